//! `KHR_materials_emissive_strength`: a factor of the emission.

use brewster_world::components::{Color, Principled};
use glam::Vec3;

use super::super::materials::Reader;
use super::super::{Found, broken};

/// Writes what the extension says into a material.
pub(in crate::gltf) fn apply(reader: &mut Reader, material: &mut Principled) -> Found<()> {
    let Some(found) = reader.extension("KHR_materials_emissive_strength")? else { return Ok(()) };
    let strength = found.get("emissiveStrength", 1.0f32)?.clamp(0.0, f32::MAX);
    match &mut material.emission {
        Color::Constant(factor) | Color::Tinted { factor, .. } => {
            *factor *= strength;
            if !factor.is_finite() {
                let message = format!("{strength:e} times the emissive factor is no finite number");
                return Err(broken(found.path_of("emissiveStrength"), message).into());
            }
        }
        Color::Texture(texture) => {
            material.emission = Color::Tinted { factor: Vec3::splat(strength), texture: texture.clone() };
        }
    }
    Ok(())
}
