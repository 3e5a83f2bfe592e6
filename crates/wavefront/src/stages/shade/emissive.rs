//! Shades hits on surfaces that send out light.

use crate::context::Context;
use crate::queues::{Contribution, ContributionQueue, HitsOf, OnEmissive, PathRaysView};

/// Gives each hit the surface's radiance; nothing is reflected.
///
/// Reads: rays, hits, emissive materials, textures. Writes: contributions.
pub fn shade_emissive(
    context: &Context<'_>,
    rays: PathRaysView<'_>,
    hits: &HitsOf<'_, OnEmissive>,
    contributions: &mut ContributionQueue,
) {
    let scene = context.scene;
    let hits = hits.columns();
    for row in 0..hits.len() {
        let hit = hits.get(row);
        let radiance =
            scene.textures.evaluate(scene.materials.emissive.get(hit.material as usize).radiance, hit.point.uv);
        let ray = hit.ray as usize;
        contributions.push(Contribution { radiance: rays.weight[ray] * radiance, pixel: rays.pixel[ray] });
    }
}
