//! The queues compute what a plain recursion of the lecture's algorithm computes, pixel by pixel.

use brewster_buffers::{SceneBuffers, Settings};
use glam::{DVec3, Vec3};

use crate::recursion::Recursion;
use crate::scene::{SCENES, load, render};

/// How far a pixel may be from the recursion's, relative to its largest channel. A path's contribution goes through some ten
/// roundings (2⁻²⁴ each) at each of at most seven interactions, and a highlight multiplies that of its cosine by an
/// exponent of at most 60: 2⁻²⁴ · (70 + 7 · 60) is 3e-5.
const TOLERANCE: f64 = 3e-5;

/// The film's step, 2⁻³², for each of at most 2⁷ rays' contributions to a pixel, halved by rounding.
const FILM_STEPS: f64 = 64.0 / 4_294_967_296.0;

/// Compares the pictures of a scene at its settings; the pixels that differ, if any.
fn compare(name: &str, scene: &SceneBuffers) -> Result<(), String> {
    let settings = &scene.settings;
    assert_eq!(settings.samples, 1, "{name}: the recursion sees the middle of a pixel");
    let recursion = Recursion::new(scene);
    let (film, _) = render(scene);
    if film.rejected() > 0 {
        return Err(format!("{name}, {settings:?}: {} contributions are no numbers", film.rejected()));
    }
    let picture = film.resolve();
    let (mut wrong, mut brightest) = (Vec::new(), 0.0f64);
    for y in 0..settings.resolution.y {
        for x in 0..settings.resolution.x {
            let expected = recursion.pixel(x, y);
            let pixel = picture.pixels.get((y * settings.resolution.x + x) as usize);
            let found = DVec3::from_array(pixel.color.map(f64::from));
            let tolerance = TOLERANCE * expected.max_element() + FILM_STEPS;
            if !(found - expected).abs().cmple(DVec3::splat(tolerance)).all() {
                wrong.push(format!("({x}, {y}): {found}, the recursion has {expected}"));
            }
            brightest = brightest.max(expected.max_element());
        }
    }
    assert!(brightest > 0.1, "{name} from {} is black: {brightest}", scene.cameras[0].position);
    let count = wrong.len();
    wrong.truncate(10);
    if count == 0 { Ok(()) } else { Err(format!("{name}, {settings:?}: {count} pixels differ\n{}", wrong.join("\n"))) }
}

#[track_caller]
fn check(scenes: impl IntoIterator<Item = (&'static str, SceneBuffers)>) {
    let wrong: Vec<String> = scenes.into_iter().filter_map(|(name, scene)| compare(name, &scene).err()).collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn on_every_scene() {
    check(SCENES.map(|name| (name, load(name))));
}

/// Up to the depth at which glass and metal have been crossed several times over.
#[test]
fn at_every_depth() {
    for name in ["facing_metals", "nested", "smooth"] {
        let scene = load(name);
        check((0..=7).map(|max_depth| (name, with(&scene, |settings| settings.max_depth = max_depth))));
    }
}

/// Shadows through glass, or stopped by it, on scenes that are written for the other.
#[test]
fn with_the_other_kind_of_shadow() {
    check(SCENES.map(|name| {
        let turned = |settings: &mut Settings| settings.transparent_shadows = !settings.transparent_shadows;
        (name, with(&load(name), turned))
    }));
}

/// The camera in media, and in one inside of another: a ray has to find them.
#[test]
fn with_the_camera_in_media() {
    let places = [
        ("lake", (0.2, -0.9, 1.2)),
        ("lake", (0.0, 0.5, 3.0)),
        ("nested", (0.0, 0.8, 0.75)),
        ("nested", (0.3, 0.6, 0.5)),
        ("nested", (0.25, 0.85, 0.2)),
        ("nested", (-0.3, 0.7, 0.3)),
        ("overlap", (-0.9, 0.0, 0.0)),
        ("smooth", (-1.5, 0.9, 0.7)),
    ];
    check(places.map(|(name, place)| {
        let mut scene = load(name);
        scene.cameras[0].position = Vec3::from(place);
        (name, scene)
    }));
}

/// The threshold cuts more and more, down to the light that camera rays see.
#[test]
fn at_every_threshold() {
    let scene = load("threshold");
    check(
        [0.0, 0.003, 0.02, 0.3, 0.9, 2.0]
            .map(|threshold| ("threshold", with(&scene, |settings| settings.contribution_threshold = threshold))),
    );
}

fn with(scene: &SceneBuffers, change: impl FnOnce(&mut Settings)) -> SceneBuffers {
    let mut scene = scene.clone();
    change(&mut scene.settings);
    scene
}
