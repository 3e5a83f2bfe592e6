//! Diagrams of curves, as SVG for documents and as PNG for looking at.
//!
//! A [`Diagram`] is a list of lines, areas and words on a page; [`Chart`] draws curves over an angle with their legend into one, a
//! [`Frame`] any two axes. Both files show the same page: the SVG names its font and leaves it to the viewer, the PNG has Noto Sans in
//! it. Inside a page of HTML a diagram takes the colors of the page's theme.

mod chart;
mod frame;
mod raster;
mod svg;

pub(crate) use chart::{Chart, Curve, Marker};
pub(crate) use frame::{Axis, Frame, INK};
pub(crate) use svg::escaped;

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
    Area { points: Vec<[f32; 2]>, ink: Ink },
    Dot { at: [f32; 2], radius: f32, ink: Ink },
    Word { text: String, at: [f32; 2], size: f32, anchor: Anchor, ink: Ink },
}

/// A white page with lines, areas and words on it, drawn in the order in which they were added.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Diagram {
    size: [u32; 2],
    marks: Vec<Mark>,
}

impl Diagram {
    /// An empty page.
    pub(crate) fn new(size: [u32; 2]) -> Diagram {
        Diagram { size, marks: Vec::new() }
    }

    /// Draws a line through points.
    pub(crate) fn line(&mut self, points: Vec<[f32; 2]>, pen: Pen) {
        self.marks.push(Mark::Line { points, pen });
    }

    /// Fills the area that points enclose.
    pub(crate) fn area(&mut self, points: Vec<[f32; 2]>, ink: Ink) {
        self.marks.push(Mark::Area { points, ink });
    }

    /// Fills a rectangle between two corners.
    pub(crate) fn block(&mut self, [left, top]: [f32; 2], [right, bottom]: [f32; 2], ink: Ink) {
        self.area(vec![[left, top], [right, top], [right, bottom], [left, bottom]], ink);
    }

    /// Fills a disk.
    pub(crate) fn dot(&mut self, at: [f32; 2], radius: f32, ink: Ink) {
        self.marks.push(Mark::Dot { at, radius, ink });
    }

    /// Writes a word.
    pub(crate) fn word(&mut self, text: impl Into<String>, at: [f32; 2], size: f32, anchor: Anchor, ink: Ink) {
        self.marks.push(Mark::Word { text: text.into(), at, size, anchor, ink });
    }
}
