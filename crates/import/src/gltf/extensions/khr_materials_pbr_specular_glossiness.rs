//! `KHR_materials_pbrSpecularGlossiness`, an archived extension: converted as its successors suggest. With an infinite index of
//! refraction the reflection along the normal is the specular color itself; roughness is 1 - glossiness.

use std::sync::Arc;

use brewster_world::components::parts::{Channel, Encoding, Image, ImageTexture, Texels, Texture};
use brewster_world::components::{Principled, Scalar};

use super::super::Found;
use super::super::materials::{Reader, unit};

/// Writes what the extension says into a material; the alpha of its diffuse color, and where more of it comes from.
pub(in crate::gltf) fn apply(reader: &mut Reader, material: &mut Principled) -> Found<Option<(f32, Option<Texture>)>> {
    let Some(found) = reader.extension("KHR_materials_pbrSpecularGlossiness")? else { return Ok(None) };
    let [r, g, b, _] = found.get("diffuseFactor", [1.0; 4])?.map(unit);
    material.base_color = reader.color(&found, [r, g, b], "diffuseTexture")?;
    material.metallic = Scalar::constant(0.0);
    material.ior = 0.0;
    let specular = found.get("specularFactor", [1.0; 3])?.map(unit);
    material.specular_color = reader.color(&found, specular, "specularGlossinessTexture")?;
    let glossiness = unit(found.get("glossinessFactor", 1.0)?);
    let texture = reader.texture(&found, "specularGlossinessTexture", Encoding::Linear)?;
    material.roughness = match texture {
        Some(Texture::Image(picture)) => {
            let image = Arc::new(roughness(&picture.image, glossiness));
            Scalar {
                factor: 1.0,
                texture: Some((Texture::Image(ImageTexture { image, pyramid: None, ..picture }), Channel::A)),
            }
        }
        _ => Scalar::constant(1.0 - glossiness),
    };
    reader.alpha(&found, "diffuseFactor", "diffuseTexture").map(Some)
}

/// A picture whose alpha is 1 - factor * alpha.
fn roughness(image: &Image, factor: f32) -> Image {
    let texels = match &image.texels {
        Texels::Bytes(texels) => Texels::Bytes(
            texels.iter().map(|&[r, g, b, a]| [r, g, b, (255.0 - factor * f32::from(a)).round() as u8]).collect(),
        ),
        Texels::Words(texels) => Texels::Words(
            texels.iter().map(|&[r, g, b, a]| [r, g, b, (65535.0 - factor * f32::from(a)).round() as u16]).collect(),
        ),
        // Alpha is 1 everywhere.
        Texels::Floats(texels) => {
            let alpha = (65535.0 * (1.0 - factor)).round() as u16;
            Texels::Words(vec![[0, 0, 0, alpha]; texels.len()])
        }
    };
    Image { texels, ..*image }
}

#[cfg(test)]
mod tests {
    use brewster_world::components::Opacity;

    use super::*;
    use crate::gltf::testing::{Builder, load_mesh};

    #[test]
    fn what_is_black_has_the_alpha_of_its_texture() {
        let mut builder = Builder::default();
        let mut bytes = Vec::new();
        let picture = ::image::RgbaImage::from_pixel(1, 1, ::image::Rgba([255, 255, 255, 0]));
        picture.write_to(&mut std::io::Cursor::new(&mut bytes), ::image::ImageFormat::Png).expect("a picture");
        let view = builder.view(&bytes, None);
        let positions = builder.floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0], "VEC3");
        builder.rest = format!(
            r#","images":[{{"bufferView":{view},"mimeType":"image/png"}}],"textures":[{{"source":0}}],"nodes":[{{"mesh":0}}],
            "meshes":[{{"primitives":[{{"attributes":{{"POSITION":{positions}}},"material":0}}]}}],
            "materials":[{{"alphaMode":"MASK","extensions":{{"KHR_materials_pbrSpecularGlossiness":
            {{"diffuseFactor":[0,0,0,0.75],"diffuseTexture":{{"index":0}}}}}}}}]"#
        );
        let Opacity::Mask { alpha, cutoff } = load_mesh(&builder).1.opacity else { panic!("a mask") };
        assert_eq!((alpha.factor, cutoff), (0.75, 0.5));
        assert!(matches!(alpha.texture, Some((Texture::Image(_), Channel::A))), "{:?}", alpha.texture);
    }
}
