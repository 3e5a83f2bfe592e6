//! `KHR_materials_iridescence`: a thin film.

use brewster_world::components::Principled;
use brewster_world::components::parts::Channel;
use serde::Deserialize;

use super::super::Found;
use super::super::materials::{Reader, unit};
use super::super::textures::Info;

#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct Extension {
    iridescence_factor: f32,
    iridescence_texture: Option<Info>,
    iridescence_ior: f32,
    iridescence_thickness_minimum: f32,
    iridescence_thickness_maximum: f32,
    iridescence_thickness_texture: Option<Info>,
}

impl Default for Extension {
    fn default() -> Self {
        Extension {
            iridescence_factor: 0.0,
            iridescence_texture: None,
            iridescence_ior: 1.3,
            iridescence_thickness_minimum: 100.0,
            iridescence_thickness_maximum: 400.0,
            iridescence_thickness_texture: None,
        }
    }
}

/// Writes what the extension says into a material.
pub(in crate::gltf) fn apply(reader: &mut Reader, material: &mut Principled) -> Found<()> {
    let Some((found, path)) = reader.extension::<Extension>("KHR_materials_iridescence")? else { return Ok(()) };
    let film = &mut material.iridescence;
    let weight = &found.iridescence_texture;
    film.factor =
        reader.scalar(unit(found.iridescence_factor), weight, Channel::R, &format!("{path}.iridescenceTexture"))?;
    film.ior = found.iridescence_ior.clamp(1.0, 100.0);
    let ends = [found.iridescence_thickness_minimum, found.iridescence_thickness_maximum];
    film.thickness = ends.map(|thickness| thickness.clamp(0.0, 1e5));
    if let Some(info) = &found.iridescence_thickness_texture {
        let texture = reader.texture(
            info,
            brewster_world::components::parts::Encoding::Linear,
            &format!("{path}.iridescenceThicknessTexture"),
        )?;
        film.thickness_texture = texture.map(|texture| (texture, Channel::G));
    }
    Ok(())
}
