//! Materials and textures as text.

use brewster_world::components as world;
use brewster_world::components::parts::{Axis, Channel, Filter, ImageTexture, Texture, UvSet, UvTransform, Wrap};
use brewster_world::components::{Color, Detail, Material, NormalMap, Opacity, Principled, Scalar};
use glam::Vec3;

use super::Exporter;
use super::numbers::{color, degrees};

impl Exporter<'_> {
    /// A material with its detail.
    pub(super) fn material(&mut self, material: &Material, detail: Option<&Detail>) -> String {
        let bare = match material {
            Material::Principled(principled) if principled.unlit => {
                format!("Emissive(radiance: {})", self.color(&principled.base_color))
            }
            Material::Principled(principled) => self.principled(principled),
            other => {
                self.lose(format!("a material that glTF does not have: {other:?}"));
                "Lambert()".to_owned()
            }
        };
        let Some(detail) = detail else { return bare };
        let mut fields = vec![format!("of: {bare}")];
        if let Some(NormalMap { texture, scale }) = &detail.normal {
            fields.push(format!("normal: {}", self.texture(Vec3::ONE, texture)));
            fields.push(format!("normal_scale: {scale:?}"));
        }
        match &detail.opacity {
            Opacity::Opaque => {}
            Opacity::Mask { alpha, cutoff } => {
                fields.push(format!("opacity: Mask(alpha: {}, cutoff: {cutoff:?})", self.scalar(alpha)));
            }
            Opacity::Blend { alpha } => fields.push(format!("opacity: Blend(alpha: {})", self.scalar(alpha))),
        }
        if detail.front_only {
            fields.push("sides: Front".to_owned());
        }
        format!("Detailed({})", fields.join(", "))
    }

    fn principled(&mut self, p: &Principled) -> String {
        let mut fields = vec![
            format!("base_color: {}", self.color(&p.base_color)),
            format!("metallic: {}", self.scalar(&p.metallic)),
            format!("roughness: {}", self.scalar(&p.roughness)),
        ];
        let default = Principled::default();
        let mut numbers = |name: &str, number: &Scalar, usual: &Scalar| {
            if number != usual {
                fields.push(format!("{name}: {}", self.scalar(number)));
            }
        };
        numbers("specular", &p.specular, &default.specular);
        numbers("clearcoat", &p.clearcoat, &default.clearcoat);
        numbers("clearcoat_roughness", &p.clearcoat_roughness, &default.clearcoat_roughness);
        numbers("transmission", &p.transmission, &default.transmission);
        numbers("diffuse_transmission", &p.diffuse_transmission, &default.diffuse_transmission);
        let mut colors = |name: &str, color: &Color, usual: &Color| {
            if color != usual {
                fields.push(format!("{name}: {}", self.color(color)));
            }
        };
        colors("specular_color", &p.specular_color, &default.specular_color);
        colors("sheen_color", &p.sheen_color, &default.sheen_color);
        colors("diffuse_transmission_color", &p.diffuse_transmission_color, &default.diffuse_transmission_color);
        colors("emission", &p.emission, &default.emission);
        if p.sheen_color != default.sheen_color {
            fields.push(format!("sheen_roughness: {}", self.scalar(&p.sheen_roughness)));
        }
        if p.ior != default.ior {
            fields.push(format!("ior: {:?}", p.ior));
        }
        if let Some(NormalMap { texture, scale }) = &p.clearcoat_normal {
            fields.push(format!("clearcoat_normal: {}", self.texture(Vec3::ONE, texture)));
            fields.push(format!("clearcoat_normal_scale: {scale:?}"));
        }
        if p.anisotropy != default.anisotropy {
            let world::Anisotropy { strength, rotation, texture } = &p.anisotropy;
            let texture = texture
                .as_ref()
                .map_or_else(String::new, |texture| format!(", texture: {}", self.texture(Vec3::ONE, texture)));
            fields.push(format!("anisotropy: (strength: {strength:?}, rotation: {}{texture})", degrees(*rotation)));
        }
        fields.extend(p.volume.as_ref().map(|volume| format!("volume: {}", inside(volume, p.dispersion))));
        if p.iridescence != default.iridescence {
            let world::Iridescence { factor, ior, thickness: [thinnest, thickest], thickness_texture } = &p.iridescence;
            let thickness = Scalar { factor: *thickest, texture: thickness_texture.clone() };
            let (factor, thickness) = (self.scalar(factor), self.scalar(&thickness));
            fields.push(format!(
                "iridescence: (factor: {factor}, ior: {ior:?}, thickness: {thickness}, thinnest: {thinnest:?})"
            ));
        }
        format!("Principled({})", fields.join(", "))
    }

    fn color(&mut self, source: &Color) -> String {
        match source {
            Color::Constant(constant) => color(*constant),
            Color::Texture(texture) => self.texture(Vec3::ONE, texture),
            Color::Tinted { factor, texture } => self.texture(*factor, texture),
        }
    }

    fn scalar(&mut self, scalar: &Scalar) -> String {
        let Some((texture, channel)) = &scalar.texture else { return format!("{:?}", scalar.factor) };
        let channel = match channel {
            Channel::R => "R",
            Channel::G => "G",
            Channel::B => "B",
            Channel::A => "A",
        };
        let texture = self.texture(Vec3::ONE, texture);
        format!("Map(texture: {texture}, channel: {channel}, factor: {:?})", scalar.factor)
    }

    fn texture(&mut self, factor: Vec3, texture: &Texture) -> String {
        let with_factor = if factor == Vec3::ONE { String::new() } else { format!("factor: {}", color(factor)) };
        match texture {
            Texture::Checker { a, b, size } => format!("Checker(a: {}, b: {}, size: {size:?})", color(*a), color(*b)),
            Texture::Gradient { from, to, axis } => {
                let axis = if *axis == Axis::U { "U" } else { "V" };
                format!("Gradient(from: {}, to: {}, axis: {axis})", color(*from), color(*to))
            }
            Texture::VertexColors => format!("VertexColors({with_factor})"),
            Texture::Image(image) => self.picture(image, with_factor),
        }
    }

    fn picture(&mut self, texture: &ImageTexture, factor: String) -> String {
        let mut fields = vec![format!("file: {:?}", self.image(&texture.image))];
        if !factor.is_empty() {
            fields.push(factor);
        }
        if texture.transform != UvTransform::IDENTITY {
            let rows = texture.transform.rows.map(|[a, b, c]| format!("({a:?}, {b:?}, {c:?})"));
            fields.push(format!("transform: ({})", rows.join(", ")));
        }
        for (name, wrap) in ["wrap_u", "wrap_v"].into_iter().zip(texture.wrap) {
            match wrap {
                Wrap::Repeat => {}
                Wrap::Mirror => fields.push(format!("{name}: Mirror")),
                Wrap::Clamp => fields.push(format!("{name}: Clamp")),
            }
        }
        if texture.filter == Filter::Nearest {
            fields.push("filter: Nearest".to_owned());
        }
        if texture.uv_set == UvSet::Second {
            fields.push("uv_set: Second".to_owned());
        }
        if texture.pyramid.is_some() {
            fields.push("mipmaps: true".to_owned());
        }
        if texture.vertex_colors {
            fields.push("vertex_colors: true".to_owned());
        }
        format!("Image({})", fields.join(", "))
    }
}

/// A volume; what nothing is absorbed in is white after any distance.
fn inside(volume: &world::Volume, dispersion: f32) -> String {
    let world::Volume { attenuation_color, attenuation_distance, multiscatter_color, anisotropy, priority } = volume;
    let mut fields = match attenuation_distance.is_finite() {
        true => vec![format!("color: {}", color(*attenuation_color)), format!("distance: {attenuation_distance:?}")],
        false => vec!["color: 1".to_owned()],
    };
    if *multiscatter_color != Vec3::ZERO {
        fields.push(format!("multiscatter: {}", color(*multiscatter_color)));
        fields.push(format!("anisotropy: {anisotropy:?}"));
    }
    if dispersion > 0.0 {
        fields.push(format!("abbe: {:?}", 20.0 / dispersion));
    }
    if *priority != 0 {
        fields.push(format!("priority: {priority}"));
    }
    format!("({})", fields.join(", "))
}
