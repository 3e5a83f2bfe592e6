//! Trees are the same for any number of threads, valid and within the memory that is stated.

use std::sync::Arc;

use brewster_geometry::*;
use glam::{Affine3A, Quat, Vec3};

use crate::support::*;

fn with_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(work)
}

const BUILDERS: [TreeBuilder; 2] = [TreeBuilder::Binned, TreeBuilder::Clustered];

/// Meshes with many equal boxes and areas are where an order could be open.
#[test]
fn threads_change_no_tree() {
    let mut random = Random::new(1);
    let mut doubled = ball(5, |_| 1.0);
    doubled.triangles.extend(doubled.triangles.clone());
    let same = TriangleMesh {
        positions: vec![Vec3::X, Vec3::Y, Vec3::Z],
        triangles: vec![[0, 1, 2]; 3000],
        ..Default::default()
    };
    for mesh in [ball(6, hills), doubled, same, soup(&mut random, 20_000, 0.1)] {
        let mesh = Arc::new(mesh);
        for builder in BUILDERS {
            let build = |threads| with_threads(threads, || MeshTree::build(mesh.clone(), builder).unwrap());
            build(1).validate().unwrap();
            assert!([2, 7].into_iter().all(|threads| build(threads) == build(1)), "{builder:?}");
        }
    }
    let (mut scene, shapes) = Scene::with_every_analytic_shape();
    for i in 0..20_000 {
        let at = Vec3::new((i % 100) as f32, 0.0, (i / 100) as f32) * 2.0;
        scene.place(shapes[i % shapes.len()], Affine3A::from_translation(at));
    }
    for builder in BUILDERS {
        let build = |threads| with_threads(threads, || TopTree::build(&scene.instances(), builder).unwrap());
        build(1).validate(&scene.instances()).unwrap();
        assert!([2, 7].into_iter().all(|threads| build(threads) == build(1)), "{builder:?}");
    }
}

/// Equal distances everywhere, or none at all, are where clustering could merge one pair a round: these would take minutes.
#[test]
fn rows_and_heaps_of_equal_things_are_built_in_time() {
    for step in [Vec3::X, Vec3::X * 1e-3, Vec3::new(1.0, 1.0, 1.0), Vec3::ZERO] {
        let (mut scene, shapes) = Scene::with_every_analytic_shape();
        for i in 0..50_000 {
            scene.place(shapes[0], Affine3A::from_translation(step * i as f32));
        }
        for builder in BUILDERS {
            TopTree::build(&scene.instances(), builder).unwrap().validate(&scene.instances()).unwrap();
        }
    }
    let positions = (0..100_002).map(|i| Vec3::new((i / 2) as f32, (i % 2) as f32, 0.0)).collect();
    let triangles = (0..100_000).map(|i| [i, i + 1, i + 2]).collect();
    let ribbon = TriangleMesh { positions, triangles, ..Default::default() };
    let ribbon = Arc::new(ribbon);
    for builder in BUILDERS {
        MeshTree::build(ribbon.clone(), builder).unwrap().validate().unwrap();
    }
}

/// The box of an instance holds every vertex, and where it turns a ball it is not much larger than the ball. (The mapped box around a ball reaches
/// up to √3 radii from its center.) The farthest that a bound from 26 directions lets a unit ball seem to reach is the largest value of
/// (x - y) + (y - z) √2 + z √3 for x ≥ y ≥ z of unit length: √(1 + (√2 - 1)² + (√3 - √2)²).
#[test]
fn boxes_of_turned_meshes_hold_them_closely() {
    let mut random = Random::new(7);
    let most = (1.0 + (2f32.sqrt() - 1.0).powi(2) + (3f32.sqrt() - 2f32.sqrt()).powi(2)).sqrt();
    // What is added for the size of the boxes in the tree.
    for (radius, most) in [((|_| 1.0) as fn(Vec3) -> f32, most + 0.05), (hills, f32::INFINITY)] {
        let mut scene = Scene::default();
        let mesh = scene.mesh(ball(5, radius));
        for _ in 0..200 {
            let turn = Quat::from_axis_angle(random.direction(), 3.0 * random.unit());
            scene.place(mesh, placed(Vec3::ONE, turn, 10.0 * random.direction()));
        }
        for (instance, map) in (0..).zip(&scene.object_to_world) {
            let aabb = scene.instances().bounds(instance).unwrap();
            for &vertex in &scene.table.meshes[0].positions {
                let at = map.point(vertex);
                let (below, above) = (at - aabb.min, aabb.max - at);
                assert!(below.min(above).min_element() > -1e-5, "{map:?}: {at} in {aabb:?}");
            }
            assert!((aabb.max - aabb.min).max_element() < 2.0 * most, "{map:?}: {aabb:?}");
        }
    }
}

/// The documented figures.
#[test]
fn memory_is_as_stated() {
    let mesh = Arc::new(ball(6, hills));
    let triangles = mesh.triangles.len();
    let ordinary = MeshTree::build(mesh, TreeBuilder::default()).unwrap().bytes() as f64 / triangles as f64;
    assert!(ordinary < 46.0, "{ordinary} bytes a triangle");
    let soup = MeshTree::build(Arc::new(soup(&mut Random::new(2), 20_000, 0.1)), TreeBuilder::default())
        .unwrap()
        .bytes() as f64
        / 20_000.0;
    assert!(soup < 200.0, "{soup} bytes a triangle that shares nothing");
    let (mut scene, shapes) = Scene::with_every_analytic_shape();
    let mut random = Random::new(3);
    for _ in 0..20_000 {
        scene.place(shapes[0], Affine3A::from_translation(random.cube() * 100.0));
    }
    let top = TopTree::build(&scene.instances(), TreeBuilder::default()).unwrap().bytes() as f64 / 20_000.0;
    assert!(top < 80.0, "{top} bytes an instance");
}

/// Shapes that are all but flat, seen at a slant, among others far out: pads grow beyond all measure, trees stay trees.
#[test]
fn extreme_instances_are_built() {
    let (mut scene, shapes) = Scene::with_every_analytic_shape();
    let mut random = Random::new(4);
    for i in 0..40 {
        let scale = Vec3::new(1e5, 1.0, [1e-2, 1e3][i % 2]);
        let at = if i % 4 == 0 { random.cube() * 1e14 } else { random.cube() };
        scene.place(shapes[[0, 4, 7][i % 3]], placed(scale, random.rotation(), at));
    }
    scene.built();
}

#[test]
fn bad_instances_are_errors() {
    let (mut scene, shapes) = Scene::with_every_analytic_shape();
    scene.place(shapes[0], Affine3A::IDENTITY);
    let scene = scene.built();
    let check = |change: fn(&mut Scene), expected: TreeError| {
        let mut scene = scene.clone();
        change(&mut scene);
        assert_eq!(TopTree::build(&scene.instances(), TreeBuilder::default()), Err(expected));
        let mut top = scene.top.clone();
        assert_eq!(top.refit(&scene.instances(), &[0]), Err(expected));
        assert!(top == scene.top, "an error leaves the tree as it was");
    };
    check(|s| s.shapes[0].row = 7, TreeError::NoSuchShape { instance: 0 });
    check(|s| s.shapes[0] = ShapeRef { kind: ShapeKind::Mesh, row: 0 }, TreeError::NoSuchShape { instance: 0 });
    check(|s| s.world_to_object.clear(), TreeError::BadLengths);
    check(|s| s.world_to_object[0].rows[1] = [0.0; 4], TreeError::OutOfRange { instance: 0 });
    check(|s| s.world_to_object[0].rows[1][3] = f32::NAN, TreeError::OutOfRange { instance: 0 });
    check(|s| s.world_to_object[0] = Affine::translation(Vec3::splat(1e20)), TreeError::OutOfRange { instance: 0 });
}
