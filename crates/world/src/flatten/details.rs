//! Details: a row for each material that has one, in the materials' order. Their textures follow those of all materials.

use brewster_buffers as buffers;
use brewster_buffers::{ScalarSource, TextureId};

use super::textures::{self, TextureWriter};
use crate::components::{Detail, Opacity, Scalar};

/// What the column holds for a detail, whose textures become the next rows.
pub(super) fn row(textures: &mut TextureWriter<'_>, detail: &Detail) -> buffers::Detail {
    let (normal, normal_scale) = match &detail.normal {
        Some(map) => (textures.row(Some(&map.texture)), map.scale),
        None => (TextureId::NONE, 1.0),
    };
    buffers::Detail {
        normal,
        normal_scale,
        bump: detail.bump.as_ref().map_or(ScalarSource::constant(0.0), |height| textures.scalar(height)),
        opacity: match &detail.opacity {
            Opacity::Opaque => buffers::Opacity::Opaque,
            Opacity::Mask { alpha, cutoff } => {
                buffers::Opacity::Mask { alpha: textures.scalar(alpha), cutoff: *cutoff }
            }
            Opacity::Blend { alpha } => buffers::Opacity::Blend { alpha: textures.scalar(alpha) },
        },
        front_only: detail.front_only,
    }
}

/// Checks the numbers and textures of a detail; the error says what must hold.
pub(super) fn check(detail: &Detail) -> Result<(), &'static str> {
    let scalar = |scalar: &Scalar| {
        scalar.texture.as_ref().map_or(Ok(()), |(texture, _)| textures::check(texture))?;
        if scalar.factor.is_finite() { Ok(()) } else { Err("a height and an opacity must be finite") }
    };
    if let Some(map) = &detail.normal {
        textures::check(&map.texture)?;
        if !map.scale.is_finite() {
            return Err("the scale of a normal map must be finite");
        }
    }
    detail.bump.as_ref().map_or(Ok(()), scalar)?;
    match &detail.opacity {
        Opacity::Opaque => Ok(()),
        Opacity::Mask { cutoff, .. } if !cutoff.is_finite() => Err("the cutoff of a mask must be finite"),
        Opacity::Mask { alpha, .. } | Opacity::Blend { alpha } => scalar(alpha),
    }
}
