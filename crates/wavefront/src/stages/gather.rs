//! Adds contributions to the samples that they belong to.

use brewster_buffers::Integrator;
use brewster_film::{FilmTile, Light, Part};

use crate::attribution::Attribution;
use crate::context::Context;
use crate::queues::{Contribution, ContributionQueue, Sample, SamplesViewMut};
use crate::stats::Counts;

/// Adds all contributions to their samples and empties the queue; tells the film by which way they came. What came by way of a
/// surface is held below the scene's clamp, by one factor for all channels.
///
/// Reads and empties: contributions. Writes: the samples' light, and their number of contributions that are no light; the film's
/// parts, if it keeps them; the attribution.
pub fn gather(
    context: &Context<'_>,
    depth: u32,
    contributions: &mut ContributionQueue,
    samples: SamplesViewMut<'_>,
    tile: &mut FilmTile<'_>,
    attribution: &mut Attribution,
    counts: &mut Counts,
) {
    let keeps_parts = tile.keeps_parts();
    for row in 0..contributions.len() {
        let contribution = contributions.get(row);
        let sample = contribution.sample as usize;
        let (view, part) = (samples.as_view(), contribution.trail.part());
        let Some(light) = settle(context, depth, &contribution, || view.get(sample), attribution, counts) else {
            samples.rejected[sample] += 1;
            continue;
        };
        if keeps_parts && part != Part::Direct {
            tile.add_part(samples.pixel[sample], part, light);
        }
        samples.light[sample].add(light);
    }
    contributions.clear();
}

/// The light that one contribution becomes; none if it is no light. What came by way of a surface is held below the scene's
/// clamp.
#[inline(always)]
pub(crate) fn settle(
    context: &Context<'_>,
    depth: u32,
    contribution: &Contribution,
    sample: impl FnOnce() -> Sample,
    attribution: &mut Attribution,
    counts: &mut Counts,
) -> Option<Light> {
    let radiance = contribution.radiance;
    let Some(mut light) = Light::new(radiance.to_array()) else {
        attribution.note_not_light(contribution, sample(), depth);
        attribution.note_settled(contribution, None);
        return None;
    };
    if contribution.trail.part() != Part::Direct {
        attribution.note_light(contribution, sample, depth);
        let clamp = match context.scene.settings.integrator {
            Integrator::Whitted => f32::INFINITY,
            Integrator::Path => context.scene.settings.clamp,
        };
        let largest = radiance.max_element();
        if largest > clamp {
            let kept = radiance * (clamp / largest);
            let [kept, removed] =
                [kept, radiance - kept].map(|part| Light::new(part.to_array()).expect("a part of what is light"));
            light = kept;
            counts.clamped.add(removed);
        }
    }
    attribution.note_settled(contribution, Some(light));
    Some(light)
}
