//! `KHR_materials_dispersion`: an index of refraction that depends on the wavelength.

use brewster_world::components::Principled;

use super::super::Found;
use super::super::materials::Reader;

/// Writes what the extension says into a material.
pub(in crate::gltf) fn apply(reader: &mut Reader, material: &mut Principled) -> Found<()> {
    let Some(found) = reader.extension("KHR_materials_dispersion")? else { return Ok(()) };
    material.dispersion = found.get("dispersion", 0.0f32)?.clamp(0.0, 100.0);
    Ok(())
}
