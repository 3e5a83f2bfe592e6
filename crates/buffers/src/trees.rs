//! How rays find instances and triangles.

use brewster_geometry::{MeshTree, TopTree};

/// One bottom-level tree per mesh, one top level over all instances that have an end, and a list of those without.
#[derive(Clone, Debug, Default)]
pub struct Trees {
    /// In the order of the shape table's meshes.
    pub meshes: Vec<MeshTree>,
    /// Over the world bounds of all instances but planes.
    pub top: TopTree,
    /// Instances that are planes without end, in order.
    pub planes: Vec<u32>,
}
