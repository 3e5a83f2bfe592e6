//! `KHR_materials_dispersion`: an index of refraction that depends on the wavelength.

use brewster_world::components::Principled;
use serde::Deserialize;

use super::super::Found;
use super::super::materials::Reader;

#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct Extension {
    dispersion: f32,
}

impl Default for Extension {
    fn default() -> Self {
        Extension { dispersion: 0.0 }
    }
}

/// Writes what the extension says into a material.
pub(in crate::gltf) fn apply(reader: &mut Reader, material: &mut Principled) -> Found<()> {
    let Some((found, _)) = reader.extension::<Extension>("KHR_materials_dispersion")? else { return Ok(()) };
    material.dispersion = found.dispersion.clamp(0.0, 100.0);
    Ok(())
}
