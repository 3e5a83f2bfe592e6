//! The contribution queue: light on its way to the film.

use brewster_lanes::columns;
use glam::Vec3;

columns! {
    /// Light that a path brings to its pixel.
    pub struct Contribution => ContributionColumns, ContributionsView, ContributionsViewMut {
        /// Radiance times weight, linear Rec.709.
        pub radiance: Vec3,
        /// The pixel's place in the batch's tile.
        pub pixel: u32,
    }
}

/// Light on its way to the film.
pub type ContributionQueue = ContributionColumns;
