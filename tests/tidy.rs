//! Every source file says what it is, and keeps to the project's bounds.

use std::path::{Path, PathBuf};

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            if !path.ends_with("target") {
                sources(&path, found);
            }
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

#[test]
fn every_file_opens_with_what_it_is_and_stays_readable() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the tests are in the workspace");
    let mut found = Vec::new();
    sources(root, &mut found);
    assert!(found.len() > 50, "only {} source files under {}", found.len(), root.display());
    let mut leads = Vec::new();
    for path in found {
        let text = std::fs::read_to_string(&path).unwrap();
        let body = text.split("#[cfg(test)]\nmod ").next().unwrap_or_default().lines().count();
        if !text.starts_with("//! ") {
            leads.push(format!("{}: no line at its head that says what it is", path.display()));
        }
        if body > 600 {
            leads.push(format!("{}: {body} lines without its tests", path.display()));
        }
        if text.contains(concat!("TO", "DO")) || text.contains(concat!("FIX", "ME")) {
            leads.push(format!("{}: something is left undone", path.display()));
        }
    }
    assert!(leads.is_empty(), "{}", leads.join("\n"));
}
