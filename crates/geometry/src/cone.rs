//! Cones.

use std::f64::consts::PI;

use glam::{DVec2, DVec3, Vec2, Vec3};

use crate::aabb::Aabb;
use crate::chord::{Chord, recentered};
use crate::disk::disk_uv;
use crate::sampling::Spread;
use crate::shape::{Analytic, Crossing, LocalSurface, ShapeError, check_length};
use crate::sphere::{around, turn, turn_gradient};

/// A closed cone around the y axis: its base at -height/2, its apex at +height/2.
///
/// Faces: 0 is the side, 1 the base. Texture: on the side u = atan2(z, x)/2π + ½ and v runs from 0 at the apex to 1 at the
/// base, which takes the square around it along x and z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// The radius of the base.
    pub radius: f32,
    /// The length along y.
    pub height: f32,
}

impl Analytic for Cone {
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

    /// Inside is where x² + z² ≤ (slope·(apex - y))², below the apex and above the base.
    fn crossing(&self, origin: DVec3, direction: DVec3) -> Option<Crossing> {
        let (half, slope) = (0.5 * self.height as f64, self.radius as f64 / self.height as f64);
        let along = DVec2::new(direction.x, direction.z);
        let widening = -slope * direction.y;
        recentered(origin, direction, |nearest, after| {
            let at = DVec2::new(nearest.x, nearest.z);
            let width = slope * (half - nearest.y);
            let mut chord = Chord::LINE;
            // The upper plane only cuts off the mirrored half: it meets the cone in the apex.
            chord.clip_slab(nearest.y, direction.y, half, 1, 0);
            let coefficients = [
                along.length_squared() - widening * widening,
                at.dot(along) - width * widening,
                at.length_squared() - width * width,
            ];
            chord.clip_quadratic(coefficients, direction.y < 0.0, 0);
            chord.nearest(after)
        })
    }

    fn surface(&self, point: DVec3, face: u32, margin: DVec3) -> LocalSurface {
        let (radius, height) = (self.radius as f64, self.height as f64);
        let around = DVec2::new(point.x, point.z);
        let outward = around.normalize_or(DVec2::X);
        // The margin in units of the side: near the rim of a flat cone the inside is thin.
        let clear = outward.abs().dot(DVec2::new(margin.x, margin.z)) / radius + margin.y / height;
        if face == 1 {
            let at = around.clamp_length_max(radius * (1.0 - clear).max(0.5));
            let point = DVec3::new(at.x, -0.5 * height, at.y);
            return LocalSurface { point, normal: DVec3::NEG_Y, uv: disk_uv(at, self.radius) };
        }
        // Along the side from the apex (0) to the base (1); at least so far that the cone is wider than the margin.
        let slant = (radius * radius + height * height).sqrt();
        let across = around.dot(outward);
        let along = (across * radius + (0.5 * height - point.y) * height) / (slant * slant);
        let clear = (2.0 * clear).min(0.5);
        let along = along.clamp(clear, 1.0 - clear);
        let at = outward * (along * radius);
        let normal = DVec3::new(outward.x * height, radius, outward.y * height) / slant;
        LocalSurface {
            point: DVec3::new(at.x, height * (0.5 - along), at.y),
            normal,
            uv: Vec2::new(turn(around.x, around.y), along as f32),
        }
    }

    fn uv_gradients(&self, point: DVec3, face: u32) -> [DVec3; 2] {
        if face == 1 {
            return [DVec3::X, DVec3::Z].map(|axis| axis * (0.5 / f64::from(self.radius)));
        }
        let (radius, height) = (self.radius as f64, self.height as f64);
        let outward = DVec2::new(point.x, point.z).normalize_or(DVec2::X);
        let down = DVec3::new(outward.x * radius, -height, outward.y * radius);
        [turn_gradient(point), down / down.length_squared()]
    }
}

impl Spread for Cone {
    fn area(&self) -> f64 {
        let (radius, height) = (self.radius as f64, self.height as f64);
        PI * radius * (radius + (radius * radius + height * height).sqrt())
    }

    /// The first number chooses between side and base.
    fn spread(&self, [u, v]: [f32; 2]) -> (DVec3, u32) {
        let (radius, height) = (self.radius as f64, self.height as f64);
        let slant = (radius * radius + height * height).sqrt();
        let at = u as f64 * (slant + radius);
        // Both are fans: distances from their centers are roots of what is left of the number.
        let (along, face) = if at < slant { (at / slant, 0) } else { (1.0 - ((at - slant) / radius).min(1.0), 1) };
        let along = along.sqrt();
        let across = around(v) * (along * radius);
        let y = if face == 0 { height * (0.5 - along) } else { -0.5 * height };
        (DVec3::new(across.x, y, across.y), face)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ray::Ray;

    /// Distances by hand: the cone is 2 wide at its base, 1 wide in the middle.
    #[test]
    fn has_a_side_and_a_base() {
        let cone = Cone { radius: 2.0, height: 4.0 };
        for (origin, direction, expected) in [
            (Vec3::new(5.0, 0.0, 0.0), Vec3::NEG_X, Some((4.0, 0))),
            (Vec3::ZERO, Vec3::NEG_X, Some((1.0, 0))),
            (Vec3::new(1.0, 10.0, 0.0), Vec3::NEG_Y, Some((10.0, 0))),
            (Vec3::new(1.0, -10.0, 0.0), Vec3::Y, Some((8.0, 1))),
            (Vec3::new(0.5, -1.0, 0.0), Vec3::NEG_Y, Some((1.0, 1))),
            (Vec3::new(5.0, 2.5, 0.0), Vec3::NEG_X, None),
            (Vec3::new(5.0, 6.0, 0.0), Vec3::NEG_X, None),
            (Vec3::new(-6.0, 0.0, 0.0), Vec3::new(4.0, -4.0, 0.0), None),
            (Vec3::new(-3.0, -1.0, 0.0), Vec3::new(2.0, 0.0, 0.0), Some((0.75, 0))),
        ] {
            let hit = cone.intersect(&Ray { origin, direction, time: 0.0 }).map(|h| (h.t, h.primitive));
            assert_eq!(hit, expected, "{origin} {direction}");
        }
        // The mirrored half above the apex is not there.
        assert_eq!(cone.intersect(&Ray { origin: Vec3::new(0.1, 9.0, 0.0), direction: Vec3::Y, time: 0.0 }), None);
    }

    #[test]
    fn normals_stand_on_the_side() {
        let cone = Cone { radius: 3.0, height: 4.0 };
        let surface = cone.surface(DVec3::new(1.5, 0.0, 0.0), 0, DVec3::ZERO);
        assert!((surface.normal - DVec3::new(0.8, 0.6, 0.0)).length() < 1e-12);
        assert!((surface.point - DVec3::new(1.5, 0.0, 0.0)).length() < 1e-12);
        assert_eq!(surface.uv, Vec2::new(0.5, 0.5));
    }
}
