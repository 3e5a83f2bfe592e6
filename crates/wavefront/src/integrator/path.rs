//! Unbiased path tracing with light sampling, as queues.

use std::ops::Range;

use brewster_film::FilmTile;

use super::{begin, end, meet, run, step};
use crate::batch::Batch;
use crate::context::Context;
use crate::queues::RaySource;
use crate::stages::scatter::{Onward, lit, scatter, scatter_medium};
use crate::stages::{Queues, draw, gather, shadow};
use crate::stats::Stage;

/// Follows some samples of every pixel of a tile to their ends, one bounce at a time.
pub fn path(context: &Context<'_>, samples: Range<u32>, batch: &mut Batch, tile: &mut FilmTile<'_>) {
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
    let Batch {
        levels,
        rays,
        sorted,
        draws,
        shadows,
        scratch,
        contributions,
        samples,
        stacks,
        attribution,
        recorder,
        ..
    } = batch;
    let at = |stage| (stage, depth, source);
    let rays = rays.view();
    let (_, mut next) = levels.at(depth);
    macro_rules! scatter {
        ($stage:expr, $length:expr, |$start:ident| ($rows:expr, $lit:expr, $scatter:ident($hits:expr))) => {
            for $start in (0..$length).step_by(run) {
                let (rows, hits) = ($rows, $hits);
                if next.is_some() {
                    recorder.stage(at(Stage::Draw), rows.len(), |_| {
                        draw(context, rays, (rows, $lit), samples.view(), depth, draws);
                    });
                }
                recorder.stage(at($stage), rows.len(), |counts| {
                    let queues = Queues { next: next.as_deref_mut(), shadows, contributions };
                    let mut onward = Onward { depth, queues, stacks };
                    $scatter(context, rays, hits, draws.view(), samples.view(), &mut onward, counts);
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
        ($stage:expr, $hits:expr) => {
            let hits = $hits.view();
            scatter!($stage, hits.columns().len(), |start| (
                hits.run(start, run).columns().rays(),
                lit(context, &hits.run(start, run)),
                scatter(&hits.run(start, run))
            ));
        };
    }
    scatter!(Stage::ScatterLambert, sorted.lambert);
    scatter!(Stage::ScatterRoughDiffuse, sorted.rough_diffuse);
    scatter!(Stage::ScatterMetal, sorted.metal);
    scatter!(Stage::ScatterDielectric, sorted.dielectric);
    scatter!(Stage::ScatterPrincipled, sorted.principled);
    scatter!(Stage::ScatterCoated, sorted.coated);
    let scatterings = sorted.scatterings.view();
    scatter!(Stage::ScatterMedium, scatterings.len(), |start| (
        &scatterings.ray[start..scatterings.len().min(start + run)],
        None,
        scatter_medium(scatterings.slice(start..scatterings.len().min(start + run)))
    ));
}
