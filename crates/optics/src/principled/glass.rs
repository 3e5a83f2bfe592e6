//! What a principled surface lets through as glass does: a boundary of a volume, or a sheet.

use glam::{Vec2, Vec3};

use crate::fresnel::{FresnelModel, f0_dielectric};
use crate::lobe::{LobeSample, LobeSplit, LobeValue, mean};
use crate::microfacet::RoughDielectric;
use crate::refraction;
use crate::thin_film::Film;

/// What lies behind a surface that lets light through.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Interface {
    /// The same medium as in front: the surface is a sheet, which light passes straight on.
    Sheet,
    /// Another medium, at whose boundary light is refracted.
    Boundary {
        /// The index on the viewer's side.
        eta_i: f32,
        /// The index beyond.
        eta_t: f32,
        /// Whether the viewer is inside of what the surface is the surface of.
        inside: bool,
    },
}

/// Glass with a color and with glTF's say over its reflection. Of smooth facets all directions are singular.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Glass {
    /// Of a sheet the indices tell the Fresnel value only.
    pub(super) boundary: RoughDielectric,
    pub(super) is_sheet: bool,
    /// Its part of the surface.
    pub(super) weight: f32,
    /// What is left of light that crosses.
    pub(super) tint: Vec3,
    /// The weight of the reflection, and its color along the normal.
    pub(super) specular: f32,
    pub(super) specular_color: Vec3,
    /// A film and the part that it covers.
    pub(super) film: Option<(Film, f32)>,
}

impl Glass {
    /// Whether all of its directions are singular.
    #[inline(always)]
    pub(super) fn is_smooth(&self) -> bool {
        self.boundary.facets.is_smooth() || (!self.is_sheet && self.boundary.is_matched())
    }

    /// The part that a facet reflects: by the Fresnel equations, the range from the normal to the horizon stretched to where
    /// KHR_materials_specular has its ends.
    #[inline(always)]
    pub(super) fn reflectance(&self, cos_i: f32) -> Vec3 {
        let RoughDielectric { eta_i, eta_t, .. } = self.boundary;
        let exact = FresnelModel::Exact.dielectric(cos_i, eta_i, eta_t).reflectance;
        let mut color = Vec3::splat(exact);
        if self.specular != 1.0 || self.specular_color != Vec3::ONE {
            let f0 = f0_dielectric(eta_i, eta_t);
            let f0_given = (self.specular_color * f0).min(Vec3::ONE);
            let tail = (exact - f0) / (1.0 - f0).max(f32::MIN_POSITIVE);
            color = (f0_given + (Vec3::ONE - f0_given) * tail.clamp(0.0, 1.0)) * self.specular;
        }
        if let Some((film, part)) = self.film {
            let filmed = film.reflectance(cos_i, eta_i, Vec3::splat(eta_t), Vec3::ZERO);
            color += (filmed * self.specular - color) * part;
        }
        color
    }

    /// About what it sends on of the light from a direction.
    #[inline(always)]
    pub(super) fn sent(&self, view: Vec3) -> f32 {
        let reflected = self.reflectance(view.z.min(1.0));
        self.weight * mean(reflected + (Vec3::ONE - reflected) * self.tint)
    }

    /// f |cosθ| and its density; black where facets are smooth.
    #[inline(always)]
    pub(super) fn evaluate(&self, view: Vec3, light: Vec3) -> LobeValue {
        if self.is_smooth() {
            return LobeValue::BLACK;
        }
        let value = if self.is_sheet {
            self.evaluate_sheet(view, light)
        } else {
            self.boundary.evaluate(view, light, |cos_i| self.reflectance(cos_i))
        };
        let tint = if light.z > 0.0 { Vec3::ONE } else { self.tint };
        LobeValue { f_cos: value.f_cos * tint * self.weight, ..value }
    }

    /// KHR_materials_transmission: what passes a sheet is the mirror image of what it would reflect.
    #[inline(always)]
    fn evaluate_sheet(&self, view: Vec3, light: Vec3) -> LobeValue {
        let mirrored = light.with_z(light.z.abs());
        let value = self.boundary.facets.reflection(view, mirrored, |_| Vec3::ONE);
        let half = view + mirrored;
        let color = self.reflectance((view.dot(half) / half.length().max(f32::MIN_POSITIVE)).clamp(0.0, 1.0));
        let (color, choice) = if light.z > 0.0 { (color, mean(color)) } else { (Vec3::ONE - color, 1.0 - mean(color)) };
        LobeValue { f_cos: value.f_cos * color, choice, ..value }
    }

    /// Both ways on. Of rough facets only the directions count, and with which probability one is reflected.
    #[inline(always)]
    pub(super) fn split(&self, view: Vec3, u: Vec2) -> LobeSplit {
        if self.is_smooth() {
            return self.split_smooth(view);
        }
        if !self.is_sheet {
            return self.boundary.split(view, u, |cos_i| self.reflectance(cos_i));
        }
        let Some(reflection) = self.boundary.facets.sample_reflection(view, u, |_| Vec3::ONE) else {
            return LobeSplit::opaque(None);
        };
        let mirrored = reflection.direction;
        let half = view + mirrored;
        let color = self.reflectance((view.dot(half) / half.length().max(f32::MIN_POSITIVE)).clamp(0.0, 1.0));
        let transmission = LobeSample { direction: mirrored.with_z(-mirrored.z), ..reflection };
        LobeSplit { reflection: Some(reflection), transmission: Some(transmission), reflectance: mean(color) }
    }

    /// About where rough facets send what they let through, and how wide; none where they are smooth, or where a plane would reflect
    /// all.
    #[inline]
    pub(super) fn bundle_through(&self, view: Vec3) -> Option<(Vec3, f32)> {
        if self.is_smooth() {
            return None;
        }
        let RoughDielectric { facets, eta_i, eta_t } = self.boundary;
        let [x, y] = facets.alphas();
        if self.is_sheet {
            return Some((-view, 2.0 * x.max(y)));
        }
        let cos_t = refraction::cos_t(view.z.min(1.0), eta_i, eta_t)?;
        let ratio = eta_i / eta_t;
        // A facet tilted by t turns what passes it by this times t, and what it reflects by 2t.
        let turn = (1.0 - ratio * view.z / cos_t.max(0.1)).abs().min(2.0);
        Some((refraction::refract_with_cosine(-view, Vec3::Z, cos_t, ratio), turn * x.max(y)))
    }

    #[inline(always)]
    fn split_smooth(&self, view: Vec3) -> LobeSplit {
        let RoughDielectric { eta_i, eta_t, .. } = self.boundary;
        let cos_i = view.z.min(1.0);
        let weight = Vec3::splat(self.weight);
        if !self.is_sheet && self.boundary.is_matched() {
            let straight = LobeSample::straight(view, weight * self.tint);
            return LobeSplit { reflection: None, transmission: Some(straight), reflectance: 0.0 };
        }
        let cos_t = if self.is_sheet { Some(cos_i) } else { refraction::cos_t(cos_i, eta_i, eta_t) };
        let Some(cos_t) = cos_t else { return LobeSplit::opaque(Some(LobeSample::mirror(view, weight))) };
        let reflected = self.reflectance(cos_i);
        let through = (Vec3::ONE - reflected) * self.tint * weight;
        let transmission = match self.is_sheet {
            true => LobeSample::straight(view, through),
            false => LobeSample::refracted(view, cos_t, [eta_i, eta_t], through),
        };
        LobeSplit {
            reflection: Some(LobeSample::mirror(view, reflected * weight)),
            transmission: Some(transmission),
            reflectance: mean(reflected),
        }
    }
}
