//! The contribution queue: light on its way to the film.

use brewster_lanes::columns;
use glam::Vec3;

use super::Trail;

columns! {
    /// Light that a path brings to its sample.
    pub struct Contribution => ContributionColumns, ContributionsView, ContributionsViewMut {
        /// Radiance times weight, linear Rec.709.
        pub radiance: Vec3,
        /// The row of the sample.
        pub sample: u32,
        /// The way that the light came.
        pub trail: Trail,
        /// The last surface that it came from, or [`NO_INSTANCE`](super::NO_INSTANCE).
        pub instance: u32,
    }
}

/// Light on its way to the film.
pub type ContributionQueue = ContributionColumns;
