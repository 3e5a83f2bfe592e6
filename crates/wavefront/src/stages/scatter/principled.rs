//! Scattering by principled materials.

use brewster_optics::lobe::{LobeSplit, LobeValue};
use brewster_optics::microfacet::Ggx;
use brewster_optics::principled::{Parameters, Principled};
use glam::{Vec2, Vec3};

use super::{Scatter, Sides, Surface};
use crate::albedo::Albedos;
use crate::context::Context;
use crate::queues::{OnPrincipled, SurfaceHit};

impl Scatter for OnPrincipled {
    type Surface = Principled;

    const TRANSMITS: bool = false;

    #[inline(always)]
    fn surface(context: &Context<'_>, hit: &SurfaceHit, _: &Sides) -> Principled {
        let (scene, materials) = (context.scene, context.scene.materials.principled.view());
        let (row, place) = (hit.material as usize, &hit.place());
        Principled::new(&Parameters {
            base_color: scene.color(materials.base_color[row], place).min(Vec3::ONE),
            metallic: scene.number(materials.metallic[row], place),
            facets: Ggx::from_roughness(scene.number(materials.roughness[row], place)),
            ior: materials.ior[row],
            specular: scene.number(materials.specular[row], place),
            specular_color: scene.color(materials.specular_color[row], place),
            clearcoat: scene.number(materials.clearcoat[row], place),
            clearcoat_facets: Ggx::from_roughness(scene.number(materials.clearcoat_roughness[row], place)),
            sheen_color: scene.color(materials.sheen_color[row], place).min(Vec3::ONE),
            sheen_alpha: Ggx::from_roughness(scene.number(materials.sheen_roughness[row], place)).mean_alpha(),
        })
    }

    #[inline(always)]
    fn albedo(_: &Albedos, surface: &Principled, _: &SurfaceHit, _: &Sides, cosine: f32) -> Vec3 {
        surface.albedo(Vec3::new((1.0 - cosine * cosine).max(0.0).sqrt(), 0.0, cosine))
    }
}

impl Surface for Principled {
    #[inline(always)]
    fn is_smooth(&self) -> bool {
        false
    }

    #[inline(always)]
    fn evaluate(&self, view: Vec3, light: Vec3) -> LobeValue {
        Principled::evaluate(self, view, light)
    }

    #[inline(always)]
    fn sample(&self, view: Vec3, u: Vec2, lobe: f32) -> LobeSplit {
        LobeSplit::opaque(Principled::sample(self, view, u, lobe))
    }
}
