//! Skins: where the joints take a mesh.

use glam::{Affine3A, Mat3A, Vec3A};
use gltf::json::{Index, Skin};

use super::document::Document;
use super::{Found, broken};

/// From the mesh's space to the world's by way of each joint: its place in the world after the inverse of its place when the
/// mesh was bound to it. The place of the mesh's own node does not count.
pub(super) fn joints(document: &Document, skin: Index<Skin>, places: &[Affine3A]) -> Found<Vec<Affine3A>> {
    let path = format!("skins[{}].inverseBindMatrices", skin.value());
    let skin = &document.root.skins[skin.value()];
    let places = skin.joints.iter().map(|joint| places[joint.value()]);
    let Some(index) = skin.inverse_bind_matrices else { return Ok(places.collect()) };
    let matrices = document.gather(index, &path)?.floats::<16>(&path)?;
    if matrices.len() < skin.joints.len() {
        let message = format!("there are {} matrices for {} joints", matrices.len(), skin.joints.len());
        return Err(broken(path, message).into());
    }
    Ok(places.zip(&matrices).map(|(place, matrix)| place * affine(matrix)).collect())
}

/// A matrix in glTF's order, column by column. Its last row is taken for 0, 0, 0, 1.
pub(super) fn affine(matrix: &[f32; 16]) -> Affine3A {
    let column = |start: usize| Vec3A::new(matrix[start], matrix[start + 1], matrix[start + 2]);
    Affine3A { matrix3: Mat3A::from_cols(column(0), column(4), column(8)), translation: column(12) }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use brewster_world::components::Shape;
    use glam::Vec3;

    use super::*;
    use crate::gltf::testing::{Builder, load};
    use crate::limits::Limits;
    use crate::scene::Part;

    /// Where the first corner of every mesh stands, 1 along each axis in the mesh, in the order of their rows: of a triangle that
    /// follows the joint `nodes[0]`. `nodes` are the others; `INSTANCES` in them are two, moved and the second doubled.
    fn corners(nodes: &str) -> Vec<Vec3> {
        let mut builder = Builder::default();
        let positions = builder.floats(&[1.0, 1.0, 1.0, 2.0, 1.0, 1.0, 1.0, 2.0, 1.0], "VEC3");
        let weights = builder.floats(&[1.0, 0.0, 0.0, 0.0].repeat(3), "VEC4");
        let joints = builder.view(&[0; 12], None);
        let joints = builder.accessor(joints, 0, 5121, 3, "VEC4");
        let moved = builder.floats(&[1.0, 0.0, 0.0, 0.0, 2.0, 0.0], "VEC3");
        let doubled = builder.floats(&[1.0, 1.0, 1.0, 2.0, 2.0, 2.0], "VEC3");
        let instances = format!(
            r#""extensions":{{"EXT_mesh_gpu_instancing":{{"attributes":{{"TRANSLATION":{moved},"SCALE":{doubled}}}}}}}"#
        );
        builder.rest = format!(
            r#","nodes":[{{"translation":[0,0,3]}},{}],"skins":[{{"joints":[0]}}],"meshes":[{{"primitives":[
            {{"attributes":{{"POSITION":{positions},"JOINTS_0":{joints},"WEIGHTS_0":{weights}}}}}]}}]"#,
            nodes.replace("INSTANCES", &instances)
        );
        let rows = load(&builder, Limits::DEFAULT).unwrap_or_else(|said| panic!("{said}")).rows;
        let mut places: BTreeMap<u32, Affine3A> = BTreeMap::new();
        let mut found = Vec::new();
        for (at, row) in rows.iter().enumerate() {
            let above = row.parent.map_or(Affine3A::IDENTITY, |parent| places[&parent]);
            let place = above * row.transform.unwrap_or(Affine3A::IDENTITY);
            places.insert(at as u32, place);
            if let Part::Own(shape) = &row.shape
                && let Shape::Mesh(mesh) = &**shape
            {
                found.push(place.transform_point3(mesh.positions[0]));
            }
        }
        found
    }

    /// glTF 2.0, 3.7.3.3: "Only the joint transforms are applied to the skinned mesh; the transform of the skinned mesh node MUST be
    /// ignored." So it is whatever that is, and whatever those above it are.
    #[test]
    fn the_place_of_a_node_with_a_skin_does_not_count() {
        for nodes in [
            r#"{"mesh":0,"skin":0}"#,
            r#"{"mesh":0,"skin":0,"translation":[5,0,0],"scale":[2,2,2]}"#,
            r#"{"mesh":0,"skin":0,"scale":[0,0,0]}"#,
            r#"{"mesh":0,"skin":0,"scale":[1,0,1],"children":[2]},{"mesh":0}"#,
            r#"{"scale":[0,0,0],"children":[2]},{"children":[3]},{"mesh":0,"skin":0,"translation":[5,0,0]}"#,
        ] {
            assert_eq!(corners(nodes), [Vec3::new(1.0, 1.0, 4.0)], "{nodes}");
        }
        let hidden = r#"{"extensions":{"KHR_node_visibility":{"visible":false}},"children":[2]},{"mesh":0,"skin":0}"#;
        assert_eq!(corners(hidden), []);
    }

    /// `EXT_mesh_gpu_instancing`: WorldPosition = NodeWorldXform * InstanceXform * VertexPosition, with T * R * S for the instance. Of a
    /// skin the node's part does not count, and the vertex is where its joint puts it, (1, 1, 4).
    #[test]
    fn instances_move_what_joints_have_bent() {
        let expected = [Vec3::new(2.0, 1.0, 4.0), Vec3::new(2.0, 4.0, 8.0)];
        for place in ["", r#","translation":[5,0,0]"#, r#","scale":[0,0,0]"#] {
            assert_eq!(corners(&format!(r#"{{"mesh":0,"skin":0{place},INSTANCES}}"#)), expected, "{place}");
        }
        let stiff = [Vec3::new(7.0, 1.0, 1.0), Vec3::new(7.0, 4.0, 2.0)];
        assert_eq!(corners(r#"{"mesh":0,"translation":[5,0,0],INSTANCES}"#), stiff);
    }
}
