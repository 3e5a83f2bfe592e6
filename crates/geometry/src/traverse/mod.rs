//! Traversal: many rays through the scene's trees.

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod beam;
mod by_obvhs;
#[cfg(target_arch = "x86_64")]
mod candidates;
#[cfg(target_arch = "x86_64")]
mod eight;
mod one;
#[cfg(target_arch = "x86_64")]
mod packet;
mod ready;
mod search;
mod single;
mod slabs;
mod task;
mod wave;

pub use by_obvhs::ObvhsTrees;
pub use one::{RayByRay, RayMemory};

use brewster_lanes::{Level, dispatch};

use crate::hit::{Hit, HitsViewMut};
use crate::ray::{Ray, Rays};
use crate::scene::SceneGeometry;

/// How rays are taken through the trees. Every kernel finds the same hits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Kernel {
    /// Sixteen coherent rays together where the level is AVX-512, the others in waves: the fastest.
    #[default]
    Packets,
    /// Many rays in flight, each on its own way; where the level is below AVX2, one after the other.
    Wave,
    /// One ray after the other, in plain Rust.
    Single,
    /// One ray after the other by obvhs's own traversal; as `Single` where the scene has no [`ObvhsTrees`].
    Obvhs,
}

/// What a ray that goes alone looks at on its way to its nearest hit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Visits {
    /// Nodes, of eight boxes each, in both levels of trees.
    pub nodes: u32,
    /// Instances whose space it was taken to.
    pub instances: u32,
    /// Shapes and triangles that it was tested against.
    pub primitives: u32,
}

impl single::Tally for Visits {
    fn node(&mut self) {
        self.nodes += 1;
    }

    fn instance(&mut self) {
        self.instances += 1;
    }

    fn primitives(&mut self, number: u32) {
        self.primitives += number;
    }
}

/// Counts what a ray looks at with [`Kernel::Single`]; the kernels that only find hits are compiled without counting. A packet
/// looks at more, what any of its rays asks for.
pub fn visits(scene: &SceneGeometry<'_>, ray: &Ray) -> Visits {
    let mut visits = Visits::default();
    let mut stacks = STACKS.take();
    single::search(scene, ray, &mut stacks, &mut search::Nearest(Hit::miss()), &mut visits);
    STACKS.set(stacks);
    visits
}

/// The same of a ray that looks for any hit with 0 < t < `t_max`.
pub fn visits_until_blocked(scene: &SceneGeometry<'_>, ray: &Ray, t_max: f32) -> Visits {
    let mut visits = Visits::default();
    let mut stacks = STACKS.take();
    single::search(scene, ray, &mut stacks, &mut search::Any { t_max, found: false }, &mut visits);
    STACKS.set(stacks);
    visits
}

/// The nearest hit of every ray, or [`Hit::miss`], by the fastest kernel. Panics if there are fewer rows for hits than rays.
///
/// The hits do not depend on the level, the trees or the other rays.
///
/// Reads: the scene, rays. Writes: hits.
pub fn closest_hits(scene: &SceneGeometry<'_>, level: Level, rays: Rays<'_>, hits: HitsViewMut<'_>) {
    closest_hits_by(Kernel::default(), scene, level, rays, hits);
}

/// The same by a kernel of one's choice.
///
/// Reads: the scene, rays. Writes: hits.
pub fn closest_hits_by(
    kernel: Kernel,
    scene: &SceneGeometry<'_>,
    level: Level,
    rays: Rays<'_>,
    mut hits: HitsViewMut<'_>,
) {
    assert!(hits.len() >= rays.len(), "every ray has a row for its hit");
    if let Some(trees) = scene.obvhs.filter(|_| kernel == Kernel::Obvhs) {
        closest_obvhs(level, scene, trees, rays, hits);
    } else if !wave::run(kernel, scene, level, rays, task::Closest(hits.reborrow())) {
        closest_single(level, scene, rays, hits);
    }
}

/// Whether every ray hits anything with 0 < t < `t_max`. Panics if there are fewer rows for that than rays.
///
/// Reads: the scene, rays, `t_max`. Writes: `out`.
pub fn occluded(scene: &SceneGeometry<'_>, level: Level, rays: Rays<'_>, t_max: &[f32], out: &mut [bool]) {
    occluded_by(Kernel::default(), scene, level, rays, t_max, out);
}

/// The same by a kernel of one's choice.
///
/// Reads: the scene, rays, `t_max`. Writes: `out`.
pub fn occluded_by(
    kernel: Kernel,
    scene: &SceneGeometry<'_>,
    level: Level,
    rays: Rays<'_>,
    t_max: &[f32],
    out: &mut [bool],
) {
    assert!(t_max.len() >= rays.len() && out.len() >= rays.len(), "every ray has a row");
    if let Some(trees) = scene.obvhs.filter(|_| kernel == Kernel::Obvhs) {
        occluded_obvhs(level, scene, trees, rays, t_max, out);
    } else if !wave::run(kernel, scene, level, rays, task::Occluded { t_max, out: &mut *out }) {
        occluded_single(level, scene, rays, t_max, out);
    }
}

thread_local! {
    /// Stacks of the single-ray kernel, kept by its thread from one batch to the next.
    static STACKS: std::cell::RefCell<single::Stacks> = std::cell::RefCell::default();
}

dispatch! {
    fn closest_obvhs<'a, 'b, 'c>(scene: &SceneGeometry<'a>, trees: &ObvhsTrees, rays: Rays<'b>, hits: HitsViewMut<'c>) {
        let mut hits = hits;
        let mut stacks = STACKS.take();
        for i in 0..rays.len() {
            let mut nearest = search::Nearest(Hit::miss());
            by_obvhs::search_by_obvhs(scene, trees, &rays.get(i), &mut stacks, &mut nearest);
            hits.set(i, nearest.0);
        }
        STACKS.set(stacks);
    }

    fn occluded_obvhs<'a, 'b, 'c>(
        scene: &SceneGeometry<'a>,
        trees: &ObvhsTrees,
        rays: Rays<'b>,
        t_max: &'c [f32],
        out: &'c mut [bool],
    ) {
        let mut stacks = STACKS.take();
        for i in 0..rays.len() {
            let mut any = search::Any { t_max: t_max[i], found: false };
            by_obvhs::search_by_obvhs(scene, trees, &rays.get(i), &mut stacks, &mut any);
            out[i] = any.found;
        }
        STACKS.set(stacks);
    }

    fn closest_single<'a, 'b, 'c>(scene: &SceneGeometry<'a>, rays: Rays<'b>, hits: HitsViewMut<'c>) {
        let mut hits = hits;
        let mut stacks = STACKS.take();
        for i in 0..rays.len() {
            let mut nearest = search::Nearest(Hit::miss());
            single::search(scene, &rays.get(i), &mut stacks, &mut nearest, &mut ());
            hits.set(i, nearest.0);
        }
        STACKS.set(stacks);
    }

    fn occluded_single<'a, 'b, 'c>(scene: &SceneGeometry<'a>, rays: Rays<'b>, t_max: &'c [f32], out: &'c mut [bool]) {
        let mut stacks = STACKS.take();
        for i in 0..rays.len() {
            let mut any = search::Any { t_max: t_max[i], found: false };
            single::search(scene, &rays.get(i), &mut stacks, &mut any, &mut ());
            out[i] = any.found;
        }
        STACKS.set(stacks);
    }
}
