//! Any bytes as a mesh file: the first says whether it is OBJ or PLY.

#![no_main]

use std::cell::RefCell;

use brewster_import::{Importer, Limits, LoadOptions};
use libfuzzer_sys::fuzz_target;
use tempfile::TempDir;

thread_local! {
    static FOLDER: RefCell<TempDir> = RefCell::new(tempfile::tempdir().expect("a temporary folder"));
}

fuzz_target!(|bytes: &[u8]| {
    let Some((kind, bytes)) = bytes.split_first() else { return };
    let name = if kind % 2 == 0 { "mesh.obj" } else { "mesh.ply" };
    FOLDER.with_borrow(|folder| {
        std::fs::write(folder.path().join(name), bytes).expect("it can be written");
        let limits = Limits { vertices: 10_000, triangles: 10_000, ..Limits::DEFAULT };
        let mut importer = Importer::new(LoadOptions { limits, ..LoadOptions::default() });
        let text = format!("Scene(entities: [(shape: Mesh(file: {name:?}), material: Lambert())])");
        let _ = importer.load_text(&folder.path().join("scene.ron"), &text);
    });
});
