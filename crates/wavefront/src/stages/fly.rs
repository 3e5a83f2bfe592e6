//! Takes rays through media that scatter, and through boundaries without a surface.
//!
//! Where a scene has such media, this stage stands in for `absorb`. A ray goes from boundary to boundary; in each medium a free
//! flight is drawn, and where one ends before the boundary, the ray is scattered there: it has met no surface but a medium. As
//! behind veils, the ray keeps its origin, so what is told of what it meets, distance and densities of light sampling, is
//! as if no boundary had been on the way: lights behind fog's boundary are sampled like any others.

use brewster_buffers::{MaterialKind, MaterialRow};
use brewster_geometry::{
    Hit, HitColumns, HitsViewMut, Ray, Rays, SurfacePoint, closest_hits_by, offset_origin, surface,
};
use brewster_lanes::columns;
use brewster_optics::absorption::transmittance;
use brewster_optics::free_flight::{Flight, albedo, flight};
use glam::Vec3;

use super::trace::behind_veil;
use crate::context::Context;
use crate::ledger::Ledger;
use crate::media::{MediaId, MediaStacks, Medium};
use crate::policy::Policy;
use crate::queues::{PathRaysViewMut, SamplesViewMut};
use crate::random::{Decision, Stream};
use crate::stats::Counts;

columns! {
    /// A ray that goes on behind a boundary without a surface.
    pub struct Flying => FlyingColumns, FlyingsView, FlyingsViewMut {
        /// Where it goes on from, in meters.
        pub origin_x: f32,
        /// Where it goes on from.
        pub origin_y: f32,
        /// Where it goes on from.
        pub origin_z: f32,
        /// Unit direction.
        pub direction_x: f32,
        /// Unit direction.
        pub direction_y: f32,
        /// Unit direction.
        pub direction_z: f32,
        /// How far it has come.
        pub progress: Progress,
        /// Its row among those traced.
        pub row: u32,
    }
}

/// How far a ray has come.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Progress {
    /// Where it was last traced from, in meters from its origin.
    pub passed: f32,
    /// Up to where media have had their part of it.
    pub flown: f32,
    /// Media that it went through.
    pub media: u32,
}

/// Memory that [`fly`] reuses. It grows where there are boundaries without a surface only.
#[derive(Debug, Default)]
pub struct FlyScratch {
    hits: HitColumns,
    flying: FlyingColumns,
    next: FlyingColumns,
    times: Vec<f32>,
}

impl FlyScratch {
    /// Bytes of memory taken.
    pub fn bytes(&self) -> usize {
        self.hits.capacity() * HitColumns::BYTES_PER_ROW
            + (self.flying.capacity() + self.next.capacity()) * FlyingColumns::BYTES_PER_ROW
            + size_of_val(&*self.times)
    }
}

/// A ray on its way through media: its weight, and the media around it.
pub(crate) struct Traveler<'a> {
    pub(crate) weight: &'a mut Vec3,
    pub(crate) media: &'a mut MediaId,
}

/// Where a ray has got to.
pub(crate) enum Arrived {
    /// At what it meets: the distance is from its origin, and where it is scattered nothing but a medium is met, see [`Scattering`](crate::queues::Scattering).
    At(Hit),
    /// Behind a boundary without a surface, at this place.
    Behind(Vec3),
}

/// Takes rays of a depth to where they are scattered or meet a surface, and weakens them by what media absorb on the way.
///
/// Reads: media, materials, random numbers. Writes: the rays' weights and media, their hits, and the samples' number of rays.
pub fn fly(
    context: &Context<'_>,
    (rays, hits): (PathRaysViewMut<'_>, HitsViewMut<'_>),
    depth: u32,
    stacks: &mut MediaStacks,
    scratch: &mut FlyScratch,
    samples: SamplesViewMut<'_>,
    counts: &mut Counts,
) {
    let Policy { kernel, level, .. } = context.policy;
    let FlyScratch { hits: met, flying, next, times } = scratch;
    flying.clear();
    next.clear();
    flying.reserve(rays.len());
    next.reserve(rays.len());
    let mut way = Way { context, rays, hits, samples, depth };
    for row in 0..way.rays.len() {
        let time = way.samples.as_view().time(context, way.rays.sample[row]);
        let (ray, hit) = (way.rays.as_view().get(row).ray(time), way.hits.as_view().get(row));
        way.go(row, (&ray, &hit), Progress::default(), stacks, flying, counts);
    }
    while !flying.is_empty() {
        let from = flying.view();
        met.resize(from.len(), Hit::miss());
        times.clear();
        if !context.scene.motions.is_empty() {
            let time = |&row: &u32| way.samples.as_view().time(context, way.rays.sample[row as usize]);
            times.extend(from.row.iter().map(time));
        }
        let onward = Rays {
            origin: [from.origin_x, from.origin_y, from.origin_z],
            direction: [from.direction_x, from.direction_y, from.direction_z],
            time: times,
        };
        closest_hits_by(kernel, &context.geometry, level, onward, met.view_mut());
        next.clear();
        for at in 0..from.len() {
            let (row, progress) = (from.row[at] as usize, from.progress[at]);
            way.samples.rays[way.rays.sample[row] as usize] += 1;
            way.go(row, (&onward.get(at), &met.get(at)), progress, stacks, next, counts);
        }
        counts.passed += from.len() as u64;
        std::mem::swap(flying, next);
    }
}

/// Rays on their way.
struct Way<'w, 'a> {
    context: &'w Context<'a>,
    rays: PathRaysViewMut<'w>,
    hits: HitsViewMut<'w>,
    samples: SamplesViewMut<'w>,
    depth: u32,
}

impl Way<'_, '_> {
    /// Takes one ray to the next boundary; it goes on from there in `flying`.
    #[inline(always)]
    fn go(
        &mut self,
        row: usize,
        way: (&Ray, &Hit),
        mut progress: Progress,
        stacks: &mut MediaStacks,
        flying: &mut FlyingColumns,
        counts: &mut Counts,
    ) {
        let Way { context, rays, hits, samples, depth } = self;
        let stream = samples.as_view().stream(&context.sampler, rays.sample[row], rays.branch[row]);
        let traveler = Traveler { weight: &mut rays.weight[row], media: &mut rays.media[row] };
        match fly_on(context, traveler, way, (&mut progress, *depth, stream), stacks, counts) {
            Arrived::At(hit) => hits.set(row, hit),
            Arrived::Behind(origin) => flying.push(Flying {
                origin_x: origin.x,
                origin_y: origin.y,
                origin_z: origin.z,
                direction_x: way.0.direction.x,
                direction_y: way.0.direction.y,
                direction_z: way.0.direction.z,
                progress,
                row: row as u32,
            }),
        }
    }
}

/// Takes a ray along its way from where it was last traced; `stream` has the numbers of its branch. Veils on the first stretch have
/// been passed already.
#[inline(always)]
pub(crate) fn fly_on(
    context: &Context<'_>,
    traveler: Traveler<'_>,
    (ray, hit): (&Ray, &Hit),
    (progress, depth, stream): (&mut Progress, u32, Stream),
    stacks: &mut MediaStacks,
    counts: &mut Counts,
) -> Arrived {
    if progress.media > 0
        && context.may_be_absent(depth)
        && let Some((behind, passed)) = behind_veil(context, (ray, hit), progress.passed, depth, || stream)
    {
        progress.passed = passed;
        return Arrived::Behind(behind);
    }
    let end = progress.passed + hit.t;
    let number = Decision::Distance.at(depth).repeat(progress.media);
    let filling = stacks.filling(*traveler.media);
    if context.albedos.is_some() && progress.media == 0 {
        counts.ledger.entered.add(*traveler.weight);
    }
    let u = || context.sampler.pair(stream, number);
    if let Some(distance) = through(context, traveler.weight, filling, end - progress.flown, u, &mut counts.ledger) {
        let t = progress.flown + distance;
        return Arrived::At(Hit { t, primitive: filling.0, ..Hit::miss() });
    }
    (progress.flown, progress.media) = (end, progress.media + 1);
    if !hit.is_miss() {
        let material = scene_material(context, hit.instance);
        if is_bare(context, material) {
            let point = surface(&context.geometry, ray, hit);
            if let Some(behind) = behind_bare(context, *traveler.media, material, (ray.direction, &point), stacks) {
                (*traveler.media, progress.passed) = (behind, end);
                return Arrived::Behind(offset_origin(&point, ray.direction));
            }
        }
    }
    Arrived::At(Hit { t: end, ..*hit })
}

/// What a medium does to a weight on a way; tells where light is scattered, if it is. What it is expected to absorb follows from
/// its coefficients alone; what the flight drew beyond that is `strayed`.
#[inline(always)]
fn through(
    context: &Context<'_>,
    weight: &mut Vec3,
    medium: Medium,
    distance: f32,
    u: impl FnOnce() -> [f32; 2],
    ledger: &mut Ledger,
) -> Option<f32> {
    if medium == Medium::VACUUM {
        return None;
    }
    let dielectrics = context.scene.materials.dielectric.view();
    let row = medium.0 as usize;
    let (absorption, scattering) = (dielectrics.absorption[row], dielectrics.scattering[row]);
    let (before, left) = (*weight, transmittance(absorption + scattering, distance));
    let scattered_at = if scattering == Vec3::ZERO {
        *weight *= left;
        None
    } else {
        let Flight { scattered_at, factor } = flight(absorption, scattering, before, u(), distance);
        *weight *= factor;
        scattered_at
    };
    if context.albedos.is_some() {
        let expected = before * (left + (1.0 - left) * albedo(absorption, scattering));
        let strayed = expected - *weight;
        ledger.volume.add(before);
        ledger.volume.take(expected);
        ledger.strayed.add(expected);
        ledger.strayed.take(*weight);
        ledger.strayed_squares.add(strayed * strayed);
    }
    scattered_at
}

#[inline(always)]
fn scene_material(context: &Context<'_>, instance: u32) -> MaterialRow {
    let id = context.scene.instances.view().material[instance as usize];
    context.scene.materials.rows.get(id.0 as usize)
}

/// Whether a material may have no surface.
#[inline(always)]
pub(crate) fn is_bare(context: &Context<'_>, material: MaterialRow) -> bool {
    context.has_fog
        && material.kind == MaterialKind::Dielectric
        && context.scene.materials.dielectric.view().bare[material.row as usize]
}

/// The media behind the boundary of a material that may have no surface, if it has none there: the index is the same on both
/// sides.
#[inline(always)]
pub(crate) fn behind_bare(
    context: &Context<'_>,
    media: MediaId,
    material: MaterialRow,
    (direction, point): (Vec3, &SurfacePoint),
    stacks: &mut MediaStacks,
) -> Option<MediaId> {
    let dielectrics = context.scene.materials.dielectric.view();
    let inward = direction.dot(point.geometric_normal) < 0.0;
    let boundary = stacks.boundary(media, Medium(material.row), inward, &dielectrics);
    let [before, behind] = [boundary.filling_before, boundary.filling_behind];
    let is_same = before == behind
        || !(before.disperses(&dielectrics) || behind.disperses(&dielectrics))
            && before.ior(&dielectrics) == behind.ior(&dielectrics);
    is_same.then_some(boundary.behind)
}
