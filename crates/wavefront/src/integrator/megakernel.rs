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
use brewster_geometry::{Hit, RayByRay, RayMemory, SurfacePoint, surface};
use glam::Vec3;

use crate::attribution::Attribution;
use crate::batch::Batch;
use crate::context::Context;
use crate::media::{MediaId, MediaStacks};
use crate::queues::{
    Contribution, OnCoated, OnDielectric, OnLambert, OnMetal, OnPrincipled, OnRoughDiffuse, PathRay, PathRaysView,
    RaySource, Sample, Scattering, ShadowRay, SurfaceHit, SurfaceHitsView,
};
use crate::random::{PixelKey, Stream};
use crate::stages::scatter::{Rows, Scatter, cut, scatter_block, scatter_in_medium};
use crate::stages::shade::{Continuation, emitted, light_lambert, light_phong, mirror_at_metal, split_at_dielectric};
use crate::stages::{
    Arrival, Arrived, DrawOnDemand, Met, Outlet, Progress, Traveler, arrive, behind, behind_veil, camera_ray,
    first_hit, first_scattering, fly_on, fold_one, glowing, may_go_on, meet, reached, seen_behind, settle, weaken,
};
use crate::stats::{Counts, Stage, Stats};

/// What goes along with the rays of paths, beside the light that they are followed for.
pub(crate) trait Beside {
    /// What goes along with one ray.
    type Mark: Copy;

    /// That of a camera ray.
    fn start(&mut self) -> Self::Mark;

    /// That of a ray that a hit sends, or sends toward a light, in a direction.
    fn sent(&self, hit: &HitOf<'_>, toward: Toward, mark: Self::Mark, stacks: &mut MediaStacks) -> Self::Mark;

    /// That of a ray toward a light behind what it met when it looked.
    fn met(
        &self,
        ray: &ShadowRay,
        hit: (&Hit, f32),
        met: &Met,
        mark: Self::Mark,
        stacks: &mut MediaStacks,
    ) -> Self::Mark;

    /// Takes light that a ray of a depth brings.
    fn light(&mut self, contribution: &Contribution, depth: u32, sample: &Sample, mark: Self::Mark);

    /// Takes the end of a sample's path.
    fn end(&mut self, sample: &Sample);
}

/// A ray's hit on a kind of material.
pub(crate) struct HitOf<'h> {
    pub(crate) kind: MaterialKind,
    pub(crate) ray: &'h PathRay,
    pub(crate) hit: &'h SurfaceHit,
    pub(crate) sample: &'h Sample,
}

/// Where a hit sends a ray.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Toward {
    /// On.
    Onward(Vec3),
    /// To a light.
    Light(Vec3),
}

/// Nothing goes along.
impl Beside for () {
    type Mark = ();

    #[inline(always)]
    fn start(&mut self) {}

    #[inline(always)]
    fn sent(&self, _: &HitOf<'_>, _: Toward, (): (), _: &mut MediaStacks) {}

    #[inline(always)]
    fn met(&self, _: &ShadowRay, _: (&Hit, f32), _: &Met, (): (), _: &mut MediaStacks) {}

    #[inline(always)]
    fn light(&mut self, _: &Contribution, _: u32, _: &Sample, (): ()) {}

    #[inline(always)]
    fn end(&mut self, _: &Sample) {}
}

/// A ray that waits.
#[derive(Clone, Copy, Debug)]
struct Waiting<M> {
    ray: PathRay,
    depth: u32,
    source: RaySource,
    mark: M,
}

/// What waits while a path is followed: memory that is kept from path to path.
#[derive(Debug, Default)]
pub struct DepthFirst<M = ()> {
    rays: Vec<Waiting<M>>,
    shadows: Vec<ShadowRay>,
    lights: Vec<(Contribution, M)>,
    memory: RayMemory,
}

impl<M> DepthFirst<M> {
    /// Bytes of memory taken.
    pub fn bytes(&self) -> usize {
        self.rays.capacity() * size_of::<Waiting<M>>()
            + self.shadows.capacity() * size_of::<ShadowRay>()
            + self.lights.capacity() * size_of::<(Contribution, M)>()
            + self.memory.bytes()
    }
}

/// What the hit of a path sends.
struct Sent<'w, M> {
    rays: &'w mut Vec<Waiting<M>>,
    /// The depth of rays that a hit sends on.
    next: u32,
    /// What goes along with the ray that met it.
    mark: M,
    shadows: &'w mut Vec<ShadowRay>,
    lights: &'w mut Vec<(Contribution, M)>,
}

impl<M: Copy> Outlet for Sent<'_, M> {
    #[inline(always)]
    fn reflect(&mut self, ray: PathRay) {
        self.rays.push(Waiting { ray, depth: self.next, source: RaySource::Reflection, mark: self.mark });
    }

    #[inline(always)]
    fn transmit(&mut self, ray: PathRay) {
        self.rays.push(Waiting { ray, depth: self.next, source: RaySource::Transmission, mark: self.mark });
    }

    #[inline(always)]
    fn shadow(&mut self, ray: ShadowRay) {
        self.shadows.push(ray);
    }

    #[inline(always)]
    fn light(&mut self, contribution: Contribution) {
        self.lights.push((contribution, self.mark));
    }
}

/// One hit, as a block of rows.
pub(crate) struct Row<'r, 'a> {
    pub(crate) context: &'r Context<'a>,
    pub(crate) ray: &'r PathRay,
    pub(crate) hit: &'r SurfaceHit,
    pub(crate) sample: &'r Sample,
    pub(crate) depth: u32,
}

impl<'r> Rows for Row<'r, '_> {
    type Numbers = DrawOnDemand<'r>;

    #[inline(always)]
    fn len(&self) -> usize {
        1
    }

    #[inline(always)]
    fn depth(&self) -> u32 {
        self.depth
    }

    #[inline(always)]
    fn ray(&self, _: usize) -> PathRay {
        *self.ray
    }

    #[inline(always)]
    fn direction(&self, _: usize) -> Vec3 {
        self.ray.direction()
    }

    #[inline(always)]
    fn hit(&self, _: usize) -> SurfaceHit {
        *self.hit
    }

    #[inline(always)]
    fn point(&self, _: usize) -> SurfacePoint {
        self.hit.point
    }

    #[inline(always)]
    fn numbers(&self, _: usize) -> DrawOnDemand<'r> {
        DrawOnDemand {
            sampler: &self.context.sampler,
            stream: self.stream(self.ray, self.ray.branch),
            depth: self.depth,
        }
    }

    #[inline(always)]
    fn stream(&self, _: &PathRay, branch: u32) -> Stream {
        self.context.sampler.stream(self.sample.key, self.sample.number, branch)
    }
}

/// A path and what it is followed with.
struct Follower<'f, 'a, 't, B: Beside> {
    context: &'f Context<'a>,
    tracer: RayByRay<'f>,
    stacks: &'f mut MediaStacks,
    sent: Sent<'f, B::Mark>,
    beside: &'f mut B,
    stats: &'f mut Stats,
    attribution: &'f mut Attribution,
    tile: &'f mut FilmTile<'t>,
    sample: Sample,
}

/// Follows some samples of every pixel of a tile to their ends, one after the other.
pub fn megakernel(context: &Context<'_>, samples: Range<u32>, batch: &mut Batch, tile: &mut FilmTile<'_>) {
    let mut depth_first = std::mem::take(&mut batch.depth_first);
    follow_beside(context, samples, batch, tile, (&mut depth_first, &mut ()));
    batch.depth_first = depth_first;
}

/// The same, and something goes along.
pub(crate) fn follow_beside<B: Beside>(
    context: &Context<'_>,
    samples: Range<u32>,
    batch: &mut Batch,
    tile: &mut FilmTile<'_>,
    (depth_first, beside): (&mut DepthFirst<B::Mark>, &mut B),
) {
    let start = Instant::now();
    let Batch { stacks, attribution, recorder, .. } = batch;
    stacks.reset();
    let around = stacks.enter_all(&context.camera_media, &context.scene.materials.dielectric.view());
    let DepthFirst { rays, shadows, lights, memory } = depth_first;
    let mut follower = Follower {
        context,
        tracer: RayByRay::new(context.geometry, context.policy.level, memory),
        stacks,
        sent: Sent { rays, next: 0, mark: beside.start(), shadows, lights },
        beside,
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

impl<B: Beside> Follower<'_, '_, '_, B> {
    /// Follows the path of one sample.
    #[inline(always)]
    fn path(&mut self, pixel: u32, number: u32, around: MediaId) {
        let (x, y) = self.tile.pixel(pixel);
        self.sample = Sample { pixel, key: PixelKey::new(x, y), number, light: Light::NONE, rays: 0, rejected: 0 };
        let counts = &mut self.stats.depths[0].counts[RaySource::Primary as usize];
        count(counts, Stage::Generate);
        count(counts, Stage::Fold);
        let ray = camera_ray(self.context, (x, y), number, around);
        let mark = self.beside.start();
        self.sent.rays.push(Waiting { ray, depth: 0, source: RaySource::Primary, mark });
        while let Some(waiting) = self.sent.rays.pop() {
            self.follow(waiting);
        }
        fold_one(&self.sample, self.tile);
        self.beside.end(&self.sample);
    }

    /// Follows one ray to what it meets, and that sends others on.
    #[inline(always)]
    fn follow(&mut self, Waiting { mut ray, depth, source, mark }: Waiting<B::Mark>) {
        let Follower { context, tracer, stacks, sent, stats, tile, sample, .. } = self;
        sent.mark = mark;
        let counts = &mut stats.depths[depth as usize].counts[source as usize];
        [Stage::Order, Stage::Trace, Stage::Sort].into_iter().for_each(|stage| count(counts, stage));
        let mut hit = trace(context, tracer, (&ray, depth), sample, counts);
        if context.has_fog {
            count(counts, Stage::Fly);
            hit = fly(context, tracer, (&mut ray, hit, depth), stacks, sample, counts);
        } else {
            count(counts, Stage::Absorb);
            weaken(context, &mut ray.weight, stacks.filling(ray.media), hit.t, counts);
        }
        let stream = || context.sampler.stream(sample.key, sample.number, ray.branch);
        let time = context.time(sample.key, sample.number);
        let found = (&hit, |ray: &_| surface(&context.geometry, ray, &hit));
        match arrive(context, (&ray, 0, time), found, depth, stream, stacks) {
            Arrival::Nothing => {
                counts.escaped += 1;
                count(counts, Stage::Escape);
                let light = seen_behind(context, depth, &ray, stacks, counts);
                light.into_iter().for_each(|light| sent.light(light));
            }
            Arrival::NoBoundary(crossing) => {
                counts.crossings += 1;
                count(counts, Stage::Cross);
                let ray = behind(context, &ray, &crossing, counts);
                sent.rays.push(Waiting { ray, depth, source: RaySource::Transmission, mark });
            }
            Arrival::Medium(scattering) => {
                counts.scatterings += 1;
                if depth == 0 {
                    count(counts, Stage::Record);
                    tile.add_first_hit(
                        sample.pixel,
                        sample.number,
                        first_scattering(context, (&ray, &scattering, time)),
                    );
                }
                self.scatter_in_medium((&ray, &scattering), depth, source);
                self.shadows(None, depth, source);
            }
            Arrival::Surface(kind, hit) => {
                counts.hits += 1;
                if depth == 0 {
                    count(counts, Stage::Record);
                    let first = first_hit(context, &hit, tile.keeps_parts());
                    tile.add_first_hit(sample.pixel, sample.number, first);
                }
                let waited = sent.rays.len();
                sent.next = depth + 1;
                match context.scene.settings.integrator {
                    Integrator::Whitted => self.shade(kind, (&ray, &hit), depth, source),
                    Integrator::Path => self.scatter(kind, (&ray, &hit), depth, source),
                }
                self.mark((kind, &ray, &hit), waited);
                self.shadows(Some((kind, &ray, &hit)), depth, source);
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
        let (rays, hits) = (PathRaysView::of(ray), SurfaceHitsView::of(hit));
        match kind {
            MaterialKind::Phong => {
                count(counts, Stage::ShadePhong);
                light_phong::<1>(context, rays, hits, sent);
            }
            MaterialKind::Lambert => {
                count(counts, Stage::ShadeLambert);
                light_lambert::<1>(context, rays, hits, sent);
            }
            MaterialKind::Metal => {
                count(counts, Stage::ShadeMetal);
                mirror_at_metal::<1>(context, (rays, hits), stacks, goes_on, sent, counts);
            }
            MaterialKind::Dielectric => {
                count(counts, Stage::ShadeDielectric);
                split_at_dielectric::<1>(context, (rays, hits), stacks, goes_on, sent, counts);
            }
            MaterialKind::Emissive => {
                count(counts, Stage::ShadeEmissive);
                emitted(context, ray, hit, stacks, counts).into_iter().for_each(|light| sent.light(light));
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
                emitted(context, ray, hit, stacks, counts).into_iter().for_each(|light| sent.light(light));
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
                glowing(context, || *ray, hit, stacks).into_iter().for_each(|light| sent.light(light));
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
        let row = Row { context, ray, hit, sample, depth };
        scatter_block::<Kind, _, 1>(context, &row, sent, stacks, counts);
    }

    /// What a medium makes of a ray that it scatters; it changes no mark.
    #[inline(always)]
    fn scatter_in_medium(&mut self, (ray, scattering): (&PathRay, &Scattering), depth: u32, source: RaySource) {
        let Follower { context, stacks, sent, stats, sample, .. } = self;
        let counts = &mut stats.depths[depth as usize].counts[source as usize];
        count(counts, Stage::ScatterMedium);
        if depth == context.scene.settings.max_depth {
            return cut(context, ray.weight, counts);
        }
        count(counts, Stage::Draw);
        sent.next = depth + 1;
        let stream = context.sampler.stream(sample.key, sample.number, ray.branch);
        let numbers = DrawOnDemand { sampler: &context.sampler, stream, depth };
        let event = (ray, scattering, context.time(sample.key, sample.number));
        scatter_in_medium(context, event, numbers, stacks, sent, counts);
    }

    /// Marks the rays that the hit sent on: those behind the ones that waited before.
    #[inline(always)]
    fn mark(&mut self, (kind, ray, hit): (MaterialKind, &PathRay, &SurfaceHit), waited: usize) {
        let Follower { beside, stacks, sent, sample, .. } = self;
        let hit = HitOf { kind, ray, hit, sample };
        for waiting in &mut sent.rays[waited..] {
            waiting.mark = beside.sent(&hit, Toward::Onward(waiting.ray.direction()), sent.mark, stacks);
        }
    }

    /// Tests what a hit, or a scattering in a medium, sent toward lights.
    #[inline(always)]
    fn shadows(&mut self, hit: Option<(MaterialKind, &PathRay, &SurfaceHit)>, depth: u32, source: RaySource) {
        let Follower { stats, sent, .. } = self;
        let sent = sent.shadows.len();
        let counts = &mut stats.depths[depth as usize].counts[source as usize];
        counts.stages[Stage::Shadow as usize] += sent as u64;
        counts.shadow_rays += sent as u64;
        for row in 0..sent {
            let Follower { context, tracer, stacks, sent, beside, stats, sample, .. } = self;
            let counts = &mut stats.depths[depth as usize].counts[source as usize];
            let shadow_ray = sent.shadows[row];
            let toward = Toward::Light(shadow_ray.direction());
            let mut mark = sent.mark;
            if let Some((kind, ray, hit)) = hit {
                mark = beside.sent(&HitOf { kind, ray, hit, sample }, toward, mark, stacks);
            }
            let seen = |ray: &ShadowRay, hit: (&Hit, f32), stacks: &mut MediaStacks| {
                let met = meet(context, ray, hit, stacks);
                mark = beside.met(ray, hit, &met, mark, stacks);
                met
            };
            match shadow(context, tracer, (shadow_ray, seen), stacks, sample, counts) {
                Some(light) => sent.lights.push((light, mark)),
                None => counts.shadowed += 1,
            }
        }
        self.sent.shadows.clear();
    }

    /// Adds the light that was found to the sample.
    #[inline(always)]
    fn gather(&mut self, depth: u32, source: RaySource) {
        let Follower { context, sent, beside, stats, attribution, tile, sample, .. } = self;
        let counts = &mut stats.depths[depth as usize].counts[source as usize];
        for (contribution, mark) in sent.lights.drain(..) {
            count(counts, Stage::Gather);
            beside.light(&contribution, depth, sample, mark);
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
    let (mut ray, mut passed) = (path.ray(context.time(sample.key, sample.number)), 0.0);
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

/// Takes a ray through media to what it meets behind them, or to where they scatter it.
#[inline(always)]
fn fly(
    context: &Context<'_>,
    tracer: &mut RayByRay<'_>,
    (path, mut hit, depth): (&mut PathRay, Hit, u32),
    stacks: &mut MediaStacks,
    sample: &mut Sample,
    counts: &mut Counts,
) -> Hit {
    let (mut ray, mut progress) = (path.ray(context.time(sample.key, sample.number)), Progress::default());
    let stream = context.sampler.stream(sample.key, sample.number, path.branch);
    loop {
        let traveler = Traveler { weight: &mut path.weight, media: &mut path.media };
        match fly_on(context, traveler, (&ray, &hit), (&mut progress, depth, stream), stacks, counts) {
            Arrived::At(hit) => return hit,
            Arrived::Behind(origin) => ray.origin = origin,
        }
        hit = tracer.closest_hit(&ray);
        counts.passed += 1;
        sample.rays += 1;
    }
}

/// What a ray toward a light brings; it is told what it meets.
#[inline(always)]
fn shadow(
    context: &Context<'_>,
    tracer: &mut RayByRay<'_>,
    (mut ray, mut seen): (ShadowRay, impl FnMut(&ShadowRay, (&Hit, f32), &mut MediaStacks) -> Met),
    stacks: &mut MediaStacks,
    sample: &mut Sample,
    counts: &mut Counts,
) -> Option<Contribution> {
    let time = context.time(sample.key, sample.number);
    if !context.scene.settings.transparent_shadows {
        counts.shadow_segments += 1;
        sample.rays += 1;
        if !tracer.occluded(&ray.ray(time), ray.distance) {
            return Some(reached(context, &ray, stacks));
        }
        if !may_go_on(context, &ray) {
            return None;
        }
    }
    loop {
        counts.shadow_segments += 1;
        sample.rays += 1;
        let hit = tracer.closest_hit(&ray.ray(time));
        match seen(&ray, (&hit, time), stacks) {
            Met::Light(contribution) => return Some(contribution),
            Met::Passed(behind) => ray = behind,
            Met::Blocked => return None,
        }
    }
}
