//! Rough diffuse surfaces: the energy-preserving Oren-Nayar model EON.
//!
//! J. Portsmouth, P. Kutz and S. Hill, *EON: A Practical Energy-Preserving Rough Diffuse BRDF*, JCGT 14(1), 2025. Fujii's
//! form of Oren and Nayar's model, `(ρ/π) A (1 + r s/t)`, and a second lobe for what meets the surface more than once.
//! With albedo 1 nothing is lost at any roughness; roughness 0 is Lambert's surface.
//!
//! With `E(μ) = A (1 + r G(μ))` the directional albedo of the first lobe at ρ = 1 and `Ē = A (1 + r Ḡ)` its average, the
//! paper's `(1-E(μi)) (1-E(μo))/(1-Ē)` is written `A r (g-G(μi)) (g-G(μo))/(g-Ḡ)` here, as `A = 1/(1 + g r)`: so it is
//! no 0/0 at roughness 0. Frame, names and densities are those of [`lobe`](crate::lobe).

use core::f32::consts::FRAC_1_PI;

use brewster_lanes::math;
use glam::{Vec2, Vec3};

use crate::lobe::{LobeSample, LobeValue};
use crate::warp;

/// `g = ½ - 2/(3π)`, which is also G at grazing incidence.
const GRAZING: f32 = 0.5 - FRAC_1_PI * (2.0 / 3.0);

/// `Ḡ = ⅔ - 28/(15π)`.
const AVERAGE: f32 = 2.0 / 3.0 - FRAC_1_PI * (28.0 / 15.0);

/// A rough diffuse surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoughDiffuse {
    /// The albedo ρ per channel, 0 to 1: what [`lambert`](crate::lambert) would reflect.
    pub albedo: Vec3,
    /// The roughness r, 0 (Lambert) to 1 (dust, the full moon).
    pub roughness: f32,
}

/// A clipped linearly transformed cosine (CLTC): the cosine lobe seen through a matrix, its part below the horizon left
/// out. Local x is on the viewer's side.
struct ClippedCosine {
    a: f32,
    b: f32,
    c: f32,
    d: f32,
    /// The part of the disk of cosines that stays above the horizon.
    kept: f32,
    /// The probability of the even lobe that fills what the matrix leaves too thin.
    even: f32,
}

impl RoughDiffuse {
    /// f |cosθ| and its density.
    #[inline(always)]
    pub fn evaluate(&self, view: Vec3, light: Vec3) -> LobeValue {
        if view.z <= 0.0 || light.z <= 0.0 {
            return LobeValue::BLACK;
        }
        LobeValue { f_cos: self.f_cos(view, light), pdf: self.pdf(view, light), ..LobeValue::BLACK }
    }

    /// A direction above the surface.
    #[inline(always)]
    pub fn sample(&self, view: Vec3, u: Vec2) -> Option<LobeSample> {
        if view.z <= 0.0 {
            return None;
        }
        let lobe = ClippedCosine::new(view.z, self.roughness);
        let direction = if u.x < lobe.even {
            even_hemisphere(Vec2::new(u.x / lobe.even, u.y))
        } else {
            let (x, y) = azimuth(view);
            let local = lobe.sample(Vec2::new((u.x - lobe.even) / (1.0 - lobe.even), u.y));
            Vec3::new(x * local.x - y * local.y, y * local.x + x * local.y, local.z)
        };
        let LobeValue { f_cos, pdf, .. } = self.evaluate(view, direction);
        (pdf > 0.0).then(|| LobeSample { direction, weight: f_cos / pdf, pdf, radiance_scale: 1.0 })
    }

    /// What is reflected in all of the light from a direction of that cosine.
    #[inline(always)]
    pub fn directional_albedo(&self, cosine: f32) -> Vec3 {
        let single = 1.0 - self.missing(cosine);
        self.albedo * single + self.multiple_albedo() * (1.0 - single)
    }

    #[inline(always)]
    fn f_cos(&self, view: Vec3, light: Vec3) -> Vec3 {
        let r = self.roughness;
        let s = view.x * light.x + view.y * light.y;
        let s = if s > 0.0 { s / view.z.max(light.z) } else { s };
        let a = self.a();
        let single = self.albedo * (a * (1.0 + r * s));
        let multiple = self.missing(view.z) * (GRAZING - g(light.z)) / (GRAZING - AVERAGE);
        (single + self.multiple_albedo() * multiple) * (FRAC_1_PI * light.z)
    }

    #[inline(always)]
    fn pdf(&self, view: Vec3, light: Vec3) -> f32 {
        let lobe = ClippedCosine::new(view.z, self.roughness);
        let (x, y) = azimuth(view);
        let local = Vec3::new(x * light.x + y * light.y, x * light.y - y * light.x, light.z);
        lobe.even * (0.5 * FRAC_1_PI) + (1.0 - lobe.even) * lobe.pdf(local)
    }

    #[inline(always)]
    fn a(&self) -> f32 {
        1.0 / (1.0 + GRAZING * self.roughness)
    }

    /// `1 - E(μ)`: what the first lobe loses at albedo 1.
    #[inline(always)]
    fn missing(&self, cosine: f32) -> f32 {
        self.a() * self.roughness * (GRAZING - g(cosine))
    }

    /// The color of light that meets the surface more than once.
    #[inline(always)]
    fn multiple_albedo(&self) -> Vec3 {
        let missing = self.a() * self.roughness * (GRAZING - AVERAGE);
        self.albedo * self.albedo * (1.0 - missing) / (Vec3::ONE - self.albedo * missing)
    }
}

impl ClippedCosine {
    /// The fit of the paper's section 4 (its coefficients are published there).
    #[inline(always)]
    fn new(cosine: f32, r: f32) -> ClippedCosine {
        let mu = cosine;
        let a = 1.0 + r * (0.303_392 + (-0.518_982 + 0.111_709 * mu) * mu + (-0.276_266 + 0.335_918 * mu) * r);
        let b = r * (-1.164_07 + 1.158_59 * mu + (0.150_815 - 0.150_105 * mu) * r) / (mu * mu * mu - 1.435_45);
        let c = 1.0 + r * (0.200_13 + (-0.506_373 + 0.261_777 * mu) * mu);
        let d = r * (0.540_852 + (-1.016_25 + 0.475_392 * mu) * mu) / (-1.074_3 + mu * (0.072_562_8 + mu));
        // At normal incidence the fit leaves it a trace above 0, where the clip would be on the other side.
        let d = d.min(0.0);
        let kept = 0.5 + 0.5 / (d * d + 1.0).sqrt();
        let even = 0.162_925 + mu * (-0.372_058 + (0.538_233 - 0.290_822 * mu) * mu);
        ClippedCosine { a, b, c, d, kept, even: even * math::pow(r, 0.1) }
    }

    #[inline(always)]
    fn sample(&self, u: Vec2) -> Vec3 {
        // Squeeze each line of the disk into what the horizon leaves of it; roundings must not touch the horizon.
        let disk = warp::disk(u);
        let half = ((1.0 - disk.y) * (1.0 + disk.y)).max(0.0).sqrt();
        let x = -(half + self.kept * (disk.x - half));
        let z = ((half - x) * (half + x)).max(1e-9).sqrt();
        let (x, y, z) = (self.a * x + self.b * z, self.c * disk.y, (self.d * x + z).max(1e-5));
        Vec3::new(x, y, z) / (x * x + y * y + z * z).sqrt()
    }

    #[inline(always)]
    fn pdf(&self, w: Vec3) -> f32 {
        // The inverse of the matrix times its determinant.
        let across = self.a - self.b * self.d;
        let determinant = self.c * across;
        let h = Vec3::new(self.c * (w.x - self.b * w.z), across * w.y, self.c * (self.a * w.z - self.d * w.x));
        let ratio = determinant / h.length_squared();
        h.z.max(0.0) * ratio * ratio * FRAC_1_PI / self.kept
    }
}

/// G(μ) of the paper over π; 0 at normal incidence.
#[inline(always)]
fn g(cosine: f32) -> f32 {
    let mu = cosine.min(1.0);
    let sine = ((1.0 - mu) * (1.0 + mu)).sqrt();
    // (1 - sin³θ)/cosθ, where 1 - sinθ = cos²θ/(1 + sinθ): no 0/0 at grazing incidence.
    let rest = mu * (1.0 + sine + sine * sine) / (1.0 + sine);
    FRAC_1_PI * sine * ((math::acos(mu) - sine * mu) + (2.0 / 3.0) * (rest - 1.0))
}

/// A direction spread evenly over the upper hemisphere, never at the horizon.
#[inline(always)]
fn even_hemisphere(u: Vec2) -> Vec3 {
    warp::cone(u, 1.0 - 1e-6)
}

/// The cosine and sine of the angle from the x axis to `view`'s projection; any for a view along the normal.
#[inline(always)]
fn azimuth(view: Vec3) -> (f32, f32) {
    let square = view.x * view.x + view.y * view.y;
    let length = square.sqrt();
    if square > 0.0 { (view.x / length, view.y / length) } else { (1.0, 0.0) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::{Focus, SphereTest};
    use crate::strategies::{real, unit_vector};
    use core::f64::consts::PI;
    use glam::DVec3;
    use proptest::prelude::*;

    const ROUGHNESSES: [f32; 5] = [0.0, 0.05, 0.3, 0.7, 1.0];
    const COSINES: [f32; 5] = [1.0, 0.9, 0.5, 0.15, 0.01];

    fn cases() -> impl Iterator<Item = (f32, Vec3)> {
        ROUGHNESSES.into_iter().flat_map(|roughness| {
            COSINES.into_iter().enumerate().map(move |(i, cosine)| {
                let (y, x) = (0.9 * i as f32).sin_cos();
                let sine = (1.0 - cosine * cosine).sqrt();
                (roughness, Vec3::new(sine * x, sine * y, cosine))
            })
        })
    }

    /// The model once more, as the paper's equations stand, in f64 and angles.
    fn reference(albedo: f64, r: f64, view: DVec3, light: DVec3) -> f64 {
        let (theta_o, theta_i) = (view.z.acos(), light.z.acos());
        let s = view.dot(light) - theta_o.cos() * theta_i.cos();
        let t = if s > 0.0 { theta_o.cos().max(theta_i.cos()) } else { 1.0 };
        let a = 1.0 / (1.0 + (0.5 - 2.0 / (3.0 * PI)) * r);
        let e = |theta: f64| {
            let (sin, cos) = theta.sin_cos();
            let g = sin * (theta - sin * cos) + 2.0 / 3.0 * (sin / cos * (1.0 - sin.powi(3)) - sin);
            a * (1.0 + r * g / PI)
        };
        let average = a * (1.0 + (2.0 / 3.0 - 28.0 / (15.0 * PI)) * r);
        let multiple = albedo * albedo * average / (1.0 - albedo * (1.0 - average));
        let shape = if r == 0.0 { 0.0 } else { (1.0 - e(theta_i)) * (1.0 - e(theta_o)) / (1.0 - average) };
        (albedo * a * (1.0 + r * s / t) + multiple * shape) / PI
    }

    #[test]
    fn samples_follow_their_density() {
        for (roughness, view) in cases() {
            let surface = RoughDiffuse { albedo: Vec3::ONE, roughness };
            let test = SphereTest { focus: Focus::SPHERE, family: ROUGHNESSES.len() * COSINES.len() };
            let sample = |u, _| surface.sample(view, u).map(|sample| sample.direction);
            test.check(&format!("{roughness} {view}"), sample, |light| surface.evaluate(view, light).pdf);
        }
    }

    /// A white furnace: nothing is lost at albedo 1, and below it the albedo is the stated one, by a quadrature of the
    /// reference.
    #[test]
    fn a_white_furnace_stays_white() {
        for (roughness, view) in cases() {
            let surface = RoughDiffuse { albedo: Vec3::new(1.0, 0.7, 0.1), roughness };
            let stated = surface.directional_albedo(view.z).as_dvec3();
            assert!((stated.x - 1.0).abs() < 2e-6, "{roughness} {view}: {stated}");
            for channel in 0..3 {
                let albedo = surface.albedo[channel] as f64;
                let f = |light: Vec3| {
                    let light = light.as_dvec3().normalize();
                    if light.z > 0.0 {
                        light.z * reference(albedo, roughness as f64, view.as_dvec3(), light)
                    } else {
                        0.0
                    }
                };
                let exact = Focus::SPHERE.total(f);
                assert!((stated[channel] - exact).abs() < 2e-5, "{roughness} {view}: {stated} {exact}");
            }
        }
    }

    /// At roughness 0 it is Lambert's surface, drawn by the cosine.
    #[test]
    fn without_roughness_it_is_lambert() {
        let (albedo, view) = (Vec3::new(0.9, 0.5, 0.1), Vec3::new(0.6, 0.0, 0.8));
        let surface = RoughDiffuse { albedo, roughness: 0.0 };
        let light = Vec3::new(0.0, -0.8, 0.6);
        let value = surface.evaluate(view, light);
        assert!(value.f_cos.abs_diff_eq(crate::lambert::brdf(albedo) * light.z, 1e-7), "{value:?}");
        assert!((value.pdf - warp::cosine_hemisphere_pdf(light)).abs() < 1e-7);
        let sample = surface.sample(view, Vec2::new(0.3, 0.6)).expect("nothing is lost");
        assert!(sample.weight.abs_diff_eq(albedo, 1e-6), "{sample:?}");
    }

    /// Dust is brightest towards the light: by hand, `A (1 + r s/t)` at r = 1 and 60° both is A·(1 + 0.75/0.5).
    #[test]
    fn dust_reflects_back() {
        let surface = RoughDiffuse { albedo: Vec3::splat(1e-6), roughness: 1.0 };
        let (view, away) = (Vec3::new(0.75f32.sqrt(), 0.0, 0.5), Vec3::new(-(0.75f32.sqrt()), 0.0, 0.5));
        let a = 1.0 / (1.5 - 2.0 / (3.0 * core::f32::consts::PI));
        let back = surface.evaluate(view, view).f_cos.x * 1e6;
        let forth = surface.evaluate(view, away).f_cos.x * 1e6;
        assert!((back - a * 2.5 * 0.5 * FRAC_1_PI).abs() < 1e-5, "{back}");
        assert!((forth - a * 0.25 * 0.5 * FRAC_1_PI).abs() < 1e-5, "{forth}");
    }

    fn upper() -> impl Strategy<Value = Vec3> {
        let above = unit_vector().prop_map(|w| Vec3::new(w.x, w.y, w.z.abs()));
        prop_oneof![6 => above, 1 => Just(Vec3::Z), 1 => Just(Vec3::X), 1 => Just(Vec3::new(0.0, 1.0, 1e-7))]
    }

    fn number() -> impl Strategy<Value = f32> {
        prop_oneof![8 => real(0.0, 1.0), 1 => Just(0.0), 1 => Just(1.0)].prop_map(|x| x.min(1f32.next_down()))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(8192))]

        #[test]
        fn it_is_the_papers_and_reciprocal(a in upper(), b in upper(), roughness in real(0.0, 1.0), albedo in real(0.0, 1.0)) {
            let [a, b] = [a, b].map(|w| Vec3::new(w.x, w.y, w.z.max(1e-3)).normalize());
            let surface = RoughDiffuse { albedo: Vec3::splat(albedo), roughness };
            let (there, back) = (surface.evaluate(a, b).f_cos.x / b.z, surface.evaluate(b, a).f_cos.x / a.z);
            prop_assert!((there - back).abs() <= 1e-6 + 2e-6 * there, "{there} {back}");
            let exact = reference(albedo as f64, roughness as f64, a.as_dvec3().normalize(), b.as_dvec3().normalize());
            prop_assert!((there as f64 - exact).abs() < 5e-6 + 5e-6 * exact, "{there} {exact}");
        }

        #[test]
        fn samples_are_sound(view in upper(), roughness in real(0.0, 1.0), x in number(), y in number()) {
            let surface = RoughDiffuse { albedo: Vec3::ONE, roughness };
            if let Some(sample) = surface.sample(view, Vec2::new(x, y)) {
                prop_assert!((sample.direction.length() - 1.0).abs() < 1e-6 && sample.direction.z > 0.0, "{sample:?}");
                prop_assert!(sample.weight.is_finite() && sample.pdf.is_finite() && sample.pdf > 0.0, "{sample:?}");
                prop_assert!(sample.weight.min_element() >= 0.0 && sample.weight.max_element() < 2.0, "{sample:?}");
            } else {
                prop_assert!(view.z <= 0.0, "a sample was lost");
            }
        }
    }
}
