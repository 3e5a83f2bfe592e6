//! From a scene in RON to columns, and from columns to a film: what every claim about pictures begins with.

use std::path::Path;

use brewster_buffers::SceneBuffers;
use brewster_film::{Film, Keep, PixelOrder};
use brewster_import::Importer;
use brewster_wavefront::queues::RaySource;
use brewster_wavefront::{Control, Counts, Policy, Renderer, Stats};
use brewster_world::Scene;
use glam::{DVec2, DVec3};

/// The scenes of `tests/scenes`: small, and together all that an integrator can meet.
pub(crate) const SCENES: [&str; 12] = [
    "colored_shadows",
    "facing_metals",
    "inside_glass",
    "lake",
    "lights",
    "nested",
    "overlap",
    "prism",
    "shapes",
    "slabs",
    "smooth",
    "threshold",
];

/// The columns of a scene in `tests/scenes`, by its name.
pub(crate) fn load(name: &str) -> SceneBuffers {
    load_file(&folder().join(name).with_extension("ron"))
}

/// The columns of a scene in a file.
pub(crate) fn load_file(path: &Path) -> SceneBuffers {
    read(path, &std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display())))
}

/// The columns of a scene that is written in a test; its files are in `tests/scenes`.
pub(crate) fn parse(text: &str) -> SceneBuffers {
    read(&folder().join("in a test.ron"), text)
}

fn folder() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes"))
}

fn read(path: &Path, text: &str) -> SceneBuffers {
    let loaded = Importer::default().load_text(path, text).unwrap_or_else(|failure| panic!("{failure}"));
    let mut scene = Scene::new();
    loaded.scene.apply(scene.world_mut());
    let report = scene.flatten();
    assert!(report.invalid.is_empty(), "{}: {:?}", path.display(), report.invalid);
    scene.buffers().clone()
}

/// A reference scene of the path integrator, by its name, small.
pub(crate) fn small_reference(name: &str) -> SceneBuffers {
    let mut scene = brewster_tests::agreement::load(name);
    scene.settings.resolution /= 5;
    scene.settings.samples = 4;
    scene
}

/// An empty film of a scene's resolution that keeps everything.
pub(crate) fn film(scene: &SceneBuffers) -> Film {
    let size = scene.settings.resolution;
    Film::keeping(PixelOrder::new(size.x, size.y, None).expect("a small picture"), Keep::ALL)
}

/// All samples of a scene's picture, on one thread in one pass.
pub(crate) fn render(scene: &SceneBuffers) -> (Film, Stats) {
    render_with(scene, Policy::default(), 1)
}

/// The same, scheduled otherwise.
pub(crate) fn render_with(scene: &SceneBuffers, policy: Policy, threads: usize) -> (Film, Stats) {
    let mut film = film(scene);
    let mut renderer = Renderer::new(scene, 0, threads, policy, false).expect("the scene can be rendered");
    assert!(renderer.pass(0..scene.settings.samples, &mut film, &Control::default()));
    (film, renderer.stats())
}

/// The pixels of a scene's picture from the top left on: the place of each one's middle, from the picture's middle to the right and up
/// in halves of its height, and its color.
pub(crate) fn picture(scene: &SceneBuffers) -> Vec<(DVec2, DVec3)> {
    let (film, _) = render(scene);
    assert_eq!(film.rejected(), 0, "contributions are no numbers");
    let size = scene.settings.resolution;
    let place = |x: u32, y: u32| {
        let from_corner = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
        (2.0 * from_corner - size.as_dvec2()) / DVec2::new(1.0, -1.0) / f64::from(size.y)
    };
    let places = (0..size.y).flat_map(|y| (0..size.x).map(move |x| place(x, y)));
    let pixels = film.resolve().pixels;
    places.enumerate().map(|(row, place)| (place, DVec3::from_array(pixels.get(row).color.map(f64::from)))).collect()
}

/// What was counted at each depth, by source, without the times.
pub(crate) fn counts(stats: &Stats) -> Vec<[Counts; RaySource::ALL.len()]> {
    stats.depths.iter().map(|depth| depth.counts).collect()
}
