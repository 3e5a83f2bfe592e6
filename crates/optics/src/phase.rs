//! Henyey and Greenstein's phase function: how a medium spreads the light that it scatters.
//!
//! L. Henyey and J. Greenstein, *Diffuse Radiation in the Galaxy*, 1941. Its one parameter is `g`, the mean cosine of the angle
//! by which light is turned: 0 spreads it evenly, toward 1 it goes on forward (milk, fog, skin), toward -1 it comes back.
//! Cosines are those between the direction before and the direction after, +1 straight on. The function is its own
//! density, so a direction drawn from it weighs 1.

use core::f32::consts::FRAC_1_PI;

use glam::{Vec2, Vec3};

use crate::basis::Basis;
use crate::warp;

/// The function for -1 < g < 1, per solid angle: `(1 - g²) / 4π (1 + g² - 2g cosθ)^(3/2)`.
#[inline(always)]
pub fn henyey_greenstein(g: f32, cosine: f32) -> f32 {
    // The root's argument as a sum of what is not negative, for g of either sign: nothing cancels.
    let turned = 1.0 - cosine.copysign(cosine * g);
    let lobe = 1.0 - g.abs();
    let square = (lobe * lobe + 2.0 * g.abs() * turned).max(f32::MIN_POSITIVE);
    0.25 * FRAC_1_PI * lobe * (1.0 + g.abs()) / (square * square.sqrt())
}

/// A direction drawn from the function around `direction`, with two numbers 0 ≤ u < 1.
#[inline(always)]
pub fn sample_henyey_greenstein(g: f32, direction: Vec3, u: Vec2) -> Vec3 {
    let g_abs = g.abs();
    // 1 - cosθ about the lobe's axis, which of g < 0 points backward: the inverse of the distribution with what would cancel
    // taken out. It is (1 - ξ)(1 - g)²(1 + gξ) over (1 - g + 2gξ)², times 2.
    let (xi, narrow) = (u.x, 1.0 - g_abs);
    let below = narrow + 2.0 * g_abs * xi;
    let versine = (2.0 * (1.0 - xi) * (narrow / below) * (narrow / below) * (1.0 + g_abs * xi)).min(2.0);
    let axis = if g < 0.0 { -direction } else { direction };
    Basis::around(axis).to_world(warp::cone(Vec2::new(1.0, u.y), versine))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::{Focus, Random, SphereTest};

    const ANISOTROPIES: [f32; 9] = [0.0, 0.001, 0.3, 0.8, 0.98, -0.001, -0.5, -0.9, -0.98];

    /// The textbook's formula in f64.
    #[test]
    fn it_is_the_formula() {
        for g in ANISOTROPIES {
            for cosine in [-1.0, -0.7, 0.0, 0.2, 0.99, 1.0] {
                let (g64, cosine64) = (f64::from(g), f64::from(cosine));
                let below = (1.0 + g64 * g64 - 2.0 * g64 * cosine64).powf(1.5);
                let expected = (1.0 - g64 * g64) / (4.0 * std::f64::consts::PI * below);
                let found = f64::from(henyey_greenstein(g, cosine));
                assert!((found / expected - 1.0).abs() < 2e-4, "g {g}, cosine {cosine}: {found} {expected}");
            }
        }
        assert!(henyey_greenstein(0.999_999, 1.0).is_finite() && henyey_greenstein(-0.999_999, 1.0) > 0.0);
    }

    #[test]
    fn directions_follow_the_function() {
        let direction = Vec3::new(0.36, -0.48, 0.8);
        for g in ANISOTROPIES {
            let axis = if g < 0.0 { -direction } else { direction };
            let test = SphereTest { focus: Focus::new(axis, 1.0 - g.abs()), family: ANISOTROPIES.len() };
            let sample = |u, _| Some(sample_henyey_greenstein(g, direction, u));
            test.check(&format!("g {g}"), sample, |light| henyey_greenstein(g, direction.dot(light)));
        }
    }

    /// The first moment of the function is g: the definition of g.
    #[test]
    fn the_mean_cosine_is_g() {
        let mut random = Random::new(5);
        for g in ANISOTROPIES {
            let count = 100_000;
            let (mut sum, mut squares) = (0.0, 0.0);
            for _ in 0..count {
                let light = sample_henyey_greenstein(g, Vec3::Y, random.square());
                assert!((light.length() - 1.0).abs() < 1e-5, "g {g}: {light}");
                sum += f64::from(light.y);
                squares += f64::from(light.y).powi(2);
            }
            let mean = sum / f64::from(count);
            let error = ((squares / f64::from(count) - mean * mean) / f64::from(count)).sqrt();
            assert!((mean - f64::from(g)).abs() < 4.5 * error + 1e-6, "g {g}: {mean} ± {error}");
        }
    }

    #[test]
    fn the_ends_of_the_numbers_are_directions() {
        for g in ANISOTROPIES {
            for x in [0.0, 1.0f32.next_down()] {
                let light = sample_henyey_greenstein(g, Vec3::Z, Vec2::new(x, 0.3));
                assert!(light.is_finite() && henyey_greenstein(g, light.z) > 0.0, "g {g}: {light}");
            }
        }
    }
}
