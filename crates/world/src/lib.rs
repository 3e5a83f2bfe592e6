//! The scene as entities, and the systems that flatten it.
//!
//! - A [`Scene`] owns a bevy_ecs world. What an author says stands in [`components`].
//! - [`Scene::flatten`] turns components into the columns of [`SceneBuffers`](brewster_buffers::SceneBuffers) and brings them up to
//!   date after edits, at the cost of the edits.
//! - A [`FlattenReport`] says what was written, what it cost, and what had to be left out.
//!
//! ```
//! use brewster_world::Scene;
//! use brewster_world::components::{Color, Falloff, Light, Material, Shape, Transform};
//! use glam::{Affine3A, Vec3};
//!
//! // A gray ball, and a lamp three meters above.
//! let mut scene = Scene::new();
//! let ball = scene.spawn((Shape::Sphere { radius: 1.0 }, Material::Lambert { albedo: Color::gray(0.5) })).id();
//! let lamp = Light::Point { intensity: Vec3::splat(40.0), falloff: Falloff::InverseSquare };
//! scene.spawn((lamp, Transform(Affine3A::from_translation(Vec3::new(0.0, 3.0, 0.0)))));
//!
//! let report = scene.flatten();
//! assert_eq!((report.instances.added, report.lights.added, report.invalid.len()), (1, 1, 0));
//! let buffers = scene.buffers();
//! assert_eq!(buffers.shapes.spheres[0].radius, 1.0);
//! assert_eq!(buffers.lights.get(0).position, Vec3::new(0.0, 3.0, 0.0));
//! let material = buffers.materials.rows.get(buffers.instances.get(0).material.0 as usize);
//! assert_eq!(buffers.materials.lambert.get(material.row as usize).albedo.factor, Vec3::splat(0.5));
//!
//! // An edit costs what it touched: one row here, and a refit of the tree.
//! scene.world_mut().get_mut::<Transform>(ball).unwrap().0.translation.x = 2.0;
//! let report = scene.flatten();
//! assert_eq!(report.rows_written(), 1);
//! assert_eq!(scene.buffers().instances.get(0).object_to_world.point(Vec3::ZERO), Vec3::new(2.0, 0.0, 0.0));
//! ```

pub mod components;
mod flatten;
mod scene;
mod systems;

pub use flatten::{EmittersEdit, FlattenReport, Invalid, MeshTreeEdits, Problem, RowEdits, TopTreeEdit};
pub use scene::Scene;
