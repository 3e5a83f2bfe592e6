//! Points spread evenly over surfaces, and how they look from elsewhere: what light sources are sampled by.
//!
//! Points are drawn in object space, evenly over the area that the shape has there. An affine map stretches area differently
//! in different directions: [`area_scale`] says by how much at a normal, so that densities in world space are exact under any
//! map.

use glam::{DVec3, Vec2, Vec3};

use crate::mesh::TriangleMesh;
use crate::shape::{Analytic, LocalSurface, ShapeKind, ShapeRef, ShapeTable};
use crate::surface::{HALF_ULP, SurfacePoint, place_sample, tilt_of_triangle};
use crate::transform::Affine;

/// A shape with an area.
pub trait Spread: Analytic {
    /// The area in object space.
    fn area(&self) -> f64;

    /// A point on the shape and its face, spread evenly over the area by two numbers 0 ≤ u < 1.
    fn spread(&self, u: [f32; 2]) -> (DVec3, u32);
}

/// A point that was drawn on a shape, in object space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AreaSample {
    /// The surface there.
    pub local: LocalSurface,
    /// The face or the triangle.
    pub primitive: u32,
    /// What the shape's size adds to errors of rays that end there.
    pub(crate) tilt: f64,
}

/// Runs an expression on an analytic shape with an area; `None` for planes and meshes.
macro_rules! with_spread {
    ($table:expr, $shape:expr, $row:ident => $body:expr) => {{
        let (table, row) = ($table, $shape.row as usize);
        match $shape.kind {
            ShapeKind::Sphere => Some({
                let $row = &table.spheres[row];
                $body
            }),
            ShapeKind::Quad => Some({
                let $row = &table.quads[row];
                $body
            }),
            ShapeKind::Disk => Some({
                let $row = &table.disks[row];
                $body
            }),
            ShapeKind::Cuboid => Some({
                let $row = &table.cuboids[row];
                $body
            }),
            ShapeKind::Cylinder => Some({
                let $row = &table.cylinders[row];
                $body
            }),
            ShapeKind::Cone => Some({
                let $row = &table.cones[row];
                $body
            }),
            ShapeKind::Torus => Some({
                let $row = &table.tori[row];
                $body
            }),
            ShapeKind::Plane | ShapeKind::Mesh => None,
        }
    }};
}

impl ShapeTable {
    /// The area of an analytic shape in object space; none of a plane without end, and of a mesh, which has one for each
    /// triangle.
    pub fn area(&self, shape: ShapeRef) -> Option<f64> {
        with_spread!(self, shape, row => row.area())
    }

    /// A point spread evenly over the area of an analytic shape by two numbers 0 ≤ u < 1; none where [`ShapeTable::area`] is
    /// none.
    #[inline]
    pub fn sample_area(&self, shape: ShapeRef, u: [f32; 2]) -> Option<AreaSample> {
        with_spread!(self, shape, row => AreaSample::on(row, row.spread(u)))
    }
}

impl AreaSample {
    /// The point of an analytic shape, as [`Spread::spread`] gives it.
    #[inline]
    pub fn on<T: Analytic>(shape: &T, (point, primitive): (DVec3, u32)) -> AreaSample {
        let tilt = f64::from(shape.bounds().reach()) * (4.0 * HALF_ULP);
        AreaSample { local: shape.surface(point, primitive, DVec3::ZERO), primitive, tilt }
    }
}

/// What all points of a triangle have in common, in object space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Face {
    /// Unit normal; some unit vector where the triangle has no area.
    pub normal: DVec3,
    /// The area.
    pub area: f64,
    tilt: f64,
}

impl TriangleMesh {
    /// The face of a triangle.
    pub fn face(&self, triangle: usize) -> Face {
        let [a, b, c] = self.corners(triangle).map(|corner| corner.as_dvec3());
        let cross = (b - a).cross(c - a);
        let twice_area = cross.length();
        let recip = twice_area.recip();
        let normal = if recip.is_finite() { cross * recip } else { DVec3::Y };
        let extent = [b - a, c - b, a - c].iter().fold(0.0f64, |most, side| most.max(side.length_squared())).sqrt();
        Face { normal, area: 0.5 * twice_area, tilt: tilt_of_triangle(extent) }
    }

    /// A point spread evenly over a triangle, whose face is given, by two numbers 0 ≤ u < 1.
    #[inline]
    pub fn sample_area(&self, triangle: usize, face: &Face, u: [f32; 2]) -> AreaSample {
        let [a, b, c] = self.corners(triangle).map(|corner| corner.as_dvec3());
        // E. Heitz, "A Low-Distortion Map Between Triangle and Square", 2019.
        let (x, y) = (0.5 * f64::from(u[0]), 0.5 * f64::from(u[1]));
        let (v, w) = if y > x { (x, y + (y - x)) } else { (x + (x - y), y) };
        let weights = [1.0 - v - w, v, w];
        let uv = if self.uvs.is_empty() {
            Vec2::ZERO
        } else {
            let corners = self.triangles[triangle];
            (0..3).fold(Vec2::ZERO, |sum, i| sum + self.uvs[corners[i] as usize] * weights[i] as f32)
        };
        let local = LocalSurface { point: a * weights[0] + b * weights[1] + c * weights[2], normal: face.normal, uv };
        AreaSample { local, primitive: triangle as u32, tilt: face.tilt }
    }
}

/// How many times larger the area of a small piece of surface is in world space than in object space, by its unit normal in
/// world space: |det M| / |Mᵀn|, which is |det M| |M⁻ᵀn'| with the normal n' in object space.
#[inline(always)]
pub fn area_scale(object_to_world: &Affine, normal: Vec3) -> f64 {
    let linear = object_to_world.to_f64().0;
    linear.determinant().abs() / object_to_world.transposed_f64(normal.as_dvec3()).length()
}

/// A drawn point in world space, to be looked at from `viewer`.
///
/// Its error bounds more than that of a point that was hit: also what is rounded on a ray from about `viewer`. So a ray that
/// ends at [`offset_origin`](crate::offset_origin) toward the viewer does not meet this surface before, unless the shape
/// bends or folds into its way.
#[inline(always)]
pub fn seen_from(
    viewer: Vec3,
    object_to_world: &Affine,
    world_to_object: &Affine,
    sample: &AreaSample,
) -> SurfacePoint {
    let mut point = place_sample(object_to_world, world_to_object, &sample.local, sample.tilt);
    let origin = world_to_object.point_f64(viewer.as_dvec3());
    let local = &sample.local;
    // Origin and direction are rounded when they are mapped, and a triangle's corners when they are sheared: ten units.
    let reach = origin.abs() + (local.point - origin).abs();
    let steepness = world_to_object.transposed_f64(local.normal).length();
    let along = local.normal.abs().dot(reach) * (16.0 * HALF_ULP) / steepness;
    // In world space direction and length are rounded.
    let aim = f64::from((point.position - viewer).length()) * (4.0 * HALF_ULP);
    point.error += (along + aim) as f32;
    point
}
