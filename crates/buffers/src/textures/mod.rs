//! Colors and numbers that vary over texture coordinates.

mod bytes;
mod image;

pub use image::{Encoding, Filter, Image, ImageTexture, Texels, UvSet, UvTransform, Wrap};

use glam::{Vec2, Vec3, Vec4};

use crate::TextureId;

/// A color, or a factor of the colors of a texture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColorSource {
    /// The color, where `texture` is `TextureId::NONE`.
    pub factor: Vec3,
    /// The texture, or `TextureId::NONE`.
    pub texture: TextureId,
}

impl ColorSource {
    /// The same everywhere.
    pub const fn constant(color: Vec3) -> ColorSource {
        ColorSource { factor: color, texture: TextureId::NONE }
    }

    /// Whether it is black everywhere, by its factor alone.
    pub fn is_black(self) -> bool {
        self.factor == Vec3::ZERO
    }
}

/// A number, or a factor of the numbers in one channel of a texture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScalarSource {
    /// The number, where `texture` is `TextureId::NONE`.
    pub factor: f32,
    /// The texture, or `TextureId::NONE`.
    pub texture: TextureId,
    /// The channel of the texture.
    pub channel: Channel,
}

impl ScalarSource {
    /// The same everywhere.
    pub const fn constant(number: f32) -> ScalarSource {
        ScalarSource { factor: number, texture: TextureId::NONE, channel: Channel::R }
    }

    /// Whether it is 0 everywhere, by its factor alone.
    pub fn is_zero(self) -> bool {
        self.factor == 0.0
    }
}

/// A channel of a texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channel {
    /// Red.
    R,
    /// Green.
    G,
    /// Blue.
    B,
    /// Alpha.
    A,
}

/// A color over texture coordinates. Equal if it shows the same: a picture, the same pixels of memory.
#[derive(Clone, Debug, PartialEq)]
pub enum Texture {
    /// Squares in turn, `a` at the corner (0, 0).
    Checker {
        /// Color of the square at (0, 0).
        a: Vec3,
        /// Color of its neighbors.
        b: Vec3,
        /// Side of a square in texture coordinates.
        size: f32,
    },
    /// From one color to another as a coordinate goes from 0 to 1; held beyond.
    Gradient {
        /// Color at 0.
        from: Vec3,
        /// Color at 1.
        to: Vec3,
        /// The coordinate.
        axis: Axis,
    },
    /// A picture.
    Image(ImageTexture),
}

/// A texture coordinate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// The first.
    U,
    /// The second.
    V,
}

/// All textures; a row index is a `TextureId`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Textures {
    /// One a texture.
    pub rows: Vec<Texture>,
}

impl Textures {
    /// The color of a source at texture coordinates.
    #[inline(always)]
    pub fn evaluate(&self, source: ColorSource, uv: Vec2) -> Vec3 {
        if source.texture == TextureId::NONE {
            source.factor
        } else {
            source.factor * self.rows[source.texture.0 as usize].evaluate(uv).truncate()
        }
    }

    /// The number of a source at texture coordinates.
    #[inline(always)]
    pub fn evaluate_scalar(&self, source: ScalarSource, uv: Vec2) -> f32 {
        if source.texture == TextureId::NONE {
            source.factor
        } else {
            source.factor * self.rows[source.texture.0 as usize].evaluate(uv)[source.channel as usize]
        }
    }

    /// The mean color of a source: of a texture, over all that it can show, each color as often as it is there. Looks at every
    /// pixel of a picture.
    pub fn mean(&self, source: ColorSource) -> Vec3 {
        if source.texture == TextureId::NONE {
            source.factor
        } else {
            source.factor * self.rows[source.texture.0 as usize].mean().truncate()
        }
    }
}

impl Texture {
    /// Whether its colors are finite and none below 0, its squares and its picture not empty.
    pub fn is_sound(&self) -> bool {
        let is_color = |color: &Vec3| color.is_finite() && color.min_element() >= 0.0;
        match self {
            Texture::Checker { a, b, size } => is_color(a) && is_color(b) && *size > 0.0 && size.is_finite(),
            Texture::Gradient { from, to, .. } => is_color(from) && is_color(to),
            Texture::Image(texture) => texture.is_sound(),
        }
    }

    /// The mean of all that it can show. Looks at every pixel of a picture.
    fn mean(&self) -> Vec4 {
        match self {
            Texture::Checker { a, b, .. } => (*a * 0.5 + *b * 0.5).extend(1.0),
            Texture::Gradient { from, to, .. } => (*from * 0.5 + *to * 0.5).extend(1.0),
            Texture::Image(texture) => texture.mean(),
        }
    }

    /// Linear color and alpha at texture coordinates.
    pub fn evaluate(&self, uv: Vec2) -> Vec4 {
        match self {
            Texture::Checker { a, b, size } => {
                let square = (uv / *size).floor();
                let color = if (square.x + square.y).rem_euclid(2.0) < 1.0 { *a } else { *b };
                color.extend(1.0)
            }
            Texture::Gradient { from, to, axis } => {
                let x = if *axis == Axis::U { uv.x } else { uv.y };
                (*from + (*to - *from) * x.clamp(0.0, 1.0)).extend(1.0)
            }
            Texture::Image(texture) => texture.evaluate(uv),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn checker_squares_alternate_across_zero() {
        let checker = Texture::Checker { a: Vec3::X, b: Vec3::Y, size: 0.5 };
        for (u, v, expected) in
            [(0.1, 0.1, Vec3::X), (0.6, 0.1, Vec3::Y), (0.6, 0.6, Vec3::X), (-0.1, 0.1, Vec3::Y), (-0.1, -0.1, Vec3::X)]
        {
            assert_eq!(checker.evaluate(Vec2::new(u, v)), expected.extend(1.0), "({u}, {v})");
        }
    }

    #[test]
    fn factors_scale_colors_and_channels() {
        let texel = Texels::Floats(vec![[0.5, 0.25, 2.0]]);
        let picture = ImageTexture::new(std::sync::Arc::new(Image { width: 1, height: 1, texels: texel }));
        let textures = Textures { rows: vec![Texture::Image(picture)] };
        let texture = TextureId(0);
        let color = ColorSource { factor: Vec3::new(1.0, 2.0, 0.5), texture };
        assert_eq!(textures.evaluate(color, Vec2::ZERO), Vec3::new(0.5, 0.5, 1.0));
        assert_eq!(textures.mean(color), Vec3::new(0.5, 0.5, 1.0));
        let number = |channel| textures.evaluate_scalar(ScalarSource { factor: 3.0, texture, channel }, Vec2::ZERO);
        assert_eq!([Channel::R, Channel::G, Channel::B, Channel::A].map(number), [1.5, 0.75, 6.0, 3.0]);
        assert_eq!(textures.evaluate_scalar(ScalarSource::constant(0.5), Vec2::ONE), 0.5);
    }
}
