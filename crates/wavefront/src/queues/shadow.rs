//! The shadow queue: rays toward lights, with what they add if nothing is in between.

use brewster_geometry::{Ray, Rays};
use brewster_lanes::columns;
use glam::Vec3;

use super::Trail;
use crate::media::MediaId;

columns! {
    /// A ray toward a light.
    pub struct ShadowRay => ShadowRayColumns, ShadowRaysView, ShadowRaysViewMut {
        /// Where it starts, in meters.
        pub origin_x: f32,
        /// Where it starts.
        pub origin_y: f32,
        /// Where it starts.
        pub origin_z: f32,
        /// Unit direction.
        pub direction_x: f32,
        /// Unit direction.
        pub direction_y: f32,
        /// Unit direction.
        pub direction_z: f32,
        /// Distance to the light in meters; infinite for directional light.
        pub distance: f32,
        /// What it adds to the sample.
        pub contribution: Vec3,
        /// The row of the sample.
        pub sample: u32,
        /// What sent the path on so far.
        pub trail: Trail,
        /// The instance that sent it.
        pub instance: u32,
        /// The media around it.
        pub media: MediaId,
        /// Whether sheets that light goes straight through let it pass: rays to points and directions of light, which no path
        /// meets by chance. Other light is found behind a sheet by the paths that pass it.
        pub passes_sheets: bool,
    }
}

impl ShadowRay {
    /// The ray alone, that looks at a moment.
    #[inline(always)]
    pub fn ray(&self, time: f32) -> Ray {
        let origin = Vec3::new(self.origin_x, self.origin_y, self.origin_z);
        Ray { origin, direction: self.direction(), time }
    }

    /// Where it goes.
    #[inline(always)]
    pub fn direction(&self) -> Vec3 {
        Vec3::new(self.direction_x, self.direction_y, self.direction_z)
    }

    /// What is left of it behind a surface at some distance.
    #[inline(always)]
    pub fn behind(self, origin: Vec3, distance: f32, contribution: Vec3, media: MediaId) -> ShadowRay {
        let (origin_x, origin_y, origin_z) = origin.into();
        ShadowRay { origin_x, origin_y, origin_z, distance: self.distance - distance, contribution, media, ..self }
    }
}

impl<'a> ShadowRaysView<'a> {
    /// The columns that traversal reads, beside the times at which the rays look.
    pub fn rays(&self, time: &'a [f32]) -> Rays<'a> {
        Rays {
            origin: [self.origin_x, self.origin_y, self.origin_z],
            direction: [self.direction_x, self.direction_y, self.direction_z],
            time,
        }
    }
}

/// Rays toward lights.
pub type ShadowQueue = ShadowRayColumns;
