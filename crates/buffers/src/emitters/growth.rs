//! How light sources are divided until each is alone: bundles of them with care, and inside of these along a curve.

use brewster_geometry::Aabb;
use glam::Vec3;
use rayon::prelude::*;

use super::bundles::{self, Place};
use super::node::{LEAF, LightBounds, Node};

/// A binary tree: the root, then pairs of siblings.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Branches {
    nodes: Vec<Node>,
    /// The parent of each pair.
    parents: Vec<u32>,
}

/// What nodes are made of.
struct Growth<'a> {
    sources: &'a [LightBounds],
    /// Intensity of all of them.
    total: f64,
    /// Of each bundle what the tree knows, and the child of its node.
    bundles: Vec<LightBounds>,
    children: Vec<u32>,
}

impl Branches {
    /// Over sources in places, bundles of at most `most` of which are divided with care; also what is known of all.
    pub(super) fn over(sources: &[LightBounds], places: &[Place], most: usize) -> (Branches, LightBounds) {
        let ranges = bundles::bundles(places, most);
        let total = places.iter().map(|&(_, source)| sources[source as usize].intensity).sum();
        let mut growth = Growth { sources, total, bundles: Vec::new(), children: Vec::new() };
        // The nodes that divide bundles, then those inside of each.
        let mut nodes = vec![Node::default(); 2 * places.len() - 1];
        let (top, mut free) = nodes.split_at_mut(2 * ranges.len() - 1);
        let mut first = top.len() as u32;
        let insides: Vec<_> = ranges
            .into_iter()
            .map(|range| {
                let inside = free.split_off_mut(..2 * (range.len() - 1)).expect("nodes for all sources");
                first += inside.len() as u32;
                (&places[range], first - inside.len() as u32, inside)
            })
            .collect();
        let halve = |(places, first, nodes)| growth.halve(places, first, nodes);
        (growth.bundles, growth.children) = insides.into_par_iter().with_min_len(16).map(halve).unzip();
        let all = growth.divide_all(top);
        (Branches::of(nodes), all)
    }

    /// Over blocks with such trees of their own.
    pub(super) fn over_blocks(blocks: Vec<LightBounds>) -> Branches {
        let mut nodes = vec![Node::default(); 2 * blocks.len() - 1];
        let total = blocks.iter().map(|block| block.intensity).sum();
        let children = (0..blocks.len() as u32).map(|block| LEAF | block).collect();
        Growth { sources: &[], total, bundles: blocks, children }.divide_all(&mut nodes);
        Branches::of(nodes)
    }

    /// A tree of nodes, with the way up.
    fn of(nodes: Vec<Node>) -> Branches {
        let mut parents = vec![0; nodes.len() / 2];
        for (number, node) in (0..).zip(&nodes).filter(|(_, node)| node.child & LEAF == 0) {
            parents[node.child as usize / 2] = number;
        }
        Branches { nodes, parents }
    }

    /// The nodes of what the tree is over.
    pub(super) fn leaves(&self) -> impl Iterator<Item = Leaf> {
        let leaves = (0..).zip(&self.nodes).filter(|(_, node)| node.child & LEAF != 0);
        leaves.map(|(node, of)| Leaf { of: of.child & !LEAF, node })
    }

    /// Draws a leaf as a point sees it with 0 ≤ u < 1, and tells what is left of the number, and the probability times that of the way
    /// here. None where nothing may shine.
    #[inline(always)]
    pub(super) fn choose(&self, point: Vec3, (mut u, mut probability): (f32, f32)) -> Option<(u32, (f32, f32))> {
        let mut child = self.nodes.first()?.child;
        while child & LEAF == 0 {
            let first = self.chance(child, point)?;
            let second = 1.0 - first;
            if u < first {
                u = (u / first).min(1.0f32.next_down());
                probability *= first;
                child = self.nodes[child as usize].child;
            } else {
                u = ((u - first) / second).min(1.0f32.next_down());
                probability *= second;
                child = self.nodes[child as usize + 1].child;
            }
        }
        Some((child & !LEAF, (u, probability)))
    }

    /// The probability with which a leaf is drawn, times that of the way on from it.
    #[inline(always)]
    pub(super) fn probability(&self, point: Vec3, mut node: u32, mut probability: f32) -> f32 {
        while node != 0 {
            let pair = (node - 1) / 2;
            let Some(first) = self.chance(2 * pair + 1, point) else { return 0.0 };
            probability *= if node == 2 * pair + 1 { first } else { 1.0 - first };
            node = self.parents[pair as usize];
        }
        probability
    }

    /// The levels above a node.
    #[cfg(test)]
    pub(super) fn depth(&self, node: u32) -> u32 {
        std::iter::successors(Some(node), |&node| (node != 0).then(|| self.parents[(node as usize - 1) / 2])).count()
            as u32
            - 1
    }

    /// The probability of the first of two siblings; none if both are dark.
    #[inline(always)]
    fn chance(&self, first: u32, point: Vec3) -> Option<f32> {
        let [a, b] = [0, 1].map(|i| self.nodes[first as usize + i].importance(point));
        let sum = a + b;
        (sum > 0.0).then(|| a / sum)
    }
}

/// What a leaf stands for, and its node.
#[derive(Clone, Copy)]
pub(super) struct Leaf {
    pub(super) of: u32,
    pub(super) node: u32,
}

impl Growth<'_> {
    /// Halves what is inside of a bundle. Its nodes, of which `first` is the number of the first, are two less than twice as many as its
    /// sources. Tells what is known of it, and its child.
    fn halve(&self, places: &[Place], first: u32, nodes: &mut [Node]) -> (LightBounds, u32) {
        if let [(_, source)] = *places {
            return (self.sources[source as usize], LEAF | source);
        }
        let (low, high) = places.split_at(bundles::middle(places));
        let (pair, rest) = nodes.split_at_mut(2);
        let (low_nodes, high_nodes) = rest.split_at_mut(2 * (low.len() - 1));
        let low_first = first + 2;
        let high_first = low_first + low_nodes.len() as u32;
        let halves = [self.halve(low, low_first, low_nodes), self.halve(high, high_first, high_nodes)];
        for (node, (bounds, child)) in pair.iter_mut().zip(&halves) {
            *node = Node::new(bounds, self.total, *child);
        }
        (halves[0].0.union(&halves[1].0), first)
    }

    /// Divides bundles with care, likewise. Tells the child.
    fn divide(&self, order: &mut [u32], first: u32, nodes: &mut [Node]) -> u32 {
        if let [bundle] = *order {
            return self.children[bundle as usize];
        }
        let middle = split(&self.bundles, order);
        let (low, high) = order.split_at_mut(middle);
        let (pair, rest) = nodes.split_at_mut(2);
        let (low_nodes, high_nodes) = rest.split_at_mut(2 * (low.len() - 1));
        let low_first = first + 2;
        let high_first = low_first + low_nodes.len() as u32;
        let node = |order: &[u32]| Node::new(&union(&self.bundles, order), self.total, 0);
        [pair[0], pair[1]] = [node(low), node(high)];
        let is_small = low.len().min(high.len()) < 64;
        let (mut low, mut high) =
            (|| self.divide(low, low_first, low_nodes), || self.divide(high, high_first, high_nodes));
        (pair[0].child, pair[1].child) = if is_small { (low(), high()) } else { rayon::join(low, high) };
        first
    }

    /// Divides all bundles; the first node is the root. Tells what is known of all.
    fn divide_all(&self, nodes: &mut [Node]) -> LightBounds {
        let mut order: Vec<u32> = (0..self.bundles.len() as u32).collect();
        let all = union(&self.bundles, &order);
        nodes[0] = Node::new(&all, self.total, self.divide(&mut order, 1, &mut nodes[1..]));
        all
    }
}

fn union(sources: &[LightBounds], order: &[u32]) -> LightBounds {
    let first = sources[order[0] as usize];
    order[1..].iter().fold(first, |union, &source| union.union(&sources[source as usize]))
}

/// Places along an axis where a node may be split.
const BUCKETS: usize = 12;

/// Divides sources in two, neither empty, and tells where the second begins.
fn split(sources: &[LightBounds], order: &mut [u32]) -> usize {
    if order.len() == 2 {
        return 1;
    }
    let center = |source: &u32| sources[*source as usize].center();
    let centers = Aabb::around(order.iter().map(center));
    let extent = centers.max - centers.min;
    let longest = extent.max_element();
    let bucket = |source: &u32, axis: usize| {
        let place = (center(source)[axis] - centers.min[axis]) / extent[axis];
        ((place * BUCKETS as f32) as usize).min(BUCKETS - 1)
    };
    let mut best: Option<(f64, usize, usize)> = None;
    for axis in (0..3).filter(|&axis| extent[axis] > 0.0) {
        let mut buckets: [Option<LightBounds>; BUCKETS] = [None; BUCKETS];
        for source in order.iter() {
            let bucket = &mut buckets[bucket(source, axis)];
            let source = &sources[*source as usize];
            *bucket = Some(bucket.map_or(*source, |bounds| bounds.union(source)));
        }
        let costs = [running_costs(buckets.iter()), running_costs(buckets.iter().rev())];
        for at in 1..BUCKETS {
            let (Some(low), Some(high)) = (costs[0][at - 1], costs[1][BUCKETS - 1 - at]) else { continue };
            // Long thin nodes cost more than their diagonal says.
            let cost = (low + high) * f64::from(longest / extent[axis]);
            if best.is_none_or(|(least, ..)| cost < least) {
                best = Some((cost, axis, at));
            }
        }
    }
    let Some((_, axis, at)) = best else { return order.len() / 2 };
    // Both sides keep their order, so that it depends on nothing but the sources.
    order.sort_by_key(|source| bucket(source, axis) >= at);
    order.partition_point(|source| bucket(source, axis) < at)
}

/// The cost of a node of the first bucket, the first two, …; none while they are empty.
fn running_costs<'a>(buckets: impl Iterator<Item = &'a Option<LightBounds>>) -> [Option<f64>; BUCKETS] {
    let mut sum: Option<LightBounds> = None;
    let mut costs = [None; BUCKETS];
    for (cost, bucket) in costs.iter_mut().zip(buckets) {
        sum = match (sum, bucket) {
            (Some(sum), Some(bucket)) => Some(sum.union(bucket)),
            (sum, bucket) => sum.or(*bucket),
        };
        *cost = sum.map(|bounds| bounds.cost());
    }
    costs
}
