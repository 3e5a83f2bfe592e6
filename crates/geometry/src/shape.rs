//! What all shapes have in common, and the table of those a scene uses.

use std::sync::Arc;

use glam::{DVec3, Vec2};

use crate::aabb::Aabb;
use crate::mesh::TriangleMesh;
use crate::ray::Ray;
use crate::{Cone, Cuboid, Cylinder, Disk, Plane, Quad, Sphere, Torus};

/// A shape that is intersected by solving its equation.
///
/// The equations are solved in f64 on a ray in f32, so what is rounded is the ray and the distance and nothing between.
pub trait Analytic: Copy + PartialEq {
    /// Whether lengths are finite, positive and in order.
    fn validate(&self) -> Result<(), ShapeError>;

    /// The smallest box around it.
    fn bounds(&self) -> Aabb;

    /// Whether it is the surface of a volume.
    fn is_closed(&self) -> bool;

    /// The nearest crossing with t > 0.
    fn crossing(&self, origin: DVec3, direction: DVec3) -> Option<Crossing>;

    /// The surface at a point that lies on it but for rounding, with the point moved onto it. On a face with edges the point
    /// keeps `margin` away from them, given by axis, so that stepping through the face by less does not step past its
    /// neighbor.
    fn surface(&self, point: DVec3, face: u32, margin: DVec3) -> LocalSurface;

    /// The gradients of both texture coordinates along the surface at a point on it; not finite where they have none.
    fn uv_gradients(&self, point: DVec3, face: u32) -> [DVec3; 2];

    /// The nearest hit with t > 0 of a ray in object space.
    ///
    /// t is kept in the interval that the ray spends in the shape's box, grown by a bound on rounding:
    /// what box tests rely on.
    #[inline(always)]
    fn intersect(&self, ray: &Ray) -> Option<LocalHit> {
        let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
        let Crossing { t, face } = self.crossing(origin, direction)?;
        let (near, far) = interval(&self.bounds(), origin, direction);
        let t = t.max(near).min(far) as f32;
        (t > 0.0 && t.is_finite()).then_some(LocalHit { t, u: 0.0, v: 0.0, primitive: face })
    }
}

/// Where a line crosses a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// Distance in lengths of the direction.
    pub t: f64,
    /// Which face of the shape.
    pub face: u32,
}

/// A hit in object space; the fields are those of [`Hit`](crate::Hit).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalHit {
    /// Distance in lengths of the ray's direction.
    pub t: f32,
    /// Weight of a triangle's second corner; 0 on other shapes.
    pub u: f32,
    /// Weight of a triangle's third corner; 0 on other shapes.
    pub v: f32,
    /// The triangle or the face.
    pub primitive: u32,
}

/// A surface in object space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalSurface {
    /// The point on it.
    pub point: DVec3,
    /// Unit normal, outward on a closed shape.
    pub normal: DVec3,
    /// Texture coordinates.
    pub uv: Vec2,
}

/// How far the intersection of a ray may lie outside an object's box: ten units of f32's half precision (2⁻²⁴), relative to
/// the largest distance along an axis between the ray's origin and the box.
///
/// A triangle's corners move by at most six such units when they are sheared (see `triangle`), its distance is off by two
/// more, and two are to spare.
pub(crate) const SLACK: f64 = 10.0 / (1 << 24) as f64;

/// The part of a line in a box that is grown by [`SLACK`]. Empty intervals come out reversed.
#[inline(always)]
pub(crate) fn interval(bounds: &Aabb, origin: DVec3, direction: DVec3) -> (f64, f64) {
    let (low, high) = (bounds.min.as_dvec3() - origin, bounds.max.as_dvec3() - origin);
    let slack = low.abs().max(high.abs()).max_element() * SLACK;
    let (mut near, mut far) = (f64::NEG_INFINITY, f64::INFINITY);
    // An infinite plane's box reaches from -∞ to +∞ and bounds nothing.
    if slack.is_finite() {
        for axis in 0..3 {
            if direction[axis] != 0.0 {
                let (a, b) = ((low[axis] - slack) / direction[axis], (high[axis] + slack) / direction[axis]);
                near = near.max(a.min(b));
                far = far.min(a.max(b));
            }
        }
    }
    (near, far)
}

/// A length that makes no shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapeError {
    /// The parameter, as its field is called.
    pub parameter: &'static str,
    /// Its value.
    pub value: f32,
    /// What it has to be.
    pub expected: &'static str,
}

impl std::fmt::Display for ShapeError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} is {}, but must be {}", self.parameter, self.value, self.expected)
    }
}

impl std::error::Error for ShapeError {}

/// Lengths from here on are not a scene any more and would overflow the areas that trees compare.
pub(crate) const LARGEST_LENGTH: f32 = 1e15;

/// A length has to be positive and at most 10¹⁵ m.
pub(crate) fn check_length(parameter: &'static str, value: f32) -> Result<(), ShapeError> {
    if value > 0.0 && value <= LARGEST_LENGTH {
        Ok(())
    } else {
        Err(ShapeError { parameter, value, expected: "positive and at most 1e15" })
    }
}

/// The kinds of shapes; each has its column in [`ShapeTable`].
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum ShapeKind {
    /// [`Sphere`]
    Sphere,
    /// [`Plane`]
    Plane,
    /// [`Quad`]
    Quad,
    /// [`Disk`]
    Disk,
    /// [`Cuboid`]
    Cuboid,
    /// [`Cylinder`]
    Cylinder,
    /// [`Cone`]
    Cone,
    /// [`Torus`]
    Torus,
    /// [`TriangleMesh`]
    Mesh,
}

impl ShapeKind {
    /// Every kind.
    pub const ALL: [ShapeKind; 9] = [
        ShapeKind::Sphere,
        ShapeKind::Plane,
        ShapeKind::Quad,
        ShapeKind::Disk,
        ShapeKind::Cuboid,
        ShapeKind::Cylinder,
        ShapeKind::Cone,
        ShapeKind::Torus,
        ShapeKind::Mesh,
    ];
}

/// A shape: its kind, and its row among those of that kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ShapeRef {
    /// The kind.
    pub kind: ShapeKind,
    /// The row in the kind's column.
    pub row: u32,
}

/// The shapes of a scene, a column for each kind. One writer; rows hold until it rewrites them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ShapeTable {
    /// Spheres.
    pub spheres: Vec<Sphere>,
    /// Planes without end.
    pub planes: Vec<Plane>,
    /// Rectangles.
    pub quads: Vec<Quad>,
    /// Disks.
    pub disks: Vec<Disk>,
    /// Boxes.
    pub cuboids: Vec<Cuboid>,
    /// Cylinders.
    pub cylinders: Vec<Cylinder>,
    /// Cones.
    pub cones: Vec<Cone>,
    /// Tori.
    pub tori: Vec<Torus>,
    /// Triangle meshes; the scene's mesh trees are in the same order.
    pub meshes: Vec<Arc<TriangleMesh>>,
}

/// Runs an expression on the row of an analytic shape, or another one on the row number of a mesh.
macro_rules! with_shape {
    ($table:expr, $shape:expr, $analytic:ident => $body:expr, $mesh:ident => $mesh_body:expr) => {{
        let (table, row): (&$crate::ShapeTable, usize) = ($table, $shape.row as usize);
        match $shape.kind {
            $crate::ShapeKind::Sphere => {
                let $analytic = &table.spheres[row];
                $body
            }
            $crate::ShapeKind::Plane => {
                let $analytic = &table.planes[row];
                $body
            }
            $crate::ShapeKind::Quad => {
                let $analytic = &table.quads[row];
                $body
            }
            $crate::ShapeKind::Disk => {
                let $analytic = &table.disks[row];
                $body
            }
            $crate::ShapeKind::Cuboid => {
                let $analytic = &table.cuboids[row];
                $body
            }
            $crate::ShapeKind::Cylinder => {
                let $analytic = &table.cylinders[row];
                $body
            }
            $crate::ShapeKind::Cone => {
                let $analytic = &table.cones[row];
                $body
            }
            $crate::ShapeKind::Torus => {
                let $analytic = &table.tori[row];
                $body
            }
            $crate::ShapeKind::Mesh => {
                let $mesh = row;
                $mesh_body
            }
        }
    }};
}
pub(crate) use with_shape;

impl ShapeTable {
    /// The number of shapes of a kind.
    pub fn len(&self, kind: ShapeKind) -> usize {
        match kind {
            ShapeKind::Sphere => self.spheres.len(),
            ShapeKind::Plane => self.planes.len(),
            ShapeKind::Quad => self.quads.len(),
            ShapeKind::Disk => self.disks.len(),
            ShapeKind::Cuboid => self.cuboids.len(),
            ShapeKind::Cylinder => self.cylinders.len(),
            ShapeKind::Cone => self.cones.len(),
            ShapeKind::Torus => self.tori.len(),
            ShapeKind::Mesh => self.meshes.len(),
        }
    }

    /// Whether there is no shape of any kind.
    pub fn is_empty(&self) -> bool {
        ShapeKind::ALL.iter().all(|&kind| self.len(kind) == 0)
    }

    /// Whether a shape is the surface of a volume. Looks at every edge of a mesh: O(n log n).
    pub fn is_closed(&self, shape: ShapeRef) -> bool {
        with_shape!(self, shape, analytic => analytic.is_closed(), mesh => self.meshes[mesh].is_closed())
    }

    /// The smallest box around a shape. Looks at every vertex of a mesh.
    pub fn bounds(&self, shape: ShapeRef) -> Aabb {
        with_shape!(self, shape, analytic => analytic.bounds(), mesh => self.meshes[mesh].bounds())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn kinds_are_numbered_in_order() {
        for (i, kind) in ShapeKind::ALL.into_iter().enumerate() {
            assert_eq!(kind as usize, i);
        }
        assert!(ShapeTable::default().is_empty());
    }

    /// A line along x through the unit cube; then one that is parallel to it.
    #[test]
    fn intervals_are_a_little_larger_than_the_box() {
        let cube = Aabb::centered(Vec3::ONE);
        let (near, far) = interval(&cube, DVec3::new(-3.0, 0.5, 0.5), DVec3::X);
        assert!(near < 2.0 && near > 1.99999 && far > 4.0 && far < 4.00001);
        let (near, far) = interval(&cube, DVec3::ZERO, DVec3::Y * 2.0);
        assert!(near < -0.5 && far > 0.5 && far < 0.50001);
    }
}
