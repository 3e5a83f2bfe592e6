//! The queues between stages. Each is a type of its own, named by what happened to the ray: filling or reading the wrong
//! one does not compile.
//!
//! | queue | filled by | drained by | bytes a row |
//! | --- | --- | --- | --- |
//! | [`PrimaryQueue`] | `generate` | `trace`, depth 0 | 52 |
//! | [`ReflectionQueue`] | `shade_metal`, `shade_dielectric` | `trace`, one depth on | 52 |
//! | [`TransmissionQueue`] | `shade_dielectric`; `cross` at the same depth | `trace`, one depth on | 52 |
//! | [`HitQueue`], one a material kind | `sort` | `shade_*`, after `record` has read it at depth 0 | 60 |
//! | [`CrossingQueue`] | `sort` | `cross` | 20 |
//! | [`EscapedQueue`] | `sort` | `escape` | 28 |
//! | [`ShadowQueue`] | `shade_*` | `shadow` | 48 |
//! | [`ContributionQueue`] | `escape`, `shade_*`, `shadow` | `gather` | 16 |
//!
//! A batch owns one of each and reuses their memory. A ray in flight takes one row of one queue between bounces, and during
//! a bounce a row of what it became: that is why none exceeds 64 bytes, one cache line.

mod contributions;
mod escaped;
mod hits;
mod levels;
mod primary;
mod rays;
mod reflection;
mod shadow;
mod transmission;

pub use contributions::{
    Contribution, ContributionColumns, ContributionQueue, ContributionsView, ContributionsViewMut,
};
pub use escaped::{Escaped, EscapedColumns, EscapedQueue, EscapedView, EscapedViewMut};
pub use hits::{
    Crossing, CrossingColumns, CrossingQueue, CrossingsView, CrossingsViewMut, DielectricHits, EmissiveHits, HitQueue,
    HitsOf, LambertHits, MetalHits, OnDielectric, OnEmissive, OnLambert, OnMetal, OnPhong, PhongHits, SurfaceHit,
    SurfaceHitColumns, SurfaceHitsView, SurfaceHitsViewMut,
};
pub use levels::{DepthQueues, Levels};
pub use primary::PrimaryQueue;
pub use rays::{PathRay, PathRayColumns, PathRaysView, PathRaysViewMut, RayQueue, RaySource};
pub use reflection::ReflectionQueue;
pub use shadow::{ShadowQueue, ShadowRay, ShadowRayColumns, ShadowRaysView, ShadowRaysViewMut};
pub use transmission::TransmissionQueue;
