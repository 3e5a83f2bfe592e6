//! Binary trees, built by obvhs from the bottom up: locally ordered clustering, then reinsertion of the largest nodes.

use glam::{Vec3, Vec3A};
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};
use rayon::prelude::*;

use super::binary::{Binary, BinaryNode, Grouping, Leaf};
use super::node::LEAF;
use crate::aabb::Aabb;

/// The share of the nodes that is reinserted in the first round; the later ones take a third, a fifth, … of it, as obvhs's
/// medium preset does.
const REINSERTED: f32 = 0.05;
const ROUNDS: usize = 16;

impl Binary {
    /// Builds a tree over at least one box. The boxes are finite. The result does not depend on the number of threads.
    pub(super) fn clustered(grouping: &Grouping<'_, impl Fn(&[u32]) -> bool>) -> Binary {
        Binary::grouped(&build(grouping.boxes), grouping)
    }

    /// The same tree with its nodes in the order in which they are first reached, depth first, and items that fit in one leaf.
    fn grouped(bvh: &Bvh2, grouping: &Grouping<'_, impl Fn(&[u32]) -> bool>) -> Binary {
        let mut binary = Binary { nodes: Vec::new(), leaves: Vec::new(), items: Vec::new(), root: 0 };
        let mut todo = vec![(0u32, None)];
        let mut items = Vec::with_capacity(8);
        while let Some((index, parent)) = todo.pop() {
            let node = &bvh.nodes[index as usize];
            gather(bvh, index, grouping.most, &mut items);
            let reference = if node.is_leaf() || items.len() <= grouping.most && (grouping.fits)(&items) {
                let (first, count) = (binary.items.len() as u32, items.len() as u32);
                let bounds = items.iter().fold(Aabb::EMPTY, |all, &item| all.union(&grouping.boxes[item as usize]));
                binary.items.extend(&items);
                binary.leaves.push(Leaf { bounds, first, count });
                LEAF | (binary.leaves.len() - 1) as u32
            } else {
                let here = binary.nodes.len() as u32;
                binary.nodes.push(BinaryNode { half_area: node.aabb().half_area(), children: [0; 2] });
                todo.push((node.first_index + 1, Some((here, 1))));
                todo.push((node.first_index, Some((here, 0))));
                here
            };
            match parent {
                Some((node, side)) => binary.nodes[node as usize].children[side as usize] = reference,
                None => binary.root = reference,
            }
        }
        binary
    }
}

/// A tree with a leaf for each box. Its own boxes are around boxes that were shaken.
pub(crate) fn build(boxes: &[Aabb]) -> Bvh2 {
    let boxes: Vec<obvhs::aabb::Aabb> =
        boxes.par_iter().enumerate().map(|(item, aabb)| shaken(item as u32, aabb)).collect();
    let items = (0..boxes.len() as u32).collect();
    let mut bvh = PlocBuilder::new().build(PlocSearchDistance::Medium, &boxes, items, SortPrecision::U64, 3);
    reinsert(&mut bvh);
    bvh
}

/// The items below a node in order, or the first few beyond `most`.
fn gather(bvh: &Bvh2, index: u32, most: usize, items: &mut Vec<u32>) {
    items.clear();
    let mut todo = vec![index];
    while let Some(index) = todo.pop()
        && items.len() <= most
    {
        let node = &bvh.nodes[index as usize];
        if node.is_leaf() {
            items.push(bvh.primitive_indices[node.first_index as usize]);
        } else {
            todo.extend([node.first_index + 1, node.first_index]);
        }
    }
}

/// A box, moved by up to a thousandth of its size and a few units in the last place of where it is.
///
/// Clustering merges boxes that are nearest to each other. Of boxes that stand in a row at equal distances, or all in one place,
/// it would merge one pair a round: 50,000 balls in a row took 25 s, and take 0.1 s when no two distances are equal.
fn shaken(item: u32, aabb: &Aabb) -> obvhs::aabb::Aabb {
    // A round of multiplying and folding for each axis: the bits need to look random, no more.
    let mut bits = item ^ 0x9e37_79b9;
    let mut random = || {
        bits = (bits ^ bits >> 16).wrapping_mul(0x045d_9f3b).wrapping_add(0x27d4_eb2f);
        (bits >> 8) as f32 / (1 << 23) as f32 - 1.0
    };
    let random = Vec3::new(random(), random(), random());
    let size = (aabb.max - aabb.min).max_element();
    let by = random * (aabb.min.abs().max(aabb.max.abs()) * 2f32.powi(-20) + size * 2f32.powi(-10));
    obvhs::aabb::Aabb { min: Vec3A::from(aabb.min + by), max: Vec3A::from(aabb.max + by) }
}

/// obvhs's own choice of nodes to reinsert sorts them on many threads, and the order of equal areas is then open. This is the
/// same choice with the order settled.
fn reinsert(bvh: &mut Bvh2) {
    let nodes = bvh.nodes.len();
    if nodes < 4 {
        return;
    }
    let mut optimizer = ReinsertionOptimizer::default();
    for round in 0..ROUNDS {
        let batch = ((nodes as f32 * REINSERTED / (2 * round + 1) as f32) as usize).clamp(1, nodes - 1);
        let mut candidates: Vec<(f32, u32)> = bvh
            .nodes
            .iter()
            .enumerate()
            .take(2 * (batch + 1))
            .skip(1)
            .map(|(index, node)| (node.aabb().half_area(), index as u32))
            .collect();
        candidates.par_sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        candidates.truncate(batch);
        let candidates: Vec<u32> = candidates.into_iter().map(|(_, index)| index).collect();
        optimizer.run_with_candidates(bvh, &candidates, 1);
    }
}
