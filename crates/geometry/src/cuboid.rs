//! Boxes.

use glam::{DVec3, Vec2, Vec3};

use crate::aabb::Aabb;
use crate::chord::Chord;
use crate::sampling::Spread;
use crate::shape::{Analytic, Crossing, LocalSurface, ShapeError, check_length};

/// A box around the origin.
///
/// Faces: 0 is -X, 1 is +X, 2 is -Y, 3 is +Y, 4 is -Z, 5 is +Z. Texture: every face takes the whole picture, upright where
/// it stands: seen from outside, u runs to the right, and v runs up (away on the top, near on the bottom: top's v is -Z,
/// bottom's is +Z).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cuboid {
    /// Half the lengths along x, y and z.
    pub half: Vec3,
}

impl Analytic for Cuboid {
    fn validate(&self) -> Result<(), ShapeError> {
        check_length("half.x", self.half.x)?;
        check_length("half.y", self.half.y)?;
        check_length("half.z", self.half.z)
    }

    #[inline(always)]
    fn bounds(&self) -> Aabb {
        Aabb::centered(self.half)
    }

    fn is_closed(&self) -> bool {
        true
    }

    #[inline(always)]
    fn crossing(&self, origin: DVec3, direction: DVec3) -> Option<Crossing> {
        let mut chord = Chord::LINE;
        for axis in 0..3 {
            let face = 2 * axis as u32;
            chord.clip_slab(origin[axis], direction[axis], self.half[axis] as f64, face, face + 1);
        }
        chord.nearest(0.0)
    }

    fn surface(&self, point: DVec3, face: u32, margin: DVec3) -> LocalSurface {
        let (axis, sign) = (face as usize / 2, if face & 1 == 1 { 1.0 } else { -1.0 });
        let half = self.half.as_dvec3();
        let clear = (half - margin).max(half * 0.5);
        let mut at = point.clamp(-clear, clear);
        at[axis] = sign * half[axis];
        let mut normal = DVec3::ZERO;
        normal[axis] = sign;
        let p = at / half;
        let (u, v) = match axis {
            0 => (-sign * p.z, p.y),
            1 => (p.x, -sign * p.z),
            _ => (sign * p.x, p.y),
        };
        LocalSurface { point: at, normal, uv: Vec2::new((u * 0.5 + 0.5) as f32, (v * 0.5 + 0.5) as f32) }
    }

    fn uv_gradients(&self, _point: DVec3, face: u32) -> [DVec3; 2] {
        let sign = if face & 1 == 1 { 1.0 } else { -1.0 };
        let along = match face / 2 {
            0 => [DVec3::Z * -sign, DVec3::Y],
            1 => [DVec3::X, DVec3::Z * -sign],
            _ => [DVec3::X * sign, DVec3::Y],
        };
        along.map(|axis| axis * 0.5 / self.half.as_dvec3())
    }
}

impl Spread for Cuboid {
    fn area(&self) -> f64 {
        let half = self.half.as_dvec3();
        8.0 * (half.x * half.y + half.y * half.z + half.z * half.x)
    }

    /// The first number chooses the face, one after the other.
    fn spread(&self, [u, v]: [f32; 2]) -> (DVec3, u32) {
        let half = self.half.as_dvec3();
        let faces = [half.y * half.z, half.z * half.x, half.x * half.y];
        let mut rest = u as f64 * 2.0 * (faces[0] + faces[1] + faces[2]);
        let mut face = 0;
        while face < 5 && rest >= faces[face / 2] {
            rest -= faces[face / 2];
            face += 1;
        }
        let (axis, sign) = (face / 2, if face & 1 == 1 { 1.0 } else { -1.0 });
        let mut at = DVec3::splat(sign);
        at[(axis + 1) % 3] = (2.0 * rest / faces[axis]).min(2.0) - 1.0;
        at[(axis + 2) % 3] = 2.0 * v as f64 - 1.0;
        (at * half, face as u32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ray::Ray;

    #[test]
    fn is_entered_and_left_by_the_right_faces() {
        let cuboid = Cuboid { half: Vec3::new(1.0, 2.0, 3.0) };
        for (direction, half) in [(Vec3::X, 1.0), (Vec3::Y, 2.0), (Vec3::Z, 3.0)] {
            let face = direction.to_array().iter().position(|&x| x != 0.0).unwrap() as u32 * 2;
            let from = |t: f32| {
                cuboid.intersect(&Ray { origin: direction * t, direction, time: 0.0 }).map(|h| (h.t, h.primitive))
            };
            assert_eq!(from(-10.0), Some((10.0 - half, face)));
            assert_eq!(from(0.0), Some((half, face + 1)));
            assert_eq!(from(10.0), None);
        }
    }

    /// u × v is the outward normal on every face, so no face shows its picture mirrored.
    #[test]
    fn textures_are_not_mirrored() {
        let cuboid = Cuboid { half: Vec3::new(1.0, 2.0, 3.0) };
        for face in 0..6 {
            let at = cuboid.surface(DVec3::ZERO, face, DVec3::ZERO);
            assert_eq!(at.uv, Vec2::splat(0.5));
            let slope = |axis: usize| {
                let mut step = DVec3::ZERO;
                step[axis] = 0.25;
                (cuboid.surface(step, face, DVec3::ZERO).uv - at.uv).as_dvec2()
            };
            let slopes = [slope(0), slope(1), slope(2)];
            let u = DVec3::new(slopes[0].x, slopes[1].x, slopes[2].x);
            let v = DVec3::new(slopes[0].y, slopes[1].y, slopes[2].y);
            assert!(u.cross(v).dot(at.normal) > 0.0, "face {face}");
        }
    }
}
