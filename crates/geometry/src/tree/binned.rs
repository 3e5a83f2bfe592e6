//! Binary trees, built from the top down: of all splits between bins of centers, the one with the least expected cost.
//!
//! A ray meets a box in proportion to its surface, so a split costs the surface of each side times the number of items there. Wald,
//! "On fast Construction of SAH-based Bounding Volume Hierarchies" (2007).

use glam::Vec4;
use rayon::prelude::*;

use super::binary::{Binary, BinaryNode, Grouping, Leaf};
use super::node::LEAF;
use crate::aabb::Aabb;

/// An item's box; the last lane of `low` holds its number.
#[derive(Clone, Copy, Default)]
struct Item {
    low: Vec4,
    high: Vec4,
}

impl Item {
    /// Makes the bits of any number below 2^28 those of an ordinary float.
    const MARK: u32 = 1 << 30;

    fn new(number: u32, aabb: &Aabb) -> Item {
        Item { low: aabb.min.extend(f32::from_bits(Item::MARK | number)), high: aabb.max.extend(0.0) }
    }

    fn number(&self) -> u32 {
        self.low.w.to_bits() ^ Item::MARK
    }

    /// Twice the center.
    #[inline(always)]
    fn center(&self) -> Vec4 {
        self.low + self.high
    }
}

/// A box that grows; its last lane means nothing.
#[derive(Clone, Copy)]
struct Extent {
    low: Vec4,
    high: Vec4,
}

impl Extent {
    const EMPTY: Extent = Extent { low: Vec4::INFINITY, high: Vec4::NEG_INFINITY };

    #[inline(always)]
    fn add(&mut self, low: Vec4, high: Vec4) {
        self.low = self.low.min(low);
        self.high = self.high.max(high);
    }

    #[inline(always)]
    fn union(mut self, other: &Extent) -> Extent {
        self.add(other.low, other.high);
        self
    }

    #[inline(always)]
    fn half_area(&self) -> f32 {
        let size = self.high - self.low;
        size.x * (size.y + size.z) + size.y * size.z
    }

    fn aabb(&self) -> Aabb {
        Aabb { min: self.low.truncate(), max: self.high.truncate() }
    }
}

/// Some items: the box around them, and that around twice their centers.
#[derive(Clone, Copy)]
struct Cluster {
    bounds: Extent,
    centers: Extent,
}

impl Cluster {
    const EMPTY: Cluster = Cluster { bounds: Extent::EMPTY, centers: Extent::EMPTY };

    #[inline(always)]
    fn add(&mut self, item: &Item) {
        self.bounds.add(item.low, item.high);
        self.centers.add(item.center(), item.center());
    }

    fn union(self, other: Cluster) -> Cluster {
        Cluster { bounds: self.bounds.union(&other.bounds), centers: self.centers.union(&other.centers) }
    }

    fn around(items: &[Item]) -> Cluster {
        items.iter().fold(Cluster::EMPTY, |mut cluster, item| {
            cluster.add(item);
            cluster
        })
    }
}

/// Items from which on both sides of a split grow at the same time, and from which on bins are filled in parts.
const FORK: usize = 16_384;
const PART: usize = 32_768;

/// Where centers fall into bins.
struct Scale<const BINS: usize> {
    from: Vec4,
    by: Vec4,
}

impl<const BINS: usize> Scale<BINS> {
    fn new(centers: &Extent) -> Scale<BINS> {
        let size = centers.high - centers.low;
        // A little less than the bins, so that the farthest center is in the last one.
        let by = size.to_array().map(|size| if size > 0.0 { BINS as f32 * (1.0 - 1e-5) / size } else { 0.0 });
        Scale { from: centers.low, by: Vec4::from_array(by) }
    }

    /// The bins of an item along x, y and z.
    #[inline(always)]
    fn bins(&self, item: &Item) -> [usize; 4] {
        // Above 2^23 there is no room for fractions: the sum rounds to a whole number, whose last bits are left.
        let whole = (1 << 23) as f32 + BINS as f32;
        let places = (item.center() - self.from) * self.by - 0.5 + whole;
        places.to_array().map(|place| place.to_bits() as usize % BINS)
    }
}

/// What fell into the bins of each axis.
#[derive(Clone)]
struct Bins<const BINS: usize> {
    extents: [[Extent; BINS]; 3],
    counts: [[u32; BINS]; 3],
}

impl<const BINS: usize> Bins<BINS> {
    const EMPTY: Bins<BINS> = Bins { extents: [[Extent::EMPTY; BINS]; 3], counts: [[0; BINS]; 3] };

    fn fill(items: &[Item], scale: &Scale<BINS>) -> Bins<BINS> {
        let mut bins = Bins::EMPTY;
        for item in items {
            let places = scale.bins(item);
            for (axis, &place) in places[..3].iter().enumerate() {
                bins.extents[axis][place].add(item.low, item.high);
                bins.counts[axis][place] += 1;
            }
        }
        bins
    }

    fn merged(mut self, other: Bins<BINS>) -> Bins<BINS> {
        for axis in 0..3 {
            for place in 0..BINS {
                let extent = &mut self.extents[axis][place];
                *extent = extent.union(&other.extents[axis][place]);
                self.counts[axis][place] += other.counts[axis][place];
            }
        }
        self
    }

    /// The cheapest split, unless all items fell into one bin of every axis.
    fn best(&self) -> Option<Split> {
        let cost = |extent: &Extent, count: u32| extent.half_area() * count as f32;
        let mut best = (f32::INFINITY, None);
        for (axis, (extents, counts)) in self.extents.iter().zip(&self.counts).enumerate() {
            let mut above = [f32::INFINITY; BINS];
            let (mut extent, mut count) = (Extent::EMPTY, 0);
            for place in (1..BINS).rev() {
                extent = extent.union(&extents[place]);
                count += counts[place];
                if count > 0 {
                    above[place] = cost(&extent, count);
                }
            }
            let (mut extent, mut count) = (Extent::EMPTY, 0);
            for place in 1..BINS {
                extent = extent.union(&extents[place - 1]);
                count += counts[place - 1];
                if count > 0 {
                    let cost = cost(&extent, count) + above[place];
                    if cost < best.0 {
                        best = (cost, Some(Split { axis, below: place }));
                    }
                }
            }
        }
        best.1
    }
}

/// A split: items in bins below `below` along an axis go to the first side.
struct Split {
    axis: usize,
    below: usize,
}

/// A part of the tree; its references count from its own beginning.
struct Part {
    nodes: Vec<BinaryNode>,
    leaves: Vec<Leaf>,
}

/// Memory of some items: what is to be sorted, where it is sorted to, and the numbers in the order of leaves, written at the end.
struct Span<'a> {
    items: &'a mut [Item],
    scratch: &'a mut [Item],
    order: &'a mut [u32],
    /// Where it begins among all items.
    first: usize,
}

impl<'a> Span<'a> {
    /// Both sides of a split, sorted into the scratch memory, which changes places with the items.
    fn split(self, middle: usize) -> [Span<'a>; 2] {
        let (items, scratch) = (self.scratch.split_at_mut(middle), self.items.split_at_mut(middle));
        let order = self.order.split_at_mut(middle);
        [
            Span { items: items.0, scratch: scratch.0, order: order.0, first: self.first },
            Span { items: items.1, scratch: scratch.1, order: order.1, first: self.first + middle },
        ]
    }
}

impl Part {
    /// One that can hold the tree over so many items.
    fn for_items(count: usize) -> Part {
        Part { nodes: Vec::with_capacity(count - 1), leaves: Vec::with_capacity(count) }
    }

    /// Adds a part behind this one; its root as a reference here.
    fn append(&mut self, root: u32, part: Part) -> u32 {
        let (nodes, leaves) = (self.nodes.len() as u32, self.leaves.len() as u32);
        let moved = |reference: u32| reference + if reference & LEAF != 0 { leaves } else { nodes };
        self.nodes.extend(part.nodes.iter().map(|node| BinaryNode { children: node.children.map(moved), ..*node }));
        self.leaves.extend(part.leaves);
        moved(root)
    }
}

impl Binary {
    /// Builds a tree over at least one box. The boxes are finite. The result does not depend on the number of threads.
    pub(super) fn binned(grouping: &Grouping<'_, impl Fn(&[u32]) -> bool + Sync>) -> Binary {
        let boxes = grouping.boxes.par_iter().enumerate();
        let mut items: Vec<Item> = boxes.map(|(item, aabb)| Item::new(item as u32, aabb)).collect();
        let cluster = items.par_chunks(PART).map(Cluster::around).reduce(|| Cluster::EMPTY, Cluster::union);
        let (mut part, mut order) = (Part::for_items(items.len()), vec![0; items.len()]);
        let mut scratch = vec![Item::default(); items.len()];
        let all = Span { items: &mut items, scratch: &mut scratch, order: &mut order, first: 0 };
        let root = grouping.grow(all, cluster, &mut part);
        Binary { nodes: part.nodes, leaves: part.leaves, items: order, root }
    }
}

impl<F: Fn(&[u32]) -> bool + Sync> Grouping<'_, F> {
    /// Adds the tree over some items to a part; its root.
    fn grow(&self, span: Span<'_>, cluster: Cluster, part: &mut Part) -> u32 {
        let count = span.items.len();
        if count <= self.most {
            span.order.iter_mut().zip(&*span.items).for_each(|(number, item)| *number = item.number());
            if count == 1 || (self.fits)(span.order) {
                let bounds = cluster.bounds.aabb();
                part.leaves.push(Leaf { bounds, first: span.first as u32, count: count as u32 });
                return LEAF | (part.leaves.len() - 1) as u32;
            }
        }
        let here = part.nodes.len();
        part.nodes.push(BinaryNode { half_area: cluster.bounds.half_area(), children: [0; 2] });
        // Bins are many enough for so many items, and few enough to be looked through.
        let divide = match count {
            ..5 => divide_few,
            5..8 => divide::<4>,
            8..32 => divide::<8>,
            _ => divide::<16>,
        };
        let (middle, [first, second]) = divide(span.items, span.scratch, &cluster);
        let [a, b] = span.split(middle);
        let children = if count < FORK {
            [self.grow(a, first, part), self.grow(b, second, part)]
        } else {
            let alone = |span: Span<'_>, cluster| {
                let mut part = Part::for_items(span.items.len());
                (self.grow(span, cluster, &mut part), part)
            };
            let (first, second) = rayon::join(|| alone(a, first), || alone(b, second));
            [first, second].map(|(root, below)| part.append(root, below))
        };
        part.nodes[here].children = children;
        here as u32
    }
}

/// What [`divide`] does, for a few items: of all ways to part them, the cheapest.
#[inline(never)]
fn divide_few(items: &[Item], scratch: &mut [Item], _cluster: &Cluster) -> (usize, [Cluster; 2]) {
    let mut best = (f32::INFINITY, 1);
    // The last item stays on the second side: that leaves each way once.
    for first in 1..1u32 << (items.len() - 1) {
        let mut sides = [Extent::EMPTY; 2];
        for (place, item) in items.iter().enumerate() {
            sides[(first >> place & 1 == 0) as usize].add(item.low, item.high);
        }
        let count = first.count_ones() as f32;
        let cost = sides[0].half_area() * count + sides[1].half_area() * (items.len() as f32 - count);
        if cost < best.0 {
            best = (cost, first);
        }
    }
    let middle = best.1.count_ones() as usize;
    let mut ends = [0, middle];
    for (place, item) in items.iter().enumerate() {
        let end = &mut ends[(best.1 >> place & 1 == 0) as usize];
        scratch[*end] = *item;
        *end += 1;
    }
    (middle, [Cluster::around(&scratch[..middle]), Cluster::around(&scratch[middle..])])
}

/// Sorts items into the scratch memory, those of the first side first: how many these are, and what is around both sides.
#[inline(never)]
fn divide<const BINS: usize>(items: &[Item], scratch: &mut [Item], cluster: &Cluster) -> (usize, [Cluster; 2]) {
    let scale = Scale::<BINS>::new(&cluster.centers);
    let filled = if items.len() < PART {
        Bins::fill(items, &scale)
    } else {
        let parts = items.par_chunks(PART).map(|items| Bins::fill(items, &scale));
        parts.reduce(|| Bins::EMPTY, Bins::merged)
    };
    let Some(Split { axis, below }) = filled.best() else {
        // All centers are in one place.
        scratch.copy_from_slice(items);
        let middle = items.len() / 2;
        return (middle, [Cluster::around(&items[..middle]), Cluster::around(&items[middle..])]);
    };
    let (mut first, mut last) = (0, items.len() - 1);
    let mut sides = [Cluster::EMPTY; 2];
    for item in items {
        let side = (scale.bins(item)[axis] >= below) as usize;
        sides[side].centers.add(item.center(), item.center());
        // Written at both ends, where only one of them counts: no branch to mispredict.
        scratch[first] = *item;
        scratch[last] = *item;
        first += 1 - side;
        last = last.wrapping_sub(side);
    }
    for (place, extent) in filled.extents[axis].iter().enumerate() {
        let side = &mut sides[(place >= below) as usize];
        side.bounds = side.bounds.union(extent);
    }
    (first, sides)
}
