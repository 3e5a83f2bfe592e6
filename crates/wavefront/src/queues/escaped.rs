//! The escaped queue: rays that met nothing.

use brewster_lanes::columns;
use glam::Vec3;

columns! {
    /// A ray that met nothing.
    pub struct Escaped => EscapedColumns, EscapedView, EscapedViewMut {
        /// Unit direction.
        pub direction: Vec3,
        /// What a unit of radiance along it adds to the pixel's sample.
        pub weight: Vec3,
        /// The pixel's place in the batch's tile.
        pub pixel: u32,
    }
}

/// Rays that met nothing.
pub type EscapedQueue = EscapedColumns;
