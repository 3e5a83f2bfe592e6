//! glTF's material is at its ends what other materials are, and every part of it keeps what light it gets.

use brewster_buffers::{SamplerKind, SceneBuffers};
use brewster_tests::agreement::{BLOCK, bound, estimate};
use glam::DVec3;

use crate::scene::{load, parse, picture, render};

/// A ball of a material under a sky, over a floor, beside a lamp.
fn scene(material: &str) -> SceneBuffers {
    let mut scene = parse(&format!(
        r#"Scene(
            settings: (integrator: Path, resolution: (48, 32), max_depth: 8, samples: 8, filter: Box),
            camera: Perspective(eye: (0, 1.5, 5), target: (0, 0.8, 0), vfov: 36),
            background: Gradient(horizon: (1, 0.9, 0.8), zenith: (0.2, 0.4, 0.9), ground: 0.2),
            entities: [
                (shape: Quad(size: (12, 12)), material: Lambert(albedo: Checker(a: 0.2, b: 0.7, size: 0.125)), rotate: (x: -90)),
                (shape: Sphere(radius: 0.8), material: {material}, at: (0, 0.9, 0)),
                (shape: Quad(size: (0.5, 0.5)), material: Emissive(radiance: 20), at: (2, 2.5, 1), rotate: (y: 40, x: 70)),
            ],
        )"#
    ));
    scene.settings.sampler = SamplerKind::Independent;
    scene
}

/// Two materials make the same picture in the mean.
#[track_caller]
fn agree(principled: &str, other: &str) {
    alike(scene(principled), scene(other), &format!("{principled} and {other}"));
}

/// Two scenes make the same picture in the mean: no block differs by more than chance lets one of so many.
#[track_caller]
pub(crate) fn alike(ours: SceneBuffers, mut theirs: SceneBuffers, names: &str) {
    const SEEDS: u64 = 40;
    // Else both would take the same numbers.
    theirs.settings.samples = 6;
    let ((a, a_errors), (b, b_errors)) = (estimate(&ours, BLOCK, SEEDS, 2), estimate(&theirs, BLOCK, SEEDS, 2));
    let errors = a_errors.iter().zip(&b_errors).map(|(a, b)| a.hypot(*b));
    let z = a.iter().zip(&b).zip(errors).map(|((a, b), error)| if a == b { 0.0 } else { (a - b).abs() / error });
    let (worst, bound) = (z.fold(0.0, f64::max), bound(a.len()));
    assert!(worst < bound, "{names}: z = {worst:.2}, at most {bound:.2}");
}

/// e^-1 of the light is left after half a meter: 2 per meter.
#[test]
fn volumes_are_dielectrics_with_absorption() {
    let volume = "volume: (color: (1, 0.60653066, 0.36787944), distance: 0.5)";
    let white = "transmission: 1, base_color: 1";
    agree(
        &format!("Principled({white}, ior: 1.5, roughness: 0, {volume})"),
        "Dielectric(ior: 1.5, absorption: (0, 1, 2))",
    );
    agree(
        &format!("Principled({white}, ior: 1.33, roughness: 0.5, {volume})"),
        "Dielectric(ior: 1.33, alpha: 0.25, absorption: (0, 1, 2))",
    );
}

#[test]
fn films_and_dispersion_of_volumes_are_those_of_dielectrics() {
    let white = "transmission: 1, base_color: 1, roughness: 0";
    agree(
        &format!("Principled({white}, ior: 1.5, volume: (abbe: 25), iridescence: (ior: 1.33, thickness: 400))"),
        "Dielectric(ior: 1.5, dispersion: Abbe(number: 25), film: (ior: 1.33, thickness: 400))",
    );
}

#[test]
fn metals_and_chalk_are_what_they_are() {
    agree(
        "Principled(metallic: 1, base_color: (0.9, 0.6, 0.3), roughness: 0.5)",
        "Metal(r0: (0.9, 0.6, 0.3), alpha: 0.25)",
    );
    agree("Principled(specular: 0, base_color: (0.9, 0.6, 0.3))", "Lambert(albedo: (0.9, 0.6, 0.3))");
}

/// Light of its own is found by paths and by light sampling, which share it.
#[test]
fn what_shines_lights_others() {
    agree("Principled(base_color: 0, specular: 0, emission: (5, 3, 1))", "Emissive(radiance: (5, 3, 1))");
}

/// Diffuse light that is transmitted is as if from the other side: both halves of a sheet are Lambert's.
#[test]
fn a_leaf_passes_on_what_it_does_not_reflect() {
    let radiance = |transmitted: f32, side: f32| {
        let scene = parse(&format!(
            "Scene(
                settings: (integrator: Path, resolution: (2, 2), samples: 4096, max_depth: 4, filter: Box),
                camera: Orthographic(eye: (0, 0, 4), height: 0.01),
                entities: [
                    (shape: Quad(), material: Principled(specular: 0, base_color: 1, diffuse_transmission: {transmitted})),
                    (light: Directional(irradiance: 1), at: (0, 0, {side}), look_at: (0, 0, 0)),
                ],
            )"
        ));
        picture(&scene).into_iter().map(|(_, color)| color).sum::<DVec3>() / 4.0
    };
    for (transmitted, side, expected) in [(0.3, 1.0, 0.7), (0.3, -1.0, 0.3), (1.0, -1.0, 1.0), (0.0, -1.0, 0.0)] {
        let (found, expected) = (radiance(transmitted, side), expected / std::f64::consts::PI);
        assert!((found - expected).abs().max_element() < 1e-4, "{transmitted} {side}: {found} {expected}");
    }
}

/// A smooth coat over black that is seen from straight above shows what lies 40° from the normal where its map says 20°, by
/// Schlick's 0.04; what the surface's own map says is nothing to it.
#[test]
fn a_clearcoat_follows_its_own_map() {
    let map = "Gradient(from: (0.5, 0.67101, 0.96985), to: (0.5, 0.67101, 0.96985))";
    let coated = |more: &str| format!("Principled(base_color: 0, specular: 0, clearcoat: 1, {more})");
    for (material, expected) in [
        (coated(""), 0.0),
        (coated(&format!("clearcoat_normal: {map}")), 4.0),
        (format!("Detailed(of: {}, normal: {map})", coated("")), 0.0),
        (format!("Detailed(of: {}, normal: {map})", coated(&format!("clearcoat_normal: {map}"))), 4.0),
    ] {
        let scene = parse(&format!(
            "Scene(
                settings: (integrator: Path, resolution: (2, 2), samples: 16384, max_depth: 2, filter: Box),
                camera: Orthographic(eye: (0, 0, 4), height: 0.01),
                entities: [
                    (shape: Quad(), material: {material}),
                    (shape: Sphere(radius: 1), material: Emissive(radiance: 100), at: (0, 6.42788, 7.66044)),
                ],
            )"
        ));
        let mean = picture(&scene).into_iter().map(|(_, color)| color).sum::<DVec3>() / 4.0;
        assert!((mean - expected).abs().max_element() < 0.02, "{material}: {mean} instead of {expected}");
    }
}

/// No number is lost at the ends of all ranges, and nothing shines that gets no light.
#[test]
fn the_ends_of_all_ranges_are_numbers() {
    for ior in [1.0, 1.5] {
        for roughness in [0.0, 1.0] {
            for color in [0.0, 1.0] {
                for inside in ["", "volume: (abbe: 1)", "volume: (color: 0)"] {
                    let common = format!("ior: {ior}, roughness: {roughness}, base_color: {color}");
                    let material = format!("Principled(transmission: 1, {common}, {inside})");
                    let layers = "clearcoat: 1, sheen_color: 1, sheen_roughness: 0, anisotropy: (strength: 1), iridescence: (thickness: 0)";
                    let layered = format!(
                        "Principled(transmission: 0.5, diffuse_transmission: 0.5, {layers}, {common}, {inside})"
                    );
                    for material in [material, layered] {
                        let mut scene = scene(&material);
                        scene.settings.samples = 2;
                        let (film, _) = render(&scene);
                        let picture = film.resolve().pixels;
                        let colors = (0..picture.len()).map(|row| picture.get(row).color);
                        assert!(colors.flatten().all(|value| (0.0..1e4).contains(&value)), "{material}");
                        assert_eq!(film.rejected(), 0, "{material}");
                    }
                }
            }
        }
    }
}

#[test]
fn every_part_of_the_scene_is_met() {
    let (_, stats) = render(&load("principled"));
    let total = stats.total();
    assert!(total.reflections > 1000 && total.transmissions > 500 && total.absorbed < total.hits / 4, "{total:?}");
}
