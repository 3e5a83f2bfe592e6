//! PLY: ASCII, and binary of either byte order, through `ply-rs-bw`, the maintained fork of `ply-rs`.
//!
//! Before it may read a payload, the counts of the header are compared with the limits and with the length of the file.

use brewster_world::components::parts::TriangleMesh;
use glam::{Vec2, Vec3, Vec4};
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{
    ElementDef, Encoding, Header, Property, PropertyAccess, PropertyAccessResult, PropertyType, ScalarType,
};

use super::Problem;
use crate::session::Budgets;

/// Reads a file: `vertex` elements with x, y, z, if there are any nx, ny, nz and u, v (or s, t), and what [`write`] writes beside
/// them; `face` elements with `vertex_indices` (or `vertex_index`). A polygon becomes a fan around its first corner; other elements
/// are read over.
pub(super) fn read(bytes: &[u8], budgets: &mut Budgets) -> Result<TriangleMesh, Problem> {
    let fail = |error: ParseError| problem(&error, bytes);
    let mut reader = Reader::new(bytes);
    let header = Parser::<Other>::new().read_header(&mut reader).map_err(fail)?;
    check_sizes(&header, reader.get_ref().len(), budgets)?;
    let mut vertices = Vec::new();
    let mut faces = Vec::new();
    for (name, element) in &header.elements {
        match name.as_str() {
            "vertex" => {
                let read = Parser::<Vertex>::new().read_payload_for_element(&mut reader, element, &header);
                vertices = read.map_err(fail)?;
            }
            "face" => {
                let read = Parser::<Face>::new().read_payload_for_element(&mut reader, element, &header);
                faces = read.map_err(fail)?;
            }
            _ => {
                Parser::<Other>::new().read_payload_for_element(&mut reader, element, &header).map_err(fail)?;
            }
        }
    }
    mesh(&header, &vertices, &faces, budgets)
}

fn mesh(header: &Header, vertices: &[Vertex], faces: &[Face], budgets: &mut Budgets) -> Result<TriangleMesh, Problem> {
    let has = |names: [&str; 2]| {
        let vertex = header.elements.get("vertex");
        vertex.is_some_and(|vertex| names.iter().all(|name| vertex.properties.contains_key(*name)))
    };
    let mut mesh =
        TriangleMesh { positions: vertices.iter().map(|vertex| vertex.position).collect(), ..Default::default() };
    if has(["nx", "nz"]) {
        mesh.normals = vertices.iter().map(|vertex| vertex.normal).collect();
    }
    if has(["u", "v"]) || has(["s", "t"]) || has(["texture_u", "texture_v"]) {
        mesh.uvs = vertices.iter().map(|vertex| vertex.uv).collect();
    }
    if has(["u1", "v1"]) {
        mesh.second_uvs = vertices.iter().map(|vertex| vertex.second_uv).collect();
    }
    if has(["r", "a"]) {
        mesh.colors = vertices.iter().map(|vertex| vertex.color).collect();
    }
    if has(["tx", "tw"]) {
        mesh.tangents = vertices.iter().map(|vertex| vertex.tangent).collect();
    }
    for (row, Face { corners }) in faces.iter().enumerate() {
        let [first, rest @ ..] = &corners[..] else { continue };
        if rest.len() < 2 {
            return Err(Problem::new(None, format!("face {row} has {} corners, not three or more", corners.len())));
        }
        let triangles = rest.len() as u64 - 1;
        budgets.triangles.take(triangles).map_err(|over| Problem::exceeded(None, "triangles", over))?;
        mesh.triangles.extend(rest.windows(2).map(|pair| [*first, pair[0], pair[1]]));
    }
    Ok(mesh)
}

/// Compares what the header promises with the limits and with what can be in the file.
fn check_sizes(header: &Header, payload: usize, budgets: &mut Budgets) -> Result<(), Problem> {
    let mut bytes = 0u64;
    for (name, element) in &header.elements {
        let smallest = smallest_size(element, header.encoding);
        if smallest == 0 {
            return Err(Problem::new(None, format!("the element `{name}` has no properties")));
        }
        bytes = bytes.saturating_add(smallest.saturating_mul(element.count as u64));
    }
    let count = |name: &str| header.elements.get(name).map_or(0, |element| element.count as u64);
    budgets.vertices.take(count("vertex")).map_err(|over| Problem::exceeded(None, "vertices", over))?;
    let triangles = budgets.triangles;
    budgets.triangles.take(count("face")).map_err(|over| Problem::exceeded(None, "triangles", over))?;
    // Faces are counted by their triangles once these are known.
    budgets.triangles = triangles;
    // The last line may lack its line break.
    if bytes > payload as u64 + 1 {
        return Err(Problem::new(None, format!("the header promises at least {bytes} bytes, the file has {payload}")));
    }
    Ok(())
}

/// Bytes that one element takes at least.
fn smallest_size(element: &ElementDef, encoding: Encoding) -> u64 {
    let scalar = |kind: &ScalarType| match (encoding, kind) {
        // A digit and a blank or line break.
        (Encoding::Ascii, _) => 2,
        (_, ScalarType::Char | ScalarType::UChar) => 1,
        (_, ScalarType::Short | ScalarType::UShort) => 2,
        (_, ScalarType::Int | ScalarType::UInt | ScalarType::Float) => 4,
        (_, ScalarType::Double) => 8,
    };
    let sizes = element.properties.iter().map(|(_, property)| match &property.data_type {
        PropertyType::Scalar(kind) | PropertyType::List(kind, _) => scalar(kind),
    });
    sizes.sum()
}

/// The reader's own words, without the lines that it quotes, and the line of the file.
fn problem(error: &ParseError, bytes: &[u8]) -> Problem {
    let text = error.to_string();
    let text =
        text.split_once(": ").filter(|(start, _)| start.starts_with("Line ")).map_or(text.as_str(), |(_, rest)| rest);
    let first = text.lines().next().unwrap_or(text).trim_end_matches('.');
    let reason = text.lines().filter_map(|line| line.trim().strip_prefix("Error: ")).next_back();
    // What its grammar expected instead says nothing to an author.
    let reason = reason.filter(|reason| !reason.contains("expected one of"));
    let message = match reason {
        Some(reason) => format!("{first}: {}", reason.trim_end_matches('.')),
        None => first.to_string(),
    };
    let is_binary = !bytes.windows(12).take(64).any(|window| window == b"format ascii");
    let place = error.line().filter(|_| !is_binary).and_then(|line| {
        let before = bytes.split_inclusive(|&byte| byte == b'\n').take(line.checked_sub(1)?);
        let start = before.map(<[u8]>::len).sum::<usize>();
        let length = bytes[start..].iter().take_while(|&&byte| !matches!(byte, b'\n' | b'\r')).count();
        Some((u32::try_from(start).ok()?, u32::try_from(start + length).ok()?))
    });
    Problem::new(place, format!("this PLY file cannot be read: {message}"))
}

/// A mesh as a binary file that [`read`] reads back to the bit: second texture coordinates are u1 and v1, colors r, g, b and a,
/// linear, and tangents tx, ty, tz and tw, the sign of their side.
pub(crate) fn write(mesh: &TriangleMesh) -> Vec<u8> {
    let pairs = |rows: &[Vec2]| rows.iter().flat_map(|row| row.to_array()).collect::<Vec<f32>>();
    let threes = |rows: &[Vec3]| rows.iter().flat_map(|row| row.to_array()).collect::<Vec<f32>>();
    let fours = |rows: &[Vec4]| rows.iter().flat_map(|row| row.to_array()).collect::<Vec<f32>>();
    let mut columns: Vec<(&[&str], Vec<f32>)> = vec![
        (&["x", "y", "z"], threes(&mesh.positions)),
        (&["nx", "ny", "nz"], threes(&mesh.normals)),
        (&["u", "v"], pairs(&mesh.uvs)),
        (&["u1", "v1"], pairs(&mesh.second_uvs)),
        (&["r", "g", "b", "a"], fours(&mesh.colors)),
        (&["tx", "ty", "tz", "tw"], fours(&mesh.tangents)),
    ];
    columns.retain(|(_, values)| !values.is_empty());
    let (vertices, faces) = (mesh.positions.len(), mesh.triangles.len());
    let names = columns.iter().flat_map(|(names, _)| names.iter());
    let properties: String = names.map(|name| format!("property float {name}\n")).collect();
    let header = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {vertices}\n{properties}element face {faces}\n\
         property list uchar uint vertex_indices\nend_header\n"
    );
    let mut bytes = header.into_bytes();
    for vertex in 0..vertices {
        for (names, values) in &columns {
            let row = &values[vertex * names.len()..][..names.len()];
            bytes.extend(row.iter().flat_map(|value| value.to_le_bytes()));
        }
    }
    for triangle in &mesh.triangles {
        bytes.push(3);
        bytes.extend(triangle.iter().flat_map(|corner| corner.to_le_bytes()));
    }
    bytes
}

#[derive(Default)]
struct Vertex {
    position: Vec3,
    normal: Vec3,
    uv: Vec2,
    second_uv: Vec2,
    color: Vec4,
    tangent: Vec4,
}

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Vertex::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let target = match name {
            "x" => &mut self.position.x,
            "y" => &mut self.position.y,
            "z" => &mut self.position.z,
            "nx" => &mut self.normal.x,
            "ny" => &mut self.normal.y,
            "nz" => &mut self.normal.z,
            "u" | "s" | "texture_u" => &mut self.uv.x,
            "v" | "t" | "texture_v" => &mut self.uv.y,
            "u1" => &mut self.second_uv.x,
            "v1" => &mut self.second_uv.y,
            "r" => &mut self.color.x,
            "g" => &mut self.color.y,
            "b" => &mut self.color.z,
            "a" => &mut self.color.w,
            "tx" => &mut self.tangent.x,
            "ty" => &mut self.tangent.y,
            "tz" => &mut self.tangent.z,
            "tw" => &mut self.tangent.w,
            _ => return PropertyAccessResult::Ignored,
        };
        match property.to_f32_lossy() {
            Some(number) => {
                *target = number;
                PropertyAccessResult::Set
            }
            None => PropertyAccessResult::UnsupportedType,
        }
    }
}

#[derive(Default)]
struct Face {
    corners: Vec<u32>,
}

impl PropertyAccess for Face {
    fn new() -> Self {
        Face::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if !matches!(name, "vertex_indices" | "vertex_index") {
            return PropertyAccessResult::Ignored;
        }
        match property.to_u32_list() {
            Some(corners) => {
                self.corners = corners;
                PropertyAccessResult::Set
            }
            None => PropertyAccessResult::UnsupportedType,
        }
    }
}

/// An element that a mesh has no use for.
struct Other;

impl PropertyAccess for Other {
    fn new() -> Self {
        Other
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limits::{Budget, Limits};

    fn read_with(bytes: &[u8], limits: &Limits) -> Result<TriangleMesh, Problem> {
        let mut budgets = Budgets {
            pixels: Budget::new("image_pixels", limits.image_pixels),
            vertices: Budget::new("vertices", limits.vertices),
            triangles: Budget::new("triangles", limits.triangles),
        };
        read(bytes, &mut budgets)
    }

    const HEADER: &str = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\n\
        element face 1\nproperty list uchar int vertex_indices\nend_header\n";

    fn ascii() -> Vec<u8> {
        format!("ply\nformat ascii 1.0\ncomment a square\n{HEADER}0 0 0 9\n1 0 0 9\n1 1 0 9\n0 1 0.5 9\n4 0 1 2 3\n")
            .into()
    }

    fn binary(order: &str, number: fn(f32) -> [u8; 4], index: fn(i32) -> [u8; 4]) -> Vec<u8> {
        let mut bytes = format!("ply\nformat binary_{order}_endian 1.0\n{HEADER}").into_bytes();
        for position in [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.5]] {
            position.into_iter().for_each(|x| bytes.extend(number(x)));
            bytes.push(9);
        }
        bytes.push(4);
        (0..4).for_each(|corner| bytes.extend(index(corner)));
        bytes
    }

    #[test]
    fn all_three_encodings_hold_the_same_square() {
        let little = binary("little", f32::to_le_bytes, i32::to_le_bytes);
        let big = binary("big", f32::to_be_bytes, i32::to_be_bytes);
        for bytes in [ascii(), little, big] {
            let mesh = read_with(&bytes, &Limits::DEFAULT).expect("it reads");
            assert_eq!(mesh.positions, [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::new(0.0, 1.0, 0.5)]);
            assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
            assert!(mesh.normals.is_empty() && mesh.uvs.is_empty());
        }
    }

    #[test]
    fn normals_and_texture_coordinates_are_read_if_declared() {
        let text = "ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\nproperty double y\nproperty double z\n\
            property float nx\nproperty float ny\nproperty float nz\nproperty float s\nproperty float t\n\
            element face 1\nproperty list uchar uint vertex_index\nend_header\n\
            0 0 0 0 0 1 0 0\n1 0 0 0 0 1 1 0\n0 1 0 0 0 1 0 1\n3 0 1 2\n";
        let mesh = read_with(text.as_bytes(), &Limits::DEFAULT).expect("it reads");
        assert_eq!(mesh.normals, [Vec3::Z; 3]);
        assert_eq!(mesh.uvs, [Vec2::ZERO, Vec2::X, Vec2::Y]);
    }

    #[test]
    fn what_is_written_is_read_back_to_the_bit() {
        let (third, tiny) = (1.0 / 3.0, f32::MIN_POSITIVE / 3.0);
        let mut mesh = TriangleMesh {
            positions: vec![Vec3::new(third, -0.0, tiny), Vec3::X, Vec3::Y],
            triangles: vec![[0, 1, 2], [2, 1, 0]],
            ..TriangleMesh::default()
        };
        let again = |mesh: &TriangleMesh| read_with(&write(mesh), &Limits::DEFAULT).expect("it reads");
        assert_eq!(again(&mesh), mesh);
        mesh.normals = vec![Vec3::Z; 3];
        mesh.uvs = vec![Vec2::new(third, 2.0); 3];
        mesh.second_uvs = vec![Vec2::new(-third, 3.0); 3];
        mesh.colors = vec![Vec4::new(third, 0.5, 2.0, 0.25); 3];
        mesh.tangents = vec![Vec4::new(1.0, third, 0.0, -1.0); 3];
        assert_eq!(again(&mesh), mesh);
        assert!(again(&mesh).positions[0].y.is_sign_negative());
    }

    #[test]
    fn broken_files_are_errors_before_memory_is_taken() {
        let few = Limits { vertices: 3, triangles: 1, ..Limits::DEFAULT };
        let replace = |from: &str, to: &str| String::from_utf8(ascii()).expect("it is text").replace(from, to);
        for (limits, text, message) in [
            (&few, replace("", ""), "the mesh has too many vertices: limit `vertices` is 3"),
            (
                &Limits { vertices: 4, ..few },
                replace("", ""),
                "the mesh has too many triangles: limit `triangles` is 1",
            ),
            (
                &Limits::DEFAULT,
                replace("vertex 4", "vertex 60000000"),
                "the header promises at least 480000002 bytes, the file has 44",
            ),
            (
                &Limits::DEFAULT,
                replace("element face", "element void 4000000000\nelement face"),
                "the element `void` has no properties",
            ),
            (&Limits::DEFAULT, replace("4 0 1 2 3", "2 0 1        "), "face 0 has 2 corners, not three or more"),
        ] {
            assert_eq!(read_with(text.as_bytes(), limits).expect_err(message).message, message);
        }
        for text in
            [replace("ply", "plx"), replace("0.5", "x"), replace("4 0 1 2 3", "4 0 -1 2 3"), replace("end_header", "")]
        {
            let problem = read_with(text.as_bytes(), &Limits::DEFAULT).expect_err(&text);
            assert!(problem.message.starts_with("this PLY file cannot be read: "), "{}", problem.message);
            assert!(!problem.message.contains('\n') && problem.place.is_some(), "{problem:?}");
        }
    }
}
