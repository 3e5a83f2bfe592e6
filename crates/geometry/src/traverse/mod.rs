//! Traversal: many rays through the scene's trees.

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
#[cfg(target_arch = "x86_64")]
mod beam;
#[cfg(target_arch = "x86_64")]
mod eight;
mod one;
#[cfg(target_arch = "x86_64")]
mod packet;
mod search;
mod single;
mod slabs;
mod wave;

pub use one::{RayByRay, RayMemory};

use brewster_lanes::{Level, dispatch};

use crate::hit::{Hit, HitsViewMut};
use crate::ray::Rays;
use crate::scene::SceneGeometry;

/// The nearest hit of every ray, or [`Hit::miss`]. Panics if there are fewer rows for hits than rays.
///
/// The hits do not depend on the level, the trees or the other rays.
///
/// Reads: the scene, rays. Writes: hits.
pub fn closest_hits(scene: &SceneGeometry<'_>, level: Level, rays: Rays<'_>, mut hits: HitsViewMut<'_>) {
    assert!(hits.len() >= rays.len(), "every ray has a row for its hit");
    if !wave::run(scene, level, rays, wave::Closest(hits.reborrow())) {
        closest_single(level, scene, rays, hits.reborrow());
    }
}

/// Whether every ray hits anything with 0 < t < `t_max`. Panics if there are fewer rows for that than rays.
///
/// Reads: the scene, rays, `t_max`. Writes: `out`.
pub fn occluded(scene: &SceneGeometry<'_>, level: Level, rays: Rays<'_>, t_max: &[f32], out: &mut [bool]) {
    assert!(t_max.len() >= rays.len() && out.len() >= rays.len(), "every ray has a row");
    if !wave::run(scene, level, rays, wave::Occluded { t_max, out: &mut *out }) {
        occluded_single(level, scene, rays, t_max, out);
    }
}

thread_local! {
    /// Stacks of the single-ray kernel, kept by its thread from one batch to the next.
    static STACKS: std::cell::RefCell<single::Stacks> = std::cell::RefCell::default();
}

dispatch! {
    fn closest_single<'a, 'b, 'c>(scene: &SceneGeometry<'a>, rays: Rays<'b>, hits: HitsViewMut<'c>) {
        let mut hits = hits;
        let mut stacks = STACKS.take();
        for i in 0..rays.len() {
            let mut nearest = search::Nearest(Hit::miss());
            single::search(scene, &rays.get(i), &mut stacks, &mut nearest);
            hits.set(i, nearest.0);
        }
        STACKS.set(stacks);
    }

    fn occluded_single<'a, 'b, 'c>(scene: &SceneGeometry<'a>, rays: Rays<'b>, t_max: &'c [f32], out: &'c mut [bool]) {
        let mut stacks = STACKS.take();
        for i in 0..rays.len() {
            let mut any = search::Any { t_max: t_max[i], found: false };
            single::search(scene, &rays.get(i), &mut stacks, &mut any);
            out[i] = any.found;
        }
        STACKS.set(stacks);
    }
}
