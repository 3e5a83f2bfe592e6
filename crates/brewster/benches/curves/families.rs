//! Families of scenes: one kind of scene each, in many sizes.

use std::f32::consts::{PI, TAU};
use std::sync::Arc;

use brewster::buffers::{Integrator, PixelFilter};
use brewster::geometry::TriangleMesh;
use brewster::world::Scene;
use brewster::world::components::{
    Background, Camera, Color, Material, Principled, Projection, Scalar, Settings, Shape, Transform, UsesMaterial,
    UsesShape,
};
use glam::{Affine3A, Mat3, UVec2, Vec2, Vec3};

/// Scenes of one kind.
pub(crate) struct Family {
    pub(crate) name: &'static str,
    /// What they are, in a sentence.
    pub(crate) text: &'static str,
    /// What a size counts.
    pub(crate) unit: &'static str,
    pub(crate) sizes: &'static [u64],
    pub(crate) scene: fn(u64) -> Scene,
    /// The picture's mean in closed form; where there is none, that of the largest size.
    pub(crate) mean: fn(u64) -> Option<f64>,
    /// The least size whose picture can be compared.
    pub(crate) comparable_from: u64,
    /// How far a mean may be off, as a part of it.
    pub(crate) tolerance: f64,
}

/// All families.
pub(crate) const FAMILIES: &[Family] = &[
    Family {
        name: "triangles",
        text: "one mesh of smooth hills in even light, which fills the picture; three bounces",
        unit: "triangles",
        sizes: &[1_058, 10_082, 100_352, 1_002_528, 10_008_450],
        scene: |size| hills(size, UVec2::splat(384), 1),
        mean: |_| None,
        comparable_from: 10_000,
        tolerance: 0.01,
    },
    Family {
        name: "instances",
        text: "balls of 960 triangles, side by side on a square, all of one mesh, seen from above in even light; of few balls many are at the rim, \
               where more light comes",
        unit: "instances",
        sizes: &[1, 16, 100, 1_024, 10_000, 99_856, 1_000_000],
        scene: instances,
        mean: |_| None,
        comparable_from: 1_000,
        tolerance: 0.02,
    },
    Family {
        name: "lights",
        text: "shining balls in a plane above a floor, all together always as large and bright; light from them alone",
        unit: "lights",
        sizes: &[1, 16, 100, 1_024, 10_000, 99_856],
        scene: lights,
        mean: |_| None,
        comparable_from: 100,
        tolerance: 0.03,
    },
    Family {
        name: "depth",
        text: "inside a ball that shines and reflects 0.9, without roulette; the mean is a sum of powers of that",
        unit: "depth",
        sizes: &[1, 2, 4, 8, 16, 32, 64],
        scene: depth,
        mean: |size| Some((0..=size as i32).map(|bounce| f64::from(REFLECTED).powi(bounce)).sum()),
        comparable_from: 1,
        tolerance: 0.01,
    },
    Family {
        name: "resolution",
        text: "the hills of 100,352 triangles, one sample a pixel",
        unit: "pixels a side",
        sizes: &[64, 128, 256, 512, 1_024, 2_048, 4_096],
        scene: |size| hills(100_352, UVec2::splat(size as u32), 1),
        mean: |_| None,
        comparable_from: 64,
        tolerance: 0.02,
    },
    Family {
        name: "samples",
        text: "the same hills, 96 x 96 pixels",
        unit: "samples",
        sizes: &[1, 4, 16, 64, 256, 1_024],
        scene: |size| hills(100_352, UVec2::splat(96), size as u32),
        mean: |_| None,
        comparable_from: 1,
        tolerance: 0.02,
    },
];

/// The part of light that the inside of the ball reflects.
const REFLECTED: f32 = 0.9;

/// A scene for paths with a camera at `eye` that looks along -Z of its transform.
fn scene(eye: Affine3A, projection: Projection, resolution: UVec2, samples: u32, max_depth: u32) -> Scene {
    let mut scene = Scene::new();
    let mut settings = Settings::default();
    settings.0.integrator = Integrator::Path;
    settings.0.filter = PixelFilter::Box;
    (settings.0.resolution, settings.0.samples, settings.0.max_depth) = (resolution, samples, max_depth);
    scene.world_mut().insert_resource(settings);
    scene.spawn((Camera { projection, lens: None }, Transform(eye)));
    scene
}

fn even_light(scene: &mut Scene) {
    let background = brewster::buffers::Background::Constant(Vec3::ONE);
    scene.world_mut().insert_resource(Background(background));
}

fn gray(albedo: f32) -> Material {
    Material::Lambert { albedo: Color::gray(albedo) }
}

/// At a place, looking toward the origin.
fn looking(from: Vec3, up: Vec3) -> Affine3A {
    let back = from.normalize();
    let right = up.cross(back).normalize();
    Affine3A::from_mat3_translation(Mat3::from_cols(right, back.cross(right), back), from)
}

fn hills(triangles: u64, resolution: UVec2, samples: u32) -> Scene {
    let projection = Projection::Perspective { vfov: 0.9 };
    let eye = looking(Vec3::new(0.0, 1.6, 1.2), Vec3::Y);
    let mut scene = scene(eye, projection, resolution, samples, 3);
    even_light(&mut scene);
    scene.spawn((Shape::Mesh(Arc::new(hilly(triangles))), gray(0.6)));
    scene
}

/// A square four meters wide of cells of two triangles, over smooth hills.
pub(crate) fn hilly(triangles: u64) -> TriangleMesh {
    let cells = ((triangles / 2) as f64).sqrt().round() as u32;
    let place = |n: u32| 4.0 * n as f32 / cells as f32 - 2.0;
    let height = |x: f32, z: f32| 0.12 * (PI * x).sin() * (PI * z).cos() + 0.05 * (1.7 * PI * (x + z)).sin();
    let positions = (0..=cells).flat_map(|row| (0..=cells).map(move |column| (place(column), place(row))));
    let positions = positions.map(|(x, z)| Vec3::new(x, height(x, z), z)).collect();
    let corner = |column: u32, row: u32| row * (cells + 1) + column;
    let squares = (0..cells).flat_map(|row| (0..cells).map(move |column| (column, row)));
    let triangles = squares
        .flat_map(|(x, y)| {
            let [a, b, c, d] = [corner(x, y), corner(x, y + 1), corner(x + 1, y + 1), corner(x + 1, y)];
            [[a, b, c], [a, c, d]]
        })
        .collect();
    TriangleMesh { positions, triangles, ..TriangleMesh::default() }
}

/// Places on a square one meter wide, in rows, and the distance between two.
fn grid(count: u64) -> (impl Iterator<Item = Vec2>, f32) {
    let side = (count as f64).sqrt().round() as u64;
    let step = 1.0 / side as f32;
    let place = move |n: u64| (n as f32 + 0.5) * step - 0.5;
    ((0..side * side).map(move |n| Vec2::new(place(n % side), place(n / side))), step)
}

fn instances(count: u64) -> Scene {
    let mut scene = scene(
        looking(Vec3::new(0.0, 2.0, 0.0), Vec3::NEG_Z),
        Projection::Orthographic { height: 1.0 },
        UVec2::splat(384),
        1,
        3,
    );
    even_light(&mut scene);
    let mesh = scene.spawn(Shape::Mesh(Arc::new(ball(16, 32)))).id();
    let material = scene.spawn(gray(0.6)).id();
    let (places, step) = grid(count);
    for place in places {
        let transform = Affine3A::from_translation(Vec3::new(place.x, 0.0, place.y))
            * Affine3A::from_scale(Vec3::splat(0.45 * step));
        scene.spawn((Transform(transform), UsesShape(mesh), UsesMaterial(material)));
    }
    scene
}

/// A ball of radius 1, of rings of quadrangles with triangles at the poles: `2 columns (rings - 1)` triangles.
fn ball(rings: u32, columns: u32) -> TriangleMesh {
    let mut positions = vec![Vec3::Y];
    for ring in 1..rings {
        let (sin, cos) = (PI * ring as f32 / rings as f32).sin_cos();
        positions.extend((0..columns).map(|column| {
            let (z, x) = (TAU * column as f32 / columns as f32).sin_cos();
            Vec3::new(sin * x, cos, sin * z)
        }));
    }
    positions.push(Vec3::NEG_Y);
    let (last, at) = (positions.len() as u32 - 1, |ring: u32, column: u32| 1 + ring * columns + column % columns);
    let mut triangles = Vec::new();
    for column in 0..columns {
        triangles.push([0, at(0, column + 1), at(0, column)]);
        for ring in 0..rings - 2 {
            let [a, b] = [at(ring, column), at(ring, column + 1)];
            let [c, d] = [at(ring + 1, column), at(ring + 1, column + 1)];
            triangles.extend([[a, b, d], [a, d, c]]);
        }
        triangles.push([last, at(rings - 2, column), at(rings - 2, column + 1)]);
    }
    TriangleMesh { positions, triangles, ..TriangleMesh::default() }
}

/// The floor is seen from between it and the lights, which are one hundredth of the square in all.
fn lights(count: u64) -> Scene {
    let down = looking(Vec3::new(0.0, 0.1, 0.0), Vec3::NEG_Z);
    let mut scene = scene(down, Projection::Perspective { vfov: 1.6 }, UVec2::splat(256), 1, 1);
    scene.spawn((Shape::Quad { size: Vec2::splat(4.0) }, gray(0.6), Transform(Affine3A::from_rotation_x(-0.5 * PI))));
    let shining = Material::Emissive { radiance: Color::gray(10.0), two_sided: false };
    let material = scene.spawn(shining).id();
    let (places, step) = grid(count);
    let shape = scene.spawn(Shape::Sphere { radius: 0.1 * step / PI.sqrt() }).id();
    for place in places {
        let transform = Affine3A::from_translation(Vec3::new(place.x, 0.3, place.y));
        scene.spawn((Transform(transform), UsesShape(shape), UsesMaterial(material)));
    }
    scene
}

fn depth(max_depth: u64) -> Scene {
    let projection = Projection::Perspective { vfov: 1.0 };
    let mut scene = scene(Affine3A::IDENTITY, projection, UVec2::splat(96), 1, max_depth as u32);
    scene.world_mut().resource_mut::<Settings>().0.roulette = false;
    let material = Material::Principled(Box::new(Principled {
        base_color: Color::gray(REFLECTED),
        metallic: Scalar::constant(0.0),
        specular: Scalar::constant(0.0),
        emission: Color::gray(1.0),
        ..Principled::default()
    }));
    scene.spawn((Shape::Sphere { radius: 1.0 }, material));
    scene
}
