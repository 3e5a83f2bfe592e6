//! Among many lights the tree finds those that matter: estimates by one sample are right in the mean and vary much less than
//! those by uniform choice.
//!
//! Expected sums are taken over all lights, one by one.

use brewster_buffers::*;
use brewster_geometry::{Affine, Quad, ShapeKind, ShapeRef, TopTree, TreeBuilder};
use brewster_random::Random;
use glam::{Affine3A, Quat, Vec2, Vec3};

/// Evenly in a box.
fn within(random: &mut Random, low: Vec3, high: Vec3) -> Vec3 {
    low + (high - low) * (0.5 + 0.5 * random.cube())
}

const LAMP: Light = Light {
    kind: LightKind::Point,
    position: Vec3::ZERO,
    direction: Vec3::NEG_Y,
    intensity: Vec3::ONE,
    cone_scale: 0.0,
    cone_offset: 1.0,
    range: f32::INFINITY,
    key: 0,
};

/// Lamps, and spots that point down, a little above a floor of 20 by 20 m.
fn lamps(count: u64, random: &mut Random) -> SceneBuffers {
    let mut scene = SceneBuffers::default();
    for key in 0..count {
        let position = within(random, Vec3::new(-10.0, 0.5, -10.0), Vec3::new(10.0, 2.5, 10.0));
        let intensity = Vec3::splat(0.2 + random.unit());
        // A spot goes from cosine 0.9 to 0.8.
        let (cone_scale, cone_offset) = if key.is_multiple_of(3) { (10.0, -8.0) } else { (0.0, 1.0) };
        scene.lights.push(Light { position, intensity, cone_scale, cone_offset, key, ..LAMP });
    }
    scene.emitters = Emitters::new(&scene);
    scene
}

/// The irradiance of a light on the floor.
fn irradiance(direction: Vec3, radiance: Vec3) -> f64 {
    f64::from(direction.y.max(0.0) * radiance.x)
}

/// The mean of estimates by one sample of a light at a point, and the mean of their squares.
fn moments(scene: &SceneBuffers, point: Vec3, samples: u32, random: &mut Random) -> [f64; 2] {
    let mut moments = [0.0; 2];
    for i in 0..samples {
        // Strata: the variance of one sample, known better.
        let choice = (i as f32 + random.unit()) / samples as f32;
        let sample = scene.sample_light(point, 0.0, choice.min(1.0f32.next_down()), [random.unit(), random.unit()]);
        let estimate = sample.map_or(0.0, |s| irradiance(s.direction, s.radiance) / f64::from(s.pdf));
        moments[0] += estimate / f64::from(samples);
        moments[1] += estimate * estimate / f64::from(samples);
    }
    moments
}

#[test]
fn one_sample_of_many_lamps_says_more_than_a_uniform_one() {
    let mut random = Random::new(1);
    let scene = lamps(300, &mut random);
    let (mut tree, mut uniform) = (0.0, 0.0);
    for _ in 0..100 {
        let point = within(&mut random, Vec3::new(-10.0, 0.0, -10.0), Vec3::new(10.0, 0.0, 10.0));
        let each = || (0..scene.lights.len()).map(|row| scene.lights.get(row).illuminate(point));
        let all: f64 = each().map(|seen| irradiance(seen.direction, seen.irradiance)).sum();
        let squares: f64 = each().map(|seen| irradiance(seen.direction, seen.irradiance).powi(2)).sum();
        let [mean, square] = moments(&scene, point, 4000, &mut random);
        assert!((mean / all - 1.0).abs() < 0.02, "at {point}: {mean}, not {all}");
        tree += (square - mean * mean) / (all * all);
        uniform += (squares * scene.lights.len() as f64 - all * all) / (all * all);
    }
    // Measured: a relative variance of 1.10 against 28.5.
    assert!(tree * 15.0 < uniform, "variance {tree} by the tree, {uniform} by uniform choice");
}

/// Panels of 10 by 10 cm that face any way: a third of them shines to both sides.
#[test]
fn panels_add_up_to_all_of_them() {
    let mut random = Random::new(2);
    let mut scene = SceneBuffers::default();
    scene.shapes.quads.push(Quad { half: Vec2::splat(0.05) });
    for two_sided in [false, true] {
        let row = u32::from(two_sided);
        scene.materials.rows.push(MaterialRow {
            kind: MaterialKind::Emissive,
            row,
            key: row.into(),
            detail: DetailId::NONE,
        });
        scene.materials.emissive.push(Emissive { radiance: ColorSource::constant(Vec3::splat(100.0)), two_sided });
    }
    for key in 0..150u64 {
        let turn = Quat::from_euler(glam::EulerRot::XYZ, 6.3 * random.unit(), 6.3 * random.unit(), 0.0);
        let at = within(&mut random, Vec3::new(-5.0, 0.5, -5.0), Vec3::new(5.0, 2.5, 5.0));
        let object_to_world = Affine::from_affine3a(Affine3A::from_rotation_translation(turn, at)).unwrap();
        let world_to_object = object_to_world.inverse().unwrap();
        let shape = ShapeRef { kind: ShapeKind::Quad, row: 0 };
        let material = MaterialId(u32::from(key.is_multiple_of(3)));
        scene.instances.push(Instance { object_to_world, world_to_object, shape, material, key });
    }
    scene.trees.top = TopTree::build(&scene.geometry().instances(), TreeBuilder::default()).unwrap();
    scene.emitters = Emitters::new(&scene);
    scene.validate().unwrap();
    assert_eq!(scene.emitters.len(), 150);
    for _ in 0..20 {
        let point = within(&mut random, Vec3::new(-5.0, 0.0, -5.0), Vec3::new(5.0, 0.0, 5.0));
        // Each panel as one point: it is small.
        let instances = scene.instances.view();
        let panel = |row: usize| {
            let to = instances.object_to_world[row].point(Vec3::ZERO) - point;
            let normal = instances.world_to_object[row].normal_to_source(Vec3::Z);
            let cosine = -to.normalize().dot(normal);
            let cosine = if instances.material[row].0 == 1 { cosine.abs() } else { cosine.max(0.0) };
            irradiance(to.normalize(), Vec3::splat(100.0 * 0.01 * cosine / to.length_squared()))
        };
        let all: f64 = (0..150).map(panel).sum();
        let [mean, square] = moments(&scene, point, 20_000, &mut random);
        let error = ((square - mean * mean) / 20_000.0).sqrt();
        assert!(error < 0.02 * all && (mean - all).abs() < 4.0 * error + 2e-3 * all, "at {point}: {mean}, not {all}");
    }
}
