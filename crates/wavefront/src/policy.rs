//! Policies: how work is scheduled. None of them changes a bit of the picture.

use brewster_lanes::Level;

/// How a batch is scheduled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Policy {
    /// Camera rays in a batch; at least one pixel's go together.
    pub batch: usize,
    /// Rays traced at once; a level that outgrows it is cut and finished part by part.
    pub capacity: usize,
    /// Which queue of a depth is traced first.
    pub order: QueueOrder,
    /// How rays are ordered before they are traced.
    pub sort: SortKey,
    /// The instruction set that kernels run on.
    pub level: Level,
    /// How paths are followed.
    pub executor: Executor,
    /// Whether the path integrator keeps the energy [`ledger`](crate::ledger).
    pub ledger: bool,
}

impl Default for Policy {
    fn default() -> Self {
        Policy {
            batch: 4096,
            capacity: 4096,
            order: QueueOrder::ReflectionFirst,
            sort: SortKey::None,
            level: Level::detect(),
            executor: Executor::Wavefront,
            ledger: false,
        }
    }
}

/// How paths are followed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Executor {
    /// A batch at a time, one bounce after the other, from queue to queue.
    Wavefront,
    /// One path at a time to its end, ray by ray, without queues. Capacity, order and sort mean nothing then, and no stage is
    /// timed by itself.
    Megakernel,
}

/// Which queue of a depth is traced first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum QueueOrder {
    /// Reflections, then transmissions.
    ReflectionFirst,
    /// Transmissions, then reflections.
    TransmissionFirst,
}

/// How rays are ordered before they are traced.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SortKey {
    /// As they were pushed.
    None,
    /// By the octant of their direction; in the old order within an octant.
    Octant,
}
