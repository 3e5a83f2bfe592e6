//! Weakens rays by the medium they went through.

use brewster_geometry::HitsView;
use brewster_optics::absorption::transmittance;

use crate::context::Context;
use crate::media::{MediaStacks, Medium};
use crate::queues::PathRaysViewMut;

/// Multiplies each ray's weight by the Beer-Lambert transmittance of the medium along it, up to its hit.
///
/// Reads: the hits and the dielectrics. Writes: the rays' weights.
pub fn absorb(context: &Context<'_>, stacks: &MediaStacks, hits: HitsView<'_>, rays: PathRaysViewMut<'_>) {
    let dielectrics = context.scene.materials.dielectric.view();
    for ((weight, &media), &distance) in rays.weight.iter_mut().zip(&*rays.media).zip(hits.t) {
        let medium = stacks.filling(media);
        if medium != Medium::VACUUM {
            *weight *= transmittance(dielectrics.absorption[medium.0 as usize], distance);
        }
    }
}
