//! Whole pictures that are known by hand: light on a floor, highlights, cones, slabs of glass, the window of a diver.

use std::f64::consts::FRAC_1_PI;

use glam::{DVec2, DVec3};

use crate::scene::{parse, picture};
use crate::textbook::{ROUNDING, reflectance};

/// A picture, four meters high, of parallel rays straight down from a height; the pixel at (x, y) sees (2x, -2y) of the floor.
fn from_above(height: f64, max_depth: u32, background: &str, entities: &str) -> Vec<(DVec2, DVec3)> {
    let text = format!(
        "Scene(
            settings: (resolution: (20, 20), max_depth: {max_depth}, samples: 1, filter: Box, transparent_shadows: true),
            camera: Orthographic(eye: (0, {height}, 0), target: (0, 0, 0), up: (0, 0, -1), height: 4),
            background: {background},
            entities: [{entities}],
        )"
    );
    picture(&parse(&text)).into_iter().map(|(place, color)| (DVec2::new(2.0, -2.0) * place, color)).collect()
}

#[track_caller]
fn check(pixels: Vec<(DVec2, DVec3)>, tolerance: f64, expected: impl Fn(DVec2) -> DVec3) {
    for (place, color) in pixels {
        let expected = expected(place);
        let error = (color - expected).abs().max_element();
        assert!(error <= tolerance * expected.max_element() + 1e-9, "{place}: {color} instead of {expected}");
    }
}

/// E = I cos θ/d² = I h/(h² + r²)^(3/2), of which albedo/π goes up; without falloff E = I cos θ.
#[test]
fn a_lamp_over_a_chalk_floor() {
    let albedo = DVec3::new(0.2, 0.5, 0.8);
    let lamp = DVec3::new(0.5, 3.0, -0.25);
    for (falloff, power) in [("InverseSquare", 1.5), ("None", 0.5)] {
        let entities = format!(
            "(shape: Plane(), material: Lambert(albedo: (0.2, 0.5, 0.8))),
            (light: Point(intensity: 12, falloff: {falloff}), at: (0.5, 3, -0.25))"
        );
        check(from_above(2.0, 0, "5", &entities), 2e-6, |place| {
            let squared = (DVec3::new(place.x, 0.0, place.y) - lamp).length_squared();
            albedo * FRAC_1_PI * 12.0 * lamp.y / squared.powf(power)
        });
    }
}

/// Seen from straight above, the mirror direction is up: a lamp at height h gives ks (h/d)^n I/d², beside diffuse and ambient
/// light. Metal gives R_0 ks (h/d)^n I/d² alone.
#[test]
fn a_highlight_under_a_lamp() {
    for (material, diffuse, specular, ambient) in [
        ("Phong(ambient: 0.5, diffuse: 0.4, specular: (0.3, 0.6, 0.9), exponent: 30)", 0.4, [0.3, 0.6, 0.9], 0.5 * 0.2),
        ("Metal(r0: (0.9, 0.5, 0.1), specular: 0.5, exponent: 30)", 0.0, [0.45, 0.25, 0.05], 0.0),
    ] {
        let entities = format!(
            "(shape: Plane(), material: {material}), (light: Point(intensity: 12), at: (0.5, 3, -0.25)),
            (light: Ambient(radiance: 0.2))"
        );
        check(from_above(2.0, 0, "5", &entities), 5e-6, |place| {
            let squared = (DVec3::new(place.x, 0.0, place.y) - DVec3::new(0.5, 3.0, -0.25)).length_squared();
            let cosine = 3.0 / squared.sqrt();
            let highlight = DVec3::from_array(specular) * cosine.powi(30);
            (diffuse * FRAC_1_PI * cosine + highlight) * 12.0 / squared + ambient
        });
    }
}

/// A cone straight down from 2 m: full to 20°, dark from 40°, between them the square of a ramp in the cosine.
#[test]
fn a_cone_of_light() {
    let entities = "(shape: Plane(), material: Lambert(albedo: 1)),
        (light: Spot(intensity: 5, inner_angle: 20, outer_angle: 40), at: (0, 2, 0), look_at: (0, 0, 0))";
    let [inner, outer] = [20.0f64, 40.0].map(|angle| angle.to_radians().cos());
    // The cosine has some five roundings, the outer one two, each times 1/(cos 20° - cos 40°) = 5.76 in the ramp; the ramp's scale
    // has the two cosines' over their difference, 18; and the sum that is the ramp has terms of 4.4, three roundings.
    let of_ramp = ROUNDING * (5.76 * (5.0 + 2.0) + 18.0 + 3.0 * 4.4);
    for (place, color) in from_above(1.0, 0, "5", entities) {
        let squared = place.length_squared() + 4.0;
        let cosine = 2.0 / squared.sqrt();
        let ramp = ((cosine - outer) / (inner - outer)).clamp(0.0, 1.0);
        let full = FRAC_1_PI * 5.0 * cosine / squared;
        let expected = full * ramp * ramp;
        let tolerance = full * (2.0 * ramp * of_ramp + of_ramp * of_ramp) + 20.0 * ROUNDING * expected;
        let error = (color - expected).abs().max_element();
        assert!(error <= tolerance + 1e-9, "{place}: {color} instead of {expected}");
    }
}

/// A slab of thickness d at normal incidence: with F = ((n-1)/(n+1))² and t = exp(-a d) it transmits (1-F)² t/(1 - F² t²) and
/// reflects F + F (1-F)² t²/(1 - F² t²). Green is below, red above.
#[test]
fn a_slab_transmits_and_reflects_its_series() {
    for (ior, absorption) in [(1.5, [0.5, 2.0, 0.0]), (2.42, [0.0, 0.1, 8.0]), (1.0, [1.0, 1.0, 1.0])] {
        let [a, b, c] = absorption;
        let entities = format!(
            "(shape: Box(size: (9, 0.7, 9)),
            material: Dielectric(ior: {ior}, absorption: ({a}, {b}, {c})))"
        );
        let f = ((ior - 1.0) / (ior + 1.0f64)).powi(2);
        let through = |a: f64| (-0.7 * a).exp();
        let seen = |color: f64, a: f64, from_below: f64, from_above: f64| {
            let t = through(a);
            let series = (1.0 - f).powi(2) / (1.0 - f * f * t * t);
            color * (from_below * series * t + from_above * (f + f * series * t * t))
        };
        let expected = DVec3::new(seen(1.0, a, 0.0, 3.0), seen(1.0, b, 2.0, 0.0), seen(1.0, c, 0.5, 0.25));
        let background = "Gradient(horizon: 9, zenith: (3, 0, 0.25), ground: (0, 2, 0.5))";
        // A leg in the glass begins off its face by twice 4.5 roundings of the face's 0.35 m, four of the box's reach of
        // 4.5 m and one of the sum: 40. What matters of the light goes to and fro once; it has some ten roundings at each
        // of four interactions.
        let shorter = 40.0 * ROUNDING;
        let tolerance = 2.0 * a.max(b).max(c) * shorter + 40.0 * ROUNDING;
        check(from_above(2.0, 14, background, &entities), tolerance, |_| expected);
    }
}

/// Light to a floor under a slab goes straight: weakened by both boundaries at the same angle, from the thin side and from the
/// dense one, and by d/cos θ of glass; beyond the critical angle nothing arrives.
#[test]
fn light_through_a_slab_to_the_floor() {
    let entities = "
        (shape: Plane(), material: Lambert(albedo: 1)),
        (shape: Box(size: (40, 0.5, 40)), material: Dielectric(ior: 1.5, absorption: (0.2, 1, 3)), at: (0, 1.25, 0)),
        (light: Point(intensity: 12), at: (0, 2, 0))";
    let pixels = from_above(0.75, 0, "0", entities);
    assert!(pixels.iter().any(|(_, color)| *color == DVec3::ZERO), "the critical angle is in the picture");
    check(pixels, 1e-4, |place| {
        let squared = place.length_squared() + 4.0;
        let cosine = 2.0 / squared.sqrt();
        let boundaries = (1.0 - reflectance(cosine, 1.0, 1.5)) * (1.0 - reflectance(cosine, 1.5, 1.0));
        let glass = DVec3::new(0.2, 1.0, 3.0).to_array().map(|a| (-a * 0.5 / cosine).exp());
        FRAC_1_PI * 12.0 * cosine / squared * boundaries * DVec3::from_array(glass)
    });
}

/// A lamp that hangs in the same absorbing water as the floor: its light is weakened by exp(-a d), whether or not shadows are
/// transparent, and what the camera sees of it is weakened again.
#[test]
fn a_lamp_under_water() {
    for shadows in [true, false] {
        let text = format!(
            "Scene(
                settings: (resolution: (9, 9), max_depth: 0, samples: 1, filter: Box, transparent_shadows: {shadows}),
                camera: Orthographic(eye: (0, -1, 0), target: (0, -2, 0), up: (0, 0, -1), height: 4),
                entities: [
                    (shape: Plane(), material: Dielectric(ior: 1.33, absorption: (0.1, 0.4, 0))),
                    (shape: Plane(point: (0, -3, 0)), material: Lambert(albedo: 1)),
                    (light: Point(intensity: 12), at: (0, -1.5, 0)),
                ],
            )"
        );
        check(picture(&parse(&text)), 3e-6, |place| {
            let distance = (4.0 * place.length_squared() + 2.25).sqrt();
            let water = DVec3::new(0.1, 0.4, 0.0).to_array().map(|a| (-a * (distance + 2.0)).exp());
            FRAC_1_PI * 12.0 * 1.5 / distance.powi(3) * DVec3::from_array(water)
        });
    }
}

/// A diver who looks up sees the whole sky in a cone of 48.75°, through 1 - F_r, and around it the dark ground mirrored.
#[test]
fn the_window_of_a_diver() {
    let text = "Scene(
        settings: (resolution: (40, 40), max_depth: 1, samples: 1, filter: Box),
        camera: Perspective(eye: (0, -1, 0), target: (0, 0, 0), up: (0, 0, -1), vfov: 120),
        background: Gradient(horizon: 1, zenith: 1, ground: 0),
        entities: [(shape: Plane(), material: Dielectric(ior: 1.33))],
    )";
    for (place, color) in picture(&parse(text)) {
        let tangent = 60f64.to_radians().tan() * place.length();
        let cosine = 1.0 / (1.0 + tangent * tangent).sqrt();
        let (transmitted, reflected) = (1.0 - reflectance(cosine, 1.33, 1.0), reflectance(cosine, 1.33, 1.0));
        // The mirrored ground is seen between the horizon's 1 and straight down's 0.
        let expected = transmitted + reflected * (1.0 - cosine);
        assert!((color - expected).abs().max_element() < 3e-4, "{place}: {color} instead of {expected}");
    }
}

/// A picture on a quad stands upright, and its bytes are decoded by the sRGB curve: `colors.png` has
/// (67 x + 13 y, 91 y + 40, 31 x + 57 y + 120) modulo 256 in column x and row y.
#[test]
fn a_picture_is_seen_as_it_was_painted() {
    let text = "Scene(
        settings: (resolution: (4, 3), max_depth: 0, samples: 1, filter: Box),
        camera: Orthographic(eye: (0, 0, 5), target: (0, 0, 0), height: 3),
        entities: [(shape: Quad(size: (4, 3)), material: Emissive(radiance: Image(file: \"colors.png\")))],
    )";
    for (pixel, (place, color)) in picture(&parse(text)).into_iter().enumerate() {
        let (x, y) = (pixel as u32 % 4, pixel as u32 / 4);
        let bytes = [67 * x + 13 * y, 91 * y + 40, (31 * x + 57 * y + 120) % 256];
        let linear = |byte: u32| match f64::from(byte) / 255.0 {
            dark if dark <= 0.04045 => dark / 12.92,
            bright => ((bright + 0.055) / 1.055).powf(2.4),
        };
        let expected = DVec3::from_array(bytes.map(linear));
        assert!((color - expected).abs().max_element() < 2e-6, "{place}: {color} instead of {expected}");
    }
}
