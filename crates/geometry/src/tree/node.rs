//! The blocks trees are made of: nodes of eight boxes, and patches of up to eight triangles.

use glam::Vec3;

use crate::aabb::Aabb;

/// Marks a reference to a leaf; the other bits number the leaf, or the node.
pub(crate) const LEAF: u32 = 1 << 31;

/// Eight boxes and what is in them, in four cache lines. Places that are not used hold boxes that nothing hits.
#[repr(C, align(128))]
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Node {
    /// Least x, greatest x, least y, greatest y, least z, greatest z of the children.
    pub(crate) planes: [[f32; 8]; 6],
    /// References to the children.
    pub(crate) children: [u32; 8],
    /// The number of children; they come first.
    pub(crate) count: u32,
    /// The node that this one is a child of, and its place there: `node << 3 | place`. 0 at the root.
    pub(crate) parent: u32,
}

impl Node {
    pub(crate) const EMPTY: Node = {
        let (low, high) = ([f32::INFINITY; 8], [f32::NEG_INFINITY; 8]);
        Node { planes: [low, high, low, high, low, high], children: [0; 8], count: 0, parent: 0 }
    };

    /// The box of a child.
    pub(crate) fn bounds(&self, place: usize) -> Aabb {
        let plane = |side: usize| Vec3::from_array(std::array::from_fn(|axis| self.planes[2 * axis + side][place]));
        Aabb { min: plane(0), max: plane(1) }
    }

    /// The box of all children.
    pub(crate) fn union(&self) -> Aabb {
        (0..self.count as usize).fold(Aabb::EMPTY, |all, place| all.union(&self.bounds(place)))
    }

    pub(crate) fn set_bounds(&mut self, place: usize, aabb: &Aabb) {
        for axis in 0..3 {
            self.planes[2 * axis][place] = aabb.min[axis];
            self.planes[2 * axis + 1][place] = aabb.max[axis];
        }
    }
}

/// Up to eight triangles over up to eight shared vertices, in two cache lines.
#[repr(C, align(128))]
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Patch {
    /// x, y and z of the vertices; places that are not used repeat the last one.
    pub(crate) vertices: [[f32; 8]; 3],
    /// First, second and third corner of the triangles.
    pub(crate) corners: [[u8; 8]; 3],
    /// Where the patch's triangles begin in the tree's list of primitives.
    pub(crate) first: u32,
    /// The number of triangles.
    pub(crate) triangles: u32,
}

impl Patch {
    /// The place of a triangle's corner.
    #[inline(always)]
    pub(crate) fn corner(&self, triangle: usize, corner: usize) -> Vec3 {
        let vertex = self.corners[corner][triangle] as usize & 7;
        Vec3::from_array(std::array::from_fn(|axis| self.vertices[axis][vertex]))
    }

    /// Puts triangles in a patch, if there are at most eight and they have at most eight different vertices.
    pub(crate) fn pack(triangles: impl Iterator<Item = [Vec3; 3]>) -> Option<Patch> {
        let mut patch = Patch { vertices: [[0.0; 8]; 3], corners: [[0; 8]; 3], first: 0, triangles: 0 };
        let mut known = [Vec3::NAN; 8];
        let mut vertices = 0;
        for corners in triangles {
            let place = patch.triangles as usize;
            if place == 8 {
                return None;
            }
            for (side, corner) in corners.into_iter().enumerate() {
                let found = known[..vertices].iter().position(|&vertex| vertex == corner);
                let vertex = found.unwrap_or(vertices);
                if vertex == 8 {
                    return None;
                }
                known[vertex] = corner;
                vertices = vertices.max(vertex + 1);
                patch.corners[side][place] = vertex as u8;
            }
            patch.triangles += 1;
        }
        for place in 0..8 {
            let vertex = known[place.min(vertices.saturating_sub(1))];
            for axis in 0..3 {
                patch.vertices[axis][place] = vertex[axis];
            }
        }
        Some(patch)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_are_whole_cache_lines() {
        assert_eq!((size_of::<Node>(), size_of::<Patch>()), (256, 128));
    }

    #[test]
    fn patches_share_vertices() {
        let at = |i: usize| Vec3::new(i as f32, (i % 2) as f32, 0.0);
        let strip = |n: usize| (0..n).map(|i| [at(i), at(i + 1), at(i + 2)]);
        let patch = Patch::pack(strip(6)).unwrap();
        assert_eq!(patch.triangles, 6);
        for (triangle, corners) in strip(6).enumerate() {
            assert_eq!([0, 1, 2].map(|c| patch.corner(triangle, c)), corners);
        }
        assert!(Patch::pack(strip(7)).is_none(), "nine vertices");
        assert!(Patch::pack((0..9).map(|_| [at(0), at(1), at(2)])).is_none(), "nine triangles");
    }
}
