//! The manual says of every type and field what the schema says, and of nothing else.

use std::path::Path;

use brewster_import::manual::{reference, study_reference};

const BEGIN: &str = "<!-- The rest is written by the schema: run the test `manual` with UPDATE_EXPECTED=1. -->\n\n";

#[test]
fn the_manual_holds_the_reference() {
    check("README.md", reference());
}

#[test]
fn the_manual_of_studies_holds_theirs() {
    check("study.md", study_reference());
}

#[track_caller]
fn check(file: &str, expected: String) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(file);
    let manual = std::fs::read_to_string(&path).expect("the manual is there");
    let (introduction, found) = manual.split_once(BEGIN).expect("the manual says where the reference begins");
    if std::env::var_os("UPDATE_EXPECTED").is_some() {
        std::fs::write(&path, format!("{introduction}{BEGIN}{expected}")).expect("it can be written");
        return;
    }
    let differing = found.lines().zip(expected.lines()).find(|(found, expected)| found != expected);
    assert_eq!(differing, None, "the first line that differs: found and expected");
    assert_eq!(found, expected);
}

/// Every example and every default in the manual can be read where it stands.
#[test]
fn the_introduction_s_scenes_load() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("README.md");
    let manual = std::fs::read_to_string(&path).expect("the manual is there");
    let mut scenes = 0;
    for block in manual.split("```ron\n").skip(1) {
        let text = block.split("```").next().unwrap_or_default();
        if text.starts_with("Scene(") || text.starts_with("//") {
            let mut importer = brewster_import::Importer::new(Default::default());
            let loaded =
                importer.load_text("manual.ron".as_ref(), text).unwrap_or_else(|failure| panic!("{text}\n{failure}"));
            assert_eq!(loaded.diagnostics, [], "{text}");
            scenes += 1;
        }
    }
    assert!(scenes > 0);
}
