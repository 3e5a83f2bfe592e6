//! Weakens rays by the medium they went through.

use brewster_geometry::HitsView;

use crate::context::Context;
use crate::media::MediaStacks;
use crate::queues::PathRaysViewMut;

/// Multiplies each ray's weight by the Beer-Lambert transmittance of the medium along it, up to its hit.
///
/// Reads: the hits and the dielectrics. Writes: the rays' weights.
pub fn absorb(context: &Context<'_>, stacks: &MediaStacks, hits: HitsView<'_>, rays: PathRaysViewMut<'_>) {
    let dielectrics = context.scene.materials.dielectric.view();
    for ((weight, &media), &distance) in rays.weight.iter_mut().zip(&*rays.media).zip(hits.t) {
        *weight *= stacks.filling(media).transmittance(distance, &dielectrics);
    }
}
