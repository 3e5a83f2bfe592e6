//! Where rays look for light that mirrors and glass throw is a question of noise alone.

use brewster_buffers::SceneBuffers;
use brewster_tests::agreement::{compare, estimate};

use crate::scene::{load, parse};

const BLOCK: [usize; 2] = [16, 16];

/// A floor beside a mirror is lit by the lamp and by its mirror image, a lamp behind the wall.
#[test]
fn light_by_way_of_a_mirror_is_that_of_the_mirror_image() {
    let scene = |depth: u32, other: &str| {
        parse(&format!(
            r#"Scene(
                settings: (integrator: Path, resolution: (64, 48), max_depth: {depth}, guiding: true, samples: 32, filter: Box),
                camera: Perspective(eye: (2.5, 2, 0), target: (1.6, 0, 0), vfov: 30),
                entities: [
                    (shape: Quad(size: (20, 20)), material: Lambert(albedo: (0.8, 0.6, 0.4)), rotate: (x: -90)),
                    (shape: Sphere(radius: 0.1), material: Emissive(radiance: 100), at: (0.8, 0.9, -0.3)),
                    {other}
                ],
            )"#
        ))
    };
    let mirror = scene(2, "(shape: Quad(size: (40, 40)), material: Metal(r0: 1), rotate: (y: 90)),");
    let image = scene(1, "(shape: Sphere(radius: 0.1), material: Emissive(radiance: 100), at: (-0.8, 0.9, -0.3)),");
    let (worst, bound) = compare(&mirror, &image, BLOCK);
    assert!(worst < bound, "|z| = {worst:.2}, not below {bound:.2}");
}

/// Sheets of nothing in the light of a lamp change nothing, though photons come through them: beside them, rays are directed toward a lamp
/// that rays toward lights find, too.
#[test]
fn light_that_is_found_in_two_ways_is_shared_by_them() {
    let scene = |sheets: &str| {
        parse(&format!(
            r#"Scene(
                settings: (integrator: Path, resolution: (64, 48), max_depth: 3, guiding: true, samples: 32, filter: Box),
                camera: Perspective(eye: (0, 3, 3), target: (0, 0, 0), vfov: 40),
                entities: [
                    (shape: Quad(size: (20, 20)), material: Lambert(albedo: (0.8, 0.6, 0.4)), rotate: (x: -90)),
                    (shape: Sphere(radius: 0.4), material: Emissive(radiance: 10), at: (0, 1.6, 0)),
                    {sheets}
                ],
            )"#
        ))
    };
    let sheet = |x: f32| {
        format!(
            "(shape: Quad(size: (0.15, 2)), material: Dielectric(ior: 1, thin: true), rotate: (x: -90), at: ({x}, 0.3, 0)),"
        )
    };
    let sheets: String = [-0.8, -0.4, 0.0, 0.4, 0.8].map(sheet).concat();
    let (worst, bound) = compare(&scene(&sheets), &scene(""), BLOCK);
    assert!(worst < bound, "|z| = {worst:.2}, not below {bound:.2}");
}

/// The picture is that of paths that nothing guides, and has less noise.
#[test]
fn guided_paths_agree_with_others_and_are_less_noisy() {
    let guided = load("caustics");
    let mut others = guided.clone();
    others.settings.guiding = false;
    // Else both would take the same numbers.
    others.settings.samples = 64;
    let (worst, bound) = compare(&guided, &others, BLOCK);
    assert!(worst < bound, "|z| = {worst:.2}, not below {bound:.2}");
    others.settings.samples = guided.settings.samples;
    let variance =
        |scene: &SceneBuffers| estimate(scene, BLOCK, 40, 2).1.iter().map(|error| error * error).sum::<f64>();
    let (with, without) = (variance(&guided), variance(&others));
    assert!(with < 0.5 * without, "variance {with} of guided paths, {without} of others");
}
