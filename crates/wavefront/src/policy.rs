//! Policies: how work is scheduled. None of them changes a bit of the picture.

use brewster_geometry::Kernel;
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
    /// How rays are taken through the trees.
    pub kernel: Kernel,
    /// How escaped rays leave the queue of hits.
    pub compaction: Compaction,
    /// The instruction set that kernels run on.
    pub level: Level,
    /// How paths are followed.
    pub executor: Executor,
    /// Whether the path integrator keeps the energy [`ledger`](crate::ledger).
    pub ledger: bool,
    /// Whether the queues are looked at closely, for a [`survey`](crate::survey): that takes more time than rendering.
    pub survey: bool,
}

impl Default for Policy {
    fn default() -> Self {
        Policy {
            batch: 4096,
            capacity: 4096,
            order: QueueOrder::ReflectionFirst,
            sort: SortKey::None,
            kernel: Kernel::default(),
            compaction: Compaction::Branch,
            level: Level::detect(),
            executor: Executor::Wavefront,
            ledger: false,
            survey: false,
        }
    }
}

/// How paths are followed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Executor {
    /// A batch at a time, one bounce after the other, from queue to queue.
    Wavefront,
    /// One path at a time to its end, ray by ray, without queues. Capacity, order, sort and compaction mean nothing then, and no stage is
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
    /// Both together, as one queue.
    Merged,
}

/// How rays are ordered before they are traced; rays of one key stay in the order in which they were pushed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SortKey {
    /// As they were pushed.
    None,
    /// By the material of the surface that they left.
    Material,
    /// By the octant of their direction.
    Octant,
    /// By the place of their origin on a Morton curve through the scene, of 1,024 cells along each axis.
    Morton,
    /// By octant, and within an octant along the curve.
    OctantMorton,
}

/// How `sort` parts rays that escaped from those that met something; either way they stay in order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Compaction {
    /// Row by row, at a branch.
    Branch,
    /// A run of rows before the first of them is looked at closely: every row is written to both lists, and the cursor of one
    /// goes on.
    Cursor,
}
