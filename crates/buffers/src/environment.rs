//! What rays see that meet nothing.

use std::sync::Arc;

use brewster_lanes::Level;
use glam::Vec3;

use crate::EnvironmentMap;
use crate::environment_map::SKY_RUN;

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

    /// [`Background::radiance`] of some unit directions at once.
    #[inline]
    pub fn radiance_all(&self, level: Level, directions: &[Vec3; SKY_RUN], radiance: &mut [Vec3; SKY_RUN]) {
        match self {
            Background::Environment(map) => map.radiance_all(level, directions, radiance),
            _ => (0..SKY_RUN).for_each(|lane| radiance[lane] = self.radiance(directions[lane])),
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

    /// What directions are drawn from. Light that is even, or nearly so, is found just as well by the directions in which
    /// surfaces scatter: only pictures are drawn from, and of them only what is brighter than their mean.
    #[inline(always)]
    pub fn drawn(&self) -> Option<&EnvironmentMap> {
        match self {
            Background::Environment(map) if map.is_drawn() => Some(map),
            _ => None,
        }
    }

    /// [`Background::pdf`] of some unit directions at once.
    #[inline]
    pub fn pdf_all(&self, level: Level, directions: &[Vec3; SKY_RUN], pdfs: &mut [f32; SKY_RUN]) {
        match self {
            Background::Environment(map) => map.pdf_all(level, directions, pdfs),
            _ => pdfs.fill(0.0),
        }
    }

    /// The density per solid angle with which a direction is drawn, 0 if none is.
    #[inline]
    pub fn pdf(&self, direction: Vec3) -> f32 {
        match self {
            Background::Environment(map) => map.pdf(direction),
            _ => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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

    #[test]
    fn the_dark_is_black_and_what_is_even_is_not_drawn_from() {
        let gradient = |horizon, zenith, ground| Background::Gradient { horizon, zenith, ground };
        let [dark, gray] = [0.0, 0.5].map(Vec3::splat);
        for (sky, is_black) in [
            (Background::default(), true),
            (gradient(dark, dark, dark), true),
            (Background::Constant(gray), false),
            (gradient(gray, dark, dark), false),
            (gradient(dark, gray, dark), false),
            (gradient(dark, dark, gray), false),
        ] {
            assert_eq!(sky.is_black(), is_black);
            assert!(sky.drawn().is_none() && sky.pdf(Vec3::X) == 0.0);
        }
    }
}
