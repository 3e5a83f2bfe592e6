//! `KHR_materials_sheen`: the fibers of cloth.

use brewster_world::components::Principled;
use brewster_world::components::parts::{Channel, Encoding};
use serde::Deserialize;

use super::super::Found;
use super::super::materials::{Reader, unit};
use super::super::textures::Info;

#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct Extension {
    sheen_color_factor: [f32; 3],
    sheen_color_texture: Option<Info>,
    sheen_roughness_factor: f32,
    sheen_roughness_texture: Option<Info>,
}

impl Default for Extension {
    fn default() -> Self {
        Extension {
            sheen_color_factor: [0.0; 3],
            sheen_color_texture: None,
            sheen_roughness_factor: 0.0,
            sheen_roughness_texture: None,
        }
    }
}

/// Writes what the extension says into a material.
pub(in crate::gltf) fn apply(reader: &mut Reader, material: &mut Principled) -> Found<()> {
    let Some((found, path)) = reader.extension::<Extension>("KHR_materials_sheen")? else { return Ok(()) };
    let (color, roughness) = (&found.sheen_color_texture, &found.sheen_roughness_texture);
    let (at_color, at_roughness) = (format!("{path}.sheenColorTexture"), format!("{path}.sheenRoughnessTexture"));
    let factor = found.sheen_color_factor.map(unit);
    material.sheen_color = reader.color(factor, color, Encoding::Srgb, &at_color)?;
    let factor = unit(found.sheen_roughness_factor);
    material.sheen_roughness = reader.scalar(factor, roughness, Channel::A, &at_roughness)?;
    Ok(())
}
