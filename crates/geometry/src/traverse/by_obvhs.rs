//! obvhs's own traversal: its binary trees, walked by its own code, with our tests of instances and triangles at the leaves.
//!
//! The leaves are those of our trees: instances, and patches of triangles that share vertices. Why no box loses a hit, in the units of
//! [`slabs`](super::slabs): obvhs takes (plane - origin) · inverse, which is off by one unit for the difference, one for the inverse and
//! one for the product, all relative to the distance between plane and origin. A direction below 2⁻²³ counts as 2⁻²³, of one whose largest
//! coordinate was brought to between 1 and 2, which moves a point at t by two units of t. With ten units for where hits lie and one for t
//! that is sixteen; boxes are grown by [`PAD`], twenty, of the largest coordinate of a box and of the farthest origin that the tree is made
//! for. Rays that start farther out go through our trees, by the single kernel.
//!
//! A box is kept while its entry is below the ray's end, which is put one number beyond the nearest hit so far: a hit of the same t may
//! have the lower number. All of this holds for boxes around boxes, too.

use glam::{Vec3, Vec3A};
use obvhs::bvh2::Bvh2;
use obvhs::fast_stack;
use obvhs::ray::RayHit;

use super::search::Search;
use super::single::{Stacks, enter, search, test_patch};
use super::slabs::PAD;
use crate::aabb::Aabb;
use crate::hit::Hit;
use crate::ray::Ray;
use crate::scene::SceneGeometry;
use crate::shape::{Analytic, with_shape};
use crate::tree::clustered;
use crate::tree::node::{LEAF, Node};
use crate::triangle::Shear;

/// What [`Kernel::Obvhs`](super::Kernel::Obvhs) walks: obvhs's trees over the leaves of a scene's trees.
///
/// Built for the scene as it is, read by any number of threads, stale as soon as anything is added, removed or moved.
#[derive(Clone, Debug)]
pub struct ObvhsTrees {
    top: Tree,
    meshes: Vec<Tree>,
}

#[derive(Clone)]
struct Tree {
    bvh: Bvh2,
    /// Boxes are grown for rays that start no farther out than this along any axis.
    starts: f32,
}

impl std::fmt::Debug for Tree {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} nodes for rays from within {}", self.bvh.nodes.len(), self.starts)
    }
}

impl ObvhsTrees {
    /// Builds the trees for rays that start in the scene's bounds, or no farther out along any axis than `starts`.
    pub fn build(scene: &SceneGeometry<'_>, starts: f32) -> ObvhsTrees {
        let starts = scene.top.reach.max(starts);
        let mut of_meshes = vec![0.0f32; scene.mesh_trees.len()];
        for (shape, map) in scene.shapes.iter().zip(scene.world_to_object) {
            with_shape!(scene.table, *shape, _analytic => {}, mesh => {
                let (linear, translation) = map.to_f64();
                let rows = [linear.row(0), linear.row(1), linear.row(2)].map(|row| row.abs().element_sum());
                let farthest = rows.into_iter().fold(0.0, f64::max) * f64::from(starts) + translation.abs().max_element();
                of_meshes[mesh] = of_meshes[mesh].max(farthest as f32);
            });
        }
        let meshes = scene.mesh_trees.iter().zip(of_meshes);
        ObvhsTrees {
            top: Tree::build(&scene.top.nodes, scene.top.reach, starts, scene.top.slack(starts)),
            meshes: meshes.map(|(tree, starts)| Tree::build(&tree.nodes, tree.reach, starts, 0.0)).collect(),
        }
    }
}

impl Tree {
    /// Over the leaves of a tree of ours.
    fn build(nodes: &[Node], reach: f32, starts: f32, slack: f32) -> Tree {
        let pad = Vec3::splat((reach + starts) * PAD + slack);
        let places = nodes.iter().flat_map(|node| (0..node.count as usize).map(move |place| (node, place)));
        let leaves = places.filter(|(node, place)| node.children[*place] & LEAF != 0);
        let (items, boxes): (Vec<u32>, Vec<Aabb>) = leaves
            .map(|(node, place)| {
                let Aabb { min, max } = node.bounds(place);
                (node.children[place] & !LEAF, Aabb { min: min - pad, max: max + pad })
            })
            .unzip();
        let mut bvh = clustered::build(&boxes);
        bvh.max_depth = if bvh.nodes.is_empty() { 0 } else { bvh.depth(0) };
        // The boxes were shaken for the builder.
        for node in bvh.nodes.iter_mut().filter(|node| node.is_leaf()) {
            let Aabb { min, max } = boxes[bvh.primitive_indices[node.first_index as usize] as usize];
            node.set_aabb(obvhs::aabb::Aabb { min: Vec3A::from(min), max: Vec3A::from(max) });
        }
        bvh.refit_all();
        bvh.primitive_indices.iter_mut().for_each(|index| *index = items[*index as usize]);
        Tree { bvh, starts }
    }

    /// Visits the leaves that a ray meets; true if a visit says that the search is over. `None` if the tree is not made for the ray.
    #[inline(always)]
    fn walk<S: Search>(&self, ray: &Ray, search: &mut S, mut visit: impl FnMut(u32, &mut S) -> bool) -> Option<bool> {
        // A power of two brings the largest coordinate of the direction to between 1 and 2, and changes no bit of t but its exponent.
        const EXPONENTS: std::ops::RangeInclusive<u32> = 127 - 20..=127 + 20;
        let exponent = ray.direction.abs().max_element().to_bits() >> 23;
        let is_near = ray.origin.abs().max_element() <= self.starts;
        if !(is_near && EXPONENTS.contains(&exponent) && ray.direction.is_finite() && ray.origin.is_finite()) {
            return None;
        }
        let [scale, inverse] = [254 - exponent, exponent].map(|exponent| f32::from_bits(exponent << 23));
        let end = |search: &S| (search.limit() * inverse).next_up();
        let (origin, direction) = (Vec3A::from(ray.origin), Vec3A::from(ray.direction * scale));
        let scaled = obvhs::ray::Ray::new(origin, direction, 0.0, end(search));
        let mut is_over = false;
        let mut leaf = |node: &obvhs::bvh2::node::Bvh2Node, ray: &mut obvhs::ray::Ray, _: &mut RayHit| {
            is_over = visit(self.bvh.primitive_indices[node.first_index as usize], search);
            ray.tmax = end(search);
            !is_over
        };
        fast_stack!(u32, (96, 192), self.bvh.max_depth, stack, {
            self.bvh.ray_traverse_dynamic(&mut stack, scaled, &mut RayHit::none(), &mut leaf);
        });
        Some(is_over)
    }
}

/// Searches the whole scene.
#[inline(always)]
pub(crate) fn search_by_obvhs(
    scene: &SceneGeometry<'_>,
    trees: &ObvhsTrees,
    ray: &Ray,
    stacks: &mut Stacks,
    looked_for: &mut impl Search,
) {
    for &plane in scene.planes {
        if enter(scene, plane, ray, &mut stacks.mesh, looked_for, &mut ()) {
            return;
        }
    }
    let walked = trees
        .top
        .walk(ray, looked_for, |instance, looked_for| enter_by_obvhs(scene, trees, instance, ray, stacks, looked_for));
    if walked.is_none() {
        search(scene, ray, stacks, looked_for, &mut ());
    }
}

/// Searches one instance; true if the search is over.
#[inline(always)]
fn enter_by_obvhs(
    scene: &SceneGeometry<'_>,
    trees: &ObvhsTrees,
    instance: u32,
    ray: &Ray,
    stacks: &mut Stacks,
    looked_for: &mut impl Search,
) -> bool {
    let local = scene.local_ray(instance, ray);
    let shape = scene.shapes[instance as usize];
    with_shape!(scene.table, shape,
        analytic => match analytic.intersect(&local) {
            Some(hit) => {
                looked_for.offer(Hit { t: hit.t, u: hit.u, v: hit.v, instance, primitive: hit.primitive })
            }
            None => false,
        },
        mesh => {
            let (tree, shear) = (&scene.mesh_trees[mesh], Shear::new(&local));
            let walked = trees.meshes[mesh].walk(&local, looked_for, |patch, looked_for| {
                test_patch(tree, &tree.patches[patch as usize], &shear, instance, looked_for)
            });
            walked.unwrap_or_else(|| enter(scene, instance, ray, &mut stacks.mesh, looked_for, &mut ()))
        }
    )
}
