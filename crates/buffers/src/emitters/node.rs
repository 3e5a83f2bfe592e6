//! A node of a tree over light sources, and what may come from it to a point.

use std::f32::consts::PI;

use brewster_geometry::Aabb;
use brewster_lanes::math;
use glam::Vec3;

use super::cone::Cone;

/// What a tree knows about one source, or about many.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LightBounds {
    /// Around the source.
    pub(super) bounds: Aabb,
    /// Around its normals.
    pub(super) normals: Cone,
    /// How far from its normals it shines, in radians.
    pub(super) emission: f32,
    /// Luminous intensity in candela where it is greatest, or about that.
    pub(super) intensity: f64,
}

impl LightBounds {
    pub(super) fn union(&self, other: &LightBounds) -> LightBounds {
        LightBounds {
            bounds: self.bounds.union(&other.bounds),
            normals: self.normals.union(&other.normals),
            emission: self.emission.max(other.emission),
            intensity: self.intensity + other.intensity,
        }
    }

    /// What a node costs that holds these: the orientation heuristic of the paper, with the diagonal for the surface, so that
    /// sources in a plane or a row have a size.
    pub(super) fn cost(&self) -> f64 {
        let diagonal = (self.bounds.max - self.bounds.min).as_dvec3().length_squared();
        self.intensity * diagonal * f64::from(self.normals.measure(self.emission))
    }

    pub(super) fn center(&self) -> Vec3 {
        self.bounds.min * 0.5 + self.bounds.max * 0.5
    }
}

/// A node as a point sees it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Node {
    center: Vec3,
    /// The square of half the box's diagonal.
    squared_radius: f32,
    axis: Vec3,
    /// Of the cone of normals; -1 if it is every direction.
    cosine: f32,
    sine: f32,
    /// Of the angle beyond the cone at which it is dark.
    emission_cosine: f32,
    /// As a part of all.
    intensity: f32,
    /// The first of its two children, or with [`LEAF`] the source, or the block.
    pub(super) child: u32,
}

/// Marks a node of one source.
pub(super) const LEAF: u32 = 1 << 31;

/// Angles are widened by this cosine before a node counts as dark: more than rounding makes of them.
const SLACK: f32 = 1e-3;

impl Node {
    pub(super) fn new(of: &LightBounds, total: f64, child: u32) -> Node {
        let half = (of.bounds.max - of.bounds.min).as_dvec3() * 0.5;
        let (sine, cosine) = math::sin_cos(of.normals.angle);
        Node {
            center: of.center(),
            squared_radius: (half.length_squared() * (1.0 + 1e-5)) as f32,
            axis: of.normals.axis,
            cosine: if of.normals.angle >= PI { -1.0 } else { cosine },
            sine,
            emission_cosine: math::cos(of.emission.min(PI)),
            intensity: (of.intensity / total) as f32,
            child,
        }
    }

    /// What may come from the node to a point.
    #[inline(always)]
    pub(super) fn importance(&self, point: Vec3) -> f32 {
        let from = point - self.center;
        let squared = from.length_squared();
        let mut cosine = 1.0;
        if self.cosine > -1.0 && squared > self.squared_radius {
            let to_normals = self.axis.dot(from) / squared.sqrt();
            let sine = (1.0 - to_normals * to_normals).max(0.0).sqrt();
            let beyond = less([to_normals, sine], [self.cosine, self.sine]);
            let seen = self.squared_radius / squared;
            cosine = less(beyond, [(1.0 - seen).max(0.0).sqrt(), seen.sqrt()])[0];
            if cosine < self.emission_cosine - SLACK {
                return 0.0;
            }
            cosine = cosine.max(SLACK);
        }
        (self.intensity * cosine / squared.max(WITHIN * self.squared_radius).max(NEAREST)).min(GREATEST)
    }
}

/// A point counts as no nearer to a node than half the radius of its ball.
///
/// Relative variances of one sample over a floor, for factors of 1, ½, ¼ and ⅛: under 300 lamps spread evenly 3.4, 1.6, 1.1
/// and 1.0; under eight clusters of them 0.72, 0.68, 0.77 and 0.91.
const WITHIN: f32 = 0.25;

/// No squared distance counts as less.
const NEAREST: f32 = 1e-30;

/// No importance counts as more: two of them can be added.
const GREATEST: f32 = 1e37;

/// The cosine and sine of one angle less another one, at least of 0; both between 0 and π.
#[inline(always)]
fn less([cosine, sine]: [f32; 2], [other_cosine, other_sine]: [f32; 2]) -> [f32; 2] {
    if cosine >= other_cosine {
        [1.0, 0.0]
    } else {
        [cosine * other_cosine + sine * other_sine, sine * other_cosine - cosine * other_sine]
    }
}

#[cfg(test)]
mod tests {
    use std::f32::consts::FRAC_PI_2;

    use super::*;

    /// Worked out by hand for a panel of 2 by 2 m that faces down, 4 m above and 3 m aside: 5 m away, seen under the cosine 0.8
    /// less the angle of its ball, whose sine is √2/5.
    #[test]
    fn importance_is_that_of_the_paper() {
        let panel = LightBounds {
            bounds: Aabb { min: Vec3::new(-1.0, 0.0, -1.0), max: Vec3::new(1.0, 0.0, 1.0) },
            normals: Cone::along(Vec3::NEG_Y),
            emission: FRAC_PI_2,
            intensity: 4.0,
        };
        let node = Node::new(&panel, 8.0, 0);
        let (sine, cosine) = (2f32.sqrt() / 5.0, (1.0f32 - 2.0 / 25.0).sqrt());
        let expected = 0.5 * (0.8 * cosine + 0.6 * sine) / 25.0;
        let found = node.importance(Vec3::new(3.0, -4.0, 0.0));
        assert!((found / expected - 1.0).abs() < 1e-4, "{found}, {expected}");
        // From behind it is dark, unless the ball is so near that some of it may be seen; inside, it
        // counts as half its radius away.
        assert_eq!(node.importance(Vec3::new(0.0, 50.0, 1.0)), 0.0);
        assert!(node.importance(Vec3::new(1.4, 0.1, 0.0)) > 0.0);
        assert!((node.importance(Vec3::ZERO) - 1.0).abs() < 1e-4);
    }
}
