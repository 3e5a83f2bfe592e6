//! Two Fresnel models on the same paths: two pictures whose difference is that of the models, without the noise of other choices.
//!
//! The paths are those of the Fresnel equations: which way a path goes, whether it goes on, and which light it asks follow them in
//! both pictures. Beside every ray goes a factor, the product of what the other model sends over what the equations send at each
//! hit on its way; a contribution times this factor is what the other picture gets. Where the equations send nothing, the other
//! picture gets nothing. Paths are followed one at a time.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use brewster_buffers::{Integrator, MaterialKind, SceneBuffers};
use brewster_film::{Film, FilmTile, Light, PixelOrder};
use brewster_geometry::Hit;
use brewster_optics::fresnel::FresnelModel;
use glam::Vec3;

use crate::attribution::Attribution;
use crate::batch::Batch;
use crate::context::Context;
use crate::integrator::{Beside, DepthFirst, HitOf, Toward, follow_beside};
use crate::media::MediaStacks;
use crate::policy::Policy;
use crate::queues::{Contribution, OnCoated, OnDielectric, OnMetal, Sample, ShadowRay};
use crate::render::{Control, Unsupported, check_integrator};
use crate::stages::scatter::ratio;
use crate::stages::{Met, fold_one, meet, settle};
use crate::stats::{Counts, Recorder};

/// Renders all samples of a scene's picture by the Fresnel equations and, over the same paths, by another model, on some threads.
/// Both films take the pixels of `order`. A noise threshold is left out of account. None if it was stopped before the end.
///
/// Metals that are given by their color have no index, and so are the same in both; films keep to the equations.
///
/// # Errors
///
/// There is no such camera, or the scene cannot be rendered.
pub fn both_models(
    scene: &SceneBuffers,
    camera: usize,
    model: FresnelModel,
    order: PixelOrder,
    threads: usize,
    control: &Control,
) -> Result<Option<[Film; 2]>, Unsupported> {
    let camera = scene.cameras.get(camera).ok_or(Unsupported::Camera(scene.cameras.len()))?;
    check_integrator(scene, camera)?;
    let scenes = [FresnelModel::Exact, model].map(|model| with_model(scene, model));
    let contexts = scenes.each_ref().map(|scene| Context::new(scene, camera, Policy::default()));
    let mut films = [Film::new(order), Film::new(order)];
    let pixels = (contexts[0].policy.batch / scene.settings.samples.max(1) as usize).max(1);
    let [exact, other] = &mut films;
    let tiles = Mutex::new(exact.tiles_mut(pixels).into_iter().zip(other.tiles_mut(pixels)));
    let stopped = AtomicBool::new(false);
    std::thread::scope(|scope| {
        for worker in 0..threads.max(1) as u32 {
            let (contexts, tiles, stopped) = (&contexts, &tiles, &stopped);
            scope.spawn(move || {
                let depth = scene.settings.max_depth;
                let mut batch = Batch::new(depth, 1, Recorder::new(depth, worker, Instant::now(), false));
                let mut waiting = DepthFirst::default();
                loop {
                    let next = tiles.lock().expect("no holder of the lock can panic").next();
                    let Some((mut exact, other)) = next else { return };
                    if control.stopped() {
                        return stopped.store(true, Ordering::Relaxed);
                    }
                    let samples = 0..scene.settings.samples;
                    let finished = exact.len() * samples.len();
                    let mut beside = OtherModel::new(contexts, other);
                    follow_beside(&contexts[0], samples, &mut batch, &mut exact, (&mut waiting, &mut beside));
                    control.count(finished as u64);
                }
            });
        }
    });
    drop(tiles);
    Ok((!stopped.into_inner()).then_some(films))
}

/// The scene with every index evaluated by one model.
fn with_model(scene: &SceneBuffers, model: FresnelModel) -> SceneBuffers {
    let mut scene = scene.clone();
    let metals = scene.materials.metal.view_mut();
    for (fresnel, k) in metals.fresnel.iter_mut().zip(&*metals.k) {
        // What was made from an index kept it, whichever model the author chose.
        if *fresnel == FresnelModel::Exact || *k != Vec3::ZERO {
            *fresnel = model;
        }
    }
    scene.materials.dielectric.view_mut().fresnel.fill(model);
    scene
}

/// The other picture, and what it takes to find its light.
struct OtherModel<'m, 'a, 't> {
    contexts: &'m [Context<'a>; 2],
    tile: FilmTile<'t>,
    light: Light,
    rejected: u32,
    /// Of this picture nothing is counted.
    counts: Counts,
    attribution: Attribution,
}

impl<'m, 'a, 't> OtherModel<'m, 'a, 't> {
    fn new(contexts: &'m [Context<'a>; 2], tile: FilmTile<'t>) -> Self {
        let (counts, attribution) = Default::default();
        OtherModel { contexts, tile, light: Light::NONE, rejected: 0, counts, attribution }
    }
}

impl Beside for OtherModel<'_, '_, '_> {
    /// What this picture gets of what the other one gets.
    type Mark = Vec3;

    fn start(&mut self) -> Vec3 {
        (self.light, self.rejected) = (Light::NONE, 0);
        Vec3::ONE
    }

    fn sent(&self, hit: &HitOf<'_>, toward: Toward, mark: Vec3, stacks: &mut MediaStacks) -> Vec3 {
        let HitOf { kind, ray, hit, sample } = *hit;
        let contexts = self.contexts.each_ref();
        let is_lecture = contexts[0].scene.settings.integrator == Integrator::Whitted;
        let first = || contexts[0].sampler.stream(sample.key, sample.number, 1);
        let (Toward::Onward(direction) | Toward::Light(direction)) = toward;
        let factor = match (kind, toward) {
            // The lecture's highlight on metal is R_0, which is no question of the model.
            (MaterialKind::Metal, Toward::Light(_)) if is_lecture => Vec3::ONE,
            (MaterialKind::Metal, _) => ratio::<OnMetal>(contexts, (*ray, hit), direction, first, stacks),
            (MaterialKind::Dielectric, _) => ratio::<OnDielectric>(contexts, (*ray, hit), direction, first, stacks),
            (MaterialKind::Coated, _) => ratio::<OnCoated>(contexts, (*ray, hit), direction, first, stacks),
            _ => Vec3::ONE,
        };
        mark * factor
    }

    fn met(&self, ray: &ShadowRay, hit: (&Hit, f32), met: &Met, mark: Vec3, stacks: &mut MediaStacks) -> Vec3 {
        match (met, meet(&self.contexts[1], ray, hit, stacks)) {
            (Met::Passed(exact), Met::Passed(other)) => {
                let is_light = exact.contribution.cmpgt(Vec3::ZERO);
                mark * Vec3::select(is_light, other.contribution / exact.contribution, Vec3::ONE)
            }
            _ => mark,
        }
    }

    fn light(&mut self, contribution: &Contribution, depth: u32, sample: &Sample, mark: Vec3) {
        let OtherModel { contexts, light, rejected, counts, attribution, .. } = self;
        let contribution = Contribution { radiance: contribution.radiance * mark, ..*contribution };
        match settle(&contexts[1], depth, &contribution, || *sample, attribution, counts) {
            Some(found) => light.add(found),
            None => *rejected += 1,
        }
    }

    fn end(&mut self, sample: &Sample) {
        let sample = Sample { light: self.light, rejected: self.rejected, ..*sample };
        fold_one(&sample, &mut self.tile);
    }
}
