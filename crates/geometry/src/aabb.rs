//! Boxes along the axes.

use glam::{DVec3, Vec3};

/// A box along the axes. An empty one has `min` = +∞ and `max` = -∞.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// The least coordinates.
    pub min: Vec3,
    /// The greatest coordinates.
    pub max: Vec3,
}

impl Aabb {
    /// The box of nothing.
    pub const EMPTY: Aabb = Aabb { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    /// The box from -half to +half.
    pub fn centered(half: Vec3) -> Aabb {
        Aabb { min: -half, max: half }
    }

    /// The smallest box around the points.
    pub fn around(points: impl IntoIterator<Item = Vec3>) -> Aabb {
        points.into_iter().fold(Aabb::EMPTY, |aabb, point| aabb.union(&Aabb { min: point, max: point }))
    }

    /// The smallest box around both.
    #[inline(always)]
    pub fn union(&self, other: &Aabb) -> Aabb {
        Aabb { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Whether no point is inside.
    pub fn is_empty(&self) -> bool {
        !self.min.cmple(self.max).all()
    }

    /// Whether the other box lies inside this one.
    pub fn contains(&self, other: &Aabb) -> bool {
        other.is_empty() || self.min.cmple(other.min).all() && self.max.cmpge(other.max).all()
    }

    /// The largest absolute coordinate; 0 of an empty box.
    pub fn reach(&self) -> f32 {
        if self.is_empty() { 0.0 } else { self.min.abs().max(self.max.abs()).max_element() }
    }

    /// The box, larger by `pad` on every side.
    pub fn padded(&self, pad: f32) -> Aabb {
        Aabb { min: self.min - pad, max: self.max + pad }
    }

    /// Half the surface's area; 0 of an empty box.
    #[inline(always)]
    pub fn half_area(&self) -> f32 {
        let size = (self.max - self.min).max(Vec3::ZERO);
        size.x * size.y + size.y * size.z + size.z * size.x
    }

    /// The eight corners.
    pub fn corners(&self) -> [Vec3; 8] {
        let pick = |high: usize, axis: usize| if high & (1 << axis) != 0 { self.max[axis] } else { self.min[axis] };
        std::array::from_fn(|i| Vec3::new(pick(i, 0), pick(i, 1), pick(i, 2)))
    }

    /// The smallest box in f32 around one in f64.
    #[inline]
    pub fn outward(min: DVec3, max: DVec3) -> Aabb {
        let down = |x: f64| if (x as f32) as f64 > x { (x as f32).next_down() } else { x as f32 };
        let up = |x: f64| if ((x as f32) as f64) < x { (x as f32).next_up() } else { x as f32 };
        Aabb { min: Vec3::from_array(min.to_array().map(down)), max: Vec3::from_array(max.to_array().map(up)) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outward_never_loses_a_point() {
        for x in [0.1f64, -0.1, 1.0 / 3.0, 1e-46, -1e-46, 16_777_217.0, 0.0] {
            let aabb = Aabb::outward(DVec3::splat(x), DVec3::splat(x));
            assert!(aabb.min.x as f64 <= x && aabb.max.x as f64 >= x, "{x} {aabb:?}");
            assert!(aabb.max.x <= aabb.min.x.next_up(), "{x} {aabb:?}");
        }
    }

    #[test]
    fn nothing_is_empty_and_neutral() {
        let unit = Aabb::centered(Vec3::ONE);
        assert!(Aabb::EMPTY.is_empty() && !unit.is_empty());
        assert_eq!(Aabb::EMPTY.union(&unit), unit);
        assert_eq!((Aabb::EMPTY.reach(), Aabb::EMPTY.half_area()), (0.0, 0.0));
        // A cube of side 2: six faces of 4, half of that.
        assert_eq!(unit.half_area(), 12.0);
        assert_eq!(Aabb::around(unit.corners()), unit);
    }
}
