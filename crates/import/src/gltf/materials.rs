//! Materials.
//!
//! | where the specification leaves a choice | what is done |
//! | --- | --- |
//! | occlusion textures | not used: light that does not get somewhere does not get there |
//! | a material that is not double-sided | cameras look through its back, unless light passes the surface; light meets both sides |
//! | a factor outside its range | the nearest in it |

use brewster_world::components::parts::{Channel, Encoding, Texture};
use brewster_world::components::{Color, Detail, Material, NormalMap, Opacity, Principled, Scalar};
use glam::Vec3;
use gltf::json::material::AlphaMode;
use gltf::json::{self, Value};

use super::document::Document;
use super::extensions::{self, others};
use super::fields::Fields;
use super::meshes::Tangents;
use super::textures::{Info, Textures};
use super::{Found, Reporter};
use crate::diagnostics::Code;
use crate::session::Session;

/// Reads one material.
pub(super) struct Reader<'r, 'i> {
    session: &'r mut Session<'i>,
    reporter: &'r mut Reporter,
    document: &'r Document,
    textures: &'r mut Textures,
    /// The material, typed and as it stands in the file.
    material: &'r json::Material,
    own: &'r Fields<'r>,
}

/// A number in 0..=1.
pub(super) fn unit(value: f32) -> f32 {
    value.clamp(0.0, 1.0)
}

/// The material of a row of the file's list, or the default one; `is_tinted` says whether colors of vertices multiply it.
pub(super) fn material(
    (session, reporter): (&mut Session, &mut Reporter),
    document: &Document,
    textures: &mut Textures,
    index: Option<usize>,
    is_tinted: bool,
) -> Found<(Material, Detail)> {
    let default = json::Material::default();
    let material = index.map_or(&default, |index| &document.root.materials[index]);
    let path = index.map_or_else(String::new, |index| format!("materials[{index}]"));
    let own = Fields::new(index.and_then(|index| document.value.get("materials")?.get(index)), path);
    let mut reader = Reader { session, reporter, document, textures, material, own: &own };
    let mut principled = reader.metallic_roughness()?;
    let p = &mut principled;
    let r = &mut reader;
    let converted = extensions::khr_materials_pbr_specular_glossiness::apply(r, p)?;
    extensions::khr_materials_ior::apply(r, p)?;
    extensions::khr_materials_specular::apply(r, p)?;
    extensions::khr_materials_transmission::apply(r, p)?;
    extensions::khr_materials_diffuse_transmission::apply(r, p)?;
    extensions::khr_materials_volume::apply(r, p)?;
    extensions::khr_materials_volume_scatter::apply(r, p)?;
    extensions::khr_materials_dispersion::apply(r, p)?;
    extensions::khr_materials_clearcoat::apply(r, p)?;
    extensions::khr_materials_sheen::apply(r, p)?;
    extensions::khr_materials_iridescence::apply(r, p)?;
    extensions::khr_materials_anisotropy::apply(r, p)?;
    extensions::khr_materials_emissive_strength::apply(r, p)?;
    extensions::khr_materials_unlit::apply(r, p)?;
    let (alpha, texture) = match converted {
        Some(converted) => converted,
        None => reader.alpha(&own.within("pbrMetallicRoughness"), "baseColorFactor", "baseColorTexture")?,
    };
    let mut alpha = Scalar { factor: alpha, texture: texture.map(|texture| (texture, Channel::A)) };
    if is_tinted {
        tint(&mut principled.base_color);
        match &mut alpha.texture {
            Some((Texture::Image(image), _)) => image.vertex_colors = true,
            _ => alpha.texture = Some((Texture::VertexColors, Channel::A)),
        }
    }
    let opacity = match material.alpha_mode.unwrap() {
        AlphaMode::Opaque => Opacity::Opaque,
        AlphaMode::Mask => Opacity::Mask { alpha, cutoff: material.alpha_cutoff.unwrap_or_default().0 },
        AlphaMode::Blend => Opacity::Blend { alpha },
    };
    // Light has to leave what it has entered.
    let lets_light_through = principled.transmission.factor > 0.0 || principled.diffuse_transmission.factor > 0.0;
    let front_only = !material.double_sided && !lets_light_through && principled.volume.is_none();
    let detail = Detail { normal: reader.normal(&own, "normalTexture")?, bump: None, opacity, front_only };
    reader.note_decisions(lets_light_through);
    Ok((Material::Principled(Box::new(principled)), detail))
}

/// What the material of a row needs of the meshes that wear it.
pub(super) fn tangents(document: &Document, index: Option<usize>) -> Tangents {
    let material = index.and_then(|index| document.value.get("materials")?.get(index));
    let within = |pointer: &str| material?.pointer(pointer).filter(|value| value.is_object());
    let set = |pointer: &str| {
        let map = within(pointer)?;
        let set = map.pointer("/extensions/KHR_texture_transform/texCoord").or_else(|| map.get("texCoord"));
        Some(set.and_then(Value::as_u64).unwrap_or(0) as u32)
    };
    // What is anisotropic has a direction, textured or not.
    let found = set("/normalTexture")
        .or_else(|| set("/extensions/KHR_materials_anisotropy/anisotropyTexture"))
        .or_else(|| within("/extensions/KHR_materials_anisotropy").and(Some(0)))
        .or_else(|| set("/extensions/KHR_materials_clearcoat/clearcoatNormalTexture"));
    found.map_or(Tangents::AsTheyAre, Tangents::Along)
}

impl<'r> Reader<'r, '_> {
    fn metallic_roughness(&mut self) -> Found<Principled> {
        let (own, pbr) = (self.own, self.own.within("pbrMetallicRoughness"));
        let [r, g, b, _] = pbr.get("baseColorFactor", [1.0; 4])?.map(unit);
        let emission = own.get("emissiveFactor", [0.0f32; 3])?.map(|factor| factor.clamp(0.0, f32::MAX));
        let data = "metallicRoughnessTexture";
        Ok(Principled {
            base_color: self.color(&pbr, [r, g, b], "baseColorTexture")?,
            metallic: self.scalar(&pbr, ("metallicFactor", 1.0), (data, Channel::B))?,
            roughness: self.scalar(&pbr, ("roughnessFactor", 1.0), (data, Channel::G))?,
            emission: self.color(own, emission, "emissiveTexture")?,
            ..Principled::default()
        })
    }

    /// How much of the surface is there, and the texture whose alpha is a factor of that: the names of a color's factor and texture.
    pub(super) fn alpha(&mut self, of: &Fields, factor: &str, texture: &str) -> Found<(f32, Option<Texture>)> {
        let texture = match self.material.alpha_mode.unwrap() {
            AlphaMode::Opaque => None,
            _ => self.texture(of, texture, Encoding::Srgb)?,
        };
        let [.., alpha] = of.get(factor, [1.0; 4])?;
        Ok((unit(alpha), texture))
    }

    fn note_decisions(&mut self, lets_light_through: bool) {
        if self.material.occlusion_texture.is_some() {
            let message = "occlusion textures are not used: shadows in corners are traced";
            self.reporter.note(Code::Decision, self.own.path_of("occlusionTexture"), message);
        }
        if !self.material.double_sided {
            let message = match lets_light_through {
                false => {
                    "cameras look through the backs of materials that are not double-sided; light meets both sides"
                }
                true => "cameras see both sides of materials that let light through, double-sided or not",
            };
            // The default material stands nowhere in the file.
            let path = if self.own.is_absent() { String::new() } else { self.own.path_of("doubleSided") };
            self.reporter.note(Code::Decision, path, message);
        }
    }

    /// What an extension of the material holds.
    pub(super) fn extension(&self, name: &str) -> Found<Option<Fields<'r>>> {
        extensions::fields(others!(self.material), name, self.own.path())
    }

    /// The texture that a field refers to; none where it cannot be read.
    pub(super) fn texture(&mut self, of: &Fields, name: &str, encoding: Encoding) -> Found<Option<Texture>> {
        let Some(info) = of.get::<Option<Info>>(name, None)? else { return Ok(None) };
        self.textures.texture((self.session, self.reporter), self.document, &info, encoding, &of.path_of(name))
    }

    /// The normal map that a field refers to.
    pub(super) fn normal(&mut self, of: &Fields, name: &str) -> Found<Option<NormalMap>> {
        let scale: f32 = of.within(name).get("scale", 1.0)?;
        let scale = if scale.is_finite() { scale } else { 1.0 };
        Ok(self.texture(of, name, Encoding::Linear)?.map(|texture| NormalMap { texture, scale }))
    }

    /// A number in 0..=1, times a channel of a texture: the names of both, and the number where none is given.
    pub(super) fn scalar(
        &mut self,
        of: &Fields,
        (factor, default): (&str, f32),
        (texture, channel): (&str, Channel),
    ) -> Found<Scalar> {
        let factor = unit(of.get(factor, default)?);
        let texture = if factor == 0.0 { None } else { self.texture(of, texture, Encoding::Linear)? };
        Ok(Scalar { factor, texture: texture.map(|texture| (texture, channel)) })
    }

    /// A color, times a texture's.
    pub(super) fn color(&mut self, of: &Fields, factor: [f32; 3], texture: &str) -> Found<Color> {
        let factor = Vec3::from_array(factor);
        let texture = if factor == Vec3::ZERO { None } else { self.texture(of, texture, Encoding::Srgb)? };
        Ok(match texture {
            None => Color::Constant(factor),
            Some(texture) if factor == Vec3::ONE => Color::Texture(texture),
            Some(texture) => Color::Tinted { factor, texture },
        })
    }
}

/// Multiplies a color by the vertices' colors.
fn tint(color: &mut Color) {
    match color {
        Color::Constant(factor) => *color = Color::Tinted { factor: *factor, texture: Texture::VertexColors },
        Color::Texture(Texture::Image(image)) | Color::Tinted { texture: Texture::Image(image), .. } => {
            image.vertex_colors = true;
        }
        Color::Texture(_) | Color::Tinted { .. } => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gltf::testing::{Builder, document};

    #[test]
    fn tangents_run_along_the_coordinates_that_a_material_looks_up_by() {
        let moved = r#"{"index":0,"texCoord":0,"extensions":{"KHR_texture_transform":{"texCoord":1}}}"#;
        let anisotropy = |map: &str| format!(r#""extensions":{{"KHR_materials_anisotropy":{{{map}}}}}"#);
        let clearcoat = |map: &str| format!(r#""extensions":{{"KHR_materials_clearcoat":{{{map}}}}}"#);
        for (material, expected) in [
            (String::new(), Tangents::AsTheyAre),
            (r#""normalTexture":{"index":0}"#.into(), Tangents::Along(0)),
            (r#""normalTexture":{"index":0,"texCoord":1}"#.into(), Tangents::Along(1)),
            (format!(r#""normalTexture":{moved}"#), Tangents::Along(1)),
            (anisotropy(""), Tangents::Along(0)),
            (anisotropy(r#""anisotropyTexture":{"index":0,"texCoord":1}"#), Tangents::Along(1)),
            (anisotropy(&format!(r#""anisotropyTexture":{moved}"#)), Tangents::Along(1)),
            (
                format!(r#""normalTexture":{{"index":0}},{}"#, anisotropy(&format!(r#""anisotropyTexture":{moved}"#))),
                Tangents::Along(0),
            ),
            (clearcoat(""), Tangents::AsTheyAre),
            (clearcoat(r#""clearcoatNormalTexture":{"index":0}"#), Tangents::Along(0)),
            (clearcoat(&format!(r#""clearcoatNormalTexture":{moved}"#)), Tangents::Along(1)),
        ] {
            let rest =
                format!(r#","images":[{{"uri":"a.png"}}],"textures":[{{"source":0}}],"materials":[{{{material}}}]"#);
            let builder = Builder { rest, ..Builder::default() };
            assert_eq!(tangents(&document(&builder), Some(0)), expected, "{material}");
        }
    }
}
