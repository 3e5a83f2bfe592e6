//! Lambert's diffuse reflection: the same radiance in every direction.

use core::f32::consts::FRAC_1_PI;

use glam::Vec3;

/// Lambert's reflectance function in sr⁻¹: `albedo/π`, whatever the directions.
#[inline(always)]
pub fn brdf(albedo: Vec3) -> Vec3 {
    albedo * FRAC_1_PI
}

/// The radiance that a surface sends back under light of the irradiance `irradiance` on a plane facing it.
///
/// `cos` is that of the angle between the normal and the direction to the light; from behind, nothing is seen.
#[inline(always)]
pub fn reflected(albedo: Vec3, irradiance: Vec3, cos: f32) -> Vec3 {
    brdf(albedo) * irradiance * cos.max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The projected solid angle of the hemisphere is π: a white surface under light of radiance 1 from everywhere
    /// sends back 1. The integral is taken over rings of equal height, whose exact share is 2π cos θ d(cos θ).
    #[test]
    fn a_white_furnace_stays_white() {
        let albedo = Vec3::new(1.0, 0.5, 0.0);
        let rings = 1000;
        let mut sum = Vec3::ZERO;
        for ring in 0..rings {
            let cos = (ring as f32 + 0.5) / rings as f32;
            let solid_angle = core::f32::consts::TAU / rings as f32;
            sum += reflected(albedo, Vec3::splat(solid_angle), cos);
        }
        assert!(sum.abs_diff_eq(albedo, 1e-4), "{sum}");
    }

    #[test]
    fn light_from_behind_is_not_seen() {
        assert_eq!(reflected(Vec3::ONE, Vec3::ONE, -0.5), Vec3::ZERO);
        assert_eq!(reflected(Vec3::ONE, Vec3::splat(core::f32::consts::PI), 0.0), Vec3::ZERO);
    }
}
