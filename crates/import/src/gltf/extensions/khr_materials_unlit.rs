//! `KHR_materials_unlit`: a picture and no surface.

use brewster_world::components::Principled;
use serde::Deserialize;

use super::super::Found;
use super::super::materials::Reader;

#[derive(Deserialize)]
struct Extension {}

/// Writes what the extension says into a material.
pub(in crate::gltf) fn apply(reader: &mut Reader, material: &mut Principled) -> Found<()> {
    material.unlit = reader.extension::<Extension>("KHR_materials_unlit")?.is_some();
    Ok(())
}
