//! Tangents for normal maps, where a file has none: by MikkTSpace, as the specification asks for.

use std::collections::HashMap;

use bevy_mikktspace::{Geometry, Ops, TangentSpace, generate_tangents};
use brewster_lanes::math;
use brewster_world::components::parts::TriangleMesh;
use glam::Vec4;

/// Gives a mesh with normals tangents along the coordinates that normal maps are looked up by. A vertex that needs several is
/// there as often. Without such coordinates, or where they are degenerate, nothing happens.
pub(super) fn add(mesh: &mut TriangleMesh, uses_second_uvs: bool) {
    let uvs = if uses_second_uvs && !mesh.second_uvs.is_empty() { &mesh.second_uvs } else { &mesh.uvs };
    if uvs.is_empty() || mesh.normals.is_empty() {
        return;
    }
    let mut corners = Corners { mesh, uvs, tangents: vec![Vec4::ZERO; 3 * mesh.triangles.len()] };
    if generate_tangents(&mut corners).is_err() {
        return;
    }
    let tangents = corners.tangents;
    let mut known: HashMap<(u32, [u32; 4]), u32> = HashMap::new();
    let mut of_vertices: Vec<Option<Vec4>> = vec![None; mesh.positions.len()];
    for (corner, tangent) in mesh.triangles.as_flattened_mut().iter_mut().zip(tangents) {
        let of_vertex = &mut of_vertices[*corner as usize];
        if *of_vertex.get_or_insert(tangent) == tangent {
            continue;
        }
        let vertex = *corner as usize;
        *corner = *known.entry((*corner, tangent.to_array().map(f32::to_bits))).or_insert_with(|| {
            of_vertices.push(Some(tangent));
            repeat(&mut mesh.positions, vertex);
            repeat(&mut mesh.normals, vertex);
            repeat(&mut mesh.uvs, vertex);
            repeat(&mut mesh.second_uvs, vertex);
            repeat(&mut mesh.colors, vertex);
            of_vertices.len() as u32 - 1
        });
    }
    mesh.tangents = of_vertices.into_iter().map(|tangent| tangent.unwrap_or(Vec4::X)).collect();
}

/// Repeats a row of a column that is not empty.
fn repeat<T: Copy>(rows: &mut Vec<T>, row: usize) {
    if let Some(&value) = rows.get(row) {
        rows.push(value);
    }
}

/// The same on every machine.
struct Portable;

impl Ops for Portable {
    fn sqrt(x: f32) -> f32 {
        x.sqrt()
    }

    fn acos(x: f32) -> f32 {
        math::acos(x)
    }
}

struct Corners<'m> {
    mesh: &'m TriangleMesh,
    uvs: &'m [glam::Vec2],
    /// One for each corner of each triangle.
    tangents: Vec<Vec4>,
}

impl Corners<'_> {
    fn vertex(&self, face: usize, corner: usize) -> usize {
        self.mesh.triangles[face][corner] as usize
    }
}

impl Geometry<Portable> for Corners<'_> {
    fn num_faces(&self) -> usize {
        self.mesh.triangles.len()
    }

    fn num_vertices_of_face(&self, _: usize) -> usize {
        3
    }

    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        self.mesh.positions[self.vertex(face, corner)].to_array()
    }

    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        self.mesh.normals[self.vertex(face, corner)].normalize_or_zero().to_array()
    }

    /// Green in a normal map is up in the picture, where glTF's v falls.
    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        let uv = self.uvs[self.vertex(face, corner)];
        [uv.x, 1.0 - uv.y]
    }

    fn set_tangent(&mut self, tangent: Option<TangentSpace>, face: usize, corner: usize) {
        let found = tangent.map_or(Vec4::X, |tangent| Vec4::from_array(tangent.tangent_encoded()));
        self.tangents[3 * face + corner] = if found.is_finite() { found } else { Vec4::X };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Vec2, Vec3};

    #[test]
    fn tangents_point_where_u_grows_and_mirrored_halves_part() {
        // Two triangles that share the edge from (0, 0) to (0, 1) with coordinates mirrored about it: u grows away from it.
        // v is 0 at the top of pictures: it falls as y grows, so that the bitangent points along +y.
        let mut mesh = TriangleMesh {
            positions: vec![Vec3::ZERO, Vec3::Y, Vec3::X, Vec3::NEG_X],
            normals: vec![Vec3::Z; 4],
            uvs: vec![Vec2::new(0.0, 1.0), Vec2::ZERO, Vec2::new(1.0, 1.0), Vec2::new(1.0, 1.0)],
            triangles: vec![[0, 2, 1], [0, 1, 3]],
            ..TriangleMesh::default()
        };
        add(&mut mesh, false);
        mesh.validate().expect("it is still a mesh");
        for (triangle, tangent) in [(0, Vec3::X), (1, Vec3::NEG_X)] {
            for corner in mesh.triangles[triangle] {
                let found = mesh.tangents[corner as usize];
                assert!(found.truncate().distance(tangent) < 1e-6, "{found}");
                let bitangent = Vec3::Z.cross(found.truncate()) * found.w;
                assert!(bitangent.distance(Vec3::Y) < 1e-6, "{found}");
            }
        }
        assert_eq!(mesh.positions.len(), 6, "the shared corners have two tangents each");
    }
}
