//! What rays are sent for.

use crate::hit::{Hit, HitsViewMut};

/// What many rays are sent for.
pub(crate) trait Task {
    /// Whether the first hit found will do.
    const ANY: bool;
    /// Where a ray ends.
    fn limit(&self, ray: usize) -> f32;
    /// Takes a ray's hit.
    fn finish(&mut self, ray: usize, hit: &Hit);
    /// Takes the hits of sixteen rays from `first` on.
    #[cfg(target_arch = "x86_64")]
    fn finish_packet(&mut self, first: usize, hits: &super::packet::Hits) {
        (0..hits.t.len()).for_each(|lane| self.finish(first + lane, &hits.get(lane)));
    }
}

/// The nearest hits.
pub(crate) struct Closest<'a>(pub(crate) HitsViewMut<'a>);

impl Task for Closest<'_> {
    const ANY: bool = false;

    #[inline(always)]
    fn limit(&self, _ray: usize) -> f32 {
        f32::INFINITY
    }

    #[inline(always)]
    fn finish(&mut self, ray: usize, hit: &Hit) {
        self.0.set(ray, *hit);
    }
}

/// Whether there is a hit before `t_max`.
pub(crate) struct Occluded<'a> {
    pub(crate) t_max: &'a [f32],
    pub(crate) out: &'a mut [bool],
}

impl Task for Occluded<'_> {
    const ANY: bool = true;

    #[inline(always)]
    fn limit(&self, ray: usize) -> f32 {
        self.t_max[ray]
    }

    #[inline(always)]
    fn finish(&mut self, ray: usize, hit: &Hit) {
        self.out[ray] = !hit.is_miss();
    }
}
