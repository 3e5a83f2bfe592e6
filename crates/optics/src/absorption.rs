//! Beer–Lambert absorption: how a colored medium dims light with distance.
//!
//! An absorption is a coefficient for each color channel, per meter. Authors rather say which color is left after a
//! given distance, which [`from_color`] turns into coefficients.

use core::fmt;

use brewster_lanes::math;
use glam::Vec3;

/// What [`from_color`] can't turn into an absorption.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum InvalidAbsorption {
    /// A channel of the color is not in 0..1: a medium does not add light.
    Color(Vec3),
    /// The distance is not positive.
    Distance(f32),
}

/// The part of light that is left after `distance` meters, `exp(-absorption · distance)` for each channel.
///
/// Neither argument is negative; the result lies in 0..1. Either may be infinite: what does not absorb lets light through for
/// ever, and over no distance nothing is absorbed.
#[inline(always)]
pub fn transmittance(absorption: Vec3, distance: f32) -> Vec3 {
    // 0 · ∞ is NaN, of which the maximum with 0 is 0.
    let left = |absorption: f32| math::exp(-(absorption * distance).max(0.0));
    Vec3::new(left(absorption.x), left(absorption.y), left(absorption.z))
}

/// The absorption that leaves `color` of white light after `distance` meters: `-ln(color)/distance`.
///
/// A channel of 0 would need an infinite absorption; it gets one that leaves 2⁻¹²⁶. An infinite distance absorbs
/// nothing.
pub fn from_color(color: Vec3, distance: f32) -> Result<Vec3, InvalidAbsorption> {
    if !color.to_array().iter().all(|channel| (0.0..=1.0).contains(channel)) {
        return Err(InvalidAbsorption::Color(color));
    }
    if distance.is_nan() || distance <= 0.0 {
        return Err(InvalidAbsorption::Distance(distance));
    }
    let channel = |color: f32| (0.0 - math::ln(color.max(f32::MIN_POSITIVE))) / distance;
    Ok(Vec3::new(channel(color.x), channel(color.y), channel(color.z)))
}

impl fmt::Display for InvalidAbsorption {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            InvalidAbsorption::Color(color) => {
                write!(f, "no absorption leaves the color {color}: every channel must lie in 0..1")
            }
            InvalidAbsorption::Distance(distance) => {
                write!(f, "a color is left after a positive distance, not after {distance} m")
            }
        }
    }
}

impl core::error::Error for InvalidAbsorption {}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::strategies::real;
    use core::f32::consts::LN_2;
    use proptest::prelude::*;

    /// An absorption of ln 2 halves the light every meter.
    #[test]
    fn light_halves_every_meter() {
        let absorption = from_color(Vec3::new(0.5, 1.0, 0.25), 1.0).expect("a color");
        assert!(absorption.abs_diff_eq(Vec3::new(LN_2, 0.0, 2.0 * LN_2), 1e-6), "{absorption}");
        assert!(transmittance(absorption, 3.0).abs_diff_eq(Vec3::new(0.125, 1.0, 1.0 / 64.0), 1e-6));
        assert_eq!(transmittance(absorption, 0.0), Vec3::ONE);
    }

    #[test]
    fn the_ends_are_defined() {
        let black = from_color(Vec3::ZERO, 0.5).expect("black glass");
        assert!(black.is_finite());
        assert_eq!(transmittance(black, 0.0), Vec3::ONE);
        assert!(transmittance(black, 0.5).max_element() < 1e-37);
        assert_eq!(transmittance(Vec3::splat(f32::MAX), 2.0), Vec3::ZERO);
        assert_eq!(transmittance(Vec3::new(0.0, 1e-9, f32::INFINITY), f32::INFINITY), Vec3::X);
        assert_eq!(transmittance(Vec3::splat(f32::INFINITY), 0.0), Vec3::ONE);
        let clear = from_color(Vec3::splat(0.5), f32::INFINITY).expect("never gets there");
        assert_eq!((clear, clear.x.is_sign_negative()), (Vec3::ZERO, false));
        assert!(!from_color(Vec3::ONE, 1.0).expect("clear").x.is_sign_negative());
    }

    #[test]
    fn what_is_no_absorption_is_an_error() {
        for color in [Vec3::new(0.5, 1.01, 0.5), Vec3::new(-0.1, 0.5, 0.5), Vec3::new(0.5, 0.5, f32::NAN)] {
            assert!(matches!(from_color(color, 1.0), Err(InvalidAbsorption::Color(_))), "{color}");
        }
        for distance in [0.0, -1.0, f32::NAN] {
            let error = from_color(Vec3::splat(0.5), distance).expect_err("no distance");
            assert!(error.to_string().contains("positive distance"), "{error}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4096))]

        #[test]
        fn a_color_comes_back_at_its_distance(
            (r, g) in (real(1e-6, 1.0), real(1e-6, 1.0)),
            distance in real(1e-3, 100.0),
        ) {
            let color = Vec3::new(r, g, 1.0);
            let absorption = from_color(color, distance).expect("a color");
            let left = transmittance(absorption, distance);
            prop_assert!((left / color - Vec3::ONE).abs().max_element() < 4e-6, "{left} {color}");
            // Half the way twice is the whole way.
            let half = transmittance(absorption, 0.5 * distance);
            prop_assert!((half * half / color - Vec3::ONE).abs().max_element() < 4e-6, "{half} {color}");
        }
    }
}
