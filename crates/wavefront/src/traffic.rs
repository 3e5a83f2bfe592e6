//! How many bytes stages move between queues, from the declared sizes of rows.
//!
//! Whole rows are counted, of which a stage may need a part; `trace` is counted by its columns. What stages read of the scene, and
//! write to the film, is not counted: how much of that there is depends on caches.

use brewster_geometry::HitColumns;

use crate::policy::SortKey;
use crate::queues::{
    ContributionQueue, CrossingQueue, EscapedQueue, PathRayColumns, SampleColumns, ScatteringQueue, ShadowQueue,
    SurfaceHitColumns,
};
use crate::stages::Draws;
use crate::stats::{Counts, Stage};

/// Bytes of queues.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Traffic {
    /// Read.
    pub read: u64,
    /// Written.
    pub written: u64,
}

impl Traffic {
    /// Both ways.
    pub fn total(self) -> u64 {
        self.read + self.written
    }
}

/// Origin and direction.
const SEGMENT: u64 = 24;

/// What a stage moved on behalf of the rays of a depth and queue. Shading stages share what all of them sent on in proportion to
/// their hits, to the byte: over all of them, the traffic of parts of a render adds up to that of the whole.
pub fn traffic(stage: Stage, counts: &Counts, sort: SortKey) -> Traffic {
    let [ray, hit, surface, sample] = [
        PathRayColumns::BYTES_PER_ROW,
        HitColumns::BYTES_PER_ROW,
        SurfaceHitColumns::BYTES_PER_ROW,
        SampleColumns::BYTES_PER_ROW,
    ]
    .map(|bytes| bytes as u64);
    let [contribution, shadow, crossing, scattering, escaped] = [
        ContributionQueue::BYTES_PER_ROW,
        ShadowQueue::BYTES_PER_ROW,
        CrossingQueue::BYTES_PER_ROW,
        ScatteringQueue::BYTES_PER_ROW,
        EscapedQueue::BYTES_PER_ROW,
    ]
    .map(|bytes| bytes as u64);
    let rows = counts.stages[stage as usize];
    let of_each = |read: u64, written: u64| Traffic { read: rows * read, written: rows * written };
    match stage {
        Stage::Generate => of_each(0, ray + sample),
        Stage::Order if sort == SortKey::None => Traffic::default(),
        Stage::Order => of_each(ray, ray),
        Stage::Trace => of_each(SEGMENT, hit),
        Stage::Absorb => of_each(hit + ray, ray),
        Stage::Fly => of_each(hit + ray + sample, hit + ray),
        Stage::Sort => Traffic {
            read: rows * (hit + ray),
            written: counts.hits * surface
                + counts.crossings * crossing
                + counts.scatterings * scattering
                + counts.escaped * escaped,
        },
        Stage::Cross => of_each(crossing + ray, ray),
        Stage::Record => of_each(surface + sample, 0),
        Stage::Escape => of_each(escaped + ray, contribution),
        Stage::ShadeEmissive | Stage::Glow => of_each(surface + ray, contribution),
        Stage::Draw => of_each(surface + sample, Draws::BYTES_PER_ROW as u64),
        Stage::Shadow => Traffic {
            read: counts.shadow_segments * shadow,
            written: counts.shadow_rays.saturating_sub(counts.shadowed) * contribution,
        },
        Stage::Gather => of_each(contribution + sample, sample),
        Stage::Fold => of_each(sample, 0),
        _ => {
            let shaded: u64 = SHADING.iter().map(|&stage| counts.stages[stage as usize]).sum();
            let sent = (counts.reflections + counts.transmissions) * ray + counts.shadow_rays * shadow;
            let before: u64 = SHADING.iter().take_while(|&&of| of != stage).map(|&of| counts.stages[of as usize]).sum();
            let up_to = |rows: u64| (u128::from(sent) * u128::from(rows) / u128::from(shaded.max(1))) as u64;
            Traffic { read: rows * (surface + ray), written: up_to(before + rows) - up_to(before) }
        }
    }
}

/// The stages that send rays on.
const SHADING: [Stage; 11] = [
    Stage::ShadePhong,
    Stage::ShadeLambert,
    Stage::ShadeMetal,
    Stage::ShadeDielectric,
    Stage::ScatterLambert,
    Stage::ScatterRoughDiffuse,
    Stage::ScatterMetal,
    Stage::ScatterDielectric,
    Stage::ScatterPrincipled,
    Stage::ScatterCoated,
    Stage::ScatterMedium,
];

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand from the table at the head of the queues' module: rays 62 bytes, hits on surfaces 64, shadow rays 57.
    #[test]
    fn rows_add_up_to_bytes() {
        let mut counts = Counts { hits: 3, reflections: 2, transmissions: 2, shadow_rays: 4, ..Counts::default() };
        counts.stages[Stage::Trace as usize] = 5;
        counts.stages[Stage::ShadeMetal as usize] = 1;
        counts.stages[Stage::ShadeDielectric as usize] = 1;
        let of = |stage| traffic(stage, &counts, SortKey::None);
        assert_eq!(of(Stage::Trace), Traffic { read: 5 * 24, written: 5 * 20 });
        assert_eq!(of(Stage::Order), Traffic::default());
        let half = (4 * 62 + 4 * 57) / 2;
        assert_eq!(of(Stage::ShadeMetal), Traffic { read: 64 + 62, written: half });
        assert_eq!(of(Stage::ShadeDielectric), of(Stage::ShadeMetal));
    }
}
