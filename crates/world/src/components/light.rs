//! Lights without extent.

use bevy_ecs::component::Component;
use glam::Vec3;

use super::{SceneKey, Transform};

/// A light. Values are linear RGB, zero or more; place and direction come from the entity's transform.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
#[require(Transform, SceneKey)]
#[component(summary_tick)]
pub enum Light {
    /// Light from a point to all sides.
    Point {
        /// Radiant intensity in candela.
        intensity: Vec3,
        /// How it weakens with distance.
        falloff: Falloff,
    },
    /// Parallel light that travels along -Z of the entity.
    Directional {
        /// Irradiance on a facing plane in lux.
        irradiance: Vec3,
    },
    /// Light from a point into a cone around -Z of the entity.
    Spot {
        /// Radiant intensity on the axis in candela.
        intensity: Vec3,
        /// Half angle of the full-strength cone, radians, 0 to `outer_angle`.
        inner_angle: f32,
        /// Half angle beyond which it is dark, radians, above 0 and at most π/2. Between the two the square of a
        /// linear ramp in the cosine.
        outer_angle: f32,
        /// How it weakens with distance.
        falloff: Falloff,
    },
    /// The lecture's constant term: multiplies a Phong material's ambient reflectance.
    Ambient {
        /// Radiance in nit.
        radiance: Vec3,
    },
}

/// How a point's light weakens with distance.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Falloff {
    /// By the squared distance: physics.
    #[default]
    InverseSquare,
    /// By the squared distance and softly to nothing at a range in meters, above 0, as KHR_lights_punctual recommends.
    Within(f32),
    /// Not at all: the intensity counts as the irradiance everywhere.
    None,
}
