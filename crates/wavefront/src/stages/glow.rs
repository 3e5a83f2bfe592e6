//! Gives hits on principled materials the light that these send out.

use crate::context::Context;
use crate::media::MediaStacks;
use crate::queues::{Contribution, ContributionQueue, HitsOf, OnPrincipled, PathRay, PathRaysView, SurfaceHit};
use crate::stages::shade::shine;

/// Gives each hit on a principled surface its radiance, of which shadow rays bring the part that they find better. The surface
/// scatters, too: that is another stage's.
///
/// Reads: rays, hits, principled materials, textures. Writes: contributions.
pub fn glow(
    context: &Context<'_>,
    rays: PathRaysView<'_>,
    hits: &HitsOf<'_, OnPrincipled>,
    stacks: &MediaStacks,
    contributions: &mut ContributionQueue,
) {
    let hits = hits.columns();
    for row in 0..hits.len() {
        let hit = hits.get(row);
        if let Some(light) = glowing(context, || rays.get(hit.ray as usize), &hit, stacks) {
            contributions.push(light);
        }
    }
}

/// The light that one hit's surface sends out.
#[inline(always)]
pub(crate) fn glowing(
    context: &Context<'_>,
    ray: impl FnOnce() -> PathRay,
    hit: &SurfaceHit,
    stacks: &MediaStacks,
) -> Option<Contribution> {
    let emission = context.scene.materials.principled.view().emission[hit.material as usize];
    (!emission.is_black()).then(|| shine(context, &ray(), hit, emission, stacks))
}
