//! Gives hits on principled materials the light that these send out.

use crate::context::Context;
use crate::media::MediaStacks;
use crate::queues::{ContributionQueue, HitsOf, OnPrincipled, PathRaysView};
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
    let emission = context.scene.materials.principled.view().emission;
    let hits = hits.columns();
    for row in 0..hits.len() {
        let hit = hits.get(row);
        let emission = emission[hit.material as usize];
        if !emission.is_black() {
            contributions.push(shine(context, &rays.get(hit.ray as usize), &hit, emission, stacks));
        }
    }
}
