//! A ray against eight boxes.
//!
//! Why no box loses a hit, in units of f32's half precision (ε = 2⁻²⁴) and relative to `reach`, the largest distance along an
//! axis between the ray's origin and anything in the tree:
//!
//! - A hit's point o + t·d lies in the primitive's box but for ten units (`shape::SLACK`).
//! - t is rounded: one unit. `plane·inverse - origin·inverse` is off by one unit for the inverse, one for each product and one
//!   for the difference (one product less where they are fused), and the origin, moved by the pad, by one more: five.
//! - So boxes grown by sixteen units hold every hit: near ≤ t ≤ far in the numbers as they come out. Twenty are used.
//! - A direction is kept away from zero by 2⁻⁴⁰ of its largest coordinate. A box it leaves by this error it left by the pad
//!   before: |t·d| is at most reach, so the error is 2⁻⁴⁰ of it.
//! - A parent's planes lie outside its children's, and everything above is monotone in the planes.
//!
//! A box is kept while near ≤ the best t so far, equality included: a hit of the same t may have the lower number.

use glam::Vec3A;

use crate::ray::Ray;
use crate::tree::node::Node;

/// The growth of boxes, relative to the reach.
pub(crate) const PAD: f32 = 20.0 / (1 << 24) as f32;

/// The least part of a direction, relative to its largest coordinate.
pub(crate) const LEAST: f32 = 1.0 / (1u64 << 40) as f32;

/// A ray, prepared for the boxes of one tree.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C)]
pub(crate) struct Slabs {
    /// One over the direction.
    pub(crate) inverse: [f32; 3],
    /// Origin times inverse, with the origin moved so that near planes come nearer.
    pub(crate) near: [f32; 3],
    /// The same for far planes.
    pub(crate) far: [f32; 3],
    /// By axis the column of [`Node::planes`] that is nearer.
    pub(crate) near_plane: [u32; 3],
}

impl Slabs {
    /// `reach` is the largest absolute coordinate of any box, `slack` an absolute growth of boxes beyond the usual. None for a ray
    /// that is infinite or has no direction, for which box tests would not see numbers: it meets nothing.
    #[inline(always)]
    pub(crate) fn new(ray: &Ray, reach: f32, slack: f32) -> Option<Slabs> {
        let (origin, direction) = (Vec3A::from(ray.origin), Vec3A::from(ray.direction));
        let pad = (origin.abs().max_element() + reach) * PAD + slack;
        let largest = direction.abs().max_element();
        let least = Vec3A::splat(largest * LEAST);
        let is_small = direction.abs().cmplt(least);
        let inverse = Vec3A::select(is_small, least.copysign(direction), direction).recip();
        let pad = Vec3A::splat(pad).copysign(direction);
        let signs = direction.is_negative_bitmask();
        let (near, far) = ((origin + pad) * inverse, (origin - pad) * inverse);
        let are_numbers = (inverse.abs() + near.abs() + far.abs()).cmplt(Vec3A::INFINITY).all();
        let slabs = Slabs {
            inverse: inverse.to_array(),
            near: near.to_array(),
            far: far.to_array(),
            near_plane: [signs & 1, 2 + (signs >> 1 & 1), 4 + (signs >> 2 & 1)],
        };
        (are_numbers && largest < f32::INFINITY).then_some(slabs)
    }

    /// Where the ray enters the eight boxes, and a bit for each that it meets before `limit`.
    #[inline(always)]
    pub(crate) fn test(&self, node: &Node, limit: f32) -> ([f32; 8], u32) {
        let (mut enter, mut leave) = ([0.0f32; 8], [limit; 8]);
        for axis in 0..3 {
            let near_plane = self.near_plane[axis] as usize;
            let (near, far) = (&node.planes[near_plane], &node.planes[near_plane ^ 1]);
            for i in 0..8 {
                let (a, b) =
                    (near[i] * self.inverse[axis] - self.near[axis], far[i] * self.inverse[axis] - self.far[axis]);
                enter[i] = if a > enter[i] { a } else { enter[i] };
                leave[i] = if b < leave[i] { b } else { leave[i] };
            }
        }
        let mut mask = 0;
        for i in 0..8 {
            mask |= ((enter[i] <= leave[i]) as u32) << i;
        }
        (enter, mask)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    /// Places that are not used are met by no ray.
    #[test]
    fn nothing_is_in_an_empty_node() {
        for direction in [Vec3::X, Vec3::NEG_Y, Vec3::new(0.6, -0.8, 0.0), Vec3::new(-0.0, 0.0, -1.0)] {
            for origin in [Vec3::ZERO, Vec3::new(-3.0, 1e9, 0.5)] {
                let slabs = Slabs::new(&Ray { origin, direction, time: 0.0 }, 0.0, 0.0).expect("it is usable");
                assert_eq!(slabs.test(&Node::EMPTY, f32::INFINITY), ([f32::INFINITY; 8], 0), "{direction} {origin}");
            }
        }
        for bad in [f32::NAN, f32::INFINITY, 0.0] {
            let slabs = Slabs::new(&Ray { origin: Vec3::ONE, direction: Vec3::splat(bad), time: 0.0 }, 1.0, 0.0);
            assert!(slabs.is_none(), "{bad} {slabs:?}");
        }
    }
}
