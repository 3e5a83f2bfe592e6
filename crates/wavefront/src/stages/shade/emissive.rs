//! Shades hits on surfaces that send out light.

use crate::context::Context;
use crate::media::MediaStacks;
use crate::queues::{Contribution, ContributionQueue, HitsOf, OnEmissive, PathRaysView};

/// Gives each hit the surface's radiance; nothing is reflected.
///
/// Reads: rays, hits, emissive materials, textures. Writes: contributions.
pub fn shade_emissive(
    context: &Context<'_>,
    rays: PathRaysView<'_>,
    hits: &HitsOf<'_, OnEmissive>,
    stacks: &MediaStacks,
    contributions: &mut ContributionQueue,
) {
    let scene = context.scene;
    let emissive = scene.materials.emissive.view();
    let hits = hits.columns();
    for row in 0..hits.len() {
        let hit = hits.get(row);
        let ray = rays.get(hit.ray as usize);
        let from_behind = ray.ray().direction.dot(hit.point.geometric_normal) >= 0.0;
        if from_behind && !emissive.two_sided[hit.material as usize] {
            continue;
        }
        let scale = context.radiance_scale(stacks, ray.media);
        let radiance = scene.textures.evaluate(emissive.radiance[hit.material as usize], hit.point.uv);
        contributions.push(Contribution { radiance: ray.weight * radiance * scale, pixel: ray.pixel });
    }
}
