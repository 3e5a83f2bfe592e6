//! A page as a picture.

use brewster::film::{LinearImage, srgb_decode};
use tiny_skia::{Color, FillRule, LineCap, LineJoin, Paint, Path, PathBuilder, Pixmap, Stroke, StrokeDash, Transform};
use ttf_parser::{Face, OutlineBuilder};

use super::{Anchor, Diagram, Ink, Mark};

impl Diagram {
    /// The page with `scale` pixels in a unit.
    pub(crate) fn image(&self, scale: u8) -> LinearImage {
        let [width, height] = self.size.map(|side| side * u32::from(scale.max(1)));
        let font = Face::parse(notosans::REGULAR_TTF, 0).expect("the font that is built in is whole");
        let mut pixels = Pixmap::new(width, height).expect("a page is not empty");
        pixels.fill(Color::WHITE);
        let transform = Transform::from_scale(f32::from(scale), f32::from(scale));
        for mark in &self.marks {
            match mark {
                Mark::Line { points, pen } => {
                    if let Some(path) = polyline(points) {
                        let stroke = Stroke {
                            width: pen.width,
                            line_cap: if pen.dash.is_empty() { LineCap::Round } else { LineCap::Butt },
                            line_join: LineJoin::Round,
                            dash: StrokeDash::new(pen.dash.to_vec(), 0.0),
                            ..Stroke::default()
                        };
                        pixels.stroke_path(&path, &paint(pen.ink), &stroke, transform, None);
                    }
                }
                Mark::Area { points, ink } => {
                    if let Some(path) = polyline(points) {
                        pixels.fill_path(&path, &paint(*ink), FillRule::Winding, transform, None);
                    }
                }
                Mark::Dot { at: [x, y], radius, ink } => {
                    if let Some(path) = PathBuilder::from_circle(*x, *y, *radius) {
                        pixels.fill_path(&path, &paint(*ink), FillRule::Winding, transform, None);
                    }
                }
                Mark::Word { text, at, size, anchor, ink } => {
                    if let Some(path) = outline(&font, text, *at, *size, *anchor) {
                        pixels.fill_path(&path, &paint(*ink), FillRule::Winding, transform, None);
                    }
                }
            }
        }
        let mut image = LinearImage::black(width, height);
        for (color, pixel) in image.color.iter_mut().zip(pixels.pixels()) {
            *color = [pixel.red(), pixel.green(), pixel.blue()].map(|value| srgb_decode(f32::from(value) / 255.0));
        }
        image
    }
}

fn paint(Ink(red, green, blue): Ink) -> Paint<'static> {
    let mut paint = Paint::default();
    paint.set_color_rgba8(red, green, blue, 255);
    paint
}

fn polyline(points: &[[f32; 2]]) -> Option<Path> {
    let mut path = PathBuilder::new();
    let ([x, y], rest) = points.split_first()?;
    path.move_to(*x, *y);
    for [x, y] in rest {
        path.line_to(*x, *y);
    }
    path.finish()
}

/// The outlines of a word's letters, side by side without kerning; a letter that the font lacks shows as its empty box.
fn outline(font: &Face<'_>, text: &str, at: [f32; 2], size: f32, anchor: Anchor) -> Option<Path> {
    let scale = size / f32::from(font.units_per_em());
    let glyphs: Vec<_> = text.chars().map(|letter| font.glyph_index(letter).unwrap_or_default()).collect();
    let advance = |glyph| f32::from(font.glyph_hor_advance(glyph).unwrap_or_default()) * scale;
    let width: f32 = glyphs.iter().copied().map(advance).sum();
    let x = match anchor {
        Anchor::Start => at[0],
        Anchor::Middle => at[0] - 0.5 * width,
        Anchor::End => at[0] - width,
    };
    let mut pen = GlyphPen { path: PathBuilder::new(), x, y: at[1], scale };
    for glyph in glyphs {
        font.outline_glyph(glyph, &mut pen);
        pen.x += advance(glyph);
    }
    pen.path.finish()
}

/// Takes a glyph's outline, in font units with y upward, to its place on the page.
struct GlyphPen {
    path: PathBuilder,
    x: f32,
    y: f32,
    scale: f32,
}

impl GlyphPen {
    fn place(&self, x: f32, y: f32) -> (f32, f32) {
        (self.x + x * self.scale, self.y - y * self.scale)
    }
}

impl OutlineBuilder for GlyphPen {
    fn move_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.place(x, y);
        self.path.move_to(x, y);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.place(x, y);
        self.path.line_to(x, y);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let ((x1, y1), (x, y)) = (self.place(x1, y1), self.place(x, y));
        self.path.quad_to(x1, y1, x, y);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let ((x1, y1), (x2, y2), (x, y)) = (self.place(x1, y1), self.place(x2, y2), self.place(x, y));
        self.path.cubic_to(x1, y1, x2, y2, x, y);
    }

    fn close(&mut self) {
        self.path.close();
    }
}

#[cfg(test)]
mod tests {
    use super::super::Pen;
    use super::*;

    #[test]
    fn ink_lands_where_it_is_drawn() {
        let mut page = Diagram::new([40, 20]);
        let black = Ink(0, 0, 0);
        page.line(vec![[0.0, 2.5], [40.0, 2.5]], Pen { ink: black, width: 1.0, dash: &[] });
        page.word("l", [20.0, 18.0], 12.0, Anchor::Middle, black);
        let image = page.image(1);
        let dark = |x: u32, y: u32| image.color[(y * 40 + x) as usize][0] < 0.5;
        assert!((0..40).all(|x| dark(x, 2) && !dark(x, 4)), "the line");
        // The letter's stem stands in the middle, from its baseline up three quarters of the size.
        assert!((10..18).all(|y| dark(19, y) || dark(20, y)), "the stem");
        assert!(!dark(16, 14) && !dark(24, 14) && !dark(20, 7) && !dark(20, 18), "around it");
    }
}
