//! The row that all queues of rays share.

use std::marker::PhantomData;

use brewster_geometry::{Ray, Rays};
use brewster_lanes::columns;
use brewster_optics::dispersion::PathWavelength;
use glam::Vec3;

use super::Trail;
use crate::media::MediaId;

/// The instance of what comes from none.
pub const NO_INSTANCE: u32 = u32::MAX;

columns! {
    /// A ray of a path, with what the path has gathered so far.
    pub struct PathRay => PathRayColumns, PathRaysView, PathRaysViewMut {
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
        /// What a unit of radiance along it adds to the sample; the path integrator leaves out the squared ratio of
        /// indices, which follows from the medium ([`Context::radiance_scale`](crate::context::Context::radiance_scale)).
        pub weight: Vec3,
        /// Density per solid angle with which the last surface chose the direction; `lobe::DELTA` where nothing else could
        /// have chosen it.
        pub pdf: f32,
        /// The row of the sample.
        pub sample: u32,
        /// What sent the path on so far.
        pub trail: Trail,
        /// The instance that it left, or [`NO_INSTANCE`] for a camera ray.
        pub instance: u32,
        /// The media around it.
        pub media: MediaId,
        /// The one wavelength that it stands for, once it has met a boundary that disperses.
        pub wavelength: PathWavelength,
        /// Which child of which child it is: 1 for a camera ray, 2b for the reflection and 2b + 1 for the transmission of
        /// branch b (wrapping), so that a split's children are told apart.
        pub branch: u32,
    }
}

impl PathRay {
    /// A ray of full weight in vacuum that has left no surface; it goes along +z, from the origin.
    pub(crate) const START: PathRay = PathRay {
        origin_x: 0.0,
        origin_y: 0.0,
        origin_z: 0.0,
        direction_x: 0.0,
        direction_y: 0.0,
        direction_z: 1.0,
        weight: Vec3::ONE,
        pdf: f32::INFINITY,
        sample: 0,
        trail: Trail::CAMERA,
        instance: NO_INSTANCE,
        media: MediaId::VACUUM,
        wavelength: PathWavelength::NONE,
        branch: 1,
    };

    /// The ray alone, that looks at a moment.
    #[inline(always)]
    pub fn ray(&self, time: f32) -> Ray {
        Ray { origin: self.origin(), direction: self.direction(), time }
    }

    /// Where it starts.
    #[inline(always)]
    pub fn origin(&self) -> Vec3 {
        Vec3::new(self.origin_x, self.origin_y, self.origin_z)
    }

    /// Where it goes.
    #[inline(always)]
    pub fn direction(&self) -> Vec3 {
        Vec3::new(self.direction_x, self.direction_y, self.direction_z)
    }

    /// The same path along another way.
    #[inline(always)]
    pub fn along(self, origin: Vec3, direction: Vec3) -> PathRay {
        PathRay {
            origin_x: origin.x,
            origin_y: origin.y,
            origin_z: origin.z,
            direction_x: direction.x,
            direction_y: direction.y,
            direction_z: direction.z,
            ..self
        }
    }
}

impl<'a> PathRaysView<'a> {
    /// The columns that traversal reads, beside the times at which the rays look.
    pub fn rays(&self, time: &'a [f32]) -> Rays<'a> {
        Rays {
            origin: [self.origin_x, self.origin_y, self.origin_z],
            direction: [self.direction_x, self.direction_y, self.direction_z],
            time,
        }
    }
}

/// Where a ray came from: the queue that it waited in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum RaySource {
    /// The camera.
    Primary,
    /// A reflection.
    Reflection,
    /// A transmission.
    Transmission,
    /// A reflection or a transmission, where a [policy](crate::QueueOrder::Merged) takes both queues as one.
    Merged,
}

impl RaySource {
    /// All sources, in the order in which reports list them.
    pub const ALL: [RaySource; 4] =
        [RaySource::Primary, RaySource::Reflection, RaySource::Transmission, RaySource::Merged];

    /// Those that there are where queues are not merged.
    pub const APART: [RaySource; 3] = [RaySource::Primary, RaySource::Reflection, RaySource::Transmission];

    /// The name used in counters and reports.
    pub fn name(self) -> &'static str {
        match self {
            RaySource::Primary => "primary",
            RaySource::Reflection => "reflection",
            RaySource::Transmission => "transmission",
            RaySource::Merged => "merged",
        }
    }
}

/// Rays that wait to be traced. `Source` makes each queue a type of its own.
#[derive(Debug)]
pub struct RayQueue<Source> {
    rays: PathRayColumns,
    source: PhantomData<Source>,
}

impl<Source> Default for RayQueue<Source> {
    fn default() -> Self {
        RayQueue { rays: PathRayColumns::new(), source: PhantomData }
    }
}

impl<Source> RayQueue<Source> {
    /// Rays that wait.
    pub fn len(&self) -> usize {
        self.rays.len()
    }

    /// Whether none waits.
    pub fn is_empty(&self) -> bool {
        self.rays.is_empty()
    }

    /// Takes memory so that the queue can hold `capacity` rays.
    pub fn reserve_total(&mut self, capacity: usize) {
        self.rays.reserve(capacity.saturating_sub(self.rays.len()));
    }

    /// Adds a ray.
    #[inline]
    pub fn push(&mut self, ray: PathRay) {
        self.rays.push(ray);
    }

    /// Adds those rays that are marked.
    #[inline(always)]
    pub fn extend_marked(&mut self, rays: PathRaysView<'_>, marks: &[bool]) {
        self.rays.extend_marked(rays, marks);
    }

    /// Moves at most `limit` rays into `taken`, which is emptied first: all of them by exchanging the memory, if it is of
    /// one size, or the last ones by copying.
    pub fn take(&mut self, limit: usize, taken: &mut PathRayColumns) {
        taken.clear();
        if self.len() <= limit && self.rays.capacity() == taken.capacity() {
            std::mem::swap(&mut self.rays, taken);
        } else {
            self.take_more(limit, taken);
        }
    }

    /// Moves at most `limit` rays behind those in `taken`, the last ones.
    pub fn take_more(&mut self, limit: usize, taken: &mut PathRayColumns) {
        let kept = self.len().saturating_sub(limit);
        taken.extend_from_view(self.rays.view().slice(kept..self.len()));
        self.rays.truncate(kept);
    }

    /// Drops the rays from `len` on; keeps the memory.
    pub fn truncate(&mut self, len: usize) {
        self.rays.truncate(len);
    }

    /// Bytes of memory taken.
    pub fn bytes(&self) -> usize {
        self.rays.capacity() * PathRayColumns::BYTES_PER_ROW
    }
}
