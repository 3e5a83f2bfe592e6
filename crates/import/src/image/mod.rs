//! Picture files to pixels, in the precision of the file. Dimensions are checked against the budget before anything is decoded.

mod exr;

use std::io::Cursor;
use std::sync::Arc;

use brewster_world::components::parts::{Image, Texels};
use image::{DynamicImage, ImageDecoder, ImageReader};

use crate::diagnostics::Code;
use crate::session::{Asset, Session};
use crate::source::Span;

/// The picture in a file that is named at `span`: bytes and words as they are, HDR and EXR in linear numbers without alpha.
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
    let decoded = match asset.bytes.starts_with(exr::MAGIC) {
        true => decode_exr(session, asset, name, span),
        false => decode_other(session, asset, name, span).map_err(|error| error.to_string()),
    };
    match decoded {
        Ok(image) => image,
        Err(error) => {
            let message = format!("cannot read the picture {name:?}: {error}");
            let error = session.sources.error(Code::Image, span, message);
            session.found.push(error.expected("a PNG, JPEG, WebP, Radiance HDR or OpenEXR file"));
            None
        }
    }
}

/// Nothing where the size was reported.
fn decode_exr(session: &mut Session, asset: &Asset, name: &str, span: Span) -> Result<Option<Image>, String> {
    let file = exr::File::open(&asset.bytes)?;
    let [width, height] = file.largest();
    if !budget(session, name, span, width, height) {
        return Ok(None);
    }
    file.decode().map(Some)
}

/// Nothing where the size was reported.
fn decode_other(session: &mut Session, asset: &Asset, name: &str, span: Span) -> image::ImageResult<Option<Image>> {
    let mut decoder = ImageReader::new(Cursor::new(&asset.bytes)).with_guessed_format()?.into_decoder()?;
    let (width, height) = decoder.dimensions();
    if !budget(session, name, span, width, height) {
        return Ok(None);
    }
    // Beside the pixels themselves a decoder needs room of its own, in proportion to them.
    let mut limits = image::Limits::no_limits();
    limits.max_alloc = Some((1 << 24) + 32 * u64::from(width) * u64::from(height));
    decoder.set_limits(limits)?;
    Ok(Some(Image { width, height, texels: texels(DynamicImage::from_decoder(decoder)?) }))
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

fn texels(image: DynamicImage) -> Texels {
    use image::ColorType::{L8, L16, La8, La16, Rgb8, Rgb16, Rgba8, Rgba16};
    match image.color() {
        L8 | La8 | Rgb8 | Rgba8 => Texels::Bytes(image.into_rgba8().pixels().map(|pixel| pixel.0).collect()),
        L16 | La16 | Rgb16 | Rgba16 => Texels::Words(image.into_rgba16().pixels().map(|pixel| pixel.0).collect()),
        _ => Texels::Floats(image.into_rgb32f().pixels().map(|pixel| pixel.0.map(tame)).collect()),
    }
}

/// A file can hold what no sensor saw: negative values and NaN count as black, infinity as the largest number.
fn tame(value: f32) -> f32 {
    if value > 0.0 { value.min(f32::MAX) } else { 0.0 }
}
