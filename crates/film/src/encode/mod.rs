//! Pictures to files: PNG for looking at, EXR for everything that the film knows, HDR for radiance alone.
//!
//! Every writer replaces its file as a whole ([`crate::write_atomically`]), gives the same bytes for the same picture, and
//! names the file in its errors.

mod exr;
mod hdr;
mod png;

use std::{fmt::Display, path::Path};

pub use self::{
    exr::write_exr,
    hdr::write_hdr,
    png::{PngAlpha, PngDepth, PngSettings, write_png},
};
use crate::{FilmError, Layers};

/// A file format that pictures are written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Display values with 8 or 16 bits.
    Png,
    /// Every layer, in full precision.
    Exr,
    /// Radiance with 8 bits of precision and a shared exponent.
    Hdr,
}

impl Format {
    /// The format that a file's name tells: `.png`, `.exr` or `.hdr`, in upper or lower case.
    ///
    /// # Errors
    ///
    /// The name ends otherwise.
    pub fn of(path: &Path) -> Result<Format, FilmError> {
        let extension = path.extension().and_then(|extension| extension.to_str()).unwrap_or_default();
        match extension.to_ascii_lowercase().as_str() {
            "png" => Ok(Format::Png),
            "exr" => Ok(Format::Exr),
            "hdr" => Ok(Format::Hdr),
            _ => Err(FilmError::Format { path: path.to_path_buf() }),
        }
    }
}

/// What a file says of its origin.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Metadata {
    /// A hash of the scene.
    pub scene_hash: String,
    /// The settings of the render.
    pub settings: String,
    /// The program and its version.
    pub version: String,
}

/// Writes a picture in the format that the file's name tells: a PNG as `png` says, an EXR with `metadata`.
///
/// # Errors
///
/// The name tells no format, or the file can't be written.
pub fn write_picture(path: &Path, layers: &Layers, png: &PngSettings, metadata: &Metadata) -> Result<(), FilmError> {
    match Format::of(path)? {
        Format::Png => write_png(path, &layers.image(), png),
        Format::Exr => write_exr(path, layers, metadata),
        Format::Hdr => write_hdr(path, &layers.image()),
    }
}

/// What a codec said, with the file that it spoke of.
pub(crate) fn codec_error(path: &Path, error: impl Display) -> FilmError {
    FilmError::Codec { path: path.to_path_buf(), message: error.to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_tell_formats() {
        for (name, expected) in [("a.png", Format::Png), ("b/c.EXR", Format::Exr), (".d.Hdr", Format::Hdr)] {
            assert_eq!(Format::of(Path::new(name)).unwrap(), expected, "{name}");
        }
        for name in ["", "a", "png", "a.jpg", "a.png.txt"] {
            let message = Format::of(Path::new(name)).unwrap_err().to_string();
            assert_eq!(message, format!("{name}: expected a name that ends in .png, .exr or .hdr"));
        }
    }
}
