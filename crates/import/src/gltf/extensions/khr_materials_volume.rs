//! `KHR_materials_volume`: the inside of a closed surface. Light is traced through it, so the thickness only says
//! whether there is an inside; without thickness the surface is a sheet.

use brewster_world::components::{Principled, Volume};
use glam::Vec3;

use super::super::materials::{Reader, unit};
use super::super::{Found, broken};

/// Writes what the extension says into a material.
pub(in crate::gltf) fn apply(reader: &mut Reader, material: &mut Principled) -> Found<()> {
    let Some(found) = reader.extension("KHR_materials_volume")? else { return Ok(()) };
    if found.get("thicknessFactor", 0.0)? <= 0.0 {
        return Ok(());
    }
    let attenuation_distance = found.get("attenuationDistance", f32::INFINITY)?;
    if attenuation_distance.is_nan() || attenuation_distance <= 0.0 {
        let problem = broken(found.path_of("attenuationDistance"), "a distance of no length");
        return Err(problem.expected("a number above 0").into());
    }
    let attenuation_color = Vec3::from_array(found.get("attenuationColor", [1.0; 3])?.map(unit));
    material.volume = Some(Volume { attenuation_color, attenuation_distance, ..Volume::default() });
    Ok(())
}
