//! From spectra to colors: what a property measured over wavelengths is worth in each Rec.709 channel.
//!
//! Wavelengths are in nanometers in air. The CIE 1931 2° observer is the analytic fit of C. Wyman, P.-P. Sloan and
//! P. Shirley, *Simple Analytic Approximations to the CIE XYZ Color Matching Functions*, JCGT 2(2), 2013 (their
//! multi-lobe fit, within 0.023 of the table); the illuminant D65 is the CIE's table (ISO/CIE 11664-2), every 10 nm.

use brewster_lanes::math;
use glam::Vec3;

/// The wavelengths that matter to the eye, in nanometers; the tables of this crate cover them.
pub const VISIBLE: core::ops::RangeInclusive<f32> = 380.0..=780.0;

/// The step of the integral over [`VISIBLE`], in nanometers.
const STEP: f32 = 5.0;

/// Relative power of the CIE standard illuminant D65 from 380 nm to 780 nm, every 10 nm.
#[rustfmt::skip]
const D65: [f32; 41] = [
    49.9755, 54.6482, 82.7549, 91.486, 93.4318, 86.6823, 104.865, 117.008, 117.812, 114.861, 115.923, 108.811,
    109.354, 107.802, 104.79, 107.689, 104.405, 104.046, 100.0, 96.3342, 95.788, 88.6856, 90.0062, 89.5991,
    87.6987, 83.2886, 83.6992, 80.0268, 80.2146, 82.2778, 78.2842, 69.7213, 71.6091, 74.349, 61.604, 69.8856,
    75.087, 63.5927, 46.4182, 66.8054, 63.3828,
];

/// Rec.709's primaries and white point as a matrix from CIE XYZ, row by row (IEC 61966-2-1, with more digits).
const REC709_FROM_XYZ: [Vec3; 3] = [
    Vec3::new(3.240_97, -1.537_383_2, -0.498_610_76),
    Vec3::new(-0.969_243_64, 1.875_967_5, 0.041_555_06),
    Vec3::new(0.055_630_08, -0.203_976_96, 1.056_971_5),
];

/// What each Rec.709 channel makes of a spectrum seen under D65.
///
/// Each channel is an average weighted by D65 and the channel's matching function, so a property that is the same at
/// every wavelength keeps its value. The functions of the real Rec.709 primaries are negative in places: a saturated
/// spectrum may leave the range of its values.
pub fn rec709_average(spectrum: impl Fn(f32) -> f32) -> Vec3 {
    let (mut sum, mut weights) = (Vec3::ZERO, Vec3::ZERO);
    let steps = ((VISIBLE.end() - VISIBLE.start()) / STEP) as u32;
    for wavelength in (0..=steps).map(|step| VISIBLE.start() + step as f32 * STEP) {
        let xyz = observer(wavelength) * d65(wavelength);
        let weight = Vec3::from_array(REC709_FROM_XYZ.map(|row| row.dot(xyz)));
        sum += weight * spectrum(wavelength);
        weights += weight;
    }
    sum / weights
}

/// The color matching functions x̄, ȳ, z̄ of the CIE 1931 2° observer at a wavelength.
pub fn observer(wavelength: f32) -> Vec3 {
    let lobe = |height: f32, center: f32, below: f32, above: f32| {
        let distance = (wavelength - center) * if wavelength < center { below } else { above };
        height * math::exp(-0.5 * distance * distance)
    };
    Vec3::new(
        lobe(0.362, 442.0, 0.0624, 0.0374) + lobe(1.056, 599.8, 0.0264, 0.0323) + lobe(-0.065, 501.1, 0.049, 0.0382),
        lobe(0.821, 568.8, 0.0213, 0.0247) + lobe(0.286, 530.9, 0.0613, 0.0322),
        lobe(1.217, 437.0, 0.0845, 0.0278) + lobe(0.681, 459.0, 0.0385, 0.0725),
    )
}

/// The relative power of the CIE standard illuminant D65, 100 at 560 nm; its end values beyond the table.
pub fn d65(wavelength: f32) -> f32 {
    let place = ((wavelength - VISIBLE.start()) / 10.0).clamp(0.0, (D65.len() - 1) as f32);
    let row = (place as usize).min(D65.len() - 2);
    let part = place - row as f32;
    D65[row] * (1.0 - part) + D65[row + 1] * part
}

/// The value of a table at a wavelength, by straight lines; its end values beyond the table.
///
/// `wavelengths` grow, and both columns are of the same length, at least one row.
pub fn interpolate(wavelengths: &[f32], values: &[f32], wavelength: f32) -> f32 {
    let above = wavelengths.partition_point(|row| *row <= wavelength);
    if above == 0 {
        return values[0];
    }
    if above == wavelengths.len() {
        return values[above - 1];
    }
    let (low, high) = (wavelengths[above - 1], wavelengths[above]);
    let part = (wavelength - low) / (high - low);
    values[above - 1] * (1.0 - part) + values[above] * part
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows of the CIE's table of the 1931 observer (ISO/CIE 11664-1).
    #[test]
    fn the_observer_is_near_the_table() {
        let table = [
            (400.0, [0.014_31, 0.000_396, 0.067_85]),
            (450.0, [0.336_2, 0.038, 1.772_11]),
            (500.0, [0.004_9, 0.323, 0.272]),
            (550.0, [0.433_45, 0.994_95, 0.008_75]),
            (600.0, [1.062_2, 0.631, 0.000_8]),
            (650.0, [0.283_5, 0.107, 0.0]),
            (700.0, [0.011_359, 0.004_102, 0.0]),
        ];
        for (wavelength, expected) in table {
            let result = observer(wavelength);
            assert!(result.abs_diff_eq(Vec3::from_array(expected), 0.023), "{wavelength}: {result} {expected:?}");
        }
    }

    /// D65 has the chromaticity (0.3127, 0.3290), and is Rec.709's white: the weights of all channels add up alike.
    #[test]
    fn d65_is_white() {
        let sum: Vec3 = (0..=80).map(|step| 380.0 + 5.0 * step as f32).map(|w| observer(w) * d65(w)).sum();
        let (x, y) = (sum.x / sum.element_sum(), sum.y / sum.element_sum());
        assert!((x - 0.3127).abs() < 1e-3 && (y - 0.3290).abs() < 1e-3, "{x} {y}");
        let white = Vec3::from_array(REC709_FROM_XYZ.map(|row| row.dot(sum / sum.y)));
        assert!(white.abs_diff_eq(Vec3::ONE, 0.01), "{white}");
        assert_eq!((d65(380.0), d65(560.0), d65(565.0)), (49.9755, 100.0, 0.5 * (100.0 + 96.3342)));
        assert_eq!((d65(0.0), d65(900.0)), (49.9755, 63.3828));
    }

    #[test]
    fn flat_spectra_are_gray() {
        assert!(rec709_average(|_| 1.5).abs_diff_eq(Vec3::splat(1.5), 1e-5));
        let red = rec709_average(|wavelength| if wavelength > 600.0 { 1.0 } else { 0.0 });
        assert!(red.x > 0.6 && red.y < 0.1 && red.z.abs() < 0.02, "{red}");
        let blue = rec709_average(|wavelength| if wavelength < 480.0 { 1.0 } else { 0.0 });
        assert!(blue.z > 0.8 && blue.y < 0.0 && blue.x < 0.1, "{blue}");
    }

    #[test]
    fn tables_are_read_by_straight_lines() {
        let (wavelengths, values) = ([400.0, 500.0, 700.0], [1.0, 3.0, 2.0]);
        for (wavelength, expected) in
            [(300.0, 1.0), (400.0, 1.0), (450.0, 2.0), (500.0, 3.0), (600.0, 2.5), (700.0, 2.0), (800.0, 2.0)]
        {
            assert_eq!(interpolate(&wavelengths, &values, wavelength), expected, "{wavelength}");
        }
        assert_eq!(interpolate(&[500.0], &[1.5], 400.0), 1.5);
    }
}
