//! Scattering by metals, smooth and rough.

use brewster_optics::conductor::F82Tint;
use brewster_optics::fresnel::{FresnelModel, conductor_color};
use brewster_optics::lobe::{LobeSample, LobeSplit, LobeValue};
use brewster_optics::microfacet::Ggx;
use brewster_optics::thin_film::Film;
use glam::{Vec2, Vec3};

use super::{Scatter, Sides, Surface};
use crate::albedo::Albedos;
use crate::context::Context;
use crate::queues::{OnMetal, SurfaceHit};

/// A conductor, its index relative to the medium in front of it.
#[derive(Clone, Copy, Debug)]
pub struct Conductor {
    facets: Ggx,
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
    fn reflectance(&self, cos_i: f32) -> Vec3 {
        if let Some(film) = self.film {
            return film.reflectance(cos_i, self.eta_i, self.eta, self.k);
        }
        match self.fresnel {
            FresnelModel::Exact => conductor_color(cos_i, self.eta_i, self.eta, self.k),
            FresnelModel::Schlick | FresnelModel::SchlickThetaM => self.tint.reflectance(cos_i),
        }
    }
}

impl Scatter for OnMetal {
    type Surface = Conductor;

    const TRANSMITS: bool = false;

    #[inline(always)]
    fn surface(context: &Context<'_>, hit: &SurfaceHit, sides: &Sides) -> Conductor {
        let scene = context.scene;
        let material = scene.materials.metal.get(hit.material as usize);
        let r0 = scene.color(material.r0, &hit.place());
        Conductor {
            facets: Ggx::isotropic(material.alpha),
            film: material.film,
            fresnel: material.fresnel,
            r0,
            tint: F82Tint::new(r0, material.f82),
            eta_i: sides.filling[0].ior_at(sides.wavelength, &scene.materials.dielectric.view()),
            eta: material.eta,
            k: material.k,
        }
    }

    #[inline(always)]
    fn albedo(albedos: &Albedos, surface: &Conductor, hit: &SurfaceHit, sides: &Sides, cosine: f32) -> Option<Vec3> {
        let rough = albedos.metal(hit.material, sides.filling[0], surface.r0, cosine);
        Some(rough.unwrap_or_else(|| surface.reflectance(cosine)))
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
        self.facets.reflection(view, light, |cos_i| self.reflectance(cos_i))
    }

    #[inline(always)]
    fn split(&self, view: Vec3, u: Vec2, _: f32) -> LobeSplit {
        if !self.is_smooth() {
            return LobeSplit::opaque(self.facets.sample_reflection(view, u, |cos_i| self.reflectance(cos_i)));
        }
        let weight = self.reflectance(view.z.min(1.0));
        LobeSplit::opaque(Some(LobeSample::mirror(view, weight)))
    }
}
