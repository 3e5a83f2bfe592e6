//! Cylinders.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3, Vec2, Vec3};

use crate::aabb::Aabb;
use crate::chord::{Chord, recentered};
use crate::disk::disk_uv;
use crate::sampling::Spread;
use crate::shape::{Analytic, Crossing, LocalSurface, ShapeError, check_length};
use crate::sphere::{around, turn, turn_gradient};

/// A closed cylinder around the origin and the y axis.
///
/// Faces: 0 is the side, 1 the bottom, 2 the top. Texture: on the side u = atan2(z, x)/2π + ½ and v runs from 0 at the top to
/// 1 at the bottom; the caps take the square around them along x and z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cylinder {
    /// The radius.
    pub radius: f32,
    /// The length along y.
    pub height: f32,
}

impl Analytic for Cylinder {
    fn validate(&self) -> Result<(), ShapeError> {
        check_length("radius", self.radius)?;
        check_length("height", self.height)
    }

    fn bounds(&self) -> Aabb {
        Aabb::centered(Vec3::new(self.radius, 0.5 * self.height, self.radius))
    }

    fn is_closed(&self) -> bool {
        true
    }

    fn crossing(&self, origin: DVec3, direction: DVec3) -> Option<Crossing> {
        let radius = self.radius as f64;
        let along = DVec2::new(direction.x, direction.z);
        recentered(origin, direction, |nearest, after| {
            let at = DVec2::new(nearest.x, nearest.z);
            let mut chord = Chord::LINE;
            chord.clip_slab(nearest.y, direction.y, 0.5 * self.height as f64, 1, 2);
            let coefficients = [along.length_squared(), at.dot(along), at.length_squared() - radius * radius];
            chord.clip_quadratic(coefficients, false, 0);
            chord.nearest(after)
        })
    }

    fn surface(&self, point: DVec3, face: u32, margin: DVec3) -> LocalSurface {
        let (radius, half) = (self.radius as f64, 0.5 * self.height as f64);
        let around = DVec2::new(point.x, point.z);
        if face == 0 {
            let clear = (half - margin.y).max(0.5 * half);
            let y = point.y.clamp(-clear, clear);
            let outward = around.normalize_or(DVec2::X);
            let normal = DVec3::new(outward.x, 0.0, outward.y);
            let v = (0.5 - 0.5 * y / half) as f32;
            return LocalSurface {
                point: normal * radius + DVec3::Y * y,
                normal,
                uv: Vec2::new(turn(around.x, around.y), v),
            };
        }
        let sign = if face == 2 { 1.0 } else { -1.0 };
        let clear = around.normalize_or(DVec2::X).abs().dot(DVec2::new(margin.x, margin.z));
        let at = around.clamp_length_max((radius - clear).max(0.5 * radius));
        LocalSurface {
            point: DVec3::new(at.x, sign * half, at.y),
            normal: DVec3::Y * sign,
            uv: disk_uv(at, self.radius),
        }
    }

    fn uv_gradients(&self, point: DVec3, face: u32) -> [DVec3; 2] {
        if face == 0 {
            [turn_gradient(point), DVec3::Y * (-1.0 / f64::from(self.height))]
        } else {
            [DVec3::X, DVec3::Z].map(|axis| axis * (0.5 / f64::from(self.radius)))
        }
    }
}

impl Spread for Cylinder {
    fn area(&self) -> f64 {
        TAU * self.radius as f64 * (self.radius as f64 + self.height as f64)
    }

    /// The first number chooses between bottom, side and top.
    fn spread(&self, [u, v]: [f32; 2]) -> (DVec3, u32) {
        let (radius, height) = (self.radius as f64, self.height as f64);
        // In units of radius times 2π: a cap has half the radius, the side the height.
        let at = u as f64 * (radius + height) - 0.5 * radius;
        let beyond = (-at).max(at - height);
        let (y, face) = if at < 0.0 { (0.0, 1) } else { (at.min(height), if beyond > 0.0 { 2 } else { 0 }) };
        // What is left of a cap's part goes from its rim to its center.
        let distance = (radius * (radius - 2.0 * beyond.max(0.0)).max(0.0)).sqrt();
        let across = around(v) * distance;
        (DVec3::new(across.x, y - 0.5 * height, across.y), face)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ray::Ray;

    /// Distances by hand; the slanted ray enters by the side at (2, 0, 0).
    #[test]
    fn has_a_side_and_two_caps() {
        let cylinder = Cylinder { radius: 2.0, height: 6.0 };
        for (origin, direction, expected) in [
            (Vec3::new(5.0, 0.0, 0.0), Vec3::NEG_X, Some((3.0, 0))),
            (Vec3::new(1.0, 10.0, 0.0), Vec3::NEG_Y, Some((7.0, 2))),
            (Vec3::new(1.0, 0.0, 0.0), Vec3::NEG_Y, Some((3.0, 1))),
            (Vec3::new(3.0, 10.0, 0.0), Vec3::NEG_Y, None),
            (Vec3::new(6.0, 4.0, 0.0), Vec3::new(-4.0, -4.0, 0.0), Some((1.0, 0))),
            (Vec3::new(5.0, 3.5, 0.0), Vec3::NEG_X, None),
        ] {
            let hit = cylinder.intersect(&Ray { origin, direction, time: 0.0 }).map(|h| (h.t, h.primitive));
            assert_eq!(hit, expected, "{origin} {direction}");
        }
    }
}
