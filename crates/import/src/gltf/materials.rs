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
use gltf::json::{self, Value, texture};
use serde::de::DeserializeOwned;
use serde_json::Map;

use super::document::Document;
use super::extensions::{self, others};
use super::meshes::Tangents;
use super::textures::{Info, Textures};
use super::{Found, Reporter};
use crate::diagnostics::Code;
use crate::session::Session;

/// Reads one material.
pub(super) struct Reader<'r, 'i> {
    pub session: &'r mut Session<'i>,
    pub reporter: &'r mut Reporter,
    pub document: &'r Document,
    pub textures: &'r mut Textures,
    /// The material, and where it stands.
    material: &'r json::Material,
    path: String,
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
    let mut reader = Reader { session, reporter, document, textures, material, path };
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
        None => reader.alpha()?,
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
    let detail = Detail { normal: reader.normal()?, bump: None, opacity, front_only };
    reader.note_decisions(lets_light_through);
    Ok((Material::Principled(Box::new(principled)), detail))
}

/// What the material of a row needs of the meshes that wear it.
pub(super) fn tangents(document: &Document, index: Option<usize>) -> Tangents {
    let Some(material) = index.map(|index| &document.root.materials[index]) else { return Tangents::AsTheyAre };
    let moved = |others: Option<&Map<String, Value>>| {
        others?.get("KHR_texture_transform")?.get("texCoord")?.as_u64().map(|set| set as u32)
    };
    if let Some(map) = &material.normal_texture {
        return Tangents::Along(moved(others!(map)).unwrap_or(map.tex_coord));
    }
    let of = |name: &str, field: &str| {
        let found = others!(material)?.get(name)?.get(field)?;
        found.get("texCoord").map_or(Some(0), Value::as_u64).map(|set| set as u32)
    };
    let set = of("KHR_materials_anisotropy", "anisotropyTexture");
    let turned = others!(material).is_some_and(|others| others.contains_key("KHR_materials_anisotropy")).then_some(0);
    match set.or(turned).or_else(|| of("KHR_materials_clearcoat", "clearcoatNormalTexture")) {
        Some(set) => Tangents::Along(set),
        None => Tangents::AsTheyAre,
    }
}

impl Reader<'_, '_> {
    fn metallic_roughness(&mut self) -> Found<Principled> {
        let material = self.material;
        let pbr = &material.pbr_metallic_roughness;
        let path = format!("{}.pbrMetallicRoughness", self.path);
        let [r, g, b, _] = pbr.base_color_factor.0.map(unit);
        let base = pbr.base_color_texture.as_ref().map(info);
        let data = pbr.metallic_roughness_texture.as_ref().map(info);
        let at_data = format!("{path}.metallicRoughnessTexture");
        let emission = material.emissive_texture.as_ref().map(info);
        let factor = material.emissive_factor.0.map(|factor| factor.clamp(0.0, f32::MAX));
        Ok(Principled {
            base_color: self.color([r, g, b], &base, Encoding::Srgb, &format!("{path}.baseColorTexture"))?,
            metallic: self.scalar(unit(pbr.metallic_factor.0), &data, Channel::B, &at_data)?,
            roughness: self.scalar(unit(pbr.roughness_factor.0), &data, Channel::G, &at_data)?,
            emission: self.color(factor, &emission, Encoding::Srgb, &format!("{}.emissiveTexture", self.path))?,
            ..Principled::default()
        })
    }

    /// How much of the surface is there, and the texture whose alpha is a factor of that.
    fn alpha(&mut self) -> Found<(f32, Option<Texture>)> {
        let pbr = &self.material.pbr_metallic_roughness;
        let path = format!("{}.pbrMetallicRoughness.baseColorTexture", self.path);
        let texture = match pbr.base_color_texture.as_ref().map(info) {
            Some(info) if self.material.alpha_mode.unwrap() != AlphaMode::Opaque => {
                self.texture(&info, Encoding::Srgb, &path)?
            }
            _ => None,
        };
        Ok((unit(pbr.base_color_factor.0[3]), texture))
    }

    fn normal(&mut self) -> Found<Option<NormalMap>> {
        let Some(map) = &self.material.normal_texture else { return Ok(None) };
        let path = format!("{}.normalTexture", self.path);
        let info = Info {
            index: map.index.value(),
            tex_coord: map.tex_coord,
            scale: map.scale,
            extensions: others!(map).cloned(),
        };
        let scale = if map.scale.is_finite() { map.scale } else { 1.0 };
        Ok(self.texture(&info, Encoding::Linear, &path)?.map(|texture| NormalMap { texture, scale }))
    }

    fn note_decisions(&mut self, lets_light_through: bool) {
        if self.material.occlusion_texture.is_some() {
            let message = "occlusion textures are not used: shadows in corners are traced";
            self.reporter.note(Code::Decision, format!("{}.occlusionTexture", self.path), message);
        }
        if !self.material.double_sided {
            let message = match lets_light_through {
                false => {
                    "cameras look through the backs of materials that are not double-sided; light meets both sides"
                }
                true => "cameras see both sides of materials that let light through, double-sided or not",
            };
            // The default material stands nowhere in the file.
            let path = if self.path.is_empty() { String::new() } else { format!("{}.doubleSided", self.path) };
            self.reporter.note(Code::Decision, path, message);
        }
    }

    /// What an extension of the material holds, and its path.
    pub(super) fn extension<T: DeserializeOwned>(&self, name: &str) -> Found<Option<(T, String)>> {
        let found = extensions::read(others!(self.material), name, &self.path)?;
        Ok(found.map(|found| (found, format!("{}.extensions.{name}", self.path))))
    }

    /// The texture that a reference means; none where it cannot be read.
    pub(super) fn texture(&mut self, info: &Info, encoding: Encoding, path: &str) -> Found<Option<Texture>> {
        self.textures.texture((self.session, self.reporter), self.document, info, encoding, path)
    }

    /// A number, times a channel of a texture.
    pub(super) fn scalar(&mut self, factor: f32, info: &Option<Info>, channel: Channel, path: &str) -> Found<Scalar> {
        let texture = match info {
            Some(info) if factor != 0.0 => self.texture(info, Encoding::Linear, path)?,
            _ => None,
        };
        Ok(Scalar { factor, texture: texture.map(|texture| (texture, channel)) })
    }

    /// A color, times a texture's.
    pub(super) fn color(
        &mut self,
        factor: [f32; 3],
        info: &Option<Info>,
        encoding: Encoding,
        path: &str,
    ) -> Found<Color> {
        let factor = Vec3::from_array(factor);
        let texture = match info {
            Some(info) if factor != Vec3::ZERO => self.texture(info, encoding, path)?,
            _ => None,
        };
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

/// A reference as the `gltf` crate has it.
fn info(info: &texture::Info) -> Info {
    Info { index: info.index.value(), tex_coord: info.tex_coord, scale: 1.0, extensions: others!(info).cloned() }
}
