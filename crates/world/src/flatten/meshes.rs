//! Meshes and their trees: one of each for every mesh that some entity holds, whoever holds it first in the order of keys first.
//!
//! Meshes are the same if they are one in memory (`Arc::ptr_eq`). A tree is built when its mesh is first seen, in parallel inside,
//! and dropped when no entity holds the mesh any longer; nothing else touches it.

use std::collections::HashMap;
use std::sync::Arc;
use std::time::Instant;

use brewster_geometry::{MeshError, MeshTree, TreeBuilder, TriangleMesh};

use super::report::MeshTreeEdits;

/// Gives rows to meshes in the order in which they are asked for.
pub(super) struct MeshRows {
    /// Trees that were there and have no row yet, by the address of their mesh, which they keep alive.
    earlier: HashMap<usize, MeshTree>,
    rows: HashMap<usize, Result<u32, MeshError>>,
    trees: Vec<MeshTree>,
    builder: TreeBuilder,
    edits: MeshTreeEdits,
}

impl MeshRows {
    pub(super) fn new(earlier: Vec<MeshTree>, builder: TreeBuilder) -> MeshRows {
        let earlier = earlier.into_iter().map(|tree| (address(tree.mesh()), tree)).collect();
        MeshRows { earlier, rows: HashMap::new(), trees: Vec::new(), builder, edits: MeshTreeEdits::default() }
    }

    /// The row of a mesh; builds its tree if there is none.
    pub(super) fn row(&mut self, mesh: &Arc<TriangleMesh>) -> Result<u32, MeshError> {
        let address = address(mesh);
        if let Some(&row) = self.rows.get(&address) {
            return row;
        }
        let tree = match self.earlier.remove(&address) {
            Some(tree) => Ok(tree),
            None => self.build(mesh),
        };
        let row = tree.map(|tree| {
            self.trees.push(tree);
            (self.trees.len() - 1) as u32
        });
        self.rows.insert(address, row);
        row
    }

    fn build(&mut self, mesh: &Arc<TriangleMesh>) -> Result<MeshTree, MeshError> {
        let start = Instant::now();
        let tree = MeshTree::build(mesh.clone(), self.builder)?;
        self.edits.built += 1;
        self.edits.triangles += mesh.triangles.len();
        self.edits.time += start.elapsed();
        Ok(tree)
    }

    /// The trees in the order of their rows.
    pub(super) fn finish(self) -> (Vec<MeshTree>, MeshTreeEdits) {
        (self.trees, MeshTreeEdits { dropped: self.earlier.len(), ..self.edits })
    }
}

/// The address of a mesh, good for lookups while the mesh lives.
fn address(mesh: &Arc<TriangleMesh>) -> usize {
    Arc::as_ptr(mesh) as usize
}
