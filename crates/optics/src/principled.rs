//! The principled surface: glTF 2.0's metallic-roughness material, with specular, index, clearcoat and sheen.
//!
//! It is glTF's model and not OpenPBR with glTF mapped to it, as most scenes come with glTF's numbers and its
//! specification says what they look like. Frame, names and densities are those of [`lobe`](crate::lobe); it reflects only.
//!
//! - **Specular**, to the letter of the specification's Appendix B, KHR_materials_ior and KHR_materials_specular: GGX of
//!   `alpha = roughness²` with separable shadowing, Schlick's Fresnel value; a metal's `f0` is the base color, a dielectric's
//!   `((ior-1)/(ior+1))²` times the specular color and at most 1, weighted by `specular`; metal and dielectric are mixed
//!   by `metallic`.
//! - **Diffuse**: Appendix B weights Lambert's lobe by what the layer above does not reflect at the half vector, and says
//!   that this breaks the conservation of energy (white plastic at grazing incidence sends back 1.7 of the light). Here
//!   it is the coupling that the appendix names instead, `(1-E(view)) (1-E(light))/(π (1-Ē))` of C. Kulla and A. Conty,
//!   *Revisiting Physically Based Shading at Imageworks*, SIGGRAPH 2017, where E is what the layer reflects in all: white
//!   sends back all light. Up to 45° from the normal both differ by less than 0.05 of the light.
//! - **Sheen** and **clearcoat** (of index 1.5) lie above that, in this order, and leave what is below them `1 - max(E(view),
//!   E(light))`: KHR_materials_sheen's own formula, in place of the clearcoat's Fresnel value of the viewer's side, which is
//!   not reciprocal.
//!
//! So the whole is reciprocal and makes no energy. No facets are narrower than [`SMOOTH_ALPHA`]: a mirror is a lobe like
//! any other, and no direction is singular.

use glam::{Vec2, Vec3};

use crate::albedo_table;
use crate::fresnel::{self, f0_dielectric};
use crate::lobe::{LobeSample, LobeValue, mean};
use crate::microfacet::{Ggx, SMOOTH_ALPHA};
use crate::sheen;
use crate::warp;

/// The reflectance of the clearcoat along the normal, that of an index of 1.5.
const CLEARCOAT_F0: f32 = 0.04;

/// The versine of the cone that is a hemisphere.
const HEMISPHERE: f32 = 1.0;

/// What glTF says of a point, textures read. Factors lie in 0..1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters {
    /// The diffuse color of a dielectric, the specular one of a metal.
    pub base_color: Vec3,
    /// How much of the surface is metal.
    pub metallic: f32,
    /// Its facets; of glTF's roughness, [`Ggx::from_roughness`].
    pub facets: Ggx,
    /// The dielectric's index, relative to the medium around; glTF's 0 stands for infinity and does so here.
    pub ior: f32,
    /// The weight of the dielectric's specular reflection.
    pub specular: f32,
    /// Its tint along the normal; may pass 1.
    pub specular_color: Vec3,
    /// The weight of the clearcoat.
    pub clearcoat: f32,
    /// The clearcoat's facets.
    pub clearcoat_facets: Ggx,
    /// The color of the sheen.
    pub sheen_color: Vec3,
    /// The width of the sheen, the square of its roughness.
    pub sheen_alpha: f32,
}

/// A principled surface, worked out for all pairs of directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Principled {
    facets: Ggx,
    /// What the specular lobe reflects along the normal and at grazing incidence.
    f0: Vec3,
    f90: f32,
    /// The same of the layer over the diffuse base, in its strongest channel.
    layer: [f32; 2],
    diffuse: Vec3,
    /// The part of even light that the layer lets in, 1-Ē.
    entering: f32,
    clearcoat: f32,
    clearcoat_facets: Ggx,
    sheen_color: Vec3,
    sheen_alpha: f32,
}

/// What the parts of a surface take of the light of one direction.
#[derive(Clone, Copy)]
struct Parts {
    specular: Vec3,
    layer: f32,
    sheen: f32,
    clearcoat: f32,
}

/// With which probability a direction is drawn from each lobe; all are 0 where the surface is black.
#[derive(Clone, Copy)]
struct Chances {
    clearcoat: f32,
    sheen: f32,
    specular: f32,
    diffuse: f32,
}

impl Default for Parameters {
    /// glTF's defaults.
    fn default() -> Parameters {
        Parameters {
            base_color: Vec3::ONE,
            metallic: 1.0,
            facets: Ggx::isotropic(1.0),
            ior: 1.5,
            specular: 1.0,
            specular_color: Vec3::ONE,
            clearcoat: 0.0,
            clearcoat_facets: Ggx::isotropic(0.0),
            sheen_color: Vec3::ZERO,
            sheen_alpha: 0.0,
        }
    }
}

impl Principled {
    /// The surface of these parameters.
    #[inline]
    pub fn new(parameters: &Parameters) -> Principled {
        let Parameters { base_color, metallic, specular, .. } = *parameters;
        let facets = spread(parameters.facets);
        let alpha = facets.mean_alpha();
        let dielectric = (parameters.specular_color * f0_dielectric(1.0, parameters.ior)).min(Vec3::ONE) * specular;
        let layer = [dielectric.max_element(), specular];
        let average = schlick(layer, albedo_table::mirror_average(alpha), albedo_table::grazing_average(alpha));
        Principled {
            facets,
            f0: dielectric + (base_color - dielectric) * metallic,
            f90: specular + (1.0 - specular) * metallic,
            layer,
            diffuse: base_color * (1.0 - metallic),
            entering: 1.0 - average,
            clearcoat: parameters.clearcoat,
            clearcoat_facets: spread(parameters.clearcoat_facets),
            sheen_color: parameters.sheen_color,
            sheen_alpha: parameters.sheen_alpha.max(sheen::MIN_ALPHA),
        }
    }

    /// f |cosθ| of all lobes, and the density with which [`Principled::sample`] gives the direction.
    #[inline]
    pub fn evaluate(&self, view: Vec3, light: Vec3) -> LobeValue {
        if !(view.z > 0.0 && light.z > 0.0) {
            return LobeValue::BLACK;
        }
        let (from, to) = (self.parts(view), self.parts(light));
        let chances = self.chances(&from);
        let cosine = warp::cosine_hemisphere_pdf(light);

        let specular = self.facets.reflection(view, light, |cosine| {
            let tail = fresnel::schlick(cosine, 0.0);
            self.f0 + (Vec3::splat(self.f90) - self.f0) * tail
        });
        let coupled = (1.0 - from.layer) * (1.0 - to.layer) / self.entering.max(f32::MIN_POSITIVE);
        let mut f_cos = specular.f_cos + self.diffuse * (coupled * cosine);
        let mut pdf = chances.specular * specular.pdf + chances.diffuse * cosine;
        if self.sheen_color != Vec3::ZERO {
            let part = from.sheen.max(to.sheen);
            f_cos *= 1.0 - self.sheen_color.max_element() * part.min(1.0);
            f_cos += self.sheen_color * sheen::reflection(view, light, self.sheen_alpha, part);
            pdf += chances.sheen * warp::cone_pdf(HEMISPHERE);
        }
        if self.clearcoat > 0.0 {
            let coat = self
                .clearcoat_facets
                .reflection(view, light, |cosine| Vec3::splat(self.clearcoat * fresnel::schlick(cosine, CLEARCOAT_F0)));
            f_cos = f_cos * (1.0 - from.clearcoat.max(to.clearcoat)) + coat.f_cos;
            pdf += chances.clearcoat * coat.pdf;
        }
        LobeValue { f_cos, pdf, ..LobeValue::BLACK }
    }

    /// A direction from one of the lobes, `choice` a random number like both of `u`; its weight and density are those of
    /// all of them. `None` where the light is lost between facets.
    #[inline]
    pub fn sample(&self, view: Vec3, u: Vec2, choice: f32) -> Option<LobeSample> {
        if view.z <= 0.0 {
            return None;
        }
        let chances = self.chances(&self.parts(view));
        let above = chances.clearcoat + chances.sheen;
        let direction = if choice < chances.clearcoat {
            self.clearcoat_facets.sample_reflection(view, u, |_| Vec3::ONE)?.direction
        } else if choice < above {
            // Evenly: at grazing incidence a sheen is brightest along the horizon.
            warp::cone(u, HEMISPHERE)
        } else if choice < above + chances.specular {
            self.facets.sample_reflection(view, u, |_| Vec3::ONE)?.direction
        } else {
            warp::cosine_hemisphere(u)
        };
        let LobeValue { f_cos, pdf, .. } = self.evaluate(view, direction);
        (pdf > 0.0).then(|| LobeSample { direction, weight: f_cos / pdf, pdf, radiance_scale: 1.0 })
    }

    /// What is reflected in all of the light from a direction, within the precision of
    /// [`albedo_table`]; with clearcoat or sheen a bound from above.
    #[inline]
    pub fn albedo(&self, view: Vec3) -> Vec3 {
        let parts = self.parts(view);
        let base = parts.specular + self.diffuse * (1.0 - parts.layer);
        let taken = parts.sheen.min(1.0);
        let cloth = self.sheen_color * taken + base * (1.0 - self.sheen_color.max_element() * taken);
        Vec3::splat(parts.clearcoat) + cloth * (1.0 - parts.clearcoat)
    }

    #[inline(always)]
    fn parts(&self, w: Vec3) -> Parts {
        let alpha = self.facets.mean_alpha();
        let (whole, grazing) = (albedo_table::mirror(w.z, alpha), albedo_table::grazing(w.z, alpha));
        let clearcoat = if self.clearcoat > 0.0 {
            let alpha = self.clearcoat_facets.mean_alpha();
            let (whole, grazing) = (albedo_table::mirror(w.z, alpha), albedo_table::grazing(w.z, alpha));
            self.clearcoat * schlick([CLEARCOAT_F0, 1.0], whole, grazing)
        } else {
            0.0
        };
        let no_sheen = self.sheen_color == Vec3::ZERO;
        Parts {
            specular: self.f0 * (whole - grazing) + Vec3::splat(self.f90 * grazing),
            layer: schlick(self.layer, whole, grazing),
            sheen: if no_sheen { 0.0 } else { albedo_table::sheen(w.z, self.sheen_alpha) },
            clearcoat,
        }
    }

    /// About in proportion to the lobes' light.
    #[inline(always)]
    fn chances(&self, parts: &Parts) -> Chances {
        let taken = parts.sheen.min(1.0);
        let below = (1.0 - parts.clearcoat) * (1.0 - self.sheen_color.max_element() * taken);
        let clearcoat = parts.clearcoat;
        let sheen = (1.0 - clearcoat) * mean(self.sheen_color) * taken;
        let specular = below * mean(parts.specular);
        let diffuse = below * mean(self.diffuse) * (1.0 - parts.layer);
        let scale = 1.0 / (clearcoat + sheen + specular + diffuse).max(f32::MIN_POSITIVE);
        Chances {
            clearcoat: clearcoat * scale,
            sheen: sheen * scale,
            specular: specular * scale,
            diffuse: diffuse * scale,
        }
    }
}

/// What facets of a Schlick curve from `f0` to `f90` reflect in all, by the entries of the table.
#[inline(always)]
fn schlick([f0, f90]: [f32; 2], whole: f32, grazing: f32) -> f32 {
    f0 * (whole - grazing) + f90 * grazing
}

/// Facets that are no mirror.
#[inline(always)]
fn spread(facets: Ggx) -> Ggx {
    let [x, y] = facets.alphas().map(|alpha| alpha.max(SMOOTH_ALPHA));
    Ggx::anisotropic(x, y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::albedo;
    use crate::fresnel::schlick_color;
    use crate::lambert;
    use crate::statistics::{Focus, Random, SphereTest};
    use crate::strategies::{real, unit_vector};
    use glam::DVec3;
    use proptest::prelude::*;

    fn plastic(roughness: f32) -> Parameters {
        Parameters { metallic: 0.0, facets: Ggx::from_roughness(roughness), ..Parameters::default() }
    }

    /// Everything at once.
    fn motley(roughness: f32) -> Parameters {
        Parameters {
            base_color: Vec3::new(0.9, 0.5, 0.1),
            metallic: 0.3,
            facets: Ggx::from_roughness(roughness),
            ior: 1.8,
            specular: 0.7,
            specular_color: Vec3::new(1.0, 0.4, 2.0),
            clearcoat: 0.6,
            clearcoat_facets: Ggx::from_roughness(0.3),
            sheen_color: Vec3::new(0.2, 0.6, 0.4),
            sheen_alpha: 0.25,
        }
    }

    fn at(cosine: f32) -> Vec3 {
        albedo::at_cosine(cosine as f64).as_vec3()
    }

    /// What comes back of green light, by an integral over all directions.
    fn green(parameters: &Parameters, view: Vec3) -> f64 {
        let surface = Principled::new(parameters);
        let focus = Focus::new(Vec3::new(-view.x, -view.y, view.z), surface.facets.mean_alpha());
        focus.total(|light| surface.evaluate(view, light).f_cos.y as f64)
    }

    /// The material of glTF's Appendix B in f64, as its "full code" has it, with KHR_materials_specular's fresnel_mix:
    /// diffuse and specular part, times the cosine.
    fn appendix_b(p: &Parameters, alpha: f64, view: DVec3, light: DVec3) -> [DVec3; 2] {
        let half = (view + light).normalize();
        let (vh, nh, nl, nv) = (view.dot(half), half.z, light.z, view.z);
        let a2 = alpha * alpha;
        let d = a2 / (core::f64::consts::PI * (nh * nh * (a2 - 1.0) + 1.0).powi(2));
        let v = |cosine: f64| 1.0 / (cosine + (a2 + (1.0 - a2) * cosine * cosine).sqrt());
        let specular_brdf = d * v(nl) * v(nv);
        let weight = (1.0 - vh.abs()).powi(5);
        let fresnel = |f0: DVec3| f0 + (DVec3::ONE - f0) * weight;
        let ior = p.ior as f64;
        let f0 = (((1.0 - ior) / (1.0 + ior)).powi(2) * p.specular_color.as_dvec3()).min(DVec3::ONE);
        let (fr, base, metallic) = (fresnel(f0), p.base_color.as_dvec3(), p.metallic as f64);
        let diffuse = base / core::f64::consts::PI * (1.0 - p.specular as f64 * fr.max_element()) * (1.0 - metallic);
        let dielectric = fr * p.specular as f64 * specular_brdf * (1.0 - metallic);
        [diffuse * nl, (dielectric + fresnel(base) * specular_brdf * metallic) * nl]
    }

    /// The specular part is the appendix's; with a diffuse base, which is coupled in another way, all of it is near.
    #[test]
    fn the_appendix_is_followed() {
        let mut random = Random::new(29);
        for i in 0..400 {
            let [view, light] = [(); 2].map(|()| warp::cosine_hemisphere(random.square()));
            let roughness = 0.2 + 0.8 * random.number();
            let colored = Parameters { clearcoat: 0.0, sheen_color: Vec3::ZERO, ..motley(roughness) };
            let alpha = (roughness * roughness) as f64;
            let [diffuse, specular] = appendix_b(&colored, alpha, view.as_dvec3(), light.as_dvec3());
            let black = Principled { diffuse: Vec3::ZERO, ..Principled::new(&colored) };
            let ours = black.evaluate(view, light).f_cos.as_dvec3();
            let close = (ours - specular).abs().max_element() <= 1e-4 * specular.max_element() + 1e-6;
            assert!(close, "{i} {roughness} {view} {light}: {ours} {specular}");
            if view.z.min(light.z) > 0.5f32.sqrt() {
                let ours = Principled::new(&plastic(roughness)).evaluate(view, light).f_cos.as_dvec3();
                let [diffuse, specular] = appendix_b(&plastic(roughness), alpha, view.as_dvec3(), light.as_dvec3());
                let off = (ours - diffuse - specular).abs().max_element() * core::f64::consts::PI;
                assert!(off < 0.05, "{i} {roughness} {view} {light}: {ours} {diffuse} {specular}");
            }
            assert!(diffuse.is_finite());
        }
    }

    /// All metal is the rough mirror of Schlick's color, and without specular all dielectric is Lambert's.
    #[test]
    fn both_ends_are_known() {
        let (view, light) = (Vec3::new(0.6, 0.0, 0.8), Vec3::new(0.0, 0.28, 0.96));
        let color = Vec3::new(0.9, 0.6, 0.2);
        let metal = Parameters { base_color: color, facets: Ggx::isotropic(0.3), ..Parameters::default() };
        let expected = metal.facets.reflection(view, light, |cosine| schlick_color(cosine, color));
        let value = Principled::new(&metal).evaluate(view, light);
        assert!(value.f_cos.abs_diff_eq(expected.f_cos, 1e-6) && (value.pdf - expected.pdf).abs() < 1e-6, "{value:?}");
        let chalk = Parameters { specular: 0.0, base_color: color, ..plastic(0.3) };
        let value = Principled::new(&chalk).evaluate(view, light);
        assert!(value.f_cos.abs_diff_eq(lambert::reflected(color, Vec3::ONE, light.z), 1e-6), "{value:?}");
        assert!((value.pdf - warp::cosine_hemisphere_pdf(light)).abs() < 1e-6, "{value:?}");
        // An index of 0 reflects all, as KHR_materials_ior has it.
        let mirror = Principled::new(&Parameters { ior: 0.0, ..plastic(0.0) });
        assert!((mirror.albedo(view) - Vec3::ONE).abs().max_element() < 2e-3, "{}", mirror.albedo(view));
    }

    /// A white furnace: white plastic sends back all light at every roughness, a white metal what its facets do by theory,
    /// and a colored one what the tables state.
    #[test]
    fn a_furnace_finds_what_is_stated() {
        for roughness in [0.1, 0.5, 1.0] {
            for cosine in [0.9, 0.2] {
                let view = at(cosine);
                let white = green(&plastic(roughness), view);
                assert!((white - 1.0).abs() < 5e-3, "{roughness} {cosine}: {white}");
                let metal = Parameters { facets: Ggx::from_roughness(roughness), ..Parameters::default() };
                let alpha = (roughness as f64).powi(2);
                let theory = albedo::rough_mirror(view.as_dvec3(), [alpha; 2], |_| DVec3::ONE).x;
                let stated = Principled::new(&metal).albedo(view).x as f64;
                assert!((stated - theory).abs() < 4e-3, "{roughness} {cosine}: {stated} {theory}");
            }
            let view = at(0.5);
            let colored = Parameters { clearcoat: 0.0, sheen_color: Vec3::ZERO, ..motley(roughness) };
            let (sent, stated) = (green(&colored, view), Principled::new(&colored).albedo(view).y as f64);
            assert!((sent - stated).abs() < 5e-3, "{roughness}: {sent} {stated}");
        }
    }

    /// White under every layer: no more than all light comes back, nor more than stated.
    #[test]
    fn layers_make_no_energy() {
        for (roughness, sheen_alpha, clearcoat) in [(0.2, 0.0, 0.5), (0.5, 0.3, 0.0), (1.0, 0.04, 1.0)] {
            for cosine in [0.8, 0.1] {
                let white = Parameters {
                    sheen_color: Vec3::ONE,
                    sheen_alpha,
                    clearcoat,
                    clearcoat_facets: Ggx::isotropic(0.2),
                    ..plastic(roughness)
                };
                let (sent, stated) = (green(&white, at(cosine)), Principled::new(&white).albedo(at(cosine)).y as f64);
                assert!(sent < 1.005 && sent < stated + 5e-3, "{roughness} {cosine}: {sent} {stated}");
                assert!(sent > 0.4, "{roughness} {cosine}: {sent}");
            }
        }
    }

    #[test]
    fn samples_follow_their_density() {
        for (name, parameters) in [("plastic", plastic(0.5)), ("motley", motley(0.6)), ("cloth", motley(1.0))] {
            for cosine in [0.9, 0.3] {
                let (surface, view) = (Principled::new(&parameters), at(cosine));
                let test = SphereTest { focus: Focus::SPHERE, family: 6 };
                let sample = |u, choice| surface.sample(view, u, choice).map(|sample| sample.direction);
                test.check(&format!("{name} {view}"), sample, |light| surface.evaluate(view, light).pdf);
                let mut random = Random::new(31);
                let draws = (0..20_000).map(|_| {
                    let (u, choice) = (random.square(), random.number());
                    surface.sample(view, u, choice).map_or(0.0, |sample| sample.weight.y as f64)
                });
                let (mean, sent) = (draws.sum::<f64>() / 20_000.0, green(&parameters, view));
                // Weights lie below 3 and mostly near the mean: four standard errors.
                assert!((mean - sent).abs() < 0.02, "{name} {view}: {mean} {sent}");
            }
        }
    }

    fn parameters() -> impl Strategy<Value = Parameters> {
        let unit = || prop_oneof![4 => real(0.0, 1.0), 1 => Just(0.0), 1 => Just(1.0)];
        let color = || (unit(), unit(), unit()).prop_map(|(x, y, z)| Vec3::new(x, y, z));
        let layers = (unit(), unit(), color(), unit());
        (color(), unit(), unit(), real(0.0, 3.0), unit(), color(), layers).prop_map(
            |(base_color, metallic, roughness, ior, specular, tint, (clearcoat, coat, sheen_color, sheen_alpha))| {
                Parameters {
                    base_color,
                    metallic,
                    facets: Ggx::from_roughness(roughness),
                    ior,
                    specular,
                    specular_color: 2.0 * tint,
                    clearcoat,
                    clearcoat_facets: Ggx::from_roughness(coat),
                    sheen_color,
                    sheen_alpha,
                }
            },
        )
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4096))]

        #[test]
        fn surfaces_are_reciprocal(mut parameters in parameters(), a in unit_vector(), b in unit_vector()) {
            // Of narrower facets the rounding of the half vector is magnified beyond the bound below.
            let wide = |facets: Ggx| Ggx::isotropic(facets.mean_alpha().max(0.05));
            parameters.facets = wide(parameters.facets);
            parameters.clearcoat_facets = wide(parameters.clearcoat_facets);
            let [a, b] = [a, b].map(|w| Vec3::new(w.x, w.y, w.z.abs().max(1e-2)).normalize());
            let surface = Principled::new(&parameters);
            let (there, back) = (surface.evaluate(a, b).f_cos / b.z, surface.evaluate(b, a).f_cos / a.z);
            prop_assert!((there - back).abs().max_element() <= 3e-4 * there.max_element() + 1e-6, "{there} {back}");
        }

        #[test]
        fn samples_are_sound(
            parameters in parameters(), view in unit_vector(), x in real(0.0, 0.999), y in real(0.0, 0.999),
            choice in real(0.0, 0.999),
        ) {
            let surface = Principled::new(&parameters);
            let stated = surface.albedo(view.with_z(view.z.abs()));
            prop_assert!(stated.min_element() >= 0.0 && stated.max_element() < 1.01, "{stated}");
            if let Some(sample) = surface.sample(view, Vec2::new(x, y), choice) {
                prop_assert!(sample.weight.is_finite() && sample.weight.min_element() >= 0.0, "{sample:?}");
                prop_assert!(sample.weight.max_element() < 20.0 && sample.pdf > 0.0 && sample.pdf.is_finite(), "{sample:?}");
            } else {
                let none = surface.evaluate(view, Vec3::Z);
                prop_assert!(none.f_cos.is_finite() && none.pdf >= 0.0, "{none:?}");
            }
        }
    }
}
