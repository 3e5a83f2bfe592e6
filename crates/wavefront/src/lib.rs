//! Columns to samples, one bounce at a time.
//!
//! A [`Renderer`] takes a scene's columns ([`brewster_buffers::SceneBuffers`]) and adds samples to a
//! [`brewster_film::Film`]. Its workers take tiles of pixels; the rays of a tile are a [`batch`] that advances one bounce at a
//! time through the [`stages`], from queue to queue ([`queues`]), as the [`integrator`] says.
//!
//! ```
//! use brewster_buffers::{Background, Camera, Projection, SceneBuffers};
//! use brewster_film::{Film, PixelOrder};
//! use brewster_wavefront::{Control, Policy, Renderer};
//! use glam::{UVec2, Vec3};
//!
//! let mut scene = SceneBuffers::default();
//! scene.background = Background::Constant(Vec3::new(0.25, 0.5, 1.0));
//! scene.settings.resolution = UVec2::new(4, 2);
//! scene.cameras.push(Camera {
//!     name: String::new(),
//!     position: Vec3::ZERO,
//!     right: Vec3::X,
//!     up: Vec3::Y,
//!     forward: Vec3::NEG_Z,
//!     projection: Projection::Perspective(1.0),
//!     aperture_radius: 0.0,
//!     focus_distance: 1.0,
//!     blades: 0,
//!     key: 0,
//!     motion: Vec::new(),
//! });
//!
//! let mut film = Film::new(PixelOrder::new(4, 2, None)?);
//! let mut renderer = Renderer::new(&scene, 0, 1, Policy::default(), false)?;
//! assert!(renderer.pass(0..16, &mut film, &Control::default()));
//! assert_eq!(film.resolve().pixels.get(7).color, [0.25, 0.5, 1.0]);
//! assert_eq!(renderer.stats().total().escaped, 4 * 2 * 16);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod adaptive;
pub mod albedo;
pub mod arithmetic;
pub mod attribution;
pub mod batch;
pub mod context;
pub mod explain;
pub mod guide;
pub mod integrator;
pub mod ledger;
pub mod media;
pub mod models;
mod pattern;
mod policy;
pub mod queues;
pub mod random;
mod render;
pub mod stages;
pub mod stats;
pub mod survey;
pub mod tape;
pub mod traffic;

pub use policy::{Compaction, Executor, Policy, QueueOrder, SortKey};
pub use render::{Control, Renderer, Unsupported};
pub use stats::{Counts, Span, Stage, Stats};
