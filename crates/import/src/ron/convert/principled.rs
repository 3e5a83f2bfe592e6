//! Principled materials.

use brewster_world::components as world;

use super::texture::{albedo, data, number, paint, part};
use crate::ron::schema;
use crate::ron::values::Either;
use crate::session::Session;
use crate::source::Span;

/// A principled material, whose schema has no other variant.
pub(super) fn principled(session: &mut Session, material: &schema::Material, span: Span) -> Option<world::Principled> {
    let schema::Material::Principled {
        base_color,
        metallic,
        roughness,
        ior,
        specular,
        specular_color,
        clearcoat,
        clearcoat_roughness,
        clearcoat_normal,
        clearcoat_normal_scale,
        sheen_color,
        sheen_roughness,
        anisotropy,
        transmission,
        diffuse_transmission,
        diffuse_transmission_color,
        volume,
        iridescence,
        compensated,
        emission,
    } = material
    else {
        return None;
    };
    let default = world::Principled::default();
    Some(world::Principled {
        base_color: albedo(session, base_color, "base_color", span)?,
        metallic: part(session, metallic)?,
        roughness: part(session, roughness)?,
        ior: *ior,
        specular: part(session, specular)?,
        specular_color: paint(session, specular_color)?,
        clearcoat: part(session, clearcoat)?,
        clearcoat_roughness: part(session, clearcoat_roughness)?,
        clearcoat_normal: match clearcoat_normal {
            Some(texture) => {
                Some(world::NormalMap { texture: data(session, texture)?, scale: *clearcoat_normal_scale })
            }
            None => None,
        },
        sheen_color: paint(session, sheen_color)?,
        sheen_roughness: part(session, sheen_roughness)?,
        anisotropy: match anisotropy {
            Some(anisotropy) => self::anisotropy(session, anisotropy)?,
            None => default.anisotropy,
        },
        transmission: part(session, transmission)?,
        diffuse_transmission: part(session, diffuse_transmission)?,
        diffuse_transmission_color: paint(session, diffuse_transmission_color)?,
        volume: volume.as_ref().map(|volume| world::Volume {
            attenuation_color: volume.color.0,
            attenuation_distance: volume.distance,
            multiscatter_color: volume.multiscatter.0,
            anisotropy: volume.anisotropy,
            priority: volume.priority,
        }),
        iridescence: match iridescence {
            Some(iridescence) => self::iridescence(session, iridescence)?,
            None => default.iridescence,
        },
        // As KHR_materials_dispersion counts.
        dispersion: volume.as_ref().and_then(|volume| volume.abbe).map_or(0.0, |abbe| 20.0 / abbe),
        compensated: *compensated,
        emission: paint(session, emission)?,
        unlit: false,
    })
}

fn anisotropy(session: &mut Session, anisotropy: &schema::Anisotropy) -> Option<world::Anisotropy> {
    let texture = match &anisotropy.texture {
        Some(texture) => Some(data(session, texture)?),
        None => None,
    };
    Some(world::Anisotropy { strength: anisotropy.strength, rotation: anisotropy.rotation.to_radians(), texture })
}

fn iridescence(session: &mut Session, iridescence: &schema::Iridescence) -> Option<world::Iridescence> {
    let thickness = number(session, &iridescence.thickness)?;
    let thinnest = match iridescence.thickness {
        Either::Plain(thickness) => thickness,
        Either::Choice(_) => iridescence.thinnest,
    };
    Some(world::Iridescence {
        factor: part(session, &iridescence.factor)?,
        ior: iridescence.ior,
        thickness: [thinnest, thickness.factor],
        thickness_texture: thickness.texture,
    })
}
