//! `KHR_materials_iridescence`: a thin film.

use brewster_world::components::Principled;
use brewster_world::components::parts::{Channel, Encoding};

use super::super::Found;
use super::super::materials::Reader;

/// Writes what the extension says into a material.
pub(in crate::gltf) fn apply(reader: &mut Reader, material: &mut Principled) -> Found<()> {
    let Some(found) = reader.extension("KHR_materials_iridescence")? else { return Ok(()) };
    let film = &mut material.iridescence;
    film.factor = reader.scalar(&found, ("iridescenceFactor", 0.0), ("iridescenceTexture", Channel::R))?;
    film.ior = found.get("iridescenceIor", 1.3f32)?.clamp(1.0, 100.0);
    let (least, most) = ("iridescenceThicknessMinimum", "iridescenceThicknessMaximum");
    let ends: [f32; 2] = [found.get(least, 100.0)?, found.get(most, 400.0)?];
    film.thickness = ends.map(|thickness| thickness.clamp(0.0, 1e5));
    let texture = reader.texture(&found, "iridescenceThicknessTexture", Encoding::Linear)?;
    film.thickness_texture = texture.map(|texture| (texture, Channel::G));
    Ok(())
}
