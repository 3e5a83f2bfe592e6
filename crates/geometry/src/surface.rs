//! What a ray found: the surface at a hit, and where rays start that leave it.
//!
//! A point on a surface is rounded to f32, moved off the surface, rounded again, and mapped to object space by the next ray,
//! which rounds a third time. [`SurfacePoint::error`] bounds the sum of all that along the normal, so that a ray that starts
//! there is truly on the side it was put. The idea is that of "Error bounds" in Pharr, Jakob and Humphreys, "Physically
//! Based Rendering", but the bound is taken where the surface is exact, in object space, and brought to world space along the
//! normal: a shape that is stretched a thousandfold in one direction costs nothing in the others.
//!
//! A point near an edge could be put past the neighboring face. So the point itself keeps away from edges by a little more
//! than the error; a pixel cannot see the difference.
//!
//! **The limit.** The error follows the step of f32 where the surface is: about a micrometer for a shape of one meter at the
//! origin, half a millimeter a kilometer away from it and 5 cm at 100 km. What is finer than that is lost: a ray that leaves
//! one side of a gap or a bump narrower than the error may start beyond the other.

use glam::{DVec3, Vec2, Vec3};

use crate::attributes::SurfacePlace;
use crate::hit::Hit;
use crate::mesh::TriangleMesh;
use crate::ray::Ray;
use crate::scene::SceneGeometry;
use crate::shape::{Analytic, LocalSurface, with_shape};
use crate::transform::Affine;

/// The surface at a hit, in world space.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SurfacePoint {
    /// The point, on the surface but for rounding. Rays do not start here, but at [`offset_origin`].
    pub position: Vec3,
    /// Unit normal of the surface itself: outward on a closed shape, on a mesh the side its triangles run counterclockwise on.
    pub geometric_normal: Vec3,
    /// Unit normal for shading: interpolated on a mesh with normals, otherwise the geometric one.
    pub shading_normal: Vec3,
    /// Texture coordinates, as the shape's type says; on a mesh without any they are 0.
    pub uv: Vec2,
    /// Bound on the distance, along the normal and in meters, between an origin at `position` and the surface as a ray sees it.
    pub error: f32,
}

impl SurfacePoint {
    /// The point as a place on what was hit at some time.
    #[inline(always)]
    pub fn place(&self, instance: u32, primitive: u32, time: f32) -> SurfacePlace {
        SurfacePlace { instance, primitive, position: self.position, uv: self.uv, width: 0.0, time }
    }
}

/// Half a unit in f32's last place, relative.
pub(crate) const HALF_ULP: f64 = 1.0 / (1 << 24) as f64;

/// The surface at a hit of [`closest_hits`](crate::closest_hits), which must not be a miss; panics on one.
pub fn surface(scene: &SceneGeometry<'_>, ray: &Ray, hit: &Hit) -> SurfacePoint {
    let mut moved = None;
    let (to_world, to_object) = scene.place_at(hit.instance, ray.time, &mut moved);
    with_shape!(scene.table, scene.shapes[hit.instance as usize],
        analytic => {
            let (point, rounding) = meeting(to_world, to_object, ray, hit.t);
            let bounds = analytic.bounds();
            // Grazing directions are rounded too: one unit over the length of the shape.
            let tilt = if bounds.min.is_finite() { bounds.reach() as f64 * (4.0 * HALF_ULP) } else { 0.0 };
            let local = analytic.surface(point, hit.primitive, 4.0 * (rounding + tilt));
            place(to_world, to_object, &Found { local, shading: local.normal, tilt }, rounding)
        },
        mesh => MeshHit::new(&scene.table.meshes[mesh], to_world, to_object, ray, hit).point()
    )
}

/// Where a ray is at t, in object space, and what rounding moves that by.
#[inline(always)]
fn meeting(to_world: &Affine, to_object: &Affine, ray: &Ray, t: f32) -> (DVec3, DVec3) {
    let local = to_object.ray(ray);
    let point = local.origin.as_dvec3() + local.direction.as_dvec3() * t as f64;
    (point, rounding(to_world, to_object, point))
}

/// Whether a ray met the front of what it hit, the side that the geometric normal points to, by far fewer numbers than
/// [`surface`] takes.
#[inline]
pub fn meets_front(scene: &SceneGeometry<'_>, ray: &Ray, hit: &Hit) -> bool {
    with_shape!(scene.table, scene.shapes[hit.instance as usize],
        _analytic => surface(scene, ray, hit).geometric_normal.dot(ray.direction) < 0.0,
        mesh => {
            // Normals and directions go to and fro in such a way that what faces what stays.
            let direction = scene.local_ray(hit.instance, ray).direction.as_dvec3();
            let [a, b, c] = scene.table.meshes[mesh].corners(hit.primitive as usize).map(|corner| corner.as_dvec3());
            (b - a).cross(c - a).dot(direction) < 0.0
        }
    )
}

/// The surface at a point that was drawn, and not found by a ray.
#[inline(always)]
pub(crate) fn place_sample(to_world: &Affine, to_object: &Affine, local: &LocalSurface, tilt: f64) -> SurfacePoint {
    let found = Found { local: *local, shading: local.normal, tilt };
    let point = place(to_world, to_object, &found, rounding(to_world, to_object, local.point));
    SurfacePoint { shading_normal: point.geometric_normal, ..point }
}

/// What rounding moves a point by along the axes of object space.
#[inline(always)]
fn rounding(to_world: &Affine, to_object: &Affine, point: DVec3) -> DVec3 {
    // The position is rounded when it is found, and again when it is moved.
    let world_error = to_world.point_f64(point).abs() * (2.5 * HALF_ULP);
    absolute(to_object, world_error) + point.abs() * (2.0 * HALF_ULP)
}

/// A surface in object space, and what its intersection adds to the error along the normal.
struct Found {
    local: LocalSurface,
    shading: DVec3,
    tilt: f64,
}

/// Maps a surface to world space.
#[inline(always)]
fn place(to_world: &Affine, to_object: &Affine, found: &Found, rounding: DVec3) -> SurfacePoint {
    let LocalSurface { point, normal, uv } = found.local;
    // One of Newton's steps: rays see the shape through `to_object`, of which `to_world` is the inverse only to rounding.
    let guess = to_world.point_f64(point);
    let position = guess + to_world.vector_f64(point - to_object.point_f64(guess));
    let outward = to_object.transposed_f64(normal);
    let steepness = outward.length();
    let geometric_normal = (outward / steepness).as_vec3();
    let shading = to_object.transposed_f64(found.shading);
    let shading_normal = unit_or(shading, geometric_normal.as_dvec3()).as_vec3();
    let error = 2.0 * (normal.abs().dot(rounding) + found.tilt) / steepness;
    SurfacePoint { position: position.as_vec3(), geometric_normal, shading_normal, uv, error: error as f32 }
}

/// A vector of unit length, or another one if it has none; without a branch.
#[inline(always)]
fn unit_or(vector: DVec3, other: DVec3) -> DVec3 {
    let scale = vector.length_recip();
    either((scale > 0.0) & (scale < f64::INFINITY), vector * scale, other)
}

/// One of two vectors, without a branch.
#[inline(always)]
fn either(first: bool, a: DVec3, b: DVec3) -> DVec3 {
    let pick = |a: f64, b: f64| if first { a } else { b };
    DVec3::new(pick(a.x, b.x), pick(a.y, b.y), pick(a.z, b.z))
}

/// All that the surface of a mesh at a hit follows from.
#[derive(Clone, Copy)]
pub(crate) struct MeshHit {
    pub(crate) to_world: Affine,
    pub(crate) to_object: Affine,
    pub(crate) ray: Ray,
    pub(crate) t: f32,
    /// The weights of the second and the third corner.
    pub(crate) weights: [f32; 2],
    pub(crate) corners: [Vec3; 3],
    /// The corners' normals; zeros if there are none.
    pub(crate) normals: [Vec3; 3],
    pub(crate) has_normals: bool,
    /// The corners' texture coordinates; zeros if there are none.
    pub(crate) uvs: [Vec2; 3],
}

impl MeshHit {
    #[inline(always)]
    pub(crate) fn new(mesh: &TriangleMesh, to_world: &Affine, to_object: &Affine, ray: &Ray, hit: &Hit) -> MeshHit {
        let vertices = mesh.triangles[hit.primitive as usize].map(|vertex| vertex as usize);
        let has_normals = !mesh.normals.is_empty();
        MeshHit {
            to_world: *to_world,
            to_object: *to_object,
            ray: *ray,
            t: hit.t,
            weights: [hit.u, hit.v],
            corners: vertices.map(|vertex| mesh.positions[vertex]),
            normals: if has_normals { vertices.map(|vertex| mesh.normals[vertex]) } else { [Vec3::ZERO; 3] },
            has_normals,
            uvs: if mesh.uvs.is_empty() { [Vec2::ZERO; 3] } else { vertices.map(|vertex| mesh.uvs[vertex]) },
        }
    }

    /// The surface there. Free of branches, so that a loop over many becomes vector code, and of arrays' `map`, whose closures are not
    /// always compiled for the loop's instruction set: with them, this took twice as long in one build and not in another.
    #[inline(always)]
    pub(crate) fn point(&self) -> SurfacePoint {
        let (_, rounding) = meeting(&self.to_world, &self.to_object, &self.ray, self.t);
        let (a, b, c) = (self.corners[0].as_dvec3(), self.corners[1].as_dvec3(), self.corners[2].as_dvec3());
        let cross = (b - a).cross(c - a);
        let normal = unit_or(cross, DVec3::Y);
        let tilt = tilt_of_triangle([c - b, a - c, b - a].iter().fold(0.0f64, |most, side| most.max(side.length())));
        let (u, v) = (f64::from(self.weights[0]), f64::from(self.weights[1]));
        let error = (normal, rounding, tilt, cross.length());
        let first = (1.0 - u - v).max(clearance(c - b, error));
        let (second, third) = (u.max(clearance(a - c, error)), v.max(clearance(b - a, error)));
        let sum = first + second + third;
        let weights = [first / sum, second / sum, third / sum];
        let point = a * weights[0] + b * weights[1] + c * weights[2];
        let normals = &self.normals;
        let mixed = normals[0].as_dvec3() * weights[0]
            + normals[1].as_dvec3() * weights[1]
            + normals[2].as_dvec3() * weights[2];
        let shading = either(self.has_normals, mixed, normal);
        let uv = self.uvs[0] * weights[0] as f32 + self.uvs[1] * weights[1] as f32 + self.uvs[2] * weights[2] as f32;
        let found = Found { local: LocalSurface { point, normal, uv }, shading, tilt };
        place(&self.to_world, &self.to_object, &found, rounding)
    }
}

/// The least weight of the corner opposite to a side: four times the error away from it, at most half way to the middle. A weight is
/// the distance from a side over that of the opposite corner, which is twice the area over the side's length.
#[inline(always)]
fn clearance(side: DVec3, (normal, rounding, tilt, twice_area): (DVec3, DVec3, f64, f64)) -> f64 {
    let away = normal.cross(side).abs();
    (4.0 * (away.dot(rounding) + side.length() * tilt) / twice_area).min(1.0 / 6.0)
}

/// What a triangle's longest side adds to the error along its normal: shearing moves corners by up to ten units of its extent, tilting a
/// grazing ray by four.
#[inline(always)]
pub(crate) fn tilt_of_triangle(extent: f64) -> f64 {
    extent * (14.0 * HALF_ULP)
}

/// What a map makes of errors: its linear part with all signs positive.
#[inline(always)]
fn absolute(map: &Affine, error: DVec3) -> DVec3 {
    let row =
        |r: &[f32; 4]| (r[0] as f64).abs() * error.x + (r[1] as f64).abs() * error.y + (r[2] as f64).abs() * error.z;
    DVec3::new(row(&map.rows[0]), row(&map.rows[1]), row(&map.rows[2]))
}

/// Where a ray starts that leaves a surface in a direction: on the direction's side of the surface, off it by
/// [`SurfacePoint::error`].
///
/// So it does not meet the surface it leaves, unless the shape bends or folds into its way, and it does meet whatever else
/// lies ahead.
#[inline(always)]
pub fn offset_origin(point: &SurfacePoint, direction: Vec3) -> Vec3 {
    let normal = point.geometric_normal;
    let side = if direction.dot(normal) < 0.0 { -normal } else { normal };
    let offset = side * point.error;
    let away = |position: f32, offset: f32| {
        let moved = position + offset;
        if offset > 0.0 {
            moved.next_up()
        } else if offset < 0.0 {
            moved.next_down()
        } else {
            moved
        }
    };
    let position = point.position;
    Vec3::new(away(position.x, offset.x), away(position.y, offset.y), away(position.z, offset.z))
}
