//! Rectangles.

use glam::{DVec2, DVec3, Vec2};

use crate::aabb::Aabb;
use crate::sampling::Spread;
use crate::shape::{Analytic, Crossing, LocalSurface, ShapeError, check_length};

/// A rectangle around the origin in the plane z = 0, normal +Z.
///
/// Texture: u and v run from 0 to 1 along x and y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quad {
    /// Half the lengths along x and y.
    pub half: Vec2,
}

impl Analytic for Quad {
    fn validate(&self) -> Result<(), ShapeError> {
        check_length("half.x", self.half.x)?;
        check_length("half.y", self.half.y)
    }

    #[inline(always)]
    fn bounds(&self) -> Aabb {
        Aabb::centered(self.half.extend(0.0))
    }

    fn is_closed(&self) -> bool {
        false
    }

    #[inline(always)]
    fn crossing(&self, origin: DVec3, direction: DVec3) -> Option<Crossing> {
        let t = -origin.z / direction.z;
        let at = (origin + direction * t).truncate().abs();
        (t > 0.0 && at.cmple(self.half.as_dvec2()).all()).then_some(Crossing { t, face: 0 })
    }

    fn surface(&self, point: DVec3, _face: u32, _margin: DVec3) -> LocalSurface {
        let half = self.half.as_dvec2();
        let at = point.truncate().clamp(-half, half);
        LocalSurface { point: at.extend(0.0), normal: DVec3::Z, uv: (at / half * 0.5 + 0.5).as_vec2() }
    }

    fn uv_gradients(&self, _point: DVec3, _face: u32) -> [DVec3; 2] {
        [DVec3::X * (0.5 / f64::from(self.half.x)), DVec3::Y * (0.5 / f64::from(self.half.y))]
    }
}

impl Spread for Quad {
    fn area(&self) -> f64 {
        4.0 * self.half.x as f64 * self.half.y as f64
    }

    fn spread(&self, u: [f32; 2]) -> (DVec3, u32) {
        let at = (DVec2::new(u[0] as f64, u[1] as f64) * 2.0 - 1.0) * self.half.as_dvec2();
        (at.extend(0.0), 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ray::Ray;
    use glam::Vec3;

    #[test]
    fn ends_at_its_edges() {
        let quad = Quad { half: Vec2::new(2.0, 1.0) };
        for (x, y, hit) in [(1.99, 0.0, true), (2.01, 0.0, false), (0.0, -0.99, true), (0.0, -1.01, false)] {
            let ray = Ray { origin: Vec3::new(x, y, -4.0), direction: Vec3::Z, time: 0.0 };
            assert_eq!(quad.intersect(&ray).map(|h| h.t), hit.then_some(4.0), "{x} {y}");
        }
        let surface = quad.surface(DVec3::new(-2.0, 0.5, 1e-9), 0, DVec3::ZERO);
        assert_eq!((surface.point.z, surface.uv), (0.0, Vec2::new(0.0, 0.75)));
    }
}
