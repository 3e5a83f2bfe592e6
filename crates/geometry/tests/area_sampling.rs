//! Points drawn on shapes are spread evenly over areas worked out by other means, and are found by rays.

use std::f64::consts::{PI, TAU};

use brewster_geometry::*;
use glam::{Affine3A, DVec2, DVec3, Vec2, Vec3};

use crate::support::*;

/// Areas by the formulas of a school book.
#[test]
fn areas_are_those_of_the_formulas() {
    let check = |area: f64, expected: f64| assert!((area / expected - 1.0).abs() < 1e-7, "{area}, not {expected}");
    check(Sphere { radius: 2.0 }.area(), 16.0 * PI);
    check(Quad { half: Vec2::new(1.0, 3.0) }.area(), 12.0);
    check(Disk { radius: 2.0, inner_radius: 1.0 }.area(), 3.0 * PI);
    // Sides of 2, 4 and 6: twice 8 + 24 + 12.
    check(Cuboid { half: Vec3::new(1.0, 2.0, 3.0) }.area(), 88.0);
    // Two caps of 4π, a side of 2π·2·6.
    check(Cylinder { radius: 2.0, height: 6.0 }.area(), 32.0 * PI);
    // A base of 9π, a side of π·3·5.
    check(Cone { radius: 3.0, height: 4.0 }.area(), 24.0 * PI);
    // A tube of circumference π around a circle of 4π.
    check(Torus { major_radius: 2.0, minor_radius: 0.5 }.area(), 4.0 * PI * PI);
    let (scene, shapes) = Scene::with_every_analytic_shape();
    for shape in shapes {
        assert_eq!(scene.table.area(shape).is_some(), shape.kind != ShapeKind::Plane);
    }
}

/// Pearson's test at one false alarm in ten thousand, by the approximation of Wilson and Hilferty (1931).
fn chi_squared(name: &str, counts: &[f64], shares: &[f64]) {
    let (total, whole): (f64, f64) = (counts.iter().sum(), shares.iter().sum());
    let expected = shares.iter().map(|share| share / whole * total);
    let statistic: f64 = counts.iter().zip(expected).map(|(count, mean)| (count - mean).powi(2) / mean).sum();
    let degrees = counts.len() as f64 - 1.0;
    let spread = 2.0 / (9.0 * degrees);
    let deviation = ((statistic / degrees).cbrt() - (1.0 - spread)) / spread.sqrt();
    assert!(deviation < 3.72, "{name}: chi squared {statistic} with {degrees} degrees of freedom");
}

/// Which of `cells` equal parts a number from 0 to 1 lies in.
fn part(x: f64, cells: usize) -> usize {
    assert!((-1e-6..=1.0 + 1e-6).contains(&x), "{x}");
    ((x * cells as f64).max(0.0) as usize).min(cells - 1)
}

/// Which eighth of a turn a point lies in.
fn sector(at: DVec2) -> usize {
    part(at.y.atan2(at.x) / TAU + 0.5, 8)
}

/// Counts points in cells whose areas are given. The cell of a point is told by its place and face alone.
fn check_even<T: Spread>(name: &str, shape: &T, areas: &[f64], cell: impl Fn(DVec3, u32) -> usize) {
    let sum: f64 = areas.iter().sum();
    assert!((sum / shape.area() - 1.0).abs() < 1e-6, "{name}: {sum} and {}", shape.area());
    let mut random = Random::new(name.len() as u64);
    let mut counts = vec![0.0; areas.len()];
    for _ in 0..100_000 {
        let sample = AreaSample::on(shape, shape.spread([random.unit(), random.unit()]));
        counts[cell(sample.local.point, sample.primitive)] += 1.0;
    }
    chi_squared(name, &counts, areas);
}

#[test]
fn points_are_spread_evenly_over_round_shapes() {
    let ball = Sphere { radius: 2.0 };
    check_even("sphere", &ball, &[16.0 * PI / 64.0; 64], |p, _| {
        part(0.5 + p.y / 4.0, 8) * 8 + sector(DVec2::new(p.x, p.z))
    });
    let disk = Disk { radius: 2.0, inner_radius: 1.0 };
    check_even("disk", &disk, &[3.0 * PI / 64.0; 64], |p, _| {
        part((p.truncate().length_squared() - 1.0) / 3.0, 8) * 8 + sector(p.truncate())
    });

    // The side in eight bands, then the caps in four rings of equal area each; eight sectors of each.
    let cylinder = Cylinder { radius: 2.0, height: 6.0 };
    let areas = [vec![24.0 * PI / 64.0; 64], vec![4.0 * PI / 32.0; 64]].concat();
    check_even("cylinder", &cylinder, &areas, |p, face| {
        let across = DVec2::new(p.x, p.z);
        let ring = part(across.length_squared() / 4.0, 4);
        let band = [part(p.y / 6.0 + 0.5, 8), 8 + ring, 12 + ring][face as usize];
        band * 8 + sector(across)
    });
    let cone = Cone { radius: 3.0, height: 4.0 };
    let areas = [vec![15.0 * PI / 64.0; 64], vec![9.0 * PI / 32.0; 32]].concat();
    check_even("cone", &cone, &areas, |p, face| {
        let across = DVec2::new(p.x, p.z);
        let squared = across.length_squared() / 9.0;
        [part(squared, 8), 8 + part(squared, 4)][face as usize] * 8 + sector(across)
    });

    // Around the tube by angle: the area between two angles is minor·(major·Δθ + minor·Δsinθ) for each radian about the axis.
    for (major, minor) in [(2.0f64, 0.5f64), (1.0, 0.999)] {
        let torus = Torus { major_radius: major as f32, minor_radius: minor as f32 };
        let edge = |i: usize| TAU * (i as f64 / 16.0 - 0.5);
        let areas: Vec<f64> = (0..128)
            .map(|i| (edge(i / 8), edge(i / 8 + 1)))
            .map(|(from, to)| minor * (major * (to - from) + minor * (to.sin() - from.sin())) * TAU / 8.0)
            .collect();
        check_even(&format!("torus {minor}"), &torus, &areas, |p, _| {
            let across = DVec2::new(p.x, p.z);
            part(p.y.atan2(across.length() - f64::from(torus.major_radius)) / TAU + 0.5, 16) * 8 + sector(across)
        });
    }
}

#[test]
fn points_are_spread_evenly_over_flat_shapes() {
    let quad = Quad { half: Vec2::new(1.0, 3.0) };
    check_even("quad", &quad, &[12.0 / 64.0; 64], |p, _| part(0.5 + p.x / 2.0, 8) * 8 + part(0.5 + p.y / 6.0, 8));
    let cuboid = Cuboid { half: Vec3::new(1.0, 2.0, 3.0) };
    let areas: Vec<f64> = (0..6 * 16).map(|i| [24.0, 12.0, 8.0][i / 32] / 16.0).collect();
    check_even("cuboid", &cuboid, &areas, |p, face| {
        let axis = face as usize / 2;
        let at = |axis: usize| part(0.5 + p[axis] / f64::from(2.0 * cuboid.half[axis]), 4);
        face as usize * 16 + at((axis + 1) % 3) * 4 + at((axis + 2) % 3)
    });
    // A triangle is cut into equal parts across its corner by squares of the distance, and along by the ratio.
    let mesh = TriangleMesh {
        positions: vec![Vec3::new(1.0, 2.0, 3.0), Vec3::new(5.0, 2.0, 3.0), Vec3::new(1.0, 2.0, 7.0)],
        triangles: vec![[0, 1, 2]],
        ..Default::default()
    };
    let face = mesh.face(0);
    assert_eq!(face.area, 8.0);
    let (mut random, mut counts) = (Random::new(3), vec![0.0; 64]);
    for _ in 0..100_000 {
        let p = mesh.sample_area(0, &face, [random.unit(), random.unit()]).local.point;
        let (v, w) = ((p.x - 1.0) / 4.0, (p.z - 3.0) / 4.0);
        assert!(p.y == 2.0 && v >= 0.0 && w >= 0.0 && v + w <= 1.0 + 1e-9, "{p}");
        counts[part((v + w).powi(2), 8) * 8 + part(v / (v + w), 8)] += 1.0;
    }
    chi_squared("triangle", &counts, &[1.0; 64]);
}

/// The mean stretch of area is the area in world space over that in object space: against fine meshes that are mapped corner by
/// corner.
#[test]
fn maps_stretch_areas_as_they_stretch_triangles() {
    let sphere = Sphere { radius: 1.0 };
    let mesh = ball(6, |_| 1.0);
    for at in [
        placed(Vec3::new(3.0, 0.2, -1.0), Random::new(4).rotation(), Vec3::ONE),
        Affine3A::from_mat3(glam::Mat3::from_cols(Vec3::X, Vec3::new(0.7, 1.0, 0.0), Vec3::new(0.0, -0.3, 0.8))),
        Affine3A::from_scale(Vec3::splat(7.0)),
    ] {
        let map = Affine::from_affine3a(at).unwrap();
        let back = map.inverse().unwrap();
        let area = |mesh: &TriangleMesh| (0..mesh.triangles.len()).map(|i| mesh.face(i).area).sum::<f64>();
        let mapped = TriangleMesh { positions: mesh.positions.iter().map(|&p| map.point(p)).collect(), ..mesh.clone() };
        let expected = area(&mapped) / area(&mesh);
        let steps = 256;
        let mean = (0..steps * steps)
            .map(|i| {
                let u = [i / steps, i % steps].map(|i| (i as f32 + 0.5) / steps as f32);
                let normal = AreaSample::on(&sphere, sphere.spread(u)).local.normal.as_vec3();
                area_scale(&map, back.normal_to_source(normal))
            })
            .sum::<f64>()
            / (steps * steps) as f64;
        assert!((mean / expected - 1.0).abs() < 1e-3, "{at}: {mean}, not {expected}");
        let uniform = [map.uniform_scale(), Some(7.0)];
        assert_eq!(uniform[0].is_some(), expected > 40.0, "{uniform:?}");
    }
}

/// A ray toward a drawn point finds it, with the same face, normal and texture coordinates; and one that ends just off it
/// meets nothing before, however it grazes, wherever the shape stands. On shapes that hide no part of their outside.
#[test]
fn rays_toward_drawn_points_find_them() {
    let (scene, mut shapes) = Scene::with_every_analytic_shape();
    shapes.retain(|shape| !matches!(shape.kind, ShapeKind::Plane | ShapeKind::Torus));
    let mut scene = scene;
    shapes.push(scene.mesh(ball(2, |_| 1.0)));
    let (mut random, mut fine) = (Random::new(6), 0);
    for shape in shapes {
        for at in places() {
            let mut scene = scene.clone();
            scene.place(shape, at);
            let scene = scene.built();
            let (to_world, to_object) = (scene.object_to_world[0], scene.world_to_object[0]);
            let size = scene.top.half_area().sqrt();
            let (mut blocked, mut found) = (Tally::new(), Tally::new());
            for _ in 0..1000 {
                let u = [random.unit(), random.unit()];
                let sample = scene.table.sample_area(shape, u).unwrap_or_else(|| {
                    let mesh = &scene.table.meshes[shape.row as usize];
                    let triangle = random.below(mesh.triangles.len());
                    mesh.sample_area(triangle, &mesh.face(triangle), u)
                });
                let outward = to_object.normal_to_source(sample.local.normal.as_vec3());
                let place = to_world.point(sample.local.point.as_vec3());
                let steep = random.below(2) == 0;
                let away = if steep {
                    (outward + 0.9 * random.direction()).normalize()
                } else {
                    grazing(&mut random, outward)
                };
                let viewer = place + away * size * 10f32.powf(4.0 * random.unit() - 2.0);
                let point = seen_from(viewer, &to_world, &to_object, &sample);
                let to = point.position - viewer;
                // Rounding may have put the viewer behind the surface, or onto it.
                if -to.dot(point.geometric_normal) <= 8.0 * point.error {
                    continue;
                }
                let target = offset_origin(&point, -to);
                let to_target = target - viewer;
                let ray = Ray { origin: viewer, direction: to_target.normalize(), time: 0.0 };
                let hit = hit_of(&scene, &ray);
                let free = hit.is_miss() || hit.t >= to_target.length() * (1.0 - f32::EPSILON);
                blocked.check(free, || format!("{ray:?} to {point:?}: {hit:?}"));
                if !steep || hit.is_miss() {
                    continue;
                }
                let there = surface(&scene.geometry(), &ray, &hit);
                let near = (there.position - point.position).length() <= 100.0 * (point.error + there.error);
                // Where f32's steps are no part of the shape, everything else is the same, too.
                let coarse = point.error + there.error > 1e-5 * size;
                fine += usize::from(!coarse);
                let same = hit.primitive == sample.primitive
                    && (there.geometric_normal - point.geometric_normal).length() < 1e-2
                    && ((there.uv - point.uv).length() < 1e-2 || there.uv.distance(point.uv) > 0.9);
                found.check(near && (same || coarse), || format!("{ray:?} {sample:?} to {point:?}: {hit:?} {there:?}"));
            }
            let name = format!("{:?} at {at}", shape.kind);
            // The next face may be met beside an edge.
            found.wrong.truncate(if found.wrong.len() * 50 < found.checked { 0 } else { usize::MAX });
            found.close(&name, 250);
            blocked.close(&name, 300);
        }
    }
    assert!(fine > 5000, "{fine}");
}
