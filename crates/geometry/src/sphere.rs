//! Spheres.

use std::f32::consts::TAU;
use std::f64::consts::PI;

use brewster_lanes::math;
use glam::{DVec2, DVec3, Vec2, Vec3};

use crate::aabb::Aabb;
use crate::chord::{Chord, recentered};
use crate::sampling::Spread;
use crate::shape::{Analytic, Crossing, LocalSurface, ShapeError, check_length};

/// A sphere around the origin.
///
/// Texture: u = atan2(z, x)/2π + ½, v = acos(y/radius)/π, so v = 0 at the top, as an environment map has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// The radius.
    pub radius: f32,
}

impl Analytic for Sphere {
    fn validate(&self) -> Result<(), ShapeError> {
        check_length("radius", self.radius)
    }

    #[inline(always)]
    fn bounds(&self) -> Aabb {
        Aabb::centered(Vec3::splat(self.radius))
    }

    fn is_closed(&self) -> bool {
        true
    }

    #[inline(always)]
    fn crossing(&self, origin: DVec3, direction: DVec3) -> Option<Crossing> {
        let radius = self.radius as f64;
        recentered(origin, direction, |nearest, after| {
            let coefficients =
                [direction.length_squared(), nearest.dot(direction), nearest.length_squared() - radius * radius];
            let mut chord = Chord::LINE;
            chord.clip_quadratic(coefficients, false, 0);
            chord.nearest(after)
        })
    }

    fn surface(&self, point: DVec3, _face: u32, _margin: DVec3) -> LocalSurface {
        let normal = point.normalize_or(DVec3::Y);
        let v = math::acos((normal.y as f32).clamp(-1.0, 1.0)) * std::f32::consts::FRAC_1_PI;
        let uv = Vec2::new(turn(normal.x, normal.z), v);
        LocalSurface { point: normal * self.radius as f64, normal, uv }
    }

    fn uv_gradients(&self, point: DVec3, _face: u32) -> [DVec3; 2] {
        let normal = point.normalize_or(DVec3::Y);
        // The arccosine of y over the radius; y grows along the surface by what of its axis is not normal to it.
        let up = DVec3::Y - normal * normal.y;
        [turn_gradient(point), up.normalize() * (-1.0 / (PI * f64::from(self.radius)))]
    }
}

impl Spread for Sphere {
    fn area(&self) -> f64 {
        4.0 * PI * self.radius as f64 * self.radius as f64
    }

    /// Archimedes: the area between two heights is that of the cylinder around it.
    fn spread(&self, [u, v]: [f32; 2]) -> (DVec3, u32) {
        let u = u as f64;
        let across = around(v) * (2.0 * (u * (1.0 - u)).sqrt());
        (DVec3::new(across.x, 1.0 - 2.0 * u, across.y) * self.radius as f64, 0)
    }
}

/// The unit vector after a part of a turn, evenly with 0 ≤ part < 1.
pub(crate) fn around(part: f32) -> DVec2 {
    let (sine, cosine) = math::sin_cos(TAU * part);
    DVec2::new(cosine as f64, sine as f64)
}

/// The angle of (x, y) in turns, plus a half: from 0 to 1.
pub(crate) fn turn(x: f64, y: f64) -> f32 {
    (math::atan2(y as f32, x as f32) * (0.5 * std::f32::consts::FRAC_1_PI) + 0.5).clamp(0.0, 1.0)
}

/// The gradient of [`turn`] of x and z.
pub(crate) fn turn_gradient(point: DVec3) -> DVec3 {
    DVec3::new(-point.z, 0.0, point.x) / (f64::from(TAU) * (point.x * point.x + point.z * point.z))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ray::Ray;

    /// Distances by hand.
    #[test]
    fn lines_cross_twice() {
        let sphere = Sphere { radius: 2.0 };
        for (origin, direction, expected) in [
            (Vec3::new(5.0, 0.0, 0.0), Vec3::NEG_X, Some(3.0)),
            (Vec3::ZERO, Vec3::new(0.0, 4.0, 0.0), Some(0.5)),
            (Vec3::new(5.0, 0.0, 0.0), Vec3::X, None),
            (Vec3::new(5.0, 2.5, 0.0), Vec3::NEG_X, None),
            (Vec3::new(0.0, 0.0, -1e6), Vec3::Z, Some(1e6 - 2.0)),
        ] {
            assert_eq!(
                sphere.intersect(&Ray { origin, direction, time: 0.0 }).map(|h| h.t),
                expected,
                "{origin} {direction}"
            );
        }
    }

    #[test]
    fn texture_follows_the_environment_map() {
        let sphere = Sphere { radius: 3.0 };
        for (point, u, v) in [
            (DVec3::X, 0.5, 0.5),
            (DVec3::Z, 0.75, 0.5),
            (DVec3::NEG_Z, 0.25, 0.5),
            (DVec3::Y, 0.5, 0.0),
            (DVec3::NEG_Y, 0.5, 1.0),
        ] {
            let surface = sphere.surface(point * 3.0, 0, DVec3::ZERO);
            assert!((surface.uv - Vec2::new(u, v)).length() < 1e-6, "{point} {}", surface.uv);
            assert_eq!(surface.normal, point);
        }
    }
}
