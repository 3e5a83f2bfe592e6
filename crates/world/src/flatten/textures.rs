//! Textures: one row for each color that comes from a texture, in the order of materials and, within one, of its fields. Images are
//! shared, not copied.

use brewster_buffers::{Channel, ColorSource, ScalarSource, Texture, TextureId};
use glam::Vec3;

use super::report::RowEdits;
use crate::components::{Color, Scalar};

/// Writes textures over those of a table, from some row on.
pub(super) struct TextureWriter<'a> {
    rows: &'a mut Vec<Texture>,
    next: usize,
    before: usize,
    edits: RowEdits,
}

impl TextureWriter<'_> {
    pub(super) fn new(rows: &mut Vec<Texture>, next: usize) -> TextureWriter<'_> {
        let before = rows.len();
        TextureWriter { rows, next, before, edits: RowEdits::default() }
    }

    /// The row of the next texture.
    pub(super) fn next(&self) -> usize {
        self.next
    }

    /// What a column holds for a color; its texture, if there is one, becomes the next row.
    pub(super) fn source(&mut self, color: &Color) -> ColorSource {
        ColorSource { factor: color.factor(), texture: self.row(color.texture()) }
    }

    /// What a column holds for a number; its texture, if there is one, becomes the next row.
    pub(super) fn scalar(&mut self, scalar: &Scalar) -> ScalarSource {
        let (texture, channel) =
            scalar.texture.as_ref().map_or((None, Channel::R), |(map, channel)| (Some(map), *channel));
        ScalarSource { factor: scalar.factor, texture: self.row(texture), channel }
    }

    /// A texture becomes the next row.
    pub(super) fn row(&mut self, texture: Option<&Texture>) -> TextureId {
        let Some(texture) = texture else { return TextureId::NONE };
        let row = self.next;
        self.next += 1;
        let differs = match self.rows.get_mut(row) {
            Some(old) if old == texture => false,
            Some(old) => {
                *old = texture.clone();
                true
            }
            None => {
                self.rows.push(texture.clone());
                true
            }
        };
        self.edits.count(row, self.before, differs);
        TextureId(row as u32)
    }

    /// What was written.
    pub(super) fn edits(&self) -> RowEdits {
        self.edits
    }

    /// Drops the rows that were not written over.
    pub(super) fn finish(mut self) -> RowEdits {
        self.rows.truncate(self.next);
        self.edits.removed = self.before.saturating_sub(self.next);
        self.edits
    }
}

/// Whether all channels are finite and at least 0.
pub(super) fn is_color(color: Vec3) -> bool {
    color.is_finite() && color.min_element() >= 0.0
}

/// Checks a texture; the error says what must hold.
pub(super) fn check(texture: &Texture) -> Result<(), &'static str> {
    if texture.is_sound() {
        Ok(())
    } else {
        Err("a texture's colors must be finite and at least 0, its squares and its image not empty")
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use brewster_buffers::{Image, ImageTexture, Texels, UvTransform};

    use super::*;

    #[test]
    fn textures_are_written_over_in_order() {
        let checker = |size| Texture::Checker { a: Vec3::ZERO, b: Vec3::ONE, size };
        let mut rows = [1.0, 2.0, 3.0, 4.0, 5.0].map(checker).to_vec();
        let mut writer = TextureWriter::new(&mut rows, 0);
        let sources = [checker(1.0), checker(5.0)].map(|texture| writer.source(&Color::Texture(texture)));
        assert_eq!(sources.map(|source| source.texture), [TextureId(0), TextureId(1)]);
        assert_eq!(writer.source(&Color::WHITE), ColorSource::constant(Vec3::ONE));
        let tinted = Color::Tinted { factor: Vec3::X, texture: checker(3.0) };
        assert_eq!(writer.source(&tinted), ColorSource { factor: Vec3::X, texture: TextureId(2) });
        let scalar = Scalar { factor: 0.5, texture: Some((checker(7.0), Channel::B)) };
        let row = ScalarSource { factor: 0.5, texture: TextureId(3), channel: Channel::B };
        assert_eq!(writer.scalar(&scalar), row);
        assert_eq!(writer.scalar(&Scalar::constant(2.0)), ScalarSource::constant(2.0));
        assert_eq!(writer.finish(), RowEdits { added: 0, removed: 1, rewritten: 2 });
        assert_eq!(rows, [checker(1.0), checker(5.0), checker(3.0), checker(7.0)]);
    }

    #[test]
    fn empty_squares_and_images_are_refused() {
        let image = |width, pixels| {
            let image = Image { width, height: 1, texels: Texels::Bytes(vec![[0; 4]; pixels]) };
            ImageTexture::new(Arc::new(image))
        };
        let boundless = ImageTexture { transform: UvTransform::scale(1.0, f32::INFINITY), ..image(1, 1) };
        for (texture, sound) in [
            (Texture::Checker { a: Vec3::ZERO, b: Vec3::ONE, size: 0.5 }, true),
            (Texture::Checker { a: Vec3::ZERO, b: Vec3::ONE, size: 0.0 }, false),
            (Texture::Checker { a: Vec3::NAN, b: Vec3::ONE, size: 0.5 }, false),
            (Texture::Image(image(2, 2)), true),
            (Texture::Image(image(2, 1)), false),
            (Texture::Image(image(0, 0)), false),
            (Texture::Image(boundless), false),
        ] {
            assert_eq!(check(&texture).is_ok(), sound, "{texture:?}");
        }
    }
}
