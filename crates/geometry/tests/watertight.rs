//! No ray slips through a closed mesh.

use brewster_geometry::*;
use brewster_lanes::Level;
use glam::{Affine3A, Quat, Vec3};

use crate::support::*;

/// From inside, at points on edges and at vertices: whatever the rounding, something is hit.
#[test]
fn edges_and_vertices_let_nothing_through() {
    let mut random = Random::new(1);
    for (depth, radius) in [(1, (|_| 1.0) as fn(Vec3) -> f32), (4, |_| 1.0), (5, |p| 1.0 + 0.05 * (9.0 * p.x).sin())] {
        for at in [
            Affine3A::IDENTITY,
            placed(Vec3::new(3.0, 0.2, 1.0), Quat::from_rotation_z(0.3), Vec3::new(7.0, -20.0, 400.0)),
            placed(Vec3::splat(1e3), Quat::from_rotation_x(2.0), Vec3::splat(1e5)),
        ] {
            let mut scene = Scene::default();
            let mesh = ball(depth, radius);
            let shape = scene.mesh(mesh.clone());
            scene.place(shape, at);
            let scene = scene.built();
            let map = scene.object_to_world[0];
            let rays: RayColumns = (0..150_000)
                .map(|i| {
                    let [a, b, _] = mesh.corners(random.below(mesh.triangles.len()));
                    let along = if i % 3 == 0 { 0.0 } else { random.unit() };
                    let origin = map.point(if i % 5 == 0 { Vec3::ZERO } else { random.cube() * 0.4 });
                    Ray { origin, direction: (map.point(a + (b - a) * along) - origin).normalize(), time: 0.0 }
                })
                .collect();
            for level in Level::available() {
                let hits = hits_of(&scene, level, rays.view());
                let lost = (0..hits.len()).find(|&i| hits.get(i).is_miss());
                assert_eq!(lost, None, "depth {depth}, {at:?}, {level:?}: {:?}", lost.map(|i| rays.view().get(i)));
            }
        }
    }
}

/// Along the lines of a grid, where every number is round and every edge's product is zero.
#[test]
fn round_numbers_let_nothing_through() {
    let n = 9u32;
    let mut mesh = TriangleMesh::default();
    for i in 0..n * n {
        mesh.positions.push(Vec3::new((i % n) as f32, (i / n) as f32, 0.0));
        if i % n < n - 1 && i / n < n - 1 {
            mesh.triangles.extend([[i, i + 1, i + n], [i + 1, i + n + 1, i + n]]);
        }
    }
    let mut scene = Scene::default();
    let shape = scene.mesh(mesh);
    scene.place(shape, Affine3A::IDENTITY);
    let scene = scene.built();
    for x in 0..=64 {
        for y in 0..=64 {
            for toward in [Vec3::ZERO, Vec3::new(0.25, -0.5, 0.0), Vec3::new(-4.0, 1.0, 0.0)] {
                let target = Vec3::new(x as f32 / 8.0, y as f32 / 8.0, 0.0);
                let ray = Ray { origin: target + Vec3::Z - toward, direction: toward - Vec3::Z, time: 0.0 };
                let hit = hit_of(&scene, &ray);
                assert_eq!(hit.t, 1.0, "{ray:?}");
            }
        }
    }
}
