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

/// The color matching functions of the CIE 1931 2° observer from 380 nm to 780 nm, every 10 nm (ISO/CIE 11664-1).
#[rustfmt::skip]
const CIE_1931: [[f64; 3]; BAND_ROWS] = [
    [0.001_368, 0.000_039, 0.006_45], [0.004_243, 0.000_12, 0.020_05], [0.014_31, 0.000_396, 0.067_85],
    [0.043_51, 0.001_21, 0.207_4], [0.134_38, 0.004, 0.645_6], [0.283_9, 0.011_6, 1.385_6],
    [0.348_28, 0.023, 1.747_06], [0.336_2, 0.038, 1.772_11], [0.290_8, 0.06, 1.669_2], [0.195_36, 0.090_98, 1.287_64],
    [0.095_64, 0.139_02, 0.812_95], [0.032_01, 0.208_02, 0.465_18], [0.004_9, 0.323, 0.272], [0.009_3, 0.503, 0.158_2],
    [0.063_27, 0.71, 0.078_25], [0.165_5, 0.862, 0.042_16], [0.290_4, 0.954, 0.020_3], [0.433_45, 0.994_95, 0.008_75],
    [0.594_5, 0.995, 0.003_9], [0.762_1, 0.952, 0.002_1], [0.916_3, 0.87, 0.001_65], [1.026_3, 0.757, 0.001_1],
    [1.062_2, 0.631, 0.000_8], [1.002_6, 0.503, 0.000_34], [0.854_45, 0.381, 0.000_19], [0.642_4, 0.265, 0.000_05],
    [0.447_9, 0.175, 0.000_02], [0.283_5, 0.107, 0.0], [0.164_9, 0.061, 0.0], [0.087_4, 0.032, 0.0],
    [0.046_77, 0.017, 0.0], [0.022_7, 0.008_21, 0.0], [0.011_359, 0.004_102, 0.0], [0.005_79, 0.002_091, 0.0],
    [0.002_899, 0.001_047, 0.0], [0.001_44, 0.000_52, 0.0], [0.000_69, 0.000_249, 0.0], [0.000_332, 0.000_12, 0.0],
    [0.000_166, 0.000_06, 0.0], [0.000_083, 0.000_03, 0.0], [0.000_042, 0.000_015, 0.0],
];

/// Rows of [`BANDS`].
pub(crate) const BAND_ROWS: usize = 41;

/// The step between the rows of [`BANDS`], in nanometers.
pub(crate) const BAND_STEP: f64 = 10.0;

/// The part of a channel's light that lies at each wavelength, per nanometer, from 380 nm on; straight lines between.
///
/// These are the matching functions of the Rec.709 primaries, cut off below 0 and scaled to an integral of 1 each.
/// [`dispersion`](crate::dispersion) says why.
pub(crate) const BANDS: [[f64; 3]; BAND_ROWS] = bands();

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

const fn bands() -> [[f64; 3]; BAND_ROWS] {
    let mut bands = [[0.0; 3]; BAND_ROWS];
    let mut channel = 0;
    while channel < 3 {
        let [x, y, z] = REC709_FROM_XYZ[channel].to_array();
        let (mut row, mut total) = (0, 0.0);
        while row < BAND_ROWS {
            let [x_bar, y_bar, z_bar] = CIE_1931[row];
            bands[row][channel] = (x as f64 * x_bar + y as f64 * y_bar + z as f64 * z_bar).max(0.0);
            // The integral of the straight lines: the first and the last row count half.
            let part = if row == 0 || row == BAND_ROWS - 1 { 0.5 } else { 1.0 };
            total += bands[row][channel] * part * BAND_STEP;
            row += 1;
        }
        row = 0;
        while row < BAND_ROWS {
            bands[row][channel] /= total;
            row += 1;
        }
        channel += 1;
    }
    bands
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

    /// The table and the published fit of it agree to what the fit states; and the luminous efficiency ȳ sums up to
    /// 106.857 nm (Wyszecki and Stiles, *Color Science*, table 3.3.1).
    #[test]
    fn the_table_is_near_the_fit() {
        for (row, table) in CIE_1931.iter().enumerate() {
            let (wavelength, table) = (380.0 + 10.0 * row as f32, table.map(|value| value as f32));
            let fit = observer(wavelength);
            assert!(fit.abs_diff_eq(Vec3::from_array(table), 0.03), "{wavelength}: {fit} {table:?}");
        }
        let sum = CIE_1931.iter().map(|row| 10.0 * row[1]).sum::<f64>();
        assert!((sum - 106.857).abs() < 0.01, "{sum}");
    }

    /// Against the fit of the observer in place of the table, cut off and scaled likewise, in steps of 1 nm.
    #[test]
    fn bands_are_the_matching_functions_cut_off() {
        let band = |wavelength: f32| {
            let xyz = observer(wavelength);
            Vec3::from_array(REC709_FROM_XYZ.map(|row| row.dot(xyz))).max(Vec3::ZERO)
        };
        let total: Vec3 = (380..=780).map(|nanometers| band(nanometers as f32)).sum();
        let mut below = [Vec3::ZERO; 2];
        for (row, values) in BANDS.iter().enumerate() {
            let wavelengths = (0..10).map(|nanometers| 380.0 + (10 * row + nanometers) as f32 - 4.5);
            below[0] += wavelengths.map(band).sum::<Vec3>() / total;
            below[1] += Vec3::from_array(values.map(|value| (BAND_STEP * value) as f32));
            assert!(below[0].abs_diff_eq(below[1], 0.012), "{row}: {} {}", below[0], below[1]);
            assert!(values.iter().all(|&value| value >= 0.0) && values.iter().sum::<f64>() > 0.0, "{row}");
        }
        // Of the straight lines' integral the first and the last row have half.
        let ends = [BANDS[0], BANDS[BAND_ROWS - 1]].map(|values| Vec3::from_array(values.map(|value| value as f32)));
        let whole = below[1] - 0.5 * BAND_STEP as f32 * (ends[0] + ends[1]);
        assert!(whole.abs_diff_eq(Vec3::ONE, 1e-6), "{whole}");
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
