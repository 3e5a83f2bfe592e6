//! Planes without end.

use glam::{DVec3, Vec2, Vec3};

use crate::aabb::Aabb;
use crate::shape::{Analytic, Crossing, LocalSurface, ShapeError};

/// The plane y = 0 without end, normal +Y. Texture: x and z in meters.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Plane;

impl Analytic for Plane {
    fn validate(&self) -> Result<(), ShapeError> {
        Ok(())
    }

    /// All of space: planes are kept beside the tree.
    #[inline(always)]
    fn bounds(&self) -> Aabb {
        Aabb { min: Vec3::NEG_INFINITY, max: Vec3::INFINITY }
    }

    fn is_closed(&self) -> bool {
        false
    }

    #[inline(always)]
    fn crossing(&self, origin: DVec3, direction: DVec3) -> Option<Crossing> {
        let t = -origin.y / direction.y;
        (t > 0.0).then_some(Crossing { t, face: 0 })
    }

    fn surface(&self, point: DVec3, _face: u32, _margin: DVec3) -> LocalSurface {
        let uv = Vec2::new(point.x as f32, point.z as f32);
        LocalSurface { point: DVec3::new(point.x, 0.0, point.z), normal: DVec3::Y, uv }
    }

    fn uv_gradients(&self, _point: DVec3, _face: u32) -> [DVec3; 2] {
        [DVec3::X, DVec3::Z]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ray::Ray;

    #[test]
    fn is_seen_from_both_sides_and_not_from_within() {
        let hit = |origin: Vec3, direction: Vec3| Plane.intersect(&Ray { origin, direction, time: 0.0 }).map(|h| h.t);
        assert_eq!(hit(Vec3::new(7.0, 3.0, 0.0), Vec3::NEG_Y), Some(3.0));
        assert_eq!(hit(Vec3::new(7.0, -3.0, 0.0), Vec3::new(1.0, 0.5, 0.0)), Some(6.0));
        assert_eq!(hit(Vec3::new(7.0, 3.0, 0.0), Vec3::X), None);
        assert_eq!(hit(Vec3::new(7.0, 0.0, 0.0), Vec3::X), None);
        assert_eq!(hit(Vec3::new(7.0, 0.0, 0.0), Vec3::Y), None);
    }
}
