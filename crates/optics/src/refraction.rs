//! Where light goes at a smooth boundary: Snell's law, mirror and refracted directions, total internal reflection.
//!
//! A direction is the way light (or the ray that looks for it) travels: a unit vector that points *to* the surface.
//! `eta_i` is the index on the side the ray comes from, `eta_t` the index on the other. The normal given to [`mirror`]
//! and [`refract`] is always the one flipped to the ray's own side, by [`flip_towards_viewer`], so that
//! `cos_i = -normal · direction` lies in 0..1.

use brewster_lanes::math;
use glam::Vec3;

/// How far the square of a unit vector's length may be from 1 before an assertion fails.
const UNIT_TOLERANCE: f32 = 1e-3;

/// The normal on the side the ray comes from: `normal` or its opposite.
///
/// The lecture flips into a second variable and goes on with the first; this function's result is the only normal that
/// [`mirror`] and [`refract`] may be given.
#[inline(always)]
pub fn flip_towards_viewer(normal: Vec3, direction: Vec3) -> Vec3 {
    if normal.dot(direction) > 0.0 { -normal } else { normal }
}

/// The mirror direction `V + 2 cosθ N` with `cosθ = -N·V`, for a normal on the ray's side.
///
/// About the unflipped normal the same expression is not even of unit length when the ray comes from inside, which the
/// assertion catches.
#[inline(always)]
pub fn mirror(direction: Vec3, normal: Vec3) -> Vec3 {
    let cos_i = -normal.dot(direction);
    debug_assert!(cos_i >= -UNIT_TOLERANCE, "{normal} is not flipped towards {direction}");
    unit(direction + 2.0 * cos_i * normal)
}

/// The refracted direction for a normal on the ray's side, or `None` in total internal reflection.
///
/// It points to the other side: its angle to `-normal` is that of [`cos_t`].
#[inline(always)]
pub fn refract(direction: Vec3, normal: Vec3, eta_i: f32, eta_t: f32) -> Option<Vec3> {
    let cos_i = -normal.dot(direction);
    Some(refract_with_cosine(direction, normal, cos_t(cos_i, eta_i, eta_t)?, eta_i / eta_t))
}

/// The refracted direction where the cosine of refraction is already known; `ratio` is `eta_i / eta_t`.
///
/// The part along the surface shrinks by the ratio (Snell's law) and the part across it has the length `cos_t`.
#[inline(always)]
pub fn refract_with_cosine(direction: Vec3, normal: Vec3, cos_t: f32, ratio: f32) -> Vec3 {
    let cos_i = -normal.dot(direction);
    debug_assert!(cos_i >= -UNIT_TOLERANCE, "{normal} is not flipped towards {direction}");
    unit(ratio * direction + (ratio * cos_i - cos_t) * normal)
}

/// The cosine of the angle of refraction by Snell's law `η1 sin θ1 = η2 sin θ2`; `None` in total internal reflection.
///
/// `cos_i` lies in 0..1 and both indices are positive. Written as `η2² cos²θ2 = η2² - η1² + η1² cos²θ1`, it keeps its
/// precision at grazing incidence and where both indices are equal.
#[inline(always)]
pub fn cos_t(cos_i: f32, eta_i: f32, eta_t: f32) -> Option<f32> {
    let incident = eta_i * cos_i;
    let square = (eta_t - eta_i) * (eta_t + eta_i) + incident * incident;
    if square >= 0.0 { Some((square.sqrt() / eta_t).min(1.0)) } else { None }
}

/// The angle of refraction for an angle of incidence in 0..π/2, or `None` in total internal reflection.
#[inline(always)]
pub fn theta_t(theta_i: f32, eta_i: f32, eta_t: f32) -> Option<f32> {
    let sin_t = math::sin(theta_i) * (eta_i / eta_t);
    if sin_t <= 1.0 { Some(math::asin(sin_t)) } else { None }
}

/// The angle of incidence beyond which everything is reflected; `None` unless the ray comes from the denser side.
#[inline(always)]
pub fn critical_angle(eta_i: f32, eta_t: f32) -> Option<f32> {
    if eta_i > eta_t { Some(math::asin(eta_t / eta_i)) } else { None }
}

/// Brewster's angle `tan θ = η2/η1`: at this incidence no p-polarized light is reflected.
#[inline(always)]
pub fn brewster_angle(eta_i: f32, eta_t: f32) -> f32 {
    math::atan2(eta_t, eta_i)
}

/// Asserts that a direction is of unit length, then takes off what rounding added, so that bounces do not pile it up.
///
/// One Newton step for `1/√x` at 1 turns an error ε of the length into one of 1.5 ε².
#[inline(always)]
fn unit(direction: Vec3) -> Vec3 {
    let square = direction.length_squared();
    debug_assert!((square - 1.0).abs() < UNIT_TOLERANCE, "{direction} is not a unit vector");
    direction * (1.5 - 0.5 * square)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::strategies::{incidence, real};
    use core::f32::consts::{FRAC_PI_2, FRAC_PI_6};
    use proptest::prelude::*;

    fn close(result: f32, expected: f32, tolerance: f32) -> bool {
        (result - expected).abs() <= tolerance
    }

    /// Into glass of index 1.5 at 30°: sin θt = 1/3, cos θt = √8/3, worked by hand.
    #[test]
    fn snell_by_hand() {
        let cos_t_30 = cos_t(0.75f32.sqrt(), 1.0, 1.5).expect("no total reflection from the thinner side");
        assert!(close(cos_t_30, 8f32.sqrt() / 3.0, 1e-7), "{cos_t_30}");
        let theta = theta_t(FRAC_PI_6, 1.0, 1.5).expect("as above");
        assert!(close(theta, 0.339_836_9, 2e-7), "{theta}");
        assert_eq!(cos_t(1.0, 1.0, 1.5), Some(1.0));
        assert_eq!(theta_t(0.0, 1.5, 1.0), Some(0.0));
    }

    /// Textbook values: 41.81° for glass of 1.5, 48.75° for water of 1.33, 24.41° for diamond of 2.42.
    #[test]
    fn critical_angles_are_the_published_ones() {
        for (eta, degrees) in [(1.5, 41.81), (1.33, 48.75), (2.42, 24.41)] {
            let critical = critical_angle(eta, 1.0).expect("from the denser side");
            assert!(close(critical.to_degrees(), degrees, 0.01), "{eta}: {}", critical.to_degrees());
            assert!(theta_t(critical - 1e-4, eta, 1.0).is_some() && theta_t(critical + 1e-4, eta, 1.0).is_none());
            assert!(cos_t((critical - 1e-4).cos(), eta, 1.0).is_some());
            assert!(cos_t((critical + 1e-4).cos(), eta, 1.0).is_none());
        }
        assert_eq!(critical_angle(1.0, 1.5), None);
        assert_eq!(critical_angle(1.5, 1.5), None);
    }

    /// Textbook values: 56.31° into glass of 1.5, 53.06° into water of 1.33; both sides' angles add up to 90°.
    #[test]
    fn brewster_angles_are_the_published_ones() {
        for (eta, degrees) in [(1.5, 56.31), (1.33, 53.06)] {
            let outside = brewster_angle(1.0, eta);
            assert!(close(outside.to_degrees(), degrees, 0.01), "{eta}: {}", outside.to_degrees());
            assert!(close(outside + brewster_angle(eta, 1.0), FRAC_PI_2, 1e-6));
        }
    }

    /// A ray going down and right at 45° onto a floor goes up and right.
    #[test]
    fn a_mirror_on_the_floor() {
        let (down, up) = (Vec3::new(0.6, -0.8, 0.0), Vec3::new(0.6, 0.8, 0.0));
        assert!(mirror(down, Vec3::Y).abs_diff_eq(up, 1e-7));
        assert!(mirror(Vec3::NEG_Y, Vec3::Y).abs_diff_eq(Vec3::Y, 1e-7));
        assert!(mirror(Vec3::X, Vec3::Y).abs_diff_eq(Vec3::X, 1e-7));
    }

    /// The lecture's slip: seen from inside, it flips the normal but reflects about the unflipped one.
    #[test]
    fn the_mirror_needs_the_flipped_normal() {
        let (outgoing, outward) = (Vec3::new(0.6, 0.8, 0.0), Vec3::Y);
        let flipped = flip_towards_viewer(outward, outgoing);
        assert_eq!(flipped, -outward);
        assert!(mirror(outgoing, flipped).abs_diff_eq(Vec3::new(0.6, -0.8, 0.0), 1e-7));
        let cos_i = -flipped.dot(outgoing);
        let slip = outgoing + 2.0 * cos_i * outward;
        assert!(slip.length() > 2.4, "the slip's length is {}", slip.length());
    }

    #[test]
    #[cfg(debug_assertions)]
    #[should_panic(expected = "is not flipped towards")]
    fn the_unflipped_normal_is_caught() {
        mirror(Vec3::new(0.6, 0.8, 0.0), Vec3::Y);
    }

    #[test]
    #[cfg(debug_assertions)]
    #[should_panic(expected = "is not a unit vector")]
    fn a_direction_that_is_too_long_is_caught() {
        mirror(Vec3::new(0.7, -0.8, 0.0), Vec3::Y);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4096))]

        /// Reflection keeps the part along the surface and turns the part across it, in f64.
        #[test]
        fn mirrors_keep_length_and_angle((direction, normal) in incidence()) {
            let mirrored = mirror(direction, normal).as_dvec3();
            let (direction, normal) = (direction.as_dvec3(), normal.as_dvec3());
            prop_assert!((mirrored.length() - 1.0).abs() < 2e-7);
            prop_assert!((mirrored.dot(normal) + direction.dot(normal)).abs() < 1e-6);
            prop_assert!((mirrored.cross(normal) - direction.cross(normal)).length() < 1e-6);
        }

        /// Snell's law as vectors: `η1 V × N = η2 T × N`, and T goes to the other side at unit length.
        #[test]
        fn refraction_obeys_snell(
            (direction, normal) in incidence(),
            (eta_i, eta_t) in (real(1.0, 4.0), real(1.0, 4.0)),
        ) {
            let cos_i = -normal.dot(direction);
            match refract(direction, normal, eta_i, eta_t) {
                Some(refracted) => {
                    let (v, n, t) = (direction.as_dvec3(), normal.as_dvec3(), refracted.as_dvec3());
                    prop_assert!((t.length() - 1.0).abs() < 2e-7);
                    prop_assert!(t.dot(n) <= 1e-6);
                    let difference = eta_i as f64 * v.cross(n) - eta_t as f64 * t.cross(n);
                    prop_assert!(difference.length() < 4e-6, "{}", difference.length());
                }
                None => {
                    let critical = critical_angle(eta_i, eta_t).expect("only from the denser side");
                    prop_assert!(cos_i as f64 <= (critical as f64).cos() + 1e-6);
                }
            }
        }

        /// Light goes back the way it came; near grazing incidence the way back lies at the critical angle, where the
        /// slope is infinite.
        #[test]
        fn refraction_is_reversible((direction, normal) in incidence(), eta in real(1.0, 4.0)) {
            let cos_i = normal.dot(direction).abs();
            let refracted = refract(direction, normal, 1.0, eta).expect("into the denser side");
            if let Some(back) = refract(-refracted, -normal, eta, 1.0) {
                let tolerance = 1e-6 * eta * eta / cos_i;
                prop_assert!(back.abs_diff_eq(-direction, tolerance), "{back} {direction} ± {tolerance}");
            } else {
                prop_assert!(cos_i < 0.01, "{cos_i}");
            }
        }

        #[test]
        fn equal_indices_do_not_refract(
            (direction, normal) in incidence(),
            (eta, cos_i) in (real(1.0, 44.0), real(0.0, 1.0)),
        ) {
            let straight = refract(direction, normal, eta, eta).expect("no boundary, no total reflection");
            prop_assert!(straight.abs_diff_eq(direction, 1e-6), "{straight} {direction}");
            let cos_t = cos_t(cos_i, eta, eta).expect("as above");
            prop_assert!(close(cos_t, cos_i, 2e-7 * cos_i), "{cos_t} {cos_i}");
        }

        #[test]
        fn both_forms_of_snell_agree(theta_i in real(0.0, 1.57), eta_i in real(1.0, 3.0), eta_t in real(1.0, 3.0)) {
            if let (Some(theta), Some(cos)) = (theta_t(theta_i, eta_i, eta_t), cos_t(theta_i.cos(), eta_i, eta_t)) {
                prop_assert!(close(theta.cos(), cos, 2e-6 / cos.max(1e-3)), "{} {cos}", theta.cos());
            }
        }
    }
}
