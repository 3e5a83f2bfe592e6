//! Sends photons from the lights toward what may bend them.

use std::cmp::Ordering;
use std::f32::consts::PI;

use brewster_buffers::{Distribution, LightSample, MaterialKind, MaterialRow, Principled, SceneBuffers};
use brewster_film::Light;
use brewster_geometry::{Aabb, Ray, RayByRay, RayMemory, offset_origin, surface};
use brewster_optics::basis::Basis;
use brewster_optics::lobe::{mean, power_heuristic};
use brewster_optics::warp;
use glam::Vec3;
use rayon::prelude::*;

use super::cells::Photon;
use crate::context::Context;
use crate::integrator::Row;
use crate::media::MediaStacks;
use crate::queues::{
    Contribution, OnCoated, OnDielectric, OnMetal, OnPrincipled, PathRay, Sample, ShadowRay, SurfaceHit, Trail,
};
use crate::random::{Decision, PixelKey, Sampler, SamplerKind};
use crate::stages::scatter::scatter_block;
use crate::stages::{Arrival, Outlet, arrive, behind, weaken};
use crate::stats::Counts;

/// Of so many samples of the picture one photon is sent, but at least and at most so many in all.
const SAMPLES: u64 = 16;
const PHOTONS: [u64; 2] = [1 << 12, 1 << 17];

/// Photons that one thread sends in a row.
const RUN: u32 = 1 << 10;

/// Surfaces that bend a photon at most.
const BOUNCES: u32 = 16;

/// Surfaces whose facets are wider are no mirrors: what they reflect is found by rays toward lights.
const WIDEST: f32 = 0.1;

/// The albedo that surfaces around a caustic are taken to have.
const GRAY: f32 = 0.5;

/// What became of the photons.
pub(super) struct Flight {
    pub(super) photons: Vec<Photon>,
    pub(super) sent: u64,
    pub(super) rays: u64,
}

/// Sends photons; none if there is nothing to send them from, toward or to.
pub(super) fn send(context: &Context<'_>) -> Option<Flight> {
    let scene = context.scene;
    let shines = !scene.emitters.rows().is_empty() || scene.background.drawn().is_some();
    let targets = if shines { Targets::new(context)? } else { return None };
    let settings = &scene.settings;
    let samples = settings.resolution.as_u64vec2().element_product() * u64::from(settings.samples);
    let photons = (samples / SAMPLES).clamp(PHOTONS[0], PHOTONS[1]).next_power_of_two() as u32;
    let seed = settings.seed ^ SEED;
    let context =
        Context { sampler: Sampler::new(SamplerKind::Sobol, seed, photons), albedos: None, ..context.clone() };
    let runs: Vec<(Vec<Photon>, u64)> = (0..photons / RUN)
        .into_par_iter()
        .map(|run| {
            let (mut memory, mut stacks) = (RayMemory::default(), MediaStacks::default());
            let tracer = RayByRay::new(context.geometry, context.policy.level, &mut memory);
            let mut sender = Sender { context: &context, targets: &targets, tracer, stacks: &mut stacks, rays: 0 };
            let photons = (run * RUN..(run + 1) * RUN).filter_map(|number| sender.photon(number)).collect();
            (photons, sender.rays)
        })
        .collect();
    let rays = runs.iter().map(|(_, rays)| rays).sum();
    let came = runs.into_iter().flat_map(|(photons, _)| photons).collect();
    Some(Flight { photons: came, sent: photons.into(), rays })
}

/// Photons have other random numbers than paths.
const SEED: u64 = 0x70_68_6f_74_6f_6e_73;

/// What photons are sent toward: instances that may reflect or transmit light in few directions, and the boxes around them, in the order
/// of these, so that the order of entities does not matter.
struct Targets {
    boxes: Vec<(Aabb, u32)>,
    choice: Distribution,
    /// The length of the scene's diagonal, in meters.
    reach: f32,
}

impl Targets {
    fn new(context: &Context<'_>) -> Option<Targets> {
        let (scene, geometry) = (context.scene, context.geometry.instances());
        let (mut boxes, mut scatters) = (Vec::new(), false);
        for (instance, material) in (0..).zip(scene.instances.view().material) {
            let material = scene.materials.rows.view().get(material.0 as usize);
            scatters |= is_diffuse(scene, material);
            if !bends(scene, material) {
                continue;
            }
            let Ok(aabb) = geometry.bounds(instance) else { continue };
            if !aabb.is_empty() {
                // What is flat has a volume, too.
                boxes.push((aabb.padded(1e-3 * (aabb.max - aabb.min).max_element()), instance));
            }
        }
        let corners = |aabb: &Aabb| [aabb.min.to_array(), aabb.max.to_array()];
        boxes.sort_by(|(a, _), (b, _)| {
            let pairs = corners(a).into_iter().flatten().zip(corners(b).into_iter().flatten());
            pairs.map(|(a, b)| a.total_cmp(&b)).find(|order| order.is_ne()).unwrap_or(Ordering::Equal)
        });
        let areas: Vec<f64> = boxes.iter().map(|(aabb, _)| f64::from(aabb.half_area())).collect();
        let all = context.geometry.top.bounds();
        let choice = if scatters { Distribution::new(&areas)? } else { return None };
        Some(Targets { boxes, choice, reach: (all.max - all.min).length() })
    }
}

/// Whether a material may send light on in few directions.
fn bends(scene: &SceneBuffers, MaterialRow { kind, row, .. }: MaterialRow) -> bool {
    let (materials, row) = (&scene.materials, row as usize);
    match kind {
        MaterialKind::Metal => materials.metal.view().alpha[row] <= WIDEST,
        MaterialKind::Dielectric => {
            let dielectrics = materials.dielectric.view();
            dielectrics.alpha[row] <= WIDEST && !dielectrics.bare[row]
        }
        MaterialKind::Principled => {
            let Principled { metallic, transmission, roughness, .. } = materials.principled.get(row);
            let is_narrow = roughness.factor * roughness.factor <= WIDEST;
            is_narrow && !(metallic.is_zero() && transmission.is_zero())
        }
        _ => false,
    }
}

/// Whether photons end at a material.
fn is_diffuse(scene: &SceneBuffers, material: MaterialRow) -> bool {
    match material.kind {
        MaterialKind::Lambert | MaterialKind::RoughDiffuse => true,
        MaterialKind::Principled => !bends(scene, material),
        _ => false,
    }
}

/// Sends one photon after the other.
struct Sender<'s, 'a> {
    context: &'s Context<'a>,
    targets: &'s Targets,
    tracer: RayByRay<'s>,
    stacks: &'s mut MediaStacks,
    rays: u64,
}

/// A ray where it has come to, with the surface there; none outside of everything.
struct Came {
    ray: PathRay,
    hit: Option<SurfaceHit>,
}

/// The one ray that goes on.
struct Next(Option<PathRay>);

impl Outlet for Next {
    fn reflect(&mut self, ray: PathRay) {
        self.0 = Some(ray);
    }

    fn transmit(&mut self, ray: PathRay) {
        self.0 = Some(ray);
    }

    fn shadow(&mut self, _: ShadowRay) {}

    fn light(&mut self, _: Contribution) {}
}

impl Sender<'_, '_> {
    /// Where a photon comes to a surface that scatters, if it does.
    fn photon(&mut self, number: u32) -> Option<Photon> {
        let sample = Sample { pixel: 0, key: PixelKey::ORIGIN, number, light: Light::NONE, rays: 0, rejected: 0 };
        let (ray, target, power) = self.start(number)?;
        let Came { ray, hit: Some(hit) } = self.walk(ray, &sample, Some(target))? else { return None };
        let (kept, is_caustic) = (mean(ray.weight), ray.trail != Trail::CAMERA);
        let (position, toward) = (hit.point.position, -ray.direction());
        let [power, radiance] = [power[0] * kept, power[1] * kept];
        let is_sound = power > 0.0 && power.is_finite();
        (is_caustic && is_sound).then(|| Photon {
            position,
            toward,
            power,
            radiance,
            others: self.others(&hit, &sample),
        })
    }

    /// Follows a ray through what bends it to what does not, if it gets there; the first thing that it meets is `target`, if one is given.
    fn walk(&mut self, mut ray: PathRay, sample: &Sample, target: Option<u32>) -> Option<Came> {
        let context = self.context;
        let scene = context.scene;
        let stream = context.sampler.stream(sample.key, sample.number, ray.branch);
        let time = context.time(sample.key, sample.number);
        // Before that depth both ways on would be taken.
        let split_depth = scene.settings.split_depth;
        for depth in 0..=scene.settings.max_depth.min(BOUNCES) {
            self.rays += 1;
            let hit = self.tracer.closest_hit(&ray.ray(time));
            if depth == 0 && target.is_some_and(|target| hit.instance != target) {
                return None;
            }
            weaken(context, &mut ray.weight, self.stacks.filling(ray.media), hit.t, &mut Counts::default());
            let found = (&hit, |ray: &Ray| surface(&context.geometry, ray, &hit));
            match arrive(context, (&ray, 0, time), found, split_depth + depth, || stream, self.stacks) {
                Arrival::NoBoundary(crossing) => ray = behind(context, &ray, &crossing, &mut Counts::default()),
                Arrival::Surface(kind, hit) => {
                    let material = scene.instances.view().material[hit.instance as usize];
                    let material = scene.materials.rows.view().get(material.0 as usize);
                    if is_diffuse(scene, MaterialRow { kind, row: hit.material, ..material }) {
                        return Some(Came { ray, hit: Some(hit) });
                    }
                    ray = self.bend(kind, &ray, &hit, sample, split_depth + depth)?;
                }
                Arrival::Nothing => return Some(Came { ray, hit: None }),
                Arrival::Medium(_) => return None,
            }
        }
        None
    }

    /// A ray from a light toward a target, which is told, its power times the number of photons, and its radiance.
    fn start(&self, number: u32) -> Option<(PathRay, u32, [f32; 2])> {
        let Sender { context, targets, .. } = self;
        let sampler = &context.sampler;
        let stream = sampler.stream(PixelKey::ORIGIN, number, 1);
        let [choice, place @ ..] = sampler.four(stream, Decision::Camera.at(0));
        let target = targets.choice.choose(choice);
        let (bounds, instance) = targets.boxes[target.index as usize];
        let size = bounds.max - bounds.min;
        let aim = bounds.min + size * Vec3::from_array(place);
        let (light, likely) = self.light(aim, number)?;
        let origin =
            if light.distance == f32::INFINITY { aim + light.direction * (1.01 * targets.reach) } else { light.target };
        let direction = -light.direction;
        // As likely as the ray are all points of the box on it to be aimed at.
        let (enters, leaves) = ((bounds.min - aim) / direction, (bounds.max - aim) / direction);
        let chord = enters.max(leaves).min_element() - enters.min(leaves).max_element();
        let radiance = mean(light.radiance);
        let density = light.pdf * likely * chord / size.element_product() * target.probability;
        let weight = light.radiance / radiance;
        let ray = PathRay { weight, ..PathRay::START }.along(origin, direction);
        Some((ray, instance, [radiance / density, radiance]))
    }

    /// A light that rays can meet, as a point sees it, and the chance that it was asked.
    fn light(&self, point: Vec3, number: u32) -> Option<(LightSample, f32)> {
        let (scene, sampler) = (self.context.scene, &self.context.sampler);
        let stream = sampler.stream(PixelKey::ORIGIN, number, 1);
        let place = sampler.pair(stream, Decision::LightPoint.at(0));
        let choice = sampler.one(stream, Decision::Light.at(0));
        let (chance, sky) = match scene.background.drawn() {
            Some(map) if scene.emitters.is_empty() => (1.0, Some(map)),
            Some(map) => (0.5, (sampler.one(stream, Decision::Distance.at(0)) < 0.5).then_some(map)),
            None => (1.0, None),
        };
        let light = match sky {
            Some(map) => map.sample(place)?,
            None => scene.sample_light(point, self.context.time(PixelKey::ORIGIN, number), choice, place)?,
        };
        (!light.is_delta).then_some((light, chance))
    }

    /// The irradiance of a place by the light that it sees.
    fn direct(&mut self, hit: &SurfaceHit, sample: &Sample) -> f32 {
        let Some((light, chance)) = self.light(hit.point.position, sample.number) else { return 0.0 };
        let (direction, distance) = light.ray_from(offset_origin(&hit.point, light.direction));
        let origin = offset_origin(&hit.point, direction);
        let time = self.context.time(sample.key, sample.number);
        self.rays += 1;
        if self.tracer.occluded(&Ray { origin, direction, time }, distance) {
            return 0.0;
        }
        let cosine = light.direction.dot(hit.point.geometric_normal).abs();
        mean(light.radiance) * cosine / (light.pdf * chance)
    }

    /// What a place gets by a ray that is scattered evenly, as an estimate of its irradiance without caustics and what rays toward lights
    /// find: of the sky, or of a gray surface.
    fn others(&mut self, hit: &SurfaceHit, sample: &Sample) -> f32 {
        let (context, branch) = (self.context, 2);
        let stream = context.sampler.stream(sample.key, sample.number, branch);
        let u = context.sampler.pair(stream, Decision::Direction.at(0));
        let local = warp::cosine_hemisphere(u.into());
        let direction = Basis::around(hit.point.geometric_normal).to_world(local);
        let ray = PathRay { branch, ..PathRay::START }.along(offset_origin(&hit.point, direction), direction);
        let Some(Came { ray, hit }) = self.walk(ray, sample, None) else { return 0.0 };
        let Some(hit) = hit else {
            let background = &context.scene.background;
            let share = power_heuristic(warp::cosine_hemisphere_pdf(local), background.pdf(ray.direction()));
            return PI * mean(background.radiance(ray.direction()) * ray.weight) * share;
        };
        GRAY * self.direct(&hit, sample) * mean(ray.weight)
    }

    /// The ray that a surface sends on, if it does.
    fn bend(
        &mut self,
        kind: MaterialKind,
        ray: &PathRay,
        hit: &SurfaceHit,
        sample: &Sample,
        depth: u32,
    ) -> Option<PathRay> {
        let Sender { context, stacks, .. } = self;
        let row = Row { context, ray, hit, sample, depth };
        let (mut next, mut counts) = (Next(None), Counts::default());
        match kind {
            MaterialKind::Metal => scatter_block::<OnMetal, _, 1>(context, &row, &mut next, stacks, &mut counts),
            MaterialKind::Dielectric => {
                scatter_block::<OnDielectric, _, 1>(context, &row, &mut next, stacks, &mut counts)
            }
            MaterialKind::Principled => {
                scatter_block::<OnPrincipled, _, 1>(context, &row, &mut next, stacks, &mut counts)
            }
            MaterialKind::Coated => scatter_block::<OnCoated, _, 1>(context, &row, &mut next, stacks, &mut counts),
            _ => {}
        }
        next.0
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;
    use std::path::Path;

    use brewster_import::Importer;

    use super::*;
    use crate::policy::Policy;

    /// What a mirror gets of the light of a ball over its middle, all of which reaches the room around: a ball shines like a point, and
    /// a disk of radius R at a distance h takes up (1 - h/√(h² + R²))/2 of all directions.
    #[test]
    fn photons_carry_the_power_that_a_mirror_reflects() {
        let text = "Scene(
            settings: (integrator: Path, resolution: (256, 256), samples: 16),
            camera: Perspective(eye: (0, 1, 5)),
            entities: [
                (shape: Sphere(radius: 0.25), material: Emissive(radiance: 3), at: (0, 1.5, 0)),
                (shape: Disk(radius: 2), material: Metal(r0: 1), rotate: (x: -90)),
                (shape: Sphere(radius: 9), material: Lambert(albedo: 0.5)),
            ],
        )";
        let loaded =
            Importer::default().load_text(Path::new("a test.ron"), text).unwrap_or_else(|error| panic!("{error}"));
        let mut world = brewster_world::Scene::new();
        loaded.scene.apply(world.world_mut());
        world.flatten();
        let scene = world.buffers();
        let context = Context::new(scene, &scene.cameras[0], Policy::default());
        let flight = send(&context).expect("there are a lamp, a mirror and a room");
        let found = flight.photons.iter().map(|photon| f64::from(photon.power)).sum::<f64>() / flight.sent as f64;
        let power = 4.0 * PI * PI * 0.25 * 0.25 * 3.0;
        let expected = power * 0.5 * (1.0 - 1.5 / (1.5f64 * 1.5 + 2.0 * 2.0).sqrt());
        assert!((found / expected - 1.0).abs() < 0.01, "{found} W in place of {expected}");
    }
}
