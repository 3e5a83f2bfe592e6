//! Integrators: which stages a bounce runs, in which order.
//!
//! **Depth.** A camera ray has depth 0. A ray's hit on a surface is an interaction of the ray's depth; it sends reflections
//! and transmissions of depth + 1 only while depth < `max_depth`. So `max_depth` is the number of interactions on a path that
//! may scatter on, in media and on surfaces. `Whitted` lights the last interaction too: 0 shows direct light alone. To `Path`, what comes from a light is
//! scattered on like all else: 0 shows emitters alone, 1 direct light. Crossing a boundary that is none (inside a medium of
//! higher priority, or of one without a surface), or passing a surface that is absent there, is no interaction and leaves the depth as it is.
//!
//! What each integrator does with each thing a scene may hold:
//!
//! | | `Whitted` | `Path` |
//! | --- | --- | --- |
//! | Phong | ambient + albedo/π · N·L + highlight, shadow-tested | an error: it is no physical material |
//! | Lambert | albedo/π · N·L, shadow-tested | the same, and light from everywhere else |
//! | RoughDiffuse | an error | EON |
//! | Metal | highlight · R_0, mirror image · F_r; a film: an error | smooth or GGX, with a thin film; no highlight |
//! | Dielectric | highlights · F_r or F_t; reflection · F_r and transmission · F_t; absorption inside; a film: an error | smooth, GGX or thin, with a thin film; F_r and F_t by chance, above `split_depth` both; absorption inside; radiance over the squared index is what crosses |
//! | Principled | an error | glTF's lobes: reflection and transmission by chance, above `split_depth` both; its emission lights whatever sees it |
//! | Coated | an error | a smooth or GGX coat over Lambert's surface or metal; what it absorbs |
//! | Emissive | its radiance where a ray meets it; it lights nothing else | lights whatever sees it |
//! | a medium that scatters | an error | free flights, Henyey and Greenstein's phase function; a scattering is an interaction |
//! | a medium without a surface | an error | rays and rays toward lights go straight in and out, where the index is that of the other side; no interaction |
//! | opacity: mask, blend | a ray meets the surface or goes straight on at its depth, by chance; rays toward lights are weakened | the same |
//! | normal map, heights | in place of the shading normal, held where a mirror image can be seen | the same |
//! | point, spot, directional light | direct light and highlights | direct light, on what is not smooth |
//! | ambient light | Phong's ambient term | nothing: it is for Phong alone |
//! | background | what escaped rays see | lights whatever sees it |
//! | transparent shadows | shadow rays pass dielectrics, straight | an error: paths find what they should |
//! | motion of shapes, lights and the camera | each sample looks at a moment of the shutter's time | the same |
//! | thin lens | an error: this integrator takes pinhole and orthographic cameras | a lens |

mod megakernel;
mod path;
mod whitted;

pub(crate) use megakernel::{Beside, HitOf, Row, Toward, follow_beside};
pub use megakernel::{DepthFirst, megakernel};
pub use path::path;
pub use whitted::whitted;

use std::ops::Range;

use brewster_buffers::Integrator;
use brewster_film::FilmTile;

use crate::batch::Batch;
use crate::context::Context;
use crate::queues::RaySource;
use crate::stages::scatter::SHADOW_RAYS;
use crate::stages::shade::shade_emissive;
use crate::stages::{
    Arrivals, absorb, cross, escape, fly, fold, gather, generate, glow, order, record, record_scatterings, sort, trace,
};
use crate::stats::Stage;

/// Makes the camera rays of some samples of every pixel of a tile.
pub fn begin(context: &Context<'_>, numbers: Range<u32>, batch: &mut Batch, tile: &FilmTile<'_>) {
    let Batch { levels, samples, shadows, stacks, recorder, .. } = batch;
    shadows.reserve(run(context) * shadow_rays(context));
    stacks.reset();
    let around = stacks.enter_all(&context.camera_media, &context.scene.materials.dielectric.view());
    recorder.stage((Stage::Generate, 0, RaySource::Primary), tile.len() * numbers.len(), |_| {
        generate(context, numbers, around, tile, samples, &mut levels.primary);
    });
}

/// Takes the rays that go next to what they meet, and what they meet sends others on. Tells the rays' depth and queue; nothing
/// when no ray waits.
///
/// Until the next step, the batch holds what this one did: the rays, their weights behind the media on their way; their hits,
/// and these by kind of material. What the hits sent waits in the levels.
pub fn step(context: &Context<'_>, batch: &mut Batch, tile: &mut FilmTile<'_>) -> Option<(u32, RaySource)> {
    let at = batch.levels.take(context.policy.order, &mut batch.rays)?;
    bounce(context, at, batch, tile);
    Some(at)
}

/// The step of rays that the batch has taken, of a depth and queue.
pub(crate) fn bounce(context: &Context<'_>, at: (u32, RaySource), batch: &mut Batch, tile: &mut FilmTile<'_>) {
    match context.scene.settings.integrator {
        Integrator::Whitted => whitted::bounce(context, at, batch, tile),
        Integrator::Path => path::bounce(context, at, batch, tile),
    }
}

/// Adds the samples, whose paths have come to their ends, to the film.
pub fn end(batch: &mut Batch, tile: &mut FilmTile<'_>) {
    let Batch { samples, recorder, .. } = batch;
    recorder.stage((Stage::Fold, 0, RaySource::Primary), samples.len(), |_| fold(samples.view(), tile));
}

/// Shadow rays that a hit sends at most.
fn shadow_rays(context: &Context<'_>) -> usize {
    match context.scene.settings.integrator {
        Integrator::Whitted => context.scene.lights.len().max(1),
        Integrator::Path => SHADOW_RAYS,
    }
}

/// Hits that are shaded at once: the shadow queue stays within its capacity however many lights there are.
fn run(context: &Context<'_>) -> usize {
    (context.policy.capacity / shadow_rays(context)).max(1)
}

/// Takes the rays to what they meet: escaped ones get the background, those that meet light its radiance; the others' hits are
/// left sorted by kind of material.
fn meet(context: &Context<'_>, (depth, source): (u32, RaySource), batch: &mut Batch, tile: &mut FilmTile<'_>) {
    let Batch {
        levels,
        rays,
        ordered,
        hits,
        passing,
        flying,
        sorted,
        contributions,
        samples,
        stacks,
        attribution,
        recorder,
        ..
    } = batch;
    let at = |stage| (stage, depth, source);
    recorder.stage(at(Stage::Order), rays.len(), |_| order(context, rays, ordered));
    recorder.stage(at(Stage::Trace), rays.len(), |counts| {
        trace(context, rays.view(), depth, hits, passing, samples.view_mut(), counts);
    });
    if let Some(survey) = &mut recorder.survey {
        survey.look(context, (depth, source), (rays.view(), samples.view()), hits.view());
    }
    if context.has_fog {
        recorder.stage(at(Stage::Fly), rays.len(), |counts| {
            fly(context, (rays.view_mut(), hits.view_mut()), depth, stacks, flying, samples.view_mut(), counts);
        });
    } else {
        recorder.stage(at(Stage::Absorb), rays.len(), |counts| {
            absorb(context, stacks, hits.view(), rays.view_mut(), counts);
        });
    }
    recorder.stage(at(Stage::Sort), rays.len(), |counts| {
        let arrivals = Arrivals { rays: rays.view(), hits: hits.view(), samples: samples.view(), depth };
        sort(context, arrivals, stacks, sorted, counts);
    });
    let rays = rays.view();
    recorder.stage(at(Stage::Cross), sorted.crossings.len(), |counts| {
        cross(context, rays, sorted.crossings.view(), &mut levels.at(depth).0.transmission, counts);
    });
    if depth == 0 {
        recorder.stage(at(Stage::Record), sorted.hits() + sorted.scatterings.len(), |_| {
            sorted.each(|hits| record(context, rays, hits, samples.view(), tile));
            record_scatterings(context, rays, sorted.scatterings.view(), samples.view(), tile);
        });
    }
    recorder.stage(at(Stage::Escape), sorted.escaped.len(), |counts| {
        escape(context, depth, rays, sorted.escaped.view(), stacks, contributions, counts);
    });
    recorder.stage(at(Stage::ShadeEmissive), sorted.emissive.len(), |counts| {
        shade_emissive(context, rays, &sorted.emissive.view(), stacks, contributions, counts);
    });
    recorder.stage(at(Stage::Glow), sorted.principled.len(), |_| {
        glow(context, rays, &sorted.principled.view(), stacks, contributions);
    });
    recorder.stage(at(Stage::Gather), contributions.len(), |counts| {
        gather(context, depth, contributions, samples.view_mut(), tile, attribution, counts);
    });
}
