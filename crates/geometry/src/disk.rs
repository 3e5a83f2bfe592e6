//! Disks and rings.

use std::f64::consts::PI;

use glam::{DVec2, DVec3, Vec2, Vec3};

use crate::aabb::Aabb;
use crate::sampling::Spread;
use crate::shape::{Analytic, Crossing, LocalSurface, ShapeError, check_length};
use crate::sphere::around;

/// A disk around the origin in the plane z = 0, normal +Z, with a hole in its middle if `inner_radius` is not 0.
///
/// Texture: u and v run from 0 to 1 along x and y, over the square around the disk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disk {
    /// The radius.
    pub radius: f32,
    /// The radius of the hole: zero or more, less than `radius`.
    pub inner_radius: f32,
}

impl Analytic for Disk {
    fn validate(&self) -> Result<(), ShapeError> {
        check_length("radius", self.radius)?;
        if self.inner_radius >= 0.0 && self.inner_radius < self.radius {
            return Ok(());
        }
        let expected = "at least 0 and less than radius";
        Err(ShapeError { parameter: "inner_radius", value: self.inner_radius, expected })
    }

    #[inline(always)]
    fn bounds(&self) -> Aabb {
        Aabb::centered(Vec3::new(self.radius, self.radius, 0.0))
    }

    fn is_closed(&self) -> bool {
        false
    }

    #[inline(always)]
    fn crossing(&self, origin: DVec3, direction: DVec3) -> Option<Crossing> {
        let (radius, inner) = (self.radius as f64, self.inner_radius as f64);
        let t = -origin.z / direction.z;
        let distance = (origin + direction * t).truncate().length_squared();
        let inside = distance <= radius * radius && distance >= inner * inner;
        (t > 0.0 && inside).then_some(Crossing { t, face: 0 })
    }

    fn surface(&self, point: DVec3, _face: u32, _margin: DVec3) -> LocalSurface {
        let point = point.truncate().extend(0.0);
        LocalSurface { point, normal: DVec3::Z, uv: disk_uv(point.truncate(), self.radius) }
    }

    fn uv_gradients(&self, _point: DVec3, _face: u32) -> [DVec3; 2] {
        [DVec3::X, DVec3::Y].map(|axis| axis * (0.5 / f64::from(self.radius)))
    }
}

impl Spread for Disk {
    fn area(&self) -> f64 {
        let (radius, inner) = (self.radius as f64, self.inner_radius as f64);
        PI * (radius - inner) * (radius + inner)
    }

    fn spread(&self, [u, v]: [f32; 2]) -> (DVec3, u32) {
        let (radius, inner) = (self.radius as f64, self.inner_radius as f64);
        let distance = (inner * inner + u as f64 * (radius - inner) * (radius + inner)).sqrt();
        ((around(v) * distance).extend(0.0), 0)
    }
}

/// Texture coordinates over the square around a disk.
pub(crate) fn disk_uv(at: DVec2, radius: f32) -> Vec2 {
    (at / radius as f64 * 0.5 + 0.5).as_vec2().clamp(Vec2::ZERO, Vec2::ONE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ray::Ray;

    #[test]
    fn is_a_ring_with_a_hole() {
        let disk = Disk { radius: 2.0, inner_radius: 1.0 };
        for (x, hit) in [(0.0, false), (0.99, false), (1.01, true), (1.99, true), (2.01, false)] {
            let ray = Ray { origin: Vec3::new(0.6 * x, 0.8 * x, 1.0), direction: Vec3::NEG_Z, time: 0.0 };
            assert_eq!(disk.intersect(&ray).is_some(), hit, "{x}");
        }
        assert!(disk.validate().is_ok());
        assert!(Disk { inner_radius: 2.0, ..disk }.validate().is_err());
        assert!(Disk { inner_radius: f32::NAN, ..disk }.validate().is_err());
    }
}
