//! Samples to pixels to files. The film knows neither scenes nor rays.
//!
//! - [`Film`] holds integer sums per pixel; a [`FilmTile`] is one thread's part of it. [`Light`] in fixed point may be added in
//!   any order and films may be merged in any way: the bits are the same.
//! - [`PixelOrder`] says which pixel comes when; [`FilterSampler`] says where around its pixel a sample lies.
//! - [`Layers`] are what the sums mean: color, alpha, depth, normals, ids and counts; and what else a film was told to
//!   [`Keep`]: standard errors, albedo, and light by the way it came.
//! - [`LinearImage`] is a picture in linear light, which a [`Display`] shows, [`write_picture`] writes and [`read_image`]
//!   reads back.
//! - [`compare()`] and [`flip()`] say how much two pictures differ, in figures and to an observer.
//!
//! ```
//! use brewster_film::{Film, FilmError, Light, Metadata, PixelOrder, PngSettings, read_image, write_picture};
//!
//! # fn main() -> Result<(), FilmError> {
//! let mut film = Film::new(PixelOrder::new(2, 2, None)?);
//! for mut tile in film.tiles_mut(2) {
//!     // A worker's part: here two pixels, each of which gets two samples.
//!     for local in 0..tile.len() as u32 {
//!         let (x, y) = tile.pixel(local);
//!         for blue in [0.0, 1.0] {
//!             tile.add_sample(local, Light::new([x as f32, y as f32, blue]).expect("it is finite and not negative"));
//!         }
//!     }
//! }
//! let layers = film.resolve();
//! assert_eq!(layers.image().color, [[0.0, 0.0, 0.5], [1.0, 0.0, 0.5], [0.0, 1.0, 0.5], [1.0, 1.0, 0.5]]);
//!
//! # let folder = tempfile::tempdir().unwrap();
//! let path = folder.path().join("picture.png");
//! write_picture(&path, &layers, &PngSettings::default(), &Metadata::default())?;
//! assert_eq!(read_image(&path)?.width, 2);
//! # Ok(())
//! # }
//! ```

mod aov;
mod atomic;
mod compare;
mod decode;
mod denoise;
mod encode;
mod error;
mod film;
mod filter;
mod flip;
mod light;
mod linear_image;
mod merge;
mod noise;
mod order;
mod tonemap;

pub use aov::{
    Layers, LayersColumns, LayersRow, LayersView, LayersViewMut, LightLayers, LightLayersColumns, LightLayersView,
    LightLayersViewMut,
};
pub use atomic::write_atomically;
pub use compare::{Difference, compare, difference_map, map_picture};
pub use decode::read_image;
pub use encode::{Format, Metadata, PngAlpha, PngDepth, PngSettings, write_exr, write_hdr, write_picture, write_png};
pub use error::FilmError;
pub use film::{
    DEPTH_SCALE, Film, FilmTile, FirstHit, Keep, NO_ID, Part, Parts, PartsColumns, PartsView, PartsViewMut, Pixel,
    PixelColumns, PixelView, PixelViewMut, SCALE, SQUARE_SCALE, Squares, SquaresColumns, SquaresView, SquaresViewMut,
};
pub use filter::{Filter, FilterSampler};
pub use flip::{Flip, PIXELS_PER_DEGREE, flip};
pub use light::Light;
pub use linear_image::LinearImage;
pub use order::{MAX_PIXELS, MAX_SIDE, PixelOrder, TILE, Window};
pub use tonemap::{Display, ToneMap, srgb_decode, srgb_encode};
