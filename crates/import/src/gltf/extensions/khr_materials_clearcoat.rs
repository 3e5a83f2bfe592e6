//! `KHR_materials_clearcoat`: a layer of varnish.

use brewster_world::components::parts::{Channel, Encoding};
use brewster_world::components::{NormalMap, Principled};
use serde::Deserialize;

use super::super::Found;
use super::super::materials::{Reader, unit};
use super::super::textures::Info;

#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct Extension {
    clearcoat_factor: f32,
    clearcoat_texture: Option<Info>,
    clearcoat_roughness_factor: f32,
    clearcoat_roughness_texture: Option<Info>,
    clearcoat_normal_texture: Option<Info>,
}

impl Default for Extension {
    fn default() -> Self {
        Extension {
            clearcoat_factor: 0.0,
            clearcoat_texture: None,
            clearcoat_roughness_factor: 0.0,
            clearcoat_roughness_texture: None,
            clearcoat_normal_texture: None,
        }
    }
}

/// Writes what the extension says into a material.
pub(in crate::gltf) fn apply(reader: &mut Reader, material: &mut Principled) -> Found<()> {
    let Some((found, path)) = reader.extension::<Extension>("KHR_materials_clearcoat")? else { return Ok(()) };
    let (weight, roughness) = (&found.clearcoat_texture, &found.clearcoat_roughness_texture);
    let (at_weight, at_roughness) = (format!("{path}.clearcoatTexture"), format!("{path}.clearcoatRoughnessTexture"));
    material.clearcoat = reader.scalar(unit(found.clearcoat_factor), weight, Channel::R, &at_weight)?;
    let factor = unit(found.clearcoat_roughness_factor);
    material.clearcoat_roughness = reader.scalar(factor, roughness, Channel::G, &at_roughness)?;
    if let Some(info) = &found.clearcoat_normal_texture {
        let texture = reader.texture(info, Encoding::Linear, &format!("{path}.clearcoatNormalTexture"))?;
        material.clearcoat_normal =
            texture.map(|texture| NormalMap { texture, scale: if info.scale.is_finite() { info.scale } else { 1.0 } });
    }
    Ok(())
}
