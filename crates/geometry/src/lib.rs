//! Where a ray meets the scene: shapes, trees and traversal kernels.
//!
//! - [`SceneGeometry`] is the scene as traversal sees it: placed shapes, borrowed as columns. A [`MeshTree`] stands under every
//!   mesh, a [`TopTree`] over all instances.
//! - [`closest_hits`] and [`occluded`] send [`Rays`] through it; [`Hit`]s are ordered, so that every tree and every kernel
//!   finds the same ones, to the bit.
//!   [`RayByRay`] sends one at a time.
//! - [`surface()`] says what was hit, and [`offset_origin`] where the next ray starts.
//!
//! ```
//! use brewster_geometry::*;
//! use brewster_lanes::Level;
//! use glam::Vec3;
//!
//! // A ball of radius 1, three meters up.
//! let table = ShapeTable { spheres: vec![Sphere { radius: 1.0 }], ..Default::default() };
//! let shapes = [ShapeRef { kind: ShapeKind::Sphere, row: 0 }];
//! let object_to_world = [Affine::translation(Vec3::new(0.0, 3.0, 0.0))];
//! let world_to_object = [object_to_world[0].inverse()?];
//! let instances = Instances {
//!     world_to_object: &world_to_object,
//!     motions: Motions::NONE,
//!     shapes: &shapes,
//!     table: &table,
//!     mesh_trees: &[],
//! };
//! let (top, planes) = (TopTree::build(&instances, TreeBuilder::default())?, instances.planes());
//! let scene = SceneGeometry {
//!     object_to_world: &object_to_world,
//!     world_to_object: &world_to_object,
//!     motions: Motions::NONE,
//!     shapes: &shapes,
//!     table: &table,
//!     mesh_trees: &[],
//!     top: &top,
//!     planes: &planes,
//!     obvhs: None,
//! };
//!
//! // One ray, from the ground straight up.
//! let ray = Ray { origin: Vec3::ZERO, direction: Vec3::Y, time: 0.0 };
//! let rays = Rays { origin: [&[0.0], &[0.0], &[0.0]], direction: [&[0.0], &[1.0], &[0.0]], time: &[] };
//! let mut hits = HitColumns::new();
//! hits.resize(1, Hit::miss());
//! closest_hits(&scene, Level::detect(), rays, hits.view_mut());
//! let hit = hits.get(0);
//! assert_eq!((hit.t, hit.instance), (2.0, 0));
//! assert_eq!(surface(&scene, &ray, &hit).geometric_normal, Vec3::NEG_Y);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod aabb;
mod attributes;
mod block;
mod chord;
mod cone;
mod cuboid;
mod cylinder;
mod disk;
mod hit;
mod mesh;
mod motion;
mod plane;
mod quad;
mod ray;
mod sampling;
mod scene;
mod shape;
mod sights;
mod sphere;
mod surface;
mod surfaces;
mod torus;
mod transform;
mod traverse;
mod tree;
mod triangle;

pub use aabb::Aabb;
pub use attributes::{SurfacePlace, UvSet};
pub use cone::Cone;
pub use cuboid::Cuboid;
pub use cylinder::Cylinder;
pub use disk::Disk;
pub use hit::{Hit, HitColumns, HitsView, HitsViewMut, MISS};
pub use mesh::{MOST_TRIANGLES, MeshError, TriangleMesh};
pub use motion::{Motion, Motions, Place};
pub use plane::Plane;
pub use quad::Quad;
pub use ray::{Ray, Rays};
pub use sampling::{AreaSample, Face, Spread, area_scale, seen_from};
pub use scene::SceneGeometry;
pub use shape::{Analytic, Crossing, LocalHit, LocalSurface, ShapeError, ShapeKind, ShapeRef, ShapeTable};
pub use sights::{Sight, Sights, per_solid_angle, sight};
pub use sphere::Sphere;
pub use surface::{SurfacePoint, meets_front, offset_origin, surface};
pub use surfaces::surfaces;
pub use torus::Torus;
pub use transform::{Affine, TransformError};
pub use traverse::{
    Kernel, ObvhsTrees, RayByRay, RayMemory, Visits, closest_hits, closest_hits_by, occluded, occluded_by, visits,
    visits_until_blocked,
};
pub use tree::{Instances, MeshTree, TopTree, TreeBuilder, TreeError};
pub use triangle::intersect_triangle;
