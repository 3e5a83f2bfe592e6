//! Samples to pixels to files.
//!
//! - [`Film`] holds integer sums per pixel; [`FilmTile`] is a thread's exclusive part of it, to which contributions are
//!   added in any order with the same bits as the result.
//! - [`Layers`] is what the sums mean: color, alpha, depth, normals, ids and counts.
//! - [`LinearImage`] is a picture in linear light, to be tone-mapped, written, read back and compared.

mod aov;
mod error;
mod film;
mod filter;
mod image;
mod merge;
mod order;
mod tonemap;

pub use aov::{Layers, LayersColumns, LayersRow, LayersView, LayersViewMut};
pub use error::FilmError;
pub use film::{DEPTH_SCALE, Film, FilmTile, FirstHit, NO_ID, Pixel, PixelColumns, PixelView, PixelViewMut, SCALE};
pub use filter::{Filter, FilterSampler};
pub use image::LinearImage;
pub use order::{MAX_PIXELS, MAX_SIDE, PixelOrder, TILE, Window};
pub use tonemap::{Display, ToneMap, srgb_decode, srgb_encode};
