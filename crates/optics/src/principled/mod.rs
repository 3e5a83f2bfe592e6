//! The principled surface: glTF 2.0's metallic-roughness material with its extensions.
//!
//! It is glTF's model and not OpenPBR with glTF mapped to it, as most scenes come with glTF's numbers and its
//! specification says what they look like. Frame, names and densities are those of [`lobe`](crate::lobe).
//!
//! - **Specular**, to the letter of the specification's Appendix B, KHR_materials_ior and KHR_materials_specular: GGX of
//!   `alpha = roughness²` with separable shadowing, Schlick's Fresnel value; a metal's `f0` is the base color, a dielectric's
//!   `((ior-1)/(ior+1))²` times the specular color and at most 1, weighted by `specular`; metal and dielectric are mixed
//!   by `metallic`. KHR_materials_anisotropy widens the facets along one direction. Beyond the letter, a metal can be told to
//!   keep the light that [meets more than one facet](crate::multiple).
//! - **Diffuse**: Appendix B weights Lambert's lobe by what the layer above does not reflect at the half vector, and says
//!   that this breaks the conservation of energy (white plastic at grazing incidence sends back 1.7 of the light). Here
//!   it is the coupling that the appendix names instead, `(1-E(view)) (1-E(light))/(π (1-Ē))` of C. Kulla and A. Conty,
//!   *Revisiting Physically Based Shading at Imageworks*, SIGGRAPH 2017, where E is what the layer reflects in all: white
//!   sends back all light. Up to 45° from the normal both differ by less than 0.05 of the light.
//!   KHR_materials_diffuse_transmission sends a part of it, with a color of its own, to the other side.
//! - **Transmission** takes the place of the opaque dielectric by `transmission (1-metallic)`: glass of the same facets, with
//!   the Fresnel equations and not Schlick's value, whose light takes the base color at every crossing. It is the boundary
//!   of a volume, or a sheet that light passes straight on, blurred as its mirror image is.
//! - **Iridescence** mixes the Fresnel values with those of a [thin film](crate::thin_film) in vacuum over a base of the index
//!   that has the same `f0`.
//! - **Sheen** and **clearcoat** (of index 1.5) lie above that, in this order, and leave what is below them `1 - max(E(view),
//!   E(light))`: KHR_materials_sheen's own formula, in place of the clearcoat's Fresnel value of the viewer's side, which is
//!   not reciprocal. From inside a volume they are not seen. A clearcoat has a normal of its own.
//!
//! So the whole is reciprocal (but for diffuse light through boundaries; glass over the squared index) and makes no energy. Opaque facets are no narrower
//! than [`SMOOTH_ALPHA`]: a mirror is a lobe like any other. Only the directions of smooth glass are singular.

mod filmed;
mod glass;

pub use glass::Interface;

use glam::{Vec2, Vec3};

use self::filmed::Filmed;
use self::glass::Glass;
use crate::albedo_table;
use crate::audit::Bundles;
use crate::basis::Basis;
use crate::fresnel::{self, f0_dielectric};
use crate::lobe::{DELTA, LobeSample, LobeSplit, LobeValue, mean};
use crate::microfacet::{Ggx, RoughDielectric, SMOOTH_ALPHA};
use crate::multiple::CompensatedMirror;
use crate::sheen;
use crate::thin_film::Film;
use crate::warp;

/// The clearcoat's index.
pub const CLEARCOAT_IOR: f32 = 1.5;

/// The reflectance of the clearcoat along the normal, that of its index.
const CLEARCOAT_F0: f32 = 0.04;

/// The versine of the cone that is a hemisphere.
const HEMISPHERE: f32 = 1.0;

/// The largest number below 1, for choices made twice with one number.
const BELOW_ONE: f32 = 1.0 - f32::EPSILON / 2.0;

/// What glTF says of a point, textures read. Factors lie in 0..1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters {
    /// The diffuse color of a dielectric and of what it transmits, the specular one of a metal.
    pub base_color: Vec3,
    /// How much of the surface is metal.
    pub metallic: f32,
    /// Its facets, along the direction of anisotropy and across; of glTF's roughness, [`Ggx::from_roughness`].
    pub facets: Ggx,
    /// The direction of anisotropy from the tangent: cosine and sine.
    pub direction: Vec2,
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
    /// The clearcoat's own normal, as it may follow other bumps than what it lies on.
    pub clearcoat_normal: Vec3,
    /// The color of the sheen.
    pub sheen_color: Vec3,
    /// The width of the sheen, the square of its roughness.
    pub sheen_alpha: f32,
    /// How much of the dielectric is glass.
    pub transmission: f32,
    /// How much of the dielectric's diffuse light goes to the other side.
    pub diffuse_transmission: f32,
    /// The color of that.
    pub diffuse_transmission_color: Vec3,
    /// What lies behind.
    pub interface: Interface,
    /// Whether the metal keeps the light that meets more than one facet, which the appendix loses.
    pub compensated: bool,
    /// The part that a thin film covers.
    pub iridescence: f32,
    /// The film.
    pub film: Film,
}

/// A principled surface, worked out for all pairs of directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Principled {
    facets: Ggx,
    direction: Vec2,
    /// What the specular lobe reflects along the normal and at grazing incidence.
    f0: Vec3,
    f90: f32,
    /// The same of the layer over the diffuse base, in its strongest channel.
    layer: [f32; 2],
    diffuse: Vec3,
    /// What further facets leave of the light that the metal's first ones lose, over the mean loss.
    further: Vec3,
    /// What the diffuse base sends to the other side.
    through: Vec3,
    /// The part of even light that the layer lets in, 1-Ē.
    entering: f32,
    glass: Option<Glass>,
    filmed: Option<Filmed>,
    clearcoat: f32,
    clearcoat_facets: Ggx,
    /// The frame around the clearcoat's normal.
    clearcoat_frame: Basis,
    sheen_color: Vec3,
    sheen_alpha: f32,
    /// Whether clearcoat and sheen lie on the other side.
    is_inside: bool,
}

/// What the parts of a surface take of the light of one direction.
#[derive(Clone, Copy)]
struct Parts {
    /// What facets reflect that are white, and those that reflect `(1-cosθ)⁵`.
    whole: f32,
    grazing: f32,
    layer: f32,
    /// Under the film.
    filmed_layer: f32,
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
    through: f32,
    glass: f32,
}

impl Default for Parameters {
    /// glTF's defaults.
    fn default() -> Parameters {
        Parameters {
            base_color: Vec3::ONE,
            metallic: 1.0,
            facets: Ggx::isotropic(1.0),
            direction: Vec2::X,
            ior: 1.5,
            specular: 1.0,
            specular_color: Vec3::ONE,
            clearcoat: 0.0,
            clearcoat_facets: Ggx::isotropic(0.0),
            clearcoat_normal: Vec3::Z,
            sheen_color: Vec3::ZERO,
            sheen_alpha: 0.0,
            transmission: 0.0,
            diffuse_transmission: 0.0,
            diffuse_transmission_color: Vec3::ONE,
            interface: Interface::Sheet,
            compensated: false,
            iridescence: 0.0,
            film: Film { ior: 1.3, thickness: 400.0 },
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
        // An infinite index lets nothing in.
        let transmission = if parameters.ior >= 1.0 { parameters.transmission } else { 0.0 };
        let glass = (1.0 - metallic) * transmission;
        let opaque = (1.0 - metallic) * (1.0 - transmission);
        Principled {
            facets,
            direction: parameters.direction,
            f0: dielectric * opaque + base_color * metallic,
            f90: specular * opaque + metallic,
            layer,
            diffuse: base_color * (opaque * (1.0 - parameters.diffuse_transmission)),
            further: if parameters.compensated { further(base_color, alpha) * metallic } else { Vec3::ZERO },
            through: parameters.diffuse_transmission_color * (opaque * parameters.diffuse_transmission),
            entering: 1.0 - average,
            glass: (glass > 0.0).then(|| Glass::new(parameters, glass)),
            filmed: (parameters.iridescence > 0.0).then(|| Filmed::new(parameters, opaque)),
            clearcoat: parameters.clearcoat,
            clearcoat_facets: spread(parameters.clearcoat_facets),
            clearcoat_frame: Basis::around(turned(parameters.direction, parameters.clearcoat_normal)),
            sheen_color: parameters.sheen_color,
            sheen_alpha: parameters.sheen_alpha.max(sheen::MIN_ALPHA),
            is_inside: matches!(parameters.interface, Interface::Boundary { inside: true, .. }),
        }
    }

    /// Whether light comes through.
    #[inline(always)]
    pub fn transmits(&self) -> bool {
        self.glass.is_some() || self.through != Vec3::ZERO
    }

    /// Whether it spreads light widely on the side that it comes from, and lets none through.
    #[inline(always)]
    pub fn is_diffuse(&self) -> bool {
        self.diffuse != Vec3::ZERO && !self.transmits()
    }

    /// Whether all of its directions are singular.
    #[inline(always)]
    pub fn is_smooth(&self) -> bool {
        let covered = self.clearcoat > 0.0 || self.sheen_color != Vec3::ZERO;
        self.glass.is_some_and(|glass| glass.weight == 1.0 && glass.is_smooth()) && (self.is_inside || !covered)
    }

    /// What is left of the light that goes straight on through a smooth sheet; black of all else.
    #[inline]
    pub fn straight(&self, view: Vec3) -> Vec3 {
        let view = self.turned(view);
        let sheet = self.glass.filter(|glass| glass.is_sheet && glass.is_smooth() && view.z > 0.0);
        let through = sheet.and_then(|glass| glass.split(view, Vec2::ZERO).transmission);
        through.map_or(Vec3::ZERO, |sample| self.single(view, sample, 1.0).weight)
    }

    /// f |cosθ| of all lobes, and the density with which [`Principled::split`] gives the direction; the chosen one is that of
    /// [`Principled::choose`].
    #[inline]
    pub fn evaluate(&self, view: Vec3, light: Vec3) -> LobeValue {
        self.evaluate_turned(self.turned(view), self.turned(light))
    }

    /// Both ways on from glass, or one from another lobe; `choice` is a random number like both of `u`. `None` where the light is
    /// lost between facets.
    #[inline]
    pub fn split(&self, view: Vec3, u: Vec2, choice: f32) -> LobeSplit {
        let view = self.turned(view);
        if view.z <= 0.0 {
            return LobeSplit::opaque(None);
        }
        let chances = self.chances(view);
        let Some(glass) = self.glass.filter(|_| choice >= 1.0 - chances.glass) else {
            let direction = self.sample_opaque(&chances, view, u, choice);
            return LobeSplit::opaque(direction.and_then(|direction| self.weighed(view, direction, |value| value.pdf)));
        };
        let LobeSplit { reflection, transmission, reflectance } = glass.split(view, u);
        let weighed = |sample: LobeSample| match sample.is_delta() {
            true => Some(self.single(view, sample, chances.glass)),
            false => self.weighed(view, sample.direction, |value| value.pdf),
        };
        LobeSplit {
            reflection: reflection.and_then(weighed),
            transmission: transmission.and_then(weighed),
            reflectance,
        }
    }

    /// A direction from one of the lobes, `choice` a random number like both of `u`; its weight and density are those of
    /// all of them. `None` where the light is lost between facets.
    #[inline]
    pub fn choose(&self, view: Vec3, u: Vec2, choice: f32) -> Option<LobeSample> {
        let view = self.turned(view);
        if view.z <= 0.0 {
            return None;
        }
        let chances = self.chances(view);
        let opaque = 1.0 - chances.glass;
        let direction = match self.glass.filter(|_| choice >= opaque) {
            None => self.sample_opaque(&chances, view, u, choice)?,
            Some(glass) => {
                let again = ((choice - opaque) / chances.glass).min(BELOW_ONE);
                let sample = glass.split(view, u).choose(again)?;
                if sample.is_delta() {
                    return Some(self.single(view, sample, chances.glass));
                }
                sample.direction
            }
        };
        self.weighed(view, direction, LobeValue::chosen_pdf)
    }

    /// What is sent into the single directions of smooth glass, which have no value.
    #[inline]
    pub fn singular(&self, view: Vec3) -> Vec3 {
        let view = self.turned(view);
        let smooth = self.glass.filter(|glass| glass.is_smooth() && view.z > 0.0);
        let split = smooth.map_or(LobeSplit::opaque(None), |glass| glass.split(view, Vec2::ZERO));
        let ways = [split.reflection, split.transmission].into_iter().flatten();
        ways.map(|sample| self.single(view, sample, 1.0).weight).sum()
    }

    /// An estimate of all that is sent on beside that, by three numbers of one's own.
    #[inline]
    pub fn estimate(&self, view: Vec3, choice: f32, u: Vec2) -> Vec3 {
        let view = self.turned(view);
        if view.z <= 0.0 {
            return Vec3::ZERO;
        }
        let mut bundles = Bundles::ABOVE.and_highlight(view, &self.facets);
        if self.transmits() {
            bundles = bundles.and_below();
        }
        if let Some((axis, width)) = self.glass.and_then(|glass| glass.bundle_through(view)) {
            bundles = bundles.and(axis, width);
        }
        if self.clearcoat > 0.0 && !self.is_inside {
            let normal = self.clearcoat_frame.normal;
            let image = normal * (2.0 * normal.dot(view)) - view;
            bundles = bundles.and(image, 2.0 * self.clearcoat_facets.mean_alpha());
        }
        bundles.estimate(choice, u, |light| self.evaluate_turned(view, light).f_cos)
    }

    /// The boundary that light comes through, and what facets of it reflect at an angle.
    pub fn boundary(&self, cos_i: f32) -> Option<(RoughDielectric, Vec3)> {
        self.glass.map(|glass| (glass.boundary, glass.reflectance(cos_i)))
    }

    /// The clearcoat's facets, the cosine of a view to its normal, and what they reflect then. `None` where there is none on the viewer's
    /// side.
    pub fn clearcoat(&self, view: Vec3) -> Option<(Ggx, f32, f32)> {
        let covered = self.clearcoat > 0.0 && !self.is_inside;
        let cosine = self.clearcoat_frame.normal.dot(self.turned(view)).clamp(0.0, 1.0);
        let reflected = self.clearcoat * fresnel::schlick(cosine, CLEARCOAT_F0);
        covered.then_some((self.clearcoat_facets, cosine, reflected))
    }

    #[inline(always)]
    fn evaluate_turned(&self, view: Vec3, light: Vec3) -> LobeValue {
        let is_through = light.z < 0.0;
        if view.z <= 0.0 || light.z == 0.0 || (is_through && !self.transmits()) {
            return LobeValue::BLACK;
        }
        let (from, to) = (self.parts(view), self.parts(light));
        let chances = self.chances_of(&from, view);
        let cosine = warp::cosine_hemisphere_pdf(light.with_z(light.z.abs()));
        let coupled = self.coupled(&from, &to) * cosine;
        let (mut f_cos, mut pdf) = if is_through {
            (self.through * coupled, chances.through * cosine)
        } else {
            let specular = self.facets.reflection(view, light, |cosine| self.fresnel(cosine));
            let pdf = chances.specular * specular.pdf + chances.diffuse * cosine;
            let further = self.further * ((1.0 - from.whole) * (1.0 - to.whole) * cosine);
            (specular.f_cos + self.diffuse * coupled + further, pdf)
        };
        let mut chosen = pdf;
        if let Some(glass) = &self.glass {
            let value = glass.evaluate(view, light);
            f_cos += value.f_cos;
            pdf += chances.glass * value.pdf;
            chosen += chances.glass * value.chosen_pdf();
        }
        let covered = is_through || !self.is_inside;
        if covered && self.sheen_color != Vec3::ZERO {
            let part = from.sheen.max(to.sheen);
            f_cos *= 1.0 - self.sheen_color.max_element() * part.min(1.0);
            f_cos += self.sheen_color * sheen::reflection(view, light, self.sheen_alpha, part);
            let even = if is_through { 0.0 } else { chances.sheen * warp::cone_pdf(HEMISPHERE) };
            (pdf, chosen) = (pdf + even, chosen + even);
        }
        if covered && self.clearcoat > 0.0 {
            let coat = if is_through { LobeValue::BLACK } else { self.coat(view, light) };
            f_cos = f_cos * (1.0 - from.clearcoat.max(to.clearcoat)) + coat.f_cos;
            (pdf, chosen) = (pdf + chances.clearcoat * coat.pdf, chosen + chances.clearcoat * coat.pdf);
        }
        let choice = if pdf > 0.0 { chosen / pdf } else { 1.0 };
        LobeValue { f_cos, pdf, choice, ..LobeValue::BLACK }
    }

    /// The clearcoat's own lobe, about its own normal.
    #[inline(always)]
    fn coat(&self, view: Vec3, light: Vec3) -> LobeValue {
        let [view, light] = [view, light].map(|w| self.clearcoat_frame.to_local(w));
        let fresnel = |cosine| Vec3::splat(self.clearcoat * fresnel::schlick(cosine, CLEARCOAT_F0));
        self.clearcoat_facets.reflection(view, light, fresnel)
    }

    /// A direction of any lobe but that of glass.
    #[inline(always)]
    fn sample_opaque(&self, chances: &Chances, view: Vec3, u: Vec2, choice: f32) -> Option<Vec3> {
        let above = chances.clearcoat + chances.sheen;
        if choice < chances.clearcoat {
            let view = self.clearcoat_frame.to_local(view);
            let sample = self.clearcoat_facets.sample_reflection(view, u, |_| Vec3::ONE)?;
            Some(self.clearcoat_frame.to_world(sample.direction)).filter(|direction| direction.z > 0.0)
        } else if choice < above {
            // Evenly: at grazing incidence a sheen is brightest along the horizon.
            Some(warp::cone(u, HEMISPHERE))
        } else if choice < above + chances.specular {
            Some(self.facets.sample_reflection(view, u, |_| Vec3::ONE)?.direction)
        } else {
            let direction = warp::cosine_hemisphere(u);
            let is_through = choice >= above + chances.specular + chances.diffuse && chances.through > 0.0;
            Some(if is_through { direction.with_z(-direction.z) } else { direction })
        }
    }

    /// A direction with the weight that value and density make.
    #[inline(always)]
    fn weighed(&self, view: Vec3, direction: Vec3, density: impl Fn(LobeValue) -> f32) -> Option<LobeSample> {
        let value = self.evaluate_turned(view, direction);
        let pdf = density(value);
        let sample = LobeSample { direction, weight: value.f_cos / pdf, pdf, radiance_scale: 1.0 };
        (pdf > 0.0).then(|| self.turned_back(sample))
    }

    /// A singular direction of glass, which is taken with a probability.
    #[inline(always)]
    fn single(&self, view: Vec3, sample: LobeSample, chance: f32) -> LobeSample {
        let mut weight = sample.weight / chance;
        if sample.is_transmission() || !self.is_inside {
            let (from, to) = (self.parts(view), self.parts(sample.direction));
            weight *= 1.0 - self.sheen_color.max_element() * from.sheen.max(to.sheen).min(1.0);
            weight *= 1.0 - from.clearcoat.max(to.clearcoat);
        }
        self.turned_back(LobeSample { weight, pdf: DELTA, ..sample })
    }

    /// Into the frame of the facets.
    #[inline(always)]
    fn turned(&self, w: Vec3) -> Vec3 {
        turned(self.direction, w)
    }

    #[inline(always)]
    fn turned_back(&self, sample: LobeSample) -> LobeSample {
        let (Vec2 { x: cos, y: sin }, w) = (self.direction, sample.direction);
        LobeSample { direction: Vec3::new(w.x * cos - w.y * sin, w.y * cos + w.x * sin, w.z), ..sample }
    }

    /// What the specular lobe's facets reflect.
    #[inline(always)]
    fn fresnel(&self, cosine: f32) -> Vec3 {
        let plain = self.f0 + (Vec3::splat(self.f90) - self.f0) * fresnel::schlick(cosine, 0.0);
        match &self.filmed {
            Some(filmed) => plain + (filmed.fresnel(cosine) - plain) * filmed.part,
            None => plain,
        }
    }

    /// What the specular lobe reflects of the light from a direction.
    #[inline(always)]
    fn specular(&self, parts: &Parts, view: Vec3) -> Vec3 {
        let plain = self.f0 * (parts.whole - parts.grazing) + Vec3::splat(self.f90 * parts.grazing);
        match &self.filmed {
            Some(filmed) => plain + (filmed.fresnel(view.z.min(1.0)) * parts.whole - plain) * filmed.part,
            None => plain,
        }
    }

    /// What further facets reflect of the light from a direction.
    #[inline(always)]
    fn of_further(&self, parts: &Parts) -> Vec3 {
        self.further * ((1.0 - parts.whole) * (1.0 - albedo_table::mirror_average(self.facets.mean_alpha())))
    }

    /// What the layer above leaves of diffuse light, times π. The mean of a film's is not known: under it less comes back.
    #[inline(always)]
    fn coupled(&self, from: &Parts, to: &Parts) -> f32 {
        let plain = (1.0 - from.layer) * (1.0 - to.layer) / self.entering.max(f32::MIN_POSITIVE);
        match &self.filmed {
            Some(filmed) => plain + (1.0 - from.filmed_layer.max(to.filmed_layer) - plain) * filmed.part,
            None => plain,
        }
    }

    #[inline(always)]
    fn parts(&self, w: Vec3) -> Parts {
        let (cosine, alpha) = (w.z.abs(), self.facets.mean_alpha());
        let (whole, grazing) = (albedo_table::mirror(cosine, alpha), albedo_table::grazing(cosine, alpha));
        let clearcoat = if self.clearcoat > 0.0 {
            let (alpha, cosine) =
                (self.clearcoat_facets.mean_alpha(), self.clearcoat_frame.normal.dot(w).abs().min(1.0));
            let (whole, grazing) = (albedo_table::mirror(cosine, alpha), albedo_table::grazing(cosine, alpha));
            self.clearcoat * schlick([CLEARCOAT_F0, 1.0], whole, grazing)
        } else {
            0.0
        };
        let no_sheen = self.sheen_color == Vec3::ZERO;
        Parts {
            whole,
            grazing,
            layer: schlick(self.layer, whole, grazing),
            filmed_layer: self.filmed.as_ref().map_or(0.0, |filmed| filmed.layer(cosine.min(1.0)) * whole),
            sheen: if no_sheen { 0.0 } else { albedo_table::sheen(cosine, self.sheen_alpha) },
            clearcoat,
        }
    }

    #[inline(always)]
    fn chances(&self, view: Vec3) -> Chances {
        self.chances_of(&self.parts(view), view)
    }

    /// About in proportion to the lobes' light.
    #[inline(always)]
    fn chances_of(&self, parts: &Parts, view: Vec3) -> Chances {
        let taken = parts.sheen.min(1.0);
        let [clearcoat, sheen, below] = if self.is_inside {
            [0.0, 0.0, 1.0]
        } else {
            let under_coat = 1.0 - parts.clearcoat;
            [
                parts.clearcoat,
                under_coat * mean(self.sheen_color) * taken,
                under_coat * (1.0 - self.sheen_color.max_element() * taken),
            ]
        };
        let entering = below * (1.0 - parts.layer);
        let specular = below * mean(self.specular(parts, view));
        let diffuse = entering * mean(self.diffuse) + below * mean(self.of_further(parts));
        let through = entering * mean(self.through);
        let glass = self.glass.as_ref().map_or(0.0, |glass| below * glass.sent(view));
        let scale = 1.0 / (clearcoat + sheen + specular + diffuse + through + glass).max(f32::MIN_POSITIVE);
        Chances {
            clearcoat: clearcoat * scale,
            sheen: sheen * scale,
            specular: specular * scale,
            diffuse: diffuse * scale,
            through: through * scale,
            glass: glass * scale,
        }
    }
}

impl Glass {
    #[inline(always)]
    fn new(parameters: &Parameters, weight: f32) -> Glass {
        let Parameters { facets, ior, iridescence, film, .. } = *parameters;
        let (eta_i, eta_t, is_sheet) = match parameters.interface {
            Interface::Sheet => (1.0, ior, true),
            Interface::Boundary { eta_i, eta_t, .. } => (eta_i, eta_t, false),
        };
        Glass {
            boundary: RoughDielectric { facets, eta_i, eta_t },
            is_sheet,
            weight,
            tint: parameters.base_color,
            specular: parameters.specular,
            specular_color: parameters.specular_color,
            film: (iridescence > 0.0).then_some((film, iridescence)),
        }
    }
}

/// The color of a metal's [second lobe](crate::multiple) over its mean loss; Schlick's curve from `f0` reflects `f0 + (1-f0)/21` of
/// even light.
#[inline(always)]
fn further(f0: Vec3, alpha: f32) -> Vec3 {
    let mirror = CompensatedMirror::new(Ggx::isotropic(alpha), f0 + (Vec3::ONE - f0) / 21.0);
    mirror.color_over_loss()
}

/// What facets of a Schlick curve from `f0` to `f90` reflect in all, by the entries of the table.
#[inline(always)]
fn schlick([f0, f90]: [f32; 2], whole: f32, grazing: f32) -> f32 {
    f0 * (whole - grazing) + f90 * grazing
}

/// Into a frame whose x axis is the given direction.
#[inline(always)]
fn turned(Vec2 { x: cos, y: sin }: Vec2, w: Vec3) -> Vec3 {
    Vec3::new(w.x * cos + w.y * sin, w.y * cos - w.x * sin, w.z)
}

/// Facets that are no mirror.
#[inline(always)]
fn spread(facets: Ggx) -> Ggx {
    let [x, y] = facets.alphas().map(|alpha| alpha.max(SMOOTH_ALPHA));
    Ggx::anisotropic(x, y)
}

#[cfg(test)]
mod tests;
