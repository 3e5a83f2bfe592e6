//! `KHR_materials_sheen`: the fibers of cloth.

use brewster_world::components::Principled;
use brewster_world::components::parts::Channel;

use super::super::Found;
use super::super::materials::{Reader, unit};

/// Writes what the extension says into a material.
pub(in crate::gltf) fn apply(reader: &mut Reader, material: &mut Principled) -> Found<()> {
    let Some(found) = reader.extension("KHR_materials_sheen")? else { return Ok(()) };
    let color = found.get("sheenColorFactor", [0.0; 3])?.map(unit);
    material.sheen_color = reader.color(&found, color, "sheenColorTexture")?;
    let texture = ("sheenRoughnessTexture", Channel::A);
    material.sheen_roughness = reader.scalar(&found, ("sheenRoughnessFactor", 0.0), texture)?;
    Ok(())
}
