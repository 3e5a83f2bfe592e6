//! Scattering by media, where a free flight ends: a stage like those of surfaces, without any surface.

use brewster_buffers::LightSample;
use brewster_optics::lobe::power_heuristic;
use brewster_optics::phase::{henyey_greenstein, sample_henyey_greenstein};
use glam::Vec3;

use super::{Onward, cut, roulette};
use crate::context::Context;
use crate::media::MediaStacks;
use crate::queues::{Event, PathRay, PathRaysView, SamplesView, Scattering, ScatteringsView, ShadowRay};
use crate::stages::{DrawsView, Numbers, Outlet};
use crate::stats::Counts;

/// Below the maximum depth, for each scattering: a shadow ray toward a light and one toward the background, and a ray on in a
/// direction drawn from the phase function. What the medium absorbs has been taken from the weight by the flight.
///
/// Reads: rays, scatterings, random numbers, samples, dielectrics, lights, background. Writes: shadow rays and the next depth's transmission queue.
pub fn scatter_medium(
    context: &Context<'_>,
    rays: PathRaysView<'_>,
    scatterings: ScatteringsView<'_>,
    draws: DrawsView<'_>,
    samples: SamplesView<'_>,
    onward: &mut Onward<'_>,
    counts: &mut Counts,
) {
    if onward.queues.next.is_none() {
        return scatterings.ray.iter().for_each(|&ray| cut(context, rays.weight[ray as usize], counts));
    }
    for row in 0..scatterings.len() {
        let scattering = scatterings.get(row);
        let ray = rays.get(scattering.ray as usize);
        let event = (&ray, &scattering, samples.time(context, ray.sample));
        scatter_in_medium(context, event, draws.get(row), onward.stacks, &mut onward.queues, counts);
    }
}

/// One scattering of a ray that looks at a moment.
#[inline(always)]
pub(crate) fn scatter_in_medium(
    context: &Context<'_>,
    (ray, scattering, time): (&PathRay, &Scattering, f32),
    numbers: impl Numbers,
    stacks: &MediaStacks,
    outlet: &mut impl Outlet,
    counts: &mut Counts,
) {
    let (scene, position) = (context.scene, scattering.position);
    if ray.weight == Vec3::ZERO {
        counts.absorbed += 1;
        return;
    }
    let anisotropy = scene.materials.dielectric.view().anisotropy[scattering.medium.0 as usize];
    if !scene.emitters.is_empty()
        && let Some(light) = numbers.light(scene, position, time)
    {
        outlet.shadow(toward(context, (ray, scattering), anisotropy, &light, stacks));
    }
    if let Some(map) = scene.background.drawn()
        && let Some(light) = numbers.sky(map)
    {
        outlet.shadow(toward(context, (ray, scattering), anisotropy, &light, stacks));
    }
    if context.albedos.is_some() {
        counts.ledger.scattered.add(ray.weight);
    }
    let spared = if context.scene.settings.roulette && roulette::is_asked(ray.weight) {
        roulette::spared(ray.weight, 1.0, numbers.roulette())
    } else {
        Some(ray.weight)
    };
    let ledger = context.albedos.is_some().then_some(&mut counts.ledger);
    let Some(weight) = spared else {
        counts.given_up += 1;
        if let Some(ledger) = ledger {
            ledger.roulette_removed.add(ray.weight);
        }
        return;
    };
    if let Some(ledger) = ledger {
        ledger.onward.add(weight);
        ledger.roulette_added.add(weight);
        ledger.roulette_added.take(ray.weight);
    }
    let before = ray.direction();
    let direction = sample_henyey_greenstein(anisotropy, before, numbers.direction());
    let pdf = henyey_greenstein(anisotropy, before.dot(direction));
    let trail = ray.trail.then(Event::Scattered);
    counts.transmissions += 1;
    outlet.transmit(PathRay { weight, pdf, trail, ..ray.along(position, direction) });
}

/// A ray toward a light.
#[inline(always)]
fn toward(
    context: &Context<'_>,
    (ray, scattering): (&PathRay, &Scattering),
    anisotropy: f32,
    light: &LightSample,
    stacks: &MediaStacks,
) -> ShadowRay {
    let origin = scattering.position;
    let phase = henyey_greenstein(anisotropy, ray.direction().dot(light.direction));
    let share = if light.is_delta { 1.0 } else { power_heuristic(light.pdf, phase) };
    let scale = context.radiance_scale(stacks, ray.media, ray.wavelength) * phase * share / light.pdf;
    let (direction, distance) = light.ray_from(origin);
    ShadowRay {
        origin_x: origin.x,
        origin_y: origin.y,
        origin_z: origin.z,
        direction_x: direction.x,
        direction_y: direction.y,
        direction_z: direction.z,
        distance,
        contribution: ray.weight * light.radiance * scale,
        sample: ray.sample,
        trail: ray.trail,
        instance: ray.instance,
        media: ray.media,
        passes_sheets: light.is_delta,
    }
}
