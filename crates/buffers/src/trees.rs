//! How rays find instances and triangles.

use std::sync::Arc;

use brewster_geometry::{MeshTree, ObvhsTrees, TopTree};

/// One bottom-level tree per mesh, one top level over all instances that have an end, and a list of those without.
#[derive(Clone, Debug, Default)]
pub struct Trees {
    /// In the order of the shape table's meshes.
    pub meshes: Vec<MeshTree>,
    /// Over the world bounds of all instances but planes.
    pub top: TopTree,
    /// Instances that are planes without end, in order.
    pub planes: Vec<u32>,
    /// obvhs's trees over the same leaves, for those who compare traversals. Flattening makes none.
    pub obvhs: Option<Arc<ObvhsTrees>>,
}
