//! One ray after the other, in plain Rust: the kernel that the faster ones are measured and tested against.

use super::search::Search;
use super::slabs::Slabs;
use crate::hit::Hit;
use crate::ray::Ray;
use crate::scene::SceneGeometry;
use crate::shape::{Analytic, with_shape};
use crate::tree::MeshTree;
use crate::tree::node::{LEAF, Node, Patch};
use crate::triangle::Shear;

/// The memory of a traversal: a stack for each of the two levels, nearest entry last.
#[derive(Default)]
pub(crate) struct Stacks {
    top: Vec<(f32, u32)>,
    pub(super) mesh: Vec<(f32, u32)>,
}

/// What is counted on the way. `()` counts nothing and costs nothing.
pub(crate) trait Tally {
    /// Eight boxes were tested.
    fn node(&mut self);
    /// A ray was taken to an instance's space.
    fn instance(&mut self);
    /// Shapes or triangles were tested.
    fn primitives(&mut self, number: u32);
}

impl Tally for () {
    #[inline(always)]
    fn node(&mut self) {}
    #[inline(always)]
    fn instance(&mut self) {}
    #[inline(always)]
    fn primitives(&mut self, _number: u32) {}
}

/// Searches the whole scene.
#[inline(always)]
pub(crate) fn search(
    scene: &SceneGeometry<'_>,
    ray: &Ray,
    stacks: &mut Stacks,
    search: &mut impl Search,
    tally: &mut impl Tally,
) {
    for &plane in scene.planes {
        if enter(scene, plane, ray, &mut stacks.mesh, search, tally) {
            return;
        }
    }
    let start = ray.origin.abs().max_element();
    let Some(slabs) = Slabs::new(ray, scene.top.reach, scene.top.slack(start)) else { return };
    walk(&scene.top.nodes, &slabs, &mut stacks.top, search, tally, |instance, search, tally| {
        enter(scene, instance, ray, &mut stacks.mesh, search, tally)
    });
}

/// Visits the leaves of a tree that the ray meets, the nearest first; a visit says whether the search is over.
#[inline(always)]
fn walk<S: Search, T: Tally>(
    nodes: &[Node],
    slabs: &Slabs,
    stack: &mut Vec<(f32, u32)>,
    search: &mut S,
    tally: &mut T,
    mut visit: impl FnMut(u32, &mut S, &mut T) -> bool,
) -> bool {
    stack.clear();
    stack.push((0.0, 0));
    while let Some((enter, reference)) = stack.pop() {
        if enter > search.limit() {
            continue;
        }
        if reference & LEAF != 0 {
            if visit(reference & !LEAF, search, tally) {
                return true;
            }
            continue;
        }
        let node = &nodes[reference as usize];
        tally.node();
        let (enter, mut mask) = slabs.test(node, search.limit());
        let base = stack.len();
        while mask != 0 {
            let child = mask.trailing_zeros() as usize;
            mask &= mask - 1;
            let place = base + stack[base..].partition_point(|&(other, _)| other > enter[child]);
            stack.insert(place, (enter[child], node.children[child]));
        }
    }
    false
}

/// Searches one instance.
#[inline(always)]
pub(crate) fn enter_instance(
    scene: &SceneGeometry<'_>,
    instance: u32,
    ray: &Ray,
    stacks: &mut Stacks,
    search: &mut impl Search,
) {
    enter(scene, instance, ray, &mut stacks.mesh, search, &mut ());
}

/// Searches one instance; true if the search is over.
#[inline(always)]
pub(super) fn enter(
    scene: &SceneGeometry<'_>,
    instance: u32,
    ray: &Ray,
    stack: &mut Vec<(f32, u32)>,
    search: &mut impl Search,
    tally: &mut impl Tally,
) -> bool {
    tally.instance();
    let shape = scene.shapes[instance as usize];
    let local = scene.local_ray(instance, ray);
    with_shape!(scene.table, shape,
        analytic => {
            tally.primitives(1);
            match analytic.intersect(&local) {
                Some(hit) => search.offer(Hit { t: hit.t, u: hit.u, v: hit.v, instance, primitive: hit.primitive }),
                None => false,
            }
        },
        mesh => {
            let tree = &scene.mesh_trees[mesh];
            let Some(slabs) = Slabs::new(&local, tree.reach, 0.0) else { return false };
            let shear = Shear::new(&local);
            walk(&tree.nodes, &slabs, stack, search, tally, |patch, search, tally| {
                tally.primitives(tree.patches[patch as usize].triangles);
                test_patch(tree, &tree.patches[patch as usize], &shear, instance, search)
            })
        }
    )
}

/// Tries the triangles of a patch: all of them in f32, those that may be hit in f64.
#[inline(always)]
pub(super) fn test_patch(
    tree: &MeshTree,
    patch: &Patch,
    shear: &Shear,
    instance: u32,
    search: &mut impl Search,
) -> bool {
    let [kx, ky, kz] = shear.axes.map(|axis| axis as usize);
    let mut sheared = [[0.0f32; 8]; 3];
    let [x, y, z] = &mut sheared;
    for i in 0..8 {
        z[i] = patch.vertices[kz][i] - shear.origin[kz];
        x[i] = patch.vertices[kx][i] - shear.origin[kx] - shear.slope[0] * z[i];
        y[i] = patch.vertices[ky][i] - shear.origin[ky] - shear.slope[1] * z[i];
    }
    let [x, y, _] = sheared;
    for triangle in 0..patch.triangles as usize {
        let [a, b, c] = [0, 1, 2].map(|corner| patch.corners[corner][triangle] as usize & 7);
        let u = x[c] * y[b] - y[c] * x[b];
        let v = x[a] * y[c] - y[a] * x[c];
        let w = x[b] * y[a] - y[b] * x[a];
        if u.min(v).min(w) < 0.0 && u.max(v).max(w) > 0.0 {
            continue;
        }
        if let Some(hit) = shear.finish_lane(patch, triangle, &sheared) {
            let primitive = tree.primitives[patch.first as usize + triangle];
            if search.offer(Hit { t: hit.t, u: hit.u, v: hit.v, instance, primitive }) {
                return true;
            }
        }
    }
    false
}
