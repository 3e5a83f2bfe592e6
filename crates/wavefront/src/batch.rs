//! A batch: the queues of one worker, reused from one tile to the next.

use brewster_geometry::HitColumns;

use crate::attribution::Attribution;
use crate::integrator::DepthFirst;
use crate::media::MediaStacks;
use crate::queues::{ContributionQueue, Levels, PathRayColumns, SampleColumns, ShadowQueue};
use crate::stages::{Draws, FlyScratch, OrderScratch, ShadowScratch, SortedHits, TraceScratch};
use crate::stats::Recorder;

/// All queues that the rays of one tile go through. One worker owns it; once its columns have grown to what a tile needs,
/// nothing in it is allocated again.
#[derive(Debug)]
pub struct Batch {
    /// Rays that wait, by depth.
    pub levels: Levels,
    /// The rays that are traced now.
    pub rays: PathRayColumns,
    /// Memory for ordering them.
    pub ordered: OrderScratch,
    /// Their hits.
    pub hits: HitColumns,
    /// Their hits by kind of material.
    pub sorted: SortedHits,
    /// The random numbers of hits.
    pub draws: Draws,
    /// Memory for tracing rays on.
    pub passing: TraceScratch,
    /// Memory for taking rays through media.
    pub flying: FlyScratch,
    /// Rays toward lights.
    pub shadows: ShadowQueue,
    /// Memory for testing them.
    pub scratch: ShadowScratch,
    /// Light on its way to the samples.
    pub contributions: ContributionQueue,
    /// The samples of the tile.
    pub samples: SampleColumns,
    /// The sets of media that rays are in.
    pub stacks: MediaStacks,
    /// The contributions that are worth a look.
    pub attribution: Attribution,
    /// What waits where paths are followed without queues.
    pub depth_first: DepthFirst,
    /// What is counted and timed.
    pub recorder: Recorder,
}

impl Batch {
    /// Empty queues for rays of depths up to `max_depth`, at most `capacity` of which are traced at once.
    pub fn new(max_depth: u32, capacity: usize, recorder: Recorder) -> Batch {
        Batch {
            levels: Levels::new(max_depth, capacity),
            rays: PathRayColumns::with_capacity(Levels::limit(capacity)),
            ordered: OrderScratch::with_capacity(Levels::limit(capacity)),
            hits: HitColumns::new(),
            sorted: SortedHits::default(),
            draws: Draws::default(),
            passing: TraceScratch::default(),
            flying: FlyScratch::default(),
            shadows: ShadowQueue::new(),
            scratch: ShadowScratch::default(),
            contributions: ContributionQueue::new(),
            samples: SampleColumns::new(),
            stacks: MediaStacks::default(),
            attribution: Attribution::default(),
            depth_first: DepthFirst::default(),
            recorder,
        }
    }

    /// Bytes of memory that the queues take.
    pub fn queue_bytes(&self) -> usize {
        self.levels.bytes()
            + self.rays.capacity() * PathRayColumns::BYTES_PER_ROW
            + self.ordered.bytes()
            + self.hits.capacity() * HitColumns::BYTES_PER_ROW
            + self.sorted.bytes()
            + self.draws.bytes()
            + self.passing.bytes()
            + self.flying.bytes()
            + self.shadows.capacity() * ShadowQueue::BYTES_PER_ROW
            + self.scratch.bytes()
            + self.contributions.capacity() * ContributionQueue::BYTES_PER_ROW
            + self.samples.capacity() * SampleColumns::BYTES_PER_ROW
            + self.depth_first.bytes()
    }
}
