//! Trees: which part of the scene a ray may meet.
//!
//! A [`MeshTree`] stands under every mesh, a [`TopTree`] over all instances. Both are eight wide: a binary tree is built
//! first (`binned`, or obvhs's: `clustered`), `collapse` makes it wide. A tree decides what is tested, never what is hit: box tests are grown by a bound on
//! all rounding between box and hit (`traverse::slabs` has the proof), and hits are ordered.

mod binary;
mod binned;
pub(crate) mod clustered;
mod collapse;
mod mesh_tree;
pub(crate) mod node;
mod pages;
mod support;
mod top_tree;

pub use binary::TreeBuilder;
pub use mesh_tree::MeshTree;
pub use top_tree::{Instances, TopTree, TreeError};
