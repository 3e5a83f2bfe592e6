//! Triangles, watertight: no line slips between two that share an edge.
//!
//! After Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection" (JCGT 2013): the corners are moved so that the ray
//! starts at the origin, and sheared along its largest direction until it is the z axis. What remains is whether the origin
//! lies inside a triangle of the plane: three products of corners, one for each edge.
//!
//! - A corner is sheared to the same place for every triangle that has it. The sign of an edge's product is never wrong, since
//!   rounding is monotone: `a·b - c·d` in f32 may come out as zero, but not on the other side of it. So a filter in f32 that
//!   lets zeros pass loses nothing. Nothing may be fused: `fma(a, b, -c·d)` is not the negative of `fma(c, d, -a·b)`.
//! - What passes is decided in f64, where the products are exact and their difference has the right sign, zero included.
//!   Both triangles of an edge count the edge as theirs, so nothing gets through; the order of hits decides between them.
//! - Shearing moves a corner by at most six half units of f32's precision, relative to the largest distance along an axis
//!   between origin and corner. The distance is a convex combination of the corners' and is off by no more, however thin
//!   the triangle is. Where the weights themselves are uncertain, it is kept in the interval of the triangle's box.

use glam::{DVec3, Vec3};

use crate::aabb::Aabb;
use crate::ray::Ray;
use crate::shape::{LocalHit, interval};
use crate::tree::node::Patch;

/// A ray, prepared for the triangles of one object space.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C)]
pub(crate) struct Shear {
    /// The ray's origin.
    pub(crate) origin: [f32; 3],
    /// The ray's direction.
    pub(crate) direction: [f32; 3],
    /// The axes in turn, the one of the largest direction last.
    pub(crate) axes: [u32; 3],
    /// How much x and y move for a step along z.
    pub(crate) slope: [f32; 2],
}

impl Shear {
    #[inline(always)]
    pub(crate) fn new(ray: &Ray) -> Shear {
        let (origin, direction) = (ray.origin.to_array(), ray.direction.to_array());
        let [x, y, z] = direction.map(f32::abs);
        let largest = if z >= x && z >= y { 2 } else { (y > x) as usize };
        let axes = [[1, 2, 0], [2, 0, 1], [0, 1, 2]][largest];
        let [kx, ky, kz] = axes.map(|axis| axis as usize);
        let slope = [direction[kx] / direction[kz], direction[ky] / direction[kz]];
        Shear { origin, direction, axes, slope }
    }

    /// A corner in the sheared space: x, y, and z in units of the object space.
    #[inline(always)]
    pub(crate) fn corner(&self, corner: Vec3) -> [f32; 3] {
        let [kx, ky, kz] = self.axes.map(|axis| axis as usize);
        let z = corner[kz] - self.origin[kz];
        let x = corner[kx] - self.origin[kx] - self.slope[0] * z;
        let y = corner[ky] - self.origin[ky] - self.slope[1] * z;
        [x, y, z]
    }

    /// The hit of a triangle whose corners are given sheared, and as they are if need be.
    #[inline(always)]
    pub(crate) fn finish(&self, [a, b, c]: [[f64; 3]; 3], corners: impl FnOnce() -> [Vec3; 3]) -> Option<LocalHit> {
        let u = c[0] * b[1] - c[1] * b[0];
        let v = a[0] * c[1] - a[1] * c[0];
        let w = b[0] * a[1] - b[1] * a[0];
        let outside = (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0);
        let determinant = u + v + w;
        if outside || determinant == 0.0 {
            return None;
        }
        let mut t = (u * a[2] + v * b[2] + w * c[2]) / (determinant * self.direction[self.axes[2] as usize] as f64);
        let extent_x = a[0].abs().max(b[0].abs()).max(c[0].abs());
        let extent = a[1].abs().max(b[1].abs()).max(c[1].abs()).max(extent_x);
        // The weights are off by 2⁻⁵³·6·extent² / determinant; below this bound that is less than 2⁻²⁵.
        if determinant.abs() < extent * extent * (1.0 / (1u32 << 25) as f64) {
            t = self.bounded(corners(), t);
        }
        let t = t as f32;
        let hit = LocalHit { t, u: (v / determinant) as f32, v: (w / determinant) as f32, primitive: 0 };
        (t > 0.0 && t.is_finite()).then_some(hit)
    }

    /// The hit of a triangle of a patch, whose vertices are given sheared.
    #[inline(always)]
    pub(crate) fn finish_lane(&self, patch: &Patch, triangle: usize, sheared: &[[f32; 8]; 3]) -> Option<LocalHit> {
        let at = |corner: usize| {
            let vertex = patch.corners[corner][triangle & 7] as usize & 7;
            [sheared[0][vertex] as f64, sheared[1][vertex] as f64, sheared[2][vertex] as f64]
        };
        self.finish([at(0), at(1), at(2)], || [0, 1, 2].map(|corner| patch.corner(triangle, corner)))
    }

    /// A distance, kept in the interval of the triangle's box.
    #[cold]
    fn bounded(&self, corners: [Vec3; 3], t: f64) -> f64 {
        let origin = DVec3::from_array(self.origin.map(f64::from));
        let direction = DVec3::from_array(self.direction.map(f64::from));
        let (near, far) = interval(&Aabb::around(corners), origin, direction);
        t.max(near).min(far)
    }
}

/// The hit of a ray with a triangle, seen from either side, with t > 0: the routine whose result every kernel gives.
pub fn intersect_triangle(ray: &Ray, corners: [Vec3; 3]) -> Option<LocalHit> {
    let shear = Shear::new(ray);
    shear.finish(corners.map(|corner| shear.corner(corner).map(f64::from)), || corners)
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [Vec3; 3] = [Vec3::new(0.0, 0.0, 0.0), Vec3::new(4.0, 0.0, 0.0), Vec3::new(0.0, 4.0, 0.0)];

    /// Weights by hand.
    #[test]
    fn hits_have_their_weights() {
        for (x, y, u, v) in [(1.0, 1.0, 0.25, 0.25), (0.0, 0.0, 0.0, 0.0), (4.0, 0.0, 1.0, 0.0), (2.0, 2.0, 0.5, 0.5)] {
            for z in [3.0, -3.0] {
                let ray =
                    Ray { origin: Vec3::new(x, y, z), direction: Vec3::new(0.0, 0.0, -0.5 * z.signum()), time: 0.0 };
                let hit = intersect_triangle(&ray, CORNERS);
                assert_eq!(hit, Some(LocalHit { t: 6.0, u, v, primitive: 0 }), "{x} {y}");
            }
        }
        let beside = Ray { origin: Vec3::new(2.001, 2.0, 1.0), direction: Vec3::NEG_Z, time: 0.0 };
        assert_eq!(intersect_triangle(&beside, CORNERS), None);
        let behind = Ray { origin: Vec3::new(1.0, 1.0, 1.0), direction: Vec3::Z, time: 0.0 };
        assert_eq!(intersect_triangle(&behind, CORNERS), None);
        let within = Ray { origin: Vec3::new(-1.0, 1.0, 0.0), direction: Vec3::X, time: 0.0 };
        assert_eq!(intersect_triangle(&within, CORNERS), None);
    }

    /// Bad numbers miss; they do not panic.
    #[test]
    fn bad_rays_miss() {
        for bad in [f32::NAN, f32::INFINITY] {
            let lost = Ray { origin: Vec3::splat(bad), direction: Vec3::Z, time: 0.0 };
            assert_eq!(intersect_triangle(&lost, CORNERS), None);
            let aimless = Ray { origin: Vec3::new(1.0, 1.0, 3.0), direction: Vec3::splat(bad), time: 0.0 };
            assert_eq!(intersect_triangle(&aimless, CORNERS), None);
        }
        let still = Ray { origin: Vec3::new(1.0, 1.0, 3.0), direction: Vec3::ZERO, time: 0.0 };
        assert_eq!(intersect_triangle(&still, CORNERS), None);
    }
}
