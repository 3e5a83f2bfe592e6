//! How much two pictures differ: figures, and a picture of the difference.

use crate::{FilmError, LinearImage, srgb_decode};

/// Figures of the difference between a picture and a reference, over all channels of all pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Difference {
    /// The mean of the squared differences.
    pub mse: f64,
    /// The mean of the squared differences, each divided by the reference's square plus [`Difference::EPSILON`].
    pub relative_mse: f64,
    /// The mean of the absolute differences.
    pub mean_absolute: f64,
    /// The mean of test less reference: what a test is too bright.
    pub bias: f64,
    /// The largest absolute difference.
    pub largest: f64,
    /// Values that are NaN or infinite in either picture; they are in no other figure.
    pub not_finite: u64,
}

impl Difference {
    /// What keeps the relative error of black finite.
    pub const EPSILON: f64 = 0.01;
}

/// Compares the colors of two pictures; alpha is not looked at.
///
/// # Errors
///
/// The sizes differ.
pub fn compare(reference: &LinearImage, test: &LinearImage) -> Result<Difference, FilmError> {
    check_sizes(reference, test)?;
    let values = || reference.color.as_flattened().iter().zip(test.color.as_flattened());
    let finite = || {
        let pairs = values().filter(|(reference, test)| reference.is_finite() && test.is_finite());
        pairs.map(|(&reference, &test)| (f64::from(reference), f64::from(test)))
    };
    let count = finite().count();
    let mean = |of: &dyn Fn(f64, f64) -> f64| {
        finite().map(|(reference, test)| of(reference, test)).sum::<f64>() / count.max(1) as f64
    };
    let square = |value: f64| value * value;
    Ok(Difference {
        mse: mean(&|reference, test| square(test - reference)),
        relative_mse: mean(&|reference, test| square(test - reference) / (square(reference) + Difference::EPSILON)),
        mean_absolute: mean(&|reference, test| (test - reference).abs()),
        bias: mean(&|reference, test| test - reference),
        largest: finite().map(|(reference, test)| (test - reference).abs()).fold(0.0, f64::max),
        not_finite: (values().count() - count) as u64,
    })
}

/// The largest absolute difference of the three channels at each pixel, infinite where a value is not finite.
///
/// # Errors
///
/// The sizes differ.
pub fn difference_map(reference: &LinearImage, test: &LinearImage) -> Result<Vec<f32>, FilmError> {
    check_sizes(reference, test)?;
    let largest = |(reference, test): (&[f32; 3], &[f32; 3])| {
        let differences = [0, 1, 2].map(|channel| (test[channel] - reference[channel]).abs());
        if differences.iter().all(|value| value.is_finite()) {
            differences.into_iter().fold(0.0, f32::max)
        } else {
            f32::INFINITY
        }
    };
    Ok(reference.color.iter().zip(&test.color).map(largest).collect())
}

/// A map of values as a picture: 0 is black, `white` and above is the bright end of matplotlib's color map Magma (S. van der
/// Walt and N. Smith, CC0), whose lightness grows evenly. Meant for [`crate::ToneMap::Srgb`] at exposure 0.
///
/// # Panics
///
/// The map has not `width` x `height` values.
pub fn map_picture(width: u32, height: u32, map: &[f32], white: f32) -> LinearImage {
    let mut image = LinearImage::black(width, height);
    assert_eq!(map.len(), image.color.len(), "a map of {width}x{height} values");
    for (color, &value) in image.color.iter_mut().zip(map) {
        *color = magma(value / white);
    }
    image
}

/// The color of a value; nine samples of the published map, joined by straight lines between display values.
fn magma(value: f32) -> [f32; 3] {
    const COLORS: [u32; 9] = [0x000004, 0x1c1044, 0x4f127b, 0x812581, 0xb5367a, 0xe55964, 0xfb8761, 0xfec287, 0xfcfdbf];
    // What is NaN is as wrong as can be.
    let place = if value.is_nan() { 1.0 } else { value.clamp(0.0, 1.0) } * 8.0;
    let low = (place as usize).min(7);
    let part = place - low as f32;
    [16, 8, 0].map(|shift| {
        let [near, far] = [COLORS[low], COLORS[low + 1]].map(|color| (color >> shift & 0xff) as f32 / 255.0);
        srgb_decode(near + (far - near) * part)
    })
}

pub(crate) fn check_sizes(reference: &LinearImage, test: &LinearImage) -> Result<(), FilmError> {
    let size = |image: &LinearImage| format!("{}x{} pixels", image.width, image.height);
    if (reference.width, reference.height) != (test.width, test.height) {
        return Err(FilmError::Mismatch { left: size(reference), right: size(test) });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(colors: &[[f32; 3]]) -> LinearImage {
        let mut image = LinearImage::black(colors.len() as u32, 1);
        image.color = colors.to_vec();
        image
    }

    #[test]
    fn figures_are_those_worked_out_by_hand() {
        let reference = picture(&[[1.0, 0.0, 2.0], [0.5, 0.5, 0.5]]);
        let test = picture(&[[1.5, 0.0, 1.0], [0.5, 0.25, 0.5]]);
        let found = compare(&reference, &test).unwrap();
        assert_eq!(found.mse, (0.25 + 1.0 + 0.0625) / 6.0);
        assert_eq!(found.relative_mse, (0.25 / 1.01 + 1.0 / 4.01 + 0.0625 / 0.26) / 6.0);
        assert_eq!(found.mean_absolute, 1.75 / 6.0);
        assert_eq!(found.bias, -0.75 / 6.0);
        assert_eq!((found.largest, found.not_finite), (1.0, 0));
        assert_eq!(difference_map(&reference, &test).unwrap(), [1.0, 0.25]);
    }

    #[test]
    fn a_picture_does_not_differ_from_itself() {
        let image = picture(&[[1.0, 1e30, 0.0]]);
        let zero =
            Difference { mse: 0.0, relative_mse: 0.0, mean_absolute: 0.0, bias: 0.0, largest: 0.0, not_finite: 0 };
        assert_eq!(compare(&image, &image).unwrap(), zero);
    }

    #[test]
    fn values_that_are_not_finite_are_counted_apart() {
        let reference = picture(&[[f32::NAN, 1.0, f32::INFINITY]]);
        let test = picture(&[[1.0, 3.0, f32::INFINITY]]);
        let found = compare(&reference, &test).unwrap();
        assert_eq!((found.mse, found.largest, found.not_finite), (4.0, 2.0, 2));
        assert_eq!(difference_map(&reference, &test).unwrap(), [f32::INFINITY]);
    }

    #[test]
    fn sizes_must_match() {
        let message = compare(&LinearImage::black(2, 3), &LinearImage::black(3, 2)).unwrap_err().to_string();
        assert_eq!(message, "the pictures do not match: 2x3 pixels against 3x2 pixels");
        assert!(difference_map(&LinearImage::black(2, 3), &LinearImage::black(3, 2)).is_err());
    }

    #[test]
    fn a_map_becomes_colors_from_black_to_bright() {
        let image = map_picture(6, 1, &[0.0, 1.0, 2.0, 9.0, f32::NAN, 0.125], 2.0);
        let shown: Vec<_> =
            image.color.iter().map(|color| color.map(|value| crate::srgb_encode(value) * 255.0)).collect();
        let bright = [252.0, 253.0, 191.0];
        let expected = [[0.0, 0.0, 4.0], [181.0, 54.0, 122.0], bright, bright, bright, [14.0, 8.0, 36.0]];
        for (shown, expected) in shown.as_flattened().iter().zip(expected.as_flattened()) {
            assert!((shown - expected).abs() < 0.01, "{shown} for {expected}");
        }
    }
}
