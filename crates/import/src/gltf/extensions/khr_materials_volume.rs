//! `KHR_materials_volume`: the inside of a closed surface. Light is traced through it, so the thickness only says
//! whether there is an inside; without thickness the surface is a sheet.

use brewster_world::components::{Principled, Volume};
use glam::Vec3;
use serde::Deserialize;

use super::super::materials::{Reader, unit};
use super::super::{Found, broken};

#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct Extension {
    thickness_factor: f32,
    attenuation_distance: f32,
    attenuation_color: [f32; 3],
}

impl Default for Extension {
    fn default() -> Self {
        Extension { thickness_factor: 0.0, attenuation_distance: f32::INFINITY, attenuation_color: [1.0; 3] }
    }
}

/// Writes what the extension says into a material.
pub(in crate::gltf) fn apply(reader: &mut Reader, material: &mut Principled) -> Found<()> {
    let Some((found, path)) = reader.extension::<Extension>("KHR_materials_volume")? else { return Ok(()) };
    if found.thickness_factor <= 0.0 {
        return Ok(());
    }
    if found.attenuation_distance.is_nan() || found.attenuation_distance <= 0.0 {
        let problem = broken(format!("{path}.attenuationDistance"), "a distance of no length");
        return Err(problem.expected("a number above 0").into());
    }
    material.volume = Some(Volume {
        attenuation_color: Vec3::from_array(found.attenuation_color.map(unit)),
        attenuation_distance: found.attenuation_distance,
        ..Volume::default()
    });
    Ok(())
}
