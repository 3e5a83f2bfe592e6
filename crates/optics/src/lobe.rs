//! What evaluating and sampling a scattering lobe give, and the frame in which they are given.
//!
//! Every lobe of this crate works in the local frame of [`Basis`](crate::basis::Basis), with +z along the shading normal
//! *flipped to the side that the path came from*, so that `view.z` is positive. `view` points from the surface back to
//! where the path came from, `light` from the surface to where it goes on; both are unit vectors. `eta_i` is the index on
//! the viewer's side, `eta_t` the one beyond, as in [`fresnel`](crate::fresnel). A lobe seen from below its own horizon
//! (a shading normal can do that) is black.
//!
//! Densities are per solid angle. A lobe without width has the density [`DELTA`], which turns a power heuristic's
//! weight `1/(1 + (other/pdf)²)` into 1 by itself. Random numbers lie in [0, 1).

use glam::Vec3;

use crate::refraction;

/// The density of a direction that only its own lobe can produce: mirrors, smooth glass.
pub const DELTA: f32 = f32::INFINITY;

/// A lobe's value for a pair of directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LobeValue {
    /// The scattering function times the cosine at the light's side, `f |cosθ|`, without [`radiance_scale`].
    ///
    /// [`radiance_scale`]: LobeValue::radiance_scale
    pub f_cos: Vec3,
    /// The density with which the sampler gives this direction, the choice between reflection and transmission left out.
    pub pdf: f32,
    /// The probability of that choice; 1 for a lobe that does not choose.
    pub choice: f32,
    /// What radiance is multiplied by beside: `(eta_i/eta_t)²` through a boundary, 1 in reflection. Energy is not.
    pub radiance_scale: f32,
}

/// A direction drawn from a lobe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LobeSample {
    /// Where the path goes on, of unit length; z < 0 is through the surface.
    pub direction: Vec3,
    /// `f |cosθ| / pdf`: the part of the energy that goes on, without [`radiance_scale`](LobeSample::radiance_scale).
    pub weight: Vec3,
    /// The density of the direction, every choice included, or [`DELTA`].
    pub pdf: f32,
    /// As [`LobeValue::radiance_scale`].
    pub radiance_scale: f32,
}

/// Both ways on from a surface. What is `None` is lost between facets, absorbed or totally reflected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LobeSplit {
    /// The path that is reflected, with the weight that it has when both go on.
    pub reflection: Option<LobeSample>,
    /// The path that is transmitted, likewise.
    pub transmission: Option<LobeSample>,
    /// The probability with which [`LobeSplit::choose`] reflects.
    pub reflectance: f32,
}

/// The weight of a technique that gives a direction with density `pdf`, where another gives it with density `other`: the
/// power heuristic with exponent 2 of E. Veach and L. Guibas, *Optimally Combining Sampling Techniques*, SIGGRAPH 1995.
/// 1 for a `pdf` of [`DELTA`].
#[inline(always)]
pub fn power_heuristic(pdf: f32, other: f32) -> f32 {
    let ratio = other / pdf;
    1.0 / (1.0 + ratio * ratio)
}

impl LobeValue {
    /// No light from there.
    pub const BLACK: LobeValue = LobeValue { f_cos: Vec3::ZERO, pdf: 0.0, choice: 1.0, radiance_scale: 1.0 };

    /// The density of the direction where one of both is chosen; [`pdf`](LobeValue::pdf) is that of a split.
    #[inline(always)]
    pub fn chosen_pdf(self) -> f32 {
        self.choice * self.pdf
    }
}

impl LobeSample {
    /// The mirror image of the view.
    #[inline(always)]
    pub fn mirror(view: Vec3, weight: Vec3) -> LobeSample {
        LobeSample { direction: Vec3::new(-view.x, -view.y, view.z), weight, pdf: DELTA, radiance_scale: 1.0 }
    }

    /// Straight through a sheet, with the same medium on both sides.
    #[inline(always)]
    pub fn straight(view: Vec3, weight: Vec3) -> LobeSample {
        LobeSample { direction: -view, weight, pdf: DELTA, radiance_scale: 1.0 }
    }

    /// Through a smooth boundary; `cos_t` as of [`refraction::cos_t`].
    #[inline(always)]
    pub fn refracted(view: Vec3, cos_t: f32, [eta_i, eta_t]: [f32; 2], weight: Vec3) -> LobeSample {
        let ratio = eta_i / eta_t;
        let direction = refraction::refract_with_cosine(-view, Vec3::Z, cos_t, ratio);
        LobeSample { direction, weight, pdf: DELTA, radiance_scale: ratio * ratio }
    }

    /// Whether no other technique can produce this direction.
    #[inline(always)]
    pub fn is_delta(&self) -> bool {
        self.pdf == DELTA
    }

    /// Whether the direction leads through the surface.
    #[inline(always)]
    pub fn is_transmission(&self) -> bool {
        self.direction.z < 0.0
    }

    /// The same direction where it was taken with probability `choice` only.
    #[inline(always)]
    pub fn chosen_with(self, choice: f32) -> LobeSample {
        LobeSample { weight: self.weight / choice, pdf: self.pdf * choice, ..self }
    }
}

impl LobeSplit {
    /// A surface that only reflects.
    #[inline(always)]
    pub fn opaque(reflection: Option<LobeSample>) -> LobeSplit {
        LobeSplit { reflection, transmission: None, reflectance: 1.0 }
    }

    /// One of both ways: reflection where `u` lies below its probability.
    #[inline(always)]
    pub fn choose(self, u: f32) -> Option<LobeSample> {
        if u < self.reflectance {
            self.reflection.map(|sample| sample.chosen_with(self.reflectance))
        } else {
            self.transmission.map(|sample| sample.chosen_with(1.0 - self.reflectance))
        }
    }
}

/// The mean of a color's channels, what choices between lobes go by; exact for a gray.
#[inline(always)]
pub fn mean(color: Vec3) -> f32 {
    color.x + ((color.y - color.x) + (color.z - color.x)) * (1.0 / 3.0)
}
