//! Scattering by Lambert materials.

use brewster_optics::lobe::{LobeSample, LobeSplit, LobeValue};
use brewster_optics::{lambert, warp};
use glam::{Vec2, Vec3};

use super::{Scatter, Sides, Surface};
use crate::albedo::Albedos;
use crate::context::Context;
use crate::queues::{OnLambert, SurfaceHit};

/// An ideal diffuse surface.
#[derive(Clone, Copy, Debug)]
pub struct Lambertian {
    albedo: Vec3,
}

impl Scatter for OnLambert {
    type Surface = Lambertian;

    const TRANSMITS: bool = false;

    #[inline(always)]
    fn surface(context: &Context<'_>, hit: &SurfaceHit, _: &Sides) -> Lambertian {
        let scene = context.scene;
        let albedo = scene.materials.lambert.view().albedo[hit.material as usize];
        Lambertian { albedo: scene.color(albedo, &context.seen(hit.place())) }
    }

    #[inline(always)]
    fn albedo(_: &Albedos, surface: &Lambertian, _: &SurfaceHit, _: &Sides, _: f32) -> Option<Vec3> {
        Some(surface.albedo)
    }
}

impl Surface for Lambertian {
    #[inline(always)]
    fn is_smooth(&self) -> bool {
        false
    }

    #[inline(always)]
    fn transmits(&self) -> bool {
        false
    }

    #[inline(always)]
    fn is_guided(&self) -> bool {
        true
    }

    #[inline(always)]
    fn evaluate(&self, view: Vec3, light: Vec3) -> LobeValue {
        if view.z <= 0.0 || light.z <= 0.0 {
            return LobeValue::BLACK;
        }
        let pdf = warp::cosine_hemisphere_pdf(light);
        LobeValue { f_cos: lambert::brdf(self.albedo) * light.z, pdf, ..LobeValue::BLACK }
    }

    #[inline(always)]
    fn split(&self, _: Vec3, u: Vec2, _: f32) -> LobeSplit {
        let direction = warp::cosine_hemisphere(u);
        let pdf = warp::cosine_hemisphere_pdf(direction);
        LobeSplit::opaque((pdf > 0.0).then_some(LobeSample {
            direction,
            weight: self.albedo,
            pdf,
            radiance_scale: 1.0,
        }))
    }
}
