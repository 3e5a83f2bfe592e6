//! Lets rays cross boundaries that are none.

use brewster_optics::lobe::DELTA;

use crate::context::Context;
use crate::queues::{Crossing, CrossingsView, PathRay, PathRaysView, TransmissionQueue};
use crate::stats::Counts;

/// Sends rays on, straight, with the media behind the boundary. It is no interaction: the depth stays. But it stops shadow
/// rays, so that what lies behind is lit by no other technique.
///
/// Reads: rays and crossings. Writes: the transmission queue of the same depth.
pub fn cross(
    context: &Context<'_>,
    rays: PathRaysView<'_>,
    crossings: CrossingsView<'_>,
    transmission: &mut TransmissionQueue,
    counts: &mut Counts,
) {
    for row in 0..crossings.len() {
        let crossing = crossings.get(row);
        let ray = rays.get(crossing.ray as usize);
        transmission.push(behind(context, &ray, &crossing, counts));
    }
}

/// A ray behind a boundary that is none.
#[inline(always)]
pub(crate) fn behind(context: &Context<'_>, ray: &PathRay, crossing: &Crossing, counts: &mut Counts) -> PathRay {
    if context.albedos.is_some() {
        counts.ledger.crossed.add(ray.weight);
    }
    // It goes on at its depth, where flights and veils have used numbers of its branch: those behind are of another, which no other
    // ray has.
    let has_drawn = context.has_fog || context.has_veils;
    let branch = if has_drawn { ray.branch.wrapping_mul(2).wrapping_add(1) } else { ray.branch };
    PathRay { media: crossing.media, pdf: DELTA, branch, ..ray.along(crossing.origin, ray.direction()) }
}
