//! Gives escaped rays the background.

use brewster_optics::lobe::{DELTA, power_heuristic};

use crate::context::Context;
use crate::media::MediaStacks;
use crate::queues::{Contribution, ContributionQueue, End, EscapedView, PathRaysView};
use crate::stats::Counts;

/// Gives each escaped ray the background's radiance, of which shadow rays bring the part that they find better.
///
/// Reads: rays, escaped rays and the background. Writes: contributions.
pub fn escape(
    context: &Context<'_>,
    rays: PathRaysView<'_>,
    escaped: EscapedView<'_>,
    stacks: &MediaStacks,
    contributions: &mut ContributionQueue,
    counts: &mut Counts,
) {
    let background = &context.scene.background;
    for &row in escaped.ray {
        let ray = rays.get(row as usize);
        if context.albedos.is_some() {
            counts.ledger.escaped.add(ray.weight);
        }
        let direction = ray.ray().direction;
        let share = if ray.pdf == DELTA { 1.0 } else { power_heuristic(ray.pdf, background.pdf(direction)) };
        let scale = share * context.radiance_scale(stacks, ray.media, ray.wavelength);
        let radiance = ray.weight * background.radiance(direction) * scale;
        contributions.push(Contribution {
            radiance,
            sample: ray.sample,
            trail: ray.trail.end(End::Background),
            instance: ray.instance,
        });
    }
}
