//! The tree over all instances.

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::binary::{Binary, Grouping, TreeBuilder};
use super::collapse::{collapse, nothing, validate};
use super::mesh_tree::MeshTree;
use super::node::{LEAF, Node};
use super::pages::in_large_pages;
use crate::aabb::Aabb;
use crate::motion::{Motions, reach_of_step};
use crate::shape::{Analytic, LARGEST_LENGTH, SLACK, ShapeKind, ShapeRef, ShapeTable, with_shape};
use crate::transform::{Affine, bounds_f64};

/// What a top tree is built over, borrowed.
#[derive(Clone, Copy, Debug)]
pub struct Instances<'a> {
    /// From world space to the space of each instance's shape.
    pub world_to_object: &'a [Affine],
    /// What moves, and how.
    pub motions: &'a Motions,
    /// The shape of each instance.
    pub shapes: &'a [ShapeRef],
    /// The shapes.
    pub table: &'a ShapeTable,
    /// The trees of `table.meshes`, in the same order.
    pub mesh_trees: &'a [MeshTree],
}

/// Why a top tree cannot be built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TreeError {
    /// Columns differ in length, or there are more than 2²⁸ instances.
    BadLengths,
    /// An instance names a shape that the table, or the list of mesh trees, does not have.
    NoSuchShape {
        /// The instance.
        instance: u32,
    },
    /// An instance lies beyond 10¹⁵ m, or its transform has no inverse.
    OutOfRange {
        /// The instance.
        instance: u32,
    },
}

impl std::fmt::Display for TreeError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            TreeError::BadLengths => f.write_str("columns of instances differ in length or are too long"),
            TreeError::NoSuchShape { instance } => write!(f, "instance {instance} names a shape that does not exist"),
            TreeError::OutOfRange { instance } => write!(f, "instance {instance} lies beyond 1e15 m or is flattened"),
        }
    }
}

impl std::error::Error for TreeError {}

/// References to instances need three more bits, see [`Node::parent`].
const MOST_INSTANCES: usize = 1 << 28;

/// Stands in `places` for an instance that is not in the tree.
const NOWHERE: u32 = u32::MAX;

/// A tree over the world bounds of all instances that have an end. Planes are not in it; [`Instances::planes`] lists them.
///
/// One writer builds and refits, any number of threads read. It goes stale when an instance is added, removed or given another
/// shape (build anew) or moved (refit). Memory: about 75 bytes an instance.
#[derive(Clone, Debug, PartialEq)]
pub struct TopTree {
    pub(crate) nodes: Vec<Node>,
    /// The place of each instance: `node << 3 | place`, or [`NOWHERE`].
    places: Vec<u32>,
    pub(crate) stack: usize,
    /// Largest absolute coordinate of any box since the tree was built.
    pub(crate) reach: f32,
    /// Boxes are grown for rays that start no farther out than this.
    starts: f32,
    /// The largest [`Placed::distortion`] since the tree was built.
    distortion: f32,
}

impl Default for TopTree {
    /// The tree over no instances.
    fn default() -> TopTree {
        let wide = nothing();
        TopTree { nodes: wide.nodes, places: Vec::new(), stack: wide.stack, reach: 0.0, starts: 0.0, distortion: 0.0 }
    }
}

impl Instances<'_> {
    /// The number of instances.
    pub fn len(&self) -> usize {
        self.shapes.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.shapes.is_empty()
    }

    /// The instances that are planes without end, in order: they are tested beside the tree.
    pub fn planes(&self) -> Vec<u32> {
        (0..self.len() as u32).filter(|&instance| self.shapes[instance as usize].kind == ShapeKind::Plane).collect()
    }

    fn check_lengths(&self) -> Result<(), TreeError> {
        if self.world_to_object.len() != self.shapes.len()
            || !self.motions.fits(self.len())
            || self.mesh_trees.len() != self.table.meshes.len()
            || self.len() > MOST_INSTANCES
        {
            return Err(TreeError::BadLengths);
        }
        Ok(())
    }

    /// The smallest box around an instance, in world space: empty for a mesh without area, and for a plane. An error says that
    /// no tree can be built over it.
    pub fn bounds(&self, instance: u32) -> Result<Aabb, TreeError> {
        Ok(self.place(instance)?.map_or(Aabb::EMPTY, |place| place.aabb))
    }

    /// Where an instance is; `None` for a plane, and for a mesh without area.
    fn place(&self, instance: u32) -> Result<Option<Placed>, TreeError> {
        let missing = TreeError::NoSuchShape { instance };
        let shape = *self.shapes.get(instance as usize).ok_or(missing)?;
        if shape.row as usize >= self.table.len(shape.kind) {
            return Err(missing);
        }
        let local =
            with_shape!(self.table, shape, analytic => analytic.bounds(), mesh => *self.mesh_trees[mesh].bounds());
        if shape.kind == ShapeKind::Plane || local.is_empty() {
            return Ok(None);
        }
        let bounds_after = |linear: &DMat3, translation| match shape.kind {
            ShapeKind::Mesh => self.mesh_trees[shape.row as usize].bounds_after(linear, translation),
            _ => bounds_f64(linear, translation, &local),
        };
        let out_of_range = TreeError::OutOfRange { instance };
        if let Some(keys) = self.motions.keys(instance) {
            return place_moving(keys, local.reach(), bounds_after).map(Some).ok_or(out_of_range);
        }
        let map = self.world_to_object[instance as usize];
        // The inverse in f64 of what rays are mapped by: the box stands where rays see the shape.
        let (linear, translation) = map.inverse_f64().ok_or(out_of_range)?;
        let aabb = bounds_after(&linear, translation);
        if aabb.is_empty() || aabb.reach() > LARGEST_LENGTH {
            return Err(out_of_range);
        }
        let rows = |m: glam::DMat3| [m.row(0), m.row(1), m.row(2)].map(|r| r.abs());
        let (outward, inward) = (rows(linear), rows(map.to_f64().0));
        let sum = |r: glam::DVec3| r.x + r.y + r.z;
        let stretch = outward.map(sum).into_iter().fold(0.0, f64::max);
        let both = |r: glam::DVec3| sum(inward[0] * r.x + inward[1] * r.y + inward[2] * r.z);
        let distortion = outward.map(both).into_iter().fold(0.0, f64::max);
        let fixed = stretch * local.reach() as f64 + distortion * translation.abs().max_element();
        Ok(Some(Placed { aabb, fixed: fixed as f32, distortion: distortion.min(1e20) as f32 }))
    }
}

/// The world bounds of an instance, and by how much hits may lie outside.
///
/// A ray is rounded when it is mapped to object space (one unit for its origin, one for its direction), and hits lie in the
/// object's box but for ten units ([`SLACK`]), all relative to the object's reach and the origin's distance there. A unit of
/// object space is at most `stretch` in world space. With W and M the linear parts of both maps and w the translation, the
/// origin is |M|·(|o| + |w|) away in object space, and |W|·|M| is the distortion: 1 for moves, at most 3 with rotations.
struct Placed {
    aabb: Aabb,
    /// What does not depend on the ray: stretch·reach + distortion·|w|.
    fixed: f32,
    distortion: f32,
}

/// Where an instance is that moves: a box for all the shutter's time. None if it lies too far out.
///
/// Rays see its shape through an inverse that is rounded anew for each of them. As its map W(s) is off by a unit in three, and the
/// inverse M by half a unit of |M|, hits are off by half a unit of |W|·|M|·(|p| + |w|) and three of |W|·|q| + |w| more; ten units
/// and three were counted already, and half as many more are added.
fn place_moving(keys: &[Affine], reach: f32, bounds_after: impl Fn(&DMat3, DVec3) -> Aabb) -> Option<Placed> {
    let mut placed = Placed { aabb: Aabb::EMPTY, fixed: 0.0, distortion: 0.0 };
    let (mut stretch, mut distortion, mut farthest) = (0.0f64, 0.0f64, 0.0f64);
    for (at, key) in keys.iter().enumerate() {
        let (linear, translation) = key.to_f64();
        placed.aabb = placed.aabb.union(&bounds_after(&linear, translation));
        farthest = farthest.max(translation.abs().max_element());
        if let Some(next) = keys.get(at + 1) {
            let [outward, inward] = reach_of_step(key, next);
            let sum = |matrix: DMat3| (matrix * DVec3::ONE).max_element();
            (stretch, distortion) = (stretch.max(sum(outward)), distortion.max(sum(outward * inward)));
        }
    }
    farthest = farthest.max(f64::from(placed.aabb.reach()));
    placed.fixed = (1.5 * (stretch * f64::from(reach) + distortion * farthest)) as f32;
    placed.distortion = (1.5 * distortion).min(1e20) as f32;
    (!placed.aabb.is_empty() && placed.aabb.reach() <= LARGEST_LENGTH).then_some(placed)
}

/// [`SLACK`], two units for mapping the ray, one for arithmetic.
const INSTANCE_SLACK: f32 = SLACK as f32 * 1.3;

impl Placed {
    fn padded(&self, starts: f32) -> Aabb {
        // A map that all but flattens space may ask for more than there is; areas must not overflow.
        let pad = INSTANCE_SLACK * (self.fixed + self.distortion * starts);
        self.aabb.padded(pad.min(1e3 * LARGEST_LENGTH))
    }
}

impl TopTree {
    /// Builds a tree. The result does not depend on the number of threads.
    pub fn build(instances: &Instances<'_>, builder: TreeBuilder) -> Result<TopTree, TreeError> {
        instances.check_lengths()?;
        let all: Vec<Result<Option<Placed>, TreeError>> =
            (0..instances.len() as u32).into_par_iter().map(|instance| instances.place(instance)).collect();
        let (mut items, mut placed) = (Vec::with_capacity(all.len()), Vec::with_capacity(all.len()));
        for (instance, place) in (0..).zip(all) {
            if let Some(place) = place? {
                items.push(instance);
                placed.push(place);
            }
        }
        let starts = placed.iter().fold(0.0, |reach: f32, place| reach.max(place.aabb.reach()));
        let distortion = placed.iter().fold(0.0, |most: f32, place| most.max(place.distortion));
        let boxes: Vec<Aabb> = placed.iter().map(|place| place.padded(starts)).collect();
        let reach = boxes.iter().fold(0.0, |reach: f32, aabb| reach.max(aabb.reach()));
        let mut wide = match &*boxes {
            [] => nothing(),
            boxes => collapse(Binary::build(builder, &Grouping { boxes, fits: |_: &[u32]| false, most: 1 })),
        };
        let mut places = vec![NOWHERE; instances.len()];
        for (index, node) in wide.nodes.iter_mut().enumerate() {
            for (place, child) in node.children[..node.count as usize].iter_mut().enumerate() {
                if *child & LEAF != 0 {
                    let leaf = wide.leaves[(*child & !LEAF) as usize];
                    let instance = items[wide.items[leaf.first as usize] as usize];
                    *child = LEAF | instance;
                    places[instance as usize] = (index << 3 | place) as u32;
                }
            }
        }
        Ok(TopTree { nodes: in_large_pages(wide.nodes), places, stack: wide.stack, reach, starts, distortion })
    }

    /// Adapts the boxes to instances that moved. Costs the depth of the tree for each; boxes may overlap more than those of a
    /// new tree, hits are the same.
    ///
    /// The instances are as many and have the same shapes as when the tree was built. An error leaves the tree as it was.
    pub fn refit(&mut self, instances: &Instances<'_>, moved: &[u32]) -> Result<(), TreeError> {
        instances.check_lengths()?;
        if self.places.len() != instances.len() {
            return Err(TreeError::BadLengths);
        }
        let placed = moved.iter().map(|&instance| instances.place(instance)).collect::<Result<Vec<_>, TreeError>>()?;
        for (&instance, place) in moved.iter().zip(&placed) {
            let at = self.places[instance as usize];
            let (Some(place), true) = (place, at != NOWHERE) else { continue };
            let aabb = place.padded(self.starts);
            self.reach = self.reach.max(aabb.reach());
            self.distortion = self.distortion.max(place.distortion);
            self.set_bounds(at, &aabb);
        }
        Ok(())
    }

    /// Gives a place another box, and its ancestors those that follow.
    fn set_bounds(&mut self, mut at: u32, aabb: &Aabb) {
        let mut aabb = *aabb;
        loop {
            let (node, place) = (at as usize >> 3, at as usize & 7);
            self.nodes[node].set_bounds(place, &aabb);
            if node == 0 {
                return;
            }
            aabb = self.nodes[node].union();
            at = self.nodes[node].parent;
        }
    }

    /// Half the area of all boxes: rays meet boxes in proportion to it, so it tells what refits have cost. Looks at every node.
    pub fn half_area(&self) -> f32 {
        let area = |node: &Node| (0..node.count as usize).map(|place| node.bounds(place).half_area()).sum::<f32>();
        self.nodes.iter().map(area).sum()
    }

    /// The box around all instances that have an end, and a little more.
    pub fn bounds(&self) -> Aabb {
        self.nodes[0].union()
    }

    /// The number of instances it was built over, planes included.
    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// Whether it was built over no instances.
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// Memory of the tree.
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.nodes) + size_of_val(&*self.places)
    }

    /// The box of an instance that is in the tree.
    #[inline(always)]
    pub(crate) fn box_of(&self, instance: u32) -> Aabb {
        let at = self.places[instance as usize] as usize;
        self.nodes[at >> 3].bounds(at & 7)
    }

    /// The instance, if there is one alone.
    pub(crate) fn only_instance(&self) -> Option<u32> {
        let root = &self.nodes[0];
        (root.count == 1 && root.children[0] & LEAF != 0).then_some(root.children[0] & !LEAF)
    }

    /// By how much box tests have to be generous to a ray that starts there, beyond what [`Placed::padded`] does.
    #[inline(always)]
    pub(crate) fn slack(&self, start: f32) -> f32 {
        INSTANCE_SLACK * self.distortion * (start - self.starts).max(0.0)
    }

    /// Checks what the tree promises: every instance with an end is in it once, every box holds what is in it.
    pub fn validate(&self, instances: &Instances<'_>) -> Result<(), String> {
        instances.check_lengths().map_err(|error| error.to_string())?;
        validate(&self.nodes, self.stack)?;
        if self.places.len() != instances.len() {
            return Err(format!("{} instances in a tree over {}", instances.len(), self.places.len()));
        }
        let mut leaves = 0;
        for node in &self.nodes {
            leaves += node.children[..node.count as usize].iter().filter(|&child| child & LEAF != 0).count();
        }
        for (instance, &at) in self.places.iter().enumerate() {
            let placed = instances.place(instance as u32).map_err(|error| error.to_string())?;
            let Some(placed) = placed else { continue };
            let (node, place) = (at as usize >> 3, at as usize & 7);
            let Some(node) = self.nodes.get(node).filter(|node| node.children[place] == LEAF | instance as u32) else {
                return Err(format!("instance {instance} is not where it should be"));
            };
            if !node.bounds(place).contains(&placed.padded(self.starts)) {
                return Err(format!("instance {instance} is outside its box"));
            }
            leaves -= 1;
        }
        if leaves == 0 { Ok(()) } else { Err(format!("{leaves} leaves too many")) }
    }
}
