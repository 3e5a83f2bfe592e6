//! Finds the closest hits.
//!
//! Where a surface may be absent (a cut-out, a veil), a number decides whether the ray meets it; the backs of some are absent for
//! camera rays. A ray that does not is traced
//! on from there, within the stage: no other stage ever sees what was not there. The ray keeps its origin, so what is told of
//! the hit in the end, distance, media and densities of light sampling, is as if nothing had been on the way.

use brewster_geometry::{Hit, HitColumns, Ray, Rays, closest_hits_by, offset_origin, surface};
use brewster_lanes::columns;
use glam::Vec3;

use crate::context::Context;
use crate::policy::Policy;
use crate::queues::{PathRaysView, SamplesViewMut};
use crate::random::{Decision, Stream};
use crate::stats::Counts;

columns! {
    /// A ray that goes on behind a surface that was not there.
    pub struct Passing => PassingColumns, PassingsView, PassingsViewMut {
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
        /// How far it has come, in meters.
        pub passed: f32,
        /// Its row among those traced.
        pub row: u32,
    }
}

impl Passing {
    #[inline(always)]
    fn new((origin, passed): (Vec3, f32), direction: Vec3, row: usize) -> Passing {
        Passing {
            origin_x: origin.x,
            origin_y: origin.y,
            origin_z: origin.z,
            direction_x: direction.x,
            direction_y: direction.y,
            direction_z: direction.z,
            passed,
            row: row as u32,
        }
    }
}

/// Memory that [`trace`] reuses. It grows where surfaces may be absent only.
#[derive(Debug, Default)]
pub struct TraceScratch {
    hits: HitColumns,
    passing: PassingColumns,
    next: PassingColumns,
    times: Vec<f32>,
}

impl TraceScratch {
    /// Bytes of memory taken.
    pub fn bytes(&self) -> usize {
        self.hits.capacity() * HitColumns::BYTES_PER_ROW
            + (self.passing.capacity() + self.next.capacity()) * PassingColumns::BYTES_PER_ROW
            + size_of_val(&*self.times)
    }
}

/// Finds what each ray of a depth hits first.
///
/// Reads: the rays, the trees, and where surfaces may be absent their textures and random numbers. Writes: one hit a ray, in the
/// rays' order, and the samples' number of rays.
pub fn trace(
    context: &Context<'_>,
    rays: PathRaysView<'_>,
    depth: u32,
    hits: &mut HitColumns,
    scratch: &mut TraceScratch,
    samples: SamplesViewMut<'_>,
    counts: &mut Counts,
) {
    hits.resize(rays.len(), Hit::miss());
    let Policy { kernel, level, .. } = context.policy;
    context.times(samples.as_view(), rays.sample, &mut scratch.times);
    closest_hits_by(kernel, &context.geometry, level, rays.rays(&scratch.times), hits.view_mut());
    for &sample in rays.sample {
        samples.rays[sample as usize] += 1;
    }
    if !context.may_be_absent(depth) {
        return;
    }
    scratch.passing.clear();
    scratch.next.clear();
    scratch.passing.reserve(rays.len());
    scratch.next.reserve(rays.len());
    for row in 0..rays.len() {
        let ray = rays.get(row).ray(samples.as_view().time(context, rays.sample[row]));
        let stream = || samples.as_view().stream(&context.sampler, rays.sample[row], rays.branch[row]);
        if let Some(behind) = behind_veil(context, (&ray, &hits.get(row)), 0.0, depth, stream) {
            scratch.passing.push(Passing::new(behind, ray.direction, row));
        }
    }
    while !scratch.passing.is_empty() {
        let passing = scratch.passing.view();
        counts.passed += passing.len() as u64;
        scratch.hits.resize(passing.len(), Hit::miss());
        let scene_moves = !scratch.times.is_empty();
        scratch.times.clear();
        if scene_moves {
            let time = |&row: &u32| samples.as_view().time(context, rays.sample[row as usize]);
            scratch.times.extend(passing.row.iter().map(time));
        }
        let onward = Rays {
            origin: [passing.origin_x, passing.origin_y, passing.origin_z],
            direction: [passing.direction_x, passing.direction_y, passing.direction_z],
            time: &scratch.times,
        };
        closest_hits_by(kernel, &context.geometry, level, onward, scratch.hits.view_mut());
        scratch.next.clear();
        for (at, &row) in passing.row.iter().enumerate() {
            let row = row as usize;
            samples.rays[rays.sample[row] as usize] += 1;
            let (hit, passed) = (scratch.hits.get(at), passing.passed[at]);
            hits.set(row, Hit { t: passed + hit.t, ..hit });
            let ray = onward.get(at);
            let stream = || samples.as_view().stream(&context.sampler, rays.sample[row], rays.branch[row]);
            if let Some(behind) = behind_veil(context, (&ray, &hit), passed, depth, stream) {
                scratch.next.push(Passing::new(behind, ray.direction, row));
            }
        }
        std::mem::swap(&mut scratch.passing, &mut scratch.next);
    }
}

/// How a ray goes on behind a surface that is not there: where from, and how far it has come; nothing if the surface is there.
/// `passed` is how far it had come where `ray` starts.
#[inline(always)]
pub(crate) fn behind_veil(
    context: &Context<'_>,
    (ray, hit): (&Ray, &Hit),
    passed: f32,
    depth: u32,
    stream: impl FnOnce() -> Stream,
) -> Option<(Vec3, f32)> {
    if hit.is_miss() {
        return None;
    }
    let scene = context.scene;
    let material = scene.instances.view().material[hit.instance as usize];
    let is_culled = depth == 0 && context.has_fronts && scene.is_culled(ray, hit);
    if !(is_culled || scene.is_veiled(material)) {
        return None;
    }
    let point = surface(&context.geometry, ray, hit);
    let coverage = match is_culled {
        true => 0.0,
        false => scene.coverage(material, &context.seen(point.place(hit.instance, hit.primitive, ray.time))),
    };
    let is_there = coverage >= 1.0
        || coverage > 0.0 && {
            let (stream, dimension) = (stream(), Decision::Crossing.at(depth));
            // The first number of a depth is as evenly spread as all others; later ones, of which nobody knows how many there
            // will be, are told apart by where they are asked for.
            let number = if passed == 0.0 {
                context.sampler.one(stream, dimension)
            } else {
                context.sampler.scattered(stream, dimension, [hit.instance, hit.primitive, passed.to_bits()])
            };
            number < coverage
        };
    (!is_there).then(|| (offset_origin(&point, ray.direction), passed + hit.t))
}
