//! Light from everywhere: what reflects and transmits without loss cannot be seen in it, and what the maximum depth cuts is
//! missing to the digit.

use glam::{DVec2, DVec3};

use crate::scene::{load, parse, picture};
use crate::textbook::{ROUNDING, conductor, reflectance, schlick};

/// A square picture of parallel rays along -Z, two meters high, of what is around the origin.
fn parallel(pixels: u32, max_depth: u32, background: &str, materials: &str, entities: &str) -> String {
    format!(
        "Scene(
            settings: (resolution: ({pixels}, {pixels}), max_depth: {max_depth}, samples: 1, filter: Box),
            camera: Orthographic(eye: (0, 0, 5), target: (0, 0, 0), height: 2),
            background: {background},
            materials: {{ {materials} }},
            entities: [{entities}],
        )"
    )
}

/// In a ball every reflection inside has the reflectance F of the first hit, outside; so of the light that entered F^(m-1) is
/// left inside when the path ends, and the pixel lacks (1 - F) F^(m-1).
#[test]
fn a_ball_of_glass_lacks_what_the_depth_cuts() {
    for ior in [1.0, 1.1, 1.33, 1.5, 2.42] {
        for max_depth in [0, 1, 2, 3, 6, 12] {
            let glass = format!("\"glass\": Dielectric(ior: {ior})");
            let ball = "(shape: Sphere(radius: 0.9), material: \"glass\")";
            for (place, color) in picture(&parse(&parallel(21, max_depth, "1", &glass, ball))) {
                let sine = place.length() / 0.9;
                if (sine - 1.0).abs() < 0.02 {
                    continue;
                }
                let reflected = |sine: f64| reflectance((1.0 - sine * sine).sqrt(), 1.0, ior);
                let (expected, tolerance) = match (sine < 1.0, max_depth) {
                    (false, _) => (1.0, 0.0),
                    (true, 0) => (0.0, 0.0),
                    (true, _) => {
                        let f = reflected(sine);
                        // A leg begins off the ball by twice 4.5 roundings of its radius and four of its box's reach and one
                        // of the sum: 20 of the radius; its direction has five, over two radii. So the sine at the next
                        // hit is off by 30, and the sum of the reflectances' errors is weighted by 1 + Σ (1 - F) m F^(m-1).
                        let off = (reflected(sine + 30.0 * ROUNDING) - reflected(sine - 30.0 * ROUNDING)) / 2.0;
                        let tolerance = off * (1.0 + 1.0 / (1.0 - f)) + 40.0 * ROUNDING;
                        (1.0 - (1.0 - f) * f.powi(max_depth as i32 - 1), tolerance)
                    }
                };
                let error = (color - expected).abs().max_element();
                assert!(error <= tolerance, "ior {ior}, depth {max_depth}, {place}: {color} instead of {expected}");
            }
        }
    }
}

/// A mirror that reflects everything is not there at all, to the last bit.
#[test]
fn a_white_mirror_vanishes() {
    let mirror = "\"mirror\": Metal(r0: 1)";
    let ball = "(shape: Sphere(radius: 0.9), material: \"mirror\", scale: (1, 0.7, 2))";
    for (place, color) in picture(&parse(&parallel(32, 1, "1", mirror, ball))) {
        assert_eq!(color, DVec3::ONE, "{place}");
    }
}

/// Nothing but the cut is lost in nested, overlapping or smooth solids either: deeper pictures are brighter, up to 1. It takes
/// long: where the box sticks out of the ball it holds light for a hundred total reflections.
#[test]
fn no_solid_makes_or_swallows_light() {
    let nested = "
        (shape: Sphere(radius: 0.9), material: \"glass\"),
        (shape: Sphere(radius: 0.7), material: \"water\"),
        (shape: Sphere(radius: 0.3), material: \"bubble\", at: (0.2, 0.1, 0.3)),
        (shape: Box(size: (0.5, 0.5, 0.5)), material: \"glass\", at: (0.6, -0.6, 0.5), rotate: (x: 20, y: 30)),";
    let smooth = "
        (shape: Mesh(file: \"ball.obj\"), material: \"glass\", scale: (0.9, 0.8, 0.7)),
        (shape: Torus(major_radius: 0.6, minor_radius: 0.2), material: \"bubble\", rotate: (x: 60))";
    let materials = "
        \"glass\": Dielectric(ior: 1.5, priority: 1),
        \"water\": Dielectric(ior: 1.33, priority: 2),
        \"bubble\": Dielectric(ior: 1, priority: 3)";
    for entities in [nested, smooth] {
        let mut shallower = vec![DVec3::ZERO; 12 * 12];
        for max_depth in [0, 1, 2, 4, 7, 11] {
            let pixels = picture(&parse(&parallel(12, max_depth, "1", materials, entities)));
            for ((place, color), before) in pixels.iter().zip(&mut shallower) {
                assert!(color.cmple(DVec3::splat(1.0 + 1e-6)).all(), "depth {max_depth}, {place}: {color} is made");
                assert!(color.cmpge(*before - 1e-6).all(), "depth {max_depth}, {place}: {color} after {before}");
                *before = *color;
            }
        }
        let mut deep = parse(&parallel(12, 200, "1", materials, entities));
        deep.settings.contribution_threshold = 1e-5;
        let missing = picture(&deep).iter().map(|(_, color)| 1.0 - color.x).sum::<f64>() / 144.0;
        assert!(missing < 1e-3, "{missing} is missing in {entities}");
    }
}

/// The same for the scenes that every claim is made about, without what absorbs or shines.
#[test]
fn no_mesh_or_instance_makes_light() {
    for name in ["nested", "overlap", "prism", "shapes", "smooth"] {
        let mut scene = load(name);
        scene.background = brewster_buffers::Background::Constant(glam::Vec3::ONE);
        scene.lights.clear();
        for row in 0..scene.materials.emissive.len() {
            let black = brewster_buffers::ColorSource::constant(glam::Vec3::ZERO);
            scene.materials.emissive.set(row, brewster_buffers::Emissive { radiance: black, two_sided: true });
        }
        scene.ambient = glam::Vec3::ZERO;
        let colors = picture(&scene);
        assert!(colors.iter().all(|(_, color)| color.max_element() < 1.0 + 3e-6), "{name} makes light");
        assert!(colors.iter().any(|(_, color)| color.min_element() > 0.999), "{name} shows no background");
    }
}

/// Two mirrors at 45° look over a wall: the color of what they see, twice weakened by Schlick's reflectance.
#[test]
fn a_periscope_of_colored_mirrors() {
    let mirrors = "\"mirror\": Metal(r0: (0.2, 0.5, 0.9)), \"wall\": Lambert()";
    let entities = "
        (shape: Quad(size: (3, 3)), material: \"mirror\", rotate: (x: -45)),
        (shape: Quad(size: (3, 3)), material: \"mirror\", at: (0, 3, 0), rotate: (x: 135)),
        (shape: Box(size: (9, 1, 1)), material: \"wall\", at: (0, 0, -3))";
    let horizon = DVec3::new(0.5, 0.25, 2.0);
    let background = "Gradient(horizon: (0.5, 0.25, 2), zenith: 7, ground: 9)";
    let weakened = DVec3::new(0.2, 0.5, 0.9).to_array().map(|r0| schlick(0.5f64.sqrt(), r0).powi(2));
    let expected = horizon * DVec3::from_array(weakened);
    for (place, color) in picture(&parse(&parallel(8, 2, background, mirrors, entities))) {
        assert!((color - expected).abs().max_element() < 1e-5, "{place}: {color} instead of {expected}");
    }
}

/// Gold in the air and under water, at normal incidence and by its complex index: 1.333 times less of an index is duller.
#[test]
fn gold_is_duller_under_water() {
    let materials = "
        \"gold\": Metal(eta: (0.15, 0.4, 1.4), k: (3.6, 2.5, 1.9)),
        \"water\": Dielectric(ior: 1.333)";
    let mirror = "(shape: Quad(size: (3, 3)), material: \"gold\")";
    let pool =
        "(shape: Box(size: (30, 30, 30)), material: \"water\"), (shape: Box(size: (29, 29, 29)), material: Emissive())";
    for (surroundings, eta_i) in [("(shape: Box(size: (29, 29, 29)), material: Emissive())", 1.0), (pool, 1.333)] {
        let entities = format!("{mirror}, {surroundings}");
        let relative = |eta: f64, k: f64| conductor(1.0, DVec2::new(eta, k) / eta_i);
        let expected = DVec3::new(relative(0.15, 3.6), relative(0.4, 2.5), relative(1.4, 1.9));
        for (place, color) in picture(&parse(&parallel(4, 1, "0", materials, &entities))) {
            assert!((color - expected).abs().max_element() < 1e-5, "{place}: {color} instead of {expected}");
        }
    }
}
