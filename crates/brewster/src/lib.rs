//! The Rust API and the command line.
//!
//! A [`Session`] takes a scene from its file to pictures; a [`Render`] adds samples to one picture, pass by pass. The commands
//! use nothing else.
//!
//! ```
//! use brewster::wavefront::Control;
//! use brewster::{RenderOptions, Session, SessionOptions};
//!
//! let scene = r#"Scene(
//!     settings: (resolution: (32, 18), samples: 4),
//!     camera: Perspective(eye: (0, 1, 5), target: (0, 1, 0)),
//!     background: (0.25, 0.5, 1.0),
//!     entities: [
//!         (shape: Sphere(radius: 1), material: Metal(of: "gold"), at: (0, 1, 0)),
//!         (light: Point(intensity: 40), at: (3, 5, 4)),
//!     ],
//! )"#;
//!
//! let mut session = Session::new("ball.ron", SessionOptions::default());
//! session.load_text(scene)?;
//! session.flatten()?;
//!
//! let mut render = session.render(RenderOptions::default())?;
//! let control = Control::default();
//! while render.remaining() > 0 && !control.stopped() {
//!     render.pass(&control);
//! }
//! let image = render.film().resolve().image();
//! assert_eq!(image.color[0], [0.25, 0.5, 1.0]);
//! assert_eq!(render.stats().of_source(brewster::wavefront::queues::RaySource::Primary).traced(), 32 * 18 * 4);
//! # Ok::<(), brewster::SessionError>(())
//! ```
//!
//! The crates of the data's way, from file to file: [`import`], [`world`], [`buffers`], [`wavefront`], [`film`]; below them
//! [`optics`], [`geometry`] and [`lanes`].

pub mod explain;
mod origin;
mod pace;
mod render;
mod session;
mod stats;
pub mod tape;
mod timeline;

pub use brewster_buffers as buffers;
pub use brewster_film as film;
pub use brewster_geometry as geometry;
pub use brewster_import as import;
pub use brewster_lanes as lanes;
pub use brewster_optics as optics;
pub use brewster_wavefront as wavefront;
pub use brewster_world as world;

pub use origin::NamedOrigin;
pub use render::{Render, RenderOptions, SampleCounts};
pub use session::{Session, SessionError, SessionOptions, SettingsChoices};
pub use stats::{STATS_VERSION, StatsFile, peak_memory, processor_seconds, tree_time};
pub use timeline::{SessionSpan, Timeline};

/// The program and its version, as files name it.
pub const PROGRAM: &str = concat!("brewster ", env!("CARGO_PKG_VERSION"));
