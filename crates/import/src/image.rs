//! Picture files to linear pixels. Dimensions are checked against the budget before anything is decoded.

use std::io::Cursor;
use std::sync::Arc;

use brewster_optics::color::{linear_from_srgb8, linear_from_srgb16};
use brewster_world::components::parts::Image;
use image::{DynamicImage, ImageDecoder, ImageReader};

use crate::diagnostics::Code;
use crate::session::{Asset, Session};
use crate::source::Span;

/// The picture in a file that is named at `span`: sRGB decoded, except for HDR, which is linear already. Alpha is dropped.
pub(crate) fn load(session: &mut Session, name: &str, span: Span) -> Option<Arc<Image>> {
    let asset = session.read_asset(name, span)?;
    if let Some((digest, image)) = session.assets.images.get(&asset.path)
        && *digest == asset.digest
    {
        let image = Arc::clone(image);
        return budget(session, name, span, image.width, image.height).then_some(image);
    }
    let image = Arc::new(decode(session, &asset, name, span)?);
    session.assets.images.insert(asset.path, (asset.digest, Arc::clone(&image)));
    Some(image)
}

fn decode(session: &mut Session, asset: &Asset, name: &str, span: Span) -> Option<Image> {
    let fail = |session: &mut Session, error: image::ImageError| {
        let message = format!("cannot read the picture {name:?}: {error}");
        let error = session.sources.error(Code::Image, span, message);
        session.found.push(error.expected("a PNG, JPEG, WebP or Radiance HDR file"));
    };
    let reader = ImageReader::new(Cursor::new(&asset.bytes)).with_guessed_format();
    let decoder = reader.map_err(image::ImageError::IoError).and_then(ImageReader::into_decoder);
    let mut decoder = match decoder {
        Ok(decoder) => decoder,
        Err(error) => {
            fail(session, error);
            return None;
        }
    };
    let (width, height) = decoder.dimensions();
    if !budget(session, name, span, width, height) {
        return None;
    }
    // Beside the pixels themselves a decoder needs room of its own, in proportion to them.
    let mut limits = image::Limits::no_limits();
    limits.max_alloc = Some((1 << 24) + 32 * u64::from(width) * u64::from(height));
    let decoded = decoder.set_limits(limits).and_then(|()| DynamicImage::from_decoder(decoder));
    match decoded {
        Ok(decoded) => Some(Image { width, height, pixels: linear_pixels(decoded) }),
        Err(error) => {
            fail(session, error);
            None
        }
    }
}

/// Takes a picture's pixels from what a scene may have, or reports that they are too many.
fn budget(session: &mut Session, name: &str, span: Span, width: u32, height: u32) -> bool {
    if width == 0 || height == 0 {
        session.error(Code::Image, span, format!("the picture {name:?} has no pixels"));
        return false;
    }
    let taken = session.budgets.pixels.take(u64::from(width) * u64::from(height));
    if let Err(exceeded) = taken {
        let message = format!("the picture {name:?} of {width} x {height} pixels is too large: {exceeded}");
        session.error(Code::Limit, span, message);
    }
    taken.is_ok()
}

fn linear_pixels(image: DynamicImage) -> Vec<[f32; 3]> {
    use image::ColorType::{L8, L16, La8, La16, Rgb8, Rgb16, Rgba8, Rgba16};
    match image.color() {
        L8 | La8 | Rgb8 | Rgba8 => image.into_rgb8().pixels().map(|pixel| pixel.0.map(linear_from_srgb8)).collect(),
        L16 | La16 | Rgb16 | Rgba16 => {
            image.into_rgb16().pixels().map(|pixel| pixel.0.map(linear_from_srgb16)).collect()
        }
        _ => {
            // A file can hold what no sensor saw: negative values and NaN count as black, infinity as the largest number.
            let tame = |value: f32| if value > 0.0 { value.min(f32::MAX) } else { 0.0 };
            image.into_rgb32f().pixels().map(|pixel| pixel.0.map(tame)).collect()
        }
    }
}
