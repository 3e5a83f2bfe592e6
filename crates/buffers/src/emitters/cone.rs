//! Cones of directions: where the normals of light sources point.

use std::f32::consts::{FRAC_PI_2, PI, TAU};

use brewster_lanes::math;
use glam::Vec3;

/// All directions within an angle of an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Cone {
    /// Unit axis.
    pub(super) axis: Vec3,
    /// Half the opening in radians, up to π.
    pub(super) angle: f32,
}

impl Cone {
    /// Every direction.
    pub(super) const SPHERE: Cone = Cone { axis: Vec3::Y, angle: PI };

    /// One direction.
    pub(super) fn along(axis: Vec3) -> Cone {
        Cone { axis, angle: 0.0 }
    }

    /// A small cone around both.
    pub(super) fn union(&self, other: &Cone) -> Cone {
        let (wide, thin) = if self.angle >= other.angle { (self, other) } else { (other, self) };
        if wide.angle >= PI {
            return Cone::SPHERE;
        }
        let between = math::acos(wide.axis.dot(thin.axis).clamp(-1.0, 1.0));
        if (between + thin.angle).min(PI) <= wide.angle {
            return *wide;
        }
        let angle = 0.5 * (wide.angle + between + thin.angle);
        // The axis is turned from that of the wider cone toward the other.
        let across = thin.axis - wide.axis * wide.axis.dot(thin.axis);
        let length = across.length();
        if angle >= PI || length < 1e-6 {
            // Where there is no way to turn, the axes are opposite or nearly one.
            return if between > FRAC_PI_2 { Cone::SPHERE } else { Cone { angle: angle.min(PI), ..*wide } };
        }
        let (sine, cosine) = math::sin_cos(angle - wide.angle);
        Cone { axis: (wide.axis * cosine + across * (sine / length)).normalize(), angle }
    }

    /// The solid angle that sources shine into whose normals are in the cone and that shine up to `emission` radians from their
    /// normals, weighed by the cosine beyond the cone (Conty Estevez and Kulla 2018, equation 1).
    pub(super) fn measure(&self, emission: f32) -> f32 {
        let angle = self.angle;
        if angle >= PI {
            return 2.0 * TAU;
        }
        let outer = (angle + emission).min(PI);
        let (sine, cosine) = math::sin_cos(angle);
        let rim = 2.0 * outer * sine - math::cos(angle - 2.0 * outer) - 2.0 * angle * sine + cosine;
        TAU * (1.0 - cosine) + FRAC_PI_2 * rim
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::Random;

    /// Directions of either cone are in their union, and it is no wider than both and what is between.
    #[test]
    fn unions_hold_both() {
        let mut random = Random::new(1);
        for i in 0..2000 {
            let mut cone = || Cone { axis: random.direction(), angle: PI * random.unit() * random.unit() };
            let (a, mut b) = (cone(), cone());
            match i % 5 {
                0 => b.axis = a.axis,
                1 => b.axis = -a.axis,
                2 => b = Cone::along(b.axis),
                _ => (),
            }
            let union = a.union(&b);
            let between = a.axis.angle_between(b.axis);
            let widest = (a.angle + between + b.angle) / 2.0;
            assert!(union.angle <= widest.max(a.angle).max(b.angle).min(PI) + 1e-3 || union == Cone::SPHERE);
            for cone in [a, b] {
                for _ in 0..20 {
                    let side = cone.axis.cross(random.direction()).normalize();
                    let (sine, cosine) = cone.angle.sin_cos();
                    let rim = cone.axis * cosine + side * sine;
                    let off = union.axis.angle_between(rim) - union.angle;
                    assert!(off < 1e-3, "{a:?} {b:?}: {union:?} misses by {off}");
                }
            }
        }
    }

    /// By hand: one normal with a cosine around it shines into π, all normals into 4π. Between, by adding up rings.
    #[test]
    fn measures_are_solid_angles() {
        let exact = |angle: f64, emission: f64| {
            let (steps, outer) = (20_000, (angle + emission).min(std::f64::consts::PI));
            let ring = |i: i32| {
                let theta = outer * (f64::from(i) + 0.5) / f64::from(steps);
                std::f64::consts::TAU * theta.sin() * (theta - angle).max(0.0).cos() * outer / f64::from(steps)
            };
            (0..steps).map(ring).sum::<f64>()
        };
        assert!((Cone::along(Vec3::X).measure(FRAC_PI_2) - PI).abs() < 1e-5);
        assert!((Cone::SPHERE.measure(FRAC_PI_2) - 4.0 * PI).abs() < 1e-5);
        for (angle, emission) in [(0.0, 0.3), (0.5, FRAC_PI_2), (1.0, 0.2), (2.0, FRAC_PI_2), (3.0, 0.1)] {
            let (found, exact) =
                (Cone { axis: Vec3::X, angle }.measure(emission), exact(angle.into(), emission.into()));
            assert!((f64::from(found) / exact - 1.0).abs() < 1e-4, "{angle} {emission}: {found}, {exact}");
        }
    }
}
