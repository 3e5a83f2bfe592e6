//! Weakens rays by the medium they went through.

use brewster_geometry::HitsView;
use glam::Vec3;

use crate::context::Context;
use crate::media::{MediaStacks, Medium};
use crate::queues::PathRaysViewMut;
use crate::stats::Counts;

/// Multiplies each ray's weight by the Beer-Lambert transmittance of the medium along it, up to its hit.
///
/// Reads: the hits and the dielectrics. Writes: the rays' weights.
pub fn absorb(
    context: &Context<'_>,
    stacks: &MediaStacks,
    hits: HitsView<'_>,
    rays: PathRaysViewMut<'_>,
    counts: &mut Counts,
) {
    for ((weight, &media), &distance) in rays.weight.iter_mut().zip(&*rays.media).zip(hits.t) {
        weaken(context, weight, stacks.filling(media), distance, counts);
    }
}

/// Multiplies one weight by what a medium leaves of light after a distance.
#[inline(always)]
pub(crate) fn weaken(context: &Context<'_>, weight: &mut Vec3, medium: Medium, distance: f32, counts: &mut Counts) {
    let entered = *weight;
    *weight *= medium.transmittance(distance, &context.scene.materials.dielectric.view());
    if context.albedos.is_some() {
        counts.ledger.entered.add(entered);
        counts.ledger.volume.add(entered);
        counts.ledger.volume.take(*weight);
    }
}
