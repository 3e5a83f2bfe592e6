//! `KHR_draco_mesh_compression`: the attributes and indices of a primitive in one compressed stream.

use std::collections::BTreeMap;

use draco_gltf::{DracoPrimitiveContract, DracoPrimitiveExtension, JsonValue};
use gltf::json::Index;
use gltf::json::accessor::{ComponentType, Type};
use gltf::json::mesh::{Mode, Primitive};
use gltf::json::validation::Checked;
use serde::Deserialize;

use super::super::accessors::Gathered;
use super::super::document::Document;
use super::super::{Found, broken};

const NAME: &str = "KHR_draco_mesh_compression";

/// Vertices that a byte of the stream may stand for: a flat grid takes a fraction of a bit for each.
const VERTICES_PER_BYTE: u64 = 256;

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Compressed {
    buffer_view: u32,
    attributes: BTreeMap<String, u32>,
}

/// What came out of a stream.
pub(in crate::gltf) struct Decoded {
    /// By semantic.
    pub attributes: BTreeMap<String, Gathered>,
    /// Three for each triangle.
    pub indices: Vec<u32>,
}

/// The attributes and indices of a primitive, if they are compressed.
pub(in crate::gltf) fn decode(document: &Document, primitive: &Primitive, path: &str) -> Found<Option<Decoded>> {
    let Some(compressed) = super::read::<Compressed>(super::others!(primitive), NAME, path)? else { return Ok(None) };
    let path = format!("{path}.extensions.{NAME}");
    let root = &document.root;
    if compressed.buffer_view as usize >= root.buffer_views.len() {
        let message = format!("there is no bufferViews[{}]", compressed.buffer_view);
        return Err(broken(format!("{path}.bufferView"), message).into());
    }
    let payload = document.view(Index::new(compressed.buffer_view), &path)?;
    let most = VERTICES_PER_BYTE * payload.len() as u64;
    let mut contract = DracoPrimitiveContract::new();
    for (semantic, index) in &primitive.attributes {
        let accessor = &root.accessors[index.value()];
        if accessor.count.0 > most {
            let message = format!("{} vertices cannot come out of {} bytes", accessor.count.0, payload.len());
            return Err(broken(format!("accessors[{}].count", index.value()), message).into());
        }
        contract = contract.with_attribute(semantic.to_string(), accessor.count.0, accessor.normalized);
    }
    if let (Some(indices), Checked::Valid(Mode::Triangles)) = (primitive.indices, primitive.mode) {
        contract = contract.with_indices(root.accessors[indices.value()].count.0);
    }
    let attributes =
        compressed.attributes.iter().map(|(name, &id)| (name.clone(), JsonValue::from(u64::from(id)))).collect();
    let json = JsonValue::object([
        ("bufferView", JsonValue::from(u64::from(compressed.buffer_view))),
        ("attributes", JsonValue::Object(attributes)),
    ]);
    let geometry = DracoPrimitiveExtension::from_json(&json).and_then(|stream| stream.decode(payload, &contract));
    let geometry = geometry.map_err(|error| broken(path.clone(), format!("the stream cannot be decoded: {error}")))?;
    let mut attributes = BTreeMap::new();
    for attribute in geometry.attributes() {
        attributes.insert(attribute.semantic().to_owned(), gathered(attribute, &path)?);
    }
    let indices = geometry.indices().ok_or_else(|| broken(path, "the stream holds no triangles"))?;
    let (words, _) = indices.bytes().as_chunks();
    Ok(Some(Decoded { attributes, indices: words.iter().map(|&word| u32::from_le_bytes(word)).collect() }))
}

fn gathered(attribute: &draco_gltf::PackedAttribute, path: &str) -> Found<Gathered> {
    use draco_gltf::ComponentType as Packed;
    let component = match attribute.component_type() {
        Packed::I8 => ComponentType::I8,
        Packed::U8 => ComponentType::U8,
        Packed::I16 => ComponentType::I16,
        Packed::U16 => ComponentType::U16,
        Packed::U32 => ComponentType::U32,
        Packed::F32 => ComponentType::F32,
        other => return Err(broken(path, format!("the stream holds numbers of the kind {other:?}")).into()),
    };
    let kind = match attribute.components() {
        1 => Type::Scalar,
        2 => Type::Vec2,
        3 => Type::Vec3,
        4 => Type::Vec4,
        other => return Err(broken(path, format!("the stream holds rows of {other} numbers")).into()),
    };
    let (count, normalized) = (attribute.count(), attribute.normalized());
    Ok(Gathered { bytes: attribute.bytes().to_vec(), component, kind, normalized, count })
}
