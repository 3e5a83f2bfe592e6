//! Metals by color instead of by index: what an artist turns, and the index that it stands for.
//!
//! The equations of a metal with an index are in [`fresnel`], measured indices in
//! [`metals`](crate::metals).

use brewster_lanes::math;
use glam::Vec3;

use crate::fresnel;

/// The largest reflectance that [`index_from_edge_tint`] tells from a perfect mirror, whose index would be infinite.
const MOST_REFLECTIVE: f32 = 0.9999;

/// The F82-tint model: Schlick's curve, with a say in the color near its dip at 82°.
///
/// P. Kutz, M. Hašan and D. Edmondson, *Novel Aspects of the Adobe Standard Material*, 2021, after N. Hoffman, *Fresnel
/// Equations Considered Harmful*, 2019: `F(μ) = F_schlick(μ) - a μ (1-μ)⁶`, with `a` such that at μ = 1/7 the
/// reflectance is the tint times Schlick's. Schlick's curve ends in white; here it may end in another color, so that one may be told to
/// reflect alike at all angles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct F82Tint {
    f0: Vec3,
    f90: Vec3,
    dip: Vec3,
}

impl F82Tint {
    /// A metal of color `f0` at normal and `f90` at grazing incidence, and `tint`, 0 to 1, at about 82°: white leaves Schlick's curve.
    #[inline(always)]
    pub fn new(f0: Vec3, f90: Vec3, tint: Vec3) -> F82Tint {
        /// `μ (1-μ)⁶` at μ = 1/7.
        const DIP: f32 = 46_656.0 / 823_543.0;
        let schlick = F82Tint { f0, f90, dip: Vec3::ZERO };
        F82Tint { dip: schlick.reflectance(1.0 / 7.0) * (Vec3::ONE - tint) / DIP, ..schlick }
    }

    /// The color that is reflected at an angle of incidence of that cosine.
    ///
    /// A dark metal with a dark tint would turn negative beside the dip; it is black there.
    #[inline(always)]
    pub fn reflectance(&self, cos_i: f32) -> Vec3 {
        let rest = (1.0 - cos_i).max(0.0);
        let fifth = math::pow5(rest);
        let shape = cos_i * fifth * rest;
        (self.f0 + (self.f90 - self.f0) * fifth - self.dip * shape).max(Vec3::ZERO)
    }
}

/// The complex index `(η, k)` of a metal by its reflectance at normal incidence and the color of its edge.
///
/// O. Gulbrandsen, *Artist Friendly Metallic Fresnel*, JCGT 3(4), 2014: the tint moves η from the largest that has this
/// reflectance (0, with k = 0) to the smallest (1), and k follows. Both lie in 0..1; a reflectance above 0.9999 counts as
/// that.
#[inline(always)]
pub fn index_from_edge_tint(reflectance: f32, edge_tint: f32) -> (f32, f32) {
    let r = reflectance.clamp(0.0, MOST_REFLECTIVE);
    let root = r.sqrt();
    let (least, most) = ((1.0 - r) / (1.0 + r), (1.0 + root) / (1.0 - root));
    let eta = most + (least - most) * edge_tint;
    // r (η+1)² - (η-1)², whose roots are η = most and 1/most.
    let k2 = (most - eta) * (eta - 1.0 / most);
    (eta, k2.max(0.0).sqrt())
}

/// The reflectance at normal incidence and the edge tint of a complex index; the way back of [`index_from_edge_tint`].
///
/// The tint of a metal of η below `(1-r)/(1+r)` lies above 1.
#[inline(always)]
pub fn edge_tint_from_index(eta: f32, k: f32) -> (f32, f32) {
    let r = fresnel::f0_conductor(1.0, eta, k);
    let root = r.sqrt();
    let (least, most) = ((1.0 - r) / (1.0 + r), (1.0 + root) / (1.0 - root));
    (r, if most > least { (most - eta) / (most - least) } else { 0.0 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fresnel::{conductor, conductor_color, f0_conductor};
    use crate::strategies::{cosine, real};
    use proptest::prelude::*;

    /// By hand, at μ = 1/7 with f0 = ½ the curve of Schlick is ½ + ½(6/7)⁵ = 0.7313322, and half of it is 0.3656661.
    #[test]
    fn the_tint_is_that_of_82_degrees() {
        let metal = F82Tint::new(Vec3::splat(0.5), Vec3::ONE, Vec3::new(1.0, 0.5, 0.0));
        let at_dip = metal.reflectance(1.0 / 7.0);
        assert!(at_dip.abs_diff_eq(Vec3::new(0.731_332_2, 0.365_666_1, 0.0), 1e-6), "{at_dip}");
        assert_eq!(metal.reflectance(1.0), Vec3::splat(0.5));
        assert_eq!(metal.reflectance(0.0), Vec3::ONE);
        assert!((1.0f32 / 7.0).acos().to_degrees() - 82.0 < 0.3);
    }

    /// Between two colors Schlick's way, by hand: ½ + (¼-½)/32 along 60°. Between one and itself there is no way: to the last bit.
    #[test]
    fn a_curve_may_end_in_another_color() {
        let falling = F82Tint::new(Vec3::splat(0.5), Vec3::splat(0.25), Vec3::ONE);
        assert_eq!([1.0, 0.5, 0.0].map(|cosine| falling.reflectance(cosine).x), [0.5, 0.4921875, 0.25]);
        let color = Vec3::new(0.8, 0.1, 0.333_333);
        let constant = F82Tint::new(color, color, Vec3::ONE);
        assert!((0..=1000).all(|step| constant.reflectance(step as f32 / 1000.0) == color));
    }

    /// Aluminum's index dips near 82° and Schlick's curve does not: fitted there, the model stays within 0.02.
    #[test]
    fn it_follows_a_real_metal() {
        let (eta, k) = (Vec3::new(1.346, 0.965, 0.617), Vec3::new(7.475, 6.400, 5.303));
        let f0 = conductor_color(1.0, 1.0, eta, k);
        let at_dip = conductor_color(1.0 / 7.0, 1.0, eta, k);
        let metal = F82Tint::new(f0, Vec3::ONE, at_dip / fresnel::schlick_color(1.0 / 7.0, f0));
        let (mut worst, mut schlick) = (0f32, 0f32);
        for step in 0..=1000 {
            let cos_i = step as f32 / 1000.0;
            let exact = conductor_color(cos_i, 1.0, eta, k);
            worst = worst.max((metal.reflectance(cos_i) - exact).abs().max_element());
            schlick = schlick.max((fresnel::schlick_color(cos_i, f0) - exact).abs().max_element());
        }
        assert!(worst < 0.02 && schlick > 0.1, "{worst} {schlick}");
    }

    /// Ends by hand: tint 0 is the dielectric of the same reflectance, r = ¼ has η = 3; tint 1 has η = 0.6, and
    /// k² = ¼·1.6² - 0.4² over ¾ = 0.64.
    #[test]
    fn edge_tints_by_hand() {
        assert_eq!(index_from_edge_tint(0.25, 0.0), (3.0, 0.0));
        let (eta, k) = index_from_edge_tint(0.25, 1.0);
        assert!((eta - 0.6).abs() < 1e-6 && (k - 0.8).abs() < 1e-6, "{eta} {k}");
        assert_eq!(index_from_edge_tint(0.0, 0.5), (1.0, 0.0));
        let (eta, k) = index_from_edge_tint(1.0, 0.5);
        assert!(eta.is_finite() && k.is_finite());
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4096))]

        #[test]
        fn edge_tints_keep_the_reflectance(r in real(0.0, 0.99), tint in real(0.0, 1.0)) {
            let (eta, k) = index_from_edge_tint(r, tint);
            prop_assert!(eta > 0.0 && k >= 0.0 && (f0_conductor(1.0, eta, k) - r).abs() < 2e-5, "{eta} {k}");
            let (back, back_tint) = edge_tint_from_index(eta, k);
            prop_assert!((back - r).abs() < 2e-5, "{back} {r}");
            prop_assert!(r < 0.01 || (back_tint - tint).abs() < 2e-3, "{back_tint} {tint}");
        }

        #[test]
        fn reflectances_stay_in_range(cos_i in cosine(), f0 in real(0.0, 1.0), tint in real(0.0, 1.0), eta in real(0.1, 3.0)) {
            let color = F82Tint::new(Vec3::splat(f0), Vec3::ONE, Vec3::splat(tint)).reflectance(cos_i);
            prop_assert!(color.min_element() >= 0.0 && color.max_element() <= 1.000_001, "{color}");
            let (_, tint) = edge_tint_from_index(eta, 2.0);
            prop_assert!(tint.is_finite() && conductor(cos_i, 1.0, eta, 2.0).unpolarized() <= 1.0);
        }
    }
}
