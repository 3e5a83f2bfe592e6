//! `KHR_materials_anisotropy`: facets that are wider in one direction.

use brewster_world::components::Principled;
use brewster_world::components::parts::Encoding;
use serde::Deserialize;

use super::super::Found;
use super::super::materials::{Reader, unit};
use super::super::textures::Info;

#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct Extension {
    anisotropy_strength: f32,
    anisotropy_rotation: f32,
    anisotropy_texture: Option<Info>,
}

impl Default for Extension {
    fn default() -> Self {
        Extension { anisotropy_strength: 0.0, anisotropy_rotation: 0.0, anisotropy_texture: None }
    }
}

/// Writes what the extension says into a material.
pub(in crate::gltf) fn apply(reader: &mut Reader, material: &mut Principled) -> Found<()> {
    let Some((found, path)) = reader.extension::<Extension>("KHR_materials_anisotropy")? else { return Ok(()) };
    material.anisotropy.strength = unit(found.anisotropy_strength);
    material.anisotropy.rotation = found.anisotropy_rotation;
    if let Some(info) = &found.anisotropy_texture {
        let path = format!("{path}.anisotropyTexture");
        material.anisotropy.texture = reader.texture(info, Encoding::Linear, &path)?;
    }
    Ok(())
}
