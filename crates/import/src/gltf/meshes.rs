//! Primitives to triangles.
//!
//! | where the specification leaves a choice | what is done |
//! | --- | --- |
//! | points and lines have no area | they are left out, with a warning |
//! | a primitive without normals | flat, by the triangles' own normals |
//! | a normal of no length | that of a triangle that the vertex belongs to |
//! | a vertex that joints move with weights whose sum is not 1 | the weights are scaled; without any, it stays |
//! | a mesh that joints mirror | its triangles are still seen from their fronts, whatever the transform of its node |
//! | a morphed mesh whose targets have no normals or tangents | those of the base |

use std::borrow::Cow;
use std::collections::BTreeMap;

use brewster_world::components::parts::TriangleMesh;
use glam::{Affine3A, Mat3A, Vec3, Vec3A, Vec4};
use gltf::json::accessor::Type;
use gltf::json::mesh::{Mode, MorphTarget, Primitive, Semantic};
use gltf::json::validation::Checked;
use gltf::json::{Accessor, Index};

use super::accessors::Gathered;
use super::document::Document;
use super::extensions::khr_draco_mesh_compression as draco;
use super::{Found, Reporter, broken, tangents, too_much};
use crate::diagnostics::Code;
use crate::session::Budgets;

/// How a mesh is bent.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Pose<'p> {
    /// One for each morph target; those that are absent are 0.
    pub weights: &'p [f32],
    /// From the mesh's space to the world's, one for each joint; empty for a mesh without a skin.
    pub joints: &'p [Affine3A],
}

impl Pose<'_> {
    /// Whether it leaves a mesh as it is.
    pub(super) fn is_rest(&self) -> bool {
        self.joints.is_empty() && self.weights.iter().all(|&weight| weight == 0.0)
    }
}

/// What a primitive's material needs of it beside its shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Tangents {
    /// Those of the file.
    AsTheyAre,
    /// Some, along the first texture coordinates or the second.
    Along(u32),
}

/// The triangles of a primitive; none if it has no area.
pub(super) fn read(
    document: &Document,
    budgets: &mut Budgets,
    reporter: &mut Reporter,
    primitive: &Primitive,
    path: &str,
    (pose, needed): (Pose, Tangents),
) -> Found<Option<TriangleMesh>> {
    let mode = primitive.mode.unwrap();
    if matches!(mode, Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip) {
        let what = if mode == Mode::Points { "points" } else { "lines" };
        reporter.warn(Code::Decision, format!("{path}.mode"), format!("{what} have no area, and are left out"));
        return Ok(None);
    }
    let source = Source::open(document, budgets, primitive, path)?;
    let positions: Vec<Vec3> = source.rows(Semantic::Positions)?;
    if positions.is_empty() {
        reporter.warn(Code::Gltf, format!("{path}.attributes"), "a primitive without `POSITION` is left out");
        return Ok(None);
    }
    let triangles = source.triangles(mode, positions.len())?;
    if triangles.is_empty() {
        reporter.warn(Code::Gltf, path, "a primitive without a triangle is left out");
        return Ok(None);
    }
    let taken = budgets.triangles.take(triangles.len() as u64);
    taken.map_err(|over| too_much(path, format!("the meshes have too many triangles: {over}")))?;
    let normals: Vec<Vec3> = source.rows(Semantic::Normals)?;
    // Tangents do not count without normals: glTF 2.0, 3.7.2.1.
    let tangents = if normals.is_empty() { Vec::new() } else { source.rows(Semantic::Tangents)? };
    let mut mesh = TriangleMesh {
        positions,
        normals,
        uvs: source.rows(Semantic::TexCoords(0))?,
        second_uvs: source.rows(Semantic::TexCoords(1))?,
        colors: source.colors()?,
        tangents,
        triangles,
    };
    if !pose.weights.is_empty() {
        morph(document, &mut mesh, primitive, path, pose.weights)?;
    }
    if !pose.joints.is_empty() {
        bend(&mut mesh, &source, path, pose.joints)?;
    }
    mend_normals(&mut mesh);
    // Last, since vertices with several tangents part.
    if let (Tangents::Along(set), true) = (needed, mesh.tangents.is_empty()) {
        tangents::add(&mut mesh, set > 0);
    }
    match mesh.validate() {
        Ok(()) => Ok(Some(mesh)),
        Err(error) => Err(broken(path, error.to_string()).into()),
    }
}

/// Where a primitive's numbers come from: accessors, or a compressed stream.
struct Source<'d> {
    document: &'d Document,
    primitive: &'d Primitive,
    path: &'d str,
    decoded: Option<draco::Decoded>,
    /// The number of vertices, that of the positions.
    vertices: Option<usize>,
}

impl<'d> Source<'d> {
    fn open(
        document: &'d Document,
        budgets: &mut Budgets,
        primitive: &'d Primitive,
        path: &'d str,
    ) -> Found<Source<'d>> {
        if let Some(index) = primitive.attributes.get(&Checked::Valid(Semantic::Positions)) {
            let stated = document.root.accessors[index.value()].count.0;
            let taken = budgets.vertices.take(stated);
            taken.map_err(|over| too_much(path, format!("the meshes have too many vertices: {over}")))?;
        }
        let decoded = draco::decode(document, primitive, path)?;
        let mut source = Source { document, primitive, path, decoded, vertices: None };
        source.vertices = source.gather(&Semantic::Positions)?.map(|positions| positions.count);
        Ok(source)
    }

    fn gather(&self, semantic: &Semantic) -> Found<Option<Gathered>> {
        let name = semantic.to_string();
        if let Some(decoded) = &self.decoded
            && let Some(attribute) = decoded.attributes.get(&name)
        {
            return Ok(Some(attribute.clone()));
        }
        let Some(&index) = self.primitive.attributes.get(&Checked::Valid(semantic.clone())) else { return Ok(None) };
        let path = format!("{}.attributes.{name}", self.path);
        let gathered = self.document.gather(index, &path)?;
        match self.vertices {
            Some(vertices) if vertices != gathered.count => {
                let message = format!("there are {} rows for {vertices} vertices", gathered.count);
                Err(broken(path, message).expected("as many rows as `POSITION` has").into())
            }
            _ => Ok(Some(gathered)),
        }
    }

    /// Rows of `N` numbers; none where the attribute is absent.
    fn rows<const N: usize, V: From<[f32; N]>>(&self, semantic: Semantic) -> Found<Vec<V>> {
        let Some(gathered) = self.gather(&semantic)? else { return Ok(Vec::new()) };
        let rows = gathered.floats(&format!("{}.attributes.{}", self.path, semantic.to_string()))?;
        Ok(rows.into_iter().map(V::from).collect())
    }

    /// The first colors, of three numbers or four.
    fn colors(&self) -> Found<Vec<Vec4>> {
        let Some(gathered) = self.gather(&Semantic::Colors(0))? else { return Ok(Vec::new()) };
        let path = format!("{}.attributes.COLOR_0", self.path);
        let rows: Vec<Vec4> = match gathered.kind {
            Type::Vec3 => gathered.floats(&path)?.into_iter().map(|row| Vec3::from_array(row).extend(1.0)).collect(),
            _ => gathered.floats(&path)?.into_iter().map(Vec4::from_array).collect(),
        };
        Ok(rows.into_iter().map(|color| color.max(Vec4::ZERO)).collect())
    }

    /// The corners of the triangles: of strips and fans in the order that makes all of them face the same way.
    fn triangles(&self, mode: Mode, vertices: usize) -> Found<Vec<[u32; 3]>> {
        let path = format!("{}.indices", self.path);
        let (mode, indices) = match (&self.decoded, self.primitive.indices) {
            // A stream holds triangles, whatever they were before.
            (Some(decoded), _) => (Mode::Triangles, Cow::Borrowed(&decoded.indices[..])),
            (None, Some(index)) => {
                let rows = self.document.gather(index, &path)?.integers::<1>(&path)?;
                (mode, Cow::Owned(rows.into_flattened()))
            }
            (None, None) => (mode, (0..vertices as u32).collect()),
        };
        let of_three = |at: usize| [indices[at], indices[at + 1], indices[at + 2]];
        let triangles: Vec<[u32; 3]> = match mode {
            Mode::TriangleStrip => (2..indices.len())
                .map(|last| {
                    let [a, b, c] = of_three(last - 2);
                    if last % 2 == 0 { [a, b, c] } else { [a, c, b] }
                })
                .collect(),
            Mode::TriangleFan => {
                (2..indices.len()).map(|last| [indices[last - 1], indices[last], indices[0]]).collect()
            }
            _ => indices.as_chunks().0.to_vec(),
        };
        match triangles.as_flattened().iter().find(|&&corner| corner as usize >= vertices) {
            None => Ok(triangles),
            Some(corner) => {
                let problem = broken(path, format!("there is no vertex {corner}"));
                Err(problem.expected(format!("0 to {}", vertices.saturating_sub(1))).into())
            }
        }
    }
}

/// Adds the morph targets, each as often as its weight says.
fn morph(
    document: &Document,
    mesh: &mut TriangleMesh,
    primitive: &Primitive,
    path: &str,
    weights: &[f32],
) -> Found<()> {
    let targets: &[MorphTarget] = primitive.targets.as_deref().unwrap_or_default();
    let vertices = mesh.positions.len();
    for (index, (target, &weight)) in targets.iter().zip(weights).enumerate() {
        if weight == 0.0 {
            continue;
        }
        let rows = |accessor: Option<Index<Accessor>>, name: &str| -> Found<Vec<Vec3>> {
            let Some(accessor) = accessor else { return Ok(Vec::new()) };
            let path = format!("{path}.targets[{index}].{name}");
            let rows = document.gather(accessor, &path)?.floats::<3>(&path)?;
            if rows.len() != vertices {
                return Err(broken(path, format!("there are {} rows for {vertices} vertices", rows.len())).into());
            }
            Ok(rows.into_iter().map(Vec3::from_array).collect())
        };
        for (to, row) in mesh.positions.iter_mut().zip(rows(target.positions, "POSITION")?) {
            *to += weight * row;
        }
        let normals = target.normals.filter(|_| !mesh.normals.is_empty());
        for (to, row) in mesh.normals.iter_mut().zip(rows(normals, "NORMAL")?) {
            *to += weight * row;
        }
        let tangents = target.tangents.filter(|_| !mesh.tangents.is_empty());
        for (to, row) in mesh.tangents.iter_mut().zip(rows(tangents, "TANGENT")?) {
            *to += (weight * row).extend(0.0);
        }
    }
    Ok(())
}

/// Moves every vertex by the mean of its joints' transforms, as much of each as its weight says.
fn bend(mesh: &mut TriangleMesh, source: &Source, path: &str, joints: &[Affine3A]) -> Found<()> {
    let mut sets = Vec::new();
    while let Some(of) = source.gather(&Semantic::Joints(sets.len() as u32))? {
        let set = sets.len();
        let here = format!("{path}.attributes.JOINTS_{set}");
        let rows = of.integers::<4>(&here)?;
        if let Some(joint) = rows.as_flattened().iter().find(|&&joint| joint as usize >= joints.len()) {
            let message = format!("there is no joint {joint}: the skin has {}", joints.len());
            return Err(broken(here, message).into());
        }
        let weights = source.rows::<4, [f32; 4]>(Semantic::Weights(set as u32))?;
        if weights.is_empty() {
            return Err(broken(here, format!("`WEIGHTS_{set}` is absent")).into());
        }
        sets.push((rows, weights));
    }
    let mut mirrored = vec![false; mesh.positions.len()];
    for vertex in 0..mesh.positions.len() {
        let (mut linear, mut translation, mut sum) = (Mat3A::ZERO, Vec3A::ZERO, 0.0);
        for (rows, weights) in &sets {
            for (&joint, &weight) in rows[vertex].iter().zip(&weights[vertex]) {
                if weight != 0.0 {
                    let joint = &joints[joint as usize];
                    linear += joint.matrix3 * weight;
                    translation += joint.translation * weight;
                    sum += weight;
                }
            }
        }
        if sum == 0.0 {
            continue;
        }
        let (linear, translation) = (linear * (1.0 / sum), translation / sum);
        mirrored[vertex] = linear.determinant() < 0.0;
        let side = if mirrored[vertex] { -1.0 } else { 1.0 };
        let position = &mut mesh.positions[vertex];
        *position = (linear * Vec3A::from(*position) + translation).into();
        if let Some(normal) = mesh.normals.get_mut(vertex) {
            *normal = (cofactors(linear) * Vec3A::from(*normal) * side).into();
        }
        if let Some(tangent) = mesh.tangents.get_mut(vertex) {
            *tangent = Vec3::from(linear * Vec3A::from(tangent.truncate())).extend(side * tangent.w);
        }
    }
    // What is mirrored is still seen from its front.
    for corners in mesh.triangles.iter_mut().filter(|corners| mirrored[corners[0] as usize]) {
        corners.swap(1, 2);
    }
    Ok(())
}

/// What takes normals along, up to a length: the inverse transposed times the determinant, which also is where there is no
/// inverse.
fn cofactors(matrix: Mat3A) -> Mat3A {
    let Mat3A { x_axis: x, y_axis: y, z_axis: z } = matrix;
    Mat3A::from_cols(y.cross(z), z.cross(x), x.cross(y))
}

/// Gives normals of no length, or of none that is a number, the direction of a triangle.
fn mend_normals(mesh: &mut TriangleMesh) {
    let is_sound = |normal: &Vec3| normal.is_finite() && normal.length_squared() > 1e-30;
    let wrong: Vec<usize> = (0..mesh.normals.len()).filter(|&row| !is_sound(&mesh.normals[row])).collect();
    if wrong.is_empty() {
        return;
    }
    let mut of_triangles: BTreeMap<u32, Vec3> = BTreeMap::new();
    for &corners in &mesh.triangles {
        let [a, b, c] = corners.map(|corner| mesh.positions[corner as usize]);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        for corner in corners {
            *of_triangles.entry(corner).or_default() += normal;
        }
    }
    for row in wrong {
        let normal = of_triangles.get(&(row as u32)).copied().unwrap_or_default();
        mesh.normals[row] = normal.try_normalize().unwrap_or(Vec3::Y);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gltf::testing::{Builder, load_mesh};

    /// A triangle with some attributes beside its positions, and more members of its primitive and mesh.
    fn triangle(builder: &mut Builder, attributes: &str, primitive: &str, mesh: &str) -> TriangleMesh {
        let positions = builder.floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0], "VEC3");
        builder.rest = format!(
            r#","nodes":[{{"mesh":0}}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":{positions}{attributes}}}{primitive}}}]{mesh}}}]"#
        );
        TriangleMesh::clone(&load_mesh(builder).0)
    }

    /// glTF 2.0, 3.7.2.2: targets displace positions, normals and tangents, these without their handedness.
    #[test]
    fn morph_targets_displace_all_that_they_name() {
        let mut builder = Builder::default();
        let normals = builder.floats(&[0.0, 0.0, 1.0].repeat(3), "VEC3");
        let tangents = builder.floats(&[1.0, 0.0, 0.0, -1.0].repeat(3), "VEC4");
        let moved = builder.floats(&[0.0, 2.0, 4.0].repeat(3), "VEC3");
        let found = triangle(
            &mut builder,
            &format!(r#","NORMAL":{normals},"TANGENT":{tangents}"#),
            &format!(r#","targets":[{{"POSITION":{moved},"NORMAL":{moved},"TANGENT":{moved}}}]"#),
            r#","weights":[0.5]"#,
        );
        assert_eq!(found.positions, [Vec3::new(0.0, 1.0, 2.0), Vec3::new(1.0, 1.0, 2.0), Vec3::new(0.0, 2.0, 2.0)]);
        assert_eq!(found.normals, [Vec3::new(0.0, 1.0, 3.0); 3]);
        assert_eq!(found.tangents, [Vec4::new(1.0, 1.0, 2.0, -1.0); 3]);
    }

    /// What joints mirror keeps its front, and v grows where it grew on it: along y, the cross product of z and -x times -1.
    #[test]
    fn mirrored_skins_keep_their_fronts() {
        let mut builder = Builder::default();
        let positions = builder.floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0], "VEC3");
        let normals = builder.floats(&[0.0, 0.0, 1.0].repeat(3), "VEC3");
        let tangents = builder.floats(&[1.0, 0.0, 0.0, 1.0].repeat(3), "VEC4");
        let weights = builder.floats(&[1.0, 0.0, 0.0, 0.0].repeat(3), "VEC4");
        let joints = builder.view(&[0; 12], None);
        let joints = builder.accessor(joints, 0, 5121, 3, "VEC4");
        builder.rest = format!(
            r#","nodes":[{{"scale":[-1,1,1],"children":[1]}},{{"mesh":0,"skin":0}}],"skins":[{{"joints":[0]}}],
            "meshes":[{{"primitives":[{{"attributes":{{"POSITION":{positions},"NORMAL":{normals},"TANGENT":{tangents},
            "JOINTS_0":{joints},"WEIGHTS_0":{weights}}}}}]}}]"#
        );
        let (mesh, _) = load_mesh(&builder);
        assert_eq!(mesh.positions, [Vec3::ZERO, Vec3::NEG_X, Vec3::Y]);
        assert_eq!((&mesh.normals[0], &mesh.tangents[0]), (&Vec3::Z, &Vec4::new(-1.0, 0.0, 0.0, -1.0)));
        let [a, b, c] = mesh.corners(0);
        assert_eq!((b - a).cross(c - a), Vec3::Z);
    }

    /// glTF 2.0, 3.7.2.1: without normals, provided tangents must be ignored.
    #[test]
    fn tangents_without_normals_do_not_count() {
        let mut builder = Builder::default();
        let tangents = builder.floats(&[1.0, 0.0, 0.0, 1.0].repeat(3), "VEC4");
        let found = triangle(&mut builder, &format!(r#","TANGENT":{tangents}"#), "", "");
        assert!(found.normals.is_empty() && found.tangents.is_empty(), "{found:?}");
    }
}
