//! The escaped queue: rays that met nothing.

use brewster_lanes::columns;

columns! {
    /// A ray that met nothing.
    pub struct Escaped => EscapedColumns, EscapedView, EscapedViewMut {
        /// The ray's row among those traced.
        pub ray: u32,
    }
}

/// Rays that met nothing.
pub type EscapedQueue = EscapedColumns;
