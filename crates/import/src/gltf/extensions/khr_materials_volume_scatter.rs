//! `KHR_materials_volume_scatter`: an inside that scatters. Of what KHR_materials_volume says is lost on the way, the part
//! that is scattered follows from the color that the many times scattered light has.

use brewster_world::components::Principled;
use glam::Vec3;

use super::super::materials::{Reader, unit};
use super::super::{Found, broken};

/// Writes what the extension says into a material that has a volume.
pub(in crate::gltf) fn apply(reader: &mut Reader, material: &mut Principled) -> Found<()> {
    let Some(found) = reader.extension("KHR_materials_volume_scatter")? else { return Ok(()) };
    let anisotropy: f32 = found.get("scatterAnisotropy", 0.0)?;
    if !(-1.0..=1.0).contains(&anisotropy) {
        let problem = broken(found.path_of("scatterAnisotropy"), "a mean cosine that is none");
        return Err(problem.expected("a number above -1 and below 1").into());
    }
    let color = found.get("multiscatterColor", [0.0; 3])?.map(unit);
    if let Some(volume) = &mut material.volume {
        volume.multiscatter_color = Vec3::from_array(color);
        // The ends would be light that is not scattered at all.
        volume.anisotropy = anisotropy.clamp(-MOST, MOST);
    }
    Ok(())
}

/// The most that light is scattered forward or back.
const MOST: f32 = 0.999;
