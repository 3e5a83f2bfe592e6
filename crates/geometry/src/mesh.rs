//! Triangle meshes: shared vertices, checked once, never copied.

use glam::{Vec2, Vec3, Vec4};

use crate::aabb::Aabb;
use crate::shape::LARGEST_LENGTH;

/// Triangles over shared vertices. Corners run counterclockwise seen from outside. Many instances share one mesh by an `Arc`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleMesh {
    /// Positions of the vertices.
    pub positions: Vec<Vec3>,
    /// Normals of the vertices, of any length but zero; empty for a flat mesh.
    pub normals: Vec<Vec3>,
    /// Texture coordinates of the vertices; may be empty.
    pub uvs: Vec<Vec2>,
    /// Second texture coordinates of the vertices; may be empty.
    pub second_uvs: Vec<Vec2>,
    /// Colors of the vertices, linear, with alpha; may be empty.
    pub colors: Vec<Vec4>,
    /// Tangents of the vertices along which u grows, of any length but zero, and the side of the bitangent: it is the cross
    /// product of normal and tangent times the sign of w. May be empty: then texture coordinates tell.
    pub tangents: Vec<Vec4>,
    /// The three vertices of every triangle.
    pub triangles: Vec<[u32; 3]>,
}

/// Why a mesh cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshError {
    /// It has no triangles.
    NoTriangles,
    /// It has more triangles or vertices than 2³⁰.
    TooLarge {
        /// How many.
        count: usize,
    },
    /// A triangle names a vertex that does not exist.
    IndexOutOfRange {
        /// The triangle.
        triangle: usize,
        /// The vertex it names.
        index: u32,
        /// The number of vertices.
        vertices: usize,
    },
    /// A number of a vertex is not finite, a position is beyond 10¹⁵ m, or a color below 0.
    BadNumber {
        /// The name of the field.
        column: &'static str,
        /// The vertex.
        vertex: usize,
    },
    /// There are normals or texture coordinates or the like, but not one for each vertex.
    LengthsDiffer {
        /// The name of the field.
        column: &'static str,
        /// How many it has.
        found: usize,
        /// The number of vertices.
        vertices: usize,
    },
}

impl std::fmt::Display for MeshError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            MeshError::NoTriangles => f.write_str("the mesh has no triangles"),
            MeshError::TooLarge { count } => {
                write!(f, "the mesh has {count} triangles or vertices; the limit is {MOST_TRIANGLES}")
            }
            MeshError::IndexOutOfRange { triangle, index, vertices } => {
                write!(f, "triangle {triangle} names vertex {index}, but there are {vertices} vertices")
            }
            MeshError::BadNumber { column, vertex } => {
                write!(f, "{column} of vertex {vertex} are not finite or out of range")
            }
            MeshError::LengthsDiffer { column, found, vertices } => {
                write!(f, "there are {found} {column} for {vertices} vertices")
            }
        }
    }
}

impl std::error::Error for MeshError {}

/// Triangles and vertices of one mesh: references to them need two more bits.
pub const MOST_TRIANGLES: usize = 1 << 30;

impl TriangleMesh {
    /// Whether a tree can be built over the mesh. Degenerate triangles are legal; no ray hits them.
    pub fn validate(&self) -> Result<(), MeshError> {
        let vertices = self.positions.len();
        if self.triangles.is_empty() {
            return Err(MeshError::NoTriangles);
        }
        let count = self.triangles.len().max(vertices);
        if count > MOST_TRIANGLES {
            return Err(MeshError::TooLarge { count });
        }
        let lengths = [
            ("normals", self.normals.len()),
            ("uvs", self.uvs.len()),
            ("second_uvs", self.second_uvs.len()),
            ("colors", self.colors.len()),
            ("tangents", self.tangents.len()),
        ];
        for (column, found) in lengths {
            if found != 0 && found != vertices {
                return Err(MeshError::LengthsDiffer { column, found, vertices });
            }
        }
        for (triangle, corners) in self.triangles.iter().enumerate() {
            if let Some(&index) = corners.iter().find(|&&index| index as usize >= vertices) {
                return Err(MeshError::IndexOutOfRange { triangle, index, vertices });
            }
        }
        let in_range = |p: &Vec3| p.is_finite() && p.abs().max_element() <= LARGEST_LENGTH;
        let bad = |column, vertex: Option<usize>| match vertex {
            Some(vertex) => Err(MeshError::BadNumber { column, vertex }),
            None => Ok(()),
        };
        bad("positions", self.positions.iter().position(|p| !in_range(p)))?;
        bad("normals", self.normals.iter().position(|n| !n.is_finite()))?;
        bad("uvs", self.uvs.iter().position(|uv| !uv.is_finite()))?;
        bad("second_uvs", self.second_uvs.iter().position(|uv| !uv.is_finite()))?;
        bad("colors", self.colors.iter().position(|color| !(color.is_finite() && color.min_element() >= 0.0)))?;
        bad("tangents", self.tangents.iter().position(|tangent| !tangent.is_finite()))
    }

    /// The corners of a triangle.
    #[inline(always)]
    pub fn corners(&self, triangle: usize) -> [Vec3; 3] {
        self.triangles[triangle].map(|vertex| self.positions[vertex as usize])
    }

    /// The smallest box around the vertices that triangles use.
    pub fn bounds(&self) -> Aabb {
        Aabb::around(self.triangles.iter().flatten().map(|&vertex| self.positions[vertex as usize]))
    }

    /// Whether a triangle has no area: two corners in one place, or all three on a line. No ray hits it.
    pub fn is_degenerate(&self, triangle: usize) -> bool {
        let [a, b, c] = self.corners(triangle).map(|corner| corner.as_dvec3());
        (b - a).cross(c - a) == glam::DVec3::ZERO
    }

    /// The degenerate triangles, in order.
    pub fn degenerate_triangles(&self) -> Vec<u32> {
        (0..self.triangles.len())
            .filter(|&triangle| self.is_degenerate(triangle))
            .map(|triangle| triangle as u32)
            .collect()
    }

    /// Whether the triangles bound a volume: every edge is used as often in one direction as in the other. Vertices in one place
    /// count as one, so a seam of normals or texture coordinates is no hole.
    pub fn is_closed(&self) -> bool {
        let place = self.places();
        let mut edges: Vec<[u32; 2]> = Vec::with_capacity(3 * self.triangles.len());
        for corners in &self.triangles {
            let [a, b, c] = corners.map(|vertex| place[vertex as usize]);
            edges.extend([[a, b], [b, c], [c, a]].into_iter().filter(|[from, to]| from != to));
        }
        let mut reversed: Vec<[u32; 2]> = edges.iter().map(|&[from, to]| [to, from]).collect();
        edges.sort_unstable();
        reversed.sort_unstable();
        edges == reversed
    }

    /// For every vertex the first one in its place.
    fn places(&self) -> Vec<u32> {
        let key = |vertex: u32| (self.positions[vertex as usize] + 0.0).to_array().map(f32::to_bits);
        let mut order: Vec<u32> = (0..self.positions.len() as u32).collect();
        order.sort_unstable_by_key(|&vertex| (key(vertex), vertex));
        let mut place = vec![0; order.len()];
        for same in order.chunk_by(|&a, &b| key(a) == key(b)) {
            for &vertex in same {
                place[vertex as usize] = same[0];
            }
        }
        place
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tetrahedron() -> TriangleMesh {
        TriangleMesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z],
            triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
            ..Default::default()
        }
    }

    #[test]
    fn bad_meshes_are_errors() {
        let good = tetrahedron();
        let check = |change: fn(&mut TriangleMesh), expected: Result<(), MeshError>| {
            let mut mesh = good.clone();
            change(&mut mesh);
            assert_eq!(mesh.validate(), expected, "{mesh:?}");
        };
        check(|_| (), Ok(()));
        check(|m| m.triangles.clear(), Err(MeshError::NoTriangles));
        check(|m| m.triangles[1][2] = 4, Err(MeshError::IndexOutOfRange { triangle: 1, index: 4, vertices: 4 }));
        check(|m| m.positions[2].y = f32::NAN, Err(MeshError::BadNumber { column: "positions", vertex: 2 }));
        check(|m| m.positions[2].y = 1e16, Err(MeshError::BadNumber { column: "positions", vertex: 2 }));
        check(
            |m| m.normals = vec![Vec3::X; 3],
            Err(MeshError::LengthsDiffer { column: "normals", found: 3, vertices: 4 }),
        );
        check(
            |m| m.uvs = vec![Vec2::new(0.0, f32::INFINITY); 4],
            Err(MeshError::BadNumber { column: "uvs", vertex: 0 }),
        );
        check(
            |m| m.second_uvs = vec![Vec2::ZERO; 5],
            Err(MeshError::LengthsDiffer { column: "second_uvs", found: 5, vertices: 4 }),
        );
        check(|m| m.colors = vec![Vec4::NEG_X; 4], Err(MeshError::BadNumber { column: "colors", vertex: 0 }));
        check(|m| m.tangents = vec![Vec4::NAN; 4], Err(MeshError::BadNumber { column: "tangents", vertex: 0 }));
    }

    #[test]
    fn holes_and_flipped_triangles_are_found() {
        let mut mesh = tetrahedron();
        assert!(mesh.is_closed());
        mesh.positions.push(Vec3::new(-0.0, 1.0, 0.0));
        mesh.triangles[3] = [1, 4, 3];
        assert!(mesh.is_closed(), "a seam is no hole");
        mesh.triangles[3] = [1, 3, 4];
        assert!(!mesh.is_closed(), "flipped");
        mesh.triangles.pop();
        assert!(!mesh.is_closed(), "a hole");
    }

    #[test]
    fn degenerate_triangles_are_listed() {
        let mut mesh = tetrahedron();
        mesh.positions.push(Vec3::new(0.5, 0.0, 0.0));
        mesh.triangles.extend([[0, 1, 1], [0, 4, 1], [0, 4, 2]]);
        assert_eq!(mesh.degenerate_triangles(), [4, 5]);
    }
}
