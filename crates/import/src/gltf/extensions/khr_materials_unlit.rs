//! `KHR_materials_unlit`: a picture and no surface.

use brewster_world::components::Principled;

use super::super::Found;
use super::super::materials::Reader;

/// Writes what the extension says into a material.
pub(in crate::gltf) fn apply(reader: &mut Reader, material: &mut Principled) -> Found<()> {
    material.unlit = reader.extension("KHR_materials_unlit")?.is_some();
    Ok(())
}
