//! Scattering by rough diffuse materials.

use brewster_optics::lobe::{LobeSplit, LobeValue};
use brewster_optics::rough_diffuse::RoughDiffuse;
use glam::{Vec2, Vec3};

use super::{Scatter, Sides, Surface};
use crate::albedo::Albedos;
use crate::context::Context;
use crate::queues::{OnRoughDiffuse, SurfaceHit};

impl Scatter for OnRoughDiffuse {
    type Surface = RoughDiffuse;

    const TRANSMITS: bool = false;

    #[inline(always)]
    fn surface(context: &Context<'_>, hit: &SurfaceHit, _: &Sides) -> RoughDiffuse {
        let scene = context.scene;
        let material = scene.materials.rough_diffuse.get(hit.material as usize);
        RoughDiffuse { albedo: scene.color(material.albedo, &context.seen(hit.place())), roughness: material.roughness }
    }

    #[inline(always)]
    fn albedo(_: &Albedos, surface: &RoughDiffuse, _: &SurfaceHit, _: &Sides, cosine: f32) -> Option<Vec3> {
        Some(surface.directional_albedo(cosine))
    }
}

impl Surface for RoughDiffuse {
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
        RoughDiffuse::evaluate(self, view, light)
    }

    #[inline(always)]
    fn split(&self, view: Vec3, u: Vec2, _: f32) -> LobeSplit {
        LobeSplit::opaque(RoughDiffuse::sample(self, view, u))
    }
}
