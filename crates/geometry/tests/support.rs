//! Scenes for the tests.

use std::sync::Arc;

use brewster_geometry::*;
use brewster_lanes::Level;
pub(crate) use brewster_random::Random;
use glam::{Affine3A, Quat, Vec2, Vec3};

/// Everything that a [`SceneGeometry`] borrows.
#[derive(Clone, Default)]
pub(crate) struct Scene {
    pub(crate) object_to_world: Vec<Affine>,
    pub(crate) world_to_object: Vec<Affine>,
    pub(crate) shapes: Vec<ShapeRef>,
    pub(crate) table: ShapeTable,
    pub(crate) mesh_trees: Vec<MeshTree>,
    pub(crate) top: TopTree,
    pub(crate) planes: Vec<u32>,
    pub(crate) motions: Motions,
}

impl Scene {
    pub(crate) fn instances(&self) -> Instances<'_> {
        Instances {
            world_to_object: &self.world_to_object,
            motions: &self.motions,
            shapes: &self.shapes,
            table: &self.table,
            mesh_trees: &self.mesh_trees,
        }
    }

    pub(crate) fn geometry(&self) -> SceneGeometry<'_> {
        SceneGeometry {
            object_to_world: &self.object_to_world,
            world_to_object: &self.world_to_object,
            motions: &self.motions,
            shapes: &self.shapes,
            table: &self.table,
            mesh_trees: &self.mesh_trees,
            top: &self.top,
            planes: &self.planes,
            obvhs: None,
        }
    }

    pub(crate) fn mesh(&mut self, mesh: TriangleMesh) -> ShapeRef {
        let mesh = Arc::new(mesh);
        self.mesh_trees.push(MeshTree::build(mesh.clone(), TreeBuilder::default()).unwrap());
        self.table.meshes.push(mesh);
        ShapeRef { kind: ShapeKind::Mesh, row: self.table.meshes.len() as u32 - 1 }
    }

    pub(crate) fn place(&mut self, shape: ShapeRef, at: Affine3A) {
        let at = Affine::from_affine3a(at).unwrap();
        self.object_to_world.push(at);
        self.world_to_object.push(at.inverse().unwrap());
        self.shapes.push(shape);
    }

    pub(crate) fn move_to(&mut self, instance: u32, at: Affine3A) {
        let at = Affine::from_affine3a(at).unwrap();
        self.object_to_world[instance as usize] = at;
        self.world_to_object[instance as usize] = at.inverse().unwrap();
    }

    pub(crate) fn built(mut self) -> Scene {
        self.top = TopTree::build(&self.instances(), TreeBuilder::default()).unwrap();
        self.planes = self.instances().planes();
        self.geometry().validate().unwrap();
        self
    }

    /// One shape of each analytic kind, of sizes around one.
    pub(crate) fn with_every_analytic_shape() -> (Scene, Vec<ShapeRef>) {
        let table = ShapeTable {
            spheres: vec![Sphere { radius: 0.7 }],
            planes: vec![Plane],
            quads: vec![Quad { half: Vec2::new(1.0, 0.6) }],
            disks: vec![Disk { radius: 0.8, inner_radius: 0.3 }],
            cuboids: vec![Cuboid { half: Vec3::new(0.5, 0.8, 0.3) }],
            cylinders: vec![Cylinder { radius: 0.4, height: 1.3 }],
            cones: vec![Cone { radius: 0.6, height: 1.1 }],
            tori: vec![Torus { major_radius: 0.7, minor_radius: 0.25 }],
            meshes: Vec::new(),
        };
        let kinds = ShapeKind::ALL.into_iter().filter(|&kind| kind != ShapeKind::Mesh);
        (Scene { table, ..Default::default() }, kinds.map(|kind| ShapeRef { kind, row: 0 }).collect())
    }
}

pub(crate) fn placed(scale: Vec3, rotation: Quat, translation: Vec3) -> Affine3A {
    Affine3A::from_scale_rotation_translation(scale, rotation, translation)
}

/// An icosahedron whose sides are split in four, `depth` times over; the radius depends on the direction.
pub(crate) fn ball(depth: u32, radius: impl Fn(Vec3) -> f32) -> TriangleMesh {
    let g = 0.5 * (1.0 + 5f32.sqrt());
    let mut points: Vec<Vec3> = [(-1.0, g), (1.0, g), (-1.0, -g), (1.0, -g)]
        .iter()
        .flat_map(|&(a, b)| [Vec3::new(a, b, 0.0), Vec3::new(0.0, a, b), Vec3::new(b, 0.0, a)])
        .map(Vec3::normalize)
        .collect();
    // The twenty triples of corners that are neighbors, counterclockwise from outside.
    let near = |a: usize, b: usize| (points[a] - points[b]).length() < 1.1;
    let mut triangles = Vec::new();
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if near(a, b) && near(b, c) && near(a, c) {
                    let outward = (points[b] - points[a]).cross(points[c] - points[a]).dot(points[a]) > 0.0;
                    triangles.push(if outward { [a, b, c] } else { [a, c, b] });
                }
            }
        }
    }
    for _ in 0..depth {
        let mut middles = std::collections::BTreeMap::new();
        let mut middle = |a: usize, b: usize| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                points.push((points[a] + points[b]).normalize());
                points.len() - 1
            })
        };
        triangles = triangles
            .iter()
            .flat_map(|&[a, b, c]| {
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
            })
            .collect();
    }
    TriangleMesh {
        normals: points.clone(),
        uvs: points.iter().map(|p| Vec2::new(p.x, p.y)).collect(),
        positions: points.iter().map(|&p| p * radius(p)).collect(),
        triangles: triangles.iter().map(|t| t.map(|v| v as u32)).collect(),
        ..Default::default()
    }
}

/// A ball with hills.
pub(crate) fn hills(p: Vec3) -> f32 {
    1.0 + 0.3 * (5.0 * p.x).sin() * (4.0 * p.y + 1.0).sin() + 0.1 * (17.0 * p.z).sin()
}

/// Triangles that have nothing to do with each other; some are slivers, some degenerate.
pub(crate) fn soup(random: &mut Random, count: usize, size: f32) -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    for i in 0..count as u32 {
        let (at, along) = (random.cube(), random.cube() * size);
        let thin = if i.is_multiple_of(5) { 1e-5 } else { 1.0 };
        let last = if i.is_multiple_of(50) { at } else { at + along * 0.4 + random.cube() * (size * thin) };
        mesh.positions.extend([at, at + along, last]);
        mesh.triangles.push([3 * i, 3 * i + 1, 3 * i + 2]);
    }
    mesh
}

/// Rays as owned columns.
#[derive(Clone, Default)]
pub(crate) struct RayColumns {
    pub(crate) origin: [Vec<f32>; 3],
    pub(crate) direction: [Vec<f32>; 3],
    pub(crate) time: Vec<f32>,
}

impl RayColumns {
    pub(crate) fn push(&mut self, ray: Ray) {
        for axis in 0..3 {
            self.origin[axis].push(ray.origin[axis]);
            self.direction[axis].push(ray.direction[axis]);
        }
        self.time.push(ray.time);
    }

    pub(crate) fn view(&self) -> Rays<'_> {
        Rays {
            origin: self.origin.each_ref().map(|c| &c[..]),
            direction: self.direction.each_ref().map(|c| &c[..]),
            time: &self.time,
        }
    }
}

impl FromIterator<Ray> for RayColumns {
    fn from_iter<I: IntoIterator<Item = Ray>>(rays: I) -> Self {
        let mut columns = RayColumns::default();
        rays.into_iter().for_each(|ray| columns.push(ray));
        columns
    }
}

pub(crate) fn hits_of(scene: &Scene, level: Level, rays: Rays<'_>) -> HitColumns {
    let mut hits = HitColumns::new();
    hits.resize(rays.len(), Hit::miss());
    closest_hits(&scene.geometry(), level, rays, hits.view_mut());
    hits
}

pub(crate) fn hit_of(scene: &Scene, ray: &Ray) -> Hit {
    let rays: RayColumns = [*ray].into_iter().collect();
    hits_of(scene, Level::detect(), rays.view()).get(0)
}

/// Places that are hard on rounding. Far out the shapes are of one meter and more: f32 has steps of 8 mm there.
pub(crate) fn places() -> Vec<Affine3A> {
    let turned = Quat::from_axis_angle(Vec3::new(0.6, 0.48, 0.64), 1.1);
    vec![
        Affine3A::IDENTITY,
        placed(Vec3::ONE, turned, Vec3::new(5.0, -3.0, 8.0)),
        placed(Vec3::new(3.0, 0.2, -1.0), turned, Vec3::new(50.0, 20.0, -10.0)),
        placed(Vec3::splat(1e-3), turned, Vec3::new(0.5, 1.0, -0.3)),
        placed(Vec3::splat(1e4), turned, Vec3::new(1e4, 3e3, 0.0)),
        placed(Vec3::splat(4.0), turned, Vec3::new(1e5, -1e5, 1e5)),
        placed(Vec3::new(1e3, 40.0, 20.0), turned, Vec3::new(-1e5, 2e3, 1e5)),
    ]
}

/// A direction on the normal's side, most often very close to the surface.
pub(crate) fn grazing(random: &mut Random, normal: Vec3) -> Vec3 {
    let along = normal.cross(random.direction()).normalize();
    let up = 10f32.powf(-8.0 * random.unit());
    let direction = (along + normal * up).normalize();
    // Rounding may have turned it away; then it is not a direction on this side.
    if direction.dot(normal) > 0.0 { direction } else { normal }
}

/// Counts what is wrong, and tells the first.
pub(crate) struct Tally {
    pub(crate) checked: usize,
    pub(crate) wrong: Vec<String>,
}

impl Tally {
    pub(crate) fn new() -> Tally {
        Tally { checked: 0, wrong: Vec::new() }
    }

    pub(crate) fn check(&mut self, right: bool, say: impl FnOnce() -> String) {
        self.checked += 1;
        if !right {
            self.wrong.push(say());
        }
    }

    pub(crate) fn close(self, name: &str, least: usize) {
        let first = self.wrong.first().cloned().unwrap_or_default();
        assert_eq!(self.wrong.len(), 0, "{name}: {} of {}: {first}", self.wrong.len(), self.checked);
        assert!(self.checked >= least, "{name}: only {} rays were checked", self.checked);
    }
}
