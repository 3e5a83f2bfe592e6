//! Scattering by metals, smooth and rough.

use brewster_optics::conductor::F82Tint;
use brewster_optics::fresnel::{FresnelModel, Reflectance, conductor, conductor_color};
use brewster_optics::lobe::{LobeSample, LobeSplit, LobeValue};
use brewster_optics::microfacet::Ggx;
use brewster_optics::multiple::{CompensatedMirror, average_fresnel};
use brewster_optics::thin_film::Film;
use glam::{Vec2, Vec3};

use super::{Scatter, Sides, Surface};
use crate::albedo::Albedos;
use crate::context::Context;
use crate::explain::Fresnel;
use crate::queues::{OnMetal, SurfaceHit, SurfaceHitsView};

/// A conductor, its index relative to the medium in front of it.
#[derive(Clone, Copy, Debug)]
pub struct Conductor {
    facets: Ggx,
    /// The same facets, where they keep the light that meets further ones.
    compensated: Option<CompensatedMirror>,
    film: Option<Film>,
    fresnel: FresnelModel,
    r0: Vec3,
    tint: F82Tint,
    eta_i: f32,
    eta: Vec3,
    k: Vec3,
}

impl Conductor {
    /// What a facet reflects.
    #[inline(always)]
    pub fn reflectance(&self, cos_i: f32) -> Vec3 {
        if let Some(film) = self.film {
            return film.reflectance(cos_i, self.eta_i, self.eta, self.k);
        }
        match self.fresnel {
            FresnelModel::Exact => conductor_color(cos_i, self.eta_i, self.eta, self.k),
            FresnelModel::Schlick | FresnelModel::SchlickThetaM => self.tint.reflectance(cos_i),
        }
    }
}

impl Conductor {
    /// The conductor of a row of metals at a hit, in a medium of index `eta_i`.
    #[inline(always)]
    pub fn new(context: &Context<'_>, row: usize, hit: &SurfaceHit, eta_i: f32) -> Conductor {
        let material = context.scene.materials.metal.get(row);
        let r0 = context.scene.color(material.r0, &context.seen(hit.place()));
        Conductor {
            facets: Ggx::isotropic(material.alpha),
            compensated: None,
            film: material.film,
            fresnel: material.fresnel,
            r0,
            tint: F82Tint::new(r0, material.r90, material.f82),
            eta_i,
            eta: material.eta,
            k: material.k,
        }
    }

    /// What is to be told of the metal, as if it were smooth.
    pub(crate) fn fresnel_at(&self, cos_i: f32) -> Fresnel {
        let by_index = self.fresnel == FresnelModel::Exact;
        let channel = |part: fn(Reflectance) -> f32| {
            Vec3::from_array([0, 1, 2].map(|i| part(conductor(cos_i, self.eta_i, self.eta[i], self.k[i]))))
        };
        Fresnel {
            model: self.fresnel,
            alpha: if self.is_smooth() { 0.0 } else { self.facets.alphas()[0] },
            eta_i: self.eta_i,
            eta_t: by_index.then_some(self.eta),
            k: by_index.then_some(self.k),
            r_s: by_index.then(|| channel(|reflectance| reflectance.s)),
            r_p: by_index.then(|| channel(|reflectance| reflectance.p)),
            f_r: self.reflectance(cos_i),
            f_t: Vec3::ZERO,
            is_total: false,
        }
    }

    /// Its facets.
    #[inline(always)]
    pub fn facets(&self) -> Ggx {
        self.facets
    }
}

impl Scatter for OnMetal {
    type Surface = Conductor;

    const TRANSMITS: bool = false;

    #[inline(always)]
    fn asks_lights(context: &Context<'_>, hits: SurfaceHitsView<'_>) -> bool {
        let alpha = context.scene.materials.metal.view().alpha;
        hits.materials().iter().any(|&row| alpha[row as usize] > 0.0)
    }

    #[inline(always)]
    fn surface(context: &Context<'_>, hit: &SurfaceHit, sides: &Sides) -> Conductor {
        let (row, dielectrics) = (hit.material as usize, context.scene.materials.dielectric.view());
        let conductor = Conductor::new(context, row, hit, sides.filling[0].ior_at(sides.wavelength, &dielectrics));
        if !context.scene.materials.metal.view().compensated[row] || conductor.facets.is_smooth() {
            return conductor;
        }
        let average = average_fresnel(|cos_i| conductor.reflectance(cos_i));
        Conductor { compensated: Some(CompensatedMirror::new(conductor.facets, average)), ..conductor }
    }

    #[inline(always)]
    fn albedo(albedos: &Albedos, surface: &Conductor, hit: &SurfaceHit, sides: &Sides, cosine: f32) -> Option<Vec3> {
        let rough = albedos.metal(hit.material, sides.filling[0], surface.r0, cosine);
        let single = rough.unwrap_or_else(|| surface.reflectance(cosine));
        let view = Vec3::new((1.0 - cosine * cosine).max(0.0).sqrt(), 0.0, cosine);
        Some(single + surface.compensated.map_or(Vec3::ZERO, |mirror| mirror.further(view)))
    }
}

impl Surface for Conductor {
    #[inline(always)]
    fn is_smooth(&self) -> bool {
        self.facets.is_smooth()
    }

    #[inline(always)]
    fn transmits(&self) -> bool {
        false
    }

    #[inline(always)]
    fn evaluate(&self, view: Vec3, light: Vec3) -> LobeValue {
        match &self.compensated {
            Some(mirror) => mirror.evaluate(view, light, |cos_i| self.reflectance(cos_i)),
            None => self.facets.reflection(view, light, |cos_i| self.reflectance(cos_i)),
        }
    }

    #[inline(always)]
    fn split(&self, view: Vec3, u: Vec2, lobe: f32) -> LobeSplit {
        if let Some(mirror) = &self.compensated {
            return LobeSplit::opaque(mirror.sample(view, u, lobe, |cos_i| self.reflectance(cos_i)));
        }
        if !self.is_smooth() {
            return LobeSplit::opaque(self.facets.sample_reflection(view, u, |cos_i| self.reflectance(cos_i)));
        }
        let weight = self.reflectance(view.z.min(1.0));
        LobeSplit::opaque(Some(LobeSample::mirror(view, weight)))
    }
}
