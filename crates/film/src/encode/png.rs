//! PNG: display values with 8 bits, dithered, or 16 bits, rounded.

use std::path::Path;

use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};

use super::codec_error;
use crate::{Display, FilmError, LinearImage, write_atomically};

/// How a PNG is written.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PngSettings {
    /// From radiance to display values.
    pub display: Display,
    /// Bits per channel.
    pub depth: PngDepth,
    /// What becomes of alpha.
    pub alpha: PngAlpha,
}

/// Bits per channel of a PNG.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PngDepth {
    /// 8 bits, dithered: see [`write_png`].
    #[default]
    Eight,
    /// 16 bits, rounded to the nearest.
    Sixteen,
}

/// What becomes of alpha in a PNG.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PngAlpha {
    /// It is dropped: the picture is shown on black, with what radiance reached the film beside objects.
    #[default]
    Opaque,
    /// It is written, and colors are divided by it, as PNG wants them. Only right for a film without radiance beside
    /// objects.
    Straight,
}

/// Writes a picture.
///
/// With 8 bits a value between two levels becomes the upper one in as many pixels as it lies above the lower: the
/// threshold of pixel (x, y) is the fraction x·g⁻¹ + y·g⁻² with the plastic number g (M. Roberts, "The unreasonable
/// effectiveness of quasirandom sequences", 2018), which fills 0..1 evenly in any region and looks like blue noise. It is
/// the same for all channels, so that gray stays gray, and takes 256 values inside 0..1, so that a value that is a level
/// stays one: a PNG that is read and written again keeps its bytes.
///
/// # Errors
///
/// The file can't be written.
pub fn write_png(path: &Path, image: &LinearImage, settings: &PngSettings) -> Result<(), FilmError> {
    let bytes = match settings.depth {
        PngDepth::Eight => quantized(image, settings, |value, x, y| [(value * 255.0 + threshold(x, y)) as u8]),
        PngDepth::Sixteen => quantized(image, settings, |value, _, _| ((value * 65535.0 + 0.5) as u16).to_ne_bytes()),
    };
    let color_type = match (settings.depth, settings.alpha) {
        (PngDepth::Eight, PngAlpha::Opaque) => ExtendedColorType::Rgb8,
        (PngDepth::Eight, PngAlpha::Straight) => ExtendedColorType::Rgba8,
        (PngDepth::Sixteen, PngAlpha::Opaque) => ExtendedColorType::Rgb16,
        (PngDepth::Sixteen, PngAlpha::Straight) => ExtendedColorType::Rgba16,
    };
    write_atomically(path, |file| {
        let encoder = PngEncoder::new(file);
        encoder.write_image(&bytes, image.width, image.height, color_type).map_err(|error| codec_error(path, error))
    })
}

/// The picture's channels, each turned to bytes by `quantize(value, x, y)`; floats cut when they become integers.
fn quantized<const N: usize>(
    image: &LinearImage,
    settings: &PngSettings,
    quantize: impl Fn(f32, u32, u32) -> [u8; N],
) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(image.color.len() * 4 * N);
    for (index, &color) in image.color.iter().enumerate() {
        let (x, y) = (index as u32 % image.width, index as u32 / image.width);
        let alpha = image.alpha.as_ref().map_or(1.0, |alpha| alpha[index].clamp(0.0, 1.0));
        let color = match settings.alpha {
            PngAlpha::Straight if alpha > 0.0 => color.map(|value| value / alpha),
            PngAlpha::Straight => [0.0; 3],
            PngAlpha::Opaque => color,
        };
        for value in settings.display.encode(color) {
            bytes.extend(quantize(value, x, y));
        }
        if settings.alpha == PngAlpha::Straight {
            bytes.extend(quantize(alpha, x, y));
        }
    }
    bytes
}

/// The part of a step that must be missing at most for a value to be rounded up: (n + ½) / 256 with n in 0..256.
fn threshold(x: u32, y: u32) -> f32 {
    // 2^32 / g and 2^32 / g², with g = 1.32471795724474602596.
    let turn = x.wrapping_mul(3_242_174_889).wrapping_add(y.wrapping_mul(2_447_445_414));
    ((turn >> 24) as f32 + 0.5) / 256.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ToneMap, read_image, srgb_decode, srgb_encode};

    fn written(image: &LinearImage, settings: &PngSettings) -> image::DynamicImage {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture.png");
        write_png(&path, image, settings).unwrap();
        image::open(&path).unwrap()
    }

    fn even(size: u32, encoded: f32) -> LinearImage {
        let mut image = LinearImage::black(size, size);
        image.color.fill([srgb_decode(encoded); 3]);
        image
    }

    #[test]
    fn dithering_keeps_the_mean_and_moves_no_value_by_a_level() {
        for level in [0.25f32, 3.1, 100.5, 127.9, 254.7] {
            let bytes = written(&even(64, level / 255.0), &PngSettings::default()).into_rgb8().into_raw();
            let mean = bytes.iter().map(|&byte| f64::from(byte)).sum::<f64>() / bytes.len() as f64;
            assert!((mean - f64::from(level)).abs() < 0.005, "mean {mean} for {level}");
            let near = [level.floor() as u8, level.ceil() as u8];
            assert!(bytes.iter().all(|byte| near.contains(byte)), "{level}");
        }
    }

    #[test]
    fn the_mean_is_kept_in_small_regions_too() {
        for (x, y) in [(0, 0), (1000, 17), (65_000, 65_000)] {
            let block = (y..y + 16).flat_map(|y| (x..x + 16).map(move |x| threshold(x, y)));
            assert!((block.sum::<f32>() / 256.0 - 0.5).abs() < 0.01, "{x}, {y}");
        }
    }

    #[test]
    fn levels_stay_levels_when_read_and_written_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("levels.png");
        let ramp = image::RgbImage::from_fn(256, 3, |x, y| image::Rgb([x as u8, 255 - x as u8, (x * y) as u8]));
        ramp.save(&path).unwrap();
        let image = read_image(&path).unwrap();
        assert_eq!(written(&image, &PngSettings::default()).into_rgb8(), ramp);
    }

    #[test]
    fn sixteen_bits_are_rounded_to_the_nearest() {
        let settings = PngSettings { depth: PngDepth::Sixteen, ..PngSettings::default() };
        for linear in [0.0, 1e-5, 0.18, 0.5, 1.0, 7.0] {
            let mut image = LinearImage::black(2, 1);
            image.color[1] = [linear, 0.0, 1.0];
            let image::DynamicImage::ImageRgb16(pixels) = written(&image, &settings) else { panic!("not 16 bits") };
            let expected = (f64::from(srgb_encode(linear)) * 65535.0).round() as u16;
            assert_eq!(pixels.get_pixel(1, 0).0, [expected, 0, 65535], "{linear}");
        }
    }

    #[test]
    fn alpha_divides_colors() {
        let mut image = LinearImage::black(3, 1);
        image.color = vec![[0.25, 0.5, 0.0], [0.7; 3], [1.0; 3]];
        image.alpha = Some(vec![0.5, 0.0, 1.0]);
        let settings = PngSettings { depth: PngDepth::Sixteen, alpha: PngAlpha::Straight, ..PngSettings::default() };
        let pixels = written(&image, &settings).into_rgba16();
        // sRGB of 0.5 is 0.735357; half of 65535 rounds up.
        assert_eq!(pixels.get_pixel(0, 0).0, [48192, 65535, 0, 32768]);
        assert_eq!(pixels.get_pixel(1, 0).0, [0; 4]);
        assert_eq!(pixels.get_pixel(2, 0).0, [65535; 4]);
        assert_eq!(written(&image, &PngSettings::default()).color(), image::ColorType::Rgb8);
    }

    #[test]
    fn the_display_decides() {
        let mut image = LinearImage::black(1, 1);
        image.color[0] = [2.8; 3];
        let display = Display { exposure: 1.0, tone_map: ToneMap::Filmic };
        let pixels = written(&image, &PngSettings { display, ..PngSettings::default() }).into_rgb8();
        assert_eq!(pixels.get_pixel(0, 0).0, [255; 3]);
    }
}
