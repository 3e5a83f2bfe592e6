//! `KHR_node_visibility`: a node that is not visible hides all below it.

use gltf::json::Node;

use super::super::Found;

/// Whether a node is to be seen, as far as it says itself.
pub(in crate::gltf) fn is_visible(node: &Node, path: &str) -> Found<bool> {
    let found = super::fields(super::others!(node), "KHR_node_visibility", path)?;
    found.map_or(Ok(true), |found| found.get("visible", true))
}
