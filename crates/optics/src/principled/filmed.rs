//! Thin films on the opaque lobes of a principled surface.

use glam::Vec3;

use super::Parameters;
use crate::thin_film::Film;

/// A film's base reflects at most this along the normal: all would need an infinite index.
const MOST_F0: f32 = 0.9999;

/// The specular lobe under a film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Filmed {
    film: Film,
    /// The part that the film covers.
    pub(super) part: f32,
    /// The weight of the dielectric in the lobe and in the layer over the diffuse base, and its index.
    dielectric: Vec3,
    layer: f32,
    ior: f32,
    /// The weight of the metal and its index.
    metal: f32,
    metal_ior: Vec3,
}

impl Filmed {
    #[inline(always)]
    pub(super) fn new(parameters: &Parameters, opaque: f32) -> Filmed {
        let weight = parameters.specular_color.min(Vec3::ONE) * parameters.specular;
        let root = |f0: f32| f0.min(MOST_F0).sqrt();
        let Vec3 { x, y, z } = parameters.base_color;
        let roots = Vec3::new(root(x), root(y), root(z));
        let infinite = (1.0 + root(1.0)) / (1.0 - root(1.0));
        Filmed {
            film: parameters.film,
            part: parameters.iridescence,
            dielectric: weight * opaque,
            layer: weight.max_element(),
            ior: if parameters.ior >= 1.0 { parameters.ior } else { infinite },
            metal: parameters.metallic,
            metal_ior: (Vec3::ONE + roots) / (Vec3::ONE - roots),
        }
    }

    #[inline(always)]
    fn over_dielectric(&self, cosine: f32) -> Vec3 {
        self.film.reflectance(cosine, 1.0, Vec3::splat(self.ior), Vec3::ZERO)
    }

    /// What facets reflect under the film, metal and dielectric by their weights.
    #[inline(always)]
    pub(super) fn fresnel(&self, cosine: f32) -> Vec3 {
        let mut color = Vec3::ZERO;
        if self.dielectric != Vec3::ZERO {
            color += self.over_dielectric(cosine) * self.dielectric;
        }
        if self.metal > 0.0 {
            color += self.film.reflectance(cosine, 1.0, self.metal_ior, Vec3::ZERO) * self.metal;
        }
        color
    }

    /// What the film and the dielectric under it take of the diffuse base's light.
    #[inline(always)]
    pub(super) fn layer(&self, cosine: f32) -> f32 {
        if self.dielectric == Vec3::ZERO { 0.0 } else { (self.over_dielectric(cosine) * self.layer).max_element() }
    }
}
