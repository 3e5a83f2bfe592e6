//! Weakens rays by the medium they went through.

use brewster_geometry::HitsView;

use crate::context::Context;
use crate::media::MediaStacks;
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
    let dielectrics = context.scene.materials.dielectric.view();
    let ledger = context.albedos.is_some();
    for ((weight, &media), &distance) in rays.weight.iter_mut().zip(&*rays.media).zip(hits.t) {
        let entered = *weight;
        *weight *= stacks.filling(media).transmittance(distance, &dielectrics);
        if ledger {
            counts.ledger.entered.add(entered);
            counts.ledger.volume.add(entered);
            counts.ledger.volume.take(*weight);
        }
    }
}
