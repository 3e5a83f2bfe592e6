//! Shades hits on surfaces that send out light.

use brewster_buffers::ColorSource;
use brewster_optics::lobe::{DELTA, power_heuristic};

use crate::context::Context;
use crate::media::MediaStacks;
use crate::queues::{Contribution, ContributionQueue, End, HitsOf, OnEmissive, PathRay, PathRaysView, SurfaceHit};
use crate::stats::Counts;

/// Gives each hit the surface's radiance, of which shadow rays bring the part that they find better; nothing is reflected.
///
/// Reads: rays, hits, emissive materials, textures. Writes: contributions.
pub fn shade_emissive(
    context: &Context<'_>,
    rays: PathRaysView<'_>,
    hits: &HitsOf<'_, OnEmissive>,
    stacks: &MediaStacks,
    contributions: &mut ContributionQueue,
    counts: &mut Counts,
) {
    let hits = hits.columns();
    for row in 0..hits.len() {
        let hit = hits.get(row);
        if let Some(light) = emitted(context, &rays.get(hit.ray as usize), &hit, stacks, counts) {
            contributions.push(light);
        }
    }
}

/// What one ray gets.
#[inline(always)]
pub(crate) fn emitted(
    context: &Context<'_>,
    ray: &PathRay,
    hit: &SurfaceHit,
    stacks: &MediaStacks,
    counts: &mut Counts,
) -> Option<Contribution> {
    if context.albedos.is_some() {
        counts.ledger.emitters.add(ray.weight);
    }
    let emissive = context.scene.materials.emissive.view();
    let from_behind = ray.direction().dot(hit.point.geometric_normal) >= 0.0;
    let shines = !from_behind || emissive.two_sided[hit.material as usize];
    shines.then(|| shine(context, ray, hit, emissive.radiance[hit.material as usize], stacks))
}

/// What a ray gets from a surface that shines toward it.
#[inline(always)]
pub(crate) fn shine(
    context: &Context<'_>,
    ray: &PathRay,
    hit: &SurfaceHit,
    radiance: ColorSource,
    stacks: &MediaStacks,
) -> Contribution {
    let scene = context.scene;
    let share = if ray.pdf == DELTA {
        1.0
    } else {
        power_heuristic(ray.pdf, scene.light_pdf(ray.origin(), hit.time, (hit.instance, hit.primitive), &hit.point))
    };
    let scale = share * context.radiance_scale(stacks, ray.media, ray.wavelength);
    let radiance = ray.weight * scene.color(radiance, &context.seen(hit.place())) * scale;
    Contribution { radiance, sample: ray.sample, trail: ray.trail.end(End::Emitter), instance: hit.instance }
}
