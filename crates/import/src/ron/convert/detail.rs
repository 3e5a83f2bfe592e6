//! What materials have beside their own: normals, heights and opacity.

use brewster_world::components as world;

use super::texture::{data, map, number};
use crate::ron::schema::{Material, Opacity, Sides};
use crate::session::Session;

/// The detail of a material that has one.
pub(super) fn detail(session: &mut Session, material: &Material) -> Option<world::Detail> {
    let Material::Detailed { normal, normal_scale, bump, opacity, sides, .. } = material else { return None };
    Some(world::Detail {
        normal: match normal {
            Some(texture) => Some(world::NormalMap { texture: data(session, texture)?, scale: *normal_scale }),
            None => None,
        },
        bump: match bump {
            Some(height) => Some(map(session, height)?),
            None => None,
        },
        opacity: match opacity {
            Opacity::Opaque {} => world::Opacity::Opaque,
            Opacity::Mask { alpha, cutoff } => world::Opacity::Mask { alpha: number(session, alpha)?, cutoff: *cutoff },
            Opacity::Blend { alpha } => world::Opacity::Blend { alpha: number(session, alpha)? },
        },
        front_only: matches!(sides, Sides::Front {}),
    })
}
