//! The deterministic algorithm of the lectures, as queues.

use std::ops::Range;

use brewster_film::FilmTile;

use super::{begin, end, meet, run, step};
use crate::batch::Batch;
use crate::context::Context;
use crate::queues::RaySource;
use crate::stages::shade::{Continuation, shade_dielectric, shade_lambert, shade_metal, shade_phong};
use crate::stages::{Queues, gather, shadow};
use crate::stats::Stage;

/// Follows some samples of every pixel of a tile to their ends, one bounce at a time.
pub fn whitted(context: &Context<'_>, samples: Range<u32>, batch: &mut Batch, tile: &mut FilmTile<'_>) {
    begin(context, samples, batch, tile);
    while step(context, batch, tile).is_some() {}
    end(batch, tile);
}

/// [`super::bounce`].
pub(super) fn bounce(
    context: &Context<'_>,
    (depth, source): (u32, RaySource),
    batch: &mut Batch,
    tile: &mut FilmTile<'_>,
) {
    meet(context, (depth, source), batch, tile);
    let run = run(context);
    let Batch { levels, rays, sorted, shadows, scratch, contributions, samples, stacks, attribution, recorder, .. } =
        batch;
    let at = |stage| (stage, depth, source);
    let rays = rays.view();
    let (_, mut next) = levels.at(depth);
    let continuation =
        Continuation { goes_on: next.is_some(), threshold: context.scene.settings.contribution_threshold };
    macro_rules! shade {
        ($stage:expr, $hits:expr, |$view:ident, $queues:ident, $counts:ident| $shade:expr) => {
            for start in (0..$hits.len()).step_by(run) {
                let $view = $hits.view().run(start, run);
                recorder.stage(at($stage), $view.columns().len(), |$counts| {
                    let $queues = &mut Queues { next: next.as_deref_mut(), shadows, contributions };
                    $shade
                });
                attribution.note_shadows(shadows);
                if let Some(survey) = &mut recorder.survey {
                    survey.look_toward_lights(context, (depth, source), (shadows, samples.view()));
                }
                recorder.stage(at(Stage::Shadow), shadows.len(), |counts| {
                    shadow(context, shadows, stacks, scratch, contributions, samples.view_mut(), counts);
                });
                recorder.stage(at(Stage::Gather), contributions.len(), |counts| {
                    gather(context, depth, contributions, samples.view_mut(), tile, attribution, counts);
                });
            }
        };
    }
    shade!(Stage::ShadePhong, sorted.phong, |hits, queues, _counts| shade_phong(context, rays, &hits, queues));
    shade!(Stage::ShadeLambert, sorted.lambert, |hits, queues, _counts| shade_lambert(context, rays, &hits, queues));
    shade!(Stage::ShadeMetal, sorted.metal, |hits, queues, counts| {
        shade_metal(context, rays, &hits, stacks, continuation, queues, counts)
    });
    shade!(Stage::ShadeDielectric, sorted.dielectric, |hits, queues, counts| {
        shade_dielectric(context, rays, &hits, stacks, continuation, queues, counts)
    });
}
