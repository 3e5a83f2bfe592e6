//! Gives escaped rays the background.

use brewster_buffers::Backdrop;
use brewster_optics::lobe::{DELTA, power_heuristic};

use crate::context::Context;
use crate::media::MediaStacks;
use crate::queues::{Contribution, ContributionQueue, End, EscapedView, PathRay, PathRaysView};
use crate::stats::Counts;

/// Gives each escaped ray the background's radiance, of which shadow rays bring the part that they find better. Camera rays, of
/// depth 0, see the backdrop.
///
/// Reads: rays, escaped rays and the background. Writes: contributions.
pub fn escape(
    context: &Context<'_>,
    depth: u32,
    rays: PathRaysView<'_>,
    escaped: EscapedView<'_>,
    stacks: &MediaStacks,
    contributions: &mut ContributionQueue,
    counts: &mut Counts,
) {
    for &row in escaped.ray {
        if let Some(light) = seen_behind(context, depth, &rays.get(row as usize), stacks, counts) {
            contributions.push(light);
        }
    }
}

/// What one escaped ray sees.
#[inline(always)]
pub(crate) fn seen_behind(
    context: &Context<'_>,
    depth: u32,
    ray: &PathRay,
    stacks: &MediaStacks,
    counts: &mut Counts,
) -> Option<Contribution> {
    if context.albedos.is_some() {
        counts.ledger.escaped.add(ray.weight);
    }
    let background = &context.scene.background;
    let seen = match &context.scene.settings.backdrop {
        Backdrop::Other(backdrop) if depth == 0 => backdrop,
        Backdrop::Transparent if depth == 0 => return None,
        _ => background,
    };
    let direction = ray.direction();
    let share = if ray.pdf == DELTA { 1.0 } else { power_heuristic(ray.pdf, background.pdf(direction)) };
    let scale = share * context.radiance_scale(stacks, ray.media, ray.wavelength);
    let radiance = ray.weight * seen.radiance(direction) * scale;
    let trail = ray.trail.end(End::Background);
    Some(Contribution { radiance, sample: ray.sample, trail, instance: ray.instance })
}
