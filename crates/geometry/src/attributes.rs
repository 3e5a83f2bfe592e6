//! What a surface has beside a point and a normal: how texture coordinates run over it, and what a mesh's vertices carry.
//!
//! All of it is found from the instance, the primitive and the point, when it is asked for: hits of scenes that do not ask carry
//! nothing for it.

use glam::{DVec2, DVec3, Vec2, Vec3, Vec4};

use crate::mesh::TriangleMesh;
use crate::scene::SceneGeometry;
use crate::shape::{Analytic, ShapeKind, with_shape};

/// A set of texture coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UvSet {
    /// The one that every shape has.
    First,
    /// The second one of a mesh, or the first where there is none.
    Second,
}

/// A place on an instance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePlace {
    /// The instance.
    pub instance: u32,
    /// The triangle or the face.
    pub primitive: u32,
    /// The point, in world space.
    pub position: Vec3,
    /// The first texture coordinates there.
    pub uv: Vec2,
    /// How much of the surface is looked at, across and in meters; 0 for a point.
    pub width: f32,
    /// When it is there.
    pub time: f32,
}

impl SceneGeometry<'_> {
    /// Texture coordinates of a set.
    pub fn uv(&self, place: &SurfacePlace, set: UvSet) -> Vec2 {
        let second = || self.mesh_at(place).and_then(|(mesh, point)| mesh.second_uv(place.primitive as usize, point));
        if set == UvSet::Second { second().unwrap_or(place.uv) } else { place.uv }
    }

    /// The color of a mesh's vertices, linear, with alpha; white without any.
    pub fn vertex_color(&self, place: &SurfacePlace) -> Vec4 {
        self.mesh_at(place).map_or(Vec4::ONE, |(mesh, point)| mesh.color(place.primitive as usize, point))
    }

    /// The tangent of a mesh that has them, of any length, and whether the bitangent is the cross product of normal and tangent
    /// (1) or the opposite of it (-1), in world space.
    pub fn vertex_tangent(&self, place: &SurfacePlace) -> Option<(Vec3, f32)> {
        let (mesh, point) = self.mesh_at(place).filter(|(mesh, _)| !mesh.tangents.is_empty())?;
        let weigh = mesh.weigh(place.primitive as usize, point);
        let tangent = weigh.fold(Vec4::ZERO, |sum, (vertex, weight)| sum + mesh.tangents[vertex] * weight);
        let mut moved = None;
        let (to_world, _) = self.place_at(place.instance, place.time, &mut moved);
        let side = if to_world.mirrors() { -1.0 } else { 1.0 };
        Some((to_world.vector(tangent.truncate()), side * 1f32.copysign(tangent.w)))
    }

    /// The unit normal of a mesh that has them, in world space.
    pub fn vertex_normal(&self, place: &SurfacePlace) -> Option<Vec3> {
        let (mesh, point) = self.mesh_at(place).filter(|(mesh, _)| !mesh.normals.is_empty())?;
        let weigh = mesh.weigh(place.primitive as usize, point);
        let normal = weigh.fold(Vec3::ZERO, |sum, (vertex, weight)| sum + mesh.normals[vertex] * weight);
        let mut moved = None;
        let (_, to_object) = self.place_at(place.instance, place.time, &mut moved);
        to_object.transposed_f64(normal.as_dvec3()).try_normalize().map(|normal| normal.as_vec3())
    }

    /// The gradients of u and v along the surface, in world space: how much they grow a meter, and where to. Zero where they do not
    /// depend on the place, or have none (poles).
    pub fn uv_gradients(&self, place: &SurfacePlace, set: UvSet) -> [Vec3; 2] {
        let mut moved = None;
        let (_, to_object) = self.place_at(place.instance, place.time, &mut moved);
        let shape = self.shapes[place.instance as usize];
        let gradients = with_shape!(self.table, shape,
            analytic => analytic.uv_gradients(to_object.point_f64(place.position.as_dvec3()), place.primitive),
            mesh => self.table.meshes[mesh].uv_gradients(place.primitive as usize, set)
        );
        gradients.map(|gradient| {
            let gradient = to_object.transposed_f64(gradient).as_vec3();
            if gradient.is_finite() { gradient } else { Vec3::ZERO }
        })
    }

    /// The mesh of an instance that is one, and the point in its space.
    fn mesh_at(&self, place: &SurfacePlace) -> Option<(&TriangleMesh, DVec3)> {
        let shape = self.shapes[place.instance as usize];
        (shape.kind == ShapeKind::Mesh).then(|| {
            let mut moved = None;
            let (_, to_object) = self.place_at(place.instance, place.time, &mut moved);
            (&*self.table.meshes[shape.row as usize], to_object.point_f64(place.position.as_dvec3()))
        })
    }
}

impl TriangleMesh {
    /// The second texture coordinates at a point of a triangle, if there are any.
    pub fn second_uv(&self, triangle: usize, point: DVec3) -> Option<Vec2> {
        let mix = |sum, (vertex, weight): (usize, f32)| sum + self.second_uvs[vertex] * weight;
        (!self.second_uvs.is_empty()).then(|| self.weigh(triangle, point).fold(Vec2::ZERO, mix))
    }

    /// The color of the vertices at a point of a triangle; white without any.
    pub fn color(&self, triangle: usize, point: DVec3) -> Vec4 {
        if self.colors.is_empty() {
            return Vec4::ONE;
        }
        self.weigh(triangle, point).fold(Vec4::ZERO, |sum, (vertex, weight)| sum + self.colors[vertex] * weight)
    }

    /// The vertices of a triangle with their weights at a point on it.
    fn weigh(&self, triangle: usize, point: DVec3) -> impl Iterator<Item = (usize, f32)> {
        let [a, b, c] = self.corners(triangle).map(|corner| corner.as_dvec3());
        let cross = (b - a).cross(c - a);
        let area = cross.length_squared();
        let part = |from: DVec3, to: DVec3| ((to - from).cross(point - from).dot(cross) / area).clamp(0.0, 1.0);
        let weights = if area > 0.0 { [part(b, c), part(c, a), part(a, b)] } else { [1.0, 0.0, 0.0] };
        let sum = weights[0] + weights[1] + weights[2];
        let corners = self.triangles[triangle];
        (0..3).map(move |i| (corners[i] as usize, (weights[i] / sum) as f32))
    }

    /// The gradients of the texture coordinates of a set in object space.
    fn uv_gradients(&self, triangle: usize, set: UvSet) -> [DVec3; 2] {
        let uvs = if set == UvSet::Second && !self.second_uvs.is_empty() { &self.second_uvs } else { &self.uvs };
        let [a, b, c] = self.corners(triangle).map(|corner| corner.as_dvec3());
        let (ab, ac) = (b - a, c - a);
        let cross = ab.cross(ac);
        if uvs.is_empty() {
            return [DVec3::ZERO; 2];
        }
        let [at_a, at_b, at_c] = self.triangles[triangle].map(|vertex| uvs[vertex as usize].as_dvec2());
        let (along_ab, along_ac): (DVec2, DVec2) = (at_b - at_a, at_c - at_a);
        // The vector in the plane whose products with the two sides are the differences along them.
        let gradient = |ab_step: f64, ac_step: f64| {
            (ac.cross(cross) * ab_step + cross.cross(ab) * ac_step) / cross.length_squared()
        };
        [gradient(along_ab.x, along_ac.x), gradient(along_ab.y, along_ac.y)]
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::Affine3A;

    use super::*;
    use crate::{
        Affine, Cone, Cuboid, Cylinder, Disk, Motions, Plane, Quad, ShapeRef, ShapeTable, Sphere, Spread, TopTree,
        Torus,
    };

    /// Steps along a surface change texture coordinates as their gradients say.
    fn check<T: Analytic + std::fmt::Debug>(shape: T, points: impl Iterator<Item = (DVec3, u32)>) {
        for (point, face) in points {
            let here = shape.surface(point, face, DVec3::ZERO);
            let gradients = shape.uv_gradients(here.point, face);
            let side = here.normal.any_orthonormal_vector();
            for direction in [side, here.normal.cross(side)] {
                let there = shape.surface(here.point + direction * 2e-3, face, DVec3::ZERO);
                let step = there.point - here.point;
                for (axis, gradient) in gradients.into_iter().enumerate() {
                    let found = gradient.dot(step) as f32;
                    let expected = there.uv[axis] - here.uv[axis];
                    // Coordinates are rounded, and surfaces bend along the step; seams are left out.
                    let tolerance = 3e-6 + 0.02 * expected.abs();
                    let sound = (found - expected).abs() < tolerance || expected.abs() > 0.1;
                    assert!(sound, "{shape:?} at {point}, axis {axis}: {found} instead of {expected}");
                }
            }
        }
    }

    fn spread(shape: &impl Spread) -> Vec<(DVec3, u32)> {
        let numbers = (0..12).map(|i| (i as f32 + 0.5) / 12.0);
        numbers.clone().flat_map(|u| numbers.clone().map(move |v| [u, v])).map(|u| shape.spread(u)).collect()
    }

    #[test]
    fn gradients_are_those_of_the_coordinates() {
        macro_rules! on {
            ($($shape:expr),*) => {$(
                let shape = $shape;
                // Near poles and rims steps of this length do not tell.
                let is_clear = |&(point, _): &(DVec3, u32)| point.x.hypot(point.z) > 0.25;
                check(shape, spread(&shape).into_iter().filter(is_clear));
            )*};
        }
        on!(
            Sphere { radius: 1.5 },
            Quad { half: Vec2::new(0.5, 2.0) },
            Disk { radius: 1.5, inner_radius: 0.2 },
            Cuboid { half: Vec3::new(0.5, 1.0, 2.0) },
            Cylinder { radius: 1.5, height: 0.7 },
            Cone { radius: 1.2, height: 2.0 },
            Torus { major_radius: 1.0, minor_radius: 0.4 }
        );
        check(Plane, [(DVec3::new(3.0, 0.0, -7.0), 0)].into_iter());
    }

    /// What an instance borrows.
    struct One {
        maps: [Affine; 2],
        shapes: [ShapeRef; 1],
        table: ShapeTable,
        top: TopTree,
    }

    impl One {
        fn new(mesh: TriangleMesh, map: Affine3A) -> One {
            let to_world = Affine::from_affine3a(map).unwrap();
            One {
                maps: [to_world, to_world.inverse().unwrap()],
                shapes: [ShapeRef { kind: ShapeKind::Mesh, row: 0 }],
                table: ShapeTable { meshes: vec![Arc::new(mesh)], ..Default::default() },
                top: TopTree::default(),
            }
        }

        fn geometry(&self) -> SceneGeometry<'_> {
            SceneGeometry {
                object_to_world: &self.maps[..1],
                world_to_object: &self.maps[1..],
                motions: Motions::NONE,
                shapes: &self.shapes,
                table: &self.table,
                mesh_trees: &[],
                top: &self.top,
                planes: &[],
                obvhs: None,
            }
        }
    }

    /// A triangle in the plane z = 0 whose second coordinates are (x, 2y), with a color and a normal at each corner.
    fn triangle() -> TriangleMesh {
        TriangleMesh {
            positions: vec![Vec3::ZERO, Vec3::X * 2.0, Vec3::Y],
            uvs: vec![Vec2::ZERO, Vec2::X, Vec2::Y],
            second_uvs: vec![Vec2::ZERO, Vec2::X * 2.0, Vec2::Y * 2.0],
            colors: vec![Vec4::X, Vec4::Y, Vec4::W],
            tangents: vec![Vec4::new(1.0, 0.0, 0.0, -1.0); 3],
            normals: vec![Vec3::Z, Vec3::X, Vec3::Y],
            triangles: vec![[0, 1, 2]],
        }
    }

    #[test]
    fn vertices_are_mixed_by_nearness_in_any_place() {
        // Scaled by (2, 2, 2) and by (-1, 1, 1), and moved.
        for (map, side) in [
            (Affine3A::from_scale(Vec3::splat(2.0)), 1.0),
            (Affine3A::from_translation(Vec3::ONE) * Affine3A::from_scale(Vec3::new(-1.0, 1.0, 1.0)), -1.0),
        ] {
            let scene = One::new(triangle(), map);
            // Half the first corner, and a quarter of each other.
            let position = map.transform_point3(Vec3::new(0.5, 0.25, 0.0));
            let place =
                SurfacePlace { instance: 0, primitive: 0, position, uv: Vec2::new(0.25, 0.25), width: 0.0, time: 0.0 };
            let scene = scene.geometry();
            assert_eq!(scene.uv(&place, UvSet::First), place.uv);
            assert!(scene.uv(&place, UvSet::Second).abs_diff_eq(Vec2::new(0.5, 0.5), 1e-6));
            assert!(scene.vertex_color(&place).abs_diff_eq(Vec4::new(0.5, 0.25, 0.0, 0.25), 1e-6));
            let (tangent, handedness) = scene.vertex_tangent(&place).unwrap();
            assert!(tangent.normalize().abs_diff_eq(Vec3::X * side, 1e-6));
            assert_eq!(handedness, -side);
            let normal = Vec3::new(0.25 * side, 0.25, 0.5).normalize();
            assert!(scene.vertex_normal(&place).unwrap().abs_diff_eq(normal, 1e-6));
            // One step of 2 m in object space is one of u and one of 1 m one of v; of the second set one of 1 m and half a one.
            let scale = map.transform_vector3(Vec3::X).length();
            for (set, expected) in [(UvSet::First, [0.5, 1.0]), (UvSet::Second, [1.0, 2.0])] {
                let found = scene.uv_gradients(&place, set);
                let expected = [Vec3::X * (side * expected[0] / scale), Vec3::Y * (expected[1] / scale)];
                assert!(
                    found[0].abs_diff_eq(expected[0], 1e-6) && found[1].abs_diff_eq(expected[1], 1e-6),
                    "{found:?}"
                );
            }
        }
    }

    #[test]
    fn what_a_mesh_lacks_has_a_stand_in() {
        let mut mesh = triangle();
        (mesh.second_uvs, mesh.colors, mesh.tangents, mesh.normals) = Default::default();
        let scene = One::new(mesh, Affine3A::IDENTITY);
        let place = SurfacePlace {
            instance: 0,
            primitive: 0,
            position: Vec3::ZERO,
            uv: Vec2::new(0.3, 0.6),
            width: 0.0,
            time: 0.0,
        };
        let scene = scene.geometry();
        assert_eq!((scene.uv(&place, UvSet::Second), scene.vertex_color(&place)), (place.uv, Vec4::ONE));
        assert_eq!((scene.vertex_tangent(&place), scene.vertex_normal(&place)), (None, None));
        assert_eq!(scene.uv_gradients(&place, UvSet::Second), scene.uv_gradients(&place, UvSet::First));
    }
}
