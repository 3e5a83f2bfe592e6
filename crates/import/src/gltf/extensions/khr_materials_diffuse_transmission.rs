//! `KHR_materials_diffuse_transmission`: diffuse light on the far side.

use brewster_world::components::Principled;
use brewster_world::components::parts::{Channel, Encoding};
use serde::Deserialize;

use super::super::Found;
use super::super::materials::{Reader, unit};
use super::super::textures::Info;

#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct Extension {
    diffuse_transmission_factor: f32,
    diffuse_transmission_texture: Option<Info>,
    diffuse_transmission_color_factor: [f32; 3],
    diffuse_transmission_color_texture: Option<Info>,
}

impl Default for Extension {
    fn default() -> Self {
        Extension {
            diffuse_transmission_factor: 0.0,
            diffuse_transmission_texture: None,
            diffuse_transmission_color_factor: [1.0; 3],
            diffuse_transmission_color_texture: None,
        }
    }
}

/// Writes what the extension says into a material.
pub(in crate::gltf) fn apply(reader: &mut Reader, material: &mut Principled) -> Found<()> {
    let Some((found, path)) = reader.extension::<Extension>("KHR_materials_diffuse_transmission")? else {
        return Ok(());
    };
    let (weight, color) = (&found.diffuse_transmission_texture, &found.diffuse_transmission_color_texture);
    let at_weight = format!("{path}.diffuseTransmissionTexture");
    let at_color = format!("{path}.diffuseTransmissionColorTexture");
    let factor = unit(found.diffuse_transmission_factor);
    material.diffuse_transmission = reader.scalar(factor, weight, Channel::A, &at_weight)?;
    let factor = found.diffuse_transmission_color_factor.map(unit);
    material.diffuse_transmission_color = reader.color(factor, color, Encoding::Srgb, &at_color)?;
    Ok(())
}
