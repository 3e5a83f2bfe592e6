//! `KHR_materials_volume_scatter`: an inside that scatters. Of what KHR_materials_volume says is lost on the way, the part
//! that is scattered follows from the color that the many times scattered light has.

use brewster_world::components::Principled;
use glam::Vec3;
use serde::Deserialize;

use super::super::materials::{Reader, unit};
use super::super::{Found, broken};

#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct Extension {
    multiscatter_color: [f32; 3],
    scatter_anisotropy: f32,
}

impl Default for Extension {
    fn default() -> Self {
        Extension { multiscatter_color: [0.0; 3], scatter_anisotropy: 0.0 }
    }
}

/// Writes what the extension says into a material that has a volume.
pub(in crate::gltf) fn apply(reader: &mut Reader, material: &mut Principled) -> Found<()> {
    let Some((found, path)) = reader.extension::<Extension>("KHR_materials_volume_scatter")? else { return Ok(()) };
    if !(-1.0..=1.0).contains(&found.scatter_anisotropy) {
        let problem = broken(format!("{path}.scatterAnisotropy"), "a mean cosine that is none");
        return Err(problem.expected("a number above -1 and below 1").into());
    }
    if let Some(volume) = &mut material.volume {
        volume.multiscatter_color = Vec3::from_array(found.multiscatter_color.map(unit));
        // The ends would be light that is not scattered at all.
        volume.anisotropy = found.scatter_anisotropy.clamp(-MOST, MOST);
    }
    Ok(())
}

/// The most that light is scattered forward or back.
const MOST: f32 = 0.999;
