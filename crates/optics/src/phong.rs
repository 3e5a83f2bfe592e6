//! Phong's highlight: a lobe around a direction that stands for the image of a light.
//!
//! The lecture's materials see lights only through it. The highlight is `max(0, L·D)^exponent`, with `L` the direction
//! to the light and `D` the middle of the lobe: the mirror direction for a reflection, the refracted direction for a
//! transmission. It is *not* normalized: its peak is 1 for every exponent, as in the lecture, and a larger exponent
//! makes it smaller in energy as well as in size. (B. T. Phong, *Illumination for Computer Generated Pictures*,
//! CACM 18(6), 1975.)

use brewster_lanes::math;
use glam::Vec3;

/// The highlight of a light in the direction `to_light` around the direction `lobe`, both unit vectors.
///
/// The exponent is positive, and the result lies in 0..1: 1 where the directions coincide, 0 from a right angle on.
#[inline(always)]
pub fn highlight(to_light: Vec3, lobe: Vec3, exponent: f32) -> f32 {
    highlight_with_cosine(to_light.dot(lobe), exponent)
}

/// The highlight for a known `L·D`.
#[inline(always)]
pub fn highlight_with_cosine(cos: f32, exponent: f32) -> f32 {
    // Two unit vectors may have a product a rounding above 1, which a large exponent would raise to something.
    math::pow(cos.clamp(0.0, 1.0), exponent)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::strategies::{incidence, real};
    use proptest::prelude::*;

    /// Powers worked out by hand: cos 60° = 1/2, cos 36.87° = 0.8.
    #[test]
    fn highlights_by_hand() {
        let light = Vec3::new(0.6, 0.8, 0.0);
        for (lobe, exponent, expected) in [
            (light, 300.0, 1.0),
            (Vec3::Y, 1.0, 0.8),
            (Vec3::Y, 2.0, 0.64),
            (Vec3::X, 3.0, 0.216),
            (Vec3::Z, 40.0, 0.0),
            (Vec3::NEG_Y, 2.0, 0.0),
        ] {
            let result = highlight(light, lobe, exponent);
            assert!((result - expected).abs() < 4e-5, "{lobe} {exponent}: {result}, expected {expected}");
        }
        assert_eq!(highlight_with_cosine(0.5, 10.0), 1.0 / 1024.0);
        assert_eq!(highlight_with_cosine(1.000_000_1, 1e6), 1.0);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4096))]

        #[test]
        fn highlights_stay_in_range((light, lobe) in incidence(), exponent in real(1e-3, 1e5)) {
            for lobe in [lobe, -lobe, light] {
                let result = highlight(light, lobe, exponent);
                let exact = (light.dot(lobe) as f64).clamp(0.0, 1.0).powf(exponent as f64);
                prop_assert!((0.0..=1.0).contains(&result) && (result as f64 - exact).abs() < 1e-6, "{result} {exact}");
            }
        }
    }
}
