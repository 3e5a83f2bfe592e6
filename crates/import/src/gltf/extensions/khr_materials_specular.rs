//! `KHR_materials_specular`: weight and tint of a dielectric's reflection.

use brewster_world::components::Principled;
use brewster_world::components::parts::{Channel, Encoding};
use serde::Deserialize;

use super::super::Found;
use super::super::materials::{Reader, unit};
use super::super::textures::Info;

#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct Extension {
    specular_factor: f32,
    specular_texture: Option<Info>,
    specular_color_factor: [f32; 3],
    specular_color_texture: Option<Info>,
}

impl Default for Extension {
    fn default() -> Self {
        Extension {
            specular_factor: 1.0,
            specular_texture: None,
            specular_color_factor: [1.0; 3],
            specular_color_texture: None,
        }
    }
}

/// Writes what the extension says into a material.
pub(in crate::gltf) fn apply(reader: &mut Reader, material: &mut Principled) -> Found<()> {
    let Some((found, path)) = reader.extension::<Extension>("KHR_materials_specular")? else { return Ok(()) };
    let (weight, color) = (&found.specular_texture, &found.specular_color_texture);
    let (at_weight, at_color) = (format!("{path}.specularTexture"), format!("{path}.specularColorTexture"));
    material.specular = reader.scalar(unit(found.specular_factor), weight, Channel::A, &at_weight)?;
    material.specular_color = reader.color(found.specular_color_factor, color, Encoding::Srgb, &at_color)?;
    Ok(())
}
