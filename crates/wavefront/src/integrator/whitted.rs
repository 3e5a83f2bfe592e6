//! The deterministic algorithm of the lectures, as queues.

use std::ops::Range;

use brewster_film::FilmTile;

use crate::batch::Batch;
use crate::context::Context;
use crate::queues::RaySource;
use crate::stages::shade::{Continuation, shade_dielectric, shade_emissive, shade_lambert, shade_metal, shade_phong};
use crate::stages::{absorb, cross, escape, gather, generate, order, record, shadow, sort, trace};
use crate::stats::Stage;

/// Follows some samples of every pixel of a tile to their ends, one bounce at a time.
pub fn whitted(context: &Context<'_>, samples: Range<u32>, batch: &mut Batch, tile: &mut FilmTile<'_>) {
    let Batch { levels, rays, ordered, hits, sorted, shadows, scratch, contributions, stacks, recorder } = batch;
    let dielectrics = context.scene.materials.dielectric.view();
    stacks.reset();
    let around = stacks.enter_all(&context.camera_media, &dielectrics);
    recorder.stage((Stage::Generate, 0, RaySource::Primary), tile.len() * samples.len(), |_| {
        generate(context, samples, around, tile, &mut levels.primary);
    });
    // Hits are shaded in runs, so that the shadow queue stays within its capacity however many lights there are.
    let lights = context.scene.lights.len().max(1);
    let run = (context.policy.capacity / lights).max(1);
    shadows.reserve(run * lights);
    while let Some((depth, source)) = levels.take(context.policy.order, rays) {
        let at = |stage| (stage, depth, source);
        let (here, next) = levels.at(depth);
        let mut onward = Continuation { next, threshold: context.scene.settings.contribution_threshold };

        recorder.stage(at(Stage::Order), rays.len(), |_| order(context.policy.sort, rays, ordered));
        recorder.stage(at(Stage::Trace), rays.len(), |_| trace(context, rays.view(), hits, tile));
        recorder.stage(at(Stage::Absorb), rays.len(), |_| absorb(context, stacks, hits.view(), rays.view_mut()));
        recorder.stage(at(Stage::Sort), rays.len(), |counts| {
            sort(context, rays.view(), hits.view(), stacks, sorted, counts);
        });
        let rays = rays.view();
        recorder.stage(at(Stage::Cross), sorted.crossings.len(), |_| {
            cross(rays, sorted.crossings.view(), &mut here.transmission);
        });
        if depth == 0 {
            recorder.stage(at(Stage::Record), sorted.hits(), |_| {
                sorted.each(|hits| record(context, rays, hits, tile));
            });
        }
        recorder.stage(at(Stage::Escape), sorted.escaped.len(), |_| {
            escape(context, sorted.escaped.view(), contributions);
        });
        recorder.stage(at(Stage::ShadeEmissive), sorted.emissive.len(), |_| {
            shade_emissive(context, rays, &sorted.emissive.view(), contributions);
        });
        macro_rules! shade {
            ($stage:expr, $hits:expr, |$view:ident, $counts:ident| $shade:expr) => {
                for start in (0..$hits.len()).step_by(run) {
                    let $view = $hits.view().run(start, run);
                    recorder.stage(at($stage), $view.columns().len(), |$counts| $shade);
                    recorder.stage(at(Stage::Shadow), shadows.len(), |counts| {
                        shadow(context, shadows, stacks, scratch, contributions, tile, counts);
                    });
                    recorder.stage(at(Stage::Gather), contributions.len(), |_| gather(contributions, tile));
                }
            };
        }
        shade!(Stage::ShadePhong, sorted.phong, |hits, _counts| {
            shade_phong(context, rays, &hits, shadows, contributions)
        });
        shade!(Stage::ShadeLambert, sorted.lambert, |hits, _counts| { shade_lambert(context, rays, &hits, shadows) });
        shade!(Stage::ShadeMetal, sorted.metal, |hits, counts| {
            shade_metal(context, rays, &hits, stacks, shadows, &mut onward, counts)
        });
        shade!(Stage::ShadeDielectric, sorted.dielectric, |hits, counts| {
            shade_dielectric(context, rays, &hits, stacks, shadows, &mut onward, counts)
        });
        recorder.stage(at(Stage::Gather), contributions.len(), |_| gather(contributions, tile));
    }
}
