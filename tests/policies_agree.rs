//! Whether glass splits paths or chooses, and which integrator follows them, is a question of noise alone.

use brewster_buffers::{Integrator, SamplerKind, SceneBuffers};
use brewster_tests::agreement::{BLOCK, compare};

use crate::scene::parse;

/// Glass, one ball of it in another, and metals under a sky; `floor` stands in the middle of an entity.
fn scene(floor: &str) -> SceneBuffers {
    scene_with(floor, "")
}

fn scene_with(floor: &str, frosted: &str) -> SceneBuffers {
    parse(&format!(
        r#"Scene(
            settings: (integrator: Path, resolution: (48, 32), max_depth: 8, samples: 8, filter: Box),
            camera: Perspective(eye: (0, 1.5, 6), target: (0, 0.8, 0), vfov: 36),
            background: Gradient(horizon: (1, 0.9, 0.8), zenith: (0.2, 0.4, 0.9), ground: 0.2),
            entities: [
                (shape: Quad(size: (12, 12)), {floor}, rotate: (x: -90)),
                (shape: Sphere(radius: 0.8), material: Dielectric(ior: 1.5, absorption: (0.5, 0.1, 0.3)), at: (-1, 0.8, 0)),
                (shape: Sphere(radius: 0.4), material: Dielectric(ior: 1.33, priority: 1), at: (-1, 0.8, 0)),
                (shape: Sphere(radius: 0.8), material: Metal(of: "gold"), at: (1, 0.8, 0)),
                {frosted}
                (shape: Box(size: (0.6, 0.6, 0.6)), material: Dielectric(ior: 1.7), at: (0.2, 0.35, 1.6), rotate: (y: 30)),
            ],
        )"#
    ))
}

const DIFFUSE: &str = "material: Lambert(albedo: Checker(a: 0.2, b: 0.7, size: 0.125))";

const MIRROR: &str = "material: Metal(r0: (0.8, 0.7, 0.6))";

#[test]
fn splitting_and_choosing_agree_at_any_depth() {
    let frosted = "(shape: Sphere(radius: 0.5), material: Dielectric(ior: 1.5, alpha: 0.4), at: (2, 0.5, 1)),
        (shape: Sphere(radius: 0.4), material: Dielectric(ior: 1.7, dispersion: Abbe(number: 20)), at: (-2, 0.4, 1.2)),
        (shape: Sphere(radius: 0.3), at: (0.9, 0.3, 2), material: Principled(
            transmission: 0.7, roughness: 0.4, diffuse_transmission: 0.5, clearcoat: 0.5, volume: (color: (0.5, 0.8, 0.9)),
        )),
        (shape: Sphere(radius: 0.3), at: (-0.5, 0.3, 2.2), material: Principled(
            transmission: 0.8, roughness: 0, metallic: 0.2, base_color: (0.9, 0.7, 0.5), volume: (),
        )),
        (shape: Quad(size: (0.6, 0.6)), at: (-1.6, 0.3, 2), material: Principled(transmission: 0.9, roughness: 0.3)),";
    splits_agree(scene_with(DIFFUSE, frosted), &[1, 2, 8]);
}

/// Fog around all of it, milk in glass, fog in glass, and a solid that both scatters and disperses.
#[test]
fn splitting_and_choosing_agree_where_media_scatter() {
    let media = "(shape: Box(size: (14, 14, 14)), material: Medium(scattering: (0.05, 0.08, 0.12), anisotropy: 0.6)),
        (shape: Sphere(radius: 0.5), at: (2, 0.5, 1), material: Dielectric(ior: 1.5, scattering: (1, 2, 4), absorption: 0.1)),
        (shape: Sphere(radius: 0.4), at: (-2, 0.4, 1.2), material: Dielectric(ior: 1.4, alpha: 0.2, scattering: 3)),
        (shape: Sphere(radius: 0.3), at: (0.9, 0.3, 2), material: Dielectric(
            ior: 1.7, dispersion: Abbe(number: 20), scattering: 1, anisotropy: -0.5,
        )),
        (shape: Sphere(radius: 0.2), at: (-1, 0.8, 0), material: Medium(scattering: 4, priority: 2)),";
    splits_agree(scene_with(DIFFUSE, media), &[1, 8]);
}

/// A scene in which every path chooses looks like one in which they split, below any of these depths.
fn splits_agree(mut choosing: SceneBuffers, split_depths: &[u32]) {
    choosing.settings.sampler = SamplerKind::Independent;
    choosing.settings.split_depth = 0;
    for &split_depth in split_depths {
        let mut splitting = choosing.clone();
        splitting.settings.split_depth = split_depth;
        // Else both would take the same numbers.
        splitting.settings.samples = 4;
        let (worst, bound) = compare(&choosing, &splitting, BLOCK);
        assert!(worst < bound, "split below {split_depth}: z = {worst:.2}, at most {bound:.2}");
    }
}

#[test]
fn roulette_changes_no_mean() {
    let mut with = scene("material: Lambert(albedo: (0.1, 0.05, 0.02))");
    with.settings.sampler = SamplerKind::Independent;
    let mut without = with.clone();
    without.settings.roulette = false;
    without.settings.samples = 4;
    let (worst, bound) = compare(&with, &without, BLOCK);
    assert!(worst < bound, "z = {worst:.2}, at most {bound:.2}");
}

#[test]
fn both_samplers_agree() {
    let independent = SceneBuffers {
        settings: brewster_buffers::Settings { sampler: SamplerKind::Independent, ..scene(DIFFUSE).settings },
        ..scene(DIFFUSE)
    };
    let (worst, bound) = compare(&scene(DIFFUSE), &independent, BLOCK);
    assert!(worst < bound, "z = {worst:.2}, at most {bound:.2}");
}

/// Mirrors and glass under a sky are the same to both: no light but the sky's, nothing that scatters it.
#[test]
fn both_integrators_agree_on_mirrors_and_glass() {
    let path = scene(MIRROR);
    let mut whitted = path.clone();
    whitted.settings.integrator = Integrator::Whitted;
    let (worst, bound) = compare(&path, &whitted, BLOCK);
    assert!(worst < bound, "z = {worst:.2}, at most {bound:.2}");
}

/// Diffuse surfaces under lights without extent: `Whitted` at depth 0 and `Path` at depth 1 are direct light.
#[test]
fn both_integrators_have_the_same_direct_light() {
    let path = parse(
        r#"Scene(
            settings: (integrator: Path, resolution: (48, 32), max_depth: 1, samples: 4, filter: Box),
            camera: Perspective(eye: (0, 1.5, 6), target: (0, 0.8, 0), vfov: 36),
            entities: [
                (shape: Quad(size: (12, 12)), material: Lambert(albedo: (0.5, 0.6, 0.7)), rotate: (x: -90)),
                (shape: Sphere(radius: 0.8), material: Lambert(albedo: 0.8), at: (-1, 0.8, 0)),
                (light: Point(intensity: (20, 25, 30)), at: (1, 3, 2)),
                (light: Spot(intensity: 40, inner_angle: 10, outer_angle: 25), at: (2, 4, 0), look_at: (1, 0, 0)),
                (light: Directional(irradiance: (1, 0.9, 0.8)), at: (-1, 3, 1), look_at: (0, 0, 0)),
            ],
        )"#,
    );
    let mut whitted = path.clone();
    whitted.settings.integrator = Integrator::Whitted;
    whitted.settings.max_depth = 0;
    let (worst, bound) = compare(&path, &whitted, BLOCK);
    assert!(worst < bound, "z = {worst:.2}, at most {bound:.2}");
}
