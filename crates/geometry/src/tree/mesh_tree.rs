//! The tree under a mesh.

use std::sync::Arc;

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::binary::{Binary, Grouping, Leaf, TreeBuilder};
use super::collapse::{collapse, nothing, validate};
use super::node::{LEAF, Node, Patch};
use super::pages::in_large_pages;
use super::support::Support;
use crate::aabb::Aabb;
use crate::mesh::{MeshError, TriangleMesh};

/// A tree over the triangles of one mesh, shared by all its instances.
///
/// Built once, read by any number of threads, stale as soon as the mesh changes: then it is built anew. Degenerate triangles
/// are left out. Memory: about 42 bytes a triangle on ordinary meshes ([`MeshTree::bytes`]), at most 200 where no two
/// triangles share a vertex; the mesh itself is not copied.
#[derive(Clone, Debug)]
pub struct MeshTree {
    mesh: Arc<TriangleMesh>,
    pub(crate) nodes: Vec<Node>,
    pub(crate) patches: Vec<Patch>,
    /// The mesh's triangle for each triangle of the patches.
    pub(crate) primitives: Vec<u32>,
    bounds: Aabb,
    support: Support,
    /// Largest absolute coordinate.
    pub(crate) reach: f32,
    pub(crate) stack: usize,
}

impl MeshTree {
    /// Builds the tree; the mesh is checked first. The result does not depend on the number of threads.
    ///
    /// While it builds it takes about 150 bytes a triangle.
    pub fn build(mesh: Arc<TriangleMesh>, builder: TreeBuilder) -> Result<MeshTree, MeshError> {
        mesh.validate()?;
        let triangles: Vec<u32> = (0..mesh.triangles.len() as u32)
            .into_par_iter()
            .filter(|&triangle| !mesh.is_degenerate(triangle as usize))
            .collect();
        let boxes: Vec<Aabb> =
            triangles.par_iter().map(|&triangle| Aabb::around(mesh.corners(triangle as usize))).collect();
        let corners = |&item: &u32| mesh.corners(triangles[item as usize] as usize);
        let pack = |items: &[u32]| Patch::pack(items.iter().map(corners));
        let fits = |items: &[u32]| pack(items).is_some();
        let wide = match &*boxes {
            [] => nothing(),
            boxes => collapse(Binary::build(builder, &Grouping { boxes, fits, most: 8 })),
        };
        let patch = |leaf: &Leaf| Patch { first: leaf.first, ..pack(wide.items_of(leaf)).expect("a leaf's items fit") };
        let patches = wide.leaves.par_iter().map(patch).collect();
        let primitives = wide.items.iter().map(|&item| triangles[item as usize]).collect();
        let bounds = wide.nodes[0].union();
        let support = Support::new(&wide.nodes);
        let (nodes, patches) = (in_large_pages(wide.nodes), in_large_pages(patches));
        Ok(MeshTree { mesh, nodes, patches, primitives, bounds, support, reach: bounds.reach(), stack: wide.stack })
    }

    /// The mesh.
    pub fn mesh(&self) -> &Arc<TriangleMesh> {
        &self.mesh
    }

    /// The box around all triangles that have an area.
    pub fn bounds(&self) -> &Aabb {
        &self.bounds
    }

    /// A box around all triangles after a map. Where the map turns it is smaller than the mapped [`MeshTree::bounds`], see [`Support`].
    pub(crate) fn bounds_after(&self, linear: &DMat3, translation: DVec3) -> Aabb {
        let rows = [linear.row(0), linear.row(1), linear.row(2)];
        let (low, high) = (rows.map(|row| -self.support.along(-row)), rows.map(|row| self.support.along(row)));
        Aabb::outward(DVec3::from_array(low) + translation, DVec3::from_array(high) + translation)
    }

    /// Memory of the tree, without the mesh.
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.nodes) + size_of_val(&*self.patches) + size_of_val(&*self.primitives)
    }

    /// Checks what the tree promises: every triangle with an area is in exactly one patch, every box holds what is in it.
    pub fn validate(&self) -> Result<(), String> {
        validate(&self.nodes, self.stack)?;
        let mut seen = vec![false; self.mesh.triangles.len()];
        for node in &self.nodes {
            for place in 0..node.count as usize {
                let child = node.children[place];
                if child & LEAF == 0 {
                    continue;
                }
                let Some(patch) = self.patches.get((child & !LEAF) as usize) else {
                    return Err(format!("patch {} does not exist", child & !LEAF));
                };
                for triangle in 0..patch.triangles as usize {
                    let primitive = self.primitives[patch.first as usize + triangle] as usize;
                    let corners = [0, 1, 2].map(|corner| patch.corner(triangle, corner));
                    if corners != self.mesh.corners(primitive) {
                        return Err(format!("triangle {primitive} has other corners in its patch"));
                    }
                    if !node.bounds(place).contains(&Aabb::around(corners)) {
                        return Err(format!("triangle {primitive} is outside its box"));
                    }
                    if std::mem::replace(&mut seen[primitive], true) {
                        return Err(format!("triangle {primitive} is in two patches"));
                    }
                }
            }
        }
        match (0..seen.len()).find(|&triangle| !seen[triangle] && !self.mesh.is_degenerate(triangle)) {
            Some(triangle) => Err(format!("triangle {triangle} is in no patch")),
            None => Ok(()),
        }
    }
}

/// Two trees are equal if they were built the same way over equal meshes.
impl PartialEq for MeshTree {
    fn eq(&self, other: &MeshTree) -> bool {
        self.nodes == other.nodes
            && self.patches == other.patches
            && self.primitives == other.primitives
            && (Arc::ptr_eq(&self.mesh, &other.mesh) || self.mesh == other.mesh)
    }
}
