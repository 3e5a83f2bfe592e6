//! Trees: which part of the scene a ray may meet.
//!
//! A [`MeshTree`] stands under every mesh, a [`TopTree`] over all instances. Both are eight wide: obvhs builds a binary tree
//! (`binary`), `collapse` makes it wide. A tree decides what is tested, never what is hit: box tests are grown by a bound on
//! all rounding between box and hit (`traverse::slabs` has the proof), and hits are ordered.

mod binary;
mod collapse;
mod mesh_tree;
pub(crate) mod node;
mod pages;
mod top_tree;

pub use mesh_tree::MeshTree;
pub use top_tree::{Instances, TopTree, TreeError};
