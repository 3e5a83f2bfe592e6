//! Adds contributions to the samples that they belong to.

use brewster_film::Light;

use crate::queues::{ContributionQueue, SamplesViewMut};

/// Adds all contributions to their samples and empties the queue.
///
/// Reads and empties: contributions. Writes: the samples' light, and their number of contributions that are no light.
pub fn gather(contributions: &mut ContributionQueue, samples: SamplesViewMut<'_>) {
    let view = contributions.view();
    for (radiance, &sample) in view.radiance.iter().zip(view.sample) {
        match Light::new(radiance.to_array()) {
            Some(light) => samples.light[sample as usize].add(light),
            None => samples.rejected[sample as usize] += 1,
        }
    }
    contributions.clear();
}
