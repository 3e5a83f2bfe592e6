//! `KHR_materials_transmission`: light that passes the surface.

use brewster_world::components::Principled;
use brewster_world::components::parts::Channel;

use super::super::Found;
use super::super::materials::Reader;

/// Writes what the extension says into a material.
pub(in crate::gltf) fn apply(reader: &mut Reader, material: &mut Principled) -> Found<()> {
    let Some(found) = reader.extension("KHR_materials_transmission")? else { return Ok(()) };
    let texture = ("transmissionTexture", Channel::R);
    material.transmission = reader.scalar(&found, ("transmissionFactor", 0.0), texture)?;
    Ok(())
}
