//! The sheen of cloth: fibers that stand up and catch grazing light.
//!
//! A. Conty and C. Kulla, *Production Friendly Microfacet Sheen BRDF*, SIGGRAPH 2017, as glTF's KHR_materials_sheen writes
//! it down: `D = (2 + 1/α) sin^{1/α}θ_h/(2π)` and `V = 1/((1 + Λ(v) + Λ(l)) 4 cosθ_v cosθ_l)`, with a fitted Λ and no
//! Fresnel term. Frame and names are those of [`lobe`](crate::lobe); `alpha` is the square of glTF's sheen roughness.
//!
//! The published fit sends back more than all light where it grazes fine fibers (`alpha` below 0.08, twice as much at
//! 0.01). There it is divided by its own albedo, [`albedo_table::sheen`](crate::albedo_table::sheen), the larger of both directions', so that it stays
//! reciprocal.

use core::f32::consts::FRAC_1_PI;

use brewster_lanes::math;
use glam::Vec3;

/// The least width, a roughness of 0.1: below, the lobe is a rim that no picture resolves.
pub const MIN_ALPHA: f32 = 0.01;

/// f |cosθ| of a sheen of color 1; `part` is what it takes of the light of both directions, the larger of both
/// [`albedo_table::sheen`](crate::albedo_table::sheen).
#[inline]
pub fn reflection(view: Vec3, light: Vec3, alpha: f32, part: f32) -> f32 {
    fitted(view, light, alpha) / part.max(1.0)
}

/// The same as published.
#[inline(always)]
fn fitted(view: Vec3, light: Vec3, alpha: f32) -> f32 {
    if !(view.z > 0.0 && light.z > 0.0) {
        return 0.0;
    }
    let inverse = 1.0 / alpha.max(MIN_ALPHA);
    let half = view + light;
    let sine2 = half.truncate().length_squared() / half.length_squared();
    let distribution = (2.0 + inverse) * math::pow(sine2, 0.5 * inverse) * (0.5 * FRAC_1_PI);
    let fit = Fit::new(alpha.max(MIN_ALPHA));
    distribution / ((1.0 + fit.lambda(view.z) + fit.lambda(light.z)) * 4.0 * view.z)
}

/// The fit of Λ to fibers of one width.
#[derive(Clone, Copy)]
struct Fit {
    a: f32,
    b: f32,
    c: f32,
    d: f32,
    e: f32,
}

impl Fit {
    #[inline(always)]
    fn new(alpha: f32) -> Fit {
        let part = (1.0 - alpha) * (1.0 - alpha);
        let between = |rough: f32, fine: f32| rough + (fine - rough) * part;
        Fit {
            a: between(21.5473, 25.3245),
            b: between(3.829_87, 3.324_35),
            c: between(0.198_23, 0.168_01),
            d: between(-1.9776, -1.273_93),
            e: between(-4.320_54, -4.859_67),
        }
    }

    #[inline(always)]
    fn lambda(self, cosine: f32) -> f32 {
        let low = cosine < 0.5;
        let fitted = self.at(if low { cosine } else { 1.0 - cosine.min(1.0) });
        math::exp(if low { fitted } else { 2.0 * self.at(0.5) - fitted })
    }

    #[inline(always)]
    fn at(self, x: f32) -> f32 {
        self.a / (1.0 + self.b * math::pow(x, self.c)) + self.d * x + self.e
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::Focus;
    use crate::strategies::{real, unit_vector};
    use crate::{albedo, albedo_table};
    use core::f32::consts::TAU;
    use proptest::prelude::*;

    /// The equations in f32 over directions, against those in f64 over another grid; and never more than all light.
    #[test]
    fn the_albedo_is_that_of_the_theory() {
        for alpha in [0.01, 0.1, 0.4, 1.0] {
            let part = |w: Vec3| albedo_table::sheen(w.z, alpha);
            for cosine in [1.0, 0.6, 0.2, 0.05, 0.01] {
                let view = albedo::at_cosine(cosine).as_vec3();
                let whole = Focus::SPHERE.total(|light| fitted(view, light, alpha) as f64);
                let exact = albedo::sheen(cosine, alpha as f64);
                assert!((whole - exact).abs() < 2e-3, "{alpha} {cosine}: {whole} {exact}");
                let kept = |light| reflection(view, light, alpha, part(view).max(part(light))) as f64;
                let kept = Focus::SPHERE.total(kept);
                assert!(kept <= whole && kept < 1.01, "{alpha} {cosine}: {kept}");
            }
        }
    }

    /// Straight down on even fibers, by hand: α = 1 has D = 3 sinθ/(2π), here with θ_h = 45° between a view along the
    /// normal and a light at the horizon; and no half vector along the normal reflects.
    #[test]
    fn the_distribution_by_hand() {
        let distribution = 3.0 * 0.5f32.sqrt() / TAU;
        let fit = Fit::new(1.0);
        let light = Vec3::new(1.0, 0.0, 1e-6);
        let expected = distribution / (4.0 * (1.0 + fit.lambda(1.0) + fit.lambda(1e-6)));
        assert!((fitted(Vec3::Z, light, 1.0) - expected).abs() < 1e-5);
        assert_eq!(fitted(Vec3::Z, Vec3::Z, 0.3), 0.0);
        // The fit at 0 and at ½ for α = 1, by hand: e + a, and a/(1 + b ½^c) + d/2 + e.
        assert!((fit.at(0.0) - 17.226_76).abs() < 1e-4);
        assert!((fit.at(0.5) - (21.5473 / (1.0 + 3.829_87 * 0.871_620) - 0.9888 - 4.320_54)).abs() < 1e-4);
    }

    proptest! {
        #[test]
        fn sheen_is_reciprocal_and_finite(a in unit_vector(), b in unit_vector(), alpha in real(0.0, 1.0)) {
            let [a, b] = [a, b].map(|w| Vec3::new(w.x, w.y, w.z.abs().max(1e-3)).normalize());
            let (there, back) = (fitted(a, b, alpha) / b.z, fitted(b, a, alpha) / a.z);
            prop_assert!(there.is_finite() && there >= 0.0);
            prop_assert!((there - back).abs() <= 1e-4 * there + 1e-7, "{there} {back}");
        }
    }
}
