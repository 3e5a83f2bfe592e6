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
/// At most `capacity` rays are traced at once, and each sends at most one ray into each queue of the next depth, or, where it
/// crosses a boundary that is none, one into the transmission queue of its own. Rays are taken breadth first, from the lowest
/// depth that has any, as long as the next depth's queues have room for another `capacity` within their limit of twice that;
/// otherwise the deeper rays are finished first. A transmission queue that crossings have filled beyond `capacity` goes before
/// the other queues of its depth. So a split tree of any depth holds at most `4 * capacity` waiting rays at a depth, whatever it
/// would have grown to, beside the tile's camera rays.
///
/// A queue takes all the memory of its limit before the first ray comes, and memory changes hands only between queues of
/// one size: no push allocates.
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

    /// The most rays that wait in the reflection or the transmission queue of a depth.
    pub const fn limit(capacity: usize) -> usize {
        2 * capacity
    }

    /// The queues of a depth and those of the next, if there is a next, ready for what rays of this depth send.
    pub fn at(&mut self, depth: u32) -> (&mut DepthQueues, Option<&mut DepthQueues>) {
        let limit = Levels::limit(self.capacity);
        let (here, next) = self.depths[depth as usize..].split_first_mut().expect("depths go up to the maximum");
        here.transmission.reserve_total(limit);
        let mut next = next.first_mut();
        if let Some(next) = &mut next {
            next.reflection.reserve_total(limit);
            next.transmission.reserve_total(limit);
        }
        (here, next)
    }

    /// The depth and queue of the rays that go next; nothing when no ray waits.
    pub fn next(&self, order: QueueOrder) -> Option<(u32, RaySource)> {
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
        Some((depth as u32, self.first_source(depth, order)))
    }

    /// Moves the rays that go next into `taken` and tells their depth and queue; nothing when no ray waits.
    pub fn take(&mut self, order: QueueOrder, taken: &mut PathRayColumns) -> Option<(u32, RaySource)> {
        let (depth, source) = self.next(order)?;
        let queues = &mut self.depths[depth as usize];
        match source {
            RaySource::Primary => self.primary.take(self.capacity, taken),
            RaySource::Reflection => queues.reflection.take(self.capacity, taken),
            RaySource::Transmission => queues.transmission.take(self.capacity, taken),
            RaySource::Merged => {
                queues.reflection.take(self.capacity, taken);
                queues.transmission.take_more(self.capacity - taken.len(), taken);
            }
        }
        Some((depth, source))
    }

    fn first_source(&self, depth: usize, order: QueueOrder) -> RaySource {
        let queues = &self.depths[depth];
        if queues.transmission.len() > self.capacity {
            return RaySource::Transmission;
        }
        if depth == 0 && !self.primary.is_empty() {
            return RaySource::Primary;
        }
        match order {
            QueueOrder::ReflectionFirst if queues.reflection.is_empty() => RaySource::Transmission,
            QueueOrder::ReflectionFirst => RaySource::Reflection,
            QueueOrder::TransmissionFirst if queues.transmission.is_empty() => RaySource::Reflection,
            QueueOrder::TransmissionFirst => RaySource::Transmission,
            QueueOrder::Merged => RaySource::Merged,
        }
    }

    /// Bytes of memory taken.
    pub fn bytes(&self) -> usize {
        let depths: usize = self.depths.iter().map(|q| q.reflection.bytes() + q.transmission.bytes()).sum();
        self.primary.bytes() + depths
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::queues::PathRay;

    /// Follows rays of which one in `of` crosses a boundary, up to three in a row, and all others split. Every queue is held to its
    /// limit after every step, and all rays that can be are traced: of n camera rays n 2^d at depth d, not counting crossings.
    fn check(capacity: usize, camera_rays: usize, of: usize, order: QueueOrder) {
        const MAX_DEPTH: u32 = 6;
        let context = format!("capacity {capacity}, {camera_rays} camera rays, one in {of} crosses, {order:?}");
        let mut levels = Levels::new(MAX_DEPTH, capacity);
        let mut taken = PathRayColumns::with_capacity(Levels::limit(capacity));
        (0..camera_rays).for_each(|_| levels.primary.push(PathRay::START));
        let mut scattered = [0; MAX_DEPTH as usize + 1];
        while let Some((depth, _)) = levels.take(order, &mut taken) {
            assert!(taken.len() <= capacity, "{context}: {} rays at once", taken.len());
            let (here, mut next) = levels.at(depth);
            for row in 0..taken.len() {
                let ray = taken.get(row);
                // The sample counts the boundaries crossed.
                if row % of == 0 && ray.sample < 3 {
                    here.transmission.push(PathRay { sample: ray.sample + 1, ..ray });
                    continue;
                }
                scattered[depth as usize] += 1;
                if let Some(next) = &mut next {
                    next.reflection.push(PathRay { sample: 0, ..ray });
                    next.transmission.push(PathRay { sample: 0, ..ray });
                }
            }
            for queues in &levels.depths {
                let longest = queues.reflection.len().max(queues.transmission.len());
                assert!(longest <= Levels::limit(capacity), "{context}: {longest} rays wait");
            }
        }
        for (depth, &scattered) in scattered.iter().enumerate() {
            assert_eq!(scattered, camera_rays << depth, "{context}: depth {depth}");
        }
    }

    #[test]
    fn a_split_tree_stays_within_its_limit_and_loses_no_ray() {
        for order in [QueueOrder::ReflectionFirst, QueueOrder::TransmissionFirst, QueueOrder::Merged] {
            for (capacity, camera_rays) in [(1, 5), (3, 100), (64, 64), (64, 1000), (256, 100)] {
                for of in [1, 2, 5, 1000] {
                    check(capacity, camera_rays, of, order);
                }
            }
        }
    }
}
