//! Crates depend on each other as the architecture page says, and on nothing else.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::Command;

type Arrows = BTreeMap<String, BTreeSet<String>>;

#[test]
fn the_table_of_crates_is_what_cargo_sees() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the tests are in the workspace");
    let drawn = arrows_of_the_page(&std::fs::read_to_string(root.join("crates/README.md")).unwrap());
    let real = arrows_of_cargo(root);
    assert_eq!(drawn, real, "crates/README.md on the left, cargo metadata on the right");
}

/// Reads the rows `| name | sentence | names |` of the page's table of crates.
fn arrows_of_the_page(page: &str) -> Arrows {
    let rows = page.lines().skip_while(|line| !line.starts_with("| crate ")).skip(2);
    let mut arrows: Arrows = rows
        .take_while(|line| line.starts_with('|'))
        .map(|row| {
            let cells: Vec<&str> = row.split('|').map(str::trim).collect();
            let names = |cell: &str| cell.split('`').skip(1).step_by(2).map(String::from).collect::<BTreeSet<_>>();
            (names(cells[1]).into_iter().next().expect("the first cell names a crate"), names(cells[3]))
        })
        .collect();
    let all: BTreeSet<String> = arrows.keys().filter(|name| *name != "brewster").cloned().collect();
    arrows.insert("brewster".into(), all);
    arrows
}

fn arrows_of_cargo(root: &Path) -> Arrows {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--no-deps", "--format-version", "1", "--offline"])
        .current_dir(root)
        .output()
        .expect("cargo runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let metadata: serde_json::Value = serde_json::from_slice(&output.stdout).expect("cargo prints JSON");
    let text = |value: &serde_json::Value| value.as_str().expect("a string").to_owned();
    let short = |name: String| name.strip_prefix("brewster-").map_or(name.clone(), String::from);
    let packages = metadata["packages"].as_array().expect("a list");
    let crates = root.join("crates");
    let of_the_data =
        packages.iter().filter(|package| Path::new(&text(&package["manifest_path"])).starts_with(&crates));
    of_the_data
        .map(|package| {
            let dependencies = package["dependencies"].as_array().expect("a list");
            let ours = dependencies
                .iter()
                .filter(|dependency| dependency["kind"].is_null() && text(&dependency["name"]).starts_with("brewster"))
                .map(|dependency| short(text(&dependency["name"])));
            (short(text(&package["name"])), ours.collect())
        })
        .collect()
}
