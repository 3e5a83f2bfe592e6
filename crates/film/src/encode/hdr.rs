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
    let pixels: Vec<_> = image.color.iter().map(|&color| Rgb(color)).collect();
    write_atomically(path, |file| {
        let encoder = HdrEncoder::new(file);
        encoder.encode(&pixels, image.width as usize, image.height as usize).map_err(|error| codec_error(path, error))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::read_image;

    #[test]
    fn radiance_comes_back_to_eight_bits() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("radiance.hdr");
        let mut image = LinearImage::black(16, 3);
        image.color[5] = [1.0, 0.5, 0.25];
        image.color[20] = [1000.0, 3.0, 0.0];
        write_hdr(&path, &image).unwrap();
        let back = read_image(&path).unwrap();
        assert_eq!((back.width, back.height, &back.alpha), (16, 3, &None));
        for (found, expected) in back.color.iter().zip(&image.color) {
            let step = expected.iter().fold(0.0f32, |a, &b| a.max(b)) / 128.0;
            for (found, expected) in found.iter().zip(expected) {
                assert!((found - expected).abs() <= step, "{found} for {expected}");
            }
        }
    }
}
