//! Every reference scene can be read, without a warning, and has its picture beside it.

use std::path::Path;

use brewster_buffers::{Integrator, PixelFilter};
use brewster_film::read_image;
use brewster_import::{LoadOptions, load_scene};
use brewster_tests::agreement::{REFERENCES, folder};
use brewster_world::Scene;
use glam::UVec2;

fn stems(extension: &str) -> Vec<String> {
    let files = std::fs::read_dir(folder()).expect("the references are there").map(|entry| entry.unwrap().path());
    let found = files.filter(|path| path.extension().is_some_and(|found| found == extension));
    let mut stems: Vec<String> = found.map(|path| path.file_stem().unwrap().to_string_lossy().into_owned()).collect();
    stems.sort();
    stems
}

fn check(path: &Path) {
    let name = path.display();
    let loaded = load_scene(path, &LoadOptions::default()).unwrap_or_else(|failure| panic!("{failure}"));
    assert_eq!(loaded.diagnostics, [], "{name}");
    let mut scene = Scene::new();
    loaded.scene.apply(scene.world_mut());
    let report = scene.flatten();
    assert!(report.invalid.is_empty(), "{name}: {:?}", report.invalid);
    let buffers = scene.buffers();
    assert_eq!(buffers.validate(), Ok(()), "{name}");
    assert!(buffers.cameras.len() == 1 && buffers.instances.len() > 1, "{name}");

    // What the pictures were made with.
    let settings = &buffers.settings;
    assert_eq!((settings.integrator, settings.filter), (Integrator::Path, PixelFilter::Box), "{name}");
    let picture = read_image(&path.with_extension("exr")).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(settings.resolution, UVec2::new(picture.width, picture.height), "{name}");
    assert!(picture.color.iter().flatten().any(|&channel| channel > 0.1), "{name}: the picture is black");
}

#[test]
fn every_reference_scene_loads_without_a_warning_and_has_its_picture() {
    assert_eq!(stems("ron"), REFERENCES);
    REFERENCES.iter().for_each(|name| check(&folder().join(name).with_extension("ron")));
}
