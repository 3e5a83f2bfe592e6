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
        let (materials, textures) = (context.scene.materials.principled.view(), &context.scene.textures);
        let (row, uv) = (hit.material as usize, hit.point.uv);
        Principled::new(&Parameters {
            base_color: textures.evaluate(materials.base_color[row], uv).min(Vec3::ONE),
            metallic: textures.evaluate_scalar(materials.metallic[row], uv),
            facets: Ggx::from_roughness(textures.evaluate_scalar(materials.roughness[row], uv)),
            ior: materials.ior[row],
            specular: textures.evaluate_scalar(materials.specular[row], uv),
            specular_color: textures.evaluate(materials.specular_color[row], uv),
            clearcoat: textures.evaluate_scalar(materials.clearcoat[row], uv),
            clearcoat_facets: Ggx::from_roughness(textures.evaluate_scalar(materials.clearcoat_roughness[row], uv)),
            sheen_color: textures.evaluate(materials.sheen_color[row], uv).min(Vec3::ONE),
            sheen_alpha: Ggx::from_roughness(textures.evaluate_scalar(materials.sheen_roughness[row], uv)).mean_alpha(),
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
