//! A place where textures are looked up, with what many of them ask of it.

use std::cell::Cell;
use std::ops::Deref;

use brewster_geometry::{SurfacePlace, UvSet};
use glam::{Vec3, Vec4};

use super::image::{Lie, Spot};
use crate::{SceneBuffers, TextureId};

/// A place of a surface, where any number of textures are looked up: how their coordinates run over the surface is found once, and
/// only if one of them asks; of textures that lie alike, asked one after the other, the pixels around it are found once; a texture of which
/// several channels are asked one after the other is looked up once. Belongs to one hit and one thread.
#[derive(Clone, Debug)]
pub struct SeenPlace {
    place: SurfacePlace,
    /// Of the first coordinates.
    gradients: Cell<Option<[Vec3; 2]>>,
    /// How the texture lies that was looked up last from afar, and at which pixels.
    pub(super) spot: Cell<Option<(Lie, Spot)>>,
    /// The texture that was looked up last, and what was found.
    pub(super) last: Cell<(TextureId, Vec4)>,
}

impl From<SurfacePlace> for SeenPlace {
    #[inline(always)]
    fn from(place: SurfacePlace) -> SeenPlace {
        let last = Cell::new((TextureId::NONE, Vec4::ZERO));
        SeenPlace { place, gradients: Cell::new(None), spot: Cell::new(None), last }
    }
}

impl Deref for SeenPlace {
    type Target = SurfacePlace;

    #[inline(always)]
    fn deref(&self) -> &SurfacePlace {
        &self.place
    }
}

impl SceneBuffers {
    /// How much the coordinates of a set grow a meter along the surface, and where to.
    #[inline]
    pub(crate) fn uv_gradients(&self, place: &SeenPlace, set: UvSet) -> [Vec3; 2] {
        if let (UvSet::First, Some(found)) = (set, place.gradients.get()) {
            return found;
        }
        let found = self.geometry().uv_gradients(place, set);
        if set == UvSet::First {
            place.gradients.set(Some(found));
        }
        found
    }
}
