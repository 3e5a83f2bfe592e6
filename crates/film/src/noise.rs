//! How far a mean may be off: standard errors from sums and sums of squares.

use crate::SCALE;

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

    /// From the definition, in f64 around the exact mean.
    fn by_definition(values: &[i64]) -> f64 {
        let n = values.len() as f64;
        let mean = values.iter().map(|&value| value as f64).sum::<f64>() / n;
        let squares: f64 = values.iter().map(|&value| (value as f64 - mean).powi(2)).sum();
        (squares / (n * (n - 1.0))).sqrt() / SCALE
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
