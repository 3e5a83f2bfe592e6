//! Parts hits by kind of material, and those that escaped.

use std::ops::Range;

use brewster_buffers::{DetailId, MaterialKind, Mix, SeenPlace};
use brewster_geometry::{Hit, HitsView, MISS, Ray, Rays, SurfacePoint, offset_origin, surfaces};

use crate::context::Context;
use crate::media::{MediaStacks, Medium};
use crate::policy::Compaction;
use crate::queues::{
    CoatedHits, Crossing, CrossingQueue, DielectricHits, EmissiveHits, Escaped, EscapedQueue, LambertHits, MetalHits,
    PathRay, PathRaysView, PhongHits, PrincipledHits, RoughDiffuseHits, SamplesView, Scattering, ScatteringQueue,
    SurfaceHit, SurfaceHitColumns, SurfaceHitsView,
};
use crate::random::{Decision, Stream};
use crate::stats::Counts;

/// What became of the rays of one trace.
#[derive(Debug, Default)]
pub struct SortedHits {
    /// Rays that met nothing.
    pub escaped: EscapedQueue,
    /// Rays that met a boundary that is none.
    pub crossings: CrossingQueue,
    /// Rays that media scattered.
    pub scatterings: ScatteringQueue,
    /// Hits on Phong materials.
    pub phong: PhongHits,
    /// Hits on Lambert materials.
    pub lambert: LambertHits,
    /// Hits on rough diffuse materials.
    pub rough_diffuse: RoughDiffuseHits,
    /// Hits on metals.
    pub metal: MetalHits,
    /// Hits on dielectrics.
    pub dielectric: DielectricHits,
    /// Hits on emissive surfaces.
    pub emissive: EmissiveHits,
    /// Hits on principled materials.
    pub principled: PrincipledHits,
    /// Hits on coated materials.
    pub coated: CoatedHits,
}

impl SortedHits {
    /// Drops all rows; keeps the memory. Says whether the next ones have to know when they were.
    pub fn clear(&mut self, moves: bool) {
        self.escaped.clear();
        self.crossings.clear();
        self.scatterings.clear();
        self.phong.clear(moves);
        self.lambert.clear(moves);
        self.rough_diffuse.clear(moves);
        self.metal.clear(moves);
        self.dielectric.clear(moves);
        self.emissive.clear(moves);
        self.principled.clear(moves);
        self.coated.clear(moves);
    }

    /// Runs over the hits of every kind.
    pub fn each(&self, mut run: impl FnMut(SurfaceHitsView<'_>)) {
        run(self.phong.view().columns());
        run(self.lambert.view().columns());
        run(self.rough_diffuse.view().columns());
        run(self.metal.view().columns());
        run(self.dielectric.view().columns());
        run(self.emissive.view().columns());
        run(self.principled.view().columns());
        run(self.coated.view().columns());
    }

    /// Bytes of memory taken.
    pub fn bytes(&self) -> usize {
        let kinds = self.phong.capacity()
            + self.lambert.capacity()
            + self.rough_diffuse.capacity()
            + self.metal.capacity()
            + self.dielectric.capacity()
            + self.emissive.capacity()
            + self.principled.capacity()
            + self.coated.capacity();
        kinds * SurfaceHitColumns::BYTES_PER_ROW
            + self.escaped.capacity() * EscapedQueue::BYTES_PER_ROW
            + self.crossings.capacity() * CrossingQueue::BYTES_PER_ROW
            + self.scatterings.capacity() * ScatteringQueue::BYTES_PER_ROW
    }

    /// Hits on surfaces.
    pub fn hits(&self) -> usize {
        self.phong.len()
            + self.lambert.len()
            + self.rough_diffuse.len()
            + self.metal.len()
            + self.dielectric.len()
            + self.emissive.len()
            + self.principled.len()
            + self.coated.len()
    }
}

/// The rays of one depth and what they met.
#[derive(Clone, Copy, Debug)]
pub struct Arrivals<'a> {
    /// The rays.
    pub rays: PathRaysView<'a>,
    /// Their hits.
    pub hits: HitsView<'a>,
    /// The samples that they belong to.
    pub samples: SamplesView<'a>,
    /// Their depth.
    pub depth: u32,
}

/// Parts rays into escaped ones, crossings and hits by kind of material, in the rays' order, and finds the points of the
/// surfaces, with the normals to shade them.
///
/// Reads: rays, hits, instances, materials, the textures that bend normals and mix, and random numbers for mixes. Writes: the sorted hits, which are emptied first, and the media stacks.
pub fn sort(
    context: &Context<'_>,
    arrivals: Arrivals<'_>,
    stacks: &mut MediaStacks,
    sorted: &mut SortedHits,
    counts: &mut Counts,
) {
    let Arrivals { rays, hits, samples, depth } = arrivals;
    sorted.clear(context.moves);
    let mut points = [SurfacePoint::default(); RUN];
    let mut times = [0.0; RUN];
    let mut rows = [0; RUN];
    for start in (0..rays.len()).step_by(RUN) {
        let run = start..rays.len().min(start + RUN);
        let looking_at = &mut times[..if context.moves { run.len() } else { 0 }];
        for (time, &sample) in looking_at.iter_mut().zip(&rays.sample[run.clone()]) {
            *time = samples.time(context, sample);
        }
        let looking = Rays { time: looking_at, ..rays.rays(&[]).slice(run.clone()) };
        surfaces(context.policy.level, &context.geometry, looking, hits.slice(run.clone()), &mut points);
        let listed = list(context.policy.compaction, hits, run, &mut rows, &mut sorted.escaped);
        for row in listed.iter().map(|&row| row as usize) {
            let stream = || samples.stream(&context.sampler, rays.sample[row], rays.branch[row]);
            let found = (&hits.get(row), |_: &_| points[row % RUN]);
            let arrived = (&rays.get(row), row as u32, times[row % RUN]);
            let (kind, hit) = match arrive(context, arrived, found, depth, stream, stacks) {
                Arrival::Nothing => {
                    sorted.escaped.push(Escaped { ray: row as u32 });
                    continue;
                }
                Arrival::NoBoundary(crossing) => {
                    sorted.crossings.push(crossing);
                    continue;
                }
                Arrival::Medium(scattering) => {
                    sorted.scatterings.push(scattering);
                    continue;
                }
                Arrival::Surface(kind, hit) => (kind, hit),
            };
            match kind {
                MaterialKind::Phong => sorted.phong.push(hit),
                MaterialKind::Lambert => sorted.lambert.push(hit),
                MaterialKind::RoughDiffuse => sorted.rough_diffuse.push(hit),
                MaterialKind::Metal => sorted.metal.push(hit),
                MaterialKind::Dielectric => sorted.dielectric.push(hit),
                MaterialKind::Emissive => sorted.emissive.push(hit),
                MaterialKind::Principled => sorted.principled.push(hit),
                MaterialKind::Coated => sorted.coated.push(hit),
                MaterialKind::Mix => unreachable!("a hit is of one of the two"),
            }
        }
    }
    counts.escaped += sorted.escaped.len() as u64;
    counts.crossings += sorted.crossings.len() as u64;
    counts.scatterings += sorted.scatterings.len() as u64;
    counts.hits += sorted.hits() as u64;
}

/// Rays whose surfaces are found at once.
const RUN: usize = 512;

/// Lists the rows of a run that are looked at one by one: all of them, or those that did not escape, and then the others are queued.
#[inline(always)]
fn list<'r>(
    compaction: Compaction,
    hits: HitsView<'_>,
    run: Range<usize>,
    rows: &'r mut [u32; RUN],
    escaped: &mut EscapedQueue,
) -> &'r [u32] {
    let (mut listed, mut gone, mut gone_rows) = (0, 0, [0; RUN]);
    for row in run {
        let hit = hits.get(row);
        // No && here: it is a branch.
        let is_gone = (compaction == Compaction::Cursor) & hit.is_miss() & (hit.primitive == MISS);
        (rows[listed], gone_rows[gone]) = (row as u32, row as u32);
        listed += usize::from(!is_gone);
        gone += usize::from(is_gone);
    }
    gone_rows[..gone].iter().for_each(|&ray| escaped.push(Escaped { ray }));
    &rows[..listed]
}

/// What a ray met.
pub(crate) enum Arrival {
    /// Nothing.
    Nothing,
    /// A boundary that is none.
    NoBoundary(Crossing),
    /// Nothing but a medium, which scattered it.
    Medium(Scattering),
    /// A surface of a kind.
    Surface(MaterialKind, SurfaceHit),
}

/// What one ray met that looks at a moment; `point` tells the point of the surface there, and `stream` has the numbers of its branch.
#[inline(always)]
pub(crate) fn arrive(
    context: &Context<'_>,
    (ray, row, time): (&PathRay, u32, f32),
    (hit, point): (&Hit, impl FnOnce(&Ray) -> SurfacePoint),
    depth: u32,
    stream: impl FnOnce() -> Stream,
    stacks: &mut MediaStacks,
) -> Arrival {
    if hit.is_miss() {
        if hit.primitive == MISS {
            return Arrival::Nothing;
        }
        let (medium, position) = (Medium(hit.primitive), ray.ray(time).at(hit.t));
        return Arrival::Medium(Scattering { ray: row, medium, position });
    }
    let scene = context.scene;
    let material = scene.instances.view().material[hit.instance as usize];
    let mut material = scene.materials.rows.view().get(material.0 as usize);
    let mut point = point(&ray.ray(time));
    let direction = ray.direction();
    if material.detail != DetailId::NONE {
        let place = context.seen(point.place(hit.instance, hit.primitive, time));
        point.shading_normal = scene.bent_normal(material.detail, &place, &point, direction);
    }
    if material.kind == MaterialKind::Mix {
        let place = context.seen(point.place(hit.instance, hit.primitive, time));
        (material.kind, material.row) = resolve(context, stream(), depth, material.row, &place);
    }
    if let Some(medium) = scene.materials.medium(material) {
        let inward = direction.dot(point.geometric_normal) < 0.0;
        let boundary = stacks.boundary(ray.media, Medium(medium), inward, &scene.materials.dielectric.view());
        if boundary.filling_before == boundary.filling_behind {
            let origin = offset_origin(&point, direction);
            return Arrival::NoBoundary(Crossing { ray: row, media: boundary.behind, origin });
        }
    }
    let (instance, primitive) = (hit.instance, hit.primitive);
    Arrival::Surface(material.kind, SurfaceHit { ray: row, instance, primitive, material: material.row, point, time })
}

/// The material of a mix that a ray meets, its kind and row: one of both by a number, at every level of mixes in mixes by another.
fn resolve(context: &Context<'_>, stream: Stream, depth: u32, mix: u32, place: &SeenPlace) -> (MaterialKind, u32) {
    let (mut met, mut level) = ((MaterialKind::Mix, mix), 0);
    while met.0 == MaterialKind::Mix {
        let Mix { a, b, by } = context.scene.materials.mix.get(met.1 as usize);
        level += 1;
        let number = context.sampler.one(stream, Decision::Crossing.at(depth).repeat(level));
        met = if number < context.scene.number(by, place) { b } else { a };
    }
    met
}
