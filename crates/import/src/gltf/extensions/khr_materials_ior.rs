//! `KHR_materials_ior`: the index of refraction; 0 stands for infinity.

use brewster_world::components::Principled;
use serde::Deserialize;

use super::super::materials::Reader;
use super::super::{Found, broken};

#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct Extension {
    ior: f32,
}

impl Default for Extension {
    fn default() -> Self {
        Extension { ior: 1.5 }
    }
}

/// Writes what the extension says into a material.
pub(in crate::gltf) fn apply(reader: &mut Reader, material: &mut Principled) -> Found<()> {
    let Some((found, path)) = reader.extension::<Extension>("KHR_materials_ior")? else { return Ok(()) };
    material.ior = match found.ior {
        0.0 => 0.0,
        ior if ior >= 1.0 && ior.is_finite() => ior,
        ior => {
            let problem = broken(format!("{path}.ior"), format!("the index of refraction is {ior}"));
            return Err(problem.expected("1 or more, or 0").into());
        }
    };
    Ok(())
}
