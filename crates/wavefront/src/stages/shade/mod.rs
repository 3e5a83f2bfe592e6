//! Shading: one stage a kind of material.
//!
//! Each reads its kind's hits, the rays they belong to and its kind's columns, and writes shadow rays, contributions, and
//! the reflections and transmissions that go on. All but emissive surfaces are shaded sixteen rows at a time, as columns: a row at a time took 1.6 (`shade_phong`) to
//! 3 times (`shade_metal`) as long.

mod arrivals;
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

use glam::Vec3;

use crate::queues::SurfaceHit;

/// Which reflections and transmissions go on: those below the maximum depth that are not too weak.
#[derive(Clone, Copy, Debug)]
pub struct Continuation {
    /// Whether there is a next depth.
    pub goes_on: bool,
    /// A ray whose largest weight falls below this is not followed.
    pub threshold: f32,
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
