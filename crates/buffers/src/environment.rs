//! What rays see that meet nothing.

use std::f32::consts::TAU;
use std::sync::Arc;

use brewster_lanes::math;
use brewster_optics::color::luminance;
use brewster_optics::warp;
use glam::{Vec2, Vec3};

use crate::environment_map::linear;
use crate::{EnvironmentMap, LightSample};

/// What rays see that meet nothing; radiance in nit.
#[derive(Clone, Debug, PartialEq)]
pub enum Background {
    /// One color.
    Constant(Vec3),
    /// From the horizon up to the zenith and down to the ground, linear in the sine of the elevation.
    Gradient {
        /// At elevation 0.
        horizon: Vec3,
        /// Straight up.
        zenith: Vec3,
        /// Straight down.
        ground: Vec3,
    },
    /// A picture.
    Environment(Arc<EnvironmentMap>),
}

/// What is behind the things in the picture. What they mirror and refract, and what lights them, is the background.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Backdrop {
    /// The background itself.
    #[default]
    Background,
    /// Something else.
    Other(Background),
    /// Nothing: the picture is transparent there.
    Transparent,
}

impl Default for Background {
    fn default() -> Self {
        Background::Constant(Vec3::ZERO)
    }
}

impl Background {
    /// The radiance from a unit direction.
    #[inline(always)]
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        match self {
            &Background::Constant(color) => color,
            &Background::Gradient { horizon, zenith, ground } => {
                let end = if direction.y >= 0.0 { zenith } else { ground };
                horizon + (end - horizon) * direction.y.abs().min(1.0)
            }
            Background::Environment(map) => map.radiance(direction),
        }
    }

    /// Whether no light comes from anywhere.
    pub fn is_black(&self) -> bool {
        match self {
            &Background::Constant(color) => color == Vec3::ZERO,
            &Background::Gradient { horizon, zenith, ground } => [horizon, zenith, ground] == [Vec3::ZERO; 3],
            Background::Environment(map) => map.is_black(),
        }
    }

    /// The mean radiance over all directions; of a picture, nearly.
    pub fn mean_radiance(&self) -> Vec3 {
        match self {
            &Background::Constant(color) => color,
            // Each half is linear in the height, over which solid angle is even.
            &Background::Gradient { horizon, zenith, ground } => zenith * 0.25 + ground * 0.25 + horizon * 0.5,
            Background::Environment(map) => map.mean_radiance(),
        }
    }

    /// Draws a direction in proportion to its luminance, with two numbers 0 ≤ u < 1; none if there is no light.
    #[inline]
    pub fn sample(&self, u: [f32; 2]) -> Option<LightSample> {
        match self {
            &Background::Constant(color) if color == Vec3::ZERO => None,
            &Background::Constant(color) => {
                Some(LightSample::distant(warp::sphere(Vec2::from_array(u)), color, warp::SPHERE_PDF))
            }
            &Background::Gradient { horizon, zenith, ground } => {
                let [horizon, zenith, ground] = [horizon, zenith, ground].map(luminance);
                let (above, below) = (0.25 * horizon + 0.25 * zenith, 0.25 * horizon + 0.25 * ground);
                if above + below == 0.0 {
                    return None;
                }
                let x = u[0] * (above + below);
                let (height, sign) = if x < above || below == 0.0 {
                    (linear(inside(x / above), horizon, zenith), 1.0)
                } else {
                    (linear(inside((x - above) / below), horizon, ground), -1.0)
                };
                let radius = ((1.0 - height) * (1.0 + height)).max(0.0).sqrt();
                let (sine, cosine) = math::sin_cos(TAU * u[1]);
                let direction = Vec3::new(radius * cosine, sign * height, radius * sine);
                Some(LightSample::distant(direction, self.radiance(direction), self.pdf(direction)))
            }
            Background::Environment(map) => map.sample(u),
        }
    }

    /// [`Background::sample`] for many.
    pub fn sample_all(&self, u: [&[f32]; 2], samples: &mut [Option<LightSample>]) {
        match self {
            Background::Environment(map) => map.sample_all(u, samples),
            _ => (0..samples.len()).for_each(|row| samples[row] = self.sample([u[0][row], u[1][row]])),
        }
    }

    /// The density of [`Background::sample`] per solid angle.
    #[inline]
    pub fn pdf(&self, direction: Vec3) -> f32 {
        match self {
            &Background::Constant(color) if color == Vec3::ZERO => 0.0,
            Background::Constant(_) => warp::SPHERE_PDF,
            Background::Gradient { .. } => {
                let mean = luminance(self.mean_radiance());
                if mean > 0.0 { luminance(self.radiance(direction)) / mean * warp::SPHERE_PDF } else { 0.0 }
            }
            Background::Environment(map) => map.pdf(direction),
        }
    }
}

/// A number moved into 0 < u < 1.
#[inline(always)]
fn inside(u: f32) -> f32 {
    u.clamp(f32::EPSILON, 1.0f32.next_down())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::{Random, check_sphere};

    #[test]
    fn a_gradient_meets_its_three_colors_and_their_middle() {
        let (horizon, zenith, ground) = (Vec3::ONE, Vec3::new(0.0, 0.5, 1.0), Vec3::ZERO);
        let sky = Background::Gradient { horizon, zenith, ground };
        assert_eq!(sky.radiance(Vec3::X), horizon);
        assert_eq!(sky.radiance(Vec3::Y), zenith);
        assert_eq!(sky.radiance(Vec3::NEG_Y), ground);
        let middle = Vec3::new(0.0, 0.5, 0.75f32.sqrt());
        assert_eq!(sky.radiance(middle), Vec3::new(0.5, 0.75, 1.0));
    }

    fn gradient(horizon: f32, zenith: f32, ground: f32) -> Background {
        let [horizon, zenith, ground] =
            [horizon, zenith, ground].map(|gray| Vec3::splat(gray) * Vec3::new(1.0, 0.5, 2.0));
        Background::Gradient { horizon, zenith, ground }
    }

    #[test]
    fn directions_follow_their_densities() {
        let skies = [
            Background::Constant(Vec3::X),
            gradient(1.0, 0.2, 0.5),
            gradient(0.0, 1.0, 0.0),
            gradient(0.0, 0.0, 3.0),
            gradient(1.0, 0.0, 0.0),
        ];
        for sky in skies {
            check_sphere(&format!("{sky:?}"), |u| sky.sample(u), |direction| sky.pdf(direction));
            // Gray light over its density is the same for every sample: the integral of luminance over the sphere.
            let mut random = Random::new(3);
            let whole = 2.0 * TAU * luminance(sky.mean_radiance());
            for _ in 0..1000 {
                let sample = sky.sample([random.number(), random.number()]).expect("there is light");
                assert_eq!(sample.radiance, sky.radiance(sample.direction));
                let weight = luminance(sample.radiance) / sample.pdf;
                assert!((weight / whole - 1.0).abs() < 1e-4, "{sky:?} {sample:?}: {weight} {whole}");
            }
        }
    }

    #[test]
    fn the_dark_has_no_samples() {
        for dark in [Background::default(), gradient(0.0, 0.0, 0.0)] {
            assert!(dark.is_black() && dark.sample([0.3, 0.6]).is_none() && dark.pdf(Vec3::X) == 0.0);
        }
        // The ends of the numbers' range land where there is light.
        for sky in [gradient(1.0, 1.0, 0.0), gradient(0.0, 0.0, 1.0), gradient(0.0, 1.0, 0.0)] {
            for u in [0.0, 1.0f32.next_down()] {
                let sample = sky.sample([u, u]).expect("there is light");
                assert!(sample.pdf > 0.0 && sample.pdf.is_finite(), "{sky:?} {u}: {sample:?}");
            }
        }
    }
}
