//! Rays that leave a surface start on the right side of it, however they graze it and wherever it stands.

use brewster_geometry::*;
use glam::{Quat, Vec3};

use crate::support::*;

/// A ray from outside toward a random place in the shape's box.
fn incoming(random: &mut Random, scene: &Scene, at: &Affine) -> Ray {
    let bounds = match scene.shapes[0].kind {
        ShapeKind::Plane => Aabb::centered(Vec3::new(3.0, 0.0, 3.0)),
        _ => scene.table.bounds(scene.shapes[0]),
    };
    let inside = random.cube() * 0.5 + 0.5;
    let target = at.point(bounds.min + (bounds.max - bounds.min) * inside);
    let origin = at.point(random.direction() * (bounds.max.length() * (1.5 + 3.0 * random.unit())));
    Ray { origin, direction: (target - origin).normalize(), time: 0.0 }
}

/// One shape in one place, with what to call it.
fn scenes(shapes: impl Fn(&mut Scene) -> Vec<(String, ShapeRef)>) -> Vec<(String, Scene)> {
    let mut all = Vec::new();
    for at in places() {
        let (mut scene, _) = Scene::with_every_analytic_shape();
        for (name, shape) in shapes(&mut scene) {
            let mut scene = scene.clone();
            scene.place(shape, at);
            all.push((format!("{name} at {at}"), scene.built()));
        }
    }
    all
}

fn analytic(kinds: &'static [ShapeKind]) -> impl Fn(&mut Scene) -> Vec<(String, ShapeRef)> {
    |_| kinds.iter().map(|&kind| (format!("{kind:?}"), ShapeRef { kind, row: 0 })).collect()
}

const FLAT: [ShapeKind; 3] = [ShapeKind::Plane, ShapeKind::Quad, ShapeKind::Disk];
const CONVEX: [ShapeKind; 4] = [ShapeKind::Sphere, ShapeKind::Cuboid, ShapeKind::Cylinder, ShapeKind::Cone];

fn convex_mesh(scene: &mut Scene) -> Vec<(String, ShapeRef)> {
    vec![("coarse ball".into(), scene.mesh(ball(0, |_| 1.0))), ("fine ball".into(), scene.mesh(ball(4, |_| 1.0)))]
}

/// No acne: a ray that leaves a flat or convex shape to the outside meets it no more.
#[test]
fn rays_outward_miss() {
    let mut all = scenes(analytic(&FLAT));
    all.extend(scenes(analytic(&CONVEX)));
    let mut random = Random::new(1);
    for (name, scene) in all {
        let mut tally = Tally::new();
        for _ in 0..4000 {
            let ray = incoming(&mut random, &scene, &scene.object_to_world[0]);
            let hit = hit_of(&scene, &ray);
            if hit.is_miss() {
                continue;
            }
            let point = surface(&scene.geometry(), &ray, &hit);
            let closed = scene.table.is_closed(scene.shapes[0]);
            let side = if closed { point.geometric_normal } else { point.geometric_normal * random.signed().signum() };
            let direction = grazing(&mut random, side);
            let next = Ray { origin: offset_origin(&point, direction), direction, time: 0.0 };
            let again = hit_of(&scene, &next);
            // A direction is rounded; along a plane without end that shows, ten million errors away.
            let far = scene.shapes[0].kind == ShapeKind::Plane && again.t > 1e7 * point.error;
            tally.check(again.is_miss() || far, || format!("{ray:?} {hit:?} {point:?} {next:?} {again:?}"));
        }
        tally.close(&name, 500);
    }
}

/// No leaks: a ray that enters a convex solid meets its other side, and nothing after that.
#[test]
fn rays_inward_come_out_once() {
    let mut all = scenes(analytic(&CONVEX));
    all.extend(scenes(convex_mesh));
    let mut random = Random::new(2);
    for (name, scene) in all {
        let mut tally = Tally::new();
        for _ in 0..4000 {
            let ray = incoming(&mut random, &scene, &scene.object_to_world[0]);
            let hit = hit_of(&scene, &ray);
            if hit.is_miss() {
                continue;
            }
            let point = surface(&scene.geometry(), &ray, &hit);
            let direction = grazing(&mut random, -point.geometric_normal);
            let next = Ray { origin: offset_origin(&point, direction), direction, time: 0.0 };
            let other = hit_of(&scene, &next);
            tally.check(!other.is_miss(), || format!("leak: {ray:?} {hit:?} {point:?} {next:?}"));
            if other.is_miss() {
                continue;
            }
            let end = surface(&scene.geometry(), &next, &other);
            let out = end.geometric_normal.dot(direction);
            tally.check(out > -1e-3, || format!("entered twice: {next:?} {other:?} {end:?}"));
            if out >= 0.0 {
                let last = Ray { origin: offset_origin(&end, direction), direction, time: 0.0 };
                let again = hit_of(&scene, &last);
                tally.check(again.is_miss(), || format!("acne: {next:?} {other:?} {end:?} {last:?} {again:?}"));
            }
        }
        tally.close(&name, 500);
    }
}

/// Through any closed shape a line goes in and out in turns, and ends outside.
#[test]
fn lines_enter_and_leave_in_turns() {
    let bent = |scene: &mut Scene| {
        vec![
            ("torus".to_string(), ShapeRef { kind: ShapeKind::Torus, row: 0 }),
            ("hilly ball".to_string(), scene.mesh(ball(3, hills))),
        ]
    };
    let mut all = scenes(bent);
    all.extend(scenes(analytic(&CONVEX)));
    all.extend(scenes(convex_mesh));
    let mut random = Random::new(3);
    for (name, scene) in all {
        let mut tally = Tally::new();
        for _ in 0..4000 {
            let first = incoming(&mut random, &scene, &scene.object_to_world[0]);
            let (mut ray, mut inside) = (first, false);
            for _ in 0..64 {
                let hit = hit_of(&scene, &ray);
                if hit.is_miss() {
                    break;
                }
                let point = surface(&scene.geometry(), &ray, &hit);
                let entering = point.geometric_normal.dot(ray.direction) < 0.0;
                tally.check(entering != inside, || format!("inside {inside}: {first:?} {ray:?} {hit:?} {point:?}"));
                inside = entering;
                ray.origin = offset_origin(&point, ray.direction);
            }
            tally.check(!inside, || format!("lost inside: {first:?} {ray:?}"));
        }
        tally.close(&name, 3000);
    }
}

/// Normals, in world space: unit length, and those of a closed shape point out of it.
#[test]
fn normals_point_outward() {
    let mut all = scenes(analytic(&CONVEX));
    all.extend(scenes(analytic(&[ShapeKind::Torus])));
    all.extend(scenes(convex_mesh));
    let mut random = Random::new(4);
    for (name, scene) in all {
        let mut tally = Tally::new();
        for _ in 0..1000 {
            let ray = incoming(&mut random, &scene, &scene.object_to_world[0]);
            let hit = hit_of(&scene, &ray);
            if hit.is_miss() {
                continue;
            }
            let point = surface(&scene.geometry(), &ray, &hit);
            let unit = |n: Vec3| (n.length() - 1.0).abs() < 1e-6;
            let outward = point.geometric_normal.dot(ray.direction) <= 1e-3;
            let close = (point.position - ray.at(hit.t)).length() <= 1e-4 * (hit.t + point.position.length());
            let mesh = scene.shapes[0].kind == ShapeKind::Mesh;
            let shading = mesh || point.shading_normal == point.geometric_normal;
            let right = unit(point.geometric_normal) && unit(point.shading_normal) && outward && close && shading;
            tally.check(right, || format!("{ray:?} {hit:?} {point:?}"));
        }
        tally.close(&name, 150);
    }
}

/// The limit that `surface` states, for a ball of one meter and a mesh like it: meters off the surface by meters from the origin.
#[test]
fn rays_start_as_near_as_stated() {
    for (far, most) in [(0.0, 2e-6), (1e3, 6e-4), (1e5, 0.06)] {
        let (mut scene, _) = Scene::with_every_analytic_shape();
        let mesh = scene.mesh(ball(1, |_| 0.5));
        for shape in [ShapeRef { kind: ShapeKind::Sphere, row: 0 }, mesh] {
            let mut scene = scene.clone();
            let size = 0.5 / scene.table.bounds(shape).max.x;
            scene.place(shape, placed(Vec3::splat(size), Quat::IDENTITY, Vec3::splat(far)));
            let scene = scene.built();
            let mut random = Random::new(5);
            for _ in 0..200 {
                let ray = incoming(&mut random, &scene, &scene.object_to_world[0]);
                let hit = hit_of(&scene, &ray);
                if !hit.is_miss() {
                    let error = surface(&scene.geometry(), &ray, &hit).error;
                    assert!(0.0 < error && error < most, "{:?} at {far} m: {error} m", shape.kind);
                }
            }
        }
    }
}
