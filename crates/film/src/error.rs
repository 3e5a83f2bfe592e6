//! What can go wrong with a film and its files; every error about a file names it.

use std::{io, path::PathBuf};

use crate::{MAX_PIXELS, MAX_SIDE, Window};

/// An error of this crate.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FilmError {
    /// A picture is empty or too large.
    #[error("a picture of {width}x{height} pixels: sides range from 1 to {MAX_SIDE}, with at most {MAX_PIXELS} pixels")]
    Size {
        /// Columns asked for.
        width: u32,
        /// Rows asked for.
        height: u32,
    },
    /// A crop window is empty or leaves its picture.
    #[error(
        "the crop window {},{},{},{} (x,y,width,height) is empty or leaves the picture of {width}x{height} pixels",
        window.x, window.y, window.width, window.height
    )]
    Crop {
        /// The window asked for.
        window: Window,
        /// The picture's width.
        width: u32,
        /// The picture's height.
        height: u32,
    },
    /// Two films or two pictures that belong together differ in size or window.
    #[error("the pictures do not match: {left} against {right}")]
    Mismatch {
        /// The shape of the first.
        left: String,
        /// The shape of the second.
        right: String,
    },
    /// A setting is out of range.
    #[error("{name} is {value}, expected {expected}")]
    Setting {
        /// What was set.
        name: &'static str,
        /// What it was set to.
        value: f32,
        /// What it may be.
        expected: &'static str,
    },
    /// A file's name does not tell a format that pictures are written in.
    #[error("{}: expected a name that ends in .png, .exr or .hdr", path.display())]
    Format {
        /// The file.
        path: PathBuf,
    },
    /// A file could not be opened, read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// A file's content is not a picture that can be read, or a picture could not be encoded.
    #[error("{}: {message}", path.display())]
    Codec {
        /// The file.
        path: PathBuf,
        /// What the codec said.
        message: String,
    },
}
