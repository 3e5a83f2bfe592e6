//! Sixteen coherent rays walked together: what camera rays are.
//!
//! A node is tested once for all of them, against the interval of their origins and inverse directions; a patch triangle by
//! triangle in f32, against sixteen rays at once. Where triangles are small, each is met by a few rays: those of all a patch's
//! triangles go together when they are decided in f64, each with a triangle of its own. That pays while the rays go the same way: they must agree in the signs of their
//! direction and in its largest axis. Groups that do not are left to the wave. What a ray meets is decided by the same routine
//! as everywhere; a packet only visits more boxes than the ray alone would.
//!
//! Where what the rays meet is no larger than a few pixels, as on many small instances, a packet is mostly air and slower than the wave. So a
//! batch counts how full its packets are when they enter meshes, and goes on without them if that is too little.
#![expect(unsafe_code, reason = "intrinsics need an instruction set, which the caller proves")]

use std::arch::x86_64::*;

use super::beam::{Beam, Interval, WIDTH};
use super::candidates::{Candidates, Columns, Decided, corners};
use super::search::Nearest;
use super::single;
use super::task::Task;
use crate::aabb::Aabb;
use crate::hit::Hit;
use crate::intersect_triangle;
use crate::ray::Rays;
use crate::scene::SceneGeometry;
use crate::shape::{LocalHit, ShapeKind};
use crate::tree::MeshTree;
use crate::tree::node::{LEAF, Node, Patch};

/// Fewer rays than these go through a mesh one by one.
const FEW: u32 = 5;

/// Packets go on while this share of their rays, in sixteenths, meets the meshes they enter.
const FULL: usize = 12;

/// The memory of packets, kept by its thread from one batch to the next.
#[derive(Default)]
pub(crate) struct Memory {
    top: Stack,
    mesh: Stack,
    single: single::Stacks,
    filling: Filling,
}

/// How full the packets of a batch are.
#[derive(Clone, Copy, Default)]
struct Filling {
    /// Packets that entered a mesh.
    packets: usize,
    /// Their rays that met its box.
    rays: usize,
}

impl Filling {
    fn is_worth_it(self) -> bool {
        self.packets < 32 || self.rays >= FULL * self.packets
    }
}

#[derive(Default)]
struct Stack {
    distances: Vec<f32>,
    references: Vec<u32>,
}

impl Stack {
    /// Makes room for a tree.
    fn fit(&mut self, entries: usize) {
        // Entries are written eight at a time.
        let entries = (entries + 8).max(self.distances.len());
        self.distances.resize(entries, 0.0);
        self.references.resize(entries, 0);
    }
}

/// Traces what is coherent, and lists the other rays.
#[target_feature(enable = "avx512f,avx512vl,avx512dq,avx512bw,avx512cd,avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn trace<T: Task>(
    scene: &SceneGeometry<'_>,
    rays: Rays<'_>,
    task: &mut T,
    memory: &mut Memory,
    rest: &mut Vec<u32>,
) {
    rest.clear();
    memory.filling = Filling::default();
    memory.top.fit(scene.top.stack);
    memory.mesh.fit(scene.mesh_trees.iter().fold(1, |most, tree| most.max(tree.stack)));
    let only_instance = scene.top.only_instance();
    for first in (0..rays.len()).step_by(WIDTH) {
        let last = rays.len().min(first + WIDTH);
        let taken = last - first == WIDTH
            && memory.filling.is_worth_it()
            && trace_packet(scene, only_instance, rays, first, task, memory);
        if !taken {
            rest.extend(first as u32..last as u32);
        }
    }
}

/// Traces the sixteen rays from `first` on, if they are coherent; false if they are not.
#[target_feature(enable = "avx512f,avx512vl,avx512dq")]
#[inline]
fn trace_packet<T: Task>(
    scene: &SceneGeometry<'_>,
    only_instance: Option<u32>,
    rays: Rays<'_>,
    first: usize,
    task: &mut T,
    memory: &mut Memory,
) -> bool {
    let world = Beam::new(rays, first);
    if world.axis().is_none() || !world.is_narrow(scene.top.reach) {
        return false;
    }
    let times = rays.slice(first..first + WIDTH).time;
    let mut packet = Packet { scene, world, times, hits: Hits::misses(), limit: f32::INFINITY };
    if !packet.run(only_instance, memory) {
        return false;
    }
    task.finish_packet(first, &packet.hits);
    true
}

/// What sixteen rays hit, by columns.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
pub(crate) struct Hits {
    pub(crate) t: [f32; WIDTH],
    pub(crate) u: [f32; WIDTH],
    pub(crate) v: [f32; WIDTH],
    pub(crate) instance: [u32; WIDTH],
    pub(crate) primitive: [u32; WIDTH],
}

impl Hits {
    fn misses() -> Hits {
        let Hit { t, u, v, instance, primitive } = Hit::miss();
        Hits { t: [t; WIDTH], u: [u; WIDTH], v: [v; WIDTH], instance: [instance; WIDTH], primitive: [primitive; WIDTH] }
    }

    #[inline(always)]
    pub(crate) fn get(&self, lane: usize) -> Hit {
        Hit {
            t: self.t[lane],
            u: self.u[lane],
            v: self.v[lane],
            instance: self.instance[lane],
            primitive: self.primitive[lane],
        }
    }

    #[inline(always)]
    fn set(&mut self, lane: usize, hit: Hit) {
        self.t[lane] = hit.t;
        self.u[lane] = hit.u;
        self.v[lane] = hit.v;
        self.instance[lane] = hit.instance;
        self.primitive[lane] = hit.primitive;
    }
}

/// Sixteen rays on their way.
struct Packet<'a> {
    scene: &'a SceneGeometry<'a>,
    world: Beam,
    /// When they look, if that matters.
    times: &'a [f32],
    hits: Hits,
    /// The farthest of the rays' nearest hits.
    limit: f32,
}

impl Packet<'_> {
    /// A bit for every ray that meets a box before its nearest hit.
    #[target_feature(enable = "avx512f,avx512vl,avx512dq")]
    #[inline]
    fn meets(&self, aabb: &Aabb, interval: &Interval) -> u16 {
        // SAFETY: the column has sixteen lanes and is aligned to 64 bytes.
        unsafe {
            let (mut enter, mut leave) = (_mm512_setzero_ps(), _mm512_load_ps(self.hits.t.as_ptr()));
            for axis in 0..3 {
                let (origin, inverse) = (self.world.origin[axis], interval.inverses[axis]);
                let low = _mm512_sub_ps(_mm512_set1_ps(aabb.min[axis] - interval.pad), origin);
                let high = _mm512_sub_ps(_mm512_set1_ps(aabb.max[axis] + interval.pad), origin);
                let (low, high) = (_mm512_mul_ps(low, inverse), _mm512_mul_ps(high, inverse));
                enter = _mm512_max_ps(enter, _mm512_min_ps(low, high));
                leave = _mm512_min_ps(leave, _mm512_max_ps(low, high));
            }
            _mm512_cmp_ps_mask::<_CMP_LE_OQ>(enter, leave)
        }
    }

    /// Sends the rays through the scene; false if they cannot go together.
    #[target_feature(enable = "avx512f,avx512vl,avx512dq")]
    #[inline]
    fn run(&mut self, only_instance: Option<u32>, memory: &mut Memory) -> bool {
        let (scene, top) = (self.scene, &self.scene.top);
        let Memory { top: stack, mesh, single, filling } = memory;
        for &plane in scene.planes {
            self.enter_alone(plane, u16::MAX, single);
        }
        self.update();
        if let Some(instance) = only_instance {
            self.enter(instance, u16::MAX, mesh, single);
            return true;
        }
        let slack = top.slack(self.world.greatest_coordinate());
        let Some(interval) = Interval::new(&self.world, top.reach, slack) else { return false };
        let mut instances = Instances { interval: &interval, mesh, single, filling };
        // SAFETY: the memory was made to fit the scene's trees.
        unsafe { walk(&top.nodes, &interval, stack, self, &mut instances) };
        true
    }

    /// Meets an instance: ray by ray, or all together in its mesh's tree.
    #[target_feature(enable = "avx512f,avx512vl,avx512dq")]
    #[inline]
    fn enter(&mut self, instance: u32, lanes: u16, stack: &mut Stack, single: &mut single::Stacks) {
        let shape = self.scene.shapes[instance as usize];
        // What moves is at another place for every ray.
        let moves = self.scene.motions.keys(instance).is_some();
        if shape.kind != ShapeKind::Mesh || lanes.count_ones() < FEW || moves {
            self.enter_alone(instance, lanes, single);
            self.update();
            return;
        }
        let tree = &self.scene.mesh_trees[shape.row as usize];
        let map = &self.scene.world_to_object[instance as usize];
        let local = self.world.mapped(map);
        let axis = local.axis();
        let prepared = axis.and_then(|axis| Some((axis, Interval::new(&local, tree.reach, 0.0)?)));
        let Some((axis, interval)) = prepared else {
            self.enter_alone(instance, lanes, single);
            self.update();
            return;
        };
        let mut patches = Patches { tree, columns: Columns::new(&local, axis), local, instance };
        // SAFETY: the memory was made to fit the scene's trees.
        unsafe { walk(&tree.nodes, &interval, stack, self, &mut patches) };
    }

    /// Meets an instance ray by ray.
    #[inline(always)]
    fn enter_alone(&mut self, instance: u32, mut lanes: u16, single: &mut single::Stacks) {
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize;
            lanes &= lanes - 1;
            let mut nearest = Nearest(self.hits.get(lane));
            let time = self.times.get(lane).copied().unwrap_or(0.0);
            single::enter_instance(self.scene, instance, &self.world.ray(lane, time), single, &mut nearest);
            self.hits.set(lane, nearest.0);
        }
    }

    #[target_feature(enable = "avx512f,avx512vl,avx512dq")]
    #[inline]
    fn update(&mut self) {
        // SAFETY: the column has sixteen lanes and is aligned to 64 bytes.
        self.limit = _mm512_reduce_max_ps(unsafe { _mm512_load_ps(self.hits.t.as_ptr()) });
    }

    /// Tests the triangles of a patch against all rays: in f32, and those that may be hit in f64.
    #[target_feature(enable = "avx512f,avx512vl,avx512dq")]
    #[inline]
    fn test_patch(&mut self, patch: &Patch, context: &Patches<'_>) {
        let Patches {
            columns: Columns { axes: [kx, ky, kz], origin: [ox, oy, oz], slope: [slope_x, slope_y], .. },
            ..
        } = *context;
        let mut changed = false;
        let zero = _mm512_setzero_ps();
        let mut sheared = [[zero; 3]; 8];
        for (vertex, sheared) in sheared.iter_mut().enumerate() {
            let z = _mm512_sub_ps(_mm512_set1_ps(patch.vertices[kz][vertex]), oz);
            let x = _mm512_sub_ps(_mm512_set1_ps(patch.vertices[kx][vertex]), ox);
            let y = _mm512_sub_ps(_mm512_set1_ps(patch.vertices[ky][vertex]), oy);
            let (x, y) = (_mm512_sub_ps(x, _mm512_mul_ps(slope_x, z)), _mm512_sub_ps(y, _mm512_mul_ps(slope_y, z)));
            *sheared = [x, y, z];
        }
        // First which rays may hit which triangles, without a branch that hangs on it.
        let mut masks = [0u16; 8];
        let mut met = 0u32;
        for triangle in 0..patch.triangles as usize & 15 {
            let [a, b, c] = corners(&sheared, patch, triangle);
            let u = _mm512_sub_ps(_mm512_mul_ps(c[0], b[1]), _mm512_mul_ps(c[1], b[0]));
            let v = _mm512_sub_ps(_mm512_mul_ps(a[0], c[1]), _mm512_mul_ps(a[1], c[0]));
            let w = _mm512_sub_ps(_mm512_mul_ps(b[0], a[1]), _mm512_mul_ps(b[1], a[0]));
            let least = _mm512_min_ps(_mm512_min_ps(u, v), w);
            let most = _mm512_max_ps(_mm512_max_ps(u, v), w);
            let mask = _mm512_cmp_ps_mask::<_CMP_GE_OQ>(least, zero) | _mm512_cmp_ps_mask::<_CMP_LE_OQ>(most, zero);
            masks[triangle & 7] = mask;
            met |= u32::from(mask != 0) << triangle;
        }
        // Then for every ray the triangle that it may hit, as far as it is one.
        let mut candidates = Candidates::none();
        while met != 0 {
            let triangle = met.trailing_zeros() as usize & 7;
            met &= met - 1;
            if candidates.lanes & masks[triangle] != 0 {
                changed |= self.finish(patch, &candidates, context);
                candidates.lanes = 0;
            }
            candidates.take(masks[triangle], triangle, corners(&sheared, patch, triangle));
        }
        if candidates.lanes != 0 {
            changed |= self.finish(patch, &candidates, context);
        }
        if changed {
            self.update();
        }
    }

    /// Decides in f64 which rays hit their triangles; true if any of them had no nearer hit.
    #[target_feature(enable = "avx512f,avx512vl,avx512dq")]
    #[inline]
    fn finish(&mut self, patch: &Patch, candidates: &Candidates, context: &Patches<'_>) -> bool {
        // Small triangles, of which there are many, are met by few of the rays.
        let lanes = candidates.lanes;
        let first = if lanes.count_ones() <= 8 { lanes } else { lanes & 0xff };
        let mut changed = self.finish_eight(patch, candidates, first, context);
        if first != lanes {
            changed |= self.finish_eight(patch, candidates, lanes & !first, context);
        }
        changed
    }

    /// The same for at most eight of them, as [`Shear::finish`] does it for one.
    #[target_feature(enable = "avx512f,avx512vl,avx512dq")]
    #[inline]
    fn finish_eight(&mut self, patch: &Patch, candidates: &Candidates, lanes: u16, context: &Patches<'_>) -> bool {
        // SAFETY: the columns have sixteen lanes and are aligned to 64 bytes; a patch has so many triangles in its tree's list.
        unsafe {
            let decided = Decided::new(candidates, context.columns.depth, lanes);
            let Decided { t, slim, .. } = decided;
            let numbers = context.tree.primitives.as_ptr().add(patch.first as usize);
            let own_primitive =
                _mm512_mask_i32gather_epi32::<4>(_mm512_setzero_si512(), lanes, candidates.triangle, numbers.cast());
            let own_instance = _mm512_set1_epi32(context.instance as i32);
            let hits = &mut self.hits;
            let best = _mm512_load_ps(hits.t.as_ptr());
            let instance = _mm512_load_si512(hits.instance.as_ptr().cast());
            let number = _mm512_load_si512(hits.primitive.as_ptr().cast());
            // As `Hit::precedes`.
            let lower_number = _mm512_cmplt_epu32_mask(own_instance, instance)
                | _mm512_cmpeq_epu32_mask(own_instance, instance) & _mm512_cmplt_epu32_mask(own_primitive, number);
            let precedes =
                _mm512_cmp_ps_mask::<_CMP_LT_OQ>(t, best) | _mm512_cmp_ps_mask::<_CMP_EQ_OQ>(t, best) & lower_number;
            let found = decided.found & precedes & !slim;
            if found != 0 {
                _mm512_mask_store_ps(hits.u.as_mut_ptr(), found, decided.u());
                _mm512_mask_store_ps(hits.v.as_mut_ptr(), found, decided.v());
                // Whole columns where they are soon read again: what is stored by a mask must reach the cache first.
                _mm512_store_ps(hits.t.as_mut_ptr(), _mm512_mask_mov_ps(best, found, t));
                let instance = _mm512_mask_mov_epi32(instance, found, own_instance);
                let number = _mm512_mask_mov_epi32(number, found, own_primitive);
                _mm512_store_si512(hits.instance.as_mut_ptr().cast(), instance);
                _mm512_store_si512(hits.primitive.as_mut_ptr().cast(), number);
            }
            (slim != 0 && self.finish_slim(patch, candidates, slim, context)) | (found != 0)
        }
    }

    /// The same ray by ray, where a triangle is too thin for its weights.
    #[cold]
    fn finish_slim(&mut self, patch: &Patch, candidates: &Candidates, mut lanes: u16, context: &Patches<'_>) -> bool {
        let mut changed = false;
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize;
            lanes &= lanes - 1;
            let triangle = candidates.triangle_of(lane);
            let corners = [0, 1, 2].map(|corner| patch.corner(triangle, corner));
            let primitive = context.tree.primitives[patch.first as usize + triangle];
            if let Some(LocalHit { t, u, v, .. }) = intersect_triangle(&context.local.ray(lane, 0.0), corners) {
                let hit = Hit { t, u, v, instance: context.instance, primitive };
                if hit.precedes(&self.hits.get(lane)) {
                    self.hits.set(lane, hit);
                    changed = true;
                }
            }
        }
        changed
    }
}

/// What a packet meets at the leaves of a tree. (A closure would not be compiled for the instruction set.)
trait Leaves {
    /// # Safety
    /// The machine has AVX-512 F, VL and DQ.
    unsafe fn visit(&mut self, packet: &mut Packet<'_>, leaf: u32);
}

/// The leaves of the top tree.
struct Instances<'m> {
    /// The rays in the world.
    interval: &'m Interval,
    mesh: &'m mut Stack,
    single: &'m mut single::Stacks,
    filling: &'m mut Filling,
}

impl Leaves for Instances<'_> {
    #[target_feature(enable = "avx512f,avx512vl,avx512dq")]
    #[inline]
    unsafe fn visit(&mut self, packet: &mut Packet<'_>, leaf: u32) {
        let lanes = packet.meets(&packet.scene.top.box_of(leaf), self.interval);
        if lanes == 0 {
            return;
        }
        if packet.scene.shapes[leaf as usize].kind == ShapeKind::Mesh {
            self.filling.packets += 1;
            self.filling.rays += lanes.count_ones() as usize;
        }
        packet.enter(leaf, lanes, self.mesh, self.single)
    }
}

/// The leaves of a mesh's tree.
struct Patches<'m> {
    tree: &'m MeshTree,
    /// The rays in the mesh's space.
    local: Beam,
    columns: Columns,
    instance: u32,
}

impl Leaves for Patches<'_> {
    #[target_feature(enable = "avx512f,avx512vl,avx512dq")]
    #[inline]
    unsafe fn visit(&mut self, packet: &mut Packet<'_>, leaf: u32) {
        packet.test_patch(&self.tree.patches[leaf as usize], self)
    }
}

/// Visits the leaves of a tree that a packet may meet, the nearest first.
///
/// # Safety
/// The stack fits the tree.
#[target_feature(enable = "avx512f,avx512vl,avx512dq")]
#[inline]
unsafe fn walk(
    nodes: &[Node],
    interval: &Interval,
    stack: &mut Stack,
    packet: &mut Packet<'_>,
    leaves: &mut impl Leaves,
) {
    let (distances, references) = (stack.distances.as_mut_ptr(), stack.references.as_mut_ptr());
    // SAFETY: as stated; references are those of the tree's own nodes.
    unsafe {
        (*distances, *references) = (0.0, 0);
        let mut entries = 1;
        while entries > 0 {
            entries -= 1;
            if *distances.add(entries) > packet.limit {
                continue;
            }
            let reference = *references.add(entries);
            if reference & LEAF != 0 {
                leaves.visit(packet, reference & !LEAF);
                continue;
            }
            let node = nodes.get_unchecked(reference as usize);
            let pushed = interval.push(node, packet.limit, distances.add(entries), references.add(entries));
            entries += pushed as usize;
        }
    }
}
