//! Attribution: which paths brought the most light at once, and which brought something that is no light.
//!
//! Either list keeps [`KEPT`] contributions, chosen by an order in which no two differ in rank, whatever the order in which they come:
//! the lists are the same on any number of threads and in any batches.

use brewster_film::Light;
use glam::Vec3;

use crate::queues::{Contribution, Sample, ShadowQueue, ShadowRay, Trail};
use crate::random::PixelKey;

/// Contributions that each list keeps.
pub const KEPT: usize = 16;

/// A contribution, and where it came from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Origin {
    /// The pixel's place in the picture.
    pub pixel: PixelKey,
    /// The number of the sample.
    pub sample: u32,
    /// The depth of the ray that brought it, or from whose hit it was sent.
    pub depth: u32,
    /// What sent the path on, and where it ended.
    pub trail: Trail,
    /// The last surface: the emitter, or the one that the path left toward a light or the background. No instance
    /// ([`NO_INSTANCE`](crate::queues::NO_INSTANCE)) where there is none.
    pub instance: u32,
    /// What it brought, before any clamping.
    pub radiance: Vec3,
}

impl Origin {
    /// What comes first, beside radiance.
    fn place(&self) -> (PixelKey, u32, u32, Trail, u32, [u32; 3]) {
        (self.pixel, self.sample, self.depth, self.trail, self.instance, self.radiance.to_array().map(f32::to_bits))
    }
}

/// The contributions of a render that are worth a look.
#[derive(Clone, Debug, PartialEq)]
pub struct Attribution {
    /// Those that were NaN, infinite or negative, and are in no sum: the first by pixel and sample.
    not_light: Vec<Origin>,
    /// Those of the largest single channel among what came by way of a surface: fireflies, if there are any.
    largest: Vec<Origin>,
    /// Everything, where it is wanted.
    pub(crate) journal: Option<Box<Journal>>,
}

/// What went through a batch: for explaining, which follows one ray at a time.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Journal {
    /// Contributions, and the light that samples got of them.
    pub(crate) lights: Vec<(Contribution, Option<Light>)>,
    /// Rays toward lights.
    pub(crate) shadows: Vec<ShadowRay>,
}

impl Journal {
    /// Forgets everything.
    pub(crate) fn clear(&mut self) {
        self.lights.clear();
        self.shadows.clear();
    }
}

impl Default for Attribution {
    /// Nothing; takes all its memory at once.
    fn default() -> Self {
        Attribution { not_light: Vec::with_capacity(KEPT + 1), largest: Vec::with_capacity(KEPT + 1), journal: None }
    }
}

impl Attribution {
    /// Contributions that were no light, the first in the picture's order of pixels (a Z-order curve) and samples.
    pub fn not_light(&self) -> &[Origin] {
        &self.not_light
    }

    /// The largest contributions that came by way of a surface, the largest first.
    pub fn largest(&self) -> &[Origin] {
        &self.largest
    }

    /// Notes a contribution that is light and came by way of a surface, if it is among the largest.
    #[inline(always)]
    pub(crate) fn note_light(&mut self, contribution: &Contribution, sample: impl FnOnce() -> Sample, depth: u32) {
        let is_large = match self.largest.get(KEPT - 1) {
            Some(least) => contribution.radiance.max_element() >= least.radiance.max_element(),
            None => true,
        };
        if is_large {
            insert(&mut self.largest, origin(contribution, &sample(), depth), before_by_size);
        }
    }

    /// Notes a contribution that is no light.
    #[cold]
    pub(crate) fn note_not_light(&mut self, contribution: &Contribution, sample: Sample, depth: u32) {
        insert(&mut self.not_light, origin(contribution, &sample, depth), before_by_place);
    }

    /// Writes rays toward lights down, if there is a journal.
    #[inline]
    pub(crate) fn note_shadows(&mut self, shadows: &ShadowQueue) {
        if let Some(journal) = &mut self.journal {
            journal.shadows.extend((0..shadows.len()).map(|row| shadows.get(row)));
        }
    }

    /// Writes a contribution down and what became of it, if there is a journal.
    #[inline(always)]
    pub(crate) fn note_settled(&mut self, contribution: &Contribution, light: Option<Light>) {
        if let Some(journal) = &mut self.journal {
            journal.lights.push((*contribution, light));
        }
    }

    /// Adds what another part of the render noted.
    pub fn merge(&mut self, other: &Attribution) {
        other.not_light.iter().for_each(|&origin| insert(&mut self.not_light, origin, before_by_place));
        other.largest.iter().for_each(|&origin| insert(&mut self.largest, origin, before_by_size));
    }
}

fn origin(contribution: &Contribution, sample: &Sample, depth: u32) -> Origin {
    let Contribution { radiance, trail, instance, .. } = *contribution;
    Origin { pixel: sample.key, sample: sample.number, depth, trail, instance, radiance }
}

fn before_by_place(a: &Origin, b: &Origin) -> bool {
    a.place() < b.place()
}

fn before_by_size(a: &Origin, b: &Origin) -> bool {
    let [a_size, b_size] = [a, b].map(|origin| origin.radiance.max_element());
    a_size > b_size || a_size == b_size && before_by_place(a, b)
}

/// Puts a row into its place in a list that is in order, and drops the last if there is one too many.
fn insert(list: &mut Vec<Origin>, origin: Origin, before: fn(&Origin, &Origin) -> bool) {
    let place = list.partition_point(|other| !before(&origin, other));
    if place < KEPT {
        list.truncate(KEPT - 1);
        list.insert(place.min(list.len()), origin);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Contributions of some sizes, many of which are alike, of several pixels and samples.
    fn contributions() -> Vec<(Contribution, Sample)> {
        (0..400u32)
            .map(|n| {
                let size = (n * 7919 % 61) as f32;
                let radiance = Vec3::new(0.5 * size, size, 0.0);
                let (key, number) = (PixelKey::new(n * 31 % 17, n % 5), n * 13 % 3);
                let sample = Sample { pixel: 0, key, number, light: Light::NONE, rays: 0, rejected: 0 };
                (Contribution { radiance, sample: 0, trail: Trail::CAMERA, instance: n % 7 }, sample)
            })
            .collect()
    }

    #[test]
    fn the_lists_do_not_depend_on_the_order() {
        let all = contributions();
        let note = |list: &mut Attribution, (contribution, sample): (Contribution, Sample)| {
            list.note_light(&contribution, || sample, 2);
            list.note_not_light(&contribution, sample, 2);
        };
        let [mut forward, mut backward, mut merged] = <[Attribution; 3]>::default();
        all.iter().for_each(|&row| note(&mut forward, row));
        all.iter().rev().for_each(|&row| note(&mut backward, row));
        assert_eq!(forward, backward);
        for part in all.chunks(37).rev() {
            let mut one = Attribution::default();
            part.iter().for_each(|&row| note(&mut one, row));
            merged.merge(&one);
        }
        assert_eq!(forward, merged);
    }

    /// Sorting all of them finds the same.
    #[test]
    fn the_largest_and_the_first_are_kept() {
        let (all, mut list) = (contributions(), Attribution::default());
        for &(contribution, sample) in &all {
            list.note_light(&contribution, || sample, 0);
            list.note_not_light(&contribution, sample, 0);
        }
        let mut sizes: Vec<f32> = all.iter().map(|(contribution, _)| contribution.radiance.y).collect();
        sizes.sort_by(|a, b| b.total_cmp(a));
        assert_eq!(list.largest().iter().map(|origin| origin.radiance.y).collect::<Vec<_>>(), sizes[..KEPT]);
        let mut places: Vec<_> = all.iter().map(|(_, sample)| (sample.key, sample.number)).collect();
        places.sort();
        let found: Vec<_> = list.not_light().iter().map(|origin| (origin.pixel, origin.sample)).collect();
        assert_eq!(found, places[..KEPT]);
    }
}
