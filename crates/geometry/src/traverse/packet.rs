//! Sixteen coherent rays walked together: what camera rays are.
//!
//! A node is tested once for all of them, against the interval of their origins and inverse directions; a patch triangle by
//! triangle, against sixteen rays at once. That pays while the rays go the same way: they must agree in the signs of their
//! direction and in its largest axis. Groups that do not are left to the wave. What a ray meets is decided by the same routine
//! as everywhere; a packet only visits more boxes than the ray alone would.
//!
//! Against the wave, camera rays of a 512² picture (`benches/traversal.rs`): 1.2 times the rays per second on a mesh of 1.3
//! million triangles, 1.6 on 100,000 spheres, but 0.6 on 2,000 rocks of a few pixels each, where a packet is mostly air. So a
//! batch counts how full its packets are when they enter meshes, and goes on without them if that is too little.
#![expect(unsafe_code, reason = "intrinsics need an instruction set, which the caller proves")]

use std::arch::x86_64::*;

use super::eight::{keys, store_ordered};
use super::search::Nearest;
use super::single;
use super::slabs::{PAD, Slabs};
use super::wave::Task;
use crate::aabb::Aabb;
use crate::hit::Hit;
use crate::ray::{Ray, Rays};
use crate::scene::SceneGeometry;
use crate::shape::ShapeKind;
use crate::tree::MeshTree;
use crate::tree::node::{LEAF, Node, Patch};
use crate::triangle::Shear;

/// Rays in a packet.
const WIDTH: usize = 16;

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
///
/// # Safety
/// The machine has AVX-512 F and VL, AVX2 and FMA.
#[inline(always)]
pub(super) unsafe fn trace<T: Task>(
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
    for first in (0..rays.len()).step_by(WIDTH) {
        let last = rays.len().min(first + WIDTH);
        if last - first < WIDTH || !memory.filling.is_worth_it() || !is_coherent(rays.direction, first) {
            rest.extend(first as u32..last as u32);
            continue;
        }
        let world: [Ray; WIDTH] = std::array::from_fn(|lane| rays.get(first + lane));
        let start = world.iter().fold(0.0f32, |most, ray| most.max(ray.origin.abs().max_element()));
        let Some(interval) = Interval::new(&world, scene.top.reach, scene.top.slack(start)) else {
            rest.extend(first as u32..last as u32);
            continue;
        };
        let mut packet = Packet::new(scene, world, &interval);
        // SAFETY: the caller has the instruction set.
        unsafe { packet.run(&interval, memory) };
        for (lane, hit) in packet.hits.iter().enumerate() {
            task.finish(first + lane, hit);
        }
    }
}

/// Whether sixteen directions agree in their signs and their largest axis.
#[inline(always)]
fn is_coherent(direction: [&[f32]; 3], first: usize) -> bool {
    let column =
        |axis: usize| -> &[f32; WIDTH] { direction[axis][first..first + WIDTH].try_into().expect("sixteen rays") };
    let (x, y, z) = (column(0), column(1), column(2));
    let (mut all, mut any) = ([!0u32; 3], [0u32; 3]);
    let (mut along_x, mut along_y, mut along_z) = (0, 0, 0);
    for lane in 0..WIDTH {
        for (axis, column) in [x, y, z].into_iter().enumerate() {
            all[axis] &= column[lane].to_bits();
            any[axis] |= column[lane].to_bits();
        }
        // As `Shear::new` chooses.
        let (x, y, z) = (x[lane].abs(), y[lane].abs(), z[lane].abs());
        let is_z = z >= x && z >= y;
        along_z += is_z as usize;
        along_y += (!is_z && y > x) as usize;
        along_x += (!is_z && y <= x) as usize;
    }
    let same_sign = (0..3).all(|axis| (all[axis] ^ any[axis]) >> 31 == 0);
    same_sign && along_x.max(along_y).max(along_z) == WIDTH
}

/// A packet for the boxes of one tree: bounds of all its rays.
struct Interval {
    /// The least and the greatest inverse direction.
    inverse: [[f32; 3]; 2],
    /// The origin, with its pad, that brings near planes nearest, and the one that brings far planes farthest.
    near: [f32; 3],
    far: [f32; 3],
    /// By how much boxes are grown.
    pad: f32,
    near_plane: [u32; 3],
}

impl Interval {
    /// The bounds in `slabs` hold for every ray; the difference to a plane is taken before it is multiplied, which saves one of
    /// its units. `None` if a ray is not usable.
    #[inline(always)]
    fn new(rays: &[Ray; WIDTH], reach: f32, slack: f32) -> Option<Interval> {
        let (mut low, mut high) = (rays[0].origin, rays[0].origin);
        let (mut least, mut most) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        let mut usable = true;
        let mut near_plane = [0; 3];
        for ray in rays {
            let slabs = Slabs::new(ray, reach, slack);
            usable &= slabs.is_usable();
            (low, high) = (low.min(ray.origin), high.max(ray.origin));
            for axis in 0..3 {
                least[axis] = least[axis].min(slabs.inverse[axis]);
                most[axis] = most[axis].max(slabs.inverse[axis]);
            }
            near_plane = slabs.near_plane;
        }
        let pad = low.abs().max(high.abs()).max_element() * PAD + (reach * PAD + slack);
        let (low, high) = (low - pad, high + pad);
        let pick = |first: glam::Vec3, second: glam::Vec3| -> [f32; 3] {
            std::array::from_fn(|axis| if near_plane[axis] & 1 == 0 { first[axis] } else { second[axis] })
        };
        usable.then(|| Interval {
            inverse: [least, most],
            near: pick(high, low),
            far: pick(low, high),
            pad,
            near_plane,
        })
    }

    /// Pushes the children of a node that any of the rays may meet before `limit`, and returns their number.
    ///
    /// # Safety
    /// The machine has AVX-512 F and VL, AVX2 and FMA; both stacks have room for eight entries.
    #[inline(always)]
    unsafe fn push(&self, node: &Node, limit: f32, distances: *mut f32, references: *mut u32) -> u32 {
        // SAFETY: as stated; nodes are aligned and have eight lanes, columns of planes are below six.
        unsafe {
            let (mut enter, mut leave) = (_mm256_setzero_ps(), _mm256_set1_ps(limit));
            for axis in 0..3 {
                let column = self.near_plane[axis] as usize;
                let near = _mm256_load_ps(node.planes.get_unchecked(column).as_ptr());
                let far = _mm256_load_ps(node.planes.get_unchecked(column ^ 1).as_ptr());
                let (least, most) = (_mm256_set1_ps(self.inverse[0][axis]), _mm256_set1_ps(self.inverse[1][axis]));
                let near = _mm256_sub_ps(near, _mm256_set1_ps(self.near[axis]));
                let far = _mm256_sub_ps(far, _mm256_set1_ps(self.far[axis]));
                enter = _mm256_max_ps(_mm256_min_ps(_mm256_mul_ps(near, least), _mm256_mul_ps(near, most)), enter);
                leave = _mm256_min_ps(_mm256_max_ps(_mm256_mul_ps(far, least), _mm256_mul_ps(far, most)), leave);
            }
            let met = _mm256_cmp_ps_mask::<_CMP_LE_OQ>(enter, leave);
            let keys = _mm256_mask_compress_epi32(_mm256_set1_epi32(-1), met, keys(enter));
            let children = _mm256_load_si256(node.children.as_ptr().cast());
            store_ordered(keys, met.count_ones(), children, distances, references);
            met.count_ones()
        }
    }
}

/// Sixteen rays on their way.
struct Packet<'a> {
    scene: &'a SceneGeometry<'a>,
    world: [Ray; WIDTH],
    /// Origins and inverse directions of the world's rays, by columns, and by how much boxes are grown for them.
    origin: [[f32; WIDTH]; 3],
    inverse: [[f32; WIDTH]; 3],
    pad: f32,
    hits: [Hit; WIDTH],
    /// The farthest of the rays' nearest hits.
    limit: f32,
}

impl<'a> Packet<'a> {
    #[inline(always)]
    fn new(scene: &'a SceneGeometry<'a>, world: [Ray; WIDTH], interval: &Interval) -> Packet<'a> {
        let (mut origin, mut inverse) = ([[0.0; WIDTH]; 3], [[0.0; WIDTH]; 3]);
        for (lane, ray) in world.iter().enumerate() {
            let slabs = Slabs::new(ray, 0.0, 0.0);
            for axis in 0..3 {
                origin[axis][lane] = ray.origin[axis];
                inverse[axis][lane] = slabs.inverse[axis];
            }
        }
        let hits = [Hit::miss(); WIDTH];
        Packet { scene, world, origin, inverse, pad: interval.pad, hits, limit: f32::INFINITY }
    }

    /// A bit for every ray that meets a box before its nearest hit.
    ///
    /// # Safety
    /// The machine has AVX-512 F.
    #[inline(always)]
    unsafe fn meets(&self, aabb: &Aabb) -> u16 {
        // SAFETY: as stated; columns have sixteen lanes.
        unsafe {
            let t: [f32; WIDTH] = std::array::from_fn(|lane| self.hits[lane].t);
            let (mut enter, mut leave) = (_mm512_setzero_ps(), _mm512_loadu_ps(t.as_ptr()));
            for axis in 0..3 {
                let (origin, inverse) = (self.origin[axis].as_ptr(), self.inverse[axis].as_ptr());
                let (origin, inverse) = (_mm512_loadu_ps(origin), _mm512_loadu_ps(inverse));
                let low = _mm512_sub_ps(_mm512_set1_ps(aabb.min[axis] - self.pad), origin);
                let high = _mm512_sub_ps(_mm512_set1_ps(aabb.max[axis] + self.pad), origin);
                let (low, high) = (_mm512_mul_ps(low, inverse), _mm512_mul_ps(high, inverse));
                enter = _mm512_max_ps(enter, _mm512_min_ps(low, high));
                leave = _mm512_min_ps(leave, _mm512_max_ps(low, high));
            }
            _mm512_cmp_ps_mask::<_CMP_LE_OQ>(enter, leave)
        }
    }

    /// # Safety
    /// The machine has AVX-512 F and VL, AVX2 and FMA; the stacks fit the scene's trees.
    #[inline(always)]
    unsafe fn run(&mut self, interval: &Interval, memory: &mut Memory) {
        let scene = self.scene;
        for &plane in scene.planes {
            self.enter_alone(plane, u16::MAX, &mut memory.single);
        }
        self.update();
        let mut instances =
            Instances { mesh: &mut memory.mesh, single: &mut memory.single, filling: &mut memory.filling };
        // SAFETY: as stated.
        unsafe { walk(&scene.top.nodes, interval, &mut memory.top, self, &mut instances) };
    }

    /// Meets an instance: ray by ray, or all together in its mesh's tree.
    ///
    /// # Safety
    /// As [`Packet::run`].
    #[inline(always)]
    unsafe fn enter(&mut self, instance: u32, context: &mut Instances<'_>) {
        let Instances { mesh: stack, single, filling } = context;
        // SAFETY: as stated.
        let lanes = unsafe { self.meets(&self.scene.top.box_of(instance)) };
        let shape = self.scene.shapes[instance as usize];
        if shape.kind == ShapeKind::Mesh {
            filling.packets += 1;
            filling.rays += lanes.count_ones() as usize;
        }
        if shape.kind != ShapeKind::Mesh || lanes.count_ones() < FEW {
            self.enter_alone(instance, lanes, single);
            self.update();
            return;
        }
        let tree = &self.scene.mesh_trees[shape.row as usize];
        let map = &self.scene.world_to_object[instance as usize];
        let local: [Ray; WIDTH] = std::array::from_fn(|lane| map.ray(&self.world[lane]));
        let shears: [Shear; WIDTH] = std::array::from_fn(|lane| Shear::new(&local[lane]));
        let signs = |ray: &Ray| ray.direction.to_array().map(f32::is_sign_negative);
        let together =
            (1..WIDTH).all(|lane| shears[lane].axes == shears[0].axes && signs(&local[lane]) == signs(&local[0]));
        let interval = Interval::new(&local, tree.reach, 0.0).filter(|_| together);
        let Some(interval) = interval else {
            self.enter_alone(instance, lanes, single);
            self.update();
            return;
        };
        let columns = Columns::new(&shears);
        let mut patches = Patches { tree, shears: &shears, columns: &columns, instance };
        // SAFETY: as stated.
        unsafe { walk(&tree.nodes, &interval, stack, self, &mut patches) };
    }

    /// Meets an instance ray by ray.
    #[inline(always)]
    fn enter_alone(&mut self, instance: u32, mut lanes: u16, single: &mut single::Stacks) {
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize;
            lanes &= lanes - 1;
            let mut nearest = Nearest(self.hits[lane]);
            single::enter_instance(self.scene, instance, &self.world[lane], single, &mut nearest);
            self.hits[lane] = nearest.0;
        }
    }

    fn update(&mut self) {
        self.limit = self.hits.iter().fold(0.0, |most, hit| most.max(hit.t));
    }

    /// Tests the triangles of a patch against all rays: in f32, and those that may be hit in f64.
    ///
    /// # Safety
    /// The machine has AVX-512 F.
    #[inline(always)]
    unsafe fn test_patch(&mut self, patch: &Patch, context: &Patches<'_>) {
        let Patches { tree, shears, columns, instance } = *context;
        let [kx, ky, kz] = [0, 1, 2].map(|i| shears[0].axes[i] as usize);
        let mut changed = false;
        // SAFETY: as stated; the arrays have sixteen lanes and are aligned to 64 bytes.
        unsafe {
            let load = |column: &[f32; WIDTH]| _mm512_loadu_ps(column.as_ptr());
            let zero = _mm512_setzero_ps();
            let mut sheared = [[zero; 3]; 8];
            let (slope_x, slope_y) = (load(&columns.slope[0]), load(&columns.slope[1]));
            let [ox, oy, oz] = [load(&columns.origin[0]), load(&columns.origin[1]), load(&columns.origin[2])];
            for (vertex, sheared) in sheared.iter_mut().enumerate() {
                let z = _mm512_sub_ps(_mm512_set1_ps(patch.vertices[kz][vertex]), oz);
                let x = _mm512_sub_ps(_mm512_set1_ps(patch.vertices[kx][vertex]), ox);
                let y = _mm512_sub_ps(_mm512_set1_ps(patch.vertices[ky][vertex]), oy);
                let (x, y) = (_mm512_sub_ps(x, _mm512_mul_ps(slope_x, z)), _mm512_sub_ps(y, _mm512_mul_ps(slope_y, z)));
                *sheared = [x, y, z];
            }
            for triangle in 0..patch.triangles as usize & 15 {
                let corner = |i: usize| &sheared[patch.corners[i][triangle & 7] as usize & 7];
                let (a, b, c) = (corner(0), corner(1), corner(2));
                let u = _mm512_sub_ps(_mm512_mul_ps(c[0], b[1]), _mm512_mul_ps(c[1], b[0]));
                let v = _mm512_sub_ps(_mm512_mul_ps(a[0], c[1]), _mm512_mul_ps(a[1], c[0]));
                let w = _mm512_sub_ps(_mm512_mul_ps(b[0], a[1]), _mm512_mul_ps(b[1], a[0]));
                let least = _mm512_min_ps(_mm512_min_ps(u, v), w);
                let most = _mm512_max_ps(_mm512_max_ps(u, v), w);
                let mut mask =
                    _mm512_cmp_ps_mask::<_CMP_GE_OQ>(least, zero) | _mm512_cmp_ps_mask::<_CMP_LE_OQ>(most, zero);
                while mask != 0 {
                    let lane = mask.trailing_zeros() as usize;
                    mask &= mask - 1;
                    let at = |corner: &[__m512; 3], axis: usize| {
                        (*(&raw const corner[axis]).cast::<[f32; WIDTH]>())[lane] as f64
                    };
                    let corners = [a, b, c];
                    let point = |i: usize| [at(corners[i], 0), at(corners[i], 1), at(corners[i], 2)];
                    let as_they_are = || [0, 1, 2].map(|corner| patch.corner(triangle, corner));
                    let Some(hit) = shears[lane].finish([point(0), point(1), point(2)], as_they_are) else { continue };
                    let primitive = tree.primitives[patch.first as usize + triangle];
                    let hit = Hit { t: hit.t, u: hit.u, v: hit.v, instance, primitive };
                    if hit.precedes(&self.hits[lane]) {
                        self.hits[lane] = hit;
                        changed = true;
                    }
                }
            }
        }
        if changed {
            self.update();
        }
    }
}

/// What shearing needs of sixteen rays, by columns: origins in the order of the axes, and slopes.
struct Columns {
    origin: [[f32; WIDTH]; 3],
    slope: [[f32; WIDTH]; 2],
}

impl Columns {
    #[inline(always)]
    fn new(shears: &[Shear; WIDTH]) -> Columns {
        let mut columns = Columns { origin: [[0.0; WIDTH]; 3], slope: [[0.0; WIDTH]; 2] };
        for (lane, shear) in shears.iter().enumerate() {
            for axis in 0..3 {
                columns.origin[axis][lane] = shear.origin[shears[0].axes[axis] as usize % 3];
            }
            columns.slope[0][lane] = shear.slope[0];
            columns.slope[1][lane] = shear.slope[1];
        }
        columns
    }
}

/// What a packet meets at the leaves of a tree. (A closure would not be compiled for the instruction set.)
trait Leaves {
    /// # Safety
    /// As [`Packet::run`].
    unsafe fn visit(&mut self, packet: &mut Packet<'_>, leaf: u32);
}

/// The leaves of the top tree.
struct Instances<'m> {
    mesh: &'m mut Stack,
    single: &'m mut single::Stacks,
    filling: &'m mut Filling,
}

impl Leaves for Instances<'_> {
    #[inline(always)]
    unsafe fn visit(&mut self, packet: &mut Packet<'_>, leaf: u32) {
        // SAFETY: as stated.
        unsafe { packet.enter(leaf, self) }
    }
}

/// The leaves of a mesh's tree.
struct Patches<'m> {
    tree: &'m MeshTree,
    shears: &'m [Shear; WIDTH],
    columns: &'m Columns,
    instance: u32,
}

impl Leaves for Patches<'_> {
    #[inline(always)]
    unsafe fn visit(&mut self, packet: &mut Packet<'_>, leaf: u32) {
        // SAFETY: as stated.
        unsafe { packet.test_patch(&self.tree.patches[leaf as usize], self) }
    }
}

/// Visits the leaves of a tree that a packet may meet, the nearest first.
///
/// # Safety
/// The machine has AVX-512 F and VL, AVX2 and FMA; the stack fits the tree.
#[inline(always)]
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
