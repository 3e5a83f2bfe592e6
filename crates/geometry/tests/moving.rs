//! What moves is met where it is at the ray's time: as in a still scene that is placed so, to the bit, by every kernel.

use brewster_geometry::*;
use glam::{Affine3A, Quat, Vec3};

use crate::agreement::{check, every_kind, rays_for};
use crate::support::*;

/// Keys around a place: shifted, turned by up to `angle` in `steps` steps, and stretched.
fn keys(random: &mut Random, at: Affine3A, steps: usize, (shift, angle, growth): (f32, f32, f32)) -> Vec<Affine> {
    let (by, axis, scale) = (random.cube() * shift, random.direction(), random.cube() * growth);
    let key = |step: usize| {
        let s = step as f32 / steps as f32;
        let turn = Quat::from_axis_angle(axis, angle * s);
        let moved = Affine3A::from_scale_rotation_translation(Vec3::ONE + scale * s, turn, by * s);
        Affine::from_affine3a(at * moved).unwrap()
    };
    (0..=steps).map(key).collect()
}

/// Every other instance moves.
fn in_motion(random: &mut Random, spread: f32, size: f32) -> Scene {
    let mut scene = every_kind(random, 60, spread, size);
    let motions: Vec<Option<Motion>> = (0..scene.shapes.len())
        .map(|instance| {
            let at = placed(Vec3::splat(size) * (0.3 + random.unit()), random.rotation(), random.cube() * spread);
            scene.move_to(instance as u32, at);
            let how = [(2.0, 0.0, 0.0), (0.5, 2.0, 0.0), (1.0, 0.7, 0.6), (0.0, 6.2, 0.0)][instance / 2 % 4];
            let keys = keys(random, at, [1, 16, 8, 64][instance / 2 % 4], how);
            (instance % 2 == 0).then(|| Motion::new(&keys).unwrap().unwrap())
        })
        .collect();
    scene.motions = Motions::new(motions.iter().map(Option::as_ref));
    scene.built()
}

/// The rays for a scene, at times all over the shutter's, and those of a small camera, whose neighbors kernels take together.
fn timed_rays(scene: &Scene, random: &mut Random, count: usize) -> RayColumns {
    let mut rays = rays_for(scene, random, count);
    let bounds = scene.top.bounds();
    let (middle, size) = ((bounds.min + bounds.max) * 0.5, (bounds.max - bounds.min).max_element());
    for i in 0..32 * 32 {
        let at = |pixel: usize| (pixel as f32 / 32.0 - 0.5) * 0.8;
        let direction = Vec3::new(at(i % 32), at(i / 32), -1.0).normalize();
        rays.push(Ray { origin: middle + Vec3::Z * size, direction, time: 0.0 });
    }
    for time in &mut rays.time {
        *time = [random.unit(), 0.0, 0.5, 1f32.next_down()][random.below(4)];
    }
    rays
}

/// Found through boxes that hold the whole way: what brute force finds without any box.
#[test]
fn kernels_agree_where_instances_move() {
    for (spread, size) in [(4.0, 1.0), (1e4, 500.0), (1e5, 10.0)] {
        let mut random = Random::new(21);
        let scene = in_motion(&mut random, spread, size);
        check(&format!("moving, spread {spread}"), &scene, &timed_rays(&scene, &mut random, 1000));
    }
}

/// The map at a moment by the definition: between neighboring keys every number goes straight on.
fn map_at(keys: &[Affine], time: f32) -> Affine {
    let passed = time * (keys.len() - 1) as f32;
    let step = passed as usize;
    let (from, to, s) = (keys[step].rows, keys[step + 1].rows, passed.fract());
    Affine { rows: std::array::from_fn(|r| std::array::from_fn(|c| from[r][c] + (to[r][c] - from[r][c]) * s)) }
}

#[test]
fn hits_and_surfaces_are_those_of_a_still_scene_placed_so() {
    let mut random = Random::new(22);
    let moving = in_motion(&mut random, 4.0, 1.0);
    let (mut hits, mut moved) = (0, 0);
    for _ in 0..40 {
        let time = random.unit();
        let mut still = moving.clone();
        still.motions = Motions::default();
        for instance in 0..moving.shapes.len() {
            if let Some(keys) = moving.motions.keys(instance as u32) {
                let map = map_at(keys, time);
                still.object_to_world[instance] = map;
                still.world_to_object[instance] = map.inverse().unwrap();
            }
        }
        let still = still.built();
        for ray in (0..300).map(|_| Ray { origin: random.cube() * 4.0, direction: random.direction(), time }) {
            let (hit, expected) = (hit_of(&moving, &ray), hit_of(&still, &ray));
            assert_eq!((hit, hit.t.to_bits()), (expected, expected.t.to_bits()), "{ray:?}");
            if !hit.is_miss() {
                let (point, there) = (surface(&moving.geometry(), &ray, &hit), surface(&still.geometry(), &ray, &hit));
                assert_eq!(point, there);
                assert_eq!(meets_front(&moving.geometry(), &ray, &hit), meets_front(&still.geometry(), &ray, &hit));
                let place = point.place(hit.instance, hit.primitive, time);
                let gradients = |scene: &Scene| scene.geometry().uv_gradients(&place, UvSet::First);
                assert_eq!(gradients(&moving), gradients(&still));
                assert_eq!(moving.geometry().vertex_normal(&place), still.geometry().vertex_normal(&place));
                hits += 1;
                moved += usize::from(hit.instance % 2 == 0);
            }
        }
    }
    assert!(hits > 2000 && moved > 300, "{hits} hits, {moved} of what moves");
}

/// Motions are written over others in place, and the tree follows by a refit.
#[test]
fn motions_are_edited_in_place() {
    let mut random = Random::new(23);
    let mut scene = in_motion(&mut random, 4.0, 1.0);
    let edited: Vec<u32> = (0..scene.shapes.len() as u32).filter(|i| i % 6 == 0).collect();
    for &instance in &edited {
        let at = placed(Vec3::ONE, random.rotation(), random.cube() * 6.0);
        let steps = scene.motions.keys(instance).unwrap().len() - 1;
        let motion = Motion::new(&keys(&mut random, at, steps, (1.0, 0.2, 0.0))).unwrap().unwrap();
        scene.move_to(instance, at);
        assert!(scene.motions.set(instance, Some(&motion)));
        assert_eq!(scene.motions.keys(instance).unwrap(), motion.keys());
        assert!(!scene.motions.set(instance, None) && !scene.motions.set(instance + 1, Some(&motion)));
    }
    let mut top = std::mem::take(&mut scene.top);
    top.refit(&scene.instances(), &edited).unwrap();
    scene.top = top;
    scene.geometry().validate().unwrap();
    check("edited", &scene, &timed_rays(&scene, &mut random, 500));
}

#[test]
fn motions_that_flatten_space_are_refused_and_wide_steps_divided() {
    let map = |scale: Vec3, angle: f32| {
        Affine::from_affine3a(placed(scale, Quat::from_rotation_y(angle), Vec3::new(1.0, 2.0, 3.0))).unwrap()
    };
    let still = map(Vec3::ONE, 0.3);
    assert_eq!(Motion::new(&[still; 5]), Ok(None));
    // Half a turn by one step goes through a map onto a line.
    let half_turn = Motion::new(&[map(Vec3::ONE, 0.0), map(Vec3::ONE, std::f32::consts::PI)]);
    assert_eq!(half_turn, Err(TransformError::FlatOnTheWay));
    let mirrored = Motion::new(&[still, map(Vec3::new(-1.0, 1.0, 1.0), 0.3)]);
    assert_eq!(mirrored, Err(TransformError::FlatOnTheWay));
    assert_eq!(Motion::new(&[still, map(Vec3::new(1.0, 0.0, 1.0), 0.3)]), Err(TransformError::Singular));
    // Growing to five times the size: by four in steps of less than half what is there, the first of them of half at most.
    let grown = Motion::new(&[map(Vec3::ONE, 0.0), map(Vec3::splat(5.0), 0.0)]).unwrap().unwrap();
    let sizes: Vec<f32> = grown.keys().iter().map(|key| key.rows[1][1]).collect();
    assert_eq!(sizes, [1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 4.5, 5.0]);
}
