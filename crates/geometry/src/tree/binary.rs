//! Binary trees: what builders make and `collapse` makes wide.

use super::node::LEAF;
use crate::aabb::Aabb;

/// How trees are built. Any tree finds the same hits; what differs is the time to build it and to find them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum TreeBuilder {
    /// From the top down, by the surfaces of bins.
    #[default]
    Binned,
    /// From the bottom up, by obvhs: clustering and reinsertion. Takes twice the time, and rays 0 to 15 % more.
    Clustered,
}

/// Boxes of items, and which items may share a leaf.
pub(crate) struct Grouping<'a, F> {
    /// The items' boxes, finite, at least one.
    pub(crate) boxes: &'a [Aabb],
    /// Whether these, two or more, may share a leaf.
    pub(crate) fits: F,
    /// The most that may, at most 8.
    pub(crate) most: usize,
}

/// A binary tree over items that are known by their boxes. Children come after their parents.
#[derive(Debug)]
pub(crate) struct Binary {
    /// The inner nodes.
    pub(crate) nodes: Vec<BinaryNode>,
    /// The leaves.
    pub(crate) leaves: Vec<Leaf>,
    /// The items, leaf by leaf.
    pub(crate) items: Vec<u32>,
    /// The root: a node, or `LEAF |` a leaf.
    pub(crate) root: u32,
}

/// An inner node.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BinaryNode {
    pub(crate) half_area: f32,
    /// Nodes, or `LEAF |` leaves.
    pub(crate) children: [u32; 2],
}

/// Items that stay together.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Leaf {
    pub(crate) bounds: Aabb,
    /// Where its items begin.
    pub(crate) first: u32,
    pub(crate) count: u32,
}

impl Binary {
    /// Builds a tree. The result does not depend on the number of threads.
    pub(crate) fn build(builder: TreeBuilder, grouping: &Grouping<'_, impl Fn(&[u32]) -> bool + Sync>) -> Binary {
        match builder {
            TreeBuilder::Binned => Binary::binned(grouping),
            TreeBuilder::Clustered => Binary::clustered(grouping),
        }
    }

    /// The leaf of a reference.
    #[inline(always)]
    pub(crate) fn leaf(&self, reference: u32) -> &Leaf {
        &self.leaves[(reference & !LEAF) as usize]
    }
}
