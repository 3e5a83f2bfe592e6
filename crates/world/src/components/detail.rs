//! What an entity's surface has that is finer than its shape.

use bevy_ecs::component::Component;
use brewster_buffers::Texture;

use super::Scalar;

/// Stands beside the [`Material`](super::Material) of an entity, whoever wears that: a map of normals, heights, and where the surface
/// is.
#[derive(Component, Clone, Debug, Default, PartialEq)]
#[component(summary_tick)]
pub struct Detail {
    /// The map of its normals.
    pub normal: Option<NormalMap>,
    /// Heights along the normal in meters, for shading alone. A number without a texture changes nothing.
    pub bump: Option<Scalar>,
    /// Where the surface is.
    pub opacity: Opacity,
    /// Whether cameras see its front alone, the side that its normal points to, and through its back. Light meets both sides.
    pub front_only: bool,
}

/// Normals in the frame of tangent, bitangent and normal, as glTF has them: components from -1 to 1 are red, green and blue from 0
/// to 1; green is up in the picture.
#[derive(Clone, Debug, PartialEq)]
pub struct NormalMap {
    /// The picture, one of [data](brewster_buffers::Encoding::Linear).
    pub texture: Texture,
    /// Factor of the components along tangent and bitangent.
    pub scale: f32,
}

/// Where a surface is. Rays that do not meet it go straight on, which is no interaction; those toward lights, too.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Opacity {
    /// Everywhere.
    #[default]
    Opaque,
    /// Where a number reaches a limit.
    Mask {
        /// The number.
        alpha: Scalar,
        /// The limit.
        cutoff: f32,
    },
    /// As a veil: this part of all rays meets it.
    Blend {
        /// The part; what lies outside 0..1 counts as the nearer of both.
        alpha: Scalar,
    },
}
