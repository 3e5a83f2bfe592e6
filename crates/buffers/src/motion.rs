//! What moves while the shutter is open. Columns hold what stands still, and of all else where it is when the shutter opens; the
//! tables here hold the rest, and are empty where nothing moves.

use brewster_geometry::{Affine, Place};
use glam::Vec3;

use crate::{Light, SceneBuffers};

/// How a light without extent moves.
#[derive(Clone, Debug, PartialEq)]
pub struct LightMotion {
    /// Row of the light.
    pub light: u32,
    /// Positions and unit directions at equal steps of the shutter's time, two or more. Between two of them both are interpolated.
    pub keys: Vec<[Vec3; 2]>,
}

/// The keys around a moment of the shutter, 0 ≤ time < 1, and how far it is from the first to the second. There are two or more.
#[inline]
pub(crate) fn around<T>(keys: &[T], time: f32) -> (&T, &T, f32) {
    let steps = keys.len() - 1;
    let passed = time * steps as f32;
    let step = (passed as usize).min(steps - 1);
    (&keys[step], &keys[step + 1], passed - step as f32)
}

/// Interpolates unit vectors; the result has unit length, too.
#[inline]
pub(crate) fn turned(from: Vec3, to: Vec3, s: f32) -> Vec3 {
    if from == to { from } else { (from + (to - from) * s).normalize() }
}

impl SceneBuffers {
    /// Whether anything but cameras moves while the shutter is open.
    pub fn moves(&self) -> bool {
        !(self.motions.is_empty() && self.light_motions.is_empty())
    }

    /// The maps of an instance at a moment, from object to world space and back; `moved` is where they stand if it moves.
    #[inline(always)]
    pub(crate) fn place_at<'p>(
        &'p self,
        instance: u32,
        time: f32,
        moved: &'p mut Option<Place>,
    ) -> (&'p Affine, &'p Affine) {
        let instances = self.instances.view();
        self.motions.maps_at(instance, time, [instances.object_to_world, instances.world_to_object], moved)
    }

    /// A light at a moment of the shutter.
    #[inline(always)]
    pub fn light_at(&self, row: usize, time: f32) -> Light {
        let light = self.lights.get(row);
        if self.light_motions.is_empty() {
            return light;
        }
        let (position, direction) = self.moved_light(row, time).unwrap_or((light.position, light.direction));
        Light { position, direction, ..light }
    }

    /// Where a light that moves is, and where it shines to. Only this passes through memory: a light does not.
    #[inline(never)]
    fn moved_light(&self, row: usize, time: f32) -> Option<(Vec3, Vec3)> {
        let motion = self.light_motions.binary_search_by_key(&(row as u32), |motion| motion.light).ok()?;
        let (&[from, from_direction], &[to, to_direction], s) = around(&self.light_motions[motion].keys, time);
        Some((from + (to - from) * s, turned(from_direction, to_direction, s)))
    }
}
