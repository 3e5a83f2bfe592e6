//! Many sources in bundles of neighbors, so that a tree over them is soon built.
//!
//! Sources are ordered along the Z-order curve through the box around them. A bundle is a stretch of the curve within one cell of an
//! octree, or of the halves and quarters of one; as J. Pantaleoni and D. Luebke, *HLBVH: Hierarchical LBVH Construction for Real-Time
//! Ray Tracing of Dynamic Geometry* (2010), have it, a tree over bundles is built with care and inside of them cells are halved.

use std::ops::Range;

use brewster_geometry::Aabb;
use glam::Vec3;
use rayon::prelude::*;

use super::node::LightBounds;

/// A source's place on the curve: its cell, of 2²¹ along each axis, bits of x, y and z in turn; and its number.
pub(super) type Place = (u64, u32);

/// The Z-order curve through a box.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Curve {
    min: Vec3,
    max: Vec3,
}

impl Curve {
    /// Through the box around sources.
    pub(super) fn through(sources: &[LightBounds]) -> Curve {
        let Aabb { min, max } = Aabb::around(sources.iter().map(LightBounds::center));
        Curve { min, max }
    }

    /// The cell of a place.
    pub(super) fn cell(&self, center: Vec3) -> u64 {
        const CELLS: f32 = (1 << 21) as f32;
        let extent = (self.max - self.min).max_element().max(f32::MIN_POSITIVE);
        let cell = ((center - self.min) / extent * CELLS).to_array().map(|x| x.min(CELLS - 1.0) as u64);
        spread(cell[0]) | spread(cell[1]) << 1 | spread(cell[2]) << 2
    }

    /// The places of sources, in order.
    pub(super) fn places(&self, sources: &[LightBounds]) -> Vec<Place> {
        let places = sources.par_iter().zip(0..sources.len() as u32);
        let mut places: Vec<Place> = places.map(|(source, number)| (self.cell(source.center()), number)).collect();
        places.par_sort_unstable();
        places
    }

    /// Whether the curve is the same after a source was moved.
    pub(super) fn stays(&self, old: Vec3, new: Vec3) -> bool {
        let Curve { min, max } = *self;
        let [inside, within] = [old.cmpgt(min) & old.cmplt(max), new.cmpge(min) & new.cmple(max)];
        // Where all are in a plane, it is the same as long as they stay there.
        (old.cmpeq(new) | inside & within).all()
    }
}

/// Cuts the curve into bundles of at most `most` sources.
pub(super) fn bundles(places: &[Place], most: usize) -> Vec<Range<usize>> {
    let mut bundles = Vec::new();
    let mut open: Vec<_> = std::iter::once(0..places.len()).collect();
    while let Some(range) = open.pop() {
        if range.len() <= most {
            bundles.push(range);
            continue;
        }
        let middle = range.start + middle(&places[range.clone()]);
        open.extend([middle..range.end, range.start..middle]);
    }
    bundles
}

/// Where the second half of a cell begins, of at least two sources: neither is empty.
pub(super) fn middle(places: &[Place]) -> usize {
    let (first, last) = (places[0].0, places[places.len() - 1].0);
    if first == last {
        return places.len() / 2;
    }
    // The last is the only one of both with the upper bit in which they differ.
    let bit = (first ^ last).ilog2();
    places.partition_point(|place| place.0 < last >> bit << bit)
}

/// Moves bit i of the lower 21 to place 3i.
fn spread(x: u64) -> u64 {
    let x = (x | x << 32) & 0x001f_0000_0000_ffff;
    let x = (x | x << 16) & 0x001f_0000_ff00_00ff;
    let x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
    let x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
    (x | x << 2) & 0x1249_2492_4924_9249
}

#[cfg(test)]
mod tests {
    use std::f32::consts::FRAC_PI_2;

    use super::super::cone::Cone;
    use super::*;

    fn at(place: Vec3) -> LightBounds {
        let bounds = Aabb { min: place, max: place };
        LightBounds { bounds, normals: Cone::SPHERE, emission: FRAC_PI_2, intensity: 1.0 }
    }

    /// Corners of a cube count x first, then y, then z, by hand; in the middle between them a corner's cell ends.
    #[test]
    fn corners_are_counted_in_turn() {
        let corners = (0..8u32).map(|i| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32));
        let sources: Vec<_> = corners.map(|corner| at(3.0 + corner * 5.0)).rev().collect();
        let places = Curve::through(&sources).places(&sources);
        assert_eq!(places.iter().map(|place| place.1).collect::<Vec<_>>(), [7, 6, 5, 4, 3, 2, 1, 0]);
        assert_eq!(middle(&places), 4);
        assert_eq!(bundles(&places, 2), [0..2, 2..4, 4..6, 6..8]);
        assert_eq!(spread(0x1f_ffff), 0x1249_2492_4924_9249);
    }

    /// What is in one place is halved by number, and no division goes wrong.
    #[test]
    fn sources_in_one_place_are_parted() {
        let sources = vec![at(Vec3::splat(2.0)); 10];
        let places = Curve::through(&sources).places(&sources);
        assert_eq!(bundles(&places, 3), [0..2, 2..5, 5..7, 7..10]);
        assert_eq!(bundles(&places[..1], 1)[0], 0..1);
    }
}
