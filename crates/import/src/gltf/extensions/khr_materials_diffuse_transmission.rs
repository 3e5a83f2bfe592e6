//! `KHR_materials_diffuse_transmission`: diffuse light on the far side.

use brewster_world::components::Principled;
use brewster_world::components::parts::Channel;

use super::super::Found;
use super::super::materials::{Reader, unit};

/// Writes what the extension says into a material.
pub(in crate::gltf) fn apply(reader: &mut Reader, material: &mut Principled) -> Found<()> {
    let Some(found) = reader.extension("KHR_materials_diffuse_transmission")? else { return Ok(()) };
    let (weight, texture) = (("diffuseTransmissionFactor", 0.0), ("diffuseTransmissionTexture", Channel::A));
    material.diffuse_transmission = reader.scalar(&found, weight, texture)?;
    let color = found.get("diffuseTransmissionColorFactor", [1.0; 3])?.map(unit);
    material.diffuse_transmission_color = reader.color(&found, color, "diffuseTransmissionColorTexture")?;
    Ok(())
}
