//! Light that is drawn and light that is met by chance tell the same story, for every shape wherever it stands.
//!
//! What is expected comes from rays in all directions, evenly: whatever they meet by tracing is what a source sends to a point.

use std::sync::Arc;

use brewster_buffers::*;
use brewster_geometry::*;
use brewster_lanes::Level;
use brewster_optics::basis::Basis;
use brewster_optics::warp;
use brewster_random::Random;
use glam::{Affine3A, Quat, Vec2, Vec3};

fn tetrahedron() -> TriangleMesh {
    TriangleMesh {
        positions: [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]]
            .map(|corner| Vec3::from_array(corner) * 0.6)
            .to_vec(),
        uvs: vec![Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::ONE],
        triangles: vec![[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2], [0, 1, 1]],
        ..Default::default()
    }
}

/// A shape of each kind that can shine, of sizes around one; the last is a mesh.
fn table() -> (ShapeTable, Vec<ShapeRef>) {
    let table = ShapeTable {
        spheres: vec![Sphere { radius: 0.7 }],
        planes: vec![],
        quads: vec![Quad { half: Vec2::new(1.0, 0.6) }],
        disks: vec![Disk { radius: 0.8, inner_radius: 0.3 }],
        cuboids: vec![Cuboid { half: Vec3::new(0.5, 0.8, 0.3) }],
        cylinders: vec![Cylinder { radius: 0.4, height: 1.3 }],
        cones: vec![Cone { radius: 0.6, height: 1.1 }],
        tori: vec![Torus { major_radius: 0.7, minor_radius: 0.25 }],
        meshes: vec![Arc::new(tetrahedron())],
    };
    let kinds = ShapeKind::ALL.into_iter().filter(|&kind| kind != ShapeKind::Plane);
    (table, kinds.map(|kind| ShapeRef { kind, row: 0 }).collect())
}

/// A checker of a bright and a dim color, so that texture coordinates count.
const CHECKER: Texture = Texture::Checker { a: Vec3::new(4.0, 2.0, 1.0), b: Vec3::new(0.5, 0.25, 0.5), size: 0.25 };

/// One emissive shape in one place.
fn scene(shape: ShapeRef, at: Affine3A, two_sided: bool) -> SceneBuffers {
    let mut scene = SceneBuffers { shapes: table().0, ..Default::default() };
    scene.trees.meshes =
        scene.shapes.meshes.iter().map(|mesh| MeshTree::build(mesh.clone(), TreeBuilder::default()).unwrap()).collect();
    scene.textures.rows.push(CHECKER);
    scene.materials.rows.push(MaterialRow { kind: MaterialKind::Emissive, row: 0, key: 0, detail: DetailId::NONE });
    let radiance = ColorSource { factor: Vec3::ONE, texture: TextureId(0) };
    scene.materials.emissive.push(Emissive { radiance, two_sided });
    place(&mut scene, shape, at, MaterialId(0));
    finish(&mut scene);
    scene
}

fn place(scene: &mut SceneBuffers, shape: ShapeRef, at: Affine3A, material: MaterialId) {
    let object_to_world = Affine::from_affine3a(at).unwrap();
    let world_to_object = object_to_world.inverse().unwrap();
    let key = scene.instances.len() as u64;
    scene.instances.push(Instance { object_to_world, world_to_object, shape, material, key });
}

fn finish(scene: &mut SceneBuffers) {
    scene.trees.top = TopTree::build(&scene.geometry().instances(), TreeBuilder::default()).unwrap();
    scene.emitters = Emitters::new(scene);
    scene.validate().unwrap();
}

fn hit(scene: &SceneBuffers, ray: &Ray) -> Hit {
    let column = |v: f32| [v];
    let (o, d) = (ray.origin.to_array().map(column), ray.direction.to_array().map(column));
    let mut hits = HitColumns::new();
    hits.resize(1, Hit::miss());
    let rays = Rays { origin: [&o[0], &o[1], &o[2]], direction: [&d[0], &d[1], &d[2]], time: &[] };
    closest_hits(&scene.geometry(), Level::detect(), rays, hits.view_mut());
    hits.get(0)
}

fn is_blocked(scene: &SceneBuffers, origin: Vec3, direction: Vec3, distance: f32) -> bool {
    let column = |v: f32| [v];
    let (o, d) = (origin.to_array().map(column), direction.to_array().map(column));
    let rays = Rays { origin: [&o[0], &o[1], &o[2]], direction: [&d[0], &d[1], &d[2]], time: &[] };
    let mut blocked = [false];
    occluded(&scene.geometry(), Level::detect(), rays, &[distance], &mut blocked);
    blocked[0]
}

/// The light that comes to a point from a direction, and the density with which that direction is drawn.
fn met(scene: &SceneBuffers, origin: Vec3, direction: Vec3) -> (Vec3, f32) {
    let ray = Ray { origin, direction, time: 0.0 };
    let hit = hit(scene, &ray);
    if hit.is_miss() {
        return (Vec3::ZERO, 0.0);
    }
    let point = surface(&scene.geometry(), &ray, &hit);
    let emissive = scene.materials.emissive.get(0);

    let place = point.place(hit.instance, hit.primitive, 0.0);
    let shines = emissive.two_sided || point.geometric_normal.dot(direction) < 0.0;
    let radiance = if shines { scene.color(emissive.radiance, &place.into()) } else { Vec3::ZERO };
    (radiance, scene.light_pdf(origin, 0.0, (hit.instance, hit.primitive), &point))
}

fn placed(scale: Vec3, translation: Vec3) -> Affine3A {
    let turned = Quat::from_axis_angle(Vec3::new(0.6, 0.48, 0.64), 1.1);
    Affine3A::from_scale_rotation_translation(scale, turned, translation)
}

/// Places near and far, stretched, mirrored, sheared.
fn places() -> Vec<Affine3A> {
    let shear =
        Affine3A::from_mat3(glam::Mat3::from_cols(Vec3::X, Vec3::new(0.7, 1.0, 0.0), Vec3::new(0.0, -0.3, 0.8)));
    vec![
        Affine3A::IDENTITY,
        placed(Vec3::splat(2.0), Vec3::new(5.0, -3.0, 8.0)),
        placed(Vec3::new(3.0, 0.5, -1.0), Vec3::new(50.0, 20.0, -10.0)),
        placed(Vec3::ONE, Vec3::ZERO) * shear,
    ]
}

/// A direction in which the shape may be, seen from a point, and one over its density per solid angle. It is drawn in object
/// space, in the cone of a ball around the shape, and mapped to world space: solid angle is stretched by |det M|/|Md|³.
fn about(scene: &SceneBuffers, point: Vec3, random: &mut Random) -> (Vec3, f32) {
    let instance = scene.instances.get(0);
    let center = -instance.world_to_object.point(point);
    let inverse = 1.2 / center.length();
    let versine = if inverse < 1.0 { 1.0 - (1.0 - inverse * inverse).sqrt() } else { 2.0 };
    let local = Basis::around(center.normalize()).to_world(warp::cone(random.square(), versine));
    let columns = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| instance.object_to_world.vector(axis));
    let direction = instance.object_to_world.vector(local);
    let stretch = columns[0].cross(columns[1]).dot(columns[2]).abs() / direction.length().powi(3);
    (direction.normalize(), stretch / warp::cone_pdf(versine))
}

/// A sum of samples and of their squares.
#[derive(Default)]
struct Mean(f64, f64, f64);

impl Mean {
    fn add(&mut self, x: f64) {
        self.0 += 1.0;
        self.1 += x;
        self.2 += x * x;
    }

    fn mean(&self) -> f64 {
        self.1 / self.0
    }

    fn squared_error(&self) -> f64 {
        (self.2 / self.0 - self.mean().powi(2)).max(0.0) / self.0
    }
}

/// Both agree within five standard errors, which must be below a part of them.
#[track_caller]
fn agree(name: &str, a: &Mean, b: &Mean, part: f64) {
    // What needs no chance to agree is rounded.
    let error = (a.squared_error() + b.squared_error()).sqrt() + 1e-5 * a.mean().max(b.mean());
    assert!(error < part * a.mean().max(b.mean()), "{name}: {} and {} are known to {error} only", a.mean(), b.mean());
    assert!((a.mean() - b.mean()).abs() < 5.0 * error, "{name}: {} and {} differ, error {error}", a.mean(), b.mean());
}

/// Every shape, everywhere, seen from near it, from some sides, and from inside.
fn each_view(mut view: impl FnMut(&str, &SceneBuffers, Vec3)) {
    let mut random = Random::new(6);
    for shape in table().1 {
        for (i, at) in places().into_iter().enumerate() {
            for (j, distance) in [0.23, 1.4, 1.8].into_iter().enumerate() {
                let two_sided = (i + j) % 2 == 1;
                let scene = scene(shape, at, two_sided);
                let away = if distance < 1.0 { Vec3::new(0.05, 0.1, 0.2) } else { random.direction() * distance };
                let name = format!("{:?} in place {i}, two-sided: {two_sided}, from {distance}", shape.kind);
                view(&name, &scene, at.transform_point3(away));
            }
        }
    }
}

/// What is drawn and not hidden adds up to what comes from everywhere; and the density, to the share of samples.
#[test]
fn drawn_light_is_all_light() {
    let mut random = Random::new(1);
    each_view(|name, scene, point| {
        let (mut all, mut drawn) = (Mean::default(), Mean::default());
        let (mut density, mut share) = (Mean::default(), Mean::default());
        for _ in 0..20_000 {
            let (direction, weight) = about(scene, point, &mut random);
            let (radiance, pdf) = met(scene, point, direction);
            all.add(f64::from(radiance.element_sum() * weight));
            density.add(f64::from(pdf * weight));
        }
        for _ in 0..20_000 {
            let sample = scene.sample_light(point, 0.0, random.unit(), random.square().into());
            let visible = sample.filter(|sample| {
                let (direction, distance) = sample.ray_from(point);
                !is_blocked(scene, point, direction, distance)
            });
            drawn.add(visible.map_or(0.0, |sample| f64::from(sample.radiance.element_sum() / sample.pdf)));
            share.add(if visible.is_some() { 1.0 } else { 0.0 });
        }
        if all.mean() == 0.0 {
            assert_eq!((drawn.mean(), density.mean(), share.mean()), (0.0, 0.0, 0.0), "{name}");
            return;
        }
        agree(&format!("{name}: light"), &all, &drawn, 0.08);
        // Densities are large where surfaces graze.
        agree(&format!("{name}: density"), &density, &share, 0.2);
    });
}

/// A direction that was drawn, and met again by a ray, has the density and the light that the sample says.
#[test]
fn a_ray_along_a_sample_finds_it() {
    let (mut random, mut found, mut wrong) = (Random::new(2), 0, Vec::new());
    each_view(|name, scene, point| {
        for _ in 0..500 {
            let Some(sample) = scene.sample_light(point, 0.0, random.unit(), random.square().into()) else { continue };
            let ray = Ray { origin: point, direction: sample.direction, time: 0.0 };
            let hit = hit(scene, &ray);
            // A grazing ray may pass by, or meet a part of a bent shape that hides the place.
            let length = (sample.target - point).length();
            if hit.is_miss() || (hit.t - length).abs() > 1e-4 * length {
                continue;
            }
            let there = surface(&scene.geometry(), &ray, &hit);
            let cosine = there.geometric_normal.dot(sample.direction).abs();
            if cosine < 0.1 {
                continue;
            }
            let pdf = scene.light_pdf(point, 0.0, (hit.instance, hit.primitive), &there);
            // The place is rounded, and with it the normal, most on the ends of stretched shapes.
            if (pdf / sample.pdf - 1.0).abs() > 5e-3 {
                wrong.push(format!("{name}: {pdf} for {sample:?}, {there:?}"));
            }
            found += 1;
        }
    });
    // Next to an edge the other face may be met.
    assert!(wrong.len() * 5000 < found, "{} of {found}: {:?}", wrong.len(), wrong.first());
    assert!(found > 10_000, "only {found} were found");
}

/// Places that are hard on rounding. Far out f32 has steps of 8 mm.
fn hard_places() -> Vec<Affine3A> {
    vec![
        placed(Vec3::splat(1e-3), Vec3::new(0.5, 1.0, -0.3)),
        placed(Vec3::splat(1e4), Vec3::new(1e4, 3e3, 0.0)),
        placed(Vec3::splat(4.0), Vec3::new(1e5, -1e5, 1e5)),
        placed(Vec3::new(1e3, 40.0, 20.0), Vec3::new(-1e5, 2e3, 1e5)),
    ]
}

/// Neither the ray from the point itself nor one from beside it meets the light before its end, on shapes that hide no part of
/// their outside; and the end is close to the light.
#[test]
fn shadow_rays_end_before_their_light() {
    let mut random = Random::new(3);
    for shape in table().1.into_iter().filter(|shape| shape.kind != ShapeKind::Torus) {
        for at in places().into_iter().chain(hard_places()) {
            let scene = scene(shape, at, false);
            let mut lit = 0;
            for i in 0..600 {
                // From near by and from far away.
                let away = random.direction() * (1.3 + 100.0 * random.unit().powi(8));
                let point = at.transform_point3(away);
                let Some(sample) = scene.sample_light(point, 0.0, random.unit(), random.square().into()) else {
                    continue;
                };
                lit += 1;
                let length = (sample.target - point).length();
                let coarse = point.abs().max_element().max(length) * f32::EPSILON;
                let name = format!("{:?} at {at}, {i}: {sample:?} from {point}", shape.kind);
                assert!(!is_blocked(&scene, point, sample.direction, sample.distance), "{name}");
                let beside = point + random.direction() * coarse;
                let (direction, distance) = sample.ray_from(beside);
                assert!(!is_blocked(&scene, beside, direction, distance), "{name}, beside {beside}");
                let ray = Ray { origin: point, direction: (sample.target - point).normalize(), time: 0.0 };
                let hit = hit(&scene, &ray);
                if !hit.is_miss() {
                    let normal = surface(&scene.geometry(), &ray, &hit).geometric_normal;
                    let above = (hit.t - length) * normal.dot(ray.direction).abs();
                    assert!(above < 1e-5 * length + 16.0 * coarse, "{name} ends early: {hit:?}, {above}");
                }
            }
            assert!(lit > 100, "{:?} at {at}: {lit}", shape.kind);
        }
    }
}

/// A sheet of 32 by 32 triangles whose picture shines in one corner: most samples go there, and their mean is what the corner
/// sends, by a sum over its parts.
#[test]
fn triangles_are_drawn_where_their_texture_shines() {
    let mut sheet = TriangleMesh::default();
    for y in 0..17u32 {
        for x in 0..17u32 {
            let uv = Vec2::new(x as f32, y as f32) / 16.0;
            sheet.positions.push((uv * 2.0 - 1.0).extend(0.0));
            sheet.uvs.push(uv);
            if x < 16 && y < 16 {
                let corner = y * 17 + x;
                sheet.triangles.extend([[corner, corner + 1, corner + 18], [corner, corner + 18, corner + 17]]);
            }
        }
    }
    let mut pixels = vec![[0.0; 3]; 16 * 16];
    // Row 0 is at the top, so the last row is at v = 0.
    (0..4).for_each(|i| pixels[(15 - i / 2) * 16 + i % 2] = [1.0, 2.0, 4.0]);
    let image = Arc::new(Image { width: 16, height: 16, texels: Texels::Floats(pixels) });
    let at = placed(Vec3::new(2.0, 1.0, 1.0), Vec3::new(3.0, 0.0, -2.0));
    let mut scene = scene(ShapeRef { kind: ShapeKind::Mesh, row: 0 }, at, true);
    scene.shapes.meshes[0] = Arc::new(sheet);
    scene.trees.meshes[0] = MeshTree::build(scene.shapes.meshes[0].clone(), TreeBuilder::default()).unwrap();
    scene.textures.rows[0] = Texture::Image(ImageTexture::new(image));
    finish(&mut scene);

    let point = at.transform_point3(Vec3::new(-0.3, 0.2, 1.5));
    let steps = 800;
    let normal = (at.matrix3 * glam::Vec3A::X).cross(at.matrix3 * glam::Vec3A::Y);
    let mut expected = 0.0;
    for i in 0..steps * steps {
        let uv = (Vec2::new((i % steps) as f32, (i / steps) as f32) + 0.5) / steps as f32;
        let radiance = scene.textures.rows[0].evaluate(&Coordinates::of(uv)).truncate();
        let to = at.transform_point3((uv * 2.0 - 1.0).extend(0.0)) - point;
        let area = 4.0 * Vec3::from(normal) / (steps * steps) as f32;
        expected += f64::from(radiance.element_sum() * area.dot(to).abs() / to.length().powi(3));
    }
    let (mut random, mut drawn, mut lit) = (Random::new(8), Mean::default(), 0);
    for _ in 0..20_000 {
        let sample = scene.sample_light(point, 0.0, random.unit(), random.square().into());
        lit += i32::from(sample.is_some());
        drawn.add(sample.map_or(0.0, |sample| f64::from(sample.radiance.element_sum() / sample.pdf)));
    }
    let error = drawn.squared_error().sqrt();
    assert!((drawn.mean() - expected).abs() < 5.0 * error && error < 0.02 * expected, "{} {expected}", drawn.mean());
    // By area alone it would be one in 64, or with what blurs into neighbors one in 28.
    assert!(lit > 12_000, "{lit}");
}
