//! Scattering by boundaries of dielectrics, smooth, rough and thin.

use brewster_optics::fresnel::FresnelModel;
use brewster_optics::lobe::{LobeSample, LobeSplit, LobeValue};
use brewster_optics::microfacet::{Ggx, RoughDielectric};
use glam::{Vec2, Vec3};

use super::{Scatter, Sides, Surface};
use crate::albedo::Albedos;
use crate::context::Context;
use crate::queues::{OnDielectric, SurfaceHit};

/// A boundary between two media, or a sheet with one medium on both sides.
#[derive(Clone, Copy, Debug)]
pub struct Boundary {
    fresnel: FresnelModel,
    glass: RoughDielectric,
    thin: bool,
}

impl Boundary {
    /// The part that a facet reflects.
    #[inline(always)]
    fn reflectance(&self, cos_i: f32) -> Vec3 {
        Vec3::splat(self.fresnel.dielectric(cos_i, self.glass.eta_i, self.glass.eta_t).reflectance)
    }
}

impl Scatter for OnDielectric {
    type Surface = Boundary;

    const TRANSMITS: bool = true;

    #[inline(always)]
    fn surface(context: &Context<'_>, hit: &SurfaceHit, sides: &Sides) -> Boundary {
        let dielectrics = context.scene.materials.dielectric.view();
        let row = hit.material as usize;
        let thin = dielectrics.thin[row];
        let [eta_i, eta_t] = sides.filling.map(|medium| medium.ior(&dielectrics));
        let eta_t = if thin { dielectrics.ior[row] } else { eta_t };
        let glass = RoughDielectric { facets: Ggx::isotropic(dielectrics.alpha[row]), eta_i, eta_t };
        Boundary { fresnel: dielectrics.fresnel[row], glass, thin }
    }

    #[inline(always)]
    fn albedo(albedos: &Albedos, surface: &Boundary, hit: &SurfaceHit, sides: &Sides, cosine: f32) -> Vec3 {
        let rough = if surface.is_smooth() || surface.glass.is_matched() {
            None
        } else {
            albedos.dielectric(hit.material, sides.filling, cosine)
        };
        rough.unwrap_or(Vec3::ONE)
    }
}

impl Surface for Boundary {
    #[inline(always)]
    fn is_smooth(&self) -> bool {
        self.thin || self.glass.facets.is_smooth()
    }

    #[inline(always)]
    fn evaluate(&self, view: Vec3, light: Vec3) -> LobeValue {
        self.glass.evaluate(view, light, |cos_i| self.reflectance(cos_i))
    }

    #[inline(always)]
    fn sample(&self, view: Vec3, u: Vec2, _: f32) -> LobeSplit {
        if !self.is_smooth() {
            return self.glass.split(view, u, |cos_i| self.reflectance(cos_i));
        }
        let cos_i = view.z.min(1.0);
        if self.thin {
            // Between two surfaces of reflectance r light goes to and fro: r + (1-r)² r (1 + r² + r⁴ + …) = 2r/(1+r).
            let once = self.reflectance(cos_i);
            let reflectance = 2.0 * once / (1.0 + once);
            return LobeSplit {
                reflection: Some(LobeSample::mirror(view, reflectance)),
                transmission: Some(LobeSample::straight(view, 1.0 - reflectance)),
                reflectance: reflectance.x,
            };
        }
        let split = self.fresnel.dielectric(cos_i, self.glass.eta_i, self.glass.eta_t);
        LobeSplit {
            reflection: Some(LobeSample::mirror(view, Vec3::splat(split.reflectance))),
            transmission: (!split.is_total()).then(|| {
                LobeSample::refracted(
                    view,
                    split.cos_t,
                    [self.glass.eta_i, self.glass.eta_t],
                    Vec3::splat(1.0 - split.reflectance),
                )
            }),
            reflectance: split.reflectance,
        }
    }
}
