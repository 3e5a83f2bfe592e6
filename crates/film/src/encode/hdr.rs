//! Radiance HDR (RGBE): linear color with a shared exponent, for programs that read no EXR.

use std::path::Path;

use image::{Rgb, codecs::hdr::HdrEncoder};

use super::codec_error;
use crate::{FilmError, LinearImage, write_atomically};

/// Writes the colors of a picture; alpha is dropped. A component keeps 8 bits relative to its pixel's largest.
///
/// # Errors
///
/// The file can't be written.
pub fn write_hdr(path: &Path, image: &LinearImage) -> Result<(), FilmError> {
    let pixels: Vec<_> = image.color.iter().map(|&color| Rgb(rounded(color))).collect();
    write_atomically(path, |file| {
        let encoder = HdrEncoder::new(file);
        encoder.encode(&pixels, image.width as usize, image.height as usize).map_err(|error| codec_error(path, error))
    })
}

/// A color with its components rounded to 8 bits of the largest. The encoder cuts off what is beyond, which would darken the
/// picture.
fn rounded(color: [f32; 3]) -> [f32; 3] {
    let largest = color.into_iter().fold(0.0, f32::max);
    // Bit 7 is the power of two at or below the largest component as it is rounded.
    let power_of_two = |x: f32| f32::from_bits(x.to_bits() & 0x7f80_0000);
    let step = power_of_two(largest + power_of_two(largest) / 256.0) / 128.0;
    if step > 0.0 && step.is_finite() { color.map(|c| (c / step + 0.5).floor() * step) } else { color }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::read_image;

    #[test]
    fn radiance_comes_back_to_eight_bits_and_no_darker() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("radiance.hdr");
        let mut image = LinearImage::black(32, 32);
        for (i, color) in image.color.iter_mut().enumerate().skip(1) {
            *color = [0.7 + i as f32 * 0.01, (i * 7 % 64) as f32 / 9.0, 30.0 / i as f32];
        }
        image.color[5] = [1.0, 0.5, 0.25];
        image.color[20] = [1000.0, 3.0, 0.0];
        image.color[21] = [1.999_999_9, 1.0, 1e-30];
        write_hdr(&path, &image).unwrap();
        let back = read_image(&path).unwrap();
        assert_eq!((back.width, back.height, &back.alpha), (32, 32, &None));
        let mut sum = 0.0;
        for (found, expected) in back.color.iter().zip(&image.color) {
            let step = expected.iter().fold(0.0f32, |a, &b| a.max(b)) / 128.0;
            for (found, expected) in found.iter().zip(expected) {
                assert!((found - expected).abs() <= 0.502 * step, "{found} for {expected}");
                sum += if step > 0.0 { (found - expected) / step } else { 0.0 };
            }
        }
        // In half steps cut off this would be -0.25 or less.
        let mean = sum / (3 * back.color.len()) as f32;
        assert!(mean.abs() < 0.03, "pixels are {mean} steps off on average");
    }
}
