//! Both integrators without queues: every path is followed ray by ray, depth first, to its end.
//!
//! What a wavefront is measured against. The shading is the stages' own, row by row; rays go through the scene one at a time
//! ([`RayByRay`]); random numbers are drawn where they are needed. Picture and counts are those of the wavefront, to the bit. What
//! waits are the siblings of the rays on the way to the one that is followed, at most a few a depth, and what one hit has sent
//! toward lights.

use std::ops::Range;
use std::time::Instant;

use brewster_buffers::{Integrator, MaterialKind};
use brewster_film::{FilmTile, Light, Part};
use brewster_geometry::{Hit, RayByRay, RayMemory};

use crate::attribution::Attribution;
use crate::batch::Batch;
use crate::context::Context;
use crate::media::{MediaId, MediaStacks};
use crate::queues::{
    Contribution, OnCoated, OnDielectric, OnLambert, OnMetal, OnPrincipled, OnRoughDiffuse, PathRay, RaySource, Sample,
    ShadowRay, SurfaceHit,
};
use crate::random::PixelKey;
use crate::stages::scatter::{Scatter, cut, scatter_at};
use crate::stages::shade::{Continuation, emitted, light_lambert, light_phong, mirror_at_metal, split_at_dielectric};
use crate::stages::{
    Arrival, DrawOnDemand, Met, Outlet, arrive, behind, behind_veil, camera_ray, first_hit, fold_one, glowing,
    may_go_on, meet, reached, seen_behind, settle, weaken,
};
use crate::stats::{Counts, Stage, Stats};

/// A ray that waits.
#[derive(Clone, Copy, Debug)]
struct Waiting {
    ray: PathRay,
    depth: u32,
    source: RaySource,
}

/// What waits while a path is followed: memory that is kept from path to path.
#[derive(Debug, Default)]
pub struct DepthFirst {
    rays: Vec<Waiting>,
    shadows: Vec<ShadowRay>,
    lights: Vec<Contribution>,
    memory: RayMemory,
}

impl DepthFirst {
    /// Bytes of memory taken.
    pub fn bytes(&self) -> usize {
        self.rays.capacity() * size_of::<Waiting>()
            + self.shadows.capacity() * size_of::<ShadowRay>()
            + self.lights.capacity() * size_of::<Contribution>()
            + self.memory.bytes()
    }
}

/// What the hit of a path sends.
struct Sent<'w> {
    rays: &'w mut Vec<Waiting>,
    /// The depth of rays that a hit sends on.
    next: u32,
    shadows: &'w mut Vec<ShadowRay>,
    lights: &'w mut Vec<Contribution>,
}

impl Outlet for Sent<'_> {
    #[inline(always)]
    fn reflect(&mut self, ray: PathRay) {
        self.rays.push(Waiting { ray, depth: self.next, source: RaySource::Reflection });
    }

    #[inline(always)]
    fn transmit(&mut self, ray: PathRay) {
        self.rays.push(Waiting { ray, depth: self.next, source: RaySource::Transmission });
    }

    #[inline(always)]
    fn shadow(&mut self, ray: ShadowRay) {
        self.shadows.push(ray);
    }

    #[inline(always)]
    fn light(&mut self, contribution: Contribution) {
        self.lights.push(contribution);
    }
}

/// A path and what it is followed with.
struct Follower<'f, 'a, 't> {
    context: &'f Context<'a>,
    tracer: RayByRay<'f>,
    stacks: &'f mut MediaStacks,
    sent: Sent<'f>,
    stats: &'f mut Stats,
    attribution: &'f mut Attribution,
    tile: &'f mut FilmTile<'t>,
    sample: Sample,
}

/// Follows some samples of every pixel of a tile to their ends, one after the other.
pub fn megakernel(context: &Context<'_>, samples: Range<u32>, batch: &mut Batch, tile: &mut FilmTile<'_>) {
    let start = Instant::now();
    let Batch { stacks, attribution, recorder, depth_first, .. } = batch;
    stacks.reset();
    let around = stacks.enter_all(&context.camera_media, &context.scene.materials.dielectric.view());
    let DepthFirst { rays, shadows, lights, memory } = depth_first;
    let mut follower = Follower {
        context,
        tracer: RayByRay::new(context.geometry, context.policy.level, memory),
        stacks,
        sent: Sent { rays, next: 0, shadows, lights },
        stats: &mut recorder.stats,
        attribution,
        tile,
        sample: Sample { pixel: 0, key: PixelKey::new(0, 0), number: 0, light: Light::NONE, rays: 0, rejected: 0 },
    };
    for pixel in 0..follower.tile.len() as u32 {
        for number in samples.clone() {
            follower.path(pixel, number, around);
        }
    }
    recorder.stats.unstaged += start.elapsed();
}

impl Follower<'_, '_, '_> {
    /// Follows the path of one sample.
    #[inline(always)]
    fn path(&mut self, pixel: u32, number: u32, around: MediaId) {
        let (x, y) = self.tile.pixel(pixel);
        self.sample = Sample { pixel, key: PixelKey::new(x, y), number, light: Light::NONE, rays: 0, rejected: 0 };
        let counts = &mut self.stats.depths[0].counts[RaySource::Primary as usize];
        count(counts, Stage::Generate);
        count(counts, Stage::Fold);
        let ray = camera_ray(self.context, (x, y), number, around);
        self.sent.rays.push(Waiting { ray, depth: 0, source: RaySource::Primary });
        while let Some(waiting) = self.sent.rays.pop() {
            self.follow(waiting);
        }
        fold_one(&self.sample, self.tile);
    }

    /// Follows one ray to what it meets, and that sends others on.
    #[inline(always)]
    fn follow(&mut self, Waiting { mut ray, depth, source }: Waiting) {
        let Follower { context, tracer, stacks, sent, stats, tile, sample, .. } = self;
        let counts = &mut stats.depths[depth as usize].counts[source as usize];
        [Stage::Order, Stage::Trace, Stage::Absorb, Stage::Sort].into_iter().for_each(|stage| count(counts, stage));
        let hit = trace(context, tracer, (&ray, depth), sample, counts);
        weaken(context, &mut ray.weight, stacks.filling(ray.media), hit.t, counts);
        let stream = || context.sampler.stream(sample.key, sample.number, ray.branch);
        match arrive(context, (&ray, 0), &hit, depth, stream, stacks) {
            Arrival::Nothing => {
                counts.escaped += 1;
                count(counts, Stage::Escape);
                sent.lights.extend(seen_behind(context, depth, &ray, stacks, counts));
            }
            Arrival::NoBoundary(crossing) => {
                counts.crossings += 1;
                count(counts, Stage::Cross);
                let ray = behind(context, &ray, &crossing, counts);
                sent.rays.push(Waiting { ray, depth, source: RaySource::Transmission });
            }
            Arrival::Surface(kind, hit) => {
                counts.hits += 1;
                if depth == 0 {
                    count(counts, Stage::Record);
                    let first = first_hit(context, &hit, tile.keeps_parts());
                    tile.add_first_hit(sample.pixel, sample.number, first);
                }
                sent.next = depth + 1;
                match context.scene.settings.integrator {
                    Integrator::Whitted => self.shade(kind, (&ray, &hit), depth, source),
                    Integrator::Path => self.scatter(kind, (&ray, &hit), depth, source),
                }
                self.shadows(depth, source);
            }
        }
        self.gather(depth, source);
    }

    /// What `Whitted` makes of a hit.
    #[inline(always)]
    fn shade(&mut self, kind: MaterialKind, (ray, hit): (&PathRay, &SurfaceHit), depth: u32, source: RaySource) {
        let Follower { context, stacks, sent, stats, .. } = self;
        let counts = &mut stats.depths[depth as usize].counts[source as usize];
        let settings = &context.scene.settings;
        let goes_on = Continuation { goes_on: depth < settings.max_depth, threshold: settings.contribution_threshold };
        match kind {
            MaterialKind::Phong => {
                count(counts, Stage::ShadePhong);
                light_phong(context, ray, hit, sent);
            }
            MaterialKind::Lambert => {
                count(counts, Stage::ShadeLambert);
                light_lambert(context, ray, hit, sent);
            }
            MaterialKind::Metal => {
                count(counts, Stage::ShadeMetal);
                mirror_at_metal(context, (ray, hit), stacks, goes_on, sent, counts);
            }
            MaterialKind::Dielectric => {
                count(counts, Stage::ShadeDielectric);
                split_at_dielectric(context, (ray, hit), stacks, goes_on, sent, counts);
            }
            MaterialKind::Emissive => {
                count(counts, Stage::ShadeEmissive);
                sent.lights.extend(emitted(context, ray, hit, stacks, counts));
            }
            MaterialKind::RoughDiffuse | MaterialKind::Principled | MaterialKind::Coated | MaterialKind::Mix => {}
        }
    }

    /// What `Path` makes of a hit.
    #[inline(always)]
    fn scatter(&mut self, kind: MaterialKind, (ray, hit): (&PathRay, &SurfaceHit), depth: u32, source: RaySource) {
        let Follower { context, stacks, sent, stats, .. } = self;
        let counts = &mut stats.depths[depth as usize].counts[source as usize];
        match kind {
            MaterialKind::Emissive => {
                count(counts, Stage::ShadeEmissive);
                sent.lights.extend(emitted(context, ray, hit, stacks, counts));
            }
            MaterialKind::Lambert => self.scatter_at::<OnLambert>(Stage::ScatterLambert, ray, hit, depth, source),
            MaterialKind::RoughDiffuse => {
                self.scatter_at::<OnRoughDiffuse>(Stage::ScatterRoughDiffuse, ray, hit, depth, source);
            }
            MaterialKind::Metal => self.scatter_at::<OnMetal>(Stage::ScatterMetal, ray, hit, depth, source),
            MaterialKind::Dielectric => {
                self.scatter_at::<OnDielectric>(Stage::ScatterDielectric, ray, hit, depth, source);
            }
            MaterialKind::Principled => {
                count(counts, Stage::Glow);
                sent.lights.extend(glowing(context, || *ray, hit, stacks));
                self.scatter_at::<OnPrincipled>(Stage::ScatterPrincipled, ray, hit, depth, source);
            }
            MaterialKind::Coated => self.scatter_at::<OnCoated>(Stage::ScatterCoated, ray, hit, depth, source),
            MaterialKind::Phong | MaterialKind::Mix => {}
        }
    }

    fn scatter_at<Kind: Scatter>(
        &mut self,
        stage: Stage,
        ray: &PathRay,
        hit: &SurfaceHit,
        depth: u32,
        source: RaySource,
    ) {
        let Follower { context, stacks, sent, stats, sample, .. } = self;
        let counts = &mut stats.depths[depth as usize].counts[source as usize];
        count(counts, stage);
        if depth == context.scene.settings.max_depth {
            return cut(context, ray.weight, counts);
        }
        count(counts, Stage::Draw);
        let stream = |branch| context.sampler.stream(sample.key, sample.number, branch);
        let numbers = DrawOnDemand { sampler: &context.sampler, stream: stream(ray.branch), depth };
        scatter_at::<Kind>(context, (*ray, *hit, depth), numbers, || stream(1), sent, stacks, counts);
    }

    /// Tests what the hit sent toward lights.
    #[inline(always)]
    fn shadows(&mut self, depth: u32, source: RaySource) {
        let Follower { context, tracer, stacks, sent, stats, sample, .. } = self;
        let counts = &mut stats.depths[depth as usize].counts[source as usize];
        for ray in sent.shadows.drain(..) {
            count(counts, Stage::Shadow);
            counts.shadow_rays += 1;
            match shadow(context, tracer, ray, stacks, sample, counts) {
                Some(light) => sent.lights.push(light),
                None => counts.shadowed += 1,
            }
        }
    }

    /// Adds the light that was found to the sample.
    #[inline(always)]
    fn gather(&mut self, depth: u32, source: RaySource) {
        let Follower { context, sent, stats, attribution, tile, sample, .. } = self;
        let counts = &mut stats.depths[depth as usize].counts[source as usize];
        for contribution in sent.lights.drain(..) {
            count(counts, Stage::Gather);
            match settle(context, depth, &contribution, || *sample, attribution, counts) {
                Some(light) => {
                    let part = contribution.trail.part();
                    if part != Part::Direct && tile.keeps_parts() {
                        tile.add_part(sample.pixel, part, light);
                    }
                    sample.light.add(light);
                }
                None => sample.rejected += 1,
            }
        }
    }
}

#[inline(always)]
fn count(counts: &mut Counts, stage: Stage) {
    counts.stages[stage as usize] += 1;
}

/// What a ray of a depth meets, past what is not there.
#[inline(always)]
fn trace(
    context: &Context<'_>,
    tracer: &mut RayByRay<'_>,
    (path, depth): (&PathRay, u32),
    sample: &mut Sample,
    counts: &mut Counts,
) -> Hit {
    let (mut ray, mut passed) = (path.ray(), 0.0);
    let mut hit = tracer.closest_hit(&ray);
    sample.rays += 1;
    if !context.may_be_absent(depth) {
        return hit;
    }
    let (key, number) = (sample.key, sample.number);
    let stream = || context.sampler.stream(key, number, path.branch);
    while let Some(behind) = behind_veil(context, (&ray, &hit), passed, depth, stream) {
        (ray.origin, passed) = behind;
        hit = tracer.closest_hit(&ray);
        counts.passed += 1;
        sample.rays += 1;
    }
    Hit { t: passed + hit.t, ..hit }
}

/// What a ray toward a light brings.
#[inline(always)]
fn shadow(
    context: &Context<'_>,
    tracer: &mut RayByRay<'_>,
    mut ray: ShadowRay,
    stacks: &mut MediaStacks,
    sample: &mut Sample,
    counts: &mut Counts,
) -> Option<Contribution> {
    if !context.scene.settings.transparent_shadows {
        counts.shadow_segments += 1;
        sample.rays += 1;
        if !tracer.occluded(&ray.ray(), ray.distance) {
            return Some(reached(context, &ray, stacks));
        }
        if !may_go_on(context, &ray) {
            return None;
        }
    }
    loop {
        counts.shadow_segments += 1;
        sample.rays += 1;
        let hit = tracer.closest_hit(&ray.ray());
        match meet(context, &ray, &hit, stacks) {
            Met::Light(contribution) => return Some(contribution),
            Met::Passed(behind) => ray = behind,
            Met::Blocked => return None,
        }
    }
}
