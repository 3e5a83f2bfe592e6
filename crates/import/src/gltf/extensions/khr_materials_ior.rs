//! `KHR_materials_ior`: the index of refraction; 0 stands for infinity.

use brewster_world::components::Principled;

use super::super::materials::Reader;
use super::super::{Found, broken};

/// Writes what the extension says into a material.
pub(in crate::gltf) fn apply(reader: &mut Reader, material: &mut Principled) -> Found<()> {
    let Some(found) = reader.extension("KHR_materials_ior")? else { return Ok(()) };
    material.ior = match found.get("ior", 1.5f32)? {
        0.0 => 0.0,
        ior if ior >= 1.0 && ior.is_finite() => ior,
        ior => {
            let problem = broken(found.path_of("ior"), format!("the index of refraction is {ior}"));
            return Err(problem.expected("1 or more, or 0").into());
        }
    };
    Ok(())
}
