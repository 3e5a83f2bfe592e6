//! Diagrams of curves, as SVG for documents and as PNG for looking at.
//!
//! A [`Diagram`] is a list of lines and words on a page; [`Chart`] draws axes, curves and their legend into one. Both files show
//! the same page: the SVG names its font and leaves it to the viewer, the PNG has Noto Sans in it.

mod chart;
mod raster;
mod svg;

pub(crate) use chart::{Chart, Curve, Marker};

/// An opaque color in sRGB.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Ink(pub u8, pub u8, pub u8);

/// How a line is drawn; lengths are in units of the page.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pen {
    /// Its color.
    pub ink: Ink,
    /// Its width.
    pub width: f32,
    /// Lengths drawn and left out in turn; empty for a whole line.
    pub dash: &'static [f32],
}

/// Which point of a word stands at its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Anchor {
    /// Its left end.
    Start,
    /// Its middle.
    Middle,
    /// Its right end.
    End,
}

/// Something on a page; y grows downward.
#[derive(Clone, Debug, PartialEq)]
enum Mark {
    Line { points: Vec<[f32; 2]>, pen: Pen },
    Word { text: String, at: [f32; 2], size: f32, anchor: Anchor, ink: Ink },
}

/// A white page with lines and words on it, drawn in the order in which they were added.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Diagram {
    size: [u32; 2],
    marks: Vec<Mark>,
}

impl Diagram {
    /// An empty page.
    fn new(size: [u32; 2]) -> Diagram {
        Diagram { size, marks: Vec::new() }
    }

    fn line(&mut self, points: Vec<[f32; 2]>, pen: Pen) {
        self.marks.push(Mark::Line { points, pen });
    }

    fn word(&mut self, text: impl Into<String>, at: [f32; 2], size: f32, anchor: Anchor, ink: Ink) {
        self.marks.push(Mark::Word { text: text.into(), at, size, anchor, ink });
    }
}
