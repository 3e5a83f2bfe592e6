//! Every broken scene of `tests/broken` gets exactly the diagnostics beside it, and every suspicious one its warnings.
//!
//! A scene's leading comments may say how it is loaded: `// --set path=value`, or `// limit name=value`. Run with
//! `UPDATE_EXPECTED=1` to write what is found; read the difference before committing it.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use brewster_import::{Limits, LoadOptions, load_scene};

fn corpus() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/broken")
}

fn files(extension: &str) -> Vec<PathBuf> {
    let entries =
        fs::read_dir(corpus()).expect("the corpus is there").map(|entry| entry.expect("it can be read").path());
    let mut files: Vec<PathBuf> =
        entries.filter(|path| path.extension().is_some_and(|found| found == extension)).collect();
    files.sort();
    files
}

fn options(text: &str) -> LoadOptions {
    let mut options = LoadOptions::default();
    for line in text.lines().take_while(|line| line.starts_with("//")) {
        if let Some((path, value)) = line.strip_prefix("// --set ").and_then(|line| line.split_once('=')) {
            options.overrides.push((path.into(), value.into()));
        } else if let Some((name, value)) = line.strip_prefix("// limit ").and_then(|line| line.split_once('=')) {
            *limit(&mut options.limits, name) = value.parse().expect("a limit is a number");
        }
    }
    options
}

fn limit<'l>(limits: &'l mut Limits, name: &str) -> &'l mut u64 {
    match name {
        "scene_bytes" => &mut limits.scene_bytes,
        "asset_bytes" => &mut limits.asset_bytes,
        "values" => &mut limits.values,
        "nesting" => &mut limits.nesting,
        "include_depth" => &mut limits.include_depth,
        "hierarchy" => &mut limits.hierarchy,
        "entities" => &mut limits.entities,
        "picture_pixels" => &mut limits.picture_pixels,
        "image_pixels" => &mut limits.image_pixels,
        "vertices" => &mut limits.vertices,
        "triangles" => &mut limits.triangles,
        "study_combinations" => &mut limits.study_combinations,
        "diagnostics" => &mut limits.diagnostics,
        _ => panic!("there is no limit {name}"),
    }
}

/// What is printed for a scene, the corpus taken for the working directory.
fn printed(path: &Path) -> String {
    let text = String::from_utf8_lossy(&fs::read(path).expect("it can be read")).into_owned();
    let (verdict, diagnostics) = match load_scene(path, &options(&text)) {
        Ok(loaded) => ("usable", loaded.diagnostics),
        Err(failure) => ("broken", failure.diagnostics),
    };
    let mut printed = format!("{verdict}\n");
    for diagnostic in diagnostics {
        write!(printed, "\n{diagnostic}").expect("a string takes any text");
    }
    printed.replace(&format!("{}/", corpus().display()), "")
}

#[test]
fn every_scene_gets_exactly_its_diagnostics() {
    let update = std::env::var_os("UPDATE_EXPECTED").is_some();
    let mut wrong = String::new();
    for path in files("ron") {
        let found = printed(&path);
        let expected_path = path.with_extension("expected");
        if update {
            fs::write(&expected_path, &found).expect("it can be written");
        }
        let expected = fs::read_to_string(&expected_path).unwrap_or_default();
        if found != expected {
            write!(wrong, "\n{}\n--- expected\n{expected}\n--- found\n{found}", path.display())
                .expect("a string takes any text");
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}

#[test]
fn every_scene_has_an_expectation_and_the_other_way_round() {
    let stems = |extension: &str| {
        files(extension).iter().map(|path| path.file_stem().expect("it has a name").to_owned()).collect::<Vec<_>>()
    };
    assert_eq!(stems("ron"), stems("expected"));
    let broken = files("expected")
        .into_iter()
        .filter(|path| fs::read_to_string(path).expect("it can be read").starts_with("broken\n\nerror["));
    assert!(broken.count() >= 60, "the corpus is to hold 60 broken scenes or more");
}

/// One line with an error in each of 20,000 entities: looking for the places of all of them would take minutes.
#[test]
fn errors_without_number_are_counted() {
    let entities = "(shape: Spere(), material: Lambert()),".repeat(20_000);
    let failure =
        brewster_import::Importer::default().load_text("a.ron".as_ref(), &format!("Scene(entities: [{entities}])"));
    let diagnostics = failure.expect_err("there are no such shapes").diagnostics;
    assert_eq!(diagnostics[0].column, 26);
    assert_eq!(diagnostics.len(), 101);
    assert_eq!(diagnostics[100].message, "19900 more are not shown: limit `diagnostics` is 100");
}
