//! `KHR_materials_anisotropy`: facets that are wider in one direction.

use brewster_world::components::Principled;
use brewster_world::components::parts::Encoding;

use super::super::Found;
use super::super::materials::{Reader, unit};

/// Writes what the extension says into a material.
pub(in crate::gltf) fn apply(reader: &mut Reader, material: &mut Principled) -> Found<()> {
    let Some(found) = reader.extension("KHR_materials_anisotropy")? else { return Ok(()) };
    material.anisotropy.strength = unit(found.get("anisotropyStrength", 0.0)?);
    material.anisotropy.rotation = found.get("anisotropyRotation", 0.0)?;
    material.anisotropy.texture = reader.texture(&found, "anisotropyTexture", Encoding::Linear)?;
    Ok(())
}
