//! Surfaces found for many rays at once are those found ray by ray, to the bit, on every instruction set.

use brewster_geometry::{AreaSample, ShapeKind, Sights, Spread, SurfacePoint, sight, surface, surfaces};
use brewster_lanes::Level;
use glam::{Quat, Vec3};

use crate::support::{Random, RayColumns, Scene, ball, hits_of, placed};

/// Every analytic shape and two meshes, with normals and without, turned and stretched about a little.
fn scene(random: &mut Random) -> Scene {
    let (mut scene, mut shapes) = Scene::with_every_analytic_shape();
    shapes.retain(|shape| shape.kind != ShapeKind::Plane);
    let mut smooth = ball(3, |_| 0.8);
    smooth.normals = smooth.positions.iter().map(|position| position.normalize() * 3.0).collect();
    smooth.uvs = smooth.positions.iter().map(|position| position.truncate()).collect();
    // Where normals cancel, the surface's own is left.
    smooth.normals[5] = -smooth.normals[4];
    shapes.extend([scene.mesh(smooth), scene.mesh(ball(2, |_| 0.7)), scene.mesh(ball(2, |_| 0.7))]);
    for (i, shape) in shapes.into_iter().enumerate() {
        let at = 2.0 * Vec3::new((i % 3) as f32, (i / 3) as f32, 0.0);
        let scale = Vec3::ONE + 0.4 * random.cube();
        let turned = if i % 2 == 0 { Quat::IDENTITY } else { random.rotation() };
        scene.place(shape, placed(scale, turned, at));
    }
    scene.built()
}

#[test]
fn surfaces_of_a_batch_are_those_of_its_rays() {
    let mut random = Random::new(11);
    let scene = scene(&mut random);
    let aim = |random: &mut Random| Vec3::new(2.0, 3.0, 0.0) + 4.0 * random.cube();
    let rays: RayColumns = (0..5003)
        .map(|_| {
            let (origin, target) = (aim(&mut random) + 6.0 * random.direction(), aim(&mut random));
            brewster_geometry::Ray { origin, direction: (target - origin).normalize(), time: 0.0 }
        })
        .collect();
    let hits = hits_of(&scene, Level::detect(), rays.view());
    let untouched = SurfacePoint { error: -1.0, ..SurfacePoint::default() };
    let expected: Vec<SurfacePoint> = (0..rays.view().len())
        .map(|row| match hits.get(row) {
            hit if hit.is_miss() => untouched,
            hit => surface(&scene.geometry(), &rays.view().get(row), &hit),
        })
        .collect();
    assert!(expected.iter().filter(|&&point| point != untouched).count() > 1000);
    for level in Level::available() {
        let mut points = vec![untouched; expected.len()];
        surfaces(level, &scene.geometry(), rays.view(), hits.view(), &mut points);
        for (row, (point, expected)) in points.iter().zip(&expected).enumerate() {
            assert_eq!(bits(point), bits(expected), "{level:?}, row {row}");
        }
    }
}

#[test]
fn points_drawn_together_look_as_each_by_itself() {
    let mut random = Random::new(12);
    let scene = scene(&mut random);
    for level in Level::available() {
        let (mut sights, mut expected, mut looked_at) = (Sights::default(), Vec::new(), 0);
        for number in 1..=1003 {
            let instance = random.below(scene.shapes.len());
            let (to_world, to_object) = (&scene.object_to_world[instance], &scene.world_to_object[instance]);
            let u = [random.unit(), random.unit()];
            let sample = scene.table.sample_area(scene.shapes[instance], u).unwrap_or_else(|| {
                let mesh = &scene.table.meshes[scene.shapes[instance].row as usize];
                let triangle = random.below(mesh.triangles.len());
                mesh.sample_area(triangle, &mesh.face(triangle), u)
            });
            let viewer = 5.0 * random.cube();
            sights.push(viewer, to_world, to_object, &sample);
            expected.push(sight(viewer, to_world, to_object, &sample));
            if sights.len() == Sights::CAPACITY || number == 1003 {
                sights.look(level, |lane, seen| {
                    let expected = &expected[lane];
                    assert_eq!(bits(&seen.surface), bits(&expected.surface), "{level:?}, {number}, {lane}");
                    assert_eq!(seen, expected, "{level:?}, {number}, {lane}");
                    looked_at += 1;
                });
                expected.clear();
            }
        }
        assert_eq!(looked_at, 1003);
    }
}

/// A viewer at the point itself has no direction to look in, and what follows from that is no number; nothing else is hurt.
#[test]
fn a_viewer_on_the_point_sees_no_direction() {
    let (mut scene, shapes) = Scene::with_every_analytic_shape();
    scene.place(shapes[2], placed(Vec3::ONE, Quat::IDENTITY, Vec3::ZERO));
    let quad = &scene.table.quads[0];
    let sample = AreaSample::on(quad, quad.spread([0.5, 0.5]));
    let seen = sight(Vec3::ZERO, &scene.object_to_world[0], &scene.world_to_object[0], &sample);
    assert!(seen.direction.is_nan() && seen.squared == 0.0 && seen.surface.position == Vec3::ZERO);
}

fn bits(point: &SurfacePoint) -> [u32; 12] {
    let SurfacePoint { position, geometric_normal, shading_normal, uv, error } = *point;
    let [[a, b, c], [d, e, f], [g, h, i]] = [position, geometric_normal, shading_normal].map(|v| v.to_array());
    [a, b, c, d, e, f, g, h, i, uv.x, uv.y, error].map(f32::to_bits)
}
