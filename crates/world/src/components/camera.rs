//! Where pictures are taken from.

use bevy_ecs::component::Component;

use super::{SceneKey, Transform};

/// A camera at its entity's origin that looks along -Z with +Y up (glTF's convention). Scale in the transform is ignored.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
#[require(Transform, SceneKey)]
#[component(summary_tick)]
pub struct Camera {
    /// How directions become pixels.
    pub projection: Projection,
    /// The lens, or none for a pinhole.
    pub lens: Option<Lens>,
}

/// How directions become pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Lines through one point.
    Perspective {
        /// The full vertical angle of view, radians, between 0 and π.
        vfov: f32,
    },
    /// Parallel lines.
    Orthographic {
        /// The height of the picture in meters, above zero.
        height: f32,
    },
}

/// A thin lens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lens {
    /// Radius of the aperture in meters, zero or more.
    pub aperture_radius: f32,
    /// Distance along the view axis that is sharp, in meters, above zero.
    pub focus_distance: f32,
    /// Blades of the aperture, a regular polygon with a corner at the top: 3 or more, or 0 for a round one.
    pub blades: u32,
}
