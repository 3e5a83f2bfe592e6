//! Scattering by coats over diffuse surfaces and metals.

use brewster_buffers::MaterialKind;
use brewster_optics::layered::{Coat, CoatedDiffuse, CoatedMetal};
use brewster_optics::lobe::{LobeSplit, LobeValue};
use brewster_optics::microfacet::Ggx;
use glam::{Vec2, Vec3};

use super::metal::Conductor;
use super::{Scatter, Sides, Surface};
use crate::albedo::Albedos;
use crate::context::Context;
use crate::queues::{OnCoated, SurfaceHit};

/// A coat and what lies below.
#[derive(Clone, Copy, Debug)]
pub struct Coating {
    coat: Coat,
    over: Over,
}

#[derive(Clone, Copy, Debug)]
enum Over {
    Diffuse(CoatedDiffuse),
    Metal(CoatedMetal, Conductor),
}

impl Scatter for OnCoated {
    type Surface = Coating;

    const TRANSMITS: bool = false;

    #[inline(always)]
    fn surface(context: &Context<'_>, hit: &SurfaceHit, sides: &Sides) -> Coating {
        let (scene, materials) = (context.scene, &context.scene.materials);
        let material = materials.coated.get(hit.material as usize);
        let eta_i = sides.filling[0].ior_at(sides.wavelength, &materials.dielectric.view());
        let coat = Coat::new(Ggx::isotropic(material.alpha), material.ior / eta_i).absorbing(material.depth);
        let row = material.base_row as usize;
        let over = if material.base == MaterialKind::Metal {
            let conductor = Conductor::new(context, row, hit, material.ior);
            Over::Metal(CoatedMetal::new(coat, conductor.facets()), conductor)
        } else {
            let albedo = scene.color(materials.lambert.view().albedo[row], &context.seen(hit.place()));
            Over::Diffuse(CoatedDiffuse::new(coat, albedo.min(Vec3::ONE)))
        };
        Coating { coat, over }
    }

    #[inline(always)]
    fn albedo(albedos: &Albedos, surface: &Coating, hit: &SurfaceHit, sides: &Sides, cosine: f32) -> Option<Vec3> {
        let Over::Diffuse(coated) = &surface.over else { return None };
        let view = Vec3::new((1.0 - cosine * cosine).max(0.0).sqrt(), 0.0, cosine);
        surface.coat.is_clear().then(|| match albedos.coat(hit.material, sides.filling[0], cosine) {
            Some((highlight, share)) => Vec3::splat(highlight) + coated.base() * share,
            None => coated.directional_albedo(view),
        })
    }
}

impl Surface for Coating {
    #[inline(always)]
    fn is_smooth(&self) -> bool {
        matches!(&self.over, Over::Metal(coated, _) if coated.is_smooth())
    }

    #[inline(always)]
    fn transmits(&self) -> bool {
        false
    }

    #[inline(always)]
    fn estimate(&self, view: Vec3, choice: f32, u: Vec2) -> Option<Vec3> {
        let (singular, bundles) = match &self.over {
            Over::Diffuse(coated) => (coated.singular(view), coated.bundles(view)),
            Over::Metal(coated, metal) => {
                (coated.singular(view, |cos_t| metal.reflectance(cos_t)), coated.bundles(view))
            }
        };
        Some(singular + bundles.estimate(choice, u, |light| self.evaluate(view, light).f_cos))
    }

    #[inline(always)]
    fn evaluate(&self, view: Vec3, light: Vec3) -> LobeValue {
        match &self.over {
            Over::Diffuse(coated) => coated.evaluate(view, light),
            Over::Metal(coated, metal) => coated.evaluate(view, light, |cos_t| metal.reflectance(cos_t)),
        }
    }

    #[inline(always)]
    fn split(&self, view: Vec3, u: Vec2, lobe: f32) -> LobeSplit {
        LobeSplit::opaque(match &self.over {
            Over::Diffuse(coated) => coated.sample(view, u, lobe),
            Over::Metal(coated, metal) => coated.sample(view, u, lobe, |cos_t| metal.reflectance(cos_t)),
        })
    }
}
