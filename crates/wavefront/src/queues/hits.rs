//! Hits, sorted by the kind of material: one queue a kind.

use std::marker::PhantomData;

use brewster_geometry::{SurfacePlace, SurfacePoint};
use brewster_lanes::columns;
use glam::Vec3;

use crate::media::MediaId;

columns! {
    /// A ray's hit on a material, with the point of the surface.
    pub struct SurfaceHit => SurfaceHitColumns, SurfaceHitsView, SurfaceHitsViewMut {
        /// The ray's row among those traced.
        pub ray: u32,
        /// The instance that was hit.
        pub instance: u32,
        /// The triangle or the face.
        pub primitive: u32,
        /// Row among the materials of the kind.
        pub material: u32,
        /// The surface there.
        pub point: SurfacePoint,
    }
}

columns! {
    /// A ray's passage through a boundary that is none, because a medium of higher priority fills the place.
    pub struct Crossing => CrossingColumns, CrossingsView, CrossingsViewMut {
        /// The ray's row among those traced.
        pub ray: u32,
        /// The media behind the boundary.
        pub media: MediaId,
        /// Where it goes on from.
        pub origin: Vec3,
    }
}

impl SurfaceHit {
    /// Where textures are looked up.
    #[inline(always)]
    pub fn place(&self) -> SurfacePlace {
        self.point.place(self.instance, self.primitive)
    }
}

/// Passages through boundaries that are none.
pub type CrossingQueue = CrossingColumns;

/// Hits on materials of one kind. `Kind` makes each queue a type of its own.
#[derive(Debug)]
pub struct HitQueue<Kind> {
    hits: SurfaceHitColumns,
    kind: PhantomData<Kind>,
}

impl<Kind> Default for HitQueue<Kind> {
    fn default() -> Self {
        HitQueue { hits: SurfaceHitColumns::new(), kind: PhantomData }
    }
}

impl<Kind> HitQueue<Kind> {
    /// Adds a hit.
    #[inline]
    pub fn push(&mut self, hit: SurfaceHit) {
        self.hits.push(hit);
    }

    /// The number of hits.
    pub fn len(&self) -> usize {
        self.hits.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.hits.is_empty()
    }

    /// Hits that fit without taking more memory.
    pub fn capacity(&self) -> usize {
        self.hits.capacity()
    }

    /// Drops all hits; keeps the memory.
    pub fn clear(&mut self) {
        self.hits.clear();
    }

    /// The hits, with their kind.
    pub fn view(&self) -> HitsOf<'_, Kind> {
        HitsOf { hits: self.hits.view(), kind: PhantomData }
    }
}

/// A shared view of a run of hits of one kind.
#[derive(Debug)]
pub struct HitsOf<'a, Kind> {
    hits: SurfaceHitsView<'a>,
    kind: PhantomData<Kind>,
}

impl<'a, Kind> HitsOf<'a, Kind> {
    /// The columns.
    pub fn columns(&self) -> SurfaceHitsView<'a> {
        self.hits
    }

    /// At most `length` hits from row `start` on.
    pub fn run(&self, start: usize, length: usize) -> HitsOf<'a, Kind> {
        let end = self.hits.len().min(start + length);
        HitsOf { hits: self.hits.slice(start..end), kind: PhantomData }
    }
}

macro_rules! kinds {
    ($($(#[$doc:meta])* $Kind:ident $Hits:ident;)*) => {$(
        $(#[$doc])*
        #[derive(Debug)]
        pub enum $Kind {}
        $(#[$doc])*
        pub type $Hits = HitQueue<$Kind>;
    )*};
}

kinds! {
    /// Hits on Phong materials.
    OnPhong PhongHits;
    /// Hits on Lambert materials.
    OnLambert LambertHits;
    /// Hits on rough diffuse materials.
    OnRoughDiffuse RoughDiffuseHits;
    /// Hits on metals.
    OnMetal MetalHits;
    /// Hits on boundaries of dielectrics.
    OnDielectric DielectricHits;
    /// Hits on surfaces that send out light.
    OnEmissive EmissiveHits;
    /// Hits on principled materials.
    OnPrincipled PrincipledHits;
    /// Hits on coated materials.
    OnCoated CoatedHits;
}
