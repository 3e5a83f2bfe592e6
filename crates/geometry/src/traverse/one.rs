//! One ray at a time, from its start to its hit, on registers of eight lanes: for whoever has no second ray yet.
//!
//! The steps are the wave's, without its lists: a node's eight boxes at once, children in order, a patch's eight triangles at
//! once. Nothing but the processor's own looking ahead hides the memory's latency.
#![expect(unsafe_code, reason = "stacks are sized before the search, which then checks no bounds")]

use brewster_lanes::Level;

use super::slabs::Slabs;
use super::wave::Kernel;
use super::{search, single};
use crate::hit::Hit;
use crate::ray::Ray;
use crate::scene::SceneGeometry;
use crate::shape::{Analytic, LocalHit, with_shape};
use crate::tree::MeshTree;
use crate::tree::node::{LEAF, Node};
use crate::triangle::Shear;

/// The memory of a search. One thread uses it at a time; it grows with the depth of trees and is kept.
#[derive(Default)]
pub struct RayMemory {
    entries: Vec<Entry>,
    plain: single::Stacks,
}

/// What waits: where the ray enters it, and a reference.
type Entry = [u32; 2];

impl std::fmt::Debug for RayMemory {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("RayMemory").field("entries", &self.entries.len()).finish()
    }
}

impl RayMemory {
    /// Bytes of memory taken.
    pub fn bytes(&self) -> usize {
        self.entries.capacity() * size_of::<Entry>()
    }
}

/// Sends rays through a scene, one at a time. What it finds is what [`closest_hits`](crate::closest_hits) and
/// [`occluded`](crate::occluded) find.
#[derive(Debug)]
pub struct RayByRay<'a> {
    scene: SceneGeometry<'a>,
    level: Level,
    memory: &'a mut RayMemory,
    only_instance: Option<u32>,
}

impl<'a> RayByRay<'a> {
    /// Makes ready for a scene's trees.
    pub fn new(scene: SceneGeometry<'a>, level: Level, memory: &'a mut RayMemory) -> RayByRay<'a> {
        let deepest = scene.mesh_trees.iter().fold(1, |most, tree| most.max(tree.stack));
        let entries = scene.top.stack + deepest + 16;
        memory.entries.resize(entries.max(memory.entries.len()), [0; 2]);
        RayByRay { scene, level, memory, only_instance: scene.top.only_instance() }
    }

    /// The nearest hit, or [`Hit::miss`].
    #[inline]
    pub fn closest_hit(&mut self, ray: &Ray) -> Hit {
        if self.level.has_avx2() {
            return self.search::<false>(ray, f32::INFINITY);
        }
        let mut nearest = search::Nearest(Hit::miss());
        single::search(&self.scene, ray, &mut self.memory.plain, &mut nearest, &mut ());
        nearest.0
    }

    /// Whether the ray hits anything with 0 < t < `t_max`.
    #[inline]
    pub fn occluded(&mut self, ray: &Ray, t_max: f32) -> bool {
        if self.level.has_avx2() {
            return !self.search::<true>(ray, t_max).is_miss();
        }
        let mut any = search::Any { t_max, found: false };
        single::search(&self.scene, ray, &mut self.memory.plain, &mut any, &mut ());
        any.found
    }

    #[inline(always)]
    fn search<const ANY: bool>(&mut self, ray: &Ray, limit: f32) -> Hit {
        let half = self.memory.entries.len();
        let distances: *mut f32 = self.memory.entries.as_mut_ptr().cast();
        let stack = Stack { distances, references: distances.wrapping_add(half).cast() };
        #[cfg(target_arch = "x86_64")]
        // SAFETY: a `Level` exists only for instruction sets that this machine has; the stack is that of the scene's trees.
        return unsafe { super::avx2::one::<ANY>(&self.scene, self.only_instance, ray, limit, stack) };
        #[cfg(not(target_arch = "x86_64"))]
        unreachable!("the level has AVX2: {:?} {:?}", (ray, limit), (stack, self.only_instance))
    }
}

/// Where what waits begins.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stack {
    distances: *mut f32,
    references: *mut u32,
}

impl Stack {
    #[inline(always)]
    fn above(self, entries: usize) -> Stack {
        let Stack { distances, references } = self;
        Stack { distances: distances.wrapping_add(entries), references: references.wrapping_add(entries) }
    }
}

/// What was found so far.
struct Found<const ANY: bool> {
    hit: Hit,
    /// Hits beyond this are of no use.
    limit: f32,
}

impl<const ANY: bool> Found<ANY> {
    /// Takes a hit; true if the search is over.
    #[inline(always)]
    fn offer(&mut self, instance: u32, local: LocalHit) -> bool {
        let hit = Hit { t: local.t, u: local.u, v: local.v, instance, primitive: local.primitive };
        if ANY {
            let found = hit.t < self.limit;
            if found {
                self.hit = hit;
            }
            return found;
        }
        if hit.precedes(&self.hit) {
            self.hit = hit;
            self.limit = hit.t;
        }
        false
    }
}

/// Searches the whole scene.
///
/// # Safety
/// The machine has the kernel's instruction set; the stack has room for the deepest tree of each level, and eight entries more.
#[inline(always)]
pub(super) unsafe fn one<K: Kernel, const ANY: bool>(
    scene: &SceneGeometry<'_>,
    only_instance: Option<u32>,
    ray: &Ray,
    limit: f32,
    stack: Stack,
) -> Hit {
    let mut found = Found::<ANY> { hit: Hit::miss(), limit };
    // SAFETY: as stated.
    unsafe {
        for &plane in scene.planes {
            let local = scene.local_ray(plane, ray);
            let row = scene.shapes[plane as usize].row as usize;
            if let Some(hit) = scene.table.planes[row].intersect(&local)
                && found.offer(plane, hit)
            {
                return found.hit;
            }
        }
        if let Some(instance) = only_instance {
            enter::<K, ANY>(scene, instance, ray, &mut found, stack);
            return found.hit;
        }
        let start = ray.origin.abs().max_element();
        let Some(slabs) = Slabs::new(ray, scene.top.reach, scene.top.slack(start)) else { return found.hit };
        walk::<K, ANY>(&scene.top.nodes, &slabs, &mut found, stack, &InScene { scene, ray });
    }
    found.hit
}

/// What the leaves of a tree are. (Closures would not be compiled for the instruction set.)
trait Leaves {
    /// Searches a leaf, with what is left of the stack; true if the search is over.
    ///
    /// # Safety
    /// As that of [`walk`]; the leaf is one of the tree.
    unsafe fn visit<K: Kernel, const ANY: bool>(&self, leaf: u32, found: &mut Found<ANY>, stack: Stack) -> bool;
}

/// The leaves of the tree over instances.
struct InScene<'a> {
    scene: &'a SceneGeometry<'a>,
    ray: &'a Ray,
}

impl Leaves for InScene<'_> {
    #[inline(always)]
    unsafe fn visit<K: Kernel, const ANY: bool>(&self, leaf: u32, found: &mut Found<ANY>, stack: Stack) -> bool {
        // SAFETY: as stated.
        unsafe { enter::<K, ANY>(self.scene, leaf, self.ray, found, stack) }
    }
}

/// The leaves of a mesh's tree.
struct InMesh<'a> {
    tree: &'a MeshTree,
    shear: &'a Shear,
    instance: u32,
}

impl Leaves for InMesh<'_> {
    #[inline(always)]
    unsafe fn visit<K: Kernel, const ANY: bool>(&self, leaf: u32, found: &mut Found<ANY>, _: Stack) -> bool {
        let InMesh { tree, shear, instance } = *self;
        let mut sheared = [[0.0; 8]; 3];
        // SAFETY: as stated; a patch's triangles are in its tree's list of primitives.
        unsafe {
            let patch = tree.patches.get_unchecked(leaf as usize);
            let mut mask = K::filter(shear, patch, found.limit, &mut sheared);
            while mask != 0 {
                let triangle = mask.trailing_zeros() as usize;
                mask &= mask - 1;
                let Some(hit) = shear.finish_lane(patch, triangle, &sheared) else { continue };
                let primitive = *tree.primitives.get_unchecked(patch.first as usize + triangle);
                if found.offer(instance, LocalHit { primitive, ..hit }) {
                    return true;
                }
            }
        }
        false
    }
}

/// Visits the leaves of a tree that the ray meets, the nearest first; true if the search is over.
///
/// # Safety
/// The machine has the kernel's instruction set, and the stack has room for the tree and eight entries more.
#[inline(always)]
unsafe fn walk<K: Kernel, const ANY: bool>(
    nodes: &[Node],
    slabs: &Slabs,
    found: &mut Found<ANY>,
    stack: Stack,
    leaves: &impl Leaves,
) -> bool {
    let (mut waiting, mut reference) = (0, 0);
    loop {
        // SAFETY: as stated; what waits are numbers of the tree's nodes and leaves.
        unsafe {
            if reference & LEAF == 0 {
                let node = nodes.get_unchecked(reference as usize);
                let mut enter = [0.0; 8];
                let met = K::meet(slabs, node, found.limit, &mut enter);
                let Stack { distances, references } = stack.above(waiting);
                // One child or two are the rule: the processor guesses how many, and looks at the next node before it knows.
                match met.count_ones() {
                    0 => {}
                    1 => {
                        reference = node.children[met.trailing_zeros() as usize & 7];
                        continue;
                    }
                    2 => {
                        let pair = [met.trailing_zeros() as usize & 7, met.ilog2() as usize & 7];
                        let [near, far] = if enter[pair[0]] <= enter[pair[1]] { pair } else { [pair[1], pair[0]] };
                        (*distances, *references) = (enter[far], node.children[far]);
                        waiting += 1;
                        reference = node.children[near];
                        continue;
                    }
                    _ if ANY => waiting += K::push::<false>(slabs, node, found.limit, distances, references) as usize,
                    _ => waiting += K::push::<true>(slabs, node, found.limit, distances, references) as usize,
                }
            } else if leaves.visit::<K, ANY>(reference & !LEAF, found, stack.above(waiting)) {
                return true;
            }
            loop {
                if waiting == 0 {
                    return false;
                }
                waiting -= 1;
                // The limit of any hit never falls: what was pushed is still before it.
                if ANY || *stack.distances.add(waiting) <= found.limit {
                    break;
                }
            }
            reference = *stack.references.add(waiting);
        }
    }
}

/// Searches one instance; true if the search is over.
///
/// # Safety
/// As that of [`walk`].
#[inline(always)]
unsafe fn enter<K: Kernel, const ANY: bool>(
    scene: &SceneGeometry<'_>,
    instance: u32,
    ray: &Ray,
    found: &mut Found<ANY>,
    stack: Stack,
) -> bool {
    let local = scene.local_ray(instance, ray);
    let shape = scene.shapes[instance as usize];
    with_shape!(scene.table, shape,
        analytic => match analytic.intersect(&local) {
            Some(hit) => found.offer(instance, hit),
            None => false,
        },
        mesh => {
            let tree = &scene.mesh_trees[mesh];
            let Some(slabs) = Slabs::new(&local, tree.reach, 0.0) else { return false };
            let shear = Shear::new(&local);
            // SAFETY: as stated.
            unsafe { walk::<K, ANY>(&tree.nodes, &slabs, found, stack, &InMesh { tree, shear: &shear, instance }) }
        }
    )
}
