//! Hits, sorted by the kind of material: one queue a kind.

use std::marker::PhantomData;
use std::slice::from_ref;

use brewster_geometry::{SurfacePlace, SurfacePoint};
use brewster_lanes::columns;
use glam::Vec3;

use crate::media::{MediaId, Medium};

columns! {
    /// What is kept of every hit: all but its time.
    pub struct SurfaceHitRow => SurfaceHitColumns, SurfaceHitRowsView, SurfaceHitRowsViewMut {
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

/// A ray's hit on a material, with the point of the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceHit {
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
    /// When it was hit, 0 ≤ time < 1 of the shutter's time. Kept where something moves, otherwise 0.
    pub time: f32,
}

columns! {
    /// A ray's scattering by a medium. Before hits are sorted it is a [miss](brewster_geometry::Hit::is_miss) with the distance, and the
    /// medium's row of the dielectrics in the place of the primitive.
    pub struct Scattering => ScatteringColumns, ScatteringsView, ScatteringsViewMut {
        /// The ray's row among those traced.
        pub ray: u32,
        /// The medium.
        pub medium: Medium,
        /// Where.
        pub position: Vec3,
    }
}

/// Rays that media scatter.
pub type ScatteringQueue = ScatteringColumns;

impl SurfaceHit {
    /// Where textures are looked up.
    #[inline(always)]
    pub fn place(&self) -> SurfacePlace {
        self.point.place(self.instance, self.primitive, self.time)
    }
}

/// A shared view of hits.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceHitsView<'a> {
    rows: SurfaceHitRowsView<'a>,
    times: &'a [f32],
}

impl<'a> SurfaceHitsView<'a> {
    /// A hit as columns of one row.
    #[inline(always)]
    pub(crate) fn of(hit: &'a SurfaceHit) -> SurfaceHitsView<'a> {
        let SurfaceHit { ray, instance, primitive, material, point, time } = hit;
        let rows = SurfaceHitRowsView {
            ray: from_ref(ray),
            instance: from_ref(instance),
            primitive: from_ref(primitive),
            material: from_ref(material),
            point: from_ref(point),
        };
        SurfaceHitsView { rows, times: from_ref(time) }
    }

    /// At most `length` hits from row `start` on.
    #[inline(always)]
    pub fn run(&self, start: usize, length: usize) -> SurfaceHitsView<'a> {
        let run = start..self.len().min(start + length);
        let times = if self.times.is_empty() { self.times } else { &self.times[run.clone()] };
        SurfaceHitsView { rows: self.rows.slice(run), times }
    }

    /// The number of hits.
    #[inline(always)]
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Whether there are none.
    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// The rows of the rays among those traced.
    #[inline(always)]
    pub fn rays(&self) -> &'a [u32] {
        self.rows.ray
    }

    /// The rows of the materials among those of the kind.
    #[inline(always)]
    pub fn materials(&self) -> &'a [u32] {
        self.rows.material
    }

    /// The points of the surfaces; and when they were hit, if something moves.
    #[inline(always)]
    pub fn points(&self) -> (&'a [SurfacePoint], &'a [f32]) {
        (self.rows.point, self.times)
    }

    /// One hit; panics beyond the end.
    #[inline(always)]
    pub fn get(&self, row: usize) -> SurfaceHit {
        let SurfaceHitRow { ray, instance, primitive, material, point } = self.rows.get(row);
        let time = self.times.get(row).copied().unwrap_or(0.0);
        SurfaceHit { ray, instance, primitive, material, point, time }
    }
}

/// Passages through boundaries that are none.
pub type CrossingQueue = CrossingColumns;

/// Hits on materials of one kind. `Kind` makes each queue a type of its own.
#[derive(Debug)]
pub struct HitQueue<Kind> {
    hits: SurfaceHitColumns,
    /// When they were, if something moves.
    times: Vec<f32>,
    moves: bool,
    kind: PhantomData<Kind>,
}

impl<Kind> Default for HitQueue<Kind> {
    fn default() -> Self {
        HitQueue { hits: SurfaceHitColumns::new(), times: Vec::new(), moves: false, kind: PhantomData }
    }
}

impl<Kind> HitQueue<Kind> {
    /// Adds a hit.
    #[inline]
    pub fn push(&mut self, hit: SurfaceHit) {
        let SurfaceHit { ray, instance, primitive, material, point, time } = hit;
        self.hits.push(SurfaceHitRow { ray, instance, primitive, material, point });
        if self.moves {
            self.times.push(time);
        }
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

    /// Drops all hits; keeps the memory. Says whether the next ones have to know when they were.
    pub fn clear(&mut self, moves: bool) {
        self.hits.clear();
        self.times.clear();
        self.moves = moves;
    }

    /// The hits, with their kind.
    pub fn view(&self) -> HitsOf<'_, Kind> {
        HitsOf { hits: SurfaceHitsView { rows: self.hits.view(), times: &self.times }, kind: PhantomData }
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
        HitsOf { hits: self.hits.run(start, length), kind: PhantomData }
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
