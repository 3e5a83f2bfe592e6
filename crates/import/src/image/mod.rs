//! Picture files to pixels, in the precision of the file. Dimensions are checked against the budget before anything is decoded.

mod exr;
mod ktx2;

use std::io::Cursor;
use std::sync::Arc;

use brewster_world::components::parts::{Image, Texels};
use image::{DynamicImage, ImageDecoder, ImageReader, Rgb};

use crate::diagnostics::{Code, Diagnostic};
use crate::limits::{Budget, Exceeded};
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
    let image = Arc::new(read_asset(session, &asset, name, span)?);
    session.assets.images.insert(asset.path, (asset.digest, Arc::clone(&image)));
    Some(image)
}

fn read_asset(session: &mut Session, asset: &Asset, name: &str, span: Span) -> Option<Image> {
    let decoded = read(&asset.bytes, &mut session.budgets.pixels);
    decoded.map_err(|error| session.found.push(error.explain(session.sources.error(error.code(), span, ""), name))).ok()
}

/// Why a picture cannot be read.
#[derive(Debug)]
pub(crate) enum Unreadable {
    /// It is none, or broken.
    Broken(String),
    /// It has no pixels.
    Empty,
    /// It has more pixels than a scene may have.
    TooLarge(u32, u32, Exceeded),
}

impl Unreadable {
    /// The kind of the problem.
    pub(crate) fn code(&self) -> Code {
        match self {
            Unreadable::TooLarge(..) => Code::Limit,
            _ => Code::Image,
        }
    }

    /// A diagnostic with the reason.
    pub(crate) fn explain(&self, diagnostic: Diagnostic, name: &str) -> Diagnostic {
        match self {
            Unreadable::Broken(reason) => diagnostic
                .message(format!("cannot read the picture {name:?}: {reason}"))
                .expected("a PNG, JPEG, WebP, KTX2, Radiance HDR or OpenEXR file"),
            Unreadable::Empty => diagnostic.message(format!("the picture {name:?} has no pixels")),
            Unreadable::TooLarge(width, height, exceeded) => {
                let message = format!("the picture {name:?} of {width} x {height} pixels is too large: {exceeded}");
                diagnostic.message(message)
            }
        }
    }
}

/// The picture that a file's bytes hold; its pixels are taken from the budget before anything is decoded.
pub(crate) fn read(bytes: &[u8], pixels: &mut Budget) -> Result<Image, Unreadable> {
    reserve(bytes, pixels)?;
    decode(bytes)
}

/// Takes the pixels that a file's first bytes announce from the budget.
pub(crate) fn reserve(bytes: &[u8], pixels: &mut Budget) -> Result<(), Unreadable> {
    let [width, height] = if bytes.starts_with(exr::MAGIC) {
        exr::File::open(bytes).map_err(Unreadable::Broken)?.largest()
    } else if bytes.starts_with(ktx2::MAGIC) {
        ktx2::File::open(bytes).map_err(Unreadable::Broken)?.size()
    } else {
        let reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format();
        reader.map_err(|error| broken(error.into()))?.into_dimensions().map_err(broken)?.into()
    };
    take(pixels, width, height)
}

/// Takes the pixels of a picture from the budget.
pub(crate) fn take(pixels: &mut Budget, width: u32, height: u32) -> Result<(), Unreadable> {
    if width == 0 || height == 0 {
        return Err(Unreadable::Empty);
    }
    let taken = pixels.take(u64::from(width) * u64::from(height));
    taken.map_err(|exceeded| Unreadable::TooLarge(width, height, exceeded))
}

fn broken(error: image::ImageError) -> Unreadable {
    Unreadable::Broken(error.to_string())
}

/// The picture that a file's bytes hold, whose pixels there is room for.
pub(crate) fn decode(bytes: &[u8]) -> Result<Image, Unreadable> {
    if bytes.starts_with(exr::MAGIC) {
        return exr::File::open(bytes).and_then(|file| file.decode()).map_err(Unreadable::Broken);
    }
    if bytes.starts_with(ktx2::MAGIC) {
        return ktx2::File::open(bytes).and_then(|file| file.decode()).map_err(Unreadable::Broken);
    }
    if is_cut_jpeg(bytes) {
        return Err(Unreadable::Broken("the file was cut off".to_owned()));
    }
    let reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format();
    let mut decoder = reader.map_err(|error| broken(error.into()))?.into_decoder().map_err(broken)?;
    let (width, height) = decoder.dimensions();
    // Beside the pixels themselves a decoder needs room of its own, in proportion to them.
    let mut limits = image::Limits::no_limits();
    limits.max_alloc = Some((1 << 24) + 32 * u64::from(width) * u64::from(height));
    decoder.set_limits(limits).map_err(broken)?;
    let image = DynamicImage::from_decoder(decoder).map_err(broken)?;
    Ok(Image { width, height, texels: texels(image) })
}

/// Whether a JPEG breaks off before the mark of its end: the decoder would show gray where pixels are missing.
fn is_cut_jpeg(bytes: &[u8]) -> bool {
    const START_OF_SCAN: u8 = 0xda;
    let Some(mut rest) = bytes.strip_prefix(b"\xff\xd8") else { return false };
    // Up to the pixels, marks lead segments that say how long they are, and that may hold small pictures with ends of their own.
    while let [0xff, mark, high, low, ..] = *rest {
        if mark == START_OF_SCAN {
            return !rest.windows(2).any(|pair| pair == b"\xff\xd9");
        }
        let length = if mark == 0xff { 1 } else { 2 + usize::from(u16::from_be_bytes([high, low])) };
        rest = rest.get(length..).unwrap_or_default();
    }
    false
}

/// A picture as a file that is read back to the bit: PNG, or OpenEXR for linear numbers.
pub(crate) fn write(picture: &Image) -> Result<Vec<u8>, String> {
    use image::ImageEncoder;
    let mut bytes = Cursor::new(Vec::new());
    let Image { width, height, texels } = picture;
    let (color, values) = match texels {
        Texels::Bytes(texels) => (image::ExtendedColorType::Rgba8, texels.as_flattened().to_vec()),
        Texels::Words(texels) => {
            let values = texels.as_flattened().iter().flat_map(|value| value.to_ne_bytes()).collect();
            (image::ExtendedColorType::Rgba16, values)
        }
        Texels::Floats(_) => return exr::write(picture),
    };
    let encoder = image::codecs::png::PngEncoder::new(&mut bytes);
    encoder.write_image(&values, *width, *height, color).map_err(|error| error.to_string())?;
    Ok(bytes.into_inner())
}

/// Takes the pixels of a picture that was read before from what a scene may have, or reports that they are too many.
fn budget(session: &mut Session, name: &str, span: Span, width: u32, height: u32) -> bool {
    take(&mut session.budgets.pixels, width, height)
        .map_err(|error| session.found.push(error.explain(session.sources.error(error.code(), span, ""), name)))
        .is_ok()
}

fn texels(image: DynamicImage) -> Texels {
    use image::ColorType::{L8, L16, La8, La16, Rgb8, Rgb16, Rgba8, Rgba16};
    if let DynamicImage::ImageRgb8(image) = &image {
        return Texels::Bytes(image.pixels().map(|&Rgb([r, g, b])| [r, g, b, u8::MAX]).collect());
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn linear_numbers_are_the_same_file_every_time() {
        let texels = Texels::Floats((0..256 * 512).map(|at| [at as f32, (at / 256) as f32, 0.5]).collect());
        let picture = Image { width: 256, height: 512, texels };
        let first = write(&picture).expect("it can be written");
        assert_eq!(decode(&first).expect("it can be read"), picture);
        for _ in 0..16 {
            assert!(write(&picture).expect("it can be written") == first, "another file");
        }
    }

    /// Wherever it breaks off, also where its head holds a small picture that is whole.
    #[test]
    fn a_jpeg_that_was_cut_off_is_no_picture() {
        let pixels: Vec<u8> = (0..3 * 40 * 24u32).map(|i| (i * i % 251) as u8).collect();
        let mut whole = Vec::new();
        let mut encoder = image::codecs::jpeg::JpegEncoder::new(&mut whole);
        encoder.encode(&pixels, 40, 24, image::ExtendedColorType::Rgb8).expect("a buffer takes all");
        let small = [b"\xff\xe1", &(2 + whole.len() as u16).to_be_bytes()[..], &whole].concat();
        let nested = [b"\xff\xd8", &small[..], &whole[2..]].concat();
        for file in [whole, nested] {
            assert_eq!(decode(&file).map(|image| (image.width, image.height)).ok(), Some((40, 24)));
            let long_enough = decode(&[&file[..], b"behind it"].concat());
            assert!(long_enough.is_ok(), "{long_enough:?}");
            for end in (0..file.len()).step_by(7) {
                assert!(decode(&file[..end]).is_err(), "{end} of {}", file.len());
            }
        }
    }
}
