//! No acne and no leaks in whole pictures: at the origin, up to a hundred kilometers from it, and under grazing light.

use std::f64::consts::FRAC_1_PI;

use brewster_wavefront::queues::RaySource;
use glam::{DVec2, DVec3};

use crate::scene::{parse, picture, render};

/// How far from the origin along every axis. The scenes' places are multiples of 1/128 m, the step of f32 at 100 km, so that
/// moving them is exact.
const OFFSETS: [f64; 3] = [0.0, 1000.0, 100_000.0];

/// A picture, two meters wide and high, of parallel rays along -Z.
fn moved(offset: f64, max_depth: u32, background: &str, entities: &str) -> Vec<(DVec2, DVec3)> {
    let eye = offset + 4.0;
    let text = format!(
        "Scene(
            settings: (resolution: (32, 32), max_depth: {max_depth}, samples: 1, filter: Box),
            camera: Orthographic(eye: ({offset}, {offset}, {eye}), target: ({offset}, {offset}, {offset}), height: 2),
            background: {background},
            entities: [(at: ({offset}, {offset}, {offset}), children: [{entities}])],
        )"
    );
    picture(&parse(&text))
}

/// A wall under light that barely grazes it is evenly lit: no point of it shadows another.
#[test]
fn a_wall_has_no_specks() {
    for offset in OFFSETS {
        for wall in ["Plane(normal: (0, 0, 1))", "Quad(size: (9, 9))", "Box(size: (9, 9, 0.5))", "Disk(radius: 9)"] {
            for elevation in [30.0, 1.0, 0.01] {
                let entities = format!(
                    "(shape: {wall}, material: Lambert(albedo: 1)),
                    (light: Directional(irradiance: 3), rotate: (y: {}))",
                    90.0 - elevation
                );
                let expected = 3.0 * FRAC_1_PI * f64::to_radians(elevation).sin();
                for (place, color) in moved(offset, 0, "0", &entities) {
                    // The light's direction is rounded, too: by 2⁻²⁴, which is much of an angle of 0.01°.
                    let error = (color.x - expected).abs() / expected;
                    assert!(error < 1e-3, "{wall} at {offset}, {elevation}°, {place}: {color} instead of {expected}");
                }
            }
        }
    }
}

/// What a mirror without end reflects meets it no more, even where it was met at a ten-thousandth of a degree.
#[test]
fn an_endless_mirror_is_met_once() {
    for height in [0.01, 1.0, 1000.0] {
        for normal in ["(0, 1, 0)", "(0.02, 1, 0)", "(0.3, 1, 0.0001)"] {
            let text = format!(
                "Scene(
                    settings: (resolution: (200, 200), max_depth: 3, samples: 1),
                    camera: Perspective(eye: (0, {height}, 0), target: (0, {height}, -100), vfov: 0.04),
                    entities: [(shape: Plane(normal: {normal}), material: Metal(r0: 1))],
                )"
            );
            let stats = render(&parse(&text)).1;
            let reflections = stats.of_source(RaySource::Reflection);
            assert!(reflections.traced() > 15_000, "{normal} from {height}: {} reflections", reflections.traced());
            assert_eq!(reflections.hits, 0, "{normal} from {height}");
        }
    }
}

/// Round things under light from the side are lit by the cosine up to the terminator, and dark behind it. Far from the origin
/// the cosine is that of a place on the grid of f32.
#[test]
fn a_ball_has_no_specks() {
    let light = DVec3::new(0.6, 0.0, 0.8);
    for (offset, tolerance) in OFFSETS.into_iter().zip([1e-5, 5e-4, 0.05]) {
        let entities = "(shape: Sphere(radius: 0.75), material: Lambert(albedo: 1)),
            (light: Directional(irradiance: 3.141592653589793), look_at: (-0.6, 0, -0.8))";
        for (place, color) in moved(offset, 0, "0", entities) {
            let inside = 1.0 - place.length_squared() / 0.5625;
            if inside > 0.01 {
                let cosine = DVec3::new(place.x / 0.75, place.y / 0.75, inside.sqrt()).dot(light);
                let error = (color.x - cosine.max(0.0)).abs();
                assert!(error < tolerance / inside.sqrt(), "at {offset}, {place}: {color} instead of {cosine}");
            }
        }
    }
}

/// Glass and mirrors in a white room lose nothing but what the maximum depth cuts, wherever they are: no ray slips out of a
/// solid or is caught in its surface. Which paths are cut may change with the place.
#[test]
fn glass_and_mirrors_do_not_leak() {
    for solid in [
        "(shape: Sphere(radius: 0.75), material: Dielectric(ior: 1.5))",
        "(shape: Box(size: (1, 1, 1)), material: Dielectric(ior: 1.5), rotate: (x: 30, y: 20))",
        "(shape: Cylinder(radius: 0.5, height: 1), material: Dielectric(ior: 1.33), rotate: (x: 70, z: 10))",
        "(shape: Sphere(radius: 0.75), material: Metal(r0: 1))",
        "(shape: Mesh(file: \"ball.obj\"), material: Dielectric(ior: 1.5), scale: 0.75)",
    ] {
        let here = moved(0.0, 8, "1", solid);
        for offset in OFFSETS {
            let there = moved(offset, 8, "1", solid);
            let sum = |pixels: &[(DVec2, DVec3)]| pixels.iter().map(|(_, color)| color.x).sum::<f64>() / 1024.0;
            assert!(there.iter().all(|(_, color)| color.x < 1.0 + 1e-6), "{solid} at {offset} makes light");
            let (mean, moved) = (sum(&here), sum(&there));
            assert!((mean - moved).abs() < 1e-3 + (1.0 - mean), "{solid}: {mean} at the origin, {moved} at {offset}");
        }
    }
}

/// The same solids on a lit floor look the same, as far as f32 tells places apart.
#[test]
fn a_scene_looks_the_same_far_away() {
    let entities = "
        (shape: Plane(point: (0, -0.75, 0)), material: Phong(diffuse: 0.6, specular: 0.2, exponent: 5)),
        (shape: Sphere(radius: 0.5), material: Dielectric(ior: 1.5), at: (-0.375, -0.25, 0.25)),
        (shape: Sphere(radius: 0.375), material: Metal(of: \"Au\", exponent: 5), at: (0.5, -0.375, 0)),
        (shape: Box(size: (0.5, 0.5, 0.5)), material: Lambert(albedo: 0.8), at: (0.25, 0.375, -0.5)),
        (light: Point(intensity: 20), at: (2, 3, 3))";
    let background = "Gradient(horizon: 1, zenith: (0.5, 0.7, 1), ground: 0.3)";
    let here = moved(0.0, 4, background, entities);
    for (offset, most) in [(1000.0, 0.004), (100_000.0, 0.05)] {
        let there = moved(offset, 4, background, entities);
        let difference = here.iter().zip(&there).map(|((_, a), (_, b))| (*a - *b).abs().element_sum() / 3.0);
        let mean = difference.sum::<f64>() / here.len() as f64;
        assert!(mean < most, "at {offset} pixels differ by {mean} on average");
    }
}
