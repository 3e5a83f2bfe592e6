//! `KHR_materials_specular`: weight and tint of a dielectric's reflection.

use brewster_world::components::Principled;
use brewster_world::components::parts::Channel;

use super::super::Found;
use super::super::materials::Reader;

/// Writes what the extension says into a material.
pub(in crate::gltf) fn apply(reader: &mut Reader, material: &mut Principled) -> Found<()> {
    let Some(found) = reader.extension("KHR_materials_specular")? else { return Ok(()) };
    material.specular = reader.scalar(&found, ("specularFactor", 1.0), ("specularTexture", Channel::A))?;
    let color = found.get("specularColorFactor", [1.0; 3])?;
    material.specular_color = reader.color(&found, color, "specularColorTexture")?;
    Ok(())
}
