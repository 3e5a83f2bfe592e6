//! Gives escaped rays the background.

use brewster_buffers::{Backdrop, Background, SKY_RUN};
use brewster_optics::lobe::{DELTA, power_heuristic};
use glam::Vec3;

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
    let (level, seen) = (context.policy.level, behind(context, depth));
    for run in escaped.ray.chunks(SKY_RUN) {
        let mut directions = [Vec3::Y; SKY_RUN];
        let mut asks = false;
        for (direction, &row) in directions.iter_mut().zip(run) {
            let row = row as usize;
            *direction = Vec3::new(rays.direction_x[row], rays.direction_y[row], rays.direction_z[row]);
            asks |= rays.pdf[row] != DELTA;
        }
        let (mut radiance, mut pdfs) = ([Vec3::ZERO; SKY_RUN], [0.0; SKY_RUN]);
        if let Some(seen) = seen {
            seen.radiance_all(level, &directions, &mut radiance);
        }
        if asks {
            context.scene.background.pdf_all(level, &directions, &mut pdfs);
        }
        for (&row, (&radiance, &pdf)) in run.iter().zip(radiance.iter().zip(&pdfs)) {
            let seen = seen.map(|_| (radiance, pdf));
            if let Some(light) = brought(context, &rays.get(row as usize), seen, stacks, counts) {
                contributions.push(light);
            }
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
    let direction = ray.direction();
    let pdf = if ray.pdf == DELTA { 0.0 } else { context.scene.background.pdf(direction) };
    let seen = behind(context, depth).map(|seen| (seen.radiance(direction), pdf));
    brought(context, ray, seen, stacks, counts)
}

/// What rays of a depth see that meet nothing, if they see anything.
#[inline(always)]
fn behind<'a>(context: &Context<'a>, depth: u32) -> Option<&'a Background> {
    match &context.scene.settings.backdrop {
        Backdrop::Other(backdrop) if depth == 0 => Some(backdrop),
        Backdrop::Transparent if depth == 0 => None,
        _ => Some(&context.scene.background),
    }
}

/// What an escaped ray brings of the radiance that it sees, if it sees any, in a direction that is drawn with some density.
#[inline(always)]
fn brought(
    context: &Context<'_>,
    ray: &PathRay,
    seen: Option<(Vec3, f32)>,
    stacks: &MediaStacks,
    counts: &mut Counts,
) -> Option<Contribution> {
    if context.albedos.is_some() {
        counts.ledger.escaped.add(ray.weight);
    }
    let (radiance, pdf) = seen?;
    let share = if ray.pdf == DELTA { 1.0 } else { power_heuristic(ray.pdf, pdf) };
    let scale = share * context.radiance_scale(stacks, ray.media, ray.wavelength);
    let trail = ray.trail.end(End::Background);
    Some(Contribution { radiance: ray.weight * radiance * scale, sample: ray.sample, trail, instance: ray.instance })
}
