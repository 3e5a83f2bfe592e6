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
