//! Columns and lanes: what every stage of Brewster is written in.
//!
//! - [`columns!`] turns one declaration into a row, an owner of columns, a shared view and an exclusive view.
//! - [`Level`] names the instruction set that a kernel runs on, and [`dispatch!`] compiles one body for each level.
//! - [`prefetch`] asks for memory before it is needed.
//! - [`math`] has the transcendental functions in plain arithmetic: the same bits on every platform.
//!
//! ```
//! use brewster_lanes::{Level, columns, dispatch};
//!
//! columns! {
//!     /// A light sample.
//!     pub struct Sample => SampleColumns, SampleView, SampleViewMut {
//!         /// Radiance in nit.
//!         pub radiance: f32,
//!         /// Index of the pixel.
//!         pub pixel: u32,
//!     }
//! }
//!
//! dispatch! {
//!     /// Halves every value.
//!     pub fn halve(values: &mut [f32]) {
//!         for value in values {
//!             *value *= 0.5;
//!         }
//!     }
//! }
//!
//! let mut samples = SampleColumns::new();
//! samples.push(Sample { radiance: 3.0, pixel: 7 });
//! halve(Level::detect(), samples.view_mut().radiance);
//! assert_eq!(samples.get(0).radiance, 1.5);
//! ```

mod columns;
mod dispatch;
pub mod math;
mod prefetch;

pub use columns::extend_marked;
pub use dispatch::Level;
pub use prefetch::prefetch;
