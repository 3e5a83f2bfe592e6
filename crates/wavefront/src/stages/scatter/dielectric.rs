//! Scattering by boundaries of dielectrics, smooth, rough and thin.

use brewster_optics::dispersion::PathWavelength;
use brewster_optics::fresnel::FresnelModel;
use brewster_optics::lobe::{LobeSample, LobeSplit, LobeValue, mean};
use brewster_optics::microfacet::{Ggx, RoughDielectric};
use brewster_optics::refraction;
use brewster_optics::thin_film::Film;
use glam::{Vec2, Vec3};

use super::{Scatter, Sides, Surface};
use crate::albedo::Albedos;
use crate::context::Context;
use crate::explain::Fresnel;
use crate::media::Medium;
use crate::queues::{OnDielectric, SurfaceHit, SurfaceHitsView};

/// A boundary between two media, or a sheet with one medium on both sides.
#[derive(Clone, Copy, Debug)]
pub struct Boundary {
    fresnel: FresnelModel,
    film: Option<Film>,
    wavelength: PathWavelength,
    glass: RoughDielectric,
    thin: bool,
}

impl Boundary {
    /// The part that a facet reflects.
    #[inline(always)]
    fn reflectance(&self, cos_i: f32) -> Vec3 {
        let RoughDielectric { eta_i, eta_t, .. } = self.glass;
        match self.film {
            Some(film) => match self.wavelength.get() {
                Some(wavelength) => {
                    Vec3::splat(film.reflectance_at(wavelength.nanometers, cos_i, eta_i, eta_t, 0.0).unpolarized())
                }
                None => film.reflectance(cos_i, eta_i, Vec3::splat(eta_t), Vec3::ZERO),
            },
            None => Vec3::splat(self.fresnel.dielectric(cos_i, eta_i, eta_t).reflectance),
        }
    }
}

impl Boundary {
    /// The part that a smooth boundary reflects. Between the faces of a sheet light goes to and fro: r + (1-r)² r (1 + r² + r⁴ + …) = 2r/(1+r).
    #[inline(always)]
    fn reflected(&self, cos_i: f32) -> Vec3 {
        let once = self.reflectance(cos_i);
        if self.thin { 2.0 * once / (1.0 + once) } else { once }
    }

    /// What is to be told of the boundary, as if it were smooth.
    pub(crate) fn fresnel_at(&self, cos_i: f32) -> Fresnel {
        Fresnel::of_boundary(self.fresnel, self.glass, cos_i, self.reflected(cos_i))
    }
}

impl Scatter for OnDielectric {
    type Surface = Boundary;

    const TRANSMITS: bool = true;

    #[inline(always)]
    fn asks_lights(context: &Context<'_>, hits: SurfaceHitsView<'_>) -> bool {
        let alpha = context.scene.materials.dielectric.view().alpha;
        hits.materials().iter().any(|&row| alpha[row as usize] > 0.0)
    }

    #[inline(always)]
    fn medium(context: &Context<'_>, row: usize) -> Option<Medium> {
        (!context.scene.materials.dielectric.view().thin[row]).then_some(Medium(row as u32))
    }

    #[inline(always)]
    fn surface(context: &Context<'_>, hit: &SurfaceHit, sides: &Sides) -> Boundary {
        let dielectrics = context.scene.materials.dielectric.view();
        let row = hit.material as usize;
        let thin = dielectrics.thin[row];
        let [eta_i, eta_t] = sides.filling.map(|medium| medium.ior_at(sides.wavelength, &dielectrics));
        let eta_t = if thin { dielectrics.ior[row] } else { eta_t };
        let glass = RoughDielectric { facets: Ggx::isotropic(dielectrics.alpha[row]), eta_i, eta_t };
        Boundary {
            fresnel: dielectrics.fresnel[row],
            film: dielectrics.film[row],
            wavelength: sides.wavelength,
            glass,
            thin,
        }
    }

    #[inline(always)]
    fn albedo(albedos: &Albedos, surface: &Boundary, hit: &SurfaceHit, sides: &Sides, cosine: f32) -> Option<Vec3> {
        let rough = if surface.is_smooth() || surface.glass.is_matched() {
            None
        } else {
            albedos.dielectric(hit.material, sides.filling, cosine)
        };
        Some(rough.unwrap_or(Vec3::ONE))
    }
}

impl Surface for Boundary {
    #[inline(always)]
    fn is_smooth(&self) -> bool {
        // Facets between equal indices bend nothing: a film there is a smooth mirror.
        self.thin || self.glass.facets.is_smooth() || (self.film.is_some() && self.glass.is_matched())
    }

    #[inline(always)]
    fn transmits(&self) -> bool {
        true
    }

    #[inline(always)]
    fn straight(&self, view: Vec3) -> Vec3 {
        let through = self.split(view, Vec2::ZERO, 0.0).transmission.filter(|_| self.thin);
        through.map_or(Vec3::ZERO, |sample| sample.weight)
    }

    #[inline(always)]
    fn evaluate(&self, view: Vec3, light: Vec3) -> LobeValue {
        self.glass.evaluate(view, light, |cos_i| self.reflectance(cos_i))
    }

    #[inline(always)]
    fn split(&self, view: Vec3, u: Vec2, _: f32) -> LobeSplit {
        if !self.is_smooth() {
            return self.glass.split(view, u, |cos_i| self.reflectance(cos_i));
        }
        let RoughDielectric { eta_i, eta_t, .. } = self.glass;
        let cos_i = view.z.min(1.0);
        let cos_t = if self.thin { Some(cos_i) } else { refraction::cos_t(cos_i, eta_i, eta_t) };
        let Some(cos_t) = cos_t else { return LobeSplit::opaque(Some(LobeSample::mirror(view, Vec3::ONE))) };
        let reflectance = self.reflected(cos_i);
        let transmittance = 1.0 - reflectance;
        let transmission = match self.thin {
            true => LobeSample::straight(view, transmittance),
            false => LobeSample::refracted(view, cos_t, [eta_i, eta_t], transmittance),
        };
        LobeSplit {
            reflection: Some(LobeSample::mirror(view, reflectance)),
            transmission: (transmittance.max_element() > 0.0).then_some(transmission),
            reflectance: mean(reflectance),
        }
    }
}
