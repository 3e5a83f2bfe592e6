//! Hits: where a ray met the scene first.

use std::cmp::Ordering;

use brewster_lanes::columns;

/// Stands in [`Hit::instance`] of a ray that meets nothing.
pub const MISS: u32 = u32::MAX;

columns! {
    /// Where a ray met the scene first.
    ///
    /// Hits are ordered by (t, instance, primitive), so that every tree and every kernel finds the same one.
    pub struct Hit => HitColumns, HitsView, HitsViewMut {
        /// Distance along the ray, in lengths of its direction; infinite for a miss.
        pub t: f32,
        /// Weight of a triangle's second corner; 0 on other shapes.
        pub u: f32,
        /// Weight of a triangle's third corner; 0 on other shapes.
        pub v: f32,
        /// Row of the instance, or [`MISS`].
        pub instance: u32,
        /// The triangle of a mesh, or the face of a shape.
        pub primitive: u32,
    }
}

impl Hit {
    /// What a ray has that meets nothing.
    pub const fn miss() -> Hit {
        Hit { t: f32::INFINITY, u: 0.0, v: 0.0, instance: MISS, primitive: MISS }
    }

    /// Whether the ray met nothing.
    #[inline(always)]
    pub fn is_miss(&self) -> bool {
        self.instance == MISS
    }

    /// The order of hits along a ray, ties decided by (instance, primitive).
    #[inline(always)]
    pub fn order(&self, other: &Hit) -> Ordering {
        self.t.total_cmp(&other.t).then(self.instance.cmp(&other.instance)).then(self.primitive.cmp(&other.primitive))
    }

    /// Whether this hit comes before the other in [`Hit::order`].
    #[inline(always)]
    pub(crate) fn precedes(&self, other: &Hit) -> bool {
        self.t < other.t || self.t == other.t && (self.instance, self.primitive) < (other.instance, other.primitive)
    }
}
