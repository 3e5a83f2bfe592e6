//! From binary trees to wide ones: of all ways to collapse, the one with the least expected cost.
//!
//! A ray visits a node in proportion to its surface. Visiting a node costs one, visiting a leaf costs one (between 0.7 and 2
//! the choice changes nothing). For every binary node, from the leaves up, the cheapest cost of its subtree as at most
//! 1, 2, … 7 wide subtrees follows from its children's: Wald, Benthin, Boulos, "Getting Rid of Packets" (2008), made exact by
//! dynamic programming as in Ylitie, Karras, Laine (HPG 2017).

use super::binary::{Binary, Leaf};
use super::node::{LEAF, Node};

/// Nodes of a wide tree; the root is the first.
pub(crate) struct Wide {
    pub(crate) nodes: Vec<Node>,
    /// Entries that the deepest traversal keeps on its stack.
    pub(crate) stack: usize,
    /// The leaves.
    pub(crate) leaves: Vec<Leaf>,
    /// The items, of which each leaf has some neighbors.
    pub(crate) items: Vec<u32>,
}

impl Wide {
    /// The items of a leaf.
    pub(crate) fn items_of(&self, leaf: &Leaf) -> &[u32] {
        &self.items[leaf.first as usize..][..leaf.count as usize]
    }
}

/// For every binary node: the cost of its subtree as at most 1 to 7 wide subtrees.
struct Plan<'a> {
    binary: &'a Binary,
    cost: Vec<[f32; 7]>,
}

/// Collapses a binary tree.
pub(crate) fn collapse(binary: Binary) -> Wide {
    let mut plan = Plan { binary: &binary, cost: vec![[0.0; 7]; binary.nodes.len()] };
    plan.price();
    let wide = plan.emit();
    Wide { items: binary.items, ..wide }
}

/// The tree over nothing.
pub(crate) fn nothing() -> Wide {
    Wide { nodes: vec![Node::EMPTY], stack: 1, leaves: Vec::new(), items: Vec::new() }
}

impl Plan<'_> {
    /// The costs of a subtree as at most 1 to 7 wide ones.
    #[inline(always)]
    fn costs(&self, reference: u32) -> [f32; 7] {
        if reference & LEAF != 0 {
            [self.binary.leaf(reference).bounds.half_area(); 7]
        } else {
            self.cost[reference as usize]
        }
    }

    /// The costs of the children of a node together, as at most 2 to 8 wide subtrees: what is at `places` is for so many.
    fn shares(&self, node: u32) -> [f32; 9] {
        let [a, b] = self.binary.nodes[node as usize].children;
        let (first, second) = (self.costs(a), self.costs(b));
        let mut shares = [f32::INFINITY; 9];
        if a & LEAF != 0 {
            // A leaf costs the same however many places it may take.
            (2..9).for_each(|places| shares[places] = first[0] + second[places - 2]);
        } else if b & LEAF != 0 {
            (2..9).for_each(|places| shares[places] = first[places - 2] + second[0]);
        } else {
            for taken in 1..8 {
                for rest in 1..9 - taken {
                    shares[taken + rest] = shares[taken + rest].min(first[taken - 1] + second[rest - 1]);
                }
            }
        }
        shares
    }

    /// The first child's share of places where both together are cheapest.
    fn first_share(&self, node: u32, places: usize) -> usize {
        let [a, b] = self.binary.nodes[node as usize].children;
        let (a, b) = (self.costs(a), self.costs(b));
        let mut best = (f32::INFINITY, 1);
        for first in places.saturating_sub(7).max(1)..places.min(8) {
            let cost = a[first - 1] + b[places - first - 1];
            if cost < best.0 {
                best = (cost, first);
            }
        }
        best.1
    }

    fn price(&mut self) {
        for node in (0..self.binary.nodes.len()).rev() {
            let shares = self.shares(node as u32);
            let inner = self.binary.nodes[node].half_area + shares.into_iter().fold(f32::INFINITY, f32::min);
            let mut cost = [inner; 7];
            for places in 2..8 {
                cost[places - 1] = cost[places - 2].min(shares[places]);
            }
            self.cost[node] = cost;
        }
    }

    /// The wide children of a node, inner ones first.
    fn children(&self, node: u32, children: &mut Vec<u32>, todo: &mut Vec<(u32, usize, bool)>) {
        children.clear();
        let shares = self.shares(node);
        let cheapest = (3..=8).fold(2, |best, places| if shares[places] < shares[best] { places } else { best });
        todo.push((node, cheapest, true));
        while let Some((reference, mut places, open)) = todo.pop() {
            if reference & LEAF != 0 {
                children.push(reference);
                continue;
            }
            let costs = self.cost[reference as usize];
            while !open && places > 1 && costs[places - 1] >= costs[places - 2] {
                places -= 1;
            }
            if !open && places == 1 {
                children.push(reference);
                continue;
            }
            let first = self.first_share(reference, places);
            let [a, b] = self.binary.nodes[reference as usize].children;
            todo.extend([(b, places - first, false), (a, first, false)]);
        }
        children.sort_by_key(|&child| child & LEAF);
    }

    /// Writes the nodes: children of a node are neighbors, and whole subtrees follow one another.
    fn emit(&self) -> Wide {
        // Each node has two children or more: so many are enough, and what is not touched takes no memory.
        let mut nodes = Vec::with_capacity(self.binary.leaves.len());
        nodes.push(Node::EMPTY);
        let mut leaves = Vec::with_capacity(self.binary.leaves.len());
        let (mut children, mut open) = (Vec::with_capacity(8), Vec::with_capacity(8));
        let mut todo = vec![(self.binary.root, 0usize)];
        while let Some((reference, here)) = todo.pop() {
            // Only a root can be a leaf here.
            if reference & LEAF != 0 {
                children.clear();
                children.push(reference);
            } else {
                self.children(reference, &mut children, &mut open);
            }
            let first = nodes.len();
            for (place, &child) in children.iter().enumerate() {
                nodes[here].children[place] = if child & LEAF != 0 {
                    nodes[here].set_bounds(place, &self.binary.leaf(child).bounds);
                    leaves.push(*self.binary.leaf(child));
                    LEAF | (leaves.len() - 1) as u32
                } else {
                    nodes.push(Node { parent: (here << 3 | place) as u32, ..Node::EMPTY });
                    (nodes.len() - 1) as u32
                };
            }
            nodes[here].count = children.len() as u32;
            let inner = nodes.len() - first;
            todo.extend((0..inner).rev().map(|i| (children[i], first + i)));
        }
        for node in (1..nodes.len()).rev() {
            let (parent, place) = (nodes[node].parent as usize >> 3, nodes[node].parent as usize & 7);
            let bounds = nodes[node].union();
            nodes[parent].set_bounds(place, &bounds);
        }
        let stack = stack_of(&nodes);
        Wide { nodes, stack, leaves, items: Vec::new() }
    }
}

/// Entries that the deepest traversal keeps: a node leaves all its children but one behind.
fn stack_of(nodes: &[Node]) -> usize {
    let mut below = vec![1usize; nodes.len()];
    for node in (0..nodes.len()).rev() {
        below[node] = below[node].max(nodes[node].count as usize);
        if node > 0 {
            let parent = nodes[node].parent as usize >> 3;
            let through = nodes[parent].count as usize - 1 + below[node];
            below[parent] = below[parent].max(through);
        }
    }
    below[0]
}

/// Checks what every wide tree promises; returns the first broken promise.
pub(crate) fn validate(nodes: &[Node], stack: usize) -> Result<(), String> {
    for (index, node) in nodes.iter().enumerate() {
        for place in 0..8 {
            let bounds = node.bounds(place);
            if place >= node.count as usize {
                if !bounds.is_empty() {
                    return Err(format!("node {index}: place {place} is not used, but has a box"));
                }
                continue;
            }
            let child = node.children[place];
            if child & LEAF != 0 {
                continue;
            }
            let Some(inner) = nodes.get(child as usize).filter(|_| child as usize > index) else {
                return Err(format!("node {index}: child {child} is not behind it"));
            };
            if inner.parent as usize != index << 3 | place {
                return Err(format!("node {child} does not know its parent {index}"));
            }
            if !bounds.contains(&inner.union()) {
                return Err(format!("node {index}: the box of child {child} does not hold it"));
            }
        }
    }
    if stack_of(nodes) > stack { Err("the stack is too small".to_string()) } else { Ok(()) }
}
