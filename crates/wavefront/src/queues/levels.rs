//! The rays that wait, by depth, and which of them go next.

use super::{PathRayColumns, PrimaryQueue, RaySource, ReflectionQueue, TransmissionQueue};
use crate::policy::QueueOrder;

/// The rays of one depth that wait.
#[derive(Debug, Default)]
pub struct DepthQueues {
    /// Reflections.
    pub reflection: ReflectionQueue,
    /// Transmissions.
    pub transmission: TransmissionQueue,
}

impl DepthQueues {
    fn is_empty(&self) -> bool {
        self.reflection.is_empty() && self.transmission.is_empty()
    }
}

/// All rays of a batch that wait, by depth.
///
/// At most `capacity` rays are traced at once, and each sends at most one ray into each queue of the next depth. Rays are
/// taken breadth first, from the lowest depth that has any, as long as the next depth's queues have room for another
/// `capacity` within their limit of twice that; otherwise the deeper rays are finished first. So a split tree of any depth holds
/// at most `4 * capacity` waiting rays at a depth, whatever it would have grown to.
#[derive(Debug)]
pub struct Levels {
    /// Rays from the camera, all of depth 0.
    pub primary: PrimaryQueue,
    depths: Vec<DepthQueues>,
    capacity: usize,
}

impl Levels {
    /// Empty queues for depths 0 to `max_depth`. They take memory when rays come.
    pub fn new(max_depth: u32, capacity: usize) -> Levels {
        let depths = (0..=max_depth).map(|_| DepthQueues::default()).collect();
        Levels { primary: PrimaryQueue::default(), depths, capacity: capacity.max(1) }
    }

    /// The queues of a depth and those of the next, if there is a next.
    pub fn at(&mut self, depth: u32) -> (&mut DepthQueues, Option<&mut DepthQueues>) {
        let (here, next) = self.depths[depth as usize..].split_first_mut().expect("depths go up to the maximum");
        (here, next.first_mut())
    }

    /// Moves the rays that go next into `taken` and tells their depth and queue; nothing when no ray waits.
    pub fn take(&mut self, order: QueueOrder, taken: &mut PathRayColumns) -> Option<(u32, RaySource)> {
        let mut depth = self.depths.iter().position(|queues| !queues.is_empty());
        if !self.primary.is_empty() {
            depth = Some(0);
        }
        let mut depth = depth?;
        while let Some(next) = self.depths.get(depth + 1) {
            if next.reflection.len().max(next.transmission.len()) <= self.capacity {
                break;
            }
            depth += 1;
        }
        let source = self.first_source(depth, order);
        let queues = &mut self.depths[depth];
        match source {
            RaySource::Primary => self.primary.take(self.capacity, taken),
            RaySource::Reflection => queues.reflection.take(self.capacity, taken),
            RaySource::Transmission => queues.transmission.take(self.capacity, taken),
        }
        Some((depth as u32, source))
    }

    fn first_source(&self, depth: usize, order: QueueOrder) -> RaySource {
        let queues = &self.depths[depth];
        if depth == 0 && !self.primary.is_empty() {
            return RaySource::Primary;
        }
        let reflection_first = match order {
            QueueOrder::ReflectionFirst => !queues.reflection.is_empty(),
            QueueOrder::TransmissionFirst => queues.transmission.is_empty(),
        };
        if reflection_first { RaySource::Reflection } else { RaySource::Transmission }
    }

    /// Bytes of memory taken.
    pub fn bytes(&self) -> usize {
        let depths: usize = self.depths.iter().map(|q| q.reflection.bytes() + q.transmission.bytes()).sum();
        self.primary.bytes() + depths
    }
}
