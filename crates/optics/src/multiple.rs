//! Light that meets more than one facet: what [`microfacet`](crate::microfacet) loses, given back.
//!
//! Rough metal gets a second, diffuse lobe (C. Kulla and A. Conty, *Revisiting Physically Based Shading at Imageworks*,
//! SIGGRAPH 2017): a perfect mirror of isotropic facets sends back all light, within 0.004, at any roughness, and the sum
//! stays reciprocal. Anisotropic facets have it by their [mean width](Ggx::mean_alpha): never more than 1.015 of the
//! light, and less than all where the widths differ much. The lobe's color is `F̄² Ē/(1 - F̄ (1-Ē))`: light that is seen
//! after n facets was reflected n times, and n is at least two (the talk has one F̄ less).
//!
//! Rough glass has E. Turquin's plain factor (*Practical Multiple Scattering Compensation for Microfacet Models*, 2019),
//! [`RoughDielectric::energy_gain`], since a second lobe would veil what is seen through it. It is not reciprocal.

use core::f32::consts::FRAC_1_PI;

use glam::{Vec2, Vec3};

use crate::albedo_table;
use crate::lobe::{LobeSample, LobeValue, mean};
use crate::microfacet::{Ggx, RoughDielectric};
use crate::warp;

/// Less than this is not given back: the tables do not resolve it.
const LEAST_LOSS: f32 = 1e-4;

/// A rough conductor that keeps the light of further facets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CompensatedMirror {
    facets: Ggx,
    /// What further facets leave of the lost light.
    color: Vec3,
    /// The part of the light that a single scattering loses on average.
    average_loss: f32,
}

impl CompensatedMirror {
    /// Facets that reflect `average` of even light, [`average_fresnel`].
    #[inline(always)]
    pub fn new(facets: Ggx, average: Vec3) -> CompensatedMirror {
        let kept = albedo_table::mirror_average(facets.mean_alpha());
        let color = average * average * kept / (Vec3::ONE - average * (1.0 - kept));
        CompensatedMirror { facets, color, average_loss: (1.0 - kept).max(LEAST_LOSS) }
    }

    /// f |cosθ| of both lobes and the density of a choice between them.
    #[inline(always)]
    pub fn evaluate(&self, view: Vec3, light: Vec3, fresnel: impl Fn(f32) -> Vec3) -> LobeValue {
        if view.z <= 0.0 || light.z <= 0.0 {
            return LobeValue::BLACK;
        }
        let single = self.facets.reflection(view, light, fresnel);
        let cosine = light.z * FRAC_1_PI;
        let loss = self.loss(view);
        let further = self.color * (loss * self.loss(light) / self.average_loss * cosine);
        let chance = self.chance(loss);
        let pdf = chance * cosine + (1.0 - chance) * single.pdf;
        LobeValue { f_cos: single.f_cos + further, pdf, ..LobeValue::BLACK }
    }

    /// A direction from either lobe, `choice` a random number like both of `u`.
    #[inline(always)]
    pub fn sample(&self, view: Vec3, u: Vec2, choice: f32, fresnel: impl Fn(f32) -> Vec3) -> Option<LobeSample> {
        if view.z <= 0.0 {
            return None;
        }
        let direction = if choice < self.chance(self.loss(view)) {
            warp::cosine_hemisphere(u)
        } else {
            self.facets.sample_reflection(view, u, |_| Vec3::ONE)?.direction
        };
        let LobeValue { f_cos, pdf, .. } = self.evaluate(view, direction, fresnel);
        (pdf > 0.0).then(|| LobeSample { direction, weight: f_cos / pdf, pdf, radiance_scale: 1.0 })
    }

    /// The second lobe is this times the loss of both directions.
    #[inline(always)]
    pub(crate) fn color_over_loss(&self) -> Vec3 {
        self.color / self.average_loss
    }

    /// What the second lobe reflects of the light from a direction.
    #[inline(always)]
    pub fn further(&self, view: Vec3) -> Vec3 {
        self.color * self.loss(view)
    }

    /// The part of white light from `w` that a single scattering loses.
    #[inline(always)]
    fn loss(&self, w: Vec3) -> f32 {
        (1.0 - albedo_table::mirror(w.z, self.facets.mean_alpha())).max(0.0)
    }

    /// The probability of the second lobe: its part of the light.
    #[inline(always)]
    fn chance(&self, loss: f32) -> f32 {
        let further = loss * mean(self.color);
        further / (further + (1.0 - loss))
    }
}

impl RoughDielectric {
    /// By what a sample's weight or f |cosθ| grows when light of further facets is counted where that of the first goes.
    ///
    /// With it a furnace stays white within the precision of [`albedo_table::boundary`]. It is not reciprocal, as it
    /// depends on the viewer's side only.
    #[inline(always)]
    pub fn energy_gain(&self, view: Vec3) -> f32 {
        if self.is_matched() {
            return 1.0;
        }
        1.0 / albedo_table::boundary(view.z.max(0.0), self.facets.mean_alpha(), self.eta_i, self.eta_t)
    }
}

/// What a smooth surface reflects of even light, `2 ∫ F(μ) μ dμ`, by a Gauss rule of eight nodes.
#[inline(always)]
pub fn average_fresnel(fresnel: impl Fn(f32) -> Vec3) -> Vec3 {
    let mut sum = Vec3::ZERO;
    for (node, weight) in crate::albedo::GAUSS {
        for cosine in [0.5 - 0.5 * node as f32, 0.5 + 0.5 * node as f32] {
            sum += fresnel(cosine) * (cosine * weight as f32);
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fresnel::{FresnelModel, conductor_color, schlick_color};
    use crate::statistics::{Focus, Random, SphereTest};
    use crate::strategies::{real, unit_vector};
    use proptest::prelude::*;

    const WIDTHS: [[f32; 2]; 6] = [[1e-3, 1e-3], [0.1, 0.1], [0.3, 0.3], [0.7, 0.7], [1.0, 1.0], [0.8, 0.1]];
    const COSINES: [f32; 3] = [1.0, 0.5, 0.05];

    fn cases() -> impl Iterator<Item = (Ggx, [f32; 2], Vec3)> {
        WIDTHS.into_iter().flat_map(|alpha| {
            COSINES.into_iter().map(move |cosine| {
                let sine = (1.0 - cosine * cosine).sqrt();
                (Ggx::anisotropic(alpha[0], alpha[1]), alpha, Vec3::new(0.8 * sine, 0.6 * sine, cosine))
            })
        })
    }

    fn white(_: f32) -> Vec3 {
        Vec3::ONE
    }

    #[test]
    fn samples_follow_their_density() {
        for (facets, alpha, view) in cases() {
            let mirror = CompensatedMirror::new(facets, Vec3::ONE);
            let image = Vec3::new(-view.x, -view.y, view.z);
            let test =
                SphereTest { focus: Focus::new(image, alpha[0].max(alpha[1])), family: WIDTHS.len() * COSINES.len() };
            let sample = |u, choice| mirror.sample(view, u, choice, white).map(|sample| sample.direction);
            test.check(&format!("{facets:?} {view}"), sample, |light| mirror.evaluate(view, light, white).pdf);
        }
    }

    /// A white furnace, by an integral over the light of all directions: all of it comes back from isotropic facets, and
    /// never more. What samples weigh in the mean is the same.
    #[test]
    fn a_white_furnace_stays_white() {
        for (facets, alpha, view) in cases() {
            let mirror = CompensatedMirror::new(facets, Vec3::ONE);
            let focus = Focus::new(Vec3::new(-view.x, -view.y, view.z), alpha[0].max(alpha[1]));
            let whole = focus.total(|light| mirror.evaluate(view, light, white).f_cos.x as f64);
            let bounds = if alpha[0] == alpha[1] { 0.996..1.004 } else { 0.7..1.015 };
            assert!(bounds.contains(&whole), "{facets:?} {view}: {whole}");
            let mut random = Random::new(5);
            let draws = (0..20_000).map(|_| {
                let (u, choice) = (random.square(), random.unit());
                mirror.sample(view, u, choice, white).map_or(0.0, |sample| sample.weight.x as f64)
            });
            let mean = draws.sum::<f64>() / 20_000.0;
            // Weights lie below 2: four standard errors.
            assert!((mean - whole).abs() < 0.03, "{facets:?} {view}: {mean} {whole}");
        }
    }

    /// Gray facets in even light, as a series by hand: of what is left after n facets a part Ē leaves the surface, so
    /// `½ Ē + ¼ (1-Ē) Ē + ⅛ (1-Ē)² Ē …` comes back.
    #[test]
    fn every_further_facet_takes_its_part() {
        for alpha in [0.3, 0.7, 1.0] {
            let kept = albedo_table::mirror_average(alpha) as f64;
            let gray = CompensatedMirror::new(Ggx::isotropic(alpha), Vec3::splat(0.5));
            let both = |cosine: f64| {
                let view = crate::albedo::at_cosine(cosine).as_vec3();
                (0.5 * albedo_table::mirror(view.z, alpha) + gray.color.x * gray.loss(view)) as f64
            };
            let series: f64 = (0..60).map(|n| kept * 0.5 * (0.5 * (1.0 - kept)).powi(n)).sum();
            let mean = crate::albedo::average(both);
            assert!((mean - series).abs() < 2e-3, "{alpha}: {mean} {series}");
        }
    }

    #[test]
    fn rough_glass_stays_white() {
        for (eta_i, eta_t) in [(1.0, 1.5), (1.5, 1.0), (1.2, 2.4)] {
            let fresnel = |cos_i: f32| Vec3::splat(FresnelModel::Exact.dielectric(cos_i, eta_i, eta_t).reflectance);
            for (facets, alpha, view) in cases().filter(|(_, alpha, _)| alpha[0] == alpha[1]) {
                let glass = RoughDielectric { facets, eta_i, eta_t };
                let albedo = crate::albedo::rough_dielectric(
                    view.as_dvec3().normalize(),
                    alpha.map(f64::from),
                    eta_i as f64,
                    eta_t as f64,
                );
                let whole = (albedo.reflected + albedo.transmitted) * glass.energy_gain(view) as f64;
                assert!((whole - 1.0).abs() < 0.01, "{glass:?} {view}: {whole}");
                let split = glass.split(view, Vec2::new(0.3, 0.4), fresnel);
                assert!(split.reflectance >= 0.0 && glass.energy_gain(view) >= 0.999);
            }
        }
        let none = RoughDielectric { facets: Ggx::isotropic(0.5), eta_i: 1.5, eta_t: 1.5 };
        assert_eq!(none.energy_gain(Vec3::Z), 1.0);
    }

    /// Schlick's curve averages to `f0 + (1-f0)/21`, in closed form.
    #[test]
    fn averages_in_closed_form() {
        let f0 = Vec3::new(0.04, 0.5, 0.9);
        let average = average_fresnel(|cosine| schlick_color(cosine, f0));
        assert!(average.abs_diff_eq(f0 + (Vec3::ONE - f0) / 21.0, 1e-6), "{average}");
        let gold =
            average_fresnel(|cosine| conductor_color(cosine, 1.0, Vec3::new(0.143, 0.375, 1.442), Vec3::splat(3.0)));
        assert!(gold.min_element() > 0.5 && gold.max_element() < 1.0);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4096))]

        #[test]
        fn both_lobes_are_reciprocal(
            a in unit_vector(), b in unit_vector(), alpha_x in real(0.05, 1.0), alpha_y in real(0.05, 1.0), f0 in real(0.0, 1.0),
        ) {
            let [a, b] = [a, b].map(|w| Vec3::new(w.x, w.y, w.z.abs().max(1e-3)).normalize());
            let f0 = Vec3::splat(f0);
            let fresnel = |cosine: f32| schlick_color(cosine, f0);
            let mirror = CompensatedMirror::new(Ggx::anisotropic(alpha_x, alpha_y), average_fresnel(fresnel));
            let (there, back) = (mirror.evaluate(a, b, fresnel).f_cos.x / b.z, mirror.evaluate(b, a, fresnel).f_cos.x / a.z);
            prop_assert!((there - back).abs() <= 1e-4 * there + 1e-8, "{there} {back}");
        }

        #[test]
        fn samples_are_sound(
            view in unit_vector(), alpha_x in real(0.0, 1.0), alpha_y in real(0.0, 1.0), x in real(0.0, 0.999), y in real(0.0, 0.999),
            choice in real(0.0, 0.999),
        ) {
            let mirror = CompensatedMirror::new(Ggx::anisotropic(alpha_x, alpha_y), Vec3::new(1.0, 0.5, 0.0));
            if let Some(sample) = mirror.sample(view, Vec2::new(x, y), choice, white) {
                prop_assert!(sample.weight.is_finite() && sample.pdf > 0.0 && sample.pdf.is_finite(), "{sample:?}");
                prop_assert!(sample.weight.min_element() >= 0.0 && sample.weight.max_element() < 20.0, "{sample:?}");
            }
        }
    }
}
