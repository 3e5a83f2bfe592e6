//! Finds the closest hits.

use brewster_geometry::{Hit, HitColumns, closest_hits};

use crate::context::Context;
use crate::queues::{PathRaysView, SamplesViewMut};

/// Finds what each ray hits first.
///
/// Reads: the rays and the trees. Writes: one hit a ray, in the rays' order, and the samples' number of rays.
pub fn trace(context: &Context<'_>, rays: PathRaysView<'_>, hits: &mut HitColumns, samples: SamplesViewMut<'_>) {
    hits.resize(rays.len(), Hit::miss());
    closest_hits(&context.geometry, context.policy.level, rays.rays(), hits.view_mut());
    for &sample in rays.sample {
        samples.rays[sample as usize] += 1;
    }
}
