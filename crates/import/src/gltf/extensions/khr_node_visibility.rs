//! `KHR_node_visibility`: a node that is not visible hides all below it.

use gltf::json::Node;
use serde::Deserialize;

use super::super::Found;

#[derive(Deserialize)]
struct Visibility {
    #[serde(default = "yes")]
    visible: bool,
}

fn yes() -> bool {
    true
}

/// Whether a node is to be seen, as far as it says itself.
pub(in crate::gltf) fn is_visible(node: &Node, path: &str) -> Found<bool> {
    let found = super::read::<Visibility>(super::others!(node), "KHR_node_visibility", path)?;
    Ok(found.is_none_or(|found| found.visible))
}
