//! Shading: one stage a kind of material.
//!
//! Each reads its kind's hits, the rays they belong to and its kind's columns, and writes shadow rays, contributions, and
//! the reflections and transmissions that go on.

mod dielectric;
mod emissive;
mod lambert;
mod metal;
mod phong;

pub use dielectric::shade_dielectric;
pub use emissive::shade_emissive;
pub(crate) use emissive::shine;
pub use lambert::shade_lambert;
pub use metal::shade_metal;
pub use phong::shade_phong;

use brewster_geometry::offset_origin;
use glam::Vec3;

use crate::media::MediaId;
use crate::queues::{DepthQueues, Event, PathRay, ShadowQueue, ShadowRay, SurfaceHit};
use crate::stats::Counts;

/// Where reflections and transmissions go: the queues of the next depth, unless that lies beyond the maximum.
#[derive(Debug)]
pub struct Continuation<'a> {
    /// The queues of the next depth; none at the maximum depth.
    pub next: Option<&'a mut DepthQueues>,
    /// A ray whose largest weight falls below this is not followed.
    pub threshold: f32,
}

impl Continuation<'_> {
    /// Sends a ray into the reflection queue of the next depth.
    #[inline(always)]
    fn reflect(&mut self, ray: PathRay, counts: &mut Counts) {
        if let Some(next) = self.admit(&ray, counts) {
            counts.reflections += 1;
            let (branch, trail) = (ray.branch.wrapping_mul(2), ray.trail.then(Event::Mirrored));
            next.reflection.push(PathRay { branch, trail, ..ray });
        }
    }

    /// Sends a ray into the transmission queue of the next depth.
    #[inline(always)]
    fn transmit(&mut self, ray: PathRay, counts: &mut Counts) {
        if let Some(next) = self.admit(&ray, counts) {
            counts.transmissions += 1;
            let (branch, trail) = (ray.branch.wrapping_mul(2).wrapping_add(1), ray.trail.then(Event::Refracted));
            next.transmission.push(PathRay { branch, trail, ..ray });
        }
    }

    /// The next depth's queues, if the ray may go there. One ray alone decides.
    #[inline(always)]
    fn admit(&mut self, ray: &PathRay, counts: &mut Counts) -> Option<&mut DepthQueues> {
        if self.next.is_none() {
            counts.cut_by_depth += 1;
        } else if ray.weight.max_element() < self.threshold {
            counts.below_threshold += 1;
            return None;
        }
        self.next.as_deref_mut()
    }
}

/// Sends a ray toward a light, with what it adds if it arrives; nothing that is black is sent.
#[inline(always)]
fn send_shadow_ray(
    queue: &mut ShadowQueue,
    hit: &SurfaceHit,
    ray: &PathRay,
    media: MediaId,
    light: &brewster_buffers::Light,
    toward: Vec3,
    contribution: Vec3,
) {
    if contribution == Vec3::ZERO {
        return;
    }
    let origin = offset_origin(&hit.point, toward);
    let seen = light.illuminate(origin);
    queue.push(ShadowRay {
        origin_x: origin.x,
        origin_y: origin.y,
        origin_z: origin.z,
        direction_x: seen.direction.x,
        direction_y: seen.direction.y,
        direction_z: seen.direction.z,
        distance: seen.distance,
        contribution,
        sample: ray.sample,
        trail: ray.trail,
        instance: hit.instance,
        media,
        passes_sheets: false,
    });
}

/// The two normals of a hit, turned to the side that the ray came from.
#[inline(always)]
pub(crate) fn facing_normals(hit: &SurfaceHit, direction: Vec3) -> (Vec3, Vec3) {
    let face = |normal: Vec3| if direction.dot(normal) < 0.0 { normal } else { -normal };
    (face(hit.point.geometric_normal), face(hit.point.shading_normal))
}
