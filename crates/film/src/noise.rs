//! How far a mean may be off: standard errors from sums and sums of squares, and the noise that an observer sees of them.

use std::ops::Range;

use crate::{Film, SCALE};

/// What keeps the noise of black finite: a radiance that a display hardly shows.
const DARK: f64 = 0.001;

impl Film {
    /// The noise of a run of pixels as part of a display's range: the root of the mean square, over pixels and channels, of
    /// the standard error of √L, a display value of gamma 2 for a radiance L of which 1 is white. To first order that is the
    /// standard error of L over 2 √(L + 0.001).
    ///
    /// # Panics
    ///
    /// The film does not keep squares.
    pub fn noise(&self, run: Range<u32>) -> f64 {
        let (pixels, squares) = (self.pixels(), self.squares().expect("the film keeps squares"));
        let (mut sum, values) = (0.0, (3 * run.len()) as f64);
        for index in run.start as usize..run.end as usize {
            let (color, samples) = (pixels.color[index].0, pixels.samples[index]);
            for (color, squares) in color.into_iter().zip(squares.light[index]) {
                let error = standard_error(color, squares, samples);
                let mean = color as f64 / (SCALE * f64::from(samples.max(1)));
                sum += error * error / (4.0 * (mean + DARK));
            }
        }
        (sum / values).sqrt()
    }
}

/// The standard error of the mean of `samples` fixed-point numbers, of which the sum and the sum of squares are given, in nit;
/// infinite for less than two.
///
/// It takes the numbers for independent. Samples that are spread evenly, as Sobol points are, err less: there it is an
/// upper estimate.
///
/// Nothing cancels: with m the mean, rounded down, the squares' distance from it, Σ(x-m)² = Σx² - m(2Σx - nm), is exact in
/// whole numbers.
pub(crate) fn standard_error(sum: i64, squares: u128, samples: u32) -> f64 {
    if samples < 2 {
        return f64::INFINITY;
    }
    let (sum, n) = (u128::from(sum.unsigned_abs()), u128::from(samples));
    let mean = sum / n;
    let around = squares.saturating_sub(mean * (2 * sum - n * mean));
    // What the mean's rounding added to each.
    let (rest, n) = ((sum % n) as f64, f64::from(samples));
    let deviation = (around as f64 - rest * rest / n).max(0.0);
    (deviation / (n * (n - 1.0))).sqrt() / SCALE
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Keep, Light, PixelOrder};

    /// From the definition, in f64 around the exact mean.
    fn by_definition(values: &[i64]) -> f64 {
        let n = values.len() as f64;
        let mean = values.iter().map(|&value| value as f64).sum::<f64>() / n;
        let squares: f64 = values.iter().map(|&value| (value as f64 - mean).powi(2)).sum();
        (squares / (n * (n - 1.0))).sqrt() / SCALE
    }

    /// By hand: samples 0 and 2 have mean 1 and standard error 1, so √L errs by 1/(2 √1.001); samples 1 and 1 do not err.
    #[test]
    fn noise_is_that_of_the_display_value() {
        let mut film = Film::keeping(PixelOrder::new(3, 1, None).unwrap(), Keep::ALL);
        let mut tile = film.tile_mut();
        for value in [0.0, 2.0] {
            tile.add_sample(0, Light::new([1.0; 3]).unwrap());
            tile.add_sample(1, Light::new([value, 1.0, 1.0]).unwrap());
            tile.add_sample(2, Light::new([value; 3]).unwrap());
        }
        let one = 0.25 / 1.001;
        for (run, expected) in [(0..1, 0.0), (2..3, one), (1..2, one / 3.0), (0..3, one * 4.0 / 9.0)] {
            assert!((film.noise(run.clone()) - f64::sqrt(expected)).abs() < 1e-12, "{run:?}");
        }
    }

    #[test]
    fn errors_are_those_of_the_definition() {
        let cases: [&[i64]; 6] = [
            &[0, 0],
            &[0, 1],
            &[1 << 32, 2 << 32, 3 << 32, 4 << 32],
            &[7, 7, 8],
            &[(1 << 50) + 3, (1 << 50) + 1, (1 << 50) + 2],
            &[1 << 61, 0, 0],
        ];
        for values in cases {
            let squares = values.iter().map(|&value| (value as u128).pow(2)).sum();
            let found = standard_error(values.iter().sum(), squares, values.len() as u32);
            let expected = by_definition(values);
            assert!((found - expected).abs() <= 1e-12 * expected, "{values:?}: {found}, not {expected}");
        }
        assert_eq!(standard_error(5, 25, 1), f64::INFINITY);
    }
}
