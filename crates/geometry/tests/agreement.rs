//! Trees, kernels and refits change no hit: everything agrees to the bit with trying every primitive.

use brewster_geometry::*;
use brewster_lanes::Level;
use glam::{Affine3A, Quat, Vec3};

use crate::support::*;

/// Rays from all around, from inside, along the axes, and some that are not rays.
pub(crate) fn rays_for(scene: &Scene, random: &mut Random, count: usize) -> RayColumns {
    let bounds = scene.top.bounds();
    let (center, size) = if bounds.is_empty() {
        (Vec3::ZERO, 1.0)
    } else {
        ((bounds.min + bounds.max) * 0.5, (bounds.max - bounds.min).max_element())
    };
    let mut rays: RayColumns = (0..count)
        .map(|i| {
            let target = center + random.cube() * (0.5 * size);
            let distance = [0.0, 0.6, 2.0, 30.0][i % 4];
            let origin = center + random.direction() * (distance * size);
            let aimed = if target == origin { Vec3::X } else { (target - origin).normalize() };
            let direction = match i % 7 {
                5 => Vec3::AXES[random.below(3)],
                6 => -Vec3::AXES[random.below(3)],
                _ => aimed,
            };
            Ray { origin, direction, time: 0.0 }
        })
        .collect();
    for bad in [f32::NAN, f32::INFINITY, 0.0] {
        rays.push(Ray { origin: center, direction: Vec3::splat(bad), time: 0.0 });
        rays.push(Ray { origin: Vec3::new(bad, 0.0, 0.0), direction: Vec3::Y, time: 0.0 });
    }
    rays
}

/// Every kernel on every level finds what brute force finds; any hit agrees with the nearest one.
pub(crate) fn check(name: &str, scene: &Scene, rays: &RayColumns) {
    let rays = rays.view();
    let expected: Vec<Hit> = (0..rays.len()).map(|i| scene.geometry().brute_force(&rays.get(i))).collect();
    let bits = |hit: &Hit| (hit.t.to_bits(), hit.u.to_bits(), hit.v.to_bits(), hit.instance, hit.primitive);
    let kernels = [Kernel::Packets, Kernel::Wave, Kernel::Single, Kernel::Obvhs];
    // For rays that start twice as far out as the scene reaches: the others go through our trees.
    let bounds = scene.top.bounds();
    let reach = if bounds.is_empty() { 1.0 } else { bounds.min.abs().max(bounds.max.abs()).max_element() };
    let trees = ObvhsTrees::build(&scene.geometry(), 2.0 * reach);
    let geometry = SceneGeometry { obvhs: Some(&trees), ..scene.geometry() };
    for (level, kernel) in Level::available().into_iter().flat_map(|level| kernels.map(|kernel| (level, kernel))) {
        let mut found = HitColumns::new();
        found.resize(rays.len(), Hit::miss());
        closest_hits_by(kernel, &geometry, level, rays, found.view_mut());
        for (i, expected) in expected.iter().enumerate() {
            assert_eq!(
                bits(&found.get(i)),
                bits(expected),
                "{name}, {level:?}, {kernel:?}, {:?}: {:?} {expected:?}",
                rays.get(i),
                found.get(i)
            );
        }
        // Just short of the hit, just beyond it, and without end.
        let limits: Vec<f32> = expected
            .iter()
            .enumerate()
            .map(|(i, hit)| match i % 3 {
                0 => hit.t,
                1 => hit.t.next_up(),
                _ => f32::INFINITY,
            })
            .collect();
        let mut out = vec![false; rays.len()];
        occluded_by(kernel, &geometry, level, rays, &limits, &mut out);
        let mut memory = RayMemory::default();
        let mut one = RayByRay::new(scene.geometry(), level, &mut memory);
        for (i, hit) in expected.iter().enumerate() {
            let ray = rays.get(i);
            assert_eq!(out[i], hit.t < limits[i], "{name}, {level:?}, {kernel:?}, {ray:?}");
            assert_eq!(one.occluded(&ray, limits[i]), out[i], "{name}, {level:?}, {ray:?} alone");
            assert_eq!(bits(&one.closest_hit(&ray)), bits(hit), "{name}, {level:?}, {ray:?} alone");
        }
    }
}

pub(crate) fn every_kind(random: &mut Random, count: usize, spread: f32, size: f32) -> Scene {
    let (mut scene, mut shapes) = Scene::with_every_analytic_shape();
    shapes.push(scene.mesh(ball(2, hills)));
    shapes.push(scene.mesh(soup(random, 100, 0.5)));
    for i in 0..count {
        let scale = (Vec3::splat(0.2) + random.cube().abs()) * size;
        let at = placed(scale, random.rotation(), random.cube() * spread);
        let shape = shapes[i % shapes.len()];
        if shape.kind != ShapeKind::Plane || i < 20 {
            scene.place(shape, at);
        }
    }
    scene
}

#[test]
fn nothing_is_hit_in_an_empty_scene() {
    let scene = Scene::default().built();
    check("empty", &scene, &rays_for(&scene, &mut Random::new(1), 100));
}

#[test]
fn one_of_each() {
    let (_, shapes) = Scene::with_every_analytic_shape();
    for shape in shapes {
        let (mut scene, _) = Scene::with_every_analytic_shape();
        scene.place(shape, placed(Vec3::new(1.0, 2.0, 0.5), Quat::from_rotation_x(1.0), Vec3::new(0.1, 3.0, -2.0)));
        let scene = scene.built();
        check(&format!("{shape:?}"), &scene, &rays_for(&scene, &mut Random::new(2), 2000));
    }
}

#[test]
fn many_of_every_kind() {
    for (spread, size) in [(5.0, 1.0), (1e4, 500.0), (1e-2, 1e-3), (1e5, 10.0)] {
        let mut random = Random::new(3);
        let scene = every_kind(&mut random, 120, spread, size).built();
        check(&format!("spread {spread}"), &scene, &rays_for(&scene, &mut random, 2000));
    }
}

/// Ties all the way: the lower instance and the lower triangle win.
#[test]
fn many_in_one_place() {
    let mut random = Random::new(4);
    let (mut scene, shapes) = Scene::with_every_analytic_shape();
    let mut twice = ball(1, |_| 1.0);
    twice.triangles.extend(twice.triangles.clone());
    let mesh = scene.mesh(twice);
    for _ in 0..25 {
        scene.place(shapes[4], Affine3A::IDENTITY);
        scene.place(mesh, Affine3A::IDENTITY);
    }
    let scene = scene.built();
    check("identical", &scene, &rays_for(&scene, &mut random, 1000));
}

/// Meshes without height, and boxes seen along their faces.
#[test]
fn flat_scenes() {
    let mut random = Random::new(5);
    let mut mesh = TriangleMesh::default();
    for i in 0..16 * 16u32 {
        mesh.positions.push(Vec3::new((i % 16) as f32, (i / 16) as f32, 0.0));
        if i % 16 < 15 && i / 16 < 15 {
            mesh.triangles.extend([[i, i + 1, i + 16], [i + 1, i + 17, i + 16]]);
        }
    }
    let mut scene = Scene::default();
    let mesh = scene.mesh(mesh);
    scene.place(mesh, Affine3A::IDENTITY);
    scene.place(mesh, Affine3A::from_translation(Vec3::new(3.0, 0.0, 0.0)));
    let scene = scene.built();
    let mut rays = rays_for(&scene, &mut random, 1000);
    for _ in 0..1000 {
        let at = Vec3::new(random.below(16) as f32, random.below(16) as f32, 0.0);
        rays.push(Ray { origin: at + Vec3::Z * 5.0, direction: Vec3::NEG_Z, time: 0.0 });
        rays.push(Ray { origin: at, direction: Vec3::X, time: 0.0 });
        rays.push(Ray { origin: at - Vec3::X * 7.0, direction: Vec3::X, time: 0.0 });
    }
    check("flat", &scene, &rays);
}

/// Slivers seen edge on, where a distance is hard to tell.
#[test]
fn soups_of_slivers() {
    let mut random = Random::new(6);
    for size in [0.02, 0.5, 2.0] {
        let mut scene = Scene::default();
        let mesh = soup(&mut random, 400, size);
        let corners = mesh.positions.clone();
        let shape = scene.mesh(mesh);
        scene.place(shape, placed(Vec3::new(1.0, 1.0, 3.0), random.rotation(), random.cube() * 10.0));
        let scene = scene.built();
        let mut rays = rays_for(&scene, &mut random, 500);
        for _ in 0..1500 {
            let triangle = random.below(corners.len() / 3) * 3;
            let [a, b] = [0, 1].map(|i| scene.object_to_world[0].point(corners[triangle + i]));
            let along = (b - a).normalize_or(Vec3::X);
            let direction = (along + random.cube() * 1e-5).normalize();
            rays.push(Ray { origin: a - along * random.unit(), direction, time: 0.0 });
        }
        check(&format!("slivers of {size}"), &scene, &rays);
    }
}

#[test]
fn only_degenerate_triangles() {
    let mut scene = Scene::default();
    let flat =
        TriangleMesh { positions: vec![Vec3::ZERO, Vec3::X], triangles: vec![[0, 1, 1]; 5], ..Default::default() };
    let mesh = scene.mesh(flat);
    scene.place(mesh, Affine3A::IDENTITY);
    let scene = scene.built();
    check("degenerate", &scene, &rays_for(&scene, &mut Random::new(7), 100));
}

/// A refitted tree differs from a built one, its hits do not.
#[test]
fn after_moves() {
    let mut random = Random::new(8);
    let mut scene = every_kind(&mut random, 150, 5.0, 1.0).built();
    for round in 0..6 {
        let moved: Vec<u32> = (0..20).map(|_| random.below(scene.shapes.len()) as u32).collect();
        for &instance in &moved {
            let spread = [1.0, 8.0, 100.0][round % 3];
            scene
                .move_to(instance, placed(Vec3::splat(0.3 + random.unit()), random.rotation(), random.cube() * spread));
        }
        let mut top = std::mem::take(&mut scene.top);
        top.refit(&scene.instances(), &moved).unwrap();
        scene.top = top;
        scene.geometry().validate().unwrap();
        check(&format!("moved {round} times"), &scene, &rays_for(&scene, &mut random, 500));
    }
}

/// Rows of neighbors from one eye, which some kernels take together: wide and narrow views, near and far.
#[test]
fn cameras() {
    let mut random = Random::new(9);
    let mut ball_alone = Scene::default();
    let shape = ball_alone.mesh(ball(3, hills));
    ball_alone.place(shape, placed(Vec3::new(1.0, 0.7, 1.2), Quat::from_rotation_y(0.4), Vec3::new(0.2, 0.1, 0.0)));
    // Two triangles of one leaf, one behind the other, in both orders.
    let mut layers = Scene::default();
    for (side, z) in [(-0.5, [0.0, 0.1]), (0.5, [0.1, 0.0])] {
        let positions =
            z.into_iter().flat_map(|z| [[-0.5, -0.5], [0.5, -0.5], [0.0, 0.5]].map(|[x, y]| Vec3::new(x, y, z)));
        let triangles = vec![[0, 1, 2], [3, 4, 5]];
        let shape = layers.mesh(TriangleMesh { positions: positions.collect(), triangles, ..Default::default() });
        layers.place(shape, Affine3A::from_translation(Vec3::X * side));
    }
    let every_kind = every_kind(&mut random, 60, 2.0, 1.0);
    for (name, scene) in [("ball", ball_alone), ("layers", layers), ("every kind", every_kind)] {
        let scene = scene.built();
        let mut rays = RayColumns::default();
        for (eye, width) in
            [(Vec3::new(0.3, 0.5, 4.0), 0.6), (Vec3::new(9.0, -7.0, 3.0), 0.02), (Vec3::splat(0.01), 2.0)]
        {
            let forward = -eye.normalize();
            let right = forward.cross(Vec3::Y).normalize();
            let up = right.cross(forward);
            for i in 0..48 * 48 {
                let at = |pixel: usize| (pixel as f32 / 48.0 - 0.5) * width;
                let direction = (forward + right * at(i % 48) + up * at(i / 48)).normalize();
                rays.push(Ray { origin: eye, direction, time: 0.0 });
            }
        }
        check(name, &scene, &rays);
    }
}
