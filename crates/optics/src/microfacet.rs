//! Rough surfaces of smooth facets: the GGX distribution, rough conductors and rough dielectrics.
//!
//! Frame, names and densities are those of [`lobe`](crate::lobe). `m` is a facet's normal, unit and with z > 0.
//!
//! - The distribution is GGX (Trowbridge-Reitz), stretched by `alpha_x` and `alpha_y` along the tangents:
//!   B. Walter et al., *Microfacet Models for Refraction through Rough Surfaces*, EGSR 2007; E. Heitz, *Understanding the
//!   Masking-Shadowing Function*, JCGT 3(2), 2014.
//! - Shadowing and masking are Smith's in their *separable* form `G = G1(view) G1(light)`: what Mitsuba's and glTF's
//!   (appendix B) equations say. The height-correlated form shadows a little less; pictures compared with theirs would
//!   come out brighter.
//! - Facets are drawn as the viewer sees them, so that a sample's weight is `F G1(light)`, never above 1:
//!   J. Dupuy and A. Benyoub, *Sampling Visible GGX Normals with Spherical Caps*, HPG 2023.
//! - Light that meets a second facet is lost, as the model has it; [`albedo`](crate::albedo) says how much that is, and
//!   [`multiple`](crate::multiple) gives it back.

use core::f32::consts::{FRAC_1_PI, TAU};

use brewster_lanes::math;
use glam::{Vec2, Vec3};

use crate::lobe::{DELTA, LobeSample, LobeSplit, LobeValue, mean};
use crate::refraction;

/// Below this width in both directions a surface counts as smooth: its lobe spreads less than a tenth of a degree, and f32
/// no longer resolves it.
pub const SMOOTH_ALPHA: f32 = 1e-3;

/// The least width along one direction of a surface that is rough along the other.
const MIN_ALPHA: f32 = 1e-4;

/// Indices that differ by less than this part of themselves make no boundary: the half vector loses its digits there,
/// and a surface between them reflects less than 10⁻⁶.
const MATCHED_INDICES: f32 = 1e-3;

/// The GGX distribution of facets around +z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ggx {
    alpha_x: f32,
    alpha_y: f32,
}

/// A rough boundary between two dielectrics.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoughDielectric {
    /// The facets.
    pub facets: Ggx,
    /// The index on the viewer's side.
    pub eta_i: f32,
    /// The index beyond.
    pub eta_t: f32,
}

impl Ggx {
    /// The same width in every direction, clamped to 10⁻⁴..1.
    #[inline(always)]
    pub fn isotropic(alpha: f32) -> Ggx {
        Ggx::anisotropic(alpha, alpha)
    }

    /// Widths along the local x and y axes, each clamped to 10⁻⁴..1.
    #[inline(always)]
    pub fn anisotropic(alpha_x: f32, alpha_y: f32) -> Ggx {
        // Written so that a width which is not a number becomes the least one.
        let clamped = |alpha: f32| if alpha > MIN_ALPHA { alpha.min(1.0) } else { MIN_ALPHA };
        Ggx { alpha_x: clamped(alpha_x), alpha_y: clamped(alpha_y) }
    }

    /// The width of a perceptual roughness, its square (glTF, OpenPBR).
    #[inline(always)]
    pub fn from_roughness(roughness: f32) -> Ggx {
        Ggx::isotropic(roughness * roughness)
    }

    /// The widths along the local x and y axes.
    #[inline(always)]
    pub fn alphas(self) -> [f32; 2] {
        [self.alpha_x, self.alpha_y]
    }

    /// Whether the lobe is too narrow to be told from a mirror; shade it as one.
    #[inline(always)]
    pub fn is_smooth(self) -> bool {
        self.alpha_x.max(self.alpha_y) < SMOOTH_ALPHA
    }

    /// The width of isotropic facets that stand as straight in the mean, `√(αx αy)`: the same D along the normal.
    ///
    /// What a table of isotropic facets says of it stands for anisotropic ones: a mirror's albedo is at most 0.015 below
    /// the true one, and up to 0.26 above where the widths differ eightfold, so less is given back than was lost.
    #[inline(always)]
    pub fn mean_alpha(self) -> f32 {
        (self.alpha_x * self.alpha_y).sqrt()
    }

    /// D(m): the area of facets of normal `m` per area of the surface and solid angle.
    #[inline(always)]
    pub fn distribution(self, m: Vec3) -> f32 {
        let (x, y) = (m.x / self.alpha_x, m.y / self.alpha_y);
        let s = x * x + y * y + m.z * m.z;
        FRAC_1_PI / (self.alpha_x * self.alpha_y * s * s)
    }

    /// Λ(w): the hidden area of facets over the visible one, seen along `w`; infinite at the horizon.
    #[inline(always)]
    pub fn lambda(self, w: Vec3) -> f32 {
        0.5 * (self.stretched_length(w) / w.z.abs() - 1.0)
    }

    /// G1(w) = 1/(1 + Λ(w)): the part of the facets towards `w` that is visible from there.
    #[inline(always)]
    pub fn g1(self, w: Vec3) -> f32 {
        w.z.abs() * self.g1_over_cosine(w)
    }

    /// Smith's separable shadowing and masking, for facets that both directions see from the right side.
    #[inline(always)]
    pub fn shadowing_masking(self, view: Vec3, light: Vec3) -> f32 {
        self.g1(view) * self.g1(light)
    }

    /// A facet's normal, drawn as often as its area is visible from `view` (with `view.z >= 0`).
    #[inline(always)]
    pub fn sample_visible_normal(self, view: Vec3, u: Vec2) -> Vec3 {
        let stretched = normalized(Vec3::new(self.alpha_x * view.x, self.alpha_y * view.y, view.z));
        // A point of the cap above -stretched.z of the unit sphere: the mirror direction on a hemisphere of mirrors.
        let rise = (1.0 - u.y) * (1.0 + stretched.z);
        let z = rise - stretched.z;
        let radius = ((1.0 - z) * (1.0 + z)).max(0.0).sqrt();
        let (sine, cosine) = math::sin_cos(TAU * u.x);
        // The facet lies halfway; its height above the horizon, z + stretched.z, is known without a difference.
        let (x, y) = (radius * cosine + stretched.x, radius * sine + stretched.y);
        normalized(Vec3::new(self.alpha_x * x, self.alpha_y * y, rise))
    }

    /// The density of [`Ggx::sample_visible_normal`], per solid angle of the normal.
    #[inline(always)]
    pub fn visible_normal_pdf(self, view: Vec3, m: Vec3) -> f32 {
        self.distribution(m) * self.g1_over_cosine(view) * view.dot(m).max(0.0)
    }

    /// A rough mirror of color `fresnel(cosine between view and facet)`: f |cosθ| and its density.
    #[inline(always)]
    pub fn reflection(self, view: Vec3, light: Vec3, fresnel: impl Fn(f32) -> Vec3) -> LobeValue {
        if !(view.z > 0.0 && light.z > 0.0) {
            return LobeValue::BLACK;
        }
        let m = normalized(view + light);
        let pdf = 0.25 * self.distribution(m) * self.g1_over_cosine(view);
        LobeValue { f_cos: fresnel(view.dot(m)) * (pdf * self.g1(light)), pdf, ..LobeValue::BLACK }
    }

    /// A direction from [`Ggx::reflection`]; `None` where the facet sends the light down into its neighbors.
    #[inline(always)]
    pub fn sample_reflection(self, view: Vec3, u: Vec2, fresnel: impl Fn(f32) -> Vec3) -> Option<LobeSample> {
        if view.z <= 0.0 {
            return None;
        }
        let m = self.sample_visible_normal(view, u);
        let cos_i = view.dot(m);
        if cos_i <= 0.0 {
            return None;
        }
        self.reflect(view, m, fresnel(cos_i))
    }

    /// The mirror image of `view` in a facet that is visible from there.
    #[inline(always)]
    fn reflect(self, view: Vec3, m: Vec3, color: Vec3) -> Option<LobeSample> {
        let direction = refraction::mirror(-view, m);
        let pdf = 0.25 * self.distribution(m) * self.g1_over_cosine(view);
        let sample = LobeSample { direction, weight: color * self.g1(direction), pdf, radiance_scale: 1.0 };
        (direction.z > 0.0).then_some(sample)
    }

    /// G1(w)/|w.z|, finite up to the horizon.
    #[inline(always)]
    fn g1_over_cosine(self, w: Vec3) -> f32 {
        2.0 / (w.z.abs() + self.stretched_length(w))
    }

    /// The length of `w` after the stretch that makes the surface one of hemispheres.
    #[inline(always)]
    fn stretched_length(self, w: Vec3) -> f32 {
        let (x, y) = (self.alpha_x * w.x, self.alpha_y * w.y);
        (x * x + y * y + w.z * w.z).sqrt()
    }
}

impl RoughDielectric {
    /// Whether both indices are so near that there is no boundary: light passes straight through.
    #[inline(always)]
    pub fn is_matched(&self) -> bool {
        (self.eta_t - self.eta_i).abs() < MATCHED_INDICES * self.eta_i
    }

    /// f |cosθ| and its density for a direction on either side; `fresnel` takes the cosine between view and facet and is
    /// not asked in total internal reflection.
    ///
    /// Walter et al., equations 20 and 21, their factor `η_o²` divided by the squared index ratio: it is the sampler's
    /// `eta_t²` here, and [`LobeValue::radiance_scale`] makes it the radiance's.
    #[inline(always)]
    pub fn evaluate(&self, view: Vec3, light: Vec3, fresnel: impl Fn(f32) -> Vec3) -> LobeValue {
        if view.z <= 0.0 || light.z == 0.0 || self.is_matched() {
            return LobeValue::BLACK;
        }
        if light.z > 0.0 {
            let cos_i = view.dot(normalized(view + light));
            let (color, _) = self.reflectance(cos_i, fresnel);
            return LobeValue { choice: mean(color), ..self.facets.reflection(view, light, |_| color) };
        }
        let half = self.eta_i * view + self.eta_t * light;
        let m = normalized(if half.z < 0.0 { -half } else { half });
        let (cos_i, cos_t) = (view.dot(m), -light.dot(m));
        if !(cos_i > 0.0 && cos_t > 0.0) {
            return LobeValue::BLACK;
        }
        let (color, _) = self.reflectance(cos_i, fresnel);
        let pdf = self.facets.visible_normal_pdf(view, m) * self.facets_per_direction(cos_i, cos_t);
        let f_cos = (Vec3::ONE - color) * (pdf * self.facets.g1(light));
        LobeValue { f_cos, pdf, choice: 1.0 - mean(color), radiance_scale: self.radiance_scale() }
    }

    /// Both ways from one facet, for a path that splits; [`LobeSplit::choose`] takes one.
    #[inline(always)]
    pub fn split(&self, view: Vec3, u: Vec2, fresnel: impl Fn(f32) -> Vec3) -> LobeSplit {
        let lost = LobeSplit { reflection: None, transmission: None, reflectance: 1.0 };
        if view.z <= 0.0 {
            return lost;
        }
        let radiance_scale = self.radiance_scale();
        if self.is_matched() {
            let straight = LobeSample { direction: -view, weight: Vec3::ONE, pdf: DELTA, radiance_scale };
            return LobeSplit { reflection: None, transmission: Some(straight), reflectance: 0.0 };
        }
        let m = self.facets.sample_visible_normal(view, u);
        let cos_i = view.dot(m);
        if cos_i <= 0.0 {
            return lost;
        }
        let (color, cos_t) = self.reflectance(cos_i, fresnel);
        let transmission = cos_t.and_then(|cos_t| {
            let direction = refraction::refract_with_cosine(-view, m, cos_t, self.eta_i / self.eta_t);
            let pdf = self.facets.visible_normal_pdf(view, m) * self.facets_per_direction(cos_i, cos_t);
            let weight = (Vec3::ONE - color) * self.facets.g1(direction);
            let seen = direction.z < 0.0 && cos_t > 0.0;
            seen.then_some(LobeSample { direction, weight, pdf, radiance_scale })
        });
        LobeSplit { reflection: self.facets.reflect(view, m, color), transmission, reflectance: mean(color) }
    }

    /// What a facet reflects, and the cosine of refraction unless that is all.
    #[inline(always)]
    fn reflectance(&self, cos_i: f32, fresnel: impl Fn(f32) -> Vec3) -> (Vec3, Option<f32>) {
        let cos_t = refraction::cos_t(cos_i.min(1.0), self.eta_i, self.eta_t);
        (if cos_t.is_some() { fresnel(cos_i) } else { Vec3::ONE }, cos_t)
    }

    /// How much solid angle of facets refracts into a unit of solid angle beyond (Walter et al., equation 17).
    #[inline(always)]
    fn facets_per_direction(&self, cos_i: f32, cos_t: f32) -> f32 {
        let across = self.eta_i * cos_i - self.eta_t * cos_t;
        self.eta_t * self.eta_t * cos_t / (across * across)
    }

    #[inline(always)]
    fn radiance_scale(&self) -> f32 {
        let ratio = self.eta_i / self.eta_t;
        ratio * ratio
    }
}

/// A vector of unit length; the normal for one that has no length.
#[inline(always)]
fn normalized(vector: Vec3) -> Vec3 {
    let square = vector.length_squared();
    if square > 1e-30 { vector / square.sqrt() } else { Vec3::Z }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::albedo::{self, Albedo};
    use crate::fresnel::{FresnelModel, conductor_color};
    use crate::statistics::{Focus, Random, SphereTest};
    use crate::strategies::{real, unit_vector};
    use glam::DVec3;
    use proptest::prelude::*;

    const WIDTHS: [[f32; 2]; 8] =
        [[1e-3, 1e-3], [0.02, 0.02], [0.1, 0.1], [0.3, 0.3], [0.7, 0.7], [1.0, 1.0], [0.1, 0.5], [0.6, 0.15]];

    const COSINES: [f32; 5] = [1.0, 0.9, 0.5, 0.15, 0.02];

    /// Each width and each angle of incidence, at some turn about the normal.
    fn cases(widths: &[[f32; 2]], cosines: &[f32]) -> Vec<(Ggx, [f32; 2], Vec3)> {
        let view = |i: usize| {
            let (y, x) = (0.7 * i as f32).sin_cos();
            let sine = (1.0 - cosines[i] * cosines[i]).sqrt();
            Vec3::new(sine * x, sine * y, cosines[i])
        };
        let case = |alpha: [f32; 2], i| (Ggx::anisotropic(alpha[0], alpha[1]), alpha, view(i));
        widths.iter().flat_map(|&alpha| (0..cosines.len()).map(move |i| case(alpha, i))).collect()
    }

    fn all_cases() -> Vec<(Ggx, [f32; 2], Vec3)> {
        cases(&WIDTHS, &COSINES)
    }

    /// Glass of 1.5 from both sides, and one of nearly the same index.
    const INDICES: [(f32, f32); 3] = [(1.0, 1.5), (1.5, 1.0), (1.33, 1.36)];

    fn with_indices<T: Clone>(cases: Vec<T>) -> impl Iterator<Item = ((f32, f32), T)> {
        INDICES.into_iter().flat_map(move |indices| cases.clone().into_iter().map(move |case| (indices, case)))
    }

    fn exact(eta_i: f32, eta_t: f32) -> impl Fn(f32) -> Vec3 + Copy {
        move |cos_i| Vec3::splat(FresnelModel::Exact.dielectric(cos_i, eta_i, eta_t).reflectance)
    }

    fn white(_: f32) -> Vec3 {
        Vec3::ONE
    }

    fn mirror(view: Vec3) -> Vec3 {
        Vec3::new(-view.x, -view.y, view.z)
    }

    /// By hand: D(z) = 1/(π αx αy), at 45° with α = 1 Λ = (√2-1)/2 and D = 1/π, G1 = 2/(1+√2).
    #[test]
    fn the_distribution_by_hand() {
        let close = |a: f32, b: f32| (a - b).abs() <= 2e-6 * b.abs();
        assert!(close(Ggx::anisotropic(0.5, 0.25).distribution(Vec3::Z), 8.0 * FRAC_1_PI));
        let (ggx, diagonal) = (Ggx::isotropic(1.0), Vec3::new(0.5f32.sqrt(), 0.0, 0.5f32.sqrt()));
        assert!(close(ggx.distribution(diagonal), FRAC_1_PI));
        assert!(close(ggx.lambda(diagonal), 0.207_106_78), "{}", ggx.lambda(diagonal));
        assert!(close(ggx.g1(diagonal), 0.828_427_1), "{}", ggx.g1(diagonal));
        assert!(close(ggx.g1(diagonal), 1.0 / (1.0 + ggx.lambda(diagonal))));
        assert_eq!((ggx.g1(Vec3::Z), ggx.g1(Vec3::X), ggx.lambda(Vec3::X)), (1.0, 0.0, f32::INFINITY));
        assert_eq!(Ggx::from_roughness(0.5), Ggx::isotropic(0.25));
        assert_eq!(Ggx::isotropic(f32::NAN), Ggx::isotropic(0.0));
        assert!(Ggx::isotropic(0.0009).is_smooth() && !Ggx::anisotropic(0.0, 0.001).is_smooth());
    }

    /// The facets' projected area is that of the surface, and so is what each view sees of it (Heitz 2014, equations 2
    /// and 14): densities of visible normals integrate to 1.
    #[test]
    fn projected_areas_are_those_of_the_surface() {
        for (ggx, alpha, view) in all_cases() {
            let focus = Focus::new(Vec3::Z, 0.5 * alpha[0].max(alpha[1]));
            let area = focus.total(|m| if m.z > 0.0 { (ggx.distribution(m) * m.z) as f64 } else { 0.0 });
            assert!((area - 1.0).abs() < 2e-4, "{alpha:?}: {area}");
            let seen = focus.total(|m| if m.z > 0.0 { ggx.visible_normal_pdf(view, m) as f64 } else { 0.0 });
            assert!((seen - 1.0).abs() < 5e-4, "{alpha:?} {view}: {seen}");
        }
    }

    #[test]
    fn visible_normals_follow_their_density() {
        for (ggx, alpha, view) in all_cases() {
            let test = SphereTest {
                focus: Focus::new(Vec3::Z, 0.5 * alpha[0].max(alpha[1])),
                family: WIDTHS.len() * COSINES.len(),
            };
            let pdf = |m: Vec3| if m.z > 0.0 { ggx.visible_normal_pdf(view, m) } else { 0.0 };
            test.check(&format!("{ggx:?} {view}"), |u, _| Some(ggx.sample_visible_normal(view, u)), pdf);
        }
    }

    #[test]
    fn reflection_follows_its_density() {
        for (ggx, alpha, view) in all_cases() {
            let test = SphereTest {
                focus: Focus::new(mirror(view), alpha[0].max(alpha[1])),
                family: WIDTHS.len() * COSINES.len(),
            };
            let sample = |u, _| ggx.sample_reflection(view, u, white).map(|sample| sample.direction);
            test.check(&format!("{ggx:?} {view}"), sample, |light| ggx.reflection(view, light, white).pdf);
        }
    }

    /// Both ways of a split, and of a choice, from both sides.
    #[test]
    fn glass_follows_its_density() {
        const WIDTHS: [[f32; 2]; 5] = [[1e-3, 1e-3], [0.1, 0.1], [0.3, 0.3], [1.0, 1.0], [0.1, 0.5]];
        for ((eta_i, eta_t), (facets, alpha, view)) in with_indices(cases(&WIDTHS, &[1.0, 0.5, 0.15])) {
            let fresnel = exact(eta_i, eta_t);
            let glass = RoughDielectric { facets, eta_i, eta_t };
            let width = alpha[0].max(alpha[1]);
            let mut ways = vec![(false, Focus::new(mirror(view), width))];
            // Past the critical angle only the odd facet transmits.
            if let Some(cos_t) = refraction::cos_t(view.z, eta_i, eta_t) {
                let beyond = refraction::refract_with_cosine(-view, Vec3::Z, cos_t, eta_i / eta_t);
                // By how much a facet's tilt turns the refracted direction.
                let bend = (1.0 - eta_i * view.z / (eta_t * cos_t)).abs();
                ways.push((true, Focus::new(beyond, width * bend)));
            }
            for (through, focus) in ways {
                let test = SphereTest { focus, family: 4 * INDICES.len() * WIDTHS.len() * 3 };
                let this_way = |light: Vec3| (light.z < 0.0) == through;
                let value = |light: Vec3| {
                    let value = glass.evaluate(view, light, fresnel);
                    if this_way(light) { value } else { LobeValue::BLACK }
                };
                let name = format!("through: {through}, {glass:?} {view}");
                let split = |u, _| {
                    let LobeSplit { reflection, transmission, .. } = glass.split(view, u, fresnel);
                    (if through { transmission } else { reflection }).map(|sample| sample.direction)
                };
                test.check(&format!("split, {name}"), split, |light| value(light).pdf);
                let chosen = |u, choice| {
                    let direction = glass.split(view, u, fresnel).choose(choice)?.direction;
                    this_way(direction).then_some(direction)
                };
                // Where less than a hundredth goes this way the cells are empty.
                if focus.total(|light| value(light).chosen_pdf() as f64) > 0.01 {
                    test.check(&format!("choice, {name}"), chosen, |light| value(light).chosen_pdf());
                }
            }
        }
    }

    /// A white furnace: the mean weight is the albedo of the quadrature, and the loss is that of single scattering.
    #[test]
    fn rough_mirrors_lose_what_the_theory_says() {
        let gold =
            |cos_i: f32| conductor_color(cos_i, 1.0, Vec3::new(0.143, 0.375, 1.442), Vec3::new(3.983, 2.386, 1.603));
        for (ggx, alpha, view) in all_cases() {
            let expected = albedo::rough_mirror(view.as_dvec3().normalize(), alpha.map(f64::from), |_| DVec3::ONE);
            let golden = albedo::rough_mirror(view.as_dvec3().normalize(), alpha.map(f64::from), |cos_i| {
                gold(cos_i as f32).as_dvec3()
            });
            let mean = mean_of(|u| ggx.sample_reflection(view, u, white).map_or(Vec3::ZERO, |sample| sample.weight));
            let golden_mean =
                mean_of(|u| ggx.sample_reflection(view, u, gold).map_or(Vec3::ZERO, |sample| sample.weight));
            assert!((mean - expected).length() < 1e-3, "{alpha:?} {view}: {mean} {expected}");
            assert!((golden_mean - golden).length() < 1e-3, "{alpha:?} {view}: {golden_mean} {golden}");
            assert!(expected.x <= 1.0 + 1e-4, "{alpha:?} {view}: {expected}");
        }
    }

    /// The same for glass, both ways, from both sides, split and chosen.
    #[test]
    fn rough_glass_loses_what_the_theory_says() {
        for ((eta_i, eta_t), (facets, alpha, view)) in with_indices(all_cases()) {
            let fresnel = exact(eta_i, eta_t);
            let glass = RoughDielectric { facets, eta_i, eta_t };
            let Albedo { reflected, transmitted } =
                albedo::rough_dielectric(view.as_dvec3().normalize(), alpha.map(f64::from), eta_i as f64, eta_t as f64);
            let weight = |sample: Option<LobeSample>| sample.map_or(0.0, |sample| sample.weight.x);
            let split = mean_of(|u| {
                let split = glass.split(view, u, fresnel);
                Vec3::new(weight(split.reflection), weight(split.transmission), 0.0)
            });
            let mut random = Random::new(3);
            let chosen = mean_of(|u| {
                let sample = glass.split(view, u, fresnel).choose(random.unit());
                let through = sample.is_some_and(|sample| sample.is_transmission());
                if through { Vec3::new(0.0, weight(sample), 0.0) } else { Vec3::new(weight(sample), 0.0, 0.0) }
            });
            let expected = DVec3::new(reflected, transmitted, 0.0);
            assert!((split - expected).length() < 1e-3, "{glass:?} {view}: {split} {expected}");
            // The choice is random: four standard errors of 65,536 draws.
            assert!((chosen - expected).length() < 8e-3, "{glass:?} {view}: {chosen} {expected}");
            assert!(reflected + transmitted <= 1.0 + 1e-4, "{glass:?} {view}: {expected}");
        }
    }

    /// The mean over a well-spread set of 65,536 points (M. Roberts's R2 sequence).
    fn mean_of(mut f: impl FnMut(Vec2) -> Vec3) -> DVec3 {
        let sum: DVec3 = (0..65_536)
            .map(|i| {
                let x = (0.754_877_666_246_692_7 * i as f64 + 0.5).fract() as f32;
                let y = (0.569_840_290_998_053_2 * i as f64 + 0.5).fract() as f32;
                f(Vec2::new(x.min(1f32.next_down()), y.min(1f32.next_down()))).as_dvec3()
            })
            .sum();
        sum / 65_536.0
    }

    /// As the width vanishes, the mean way is the mirror's or Snell's and the weight the Fresnel value.
    #[test]
    fn narrow_lobes_tend_to_smooth_boundaries() {
        for (eta_i, eta_t) in [(1.0f32, 1.5f32), (1.5, 1.0)] {
            for cosine in [1.0f32, 0.9, 0.8] {
                let glass = RoughDielectric { facets: Ggx::isotropic(SMOOTH_ALPHA), eta_i, eta_t };
                let view = Vec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine);
                let smooth = FresnelModel::Exact.dielectric(cosine, eta_i, eta_t);
                let refracted = refraction::refract(-view, Vec3::Z, eta_i, eta_t).expect("below the critical angle");
                for u in [Vec2::new(0.1, 0.2), Vec2::new(0.7, 0.6)] {
                    let split = glass.split(view, u, exact(eta_i, eta_t));
                    let (up, down) = (split.reflection.expect("up"), split.transmission.expect("down"));
                    assert!(up.direction.abs_diff_eq(mirror(view), 0.01), "{up:?}");
                    assert!(down.direction.abs_diff_eq(refracted, 0.01), "{down:?}");
                    assert!((up.weight.x - smooth.reflectance).abs() < 3e-3, "{up:?} {smooth:?}");
                    assert!((down.weight.x - smooth.transmittance()).abs() < 3e-3, "{down:?} {smooth:?}");
                    assert!((split.reflectance - smooth.reflectance).abs() < 3e-3);
                }
            }
        }
    }

    #[test]
    fn matched_indices_are_no_boundary() {
        let none = RoughDielectric { facets: Ggx::isotropic(0.5), eta_i: 1.33, eta_t: 1.33 };
        let view = Vec3::new(0.6, 0.0, 0.8);
        let sample = none.split(view, Vec2::splat(0.3), exact(1.33, 1.33)).choose(0.0).expect("it passes");
        assert_eq!((sample.direction, sample.weight, sample.radiance_scale), (-view, Vec3::ONE, 1.0));
        assert!(sample.is_delta() && sample.is_transmission());
        assert_eq!(none.evaluate(view, -view, exact(1.33, 1.33)), LobeValue::BLACK);
    }

    fn width() -> impl Strategy<Value = f32> {
        prop_oneof![4 => real(0.0, 1.0), 1 => real(0.0, 1e-2), 1 => Just(0.0), 1 => Just(1.0)]
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

        /// f(i, o) = f(o, i) for mirrors; through a boundary the radiance's f over the squared index is symmetric.
        #[test]
        fn scattering_is_reciprocal(
            a in upper(), b in upper(), alpha_x in real(0.05, 1.0), alpha_y in real(0.05, 1.0), eta in real(1.1, 2.5),
        ) {
            // Closer to grazing, dividing by the cosine magnifies the rounding of the facet's normal beyond the bound below.
            let [a, b] = [a, b].map(|w| Vec3::new(w.x, w.y, w.z.max(1e-2)).normalize());
            let facets = Ggx::anisotropic(alpha_x, alpha_y);
            let schlick = |cos_i: f32| crate::fresnel::schlick_color(cos_i, Vec3::new(0.9, 0.5, 0.1));
            let (there, back) = (facets.reflection(a, b, schlick), facets.reflection(b, a, schlick));
            let (there, back) = (there.f_cos / b.z, back.f_cos / a.z);
            prop_assert!((there - back).abs().max_element() <= 1e-4 * there.max_element() + 1e-9, "{there} {back}");

            let into = RoughDielectric { facets, eta_i: 1.0, eta_t: eta };
            let out = RoughDielectric { facets, eta_i: eta, eta_t: 1.0 };
            // The frame's z lies on the viewer's side: seen from below, everything is mirrored in the plane.
            let flip = |w: Vec3| Vec3::new(w.x, w.y, -w.z);
            let there = into.evaluate(a, flip(b), exact(1.0, eta));
            let back = out.evaluate(b, flip(a), exact(eta, 1.0));
            let there = there.f_cos.x * there.radiance_scale / b.z;
            let back = back.f_cos.x * back.radiance_scale / a.z / (eta * eta);
            prop_assert!((there - back).abs() <= 1e-3 * there.max(back) + 1e-5, "{there} {back}");
        }

        /// What a sample claims is what an evaluation of its direction finds, and it never gains energy.
        #[test]
        fn samples_agree_with_evaluations(
            view in upper(), alpha_x in real(0.05, 1.0), alpha_y in real(0.05, 1.0), x in number(), y in real(0.0, 0.999),
            inside: bool, eta in real(1.1, 2.5),
        ) {
            let (eta_i, eta_t) = if inside { (eta, 1.0) } else { (1.0, eta) };
            let glass = RoughDielectric { facets: Ggx::anisotropic(alpha_x, alpha_y), eta_i, eta_t };
            let fresnel = exact(eta_i, eta_t);
            let split = glass.split(view, Vec2::new(x, y), fresnel);
            for (sample, choice) in [(split.reflection, split.reflectance), (split.transmission, 1.0 - split.reflectance)] {
                let Some(sample) = sample else { continue };
                // Near the horizon and the critical angle the half vector that an evaluation builds is ill-conditioned.
                if sample.direction.z.abs() < 0.01 || view.z < 0.01 || sample.pdf < 1e-3 {
                    continue;
                }
                let value = glass.evaluate(view, sample.direction, fresnel);
                prop_assert!((value.pdf / sample.pdf - 1.0).abs() < 0.02, "{value:?} {sample:?}");
                prop_assert!((value.choice - choice).abs() < 5e-3, "{value:?} {choice}");
                let weight = value.f_cos / value.pdf;
                prop_assert!((weight - sample.weight).abs().max_element() < 5e-3, "{value:?} {sample:?}");
                prop_assert_eq!(value.radiance_scale, sample.radiance_scale);
            }
        }

        /// No input makes a NaN, an infinity or energy.
        #[test]
        fn nothing_is_not_a_number(
            view in upper(), light in unit_vector(), alpha_x in width(), alpha_y in width(), x in number(), y in number(),
            choice in number(), eta_i in real(1.0, 3.0), eta_t in real(1.0, 3.0),
        ) {
            let facets = Ggx::anisotropic(alpha_x, alpha_y);
            let glass = RoughDielectric { facets, eta_i, eta_t };
            let fresnel = exact(eta_i, eta_t);
            let u = Vec2::new(x, y);
            let split = glass.split(view, u, fresnel);
            let samples = [facets.sample_reflection(view, u, white), split.reflection, split.transmission, split.choose(choice)];
            for sample in samples.into_iter().flatten() {
                prop_assert!((sample.direction.length() - 1.0).abs() < 1e-6, "{sample:?}");
                prop_assert!(sample.weight.is_finite() && sample.pdf > 0.0, "{sample:?}");
                prop_assert!(sample.weight.min_element() >= 0.0 && sample.weight.max_element() <= 1.000_01, "{sample:?}");
            }
            for value in [facets.reflection(view, light, white), glass.evaluate(view, light, fresnel)] {
                prop_assert!(value.f_cos.is_finite() && value.pdf.is_finite(), "{value:?}");
                prop_assert!(value.f_cos.min_element() >= 0.0 && value.pdf >= 0.0, "{value:?}");
                prop_assert!((0.0..=1.0).contains(&value.choice), "{value:?}");
            }
            let m = facets.sample_visible_normal(view, u);
            prop_assert!(m.z >= 0.0 && (m.length() - 1.0).abs() < 1e-6, "{m}");
        }
    }
}
