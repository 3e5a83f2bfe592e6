//! What a traversal looks for: the nearest hit, or any hit.

use crate::hit::Hit;

/// What a traversal looks for.
pub(crate) trait Search {
    /// Hits beyond this are of no use.
    fn limit(&self) -> f32;
    /// Takes a hit; true if the search is over.
    fn offer(&mut self, hit: Hit) -> bool;
}

/// The first hit in the order of hits.
pub(crate) struct Nearest(pub(crate) Hit);

impl Search for Nearest {
    #[inline(always)]
    fn limit(&self) -> f32 {
        self.0.t
    }

    #[inline(always)]
    fn offer(&mut self, hit: Hit) -> bool {
        if hit.precedes(&self.0) {
            self.0 = hit;
        }
        false
    }
}

/// Whether there is any hit before a distance.
pub(crate) struct Any {
    pub(crate) t_max: f32,
    pub(crate) found: bool,
}

impl Search for Any {
    #[inline(always)]
    fn limit(&self) -> f32 {
        self.t_max
    }

    #[inline(always)]
    fn offer(&mut self, hit: Hit) -> bool {
        self.found |= hit.t < self.t_max;
        self.found
    }
}
