//! `KHR_materials_clearcoat`: a layer of varnish.

use brewster_world::components::Principled;
use brewster_world::components::parts::Channel;

use super::super::Found;
use super::super::materials::Reader;

/// Writes what the extension says into a material.
pub(in crate::gltf) fn apply(reader: &mut Reader, material: &mut Principled) -> Found<()> {
    let Some(found) = reader.extension("KHR_materials_clearcoat")? else { return Ok(()) };
    let (weight, roughness) = (("clearcoatFactor", 0.0), ("clearcoatRoughnessFactor", 0.0));
    material.clearcoat = reader.scalar(&found, weight, ("clearcoatTexture", Channel::R))?;
    material.clearcoat_roughness = reader.scalar(&found, roughness, ("clearcoatRoughnessTexture", Channel::G))?;
    material.clearcoat_normal = reader.normal(&found, "clearcoatNormalTexture")?;
    Ok(())
}
