//! Many rays in flight: while one waits for memory, others are worked on.
//!
//! Every slot holds a ray and its stack. A round has four passes over lists of slots, with no branch that is hard to predict
//! inside a step:
//!
//! 1. pop: every active slot takes its next reference, asks the cache for what it names, and joins the list for its kind, by
//!    being written to all lists of which one advances; finished slots hand in their hit and take the next ray;
//! 2. instances: a ray that met an instance is mapped to object space, where it meets a shape or begins a mesh's tree;
//! 3. nodes: eight boxes, their children pushed in order;
//! 4. patches: eight triangles in f32, those that may be hit in f64.
//!
//! Against one ray after the other in plain Rust (`benches/traversal.rs`, AVX2, best of four rounds): camera rays 1.7 to 2.0 times
//! the rays per second, bounces 1.8 to 4.8, shadow rays 1.7 to 3.4; most where the tree is larger than the cache.
//!
//! Two levels share one stack: entering a mesh leaves a [`LEAVE`] behind, under which the top level's entries wait. What a slot
//! finds depends on its ray alone, whatever the other slots do.
#![expect(unsafe_code, reason = "lists and stacks are sized before the loop, which then checks no bounds")]

use brewster_lanes::{Level, prefetch};
use glam::Vec3;

use super::ready::{RUN, Ready};
use super::slabs::Slabs;
use super::task::Task;
use crate::hit::{Hit, MISS};
use crate::ray::{Ray, Rays};
use crate::scene::SceneGeometry;
use crate::shape::{Analytic, LocalHit, ShapeKind, with_shape};
use crate::tree::MeshTree;
use crate::tree::node::{LEAF, Node, Patch};
use crate::triangle::Shear;

/// Rays in flight: 16 to 64 are alike, fewer leave memory waiting.
const SLOTS: usize = 32;

/// Bytes of trees that stay in the cache next to a core: asking for them would take longer than waiting.
const IN_CACHE: usize = 1 << 18;

/// Under the last entry of a stack.
const DONE: u32 = u32::MAX;

/// Under the last entry of a mesh's tree.
const LEAVE: u32 = u32::MAX - 1;

/// The steps that are written for an instruction set.
pub(crate) trait Kernel {
    /// Where the ray enters the children of a node, and a bit for each that it meets before `limit`. Distances may be rounded down, never
    /// up.
    ///
    /// # Safety
    /// The machine has the kernel's instruction set.
    unsafe fn meet(slabs: &Slabs, node: &Node, limit: f32, enter: &mut [f32; 8]) -> u32;

    /// Pushes the children of a node that the ray meets before `limit` and returns their number: the nearest last if `ORDERED`.
    /// Distances may be rounded down, never up.
    ///
    /// # Safety
    /// The machine has the kernel's instruction set, and both stacks have room for eight entries.
    unsafe fn push<const ORDERED: bool>(
        slabs: &Slabs,
        node: &Node,
        limit: f32,
        distances: *mut f32,
        references: *mut u32,
    ) -> u32;

    /// Shears the vertices of a patch, and returns a bit for every triangle that the ray may hit before `limit`. Without a bit, the
    /// sheared vertices need not be written.
    ///
    /// # Safety
    /// The machine has the kernel's instruction set.
    unsafe fn filter(shear: &Shear, patch: &Patch, limit: f32, sheared: &mut [[f32; 8]; 3]) -> u32;
}

/// A ray in flight.
#[repr(C, align(64))]
struct Slot {
    /// The ray in the space that it is in now.
    slabs: Slabs,
    stack: u32,
    /// Hits beyond this are of no use.
    limit: f32,
    current: u32,
    /// Where nodes and leaves begin in the tree that the ray is in now, and how many bytes each of them takes.
    bases: [*const u8; 2],
    strides: [u32; 2],
    /// 1 among instances, 0 in a mesh.
    on_top: u32,
    instance: u32,
    shear: Shear,
    primitives: *const u32,
    hit: Hit,
    ray_index: u32,
    ray: Ray,
    top: Slabs,
}

/// Sends rays through the scene with steps for the level's instruction set; false if there are none, or another kernel is asked for.
pub(crate) fn run<T: Task>(
    kernel: super::Kernel,
    scene: &SceneGeometry<'_>,
    level: Level,
    rays: Rays<'_>,
    task: T,
) -> bool {
    if matches!(kernel, super::Kernel::Single | super::Kernel::Obvhs) || !level.has_avx2() {
        return false;
    }
    // Taken out of its place, since a closure would not be compiled for the level.
    let mut memory = MEMORY.take();
    #[cfg(target_arch = "x86_64")]
    // SAFETY: a `Level` exists only for instruction sets that this machine has.
    unsafe {
        // Packets look for the nearest hits only: shadow rays are seldom coherent, and end at their first hit.
        if level.has_avx512() && !T::ANY && kernel == super::Kernel::Packets {
            let (mut task, mut rest) = (task, std::mem::take(&mut memory.rest));
            super::packet::trace(scene, rays, &mut task, &mut memory.packets, &mut rest);
            super::avx2::run(scene, rays, Some(&rest), task, &mut memory);
            memory.rest = rest;
        } else {
            super::avx2::run(scene, rays, None, task, &mut memory);
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (scene, rays, task);
    MEMORY.set(memory);
    true
}

/// The memory of a wave, kept by its thread from one batch to the next.
#[derive(Default)]
pub(crate) struct Memory {
    slots: Vec<Slot>,
    stacks: Vec<u32>,
    #[cfg(target_arch = "x86_64")]
    pub(crate) packets: super::packet::Memory,
    /// Rays that no packet took.
    #[cfg(target_arch = "x86_64")]
    pub(crate) rest: Vec<u32>,
}

thread_local! {
    static MEMORY: std::cell::RefCell<Memory> = std::cell::RefCell::default();
}

/// The stacks of all slots: for each slot distances, then references.
#[derive(Clone, Copy)]
struct Stacks {
    base: *mut u32,
    /// Entries of one stack.
    entries: usize,
    /// Words from one slot's stacks to the next.
    stride: usize,
}

impl Stacks {
    /// Takes memory for stacks of so many entries.
    fn new(memory: &mut Vec<u32>, entries: usize) -> Stacks {
        let words = (2 * entries).next_multiple_of(16);
        // Never a multiple of 1 KiB, or slots would compete for the same cache lines (5 to 15 % slower).
        let stride = if words.is_multiple_of(256) { words + 16 } else { words };
        memory.resize((SLOTS * stride).max(memory.len()), 0);
        Stacks { base: memory.as_mut_ptr(), entries, stride }
    }

    /// Distances and references of a slot.
    #[inline(always)]
    fn of(&self, slot: usize) -> (*mut f32, *mut u32) {
        let distances = self.base.wrapping_add(slot * self.stride);
        (distances.cast(), distances.wrapping_add(self.entries))
    }
}

/// Lists of slots, by what they do next.
struct Lists {
    active: [u8; SLOTS],
    nodes: [u8; SLOTS + 1],
    patches: [u8; SLOTS + 1],
    instances: [u8; SLOTS + 1],
    /// At the bottom of a tree: of a mesh's, or of the scene's.
    bottom: [u8; SLOTS + 1],
}

/// Sends rays through the scene: all, or those listed in `order`.
///
/// # Safety
/// The machine has the kernel's instruction set.
#[inline(always)]
pub(crate) unsafe fn wave<K: Kernel, T: Task>(
    scene: &SceneGeometry<'_>,
    rays: Rays<'_>,
    order: Option<&[u32]>,
    task: T,
    memory: &mut Memory,
) {
    let deepest = scene.mesh_trees.iter().fold(1, |most, tree| most.max(tree.stack));
    let entries = scene.top.stack + deepest + 16;
    memory.slots.resize_with(SLOTS, Slot::idle);
    let stacks = Stacks::new(&mut memory.stacks, entries);
    let slots: &mut [Slot; SLOTS] = memory.slots.as_mut_slice().try_into().expect("there are that many slots");
    let start = Start::new(scene);
    let bytes: usize =
        scene.mesh_trees.iter().map(|tree| size_of_val(&*tree.nodes) + size_of_val(&*tree.patches)).sum();
    let prefetches = bytes + size_of_val(scene.top.nodes.as_slice()) > IN_CACHE;
    let ready = Ready::default();
    let mut wave = Wave { scene, rays, order, task, slots, stacks, start, prefetches, next_ray: 0, ready };
    // SAFETY: the stacks have room for the deepest tree of each level, their sentinels, and eight entries more.
    unsafe { wave.run::<K>() };
}

struct Wave<'a, 'm, T> {
    scene: &'a SceneGeometry<'a>,
    rays: Rays<'a>,
    /// Which rays to trace, if not all.
    order: Option<&'a [u32]>,
    task: T,
    slots: &'m mut [Slot; SLOTS],
    stacks: Stacks,
    start: Start<'a>,
    /// Whether to ask the cache for what comes next.
    prefetches: bool,
    next_ray: usize,
    /// The run of rays that the next one is in.
    ready: Ready,
}

/// Where rays begin.
#[derive(Clone, Copy)]
enum Start<'a> {
    /// Among the instances.
    Top,
    /// In the tree of a mesh, without a look at its instance's box: there is no other instance, and it does not move.
    Mesh(u32, &'a MeshTree),
}

impl<'a> Start<'a> {
    fn new(scene: &SceneGeometry<'a>) -> Start<'a> {
        let Some(instance) = scene.top.only_instance() else { return Start::Top };
        let shape = scene.shapes[instance as usize];
        if shape.kind != ShapeKind::Mesh || scene.motions.at(instance, 0.0).is_some() {
            return Start::Top;
        }
        Start::Mesh(instance, &scene.mesh_trees[shape.row as usize])
    }
}

impl Slot {
    fn idle() -> Slot {
        let ray = Ray { origin: Vec3::ZERO, direction: Vec3::X, time: 0.0 };
        Slot {
            slabs: Slabs::default(),
            stack: 0,
            limit: 0.0,
            current: DONE,
            bases: [std::ptr::null(); 2],
            strides: [0; 2],
            on_top: 1,
            instance: MISS,
            shear: Shear::new(&ray),
            primitives: std::ptr::null(),
            hit: Hit::miss(),
            ray_index: 0,
            ray,
            top: Slabs::default(),
        }
    }

    /// Takes a hit in the slot's instance; true if the search is over.
    #[inline(always)]
    fn offer<T: Task>(&mut self, local: LocalHit) -> bool {
        let hit = Hit { t: local.t, u: local.u, v: local.v, instance: self.instance, primitive: local.primitive };
        if T::ANY {
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

    /// Goes among the instances.
    #[inline(always)]
    fn go_on_top(&mut self, scene: &SceneGeometry<'_>) {
        self.slabs = self.top;
        self.on_top = 1;
        self.bases = [scene.top.nodes.as_ptr().cast(), scene.world_to_object.as_ptr().cast()];
        self.strides = [size_of::<Node>() as u32, size_of::<crate::Affine>() as u32];
    }

    /// Goes into the tree of a mesh.
    #[inline(always)]
    fn go_into(&mut self, tree: &MeshTree) {
        self.on_top = 0;
        self.bases = [tree.nodes.as_ptr().cast(), tree.patches.as_ptr().cast()];
        self.strides = [size_of::<Node>() as u32, size_of::<Patch>() as u32];
        self.primitives = tree.primitives.as_ptr();
    }
}

impl<T: Task> Wave<'_, '_, T> {
    /// # Safety
    /// The machine has the kernel's instruction set; stacks have room for the deepest path through both levels, a sentinel for
    /// each level, and eight entries more.
    #[inline(always)]
    unsafe fn run<K: Kernel>(&mut self) {
        let mut lists = Lists {
            active: [0; SLOTS],
            nodes: [0; SLOTS + 1],
            patches: [0; SLOTS + 1],
            instances: [0; SLOTS + 1],
            bottom: [0; SLOTS + 1],
        };
        let mut active = 0;
        for slot in 0..SLOTS {
            lists.active[active] = slot as u8;
            active += self.begin(slot) as usize;
        }
        while active > 0 {
            // SAFETY: lists hold numbers of slots, each slot in one of them; see also above.
            unsafe {
                let [mut nodes, patches, instances, bottom] = self.pop(&mut lists, active);
                active = 0;
                for i in 0..bottom {
                    let slot = *lists.bottom.get_unchecked(i);
                    let goes_on = self.end(slot as usize);
                    *lists.active.get_unchecked_mut(active) = slot;
                    active += goes_on as usize;
                }
                for i in 0..instances {
                    let slot = *lists.instances.get_unchecked(i);
                    let begins_mesh = self.enter(slot as usize);
                    *lists.nodes.get_unchecked_mut(nodes) = slot;
                    nodes += begins_mesh as usize;
                    *lists.active.get_unchecked_mut(active) = slot;
                    active += (!begins_mesh) as usize;
                }
                for i in 0..nodes {
                    let slot = *lists.nodes.get_unchecked(i);
                    self.node::<K>(slot as usize);
                    *lists.active.get_unchecked_mut(active) = slot;
                    active += 1;
                }
                for i in 0..patches {
                    let slot = *lists.patches.get_unchecked(i);
                    self.patch::<K>(slot as usize);
                    *lists.active.get_unchecked_mut(active) = slot;
                    active += 1;
                }
            }
        }
    }

    /// Every active slot takes its next reference and joins a list; returns how many are in each.
    ///
    /// # Safety
    /// The first `active` entries of the list of active slots are different numbers of slots, whose stacks are not empty.
    #[inline(always)]
    unsafe fn pop(&mut self, lists: &mut Lists, active: usize) -> [usize; 4] {
        let (mut nodes, mut patches, mut instances, mut bottom) = (0, 0, 0, 0);
        for i in 0..active {
            // SAFETY: as stated; the sentinel under every stack is nearer than any limit.
            unsafe {
                let slot = *lists.active.get_unchecked(i);
                let (distances, references) = self.stacks.of(slot as usize);
                let state = self.slots.get_unchecked_mut(slot as usize);
                let mut top = state.stack as usize - 1;
                // The limit of any hit never falls: what was pushed is still before it.
                while !T::ANY && *distances.add(top) > state.limit {
                    top -= 1;
                }
                let reference = *references.add(top);
                state.stack = top as u32;
                state.current = reference;
                let (leaf, end) = ((reference >> 31) as usize, (reference >= LEAVE) as usize);
                let index = reference & !LEAF & (end as u32).wrapping_sub(1);
                let (base, stride) = (*state.bases.get_unchecked(leaf), *state.strides.get_unchecked(leaf));
                if self.prefetches {
                    prefetch_block(base.wrapping_add(index as usize * stride as usize), stride);
                }
                *lists.nodes.get_unchecked_mut(nodes) = slot;
                *lists.patches.get_unchecked_mut(patches) = slot;
                *lists.instances.get_unchecked_mut(instances) = slot;
                *lists.bottom.get_unchecked_mut(bottom) = slot;
                let inside = leaf & (end ^ 1);
                nodes += leaf ^ 1;
                patches += inside & (state.on_top as usize ^ 1);
                instances += inside & state.on_top as usize;
                bottom += end;
            }
        }
        [nodes, patches, instances, bottom]
    }

    /// At the bottom of a tree: back to the top level, or on to the next ray. False if there is none.
    #[inline(always)]
    fn end(&mut self, slot: usize) -> bool {
        let state = &mut self.slots[slot];
        if state.current == LEAVE {
            state.go_on_top(self.scene);
            return true;
        }
        let (ray, hit) = (state.ray_index as usize, state.hit);
        self.task.finish(ray, &hit);
        self.begin(slot)
    }

    /// Takes the next ray that has to be traced, with the root on its stack. False if there is none.
    #[inline(always)]
    fn begin(&mut self, slot: usize) -> bool {
        let count = self.order.map_or(self.rays.len(), <[u32]>::len);
        while self.next_ray < count {
            let lane = self.next_ray % RUN;
            if lane == 0 {
                self.make_ready(count);
            }
            let index = self.order.map_or(self.next_ray, |order| order[self.next_ray] as usize);
            self.next_ray += 1;
            let (distances, references) = self.stacks.of(slot);
            let state = &mut self.slots[slot];
            state.ray_index = index as u32;
            state.hit = Hit::miss();
            state.limit = self.task.limit(index);
            let mut over = false;
            for &plane in self.scene.planes {
                let local = self.scene.local_ray(plane, &self.rays.get(index));
                let row = self.scene.shapes[plane as usize].row as usize;
                state.instance = plane;
                if let Some(hit) = self.scene.table.planes[row].intersect(&local) {
                    over |= state.offer::<T>(hit);
                }
            }
            // SAFETY: every stack has room for more than two entries.
            unsafe {
                (*distances, *references) = (f32::NEG_INFINITY, DONE);
                (*distances.add(1), *references.add(1)) = (0.0, 0);
            }
            state.stack = 2;
            if let Some(slabs) = self.ready.slabs_of(lane)
                && !over
            {
                match self.start {
                    Start::Top => {
                        state.ray = self.rays.get(index);
                        state.top = *slabs;
                        state.go_on_top(self.scene);
                    }
                    Start::Mesh(instance, tree) => {
                        state.instance = instance;
                        state.slabs = *slabs;
                        state.shear = *self.ready.shear_of(lane);
                        state.go_into(tree);
                    }
                }
                return true;
            }
            let hit = state.hit;
            self.task.finish(index, &hit);
        }
        false
    }

    /// Makes the next rays ready for the tree that they begin in.
    #[inline(always)]
    fn make_ready(&mut self, count: usize) {
        let Wave { ready, rays, order, next_ray, scene, .. } = self;
        let number = |lane: usize| (*next_ray + lane).min(count - 1);
        ready.take(*rays, |lane| order.map_or(number(lane), |order| order[number(lane)] as usize));
        match self.start {
            Start::Top => ready.slabs(scene.top.reach, |start| scene.top.slack(start)),
            Start::Mesh(instance, tree) => {
                ready.map(&scene.world_to_object[instance as usize]);
                ready.slabs(tree.reach, |_| 0.0);
                ready.shears();
            }
        }
    }

    /// Meets an instance: its shape, or the root of its mesh's tree, which is then current. True for a mesh.
    #[inline(always)]
    fn enter(&mut self, slot: usize) -> bool {
        let (distances, references) = self.stacks.of(slot);
        let state = &mut self.slots[slot];
        let instance = state.current & !LEAF;
        state.instance = instance;
        let local = self.scene.local_ray(instance, &state.ray);
        let shape = self.scene.shapes[instance as usize];
        with_shape!(self.scene.table, shape,
            analytic => {
                if let Some(hit) = analytic.intersect(&local) && state.offer::<T>(hit) {
                    state.stack = 1;
                }
                false
            },
            mesh => {
                let tree = &self.scene.mesh_trees[mesh];
                let Some(slabs) = Slabs::new(&local, tree.reach, 0.0) else { return false };
                state.slabs = slabs;
                state.shear = Shear::new(&local);
                state.go_into(tree);
                state.current = 0;
                // Where nothing waits among the instances, the ray is done when it has been through the mesh.
                if state.stack > 1 {
                    // SAFETY: stacks have room for a sentinel in each level.
                    unsafe {
                        (*distances.add(state.stack as usize), *references.add(state.stack as usize)) =
                            (f32::NEG_INFINITY, LEAVE);
                    }
                    state.stack += 1;
                }
                true
            }
        )
    }

    /// Tests the eight boxes of the current node.
    ///
    /// # Safety
    /// The machine has the kernel's instruction set; the slot's current reference is a node of its tree.
    #[inline(always)]
    unsafe fn node<K: Kernel>(&mut self, slot: usize) {
        let (distances, references) = self.stacks.of(slot);
        // SAFETY: as stated; stacks have eight entries to spare.
        unsafe {
            let state = self.slots.get_unchecked_mut(slot);
            let node = &*state.bases[0].cast::<Node>().add(state.current as usize);
            let (distances, references) = (distances.add(state.stack as usize), references.add(state.stack as usize));
            state.stack += if T::ANY {
                K::push::<false>(&state.slabs, node, state.limit, distances, references)
            } else {
                K::push::<true>(&state.slabs, node, state.limit, distances, references)
            };
        }
    }

    /// Tests the eight triangles of the current patch.
    ///
    /// # Safety
    /// The machine has the kernel's instruction set; the slot's current reference is a patch of its tree.
    #[inline(always)]
    unsafe fn patch<K: Kernel>(&mut self, slot: usize) {
        // SAFETY: as stated; a patch's triangles are in its tree's list of primitives.
        unsafe {
            let state = self.slots.get_unchecked_mut(slot);
            let patch = &*state.bases[1].cast::<Patch>().add((state.current & !LEAF) as usize);
            let mut sheared = [[0.0; 8]; 3];
            let mut mask = K::filter(&state.shear, patch, state.limit, &mut sheared);
            while mask != 0 {
                let triangle = mask.trailing_zeros() as usize;
                mask &= mask - 1;
                let Some(hit) = state.shear.finish_lane(patch, triangle, &sheared) else { continue };
                let primitive = *state.primitives.add(patch.first as usize + triangle);
                if state.offer::<T>(LocalHit { primitive, ..hit }) {
                    state.stack = 1;
                    return;
                }
            }
        }
    }
}

/// Asks the cache for a block of 128 or 256 bytes.
#[inline(always)]
fn prefetch_block(block: *const u8, bytes: u32) {
    // The second half of a node; of anything smaller the first half again.
    let second = block.wrapping_add((bytes as usize >> 1) & 128);
    for half in [second, block] {
        prefetch(half);
        prefetch(half.wrapping_add(64));
    }
}
