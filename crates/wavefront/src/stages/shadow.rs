//! Tests rays toward lights.

use brewster_buffers::MaterialKind;
use brewster_geometry::{Hit, HitColumns, closest_hits_by, occluded_by, offset_origin, surface};
use glam::Vec3;

use super::fly::{behind_bare, is_bare};
use super::scatter::straight;
use crate::context::Context;
use crate::media::{MediaStacks, Medium};
use crate::policy::Policy;
use crate::queues::{Contribution, ContributionQueue, End, SamplesView, SamplesViewMut, ShadowQueue, ShadowRay};
use crate::stats::Counts;

/// Memory that [`shadow`] reuses.
#[derive(Debug, Default)]
pub struct ShadowScratch {
    blocked: Vec<bool>,
    hits: HitColumns,
    next: ShadowQueue,
    times: Vec<f32>,
}

impl ShadowScratch {
    /// Bytes of memory taken.
    pub fn bytes(&self) -> usize {
        self.blocked.capacity()
            + self.hits.capacity() * HitColumns::BYTES_PER_ROW
            + self.next.capacity() * ShadowQueue::BYTES_PER_ROW
            + size_of_val(&*self.times)
    }
}

/// Passes on the contributions of rays that reach their light, weakened by the media on the way, and empties the queue.
///
/// Reads and empties: shadow rays. Writes: contributions, and the samples' number of rays.
pub fn shadow(
    context: &Context<'_>,
    queue: &mut ShadowQueue,
    stacks: &mut MediaStacks,
    scratch: &mut ShadowScratch,
    contributions: &mut ContributionQueue,
    mut samples: SamplesViewMut<'_>,
    counts: &mut Counts,
) {
    counts.shadow_rays += queue.len() as u64;
    let before = contributions.len();
    let sent = queue.len();
    if context.scene.settings.transparent_shadows {
        while !queue.is_empty() {
            counts.shadow_segments += queue.len() as u64;
            count_rays(queue, &mut samples);
            follow(context, queue, stacks, scratch, samples.as_view(), contributions);
        }
    } else {
        counts.shadow_segments += queue.len() as u64;
        count_rays(queue, &mut samples);
        scratch.next.clear();
        if context.has_veils || context.has_sheets || context.has_fog {
            scratch.next.reserve(queue.capacity());
        }
        let view = queue.view();
        scratch.blocked.resize(view.len(), false);
        let Policy { kernel, level, .. } = context.policy;
        context.times(samples.as_view(), view.sample, &mut scratch.times);
        occluded_by(kernel, &context.geometry, level, view.rays(&scratch.times), view.distance, &mut scratch.blocked);
        for row in 0..view.len() {
            let ray = view.get(row);
            if !scratch.blocked[row] {
                contributions.push(reached(context, &ray, stacks));
            } else if may_go_on(context, &ray) {
                scratch.next.push(ray);
            }
        }
        queue.clear();
        // What is in the way may be a veil, a sheet or no surface at all: that is found out one surface after the other.
        if !scratch.next.is_empty() {
            std::mem::swap(queue, &mut scratch.next);
        }
        while !queue.is_empty() {
            counts.shadow_segments += queue.len() as u64;
            count_rays(queue, &mut samples);
            follow(context, queue, stacks, scratch, samples.as_view(), contributions);
        }
    }
    counts.shadowed += (sent - (contributions.len() - before)) as u64;
}

fn count_rays(queue: &ShadowQueue, samples: &mut SamplesViewMut<'_>) {
    for &sample in queue.view().sample {
        samples.rays[sample as usize] += 1;
    }
}

/// What a ray brings that nothing stands in the way of.
#[inline(always)]
pub(crate) fn reached(context: &Context<'_>, ray: &ShadowRay, stacks: &MediaStacks) -> Contribution {
    let dielectrics = context.scene.materials.dielectric.view();
    let radiance = ray.contribution * stacks.filling(ray.media).transmittance(ray.distance, &dielectrics);
    Contribution { radiance, sample: ray.sample, trail: ray.trail.end(End::Light), instance: ray.instance }
}

/// Whether what is in a ray's way may be a veil, a sheet or a boundary without a surface.
#[inline(always)]
pub(crate) fn may_go_on(context: &Context<'_>, ray: &ShadowRay) -> bool {
    context.has_veils || context.has_fog || (context.has_sheets && ray.passes_sheets)
}

/// Follows each ray to the next surface.
fn follow(
    context: &Context<'_>,
    queue: &mut ShadowQueue,
    stacks: &mut MediaStacks,
    scratch: &mut ShadowScratch,
    samples: SamplesView<'_>,
    contributions: &mut ContributionQueue,
) {
    scratch.hits.resize(queue.len(), Hit::miss());
    let Policy { kernel, level, .. } = context.policy;
    context.times(samples, queue.view().sample, &mut scratch.times);
    closest_hits_by(kernel, &context.geometry, level, queue.view().rays(&scratch.times), scratch.hits.view_mut());
    scratch.next.clear();
    // The two queues change places: either has room for what the other may get.
    scratch.next.reserve(queue.capacity());
    for row in 0..queue.len() {
        let ray = queue.get(row);
        match meet(context, &ray, (&scratch.hits.get(row), samples.time(context, ray.sample)), stacks) {
            Met::Light(contribution) => contributions.push(contribution),
            Met::Passed(ray) => scratch.next.push(ray),
            Met::Blocked => {}
        }
    }
    std::mem::swap(queue, &mut scratch.next);
}

/// What a ray toward a light came to.
pub(crate) enum Met {
    /// Its light.
    Light(Contribution),
    /// A surface that let some of it through: what is left behind it.
    Passed(ShadowRay),
    /// A surface that let nothing through.
    Blocked,
}

/// Follows a ray to what it hits when it looks: past a surface that is partly absent weakened by the part that is there, past a boundary
/// without a surface, through a sheet or a dielectric, where it may, weakened by what that does not let pass, to its light, or not at all. Factors multiply in the order
/// of the hits.
#[inline(always)]
pub(crate) fn meet(context: &Context<'_>, ray: &ShadowRay, (hit, time): (&Hit, f32), stacks: &mut MediaStacks) -> Met {
    let scene = context.scene;
    let dielectrics = scene.materials.dielectric.view();
    let end = hit.t.min(ray.distance);
    let mut contribution = ray.contribution * stacks.filling(ray.media).transmittance(end, &dielectrics);
    if hit.is_miss() || hit.t >= ray.distance {
        let trail = ray.trail.end(End::Light);
        return Met::Light(Contribution { radiance: contribution, sample: ray.sample, trail, instance: ray.instance });
    }
    let id = scene.instances.view().material[hit.instance as usize];
    let material = scene.materials.rows.get(id.0 as usize);
    let is_veil = scene.is_veiled(id);
    let is_clear = scene.settings.transparent_shadows && material.kind == MaterialKind::Dielectric;
    let is_sheet = context.has_sheets && ray.passes_sheets;
    let is_bare = is_bare(context, material);
    if !(is_veil || is_clear || is_sheet || is_bare) {
        return Met::Blocked;
    }
    let point = surface(&context.geometry, &ray.ray(time), hit);
    let direction = ray.direction();
    let mut behind = ray.media;
    if is_bare {
        match behind_bare(context, ray.media, material, (direction, &point), stacks) {
            Some(media) => behind = media,
            None => return Met::Blocked,
        }
    } else if is_veil || is_sheet {
        let there = if is_veil {
            scene.coverage(id, &context.seen(point.place(hit.instance, hit.primitive, time)))
        } else {
            1.0
        };
        let filling = stacks.filling(ray.media);
        let through = if is_sheet { straight(context, ray, (hit, point, time), filling) } else { Vec3::ZERO };
        contribution *= through * there + (1.0 - there);
    } else {
        let inward = direction.dot(point.geometric_normal) < 0.0;
        let boundary = stacks.boundary(ray.media, Medium(material.row), inward, &dielectrics);
        if boundary.filling_before != boundary.filling_behind {
            let cos_i = direction.dot(point.shading_normal).abs().min(1.0);
            let [eta_i, eta_t] = boundary.indices(direction, &point, &dielectrics);
            let fresnel = dielectrics.fresnel[material.row as usize].dielectric(cos_i, eta_i, eta_t);
            contribution *= fresnel.transmittance();
        }
        behind = boundary.behind;
    }
    if contribution == Vec3::ZERO {
        return Met::Blocked;
    }
    Met::Passed(ray.behind(offset_origin(&point, direction), hit.t, contribution, behind))
}
