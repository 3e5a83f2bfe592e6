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
pub(crate) use dielectric::split_at_dielectric;
pub use emissive::shade_emissive;
pub(crate) use emissive::{emitted, shine};
pub(crate) use lambert::light_lambert;
pub use lambert::shade_lambert;
pub(crate) use metal::mirror_at_metal;
pub use metal::shade_metal;
pub(crate) use phong::light_phong;
pub use phong::shade_phong;

use brewster_geometry::offset_origin;
use glam::Vec3;

use crate::media::MediaId;
use crate::queues::{Event, PathRay, ShadowRay, SurfaceHit};
use crate::stages::Outlet;
use crate::stats::Counts;

/// Which reflections and transmissions go on: those below the maximum depth that are not too weak.
#[derive(Clone, Copy, Debug)]
pub struct Continuation {
    /// Whether there is a next depth.
    pub goes_on: bool,
    /// A ray whose largest weight falls below this is not followed.
    pub threshold: f32,
}

impl Continuation {
    /// Sends a reflection to the next depth.
    #[inline(always)]
    fn reflect(self, ray: PathRay, outlet: &mut impl Outlet, counts: &mut Counts) {
        if self.admits(&ray, counts) {
            counts.reflections += 1;
            let (branch, trail) = (ray.branch.wrapping_mul(2), ray.trail.then(Event::Mirrored));
            outlet.reflect(PathRay { branch, trail, ..ray });
        }
    }

    /// Sends a transmission to the next depth.
    #[inline(always)]
    fn transmit(self, ray: PathRay, outlet: &mut impl Outlet, counts: &mut Counts) {
        if self.admits(&ray, counts) {
            counts.transmissions += 1;
            let (branch, trail) = (ray.branch.wrapping_mul(2).wrapping_add(1), ray.trail.then(Event::Refracted));
            outlet.transmit(PathRay { branch, trail, ..ray });
        }
    }

    /// Whether a ray may go on. It alone decides.
    #[inline(always)]
    fn admits(self, ray: &PathRay, counts: &mut Counts) -> bool {
        let is_weak = ray.weight.max_element() < self.threshold;
        if !self.goes_on {
            counts.cut_by_depth += 1;
        } else if is_weak {
            counts.below_threshold += 1;
        }
        self.goes_on && !is_weak
    }
}

/// Sends a ray toward a light, with what it adds if it arrives; nothing that is black is sent.
#[inline(always)]
fn send_shadow_ray(
    outlet: &mut impl Outlet,
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
    outlet.shadow(ShadowRay {
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
    (facing(hit.point.geometric_normal, direction), facing(hit.point.shading_normal, direction))
}

/// A normal, turned to the side that a ray came from.
#[inline(always)]
pub(crate) fn facing(normal: Vec3, direction: Vec3) -> Vec3 {
    if direction.dot(normal) < 0.0 { normal } else { -normal }
}
