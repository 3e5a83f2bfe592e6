//! Scattering by principled materials.

use brewster_buffers::{self as buffers, SeenPlace, TextureId};
use brewster_optics::basis::Basis;
use brewster_optics::lobe::{LobeSample, LobeSplit, LobeValue};
use brewster_optics::microfacet::Ggx;
use brewster_optics::principled::{Interface, Parameters, Principled};
use brewster_optics::thin_film::Film;
use glam::{Vec2, Vec3};

use super::{Scatter, Sides, Surface};
use crate::albedo::Albedos;
use crate::context::Context;
use crate::media::Medium;
use crate::queues::{OnPrincipled, SurfaceHit};

impl Scatter for OnPrincipled {
    type Surface = Principled;

    const TRANSMITS: bool = true;

    #[inline(always)]
    fn medium(context: &Context<'_>, row: usize) -> Option<Medium> {
        let medium = context.scene.materials.principled.view().medium[row];
        (medium != buffers::Principled::NO_MEDIUM).then_some(Medium(medium))
    }

    #[inline(always)]
    fn surface(context: &Context<'_>, hit: &SurfaceHit, sides: &Sides) -> Principled {
        let (scene, place) = (context.scene, &context.seen(hit.place()));
        let material = scene.materials.principled.get(hit.material as usize);
        let color = |source| scene.color(source, place);
        let part = |source| scene.number(source, place).clamp(0.0, 1.0);
        let alpha = |source| {
            let roughness = part(source);
            roughness * roughness
        };
        // Both are often channels of one texture.
        let metallic = part(material.metallic);
        let (facets, direction) = facets(context, (hit, place), sides.normal, &material, alpha(material.roughness));
        let (iridescence, thickness) = if material.iridescence.is_zero() {
            (0.0, 0.0)
        } else {
            let [thinnest, thickest] = material.iridescence_thickness;
            let place = part(material.iridescence_thickness_source);
            (part(material.iridescence), thinnest + (thickest - thinnest) * place)
        };
        Principled::new(&Parameters {
            base_color: color(material.base_color).min(Vec3::ONE),
            metallic,
            facets,
            direction,
            ior: material.ior,
            specular: part(material.specular),
            specular_color: color(material.specular_color),
            clearcoat: part(material.clearcoat),
            clearcoat_facets: Ggx::isotropic(alpha(material.clearcoat_roughness)),
            clearcoat_normal: clearcoat_normal(context, (hit, place), sides.normal, &material),
            sheen_color: color(material.sheen_color).min(Vec3::ONE),
            sheen_alpha: alpha(material.sheen_roughness),
            transmission: part(material.transmission),
            diffuse_transmission: part(material.diffuse_transmission),
            diffuse_transmission_color: color(material.diffuse_transmission_color).min(Vec3::ONE),
            interface: interface(context, material.medium, sides),
            compensated: material.compensated,
            iridescence,
            film: Film { ior: material.iridescence_ior, thickness },
        })
    }

    #[inline(always)]
    fn albedo(_: &Albedos, _: &Principled, _: &SurfaceHit, _: &Sides, _: f32) -> Option<Vec3> {
        None
    }
}

/// KHR_materials_anisotropy: along a direction facets are wider by `(1 - alpha) strength²`; the direction in the frame around
/// the normal.
#[inline(always)]
fn facets(
    context: &Context<'_>,
    (hit, place): (&SurfaceHit, &SeenPlace),
    normal: Vec3,
    material: &buffers::Principled,
    alpha: f32,
) -> (Ggx, Vec2) {
    if material.anisotropy == 0.0 {
        return (Ggx::isotropic(alpha), Vec2::X);
    }
    let (mut strength, mut direction) = (material.anisotropy, material.anisotropy_direction);
    if material.anisotropy_texture != TextureId::NONE {
        let texel = context.scene.texture(material.anisotropy_texture, place);
        direction = direction.rotate(2.0 * texel.truncate().truncate() - Vec2::ONE);
        strength *= texel.z;
    }
    let facets = Ggx::anisotropic(alpha + (1.0 - alpha) * strength * strength, alpha);
    let [tangent, bitangent] = context.scene.tangents(material.anisotropy_texture, place, hit.point.shading_normal);
    let (world, frame) = (tangent * direction.x + bitangent * direction.y, Basis::around(normal));
    let local = frame.to_local(world).truncate();
    let length = local.length();
    (facets, if length > 1e-6 { local / length } else { Vec2::X })
}

/// KHR_materials_clearcoat: the coat follows its own map of normals and no other; in the frame around the normal.
#[inline(always)]
fn clearcoat_normal(
    context: &Context<'_>,
    (hit, place): (&SurfaceHit, &SeenPlace),
    normal: Vec3,
    material: &buffers::Principled,
) -> Vec3 {
    if material.clearcoat.is_zero() {
        return Vec3::Z;
    }
    let scene = context.scene;
    let upright = context.geometry.vertex_normal(place).unwrap_or(hit.point.geometric_normal);
    let bent = match material.clearcoat_normal {
        TextureId::NONE => upright,
        map => scene.mapped(map, material.clearcoat_normal_scale, place, upright),
    };
    // The normal has been turned to the viewer's side.
    let side = 1f32.copysign(normal.dot(hit.point.shading_normal));
    Basis::around(normal).to_local(bent * side)
}

#[inline(always)]
fn interface(context: &Context<'_>, medium: u32, sides: &Sides) -> Interface {
    if medium == buffers::Principled::NO_MEDIUM {
        return Interface::Sheet;
    }
    let dielectrics = context.scene.materials.dielectric.view();
    let [eta_i, eta_t] = sides.filling.map(|medium| medium.ior_at(sides.wavelength, &dielectrics));
    Interface::Boundary { eta_i, eta_t, inside: sides.filling[0] == Medium(medium) }
}

impl Surface for Principled {
    #[inline(always)]
    fn is_smooth(&self) -> bool {
        Principled::is_smooth(self)
    }

    #[inline(always)]
    fn transmits(&self) -> bool {
        Principled::transmits(self)
    }

    #[inline(always)]
    fn straight(&self, view: Vec3) -> Vec3 {
        Principled::straight(self, view)
    }

    #[inline(always)]
    fn estimate(&self, view: Vec3, choice: f32, u: Vec2) -> Option<Vec3> {
        let singular = Principled::singular(self, view);
        Some(if Principled::is_smooth(self) {
            singular
        } else {
            singular + Principled::estimate(self, view, choice, u)
        })
    }

    #[inline(always)]
    fn is_guided(&self) -> bool {
        Principled::is_diffuse(self)
    }

    #[inline(always)]
    fn evaluate(&self, view: Vec3, light: Vec3) -> LobeValue {
        Principled::evaluate(self, view, light)
    }

    #[inline(always)]
    fn split(&self, view: Vec3, u: Vec2, lobe: f32) -> LobeSplit {
        Principled::split(self, view, u, lobe)
    }

    #[inline(always)]
    fn choose(&self, view: Vec3, u: Vec2, lobe: f32) -> Option<LobeSample> {
        Principled::choose(self, view, u, lobe)
    }
}
