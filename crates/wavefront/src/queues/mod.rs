//! The queues between stages. Each is a type of its own, named by what happened to the ray: filling or reading the wrong
//! one does not compile.
//!
//! | queue | filled by | drained by | bytes a row |
//! | --- | --- | --- | --- |
//! | [`PrimaryQueue`] | `generate` | `trace`, depth 0 | 62 |
//! | [`ReflectionQueue`] | `shade_metal`, `shade_dielectric`, `scatter_*` | `trace`, one depth on | 62 |
//! | [`TransmissionQueue`] | `shade_dielectric`, `scatter_dielectric`, `scatter_medium`; `cross` at the same depth | `trace`, one depth on | 62 |
//! | [`HitQueue`], one a material kind | `sort` | `shade_*`, `scatter_*`, after `record` has read it at depth 0 | 64 |
//! | [`CrossingQueue`] | `sort` | `cross` | 20 |
//! | [`ScatteringQueue`] | `sort` | `scatter_medium`, after `record` has read it at depth 0 | 20 |
//! | [`EscapedQueue`] | `sort` | `escape` | 4 |
//! | [`ShadowQueue`] | `shade_*`, `scatter_*` | `shadow` | 57 |
//! | [`ContributionQueue`] | `escape`, `shade_*`, `glow`, `shadow`; `scatter_*` what is no number | `gather` | 24 |
//! | [`SampleColumns`] | `generate`, `trace`, `shadow`, `gather` | `fold`, at the end of the tile | 44 |
//!
//! A batch owns one of each and reuses their memory. A ray in flight takes one row of one queue between bounces, and during
//! a bounce a row of what it became: that is why none exceeds 64 bytes, one cache line. The sample that all rays of a path belong to
//! keeps its row from the first stage to the last.
//!
//! **Memory.** A batch that traces at most `capacity` rays at once takes no more rows than
//!
//! - of rays: those of the tile's camera rays, `4 * capacity` at each depth from 1 on, `2 * capacity` at depth 0, and
//!   `4 * capacity` for those being traced and put in order,
//! - of each queue of hits, crossings, scatterings and escaped rays: `2 * capacity`,
//! - of samples: as many as camera rays,
//! - of contributions: `4 * capacity`, of shadow rays with memory to test them: `2 * capacity`.
//!
//! Where something moves, rows of hits and rays that are traced have their time beside them, 4 bytes.
//!
//! (Where there are more lights than `capacity`, their number takes its place in the last line.) So it grows with the maximum
//! depth, however many rays a split tree would have at its widest.

mod contributions;
mod escaped;
mod hits;
mod levels;
mod primary;
mod rays;
mod reflection;
mod samples;
mod shadow;
mod trail;
mod transmission;

pub use contributions::{
    Contribution, ContributionColumns, ContributionQueue, ContributionsView, ContributionsViewMut,
};
pub use escaped::{Escaped, EscapedColumns, EscapedQueue, EscapedView, EscapedViewMut};
pub use hits::{
    CoatedHits, Crossing, CrossingColumns, CrossingQueue, CrossingsView, CrossingsViewMut, DielectricHits,
    EmissiveHits, HitQueue, HitsOf, LambertHits, MetalHits, OnCoated, OnDielectric, OnEmissive, OnLambert, OnMetal,
    OnPhong, OnPrincipled, OnRoughDiffuse, PhongHits, PrincipledHits, RoughDiffuseHits, Scattering, ScatteringColumns,
    ScatteringQueue, ScatteringsView, ScatteringsViewMut, SurfaceHit, SurfaceHitColumns, SurfaceHitRow,
    SurfaceHitRowsView, SurfaceHitRowsViewMut, SurfaceHitsView,
};
pub use levels::{DepthQueues, Levels};
pub use primary::PrimaryQueue;
pub use rays::{NO_INSTANCE, PathRay, PathRayColumns, PathRaysView, PathRaysViewMut, RayQueue, RaySource};
pub use reflection::ReflectionQueue;
pub use samples::{Sample, SampleColumns, SamplesView, SamplesViewMut};
pub use shadow::{ShadowQueue, ShadowRay, ShadowRayColumns, ShadowRaysView, ShadowRaysViewMut};
pub use trail::{End, Event, Trail};
pub use transmission::TransmissionQueue;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_tells_the_bytes_of_a_row_and_none_exceeds_a_cache_line() {
        let rays = PathRayColumns::BYTES_PER_ROW;
        let expected = [
            ("PrimaryQueue", rays),
            ("ReflectionQueue", rays),
            ("TransmissionQueue", rays),
            ("HitQueue", SurfaceHitColumns::BYTES_PER_ROW),
            ("CrossingQueue", CrossingQueue::BYTES_PER_ROW),
            ("ScatteringQueue", ScatteringQueue::BYTES_PER_ROW),
            ("EscapedQueue", EscapedQueue::BYTES_PER_ROW),
            ("ShadowQueue", ShadowQueue::BYTES_PER_ROW),
            ("ContributionQueue", ContributionQueue::BYTES_PER_ROW),
            ("SampleColumns", SampleColumns::BYTES_PER_ROW),
        ];
        let table: Vec<(&str, usize)> = include_str!("mod.rs")
            .lines()
            .filter_map(|line| line.strip_prefix("//! | [`"))
            .map(|row| {
                let (name, rest) = row.split_once('`').expect("a name in quotes");
                let bytes = rest.trim_end_matches([' ', '|']).rsplit(' ').next().expect("a last cell");
                (name, bytes.parse().expect("a number of bytes"))
            })
            .collect();
        assert_eq!(table, expected);
        assert!(expected.iter().all(|&(_, bytes)| bytes <= 64), "{expected:?}");
    }
}
