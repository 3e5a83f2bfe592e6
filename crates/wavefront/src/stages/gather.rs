//! Adds contributions to the samples that they belong to.

use brewster_film::{FilmTile, Light};

use crate::queues::{ContributionQueue, SamplesViewMut};

/// Adds all contributions to their samples and empties the queue; tells the film by which way they came.
///
/// Reads and empties: contributions. Writes: the samples' light, and their number of contributions that are no light; the film's
/// parts, if it keeps them.
pub fn gather(contributions: &mut ContributionQueue, samples: SamplesViewMut<'_>, tile: &mut FilmTile<'_>) {
    let view = contributions.view();
    let keeps_parts = tile.keeps_parts();
    for (row, &sample) in view.sample.iter().enumerate() {
        let sample = sample as usize;
        match Light::new(view.radiance[row].to_array()) {
            Some(light) => {
                samples.light[sample].add(light);
                if keeps_parts {
                    tile.add_part(samples.pixel[sample], view.trail[row].part(), light);
                }
            }
            None => samples.rejected[sample] += 1,
        }
    }
    contributions.clear();
}
