//! What rays see that meet nothing.

use glam::Vec3;

/// What rays see that meet nothing; radiance in nit.
#[derive(Clone, Copy, Debug, PartialEq)]
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
        match *self {
            Background::Constant(color) => color,
            Background::Gradient { horizon, zenith, ground } => {
                let end = if direction.y >= 0.0 { zenith } else { ground };
                horizon + (end - horizon) * direction.y.abs().min(1.0)
            }
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
}
