//! Principled materials: a row of their own, and one of the dielectrics for what fills them.

use brewster_buffers as buffers;
use brewster_buffers::{ColorSource, Materials};
use brewster_lanes::math;
use brewster_optics::dispersion::{Cauchy, DispersiveIndex};
use brewster_optics::fresnel::FresnelModel;
use brewster_optics::{absorption, free_flight};
use glam::{Vec2, Vec3};

use super::materials::is_between;
use super::rows::Rows;
use super::textures::{self, TextureWriter};
use crate::components::{Color, Principled, Scalar, Volume};

/// Whether there is a medium behind the surface: it is none where no light gets in.
pub(super) fn has_inside(principled: &Principled) -> bool {
    let passes = principled.transmission.factor > 0.0 || principled.diffuse_transmission.factor > 0.0;
    principled.volume.is_some() && passes && principled.ior >= 1.0
}

/// Its colors, in the order in which [`put`] writes their textures.
pub(super) fn colors(principled: &Principled) -> [&Color; 5] {
    let Principled { base_color, specular_color, sheen_color, diffuse_transmission_color, emission, .. } = principled;
    [base_color, specular_color, sheen_color, diffuse_transmission_color, emission]
}

/// Its numbers that may have a texture and lie in 0..1.
fn scalars(principled: &Principled) -> [&Scalar; 9] {
    let Principled { metallic, roughness, specular, clearcoat, clearcoat_roughness, .. } = principled;
    let Principled { sheen_roughness, transmission, diffuse_transmission, iridescence, .. } = principled;
    [
        metallic,
        roughness,
        specular,
        clearcoat,
        clearcoat_roughness,
        sheen_roughness,
        transmission,
        diffuse_transmission,
        &iridescence.factor,
    ]
}

/// Textures beside those of its colors.
pub(super) fn other_textures(principled: &Principled) -> usize {
    let scalars = scalars(principled).into_iter().filter(|scalar| scalar.texture.is_some()).count();
    let Principled { anisotropy, iridescence, .. } = principled;
    let normal = usize::from(principled.clearcoat_normal.is_some());
    scalars + normal + usize::from(anisotropy.texture.is_some()) + usize::from(iridescence.thickness_texture.is_some())
}

/// Writes a material to a row of the principled ones and what fills it to a row of the dielectrics. Says whether others
/// stood there.
pub(super) fn put(
    materials: &mut Materials,
    textures: &mut TextureWriter<'_>,
    principled: &Principled,
    row: usize,
    medium: Option<usize>,
) -> bool {
    let [base_color, specular_color, sheen_color, diffuse_transmission_color, emission] =
        colors(principled).map(|color| textures.source(color));
    let [
        metallic,
        roughness,
        specular,
        clearcoat,
        clearcoat_roughness,
        sheen_roughness,
        transmission,
        diffuse_transmission,
        iridescence,
    ] = scalars(principled).map(|scalar| textures.scalar(scalar));
    let (sin, cos) = math::sin_cos(principled.anisotropy.rotation);
    let film = &principled.iridescence;
    let row_of_kind = buffers::Principled {
        base_color,
        metallic,
        roughness,
        ior: principled.ior,
        specular,
        specular_color,
        clearcoat,
        clearcoat_roughness,
        clearcoat_normal: textures.row(principled.clearcoat_normal.as_ref().map(|map| &map.texture)),
        clearcoat_normal_scale: principled.clearcoat_normal.as_ref().map_or(1.0, |map| map.scale),
        sheen_color,
        sheen_roughness,
        anisotropy: principled.anisotropy.strength,
        anisotropy_direction: Vec2::new(cos, sin),
        anisotropy_texture: textures.row(principled.anisotropy.texture.as_ref()),
        transmission,
        diffuse_transmission,
        diffuse_transmission_color,
        medium: medium.map_or(buffers::Principled::NO_MEDIUM, |row| row as u32),
        iridescence,
        iridescence_ior: film.ior,
        iridescence_thickness: film.thickness,
        iridescence_thickness_source: textures.scalar(&Scalar { factor: 1.0, texture: film.thickness_texture.clone() }),
        compensated: principled.compensated,
        emission,
    };
    let mut differs = materials.principled.put(row, row_of_kind);
    if let (Some(row), Some(volume)) = (medium, &principled.volume) {
        differs |= materials.dielectric.put(row, filling(principled, volume));
    }
    differs
}

/// What fills a volume. Its surface is the principled material's: nothing is read here but the medium.
fn filling(principled: &Principled, volume: &Volume) -> buffers::Dielectric {
    let extinction =
        absorption::from_color(volume.attenuation_color, volume.attenuation_distance).expect("a checked volume");
    // KHR_materials_volume_scatter: what is attenuated is absorbed or scattered.
    let scattering = match volume.multiscatter_color {
        Vec3::ZERO => Vec3::ZERO,
        color => extinction * free_flight::albedo_of_color(color),
    };
    buffers::Dielectric {
        ior: principled.ior,
        dispersion: dispersion(principled),
        fresnel: FresnelModel::Exact,
        specular: ColorSource::constant(Vec3::ZERO),
        exponent: 0.0,
        absorption: extinction - scattering,
        scattering,
        anisotropy: volume.anisotropy,
        bare: false,
        priority: volume.priority,
        alpha: 0.0,
        film: None,
        thin: false,
    }
}

/// KHR_materials_dispersion says 20 over the Abbe number; the index follows Cauchy's formula.
fn dispersion(principled: &Principled) -> Option<DispersiveIndex> {
    (principled.dispersion > 0.0)
        .then(|| DispersiveIndex::Cauchy(Cauchy::from_abbe(principled.ior, 20.0 / principled.dispersion)))
}

/// Checks the numbers of a material whose colors are sound; the error says what must hold.
pub(super) fn check(principled: &Principled) -> Result<(), &'static str> {
    let is_part = |value: f32| (0.0..=1.0).contains(&value);
    let (scalars, film) = (scalars(principled), &principled.iridescence);
    let mut maps = scalars.iter().filter_map(|scalar| scalar.texture.as_ref()).chain(&film.thickness_texture);
    maps.try_for_each(|(texture, _)| textures::check(texture))?;
    principled.anisotropy.texture.as_ref().map_or(Ok(()), textures::check)?;
    principled.clearcoat_normal.as_ref().map_or(Ok(()), |map| textures::check(&map.texture))?;
    let colors = [&principled.base_color, &principled.sheen_color, &principled.diffuse_transmission_color];
    let is_dim = |color: &&Color| color.factor().max_element() <= 1.0;
    let is_index = |ior: f32| ior >= 1.0 && ior.is_finite();
    let anisotropy = &principled.anisotropy;
    let volume = principled.volume.as_ref().is_none_or(|volume| {
        absorption::from_color(volume.attenuation_color, volume.attenuation_distance)
            .is_ok_and(|absorption| absorption.is_finite())
            && volume.multiscatter_color.to_array().into_iter().all(is_part)
            && is_between(volume.anisotropy)
    });
    let rules = [
        (scalars.iter().all(|scalar| is_part(scalar.factor)), "a principled factor must be 0 to 1"),
        (colors.iter().all(is_dim), "a principled color must be at most 1"),
        (principled.ior == 0.0 || is_index(principled.ior), "an index of refraction must be at least 1, or 0"),
        (is_part(anisotropy.strength) && anisotropy.rotation.is_finite(), "an anisotropy must be 0 to 1"),
        (
            principled.clearcoat_normal.as_ref().is_none_or(|map| map.scale.is_finite()),
            "the scale of a normal map must be finite",
        ),
        (volume, "a volume's colors must be 0 to 1, its distance above 0, its anisotropy between -1 and 1"),
        (
            is_index(film.ior) && film.thickness.into_iter().all(|thickness| (0.0..=1e5).contains(&thickness)),
            "an iridescent film must be at most 100000 nm thick, of an index of at least 1",
        ),
        (
            principled.dispersion >= 0.0 && dispersion(principled).is_none_or(|index| index.is_sound()),
            "a dispersion must be at least 0",
        ),
    ];
    rules.into_iter().try_for_each(|(holds, rule)| if holds { Ok(()) } else { Err(rule) })
}
