//! `KHR_materials_transmission`: light that passes the surface.

use brewster_world::components::Principled;
use brewster_world::components::parts::Channel;
use serde::Deserialize;

use super::super::Found;
use super::super::materials::{Reader, unit};
use super::super::textures::Info;

#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct Extension {
    transmission_factor: f32,
    transmission_texture: Option<Info>,
}

impl Default for Extension {
    fn default() -> Self {
        Extension { transmission_factor: 0.0, transmission_texture: None }
    }
}

/// Writes what the extension says into a material.
pub(in crate::gltf) fn apply(reader: &mut Reader, material: &mut Principled) -> Found<()> {
    let Some((found, path)) = reader.extension::<Extension>("KHR_materials_transmission")? else { return Ok(()) };
    let path = format!("{path}.transmissionTexture");
    let factor = unit(found.transmission_factor);
    material.transmission = reader.scalar(factor, &found.transmission_texture, Channel::R, &path)?;
    Ok(())
}
