//! What all kinds of material do where rays arrive, over a block of rows at a time.

#![expect(clippy::needless_range_loop, reason = "what belongs to a row stands in many columns")]

use brewster_buffers::{ColorSource, Light, TextureId};
use brewster_geometry::{SurfacePoint, offset_origin};
use brewster_optics::dispersion::PathWavelength;
use brewster_optics::lobe::DELTA;
use glam::{Vec2, Vec3};

use super::{Continuation, facing};
use crate::context::Context;
use crate::media::MediaId;
use crate::queues::{Event, PathRay, PathRaysView, ShadowRaysView, SurfaceHit, SurfaceHitsView, Trail};
use crate::stages::Outlet;
use crate::stages::vectors::{Vectors, count};
use crate::stats::Counts;

/// Rays and what each hits, at most N of them: what lies beyond is the last one's copy, and does not count.
pub(super) struct Arrivals<'q, const N: usize> {
    pub(super) context: &'q Context<'q>,
    hits: SurfaceHitsView<'q>,
    pub(super) counted: [bool; N],
    pub(super) directions: Vectors<N>,
    pub(super) weights: Vectors<N>,
    positions: Vectors<N>,
    /// The geometric normals as they are.
    pub(super) outward: Vectors<N>,
    errors: [f32; N],
    /// The normals on the sides that the rays came from.
    pub(super) geometric: Vectors<N>,
    pub(super) normals: Vectors<N>,
    pub(super) media: [MediaId; N],
    pub(super) samples: [u32; N],
    pub(super) trails: [Trail; N],
    pub(super) instances: [u32; N],
    branches: [u32; N],
}

/// A light as the rows of a block see it.
pub(super) struct Lamp<const N: usize> {
    light: Light,
    /// Where it is when they look, and where it shines to.
    positions: Vectors<N>,
    axes: Vectors<N>,
    /// Unit directions toward it.
    pub(super) directions: Vectors<N>,
    /// Irradiances on planes that face it.
    pub(super) irradiances: Vectors<N>,
}

/// What the rows of a block send on.
pub(super) struct Onward<const N: usize> {
    /// The rows that send something.
    pub(super) sent: [bool; N],
    pub(super) directions: Vectors<N>,
    pub(super) weights: Vectors<N>,
    pub(super) media: [MediaId; N],
}

impl<'q, const N: usize> Arrivals<'q, N> {
    #[inline(always)]
    pub(super) fn new(context: &'q Context<'q>, rays: PathRaysView<'q>, hits: SurfaceHitsView<'q>) -> Arrivals<'q, N> {
        let mut arrivals = Arrivals {
            context,
            hits,
            counted: [false; N],
            directions: Vectors::ZERO,
            weights: Vectors::ZERO,
            positions: Vectors::ZERO,
            outward: Vectors::ZERO,
            errors: [0.0; N],
            geometric: Vectors::ZERO,
            normals: Vectors::ZERO,
            media: [MediaId::VACUUM; N],
            samples: [0; N],
            trails: [Trail::CAMERA; N],
            instances: [0; N],
            branches: [0; N],
        };
        for row in 0..N {
            let SurfaceHit { ray, instance, point, .. } = arrivals.hit(row);
            let PathRay { weight, sample, trail, media, branch, .. } = rays.get(ray as usize);
            let direction = rays.get(ray as usize).direction();
            arrivals.counted[row] = row < hits.len();
            arrivals.directions.set(row, direction);
            arrivals.weights.set(row, weight);
            arrivals.positions.set(row, point.position);
            arrivals.outward.set(row, point.geometric_normal);
            arrivals.normals.set(row, point.shading_normal);
            arrivals.errors[row] = point.error;
            (arrivals.media[row], arrivals.samples[row], arrivals.trails[row]) = (media, sample, trail);
            (arrivals.instances[row], arrivals.branches[row]) = (instance, branch);
        }
        for row in 0..N {
            let direction = arrivals.directions.get(row);
            arrivals.geometric.set(row, facing(arrivals.outward.get(row), direction));
            arrivals.normals.set(row, facing(arrivals.normals.get(row), direction));
        }
        arrivals
    }

    /// A row's hit.
    #[inline(always)]
    pub(super) fn hit(&self, row: usize) -> SurfaceHit {
        self.hits.get(row.min(self.hits.len() - 1))
    }

    /// The color of a source where a row's ray hits.
    #[inline(always)]
    pub(super) fn color(&self, row: usize, source: ColorSource) -> Vec3 {
        if source.texture == TextureId::NONE {
            return source.factor;
        }
        self.context.scene.color(source, &self.context.seen(self.hit(row).place()))
    }

    /// The cosine of a row's angle of incidence.
    #[inline(always)]
    pub(super) fn cos_i(&self, row: usize) -> f32 {
        (-self.directions.get(row).dot(self.normals.get(row))).clamp(0.0, 1.0)
    }

    /// Where a ray of a row starts that leaves in a direction.
    #[inline(always)]
    fn origin(&self, row: usize, direction: Vec3) -> Vec3 {
        let point = SurfacePoint {
            position: self.positions.get(row),
            geometric_normal: self.outward.get(row),
            shading_normal: Vec3::ZERO,
            uv: Vec2::ZERO,
            error: self.errors[row],
        };
        offset_origin(&point, direction)
    }

    /// A light of the scene.
    #[inline(always)]
    pub(super) fn lamp(&self, index: usize) -> Lamp<N> {
        let scene = self.context.scene;
        let light = scene.lights.get(index);
        let mut lamp = Lamp {
            light,
            positions: Vectors::splat(light.position),
            axes: Vectors::splat(light.direction),
            directions: Vectors::ZERO,
            irradiances: Vectors::ZERO,
        };
        if !scene.light_motions.is_empty() {
            for row in 0..N {
                let moved = scene.light_at(index, self.hit(row).time);
                lamp.positions.set(row, moved.position);
                lamp.axes.set(row, moved.direction);
            }
        }
        for row in 0..N {
            let seen = lamp.at(row).illuminate(self.positions.get(row));
            lamp.directions.set(row, seen.direction);
            lamp.irradiances.set(row, seen.irradiance);
        }
        lamp
    }

    /// Whether a direction leads to the outside by both normals of a row.
    #[inline(always)]
    pub(super) fn is_outside(&self, row: usize, direction: Vec3) -> bool {
        (direction.dot(self.normals.get(row)) > 0.0) & (direction.dot(self.geometric.get(row)) > 0.0)
    }

    /// Whether a direction leads to the inside by both normals of a row.
    #[inline(always)]
    pub(super) fn is_inside(&self, row: usize, direction: Vec3) -> bool {
        (direction.dot(self.normals.get(row)) < 0.0) & (direction.dot(self.geometric.get(row)) < 0.0)
    }

    /// Sends rays from those rows toward a light that are lit, with what they add if they arrive; nothing that is black is sent.
    #[inline(always)]
    pub(super) fn toward(
        &self,
        lamp: &Lamp<N>,
        contributions: &Vectors<N>,
        lit: &[bool; N],
        media: &[MediaId; N],
        outlet: &mut impl Outlet,
    ) {
        let mut goes = [false; N];
        for row in 0..N {
            goes[row] = self.counted[row] & lit[row] & (contributions.get(row) != Vec3::ZERO);
        }
        if count(&goes) == 0 {
            return;
        }
        let (mut origins, mut directions, mut distances) = (Vectors::<N>::ZERO, Vectors::<N>::ZERO, [0.0; N]);
        let mut contribution = [Vec3::ZERO; N];
        for row in 0..N {
            let origin = self.origin(row, lamp.directions.get(row));
            let seen = lamp.at(row).illuminate(origin);
            origins.set(row, origin);
            directions.set(row, seen.direction);
            distances[row] = seen.distance;
        }
        for row in 0..N {
            contribution[row] = contributions.get(row);
        }
        let ([origin_x, origin_y, origin_z], [direction_x, direction_y, direction_z]) = (&origins.0, &directions.0);
        let rays = ShadowRaysView {
            origin_x,
            origin_y,
            origin_z,
            direction_x,
            direction_y,
            direction_z,
            distance: &distances,
            contribution: &contribution,
            sample: &self.samples,
            trail: &self.trails,
            instance: &self.instances,
            media,
            passes_sheets: &[false; N],
        };
        outlet.shadow_marked(rays, &goes);
    }

    /// Sends reflections or, if they are refracted, transmissions to the next depth: those that may go on. Each ray alone decides.
    #[inline(always)]
    pub(super) fn send(
        &self,
        rays: &Onward<N>,
        event: Event,
        continuation: Continuation,
        outlet: &mut impl Outlet,
        counts: &mut Counts,
    ) {
        let (mut sent, mut goes, mut branches) = ([false; N], [false; N], [0; N]);
        for row in 0..N {
            sent[row] = self.counted[row] & rays.sent[row];
            let is_weak = rays.weights.get(row).max_element() < continuation.threshold;
            goes[row] = sent[row] & !is_weak;
        }
        if !continuation.goes_on {
            counts.cut_by_depth += count(&sent);
            return;
        }
        let going = count(&goes);
        counts.below_threshold += count(&sent) - going;
        if going == 0 {
            return;
        }
        let transmits = event == Event::Refracted;
        let (mut origins, mut weight, mut trail) = (Vectors::<N>::ZERO, [Vec3::ZERO; N], self.trails);
        for row in 0..N {
            origins.set(row, self.origin(row, rays.directions.get(row)));
            branches[row] = self.branches[row].wrapping_mul(2).wrapping_add(u32::from(transmits));
        }
        for row in 0..N {
            trail[row] = self.trails[row].then(event);
            weight[row] = rays.weights.get(row);
        }
        let ([origin_x, origin_y, origin_z], [direction_x, direction_y, direction_z]) =
            (&origins.0, &rays.directions.0);
        let rays = PathRaysView {
            origin_x,
            origin_y,
            origin_z,
            direction_x,
            direction_y,
            direction_z,
            weight: &weight,
            pdf: &[DELTA; N],
            sample: &self.samples,
            trail: &trail,
            instance: &self.instances,
            media: &rays.media,
            wavelength: &[PathWavelength::NONE; N],
            branch: &branches,
        };
        if transmits {
            counts.transmissions += going;
            outlet.transmit_marked(rays, &goes);
        } else {
            counts.reflections += going;
            outlet.reflect_marked(rays, &goes);
        }
    }
}

impl<const N: usize> Lamp<N> {
    /// The light when a row looks.
    #[inline(always)]
    fn at(&self, row: usize) -> Light {
        Light { position: self.positions.get(row), direction: self.axes.get(row), ..self.light }
    }
}
