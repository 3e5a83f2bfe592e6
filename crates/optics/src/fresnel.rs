//! The Fresnel equations: how much light a smooth boundary reflects.
//!
//! Everywhere `eta_i` is the index on the side the light comes from and `eta_t` the index on the other; `cos_i` is the
//! cosine of the angle of incidence θ1, in 0..1 (a rounding above 1 does no harm), and `cos_t` that of the angle of
//! refraction θ2. *s* is the polarization perpendicular to the plane of incidence, *p* the one parallel to it.
//!
//! | equation | function |
//! | --- | --- |
//! | dielectric, angle form | [`dielectric_angle_form`] |
//! | dielectric, cosine form | [`dielectric_cosine_form`], [`amplitudes`] |
//! | conductor, with complex index η + ik | [`conductor`], [`conductor_color`] |
//! | normal incidence F₀ | [`f0_dielectric`], [`f0_conductor`] |
//! | its inverse | [`ior_from_f0`] |
//! | Schlick | [`schlick`], [`schlick_color`] |
//! | Schlick for dielectrics, with θm | [`schlick_theta_m`] |
//!
//! A shader asks [`FresnelModel::dielectric`] or [`FresnelModel::conductor`], which evaluate the model its author
//! chose.
//!
//! Sources: M. Born and E. Wolf, *Principles of Optics*, 7th ed., sections 1.5 and 14.2; C. Schlick, *An Inexpensive
//! BRDF Model for Physically-based Rendering*, Eurographics 1994. The lecture that these functions follow has the names
//! of s and p exchanged in the angle form, drops the squares in the cosine form and misprints its `r_s`; the tests hold
//! on to the corrected equations.

use core::fmt;

use brewster_lanes::math;
use glam::Vec3;

use crate::refraction;

/// How reflectance is computed, so that an author can compare.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum FresnelModel {
    /// The Fresnel equations themselves.
    #[default]
    Exact,
    /// Schlick's approximation with the angle of incidence, whichever side the light comes from.
    Schlick,
    /// Schlick's approximation with the larger of both angles, the one in the thinner medium.
    SchlickThetaM,
}

/// How a dielectric boundary splits light in two.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DielectricSplit {
    /// The part that is reflected, `F_r`: 1 in total internal reflection.
    pub reflectance: f32,
    /// The cosine of the angle of refraction; 0 in total internal reflection.
    pub cos_t: f32,
}

/// The parts of s- and p-polarized light that are reflected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reflectance {
    /// Of light polarized perpendicular to the plane of incidence.
    pub s: f32,
    /// Of light polarized parallel to the plane of incidence.
    pub p: f32,
}

/// The amplitudes of the reflected and transmitted field over that of the incident one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Amplitudes {
    /// Reflected, s-polarized.
    pub r_s: f32,
    /// Reflected, p-polarized.
    pub r_p: f32,
    /// Transmitted, s-polarized.
    pub t_s: f32,
    /// Transmitted, p-polarized.
    pub t_p: f32,
}

/// No index of refraction has this reflectance at normal incidence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InvalidF0(pub f32);

impl FresnelModel {
    /// Every model, the exact one first.
    pub const ALL: [FresnelModel; 3] = [FresnelModel::Exact, FresnelModel::Schlick, FresnelModel::SchlickThetaM];

    /// Splits unpolarized light at a dielectric boundary. Past the critical angle every model reflects all of it.
    #[inline(always)]
    pub fn dielectric(self, cos_i: f32, eta_i: f32, eta_t: f32) -> DielectricSplit {
        let Some(cos_t) = refraction::cos_t(cos_i, eta_i, eta_t) else {
            return DielectricSplit { reflectance: 1.0, cos_t: 0.0 };
        };
        // No `match`: with one, loops do not become vector code.
        let cosine = if self == FresnelModel::SchlickThetaM { cos_i.min(cos_t) } else { cos_i };
        let reflectance = if self == FresnelModel::Exact {
            dielectric_cosine_form(cos_i, cos_t, eta_i, eta_t).unpolarized()
        } else {
            schlick(cosine, f0_dielectric(eta_i, eta_t))
        };
        DielectricSplit { reflectance, cos_t }
    }

    /// The color that a conductor `eta + i k` reflects against a medium of index `eta_i`.
    ///
    /// A conductor has no angle of refraction to compare with, so both Schlick models are the same here.
    #[inline(always)]
    pub fn conductor(self, cos_i: f32, eta_i: f32, eta: Vec3, k: Vec3) -> Vec3 {
        match self {
            FresnelModel::Exact => conductor_color(cos_i, eta_i, eta, k),
            FresnelModel::Schlick | FresnelModel::SchlickThetaM => {
                let r0 = |channel| f0_conductor(eta_i, eta[channel], k[channel]);
                schlick_color(cos_i, Vec3::new(r0(0), r0(1), r0(2)))
            }
        }
    }
}

impl DielectricSplit {
    /// The part that is transmitted, `F_t = 1 - F_r`: a dielectric absorbs nothing at its boundary.
    #[inline(always)]
    pub fn transmittance(self) -> f32 {
        1.0 - self.reflectance
    }

    /// Whether nothing is transmitted: in total internal reflection, and at grazing incidence.
    #[inline(always)]
    pub fn is_total(self) -> bool {
        self.reflectance >= 1.0
    }
}

impl Reflectance {
    /// The reflectance of light that is not polarized, `½(R_s + R_p)`.
    #[inline(always)]
    pub fn unpolarized(self) -> f32 {
        0.5 * (self.s + self.p)
    }
}

impl Amplitudes {
    /// The reflected energy: the squares of the amplitudes.
    #[inline(always)]
    pub fn reflectance(self) -> Reflectance {
        Reflectance { s: self.r_s * self.r_s, p: self.r_p * self.r_p }
    }
}

/// The dielectric in angle form: `R_s = sin²(θ1-θ2)/sin²(θ1+θ2)` and `R_p = tan²(θ1-θ2)/tan²(θ1+θ2)`.
///
/// `theta_i` lies in 0..π/2. At normal incidence, where both are 0/0, the limit [`f0_dielectric`] stands in; past the
/// critical angle both are 1. (The lecture calls the sine ratio parallel and the tangent ratio perpendicular: they are
/// the other way round.)
#[inline(always)]
pub fn dielectric_angle_form(theta_i: f32, eta_i: f32, eta_t: f32) -> Reflectance {
    let Some(theta_t) = refraction::theta_t(theta_i, eta_i, eta_t) else {
        return Reflectance { s: 1.0, p: 1.0 };
    };
    if theta_i == 0.0 {
        let f0 = f0_dielectric(eta_i, eta_t);
        return Reflectance { s: f0, p: f0 };
    }
    let r_s = math::sin(theta_i - theta_t) / math::sin(theta_i + theta_t);
    let r_p = math::tan(theta_i - theta_t) / math::tan(theta_i + theta_t);
    // π/2 in f32 lies beyond π/2, so the ratios may pass 1 by a rounding there.
    Reflectance { s: (r_s * r_s).min(1.0), p: (r_p * r_p).min(1.0) }
}

/// The dielectric in cosine form: the squares of the reflected [`amplitudes`].
///
/// `cos_t` is that of [`refraction::cos_t`]. (The lecture drops the squares.)
#[inline(always)]
pub fn dielectric_cosine_form(cos_i: f32, cos_t: f32, eta_i: f32, eta_t: f32) -> Reflectance {
    amplitudes(cos_i, cos_t, eta_i, eta_t).reflectance()
}

/// The four Fresnel amplitudes of a dielectric.
///
/// `r_s = (η1 cosθ1 - η2 cosθ2)/(η1 cosθ1 + η2 cosθ2)`, `r_p = (η2 cosθ1 - η1 cosθ2)/(η2 cosθ1 + η1 cosθ2)`, and `t_s`,
/// `t_p` are `2 η1 cosθ1` over the same denominators. (The lecture prints `η2 cosθ2 + η2 cosθ2` under `r_s`.) Between
/// equal indices at grazing incidence all are 0/0; there is no boundary, so nothing is reflected.
#[inline(always)]
pub fn amplitudes(cos_i: f32, cos_t: f32, eta_i: f32, eta_t: f32) -> Amplitudes {
    let (s_i, s_t) = (eta_i * cos_i, eta_t * cos_t);
    let (p_i, p_t) = (eta_t * cos_i, eta_i * cos_t);
    Amplitudes {
        r_s: fraction(s_i - s_t, s_i + s_t),
        r_p: fraction(p_i - p_t, p_i + p_t),
        t_s: if s_i + s_t == 0.0 { 1.0 } else { 2.0 * s_i / (s_i + s_t) },
        t_p: if p_i + p_t == 0.0 { 1.0 } else { 2.0 * s_i / (p_i + p_t) },
    }
}

/// A conductor of complex index `eta + i k` against a dielectric of index `eta_i`; what is not reflected turns to heat.
///
/// With `(a + ib)² = (η + ik)²/η1² - sin²θ` (Born and Wolf, section 14.2):
/// `R_s = ((a - cosθ)² + b²)/((a + cosθ)² + b²)` and
/// `R_p = R_s ((a cosθ - sin²θ)² + b² cos²θ)/((a cosθ + sin²θ)² + b² cos²θ)`.
/// Valid for `eta > 0` and `k >= 0`, both below 10⁹; with `k = 0` it is the dielectric, total reflection included.
#[inline(always)]
pub fn conductor(cos_i: f32, eta_i: f32, eta: f32, k: f32) -> Reflectance {
    let (eta, k) = (eta / eta_i, k / eta_i);
    let sin2 = (1.0 - cos_i) * (1.0 + cos_i);
    let real = (eta - k) * (eta + k) - sin2;
    let imaginary = 2.0 * eta * k;
    let modulus = (real * real + imaginary * imaginary).sqrt();
    // The larger of a² and b² is a sum; the smaller follows from ab = ηk, as their difference would cancel.
    let larger = 0.5 * (modulus + real.abs());
    let smaller = fraction(0.25 * imaginary * imaginary, larger);
    let (a2, b2) = if real >= 0.0 { (larger, smaller) } else { (smaller, larger) };
    let a = a2.sqrt();

    let (near, far) = (a - cos_i, a + cos_i);
    let s = fraction(near * near + b2, far * far + b2);
    let (near, far) = (a * cos_i - sin2, a * cos_i + sin2);
    let heat = b2 * cos_i * cos_i;
    Reflectance { s, p: s * fraction(near * near + heat, far * far + heat) }
}

/// The unpolarized reflectance of a [`conductor`] for each color channel.
#[inline(always)]
pub fn conductor_color(cos_i: f32, eta_i: f32, eta: Vec3, k: Vec3) -> Vec3 {
    let channel = |i| conductor(cos_i, eta_i, eta[i], k[i]).unpolarized();
    Vec3::new(channel(0), channel(1), channel(2))
}

/// The reflectance of a dielectric at normal incidence, `F_0 = ((η1-η2)/(η1+η2))²`; the same from both sides.
#[inline(always)]
pub fn f0_dielectric(eta_i: f32, eta_t: f32) -> f32 {
    let r = (eta_i - eta_t) / (eta_i + eta_t);
    r * r
}

/// The reflectance of a conductor at normal incidence, `F_0 = ((η-1)²+k²)/((η+1)²+k²)`, with both relative to `eta_i`.
#[inline(always)]
pub fn f0_conductor(eta_i: f32, eta: f32, k: f32) -> f32 {
    let (less, more, k2) = (eta - eta_i, eta + eta_i, k * k);
    (less * less + k2) / (more * more + k2)
}

/// The relative index `η = (1+√F_0)/(1-√F_0)`, at least 1, of the dielectric that reflects `f0` at normal incidence.
///
/// Its reciprocal reflects the same. An index of this kind is no metal's: aluminum's reflectance would give 44.
pub fn ior_from_f0(f0: f32) -> Result<f32, InvalidF0> {
    if !(0.0..1.0).contains(&f0) {
        return Err(InvalidF0(f0));
    }
    let r = f0.sqrt();
    Ok((1.0 + r) / (1.0 - r))
}

/// Schlick's approximation `F_r ≈ R_0 + (1-R_0)(1-cosθ)⁵`.
#[inline(always)]
pub fn schlick(cos: f32, r0: f32) -> f32 {
    r0 + (1.0 - r0) * math::pow5((1.0 - cos).max(0.0))
}

/// [`schlick`] for each color channel.
#[inline(always)]
pub fn schlick_color(cos: f32, r0: Vec3) -> Vec3 {
    r0 + (Vec3::ONE - r0) * math::pow5((1.0 - cos).max(0.0))
}

/// Schlick's approximation for a dielectric, with `θm = max(θ1, θ2)`, the angle in the thinner medium.
///
/// Past the critical angle it is 1.
#[inline(always)]
pub fn schlick_theta_m(cos_i: f32, eta_i: f32, eta_t: f32) -> f32 {
    FresnelModel::SchlickThetaM.dielectric(cos_i, eta_i, eta_t).reflectance
}

impl fmt::Display for InvalidF0 {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "no index of refraction reflects {} at normal incidence: it must be at least 0 and below 1", self.0)
    }
}

impl core::error::Error for InvalidF0 {}

/// `numerator / denominator` for a denominator that is not negative; 0/0 is 0.
///
/// The smallest number is lost in any other denominator, and costs less than a choice.
#[inline(always)]
fn fraction(numerator: f32, denominator: f32) -> f32 {
    numerator / (denominator + f32::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::refraction::{brewster_angle, cos_t, critical_angle};
    use crate::strategies::{cosine, indices, real, thin_to_dense};
    use core::f32::consts::{FRAC_PI_2, FRAC_PI_4};
    use proptest::prelude::*;

    #[track_caller]
    fn check(what: &str, result: f32, expected: f32, tolerance: f32) {
        assert!((result - expected).abs() <= tolerance, "{what}: {result}, expected {expected} ± {tolerance}");
    }

    fn cosine_form(cos_i: f32, eta_i: f32, eta_t: f32) -> Reflectance {
        let cos_t = cos_t(cos_i, eta_i, eta_t).expect("no total internal reflection here");
        dielectric_cosine_form(cos_i, cos_t, eta_i, eta_t)
    }

    /// Air to glass of 1.5 at 45°, by hand: sin θ2 = √½/1.5 = 0.4714045, cos θ2 = 0.8819171,
    /// r_s = (0.7071068 - 1.3228757)/(0.7071068 + 1.3228757) = -0.3033371, and at 45° R_p = R_s².
    #[test]
    fn both_forms_at_45_degrees() {
        for r in [dielectric_angle_form(FRAC_PI_4, 1.0, 1.5), cosine_form(0.5f32.sqrt(), 1.0, 1.5)] {
            check("R_s", r.s, 0.092_013_4, 2e-7);
            check("R_p", r.p, 0.008_466_5, 2e-7);
            check("F_r", r.unpolarized(), 0.050_239_9, 2e-7);
        }
    }

    /// The slip of the angle form exchanges s and p. At Brewster's angle p vanishes (that is what the angle is) and, as
    /// tan θ1 = η, R_s = ((η²-1)/(η²+1))²: 0.1479290 for 1.5.
    #[test]
    fn p_is_the_one_that_vanishes_at_brewsters_angle() {
        let theta = brewster_angle(1.0, 1.5);
        for r in [dielectric_angle_form(theta, 1.0, 1.5), cosine_form(theta.cos(), 1.0, 1.5)] {
            check("R_p", r.p, 0.0, 1e-12);
            check("R_s", r.s, 0.147_929, 3e-7);
        }
        for eta in [1.0003, 1.33, 2.42] {
            let theta = brewster_angle(eta, 1.0);
            check("R_p from inside", cosine_form(theta.cos(), eta, 1.0).p, 0.0, 1e-7);
            check("R_p from inside", dielectric_angle_form(theta, eta, 1.0).p, 0.0, 1e-7);
        }
    }

    /// The slips of the cosine form: no squares, and `η2 cosθ2 + η2 cosθ2` under `r_s`.
    #[test]
    fn the_cosine_form_is_not_the_printed_one() {
        let (cos_i, eta) = (0.6f32, 1.5f32);
        let cos_t = cos_t(cos_i, 1.0, eta).expect("into the denser side");
        let r = cosine_form(cos_i, 1.0, eta);
        // By hand: cos θ2 = √(1 - 0.64/2.25) = 0.8459052; r_s = (0.6 - 1.2688577)/1.8688577 = -0.3578964,
        // r_p = (0.9 - 0.8459052)/1.7459052 = 0.0309838.
        check("R_s", r.s, 0.128_089_8, 3e-7);
        check("R_p", r.p, 0.000_959_996, 3e-8);
        let printed_r_s = (cos_i - eta * cos_t) / (eta * cos_t + eta * cos_t);
        assert!((r.s - printed_r_s * printed_r_s).abs() > 0.05);
        let a = amplitudes(cos_i, cos_t, 1.0, eta);
        assert!(a.r_s < 0.0 && (r.unpolarized() - 0.5 * (a.r_s + a.r_p)).abs() > 0.2);
    }

    /// F_0 = 4 % for glass of 1.5, 2.0 % for water, 17.2 % for diamond (textbook values), from either side.
    #[test]
    fn normal_incidence_is_the_limit() {
        for (eta, f0) in [(1.5f32, 0.04), (1.333, 0.020_37), (2.417, 0.171_97)] {
            for (eta_i, eta_t) in [(1.0, eta), (eta, 1.0)] {
                check("F_0", f0_dielectric(eta_i, eta_t), f0, 1e-5);
                check("angle form at 0", dielectric_angle_form(0.0, eta_i, eta_t).unpolarized(), f0, 1e-5);
                check("angle form near 0", dielectric_angle_form(1e-20, eta_i, eta_t).unpolarized(), f0, 1e-5);
                check("cosine form at 0", cosine_form(1.0, eta_i, eta_t).unpolarized(), f0, 1e-5);
                check("conductor at 0", conductor(1.0, eta_i, eta_t, 0.0).unpolarized(), f0, 1e-5);
                check("Schlick at 0", schlick(1.0, f0), f0, 0.0);
            }
        }
    }

    #[test]
    fn the_inverse_of_f0() {
        for (f0, eta) in [(0.0, 1.0), (0.04, 1.5), (0.25, 3.0), (0.64, 9.0)] {
            check("eta", ior_from_f0(f0).expect("a dielectric"), eta, 1e-5 * eta);
        }
        // It is no metal's index: aluminum reflects 91.3 %.
        check("aluminum", ior_from_f0(0.913).expect("below 1"), 44.0, 0.1);
        for f0 in [1.0, 1.5, -0.01, f32::NAN, f32::INFINITY] {
            let error = ior_from_f0(f0).expect_err("no dielectric");
            assert!(error.to_string().contains(&f0.to_string()), "{error}");
        }
        assert!(ior_from_f0(1f32.next_down()).expect("below 1").is_finite());
    }

    #[test]
    fn total_internal_reflection_is_total() {
        let critical = critical_angle(1.5, 1.0).expect("from the denser side");
        for model in FresnelModel::ALL {
            for theta in [critical + 1e-3, 1.0, 1.5, FRAC_PI_2] {
                let split = model.dielectric(theta.cos().max(0.0), 1.5, 1.0);
                assert!(split.is_total() && split.transmittance() == 0.0 && split.cos_t == 0.0, "{model:?} {split:?}");
                assert_eq!(dielectric_angle_form(theta, 1.5, 1.0), Reflectance { s: 1.0, p: 1.0 });
            }
            assert!(!model.dielectric((critical - 1e-3).cos(), 1.5, 1.0).is_total(), "{model:?}");
        }
    }

    /// By hand for glass of 1.5 at cos θ1 = 0.5: R_0 = 0.04, 0.04 + 0.96/32 = 0.07. From inside at cos θ1 = 0.9:
    /// cos θ2 = √(1 - 2.25·0.19) = 0.7566373, 0.04 + 0.96·(0.2433627)⁵ = 0.0408195, and with θ1 0.0400096.
    #[test]
    fn schlick_by_hand() {
        check("outside", FresnelModel::Schlick.dielectric(0.5, 1.0, 1.5).reflectance, 0.07, 1e-7);
        check("outside, θm", schlick_theta_m(0.5, 1.0, 1.5), 0.07, 1e-7);
        check("inside", FresnelModel::Schlick.dielectric(0.9, 1.5, 1.0).reflectance, 0.040_009_6, 1e-7);
        check("inside, θm", schlick_theta_m(0.9, 1.5, 1.0), 0.040_819_5, 2e-7);
        assert_eq!(schlick_theta_m(0.5, 1.5, 1.0), 1.0);
        assert_eq!(schlick_color(0.5, Vec3::new(0.0, 0.04, 1.0)), Vec3::new(1.0 / 32.0, schlick(0.5, 0.04), 1.0));
    }

    /// The cosine form in f64, total reflection included.
    fn dielectric_in_f64(cos_i: f64, eta_i: f32, eta_t: f32) -> f64 {
        let (n1, n2) = (eta_i as f64, eta_t as f64);
        let square = 1.0 - (n1 / n2).powi(2) * (1.0 - cos_i * cos_i);
        if square < 0.0 {
            return 1.0;
        }
        let cos_t = square.sqrt();
        let part = |a: f64, b: f64| if a + b == 0.0 { 0.0 } else { ((a - b) / (a + b)).powi(2) };
        0.5 * (part(n1 * cos_i, n2 * cos_t) + part(n2 * cos_i, n1 * cos_t))
    }

    /// Numbers from `-most` to `most`.
    fn roundings(most: f64) -> impl Iterator<Item = f64> {
        (-50..=50).map(move |step| most * step as f64 / 50.0)
    }

    /// The least and the greatest reflectance in f64 over some cosines, with a margin for the rounding of the result.
    fn range_in_f64(cosines: impl Iterator<Item = f64>, eta_i: f32, eta_t: f32) -> (f64, f64) {
        let widen = |(least, greatest): (f64, f64), f: f64| (least.min(f - 1e-6), greatest.max(f + 1e-6));
        cosines.map(|cos_i| dielectric_in_f64(cos_i, eta_i, eta_t)).fold((f64::MAX, f64::MIN), widen)
    }

    /// A conductor in f64, with complex numbers: r_s and r_p of the cosine form with a complex cos θ2.
    fn complex_conductor(cos_i: f64, eta: f64, k: f64) -> (f64, f64) {
        type Complex = (f64, f64);
        let mul = |a: Complex, b: Complex| (a.0 * b.0 - a.1 * b.1, a.0 * b.1 + a.1 * b.0);
        let div = |a: Complex, b: Complex| {
            let square = b.0 * b.0 + b.1 * b.1;
            ((a.0 * b.0 + a.1 * b.1) / square, (a.1 * b.0 - a.0 * b.1) / square)
        };
        let square_root = |a: Complex| {
            let (modulus, angle) = (a.0.hypot(a.1).sqrt(), a.1.atan2(a.0) / 2.0);
            (modulus * angle.cos(), modulus * angle.sin())
        };
        let square = |a: Complex| a.0 * a.0 + a.1 * a.1;
        let n = (eta, k);
        let sin_t = div(((1.0 - cos_i * cos_i).sqrt(), 0.0), n);
        let sin2_t = mul(sin_t, sin_t);
        let cos_t = square_root((1.0 - sin2_t.0, -sin2_t.1));
        let (n_cos_i, n_cos_t) = (mul(n, (cos_i, 0.0)), mul(n, cos_t));
        let r_s = div((cos_i - n_cos_t.0, -n_cos_t.1), (cos_i + n_cos_t.0, n_cos_t.1));
        let r_p = div((n_cos_i.0 - cos_t.0, n_cos_i.1 - cos_t.1), (n_cos_i.0 + cos_t.0, n_cos_i.1 + cos_t.1));
        (square(r_s), square(r_p))
    }

    /// Measured indices (see `metals`) and the reflectance at normal incidence worked out from them by hand. The
    /// lecture's slip is to use the dielectric form, without k, which gives gold 43 % instead of 93 %.
    #[test]
    fn metals_at_normal_incidence() {
        let cases = [
            ("gold at 616.8 nm", 0.21, 3.272, 0.931_0),
            ("gold at 495.9 nm", 1.04, 1.833, 0.446_9),
            ("silver at 548.6 nm", 0.06, 3.586, 0.982_8),
            ("copper at 659.5 nm", 0.22, 3.747, 0.943_3),
            ("copper at 450.9 nm", 1.24, 2.397, 0.539_2),
            ("aluminum at 563.6 nm", 1.0728, 6.7839, 0.914_7),
            ("chromium at 548.6 nm", 3.18, 3.33, 0.554_6),
            ("iron at 548.6 nm", 2.95, 2.93, 0.512_1),
        ];
        for (what, eta, k, f0) in cases {
            check(what, f0_conductor(1.0, eta, k), f0, 1e-4);
            check(what, conductor(1.0, 1.0, eta, k).unpolarized(), f0, 1e-4);
            assert!((f0_dielectric(1.0, eta) - f0).abs() > 0.1, "{what}: k is what makes the metal");
        }
    }

    /// Under water a metal is duller: gold at 616.8 nm, its index relative to 1.333 put in by hand.
    #[test]
    fn a_conductor_in_a_medium_is_relative_to_it() {
        let inside = conductor(0.7, 1.333, 0.21, 3.272);
        let relative = conductor(0.7, 1.0, 0.157_539, 2.454_614);
        check("R_s", inside.s, relative.s, 1e-6);
        check("R_p", inside.p, relative.p, 1e-6);
        check("F_0", f0_conductor(1.333, 0.21, 3.272), f0_conductor(1.0, 0.157_539, 2.454_614), 1e-6);
        assert!(inside.unpolarized() < conductor(0.7, 1.0, 0.21, 3.272).unpolarized());
    }

    #[test]
    fn grazing_incidence_reflects_everything() {
        for eta in [1.0003f32, 1.5, 44.0] {
            for model in FresnelModel::ALL {
                assert_eq!(model.dielectric(0.0, 1.0, eta).reflectance, 1.0, "{model:?} {eta}");
                assert_eq!(model.dielectric(0.0, eta, 1.0).reflectance, 1.0, "{model:?} {eta}");
                assert_eq!(model.conductor(0.0, 1.0, Vec3::splat(eta), Vec3::splat(3.0)), Vec3::ONE);
            }
            check("angle form", dielectric_angle_form(FRAC_PI_2, 1.0, eta).unpolarized(), 1.0, 1e-5);
        }
    }

    #[test]
    fn no_boundary_reflects_nothing() {
        for cos_i in [0.0, 1e-15, 1e-6, 0.5, 1.0] {
            for eta in [1.0, 1.5, 44.0] {
                let split = FresnelModel::Exact.dielectric(cos_i, eta, eta);
                check("F_r", split.reflectance, 0.0, 1e-10);
                check("cos θ2", split.cos_t, cos_i, 2e-7 * cos_i);
            }
        }
        for theta in [1e-20, 0.5, 1.5, FRAC_PI_2] {
            for eta in [1.0, 1.5, 44.0] {
                check("angle form", dielectric_angle_form(theta, eta, eta).unpolarized(), 0.0, 1e-9);
            }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4096))]

        #[test]
        fn reflectances_stay_in_range(
            cos_i in prop_oneof![9 => cosine(), 1 => real(1.0, 1.000_000_3)],
            (eta_i, eta_t) in indices(),
            (eta, k) in (real(0.01, 44.0), real(0.0, 44.0)),
        ) {
            for model in FresnelModel::ALL {
                let split = model.dielectric(cos_i, eta_i, eta_t);
                prop_assert!((0.0..=1.0).contains(&split.reflectance), "{model:?} {split:?}");
                prop_assert!(split.reflectance + split.transmittance() == 1.0, "{model:?} {split:?}");
                prop_assert!((0.0..=1.0).contains(&split.cos_t), "{model:?} {split:?}");
                let color = model.conductor(cos_i, eta_i, Vec3::new(eta, 1.0, eta_t), Vec3::new(k, 0.5, 0.0));
                prop_assert!(color.min_element() >= 0.0 && color.max_element() <= 1.0, "{model:?} {color}");
            }
            let r = conductor(cos_i, eta_i, eta, k);
            prop_assert!((0.0..=1.0).contains(&r.s) && (0.0..=1.0).contains(&r.p), "{r:?}");
            let r = dielectric_angle_form(math::acos(cos_i.min(1.0)), eta_i, eta_t);
            prop_assert!((0.0..=1.0).contains(&r.s) && (0.0..=1.0).contains(&r.p), "{r:?}");
        }

        /// The result is that of a cosine which is off by a few roundings, however steep the equations are there.
        #[test]
        fn the_exact_model_agrees_with_f64(cos_i in cosine(), (eta_i, eta_t) in indices()) {
            let result = FresnelModel::Exact.dielectric(cos_i, eta_i, eta_t).reflectance;
            let cosines = roundings(5e-7).map(|off| cos_i as f64 * (1.0 + off));
            let (least, greatest) = range_in_f64(cosines, eta_i, eta_t);
            prop_assert!((least..=greatest).contains(&(result as f64)), "{result} {least} {greatest}");
        }

        /// From both sides. An angle near π/2 or near the critical angle has few digits left below its cosine.
        #[test]
        fn both_dielectric_forms_agree(part in real(0.0, 0.95), (eta_i, eta_t) in indices()) {
            let theta = part * critical_angle(eta_i, eta_t).unwrap_or(FRAC_PI_2);
            let cos_i = (theta as f64).cos() as f32;
            let (angles, cosines) = (dielectric_angle_form(theta, eta_i, eta_t), cosine_form(cos_i, eta_i, eta_t));
            let tolerance = 4e-6 * (eta_i / eta_t).max(1.0).powi(2);
            prop_assert!((angles.s - cosines.s).abs() < tolerance, "{angles:?} {cosines:?} ± {tolerance}");
            prop_assert!((angles.p - cosines.p).abs() < tolerance, "{angles:?} {cosines:?} ± {tolerance}");
        }

        /// What is reflected and what the transmitted amplitudes carry on (`(η2 cosθ2)/(η1 cosθ1) t²`, Born and Wolf,
        /// section 1.5.3) add up to 1, for s and for p, in both directions.
        #[test]
        fn energy_is_conserved(cos_i in real(0.01, 1.0), (thin, dense) in thin_to_dense()) {
            let cos_t = cos_t(cos_i, thin, dense).expect("from the thinner side");
            for (cos_i, cos_t, eta_i, eta_t) in [(cos_i, cos_t, thin, dense), (cos_t, cos_i, dense, thin)] {
                let a = amplitudes(cos_i, cos_t, eta_i, eta_t);
                let (r, beam) = (a.reflectance(), (eta_t * cos_t) / (eta_i * cos_i));
                prop_assert!((r.s + beam * a.t_s * a.t_s - 1.0).abs() < 2e-6, "{a:?}");
                prop_assert!((r.p + beam * a.t_p * a.t_p - 1.0).abs() < 2e-6, "{a:?}");
            }
        }

        /// Stokes: the way back has `r' = -r` and `t t' = 1 - r²`.
        #[test]
        fn stokes_relations_hold(cos_i in cosine(), (thin, dense) in thin_to_dense()) {
            let cos_t = cos_t(cos_i, thin, dense).expect("from the thinner side");
            let (there, back) = (amplitudes(cos_i, cos_t, thin, dense), amplitudes(cos_t, cos_i, dense, thin));
            prop_assert!((there.r_s + back.r_s).abs() < 1e-6 && (there.r_p + back.r_p).abs() < 1e-6);
            prop_assert!((there.t_s * back.t_s - (1.0 - there.r_s * there.r_s)).abs() < 2e-6, "{there:?} {back:?}");
            prop_assert!((there.t_p * back.t_p - (1.0 - there.r_p * there.r_p)).abs() < 2e-6, "{there:?} {back:?}");
        }

        /// Both sides of a boundary reflect alike at the two ends of one path. The way back is the worse conditioned
        /// the flatter the path on the thin side.
        #[test]
        fn both_sides_are_reciprocal(cos_i in real(0.05, 1.0), (thin, dense) in thin_to_dense()) {
            for model in [FresnelModel::Exact, FresnelModel::SchlickThetaM] {
                let there = model.dielectric(cos_i, thin, dense);
                let back = model.dielectric(there.cos_t, dense, thin);
                let tolerance = 2e-6 + 4e-7 * (dense / thin).powi(2) / cos_i;
                prop_assert!((there.reflectance - back.reflectance).abs() < tolerance, "{model:?} {there:?} {back:?}");
            }
        }

        /// From both sides, total reflection included. The conductor's equations round `sin²θ` and the relative index,
        /// which moves `cos²θ` by an absolute amount; so an index next to the medium's own is left out.
        #[test]
        fn a_conductor_without_k_is_the_dielectric(cos_i in cosine(), (eta_i, eta_t) in indices()) {
            prop_assume!((eta_t / eta_i - 1.0).abs() > 1e-5);
            let result = conductor(cos_i, eta_i, eta_t, 0.0).unpolarized();
            let cosines = roundings(5e-7).map(|off| (cos_i as f64 * cos_i as f64 + off).max(0.0).sqrt());
            let (least, greatest) = range_in_f64(cosines, eta_i, eta_t);
            prop_assert!((least..=greatest).contains(&(result as f64)), "{result} {least} {greatest}");
        }

        #[test]
        fn a_conductor_agrees_with_complex_numbers(cos_i in cosine(), eta in real(0.02, 10.0), k in real(0.05, 20.0)) {
            let r = conductor(cos_i, 1.0, eta, k);
            let (s, p) = complex_conductor(cos_i as f64, eta as f64, k as f64);
            prop_assert!((r.s as f64 - s).abs() < 2e-6 && (r.p as f64 - p).abs() < 2e-6, "{r:?} {s} {p}");
        }

        /// Schlick stays near the exact value for ordinary glass, from both sides (they are reciprocal).
        #[test]
        fn schlick_is_near_for_glass(cos_i in cosine(), eta in real(1.3, 1.8)) {
            let exact = FresnelModel::Exact.dielectric(cos_i, 1.0, eta).reflectance;
            let difference = schlick_theta_m(cos_i, 1.0, eta) - exact;
            prop_assert!(difference.abs() < 0.08, "{difference}");
        }
    }
}
