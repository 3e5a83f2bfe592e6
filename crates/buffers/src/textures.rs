//! Colors that vary over texture coordinates.

use std::sync::Arc;

use glam::{DVec3, Vec2, Vec3};

use crate::TextureId;

/// A constant color, or a texture that replaces it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColorSource {
    /// Counts where `texture` is `TextureId::NONE`.
    pub constant: Vec3,
    /// The texture, or `TextureId::NONE`.
    pub texture: TextureId,
}

impl ColorSource {
    /// The same everywhere.
    pub const fn constant(constant: Vec3) -> ColorSource {
        ColorSource { constant, texture: TextureId::NONE }
    }

    /// Whether it is black everywhere, by its constant alone.
    pub fn is_black(self) -> bool {
        self.texture == TextureId::NONE && self.constant == Vec3::ZERO
    }
}

/// A number, multiplied by a channel of a texture if there is one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScalarSource {
    /// The number.
    pub factor: f32,
    /// The texture, or `TextureId::NONE`.
    pub texture: TextureId,
    /// The texture's channel.
    pub channel: Channel,
}

impl ScalarSource {
    /// The same everywhere.
    pub const fn constant(factor: f32) -> ScalarSource {
        ScalarSource { factor, texture: TextureId::NONE, channel: Channel::R }
    }

    /// Whether it is 0 everywhere.
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
    /// Opacity.
    A,
}

/// A color over texture coordinates.
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
    /// A picture, bilinear, repeated; row 0 is at v = 1.
    Image {
        /// The pixels.
        image: Arc<Image>,
        /// Times the picture repeats over 0..1.
        repeat: f32,
    },
}

/// A texture coordinate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// The first.
    U,
    /// The second.
    V,
}

/// Pixels in linear Rec.709, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Pixels in a row, at least 1.
    pub width: u32,
    /// Rows, at least 1.
    pub height: u32,
    /// `width * height` colors.
    pub pixels: Vec<[f32; 3]>,
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
            source.constant
        } else {
            self.rows[source.texture.0 as usize].evaluate(uv)
        }
    }

    /// The number of a source at texture coordinates.
    #[inline(always)]
    pub fn evaluate_scalar(&self, source: ScalarSource, uv: Vec2) -> f32 {
        if source.texture == TextureId::NONE {
            return source.factor;
        }
        let color = self.rows[source.texture.0 as usize].evaluate(uv);
        source.factor
            * match source.channel {
                Channel::R => color.x,
                Channel::G => color.y,
                Channel::B => color.z,
                Channel::A => 1.0,
            }
    }

    /// The mean color of a source: of a texture, over all that it can show, each color as often as it is there.
    pub fn mean(&self, source: ColorSource) -> Vec3 {
        if source.texture == TextureId::NONE { source.constant } else { self.rows[source.texture.0 as usize].mean() }
    }
}

impl Texture {
    /// Whether two textures are equal; images are if they are one in memory.
    pub fn is_same(&self, other: &Texture) -> bool {
        match (self, other) {
            (Texture::Image { image: a, repeat: times_a }, Texture::Image { image: b, repeat: times_b }) => {
                Arc::ptr_eq(a, b) && times_a == times_b
            }
            _ => self == other,
        }
    }

    /// The mean of all that it can show. Looks at every pixel of a picture.
    fn mean(&self) -> Vec3 {
        match self {
            Texture::Checker { a, b, .. } => *a * 0.5 + *b * 0.5,
            Texture::Gradient { from, to, .. } => *from * 0.5 + *to * 0.5,
            Texture::Image { image, .. } => {
                let sum = image.pixels.iter().fold(DVec3::ZERO, |sum, &pixel| sum + Vec3::from_array(pixel).as_dvec3());
                (sum / image.pixels.len() as f64).as_vec3()
            }
        }
    }

    /// The color at texture coordinates.
    pub fn evaluate(&self, uv: Vec2) -> Vec3 {
        match self {
            Texture::Checker { a, b, size } => {
                let square = (uv / *size).floor();
                if (square.x + square.y).rem_euclid(2.0) < 1.0 { *a } else { *b }
            }
            Texture::Gradient { from, to, axis } => {
                let x = if *axis == Axis::U { uv.x } else { uv.y };
                *from + (*to - *from) * x.clamp(0.0, 1.0)
            }
            Texture::Image { image, repeat } => image.bilinear(uv * *repeat),
        }
    }
}

impl Image {
    /// Between the four nearest pixel centers; the picture repeats in both directions.
    fn bilinear(&self, uv: Vec2) -> Vec3 {
        // What is beyond the comma; rounded to 1 just below a whole number.
        let within = uv - uv.floor();
        let place = |x: f32, size: u32| {
            let x = x * size as f32 - 0.5;
            let low = x.floor();
            let index = |i: f32| (i as i64).rem_euclid(i64::from(size)) as usize;
            (index(low), index(low + 1.0), x - low)
        };
        let (x0, x1, fx) = place(within.x, self.width);
        let (y0, y1, fy) = place(1.0 - within.y, self.height);
        let pixel = |x: usize, y: usize| Vec3::from_array(self.pixels[y * self.width as usize + x]);
        let top = pixel(x0, y0) * (1.0 - fx) + pixel(x1, y0) * fx;
        let bottom = pixel(x0, y1) * (1.0 - fx) + pixel(x1, y1) * fx;
        top * (1.0 - fy) + bottom * fy
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
            assert_eq!(checker.evaluate(Vec2::new(u, v)), expected, "({u}, {v})");
        }
    }

    #[test]
    fn an_image_has_its_first_row_at_the_top_and_repeats() {
        let pixels = vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 1.0, 1.0]];
        let texture = Texture::Image { image: Arc::new(Image { width: 2, height: 2, pixels }), repeat: 1.0 };
        for (u, v, expected) in [
            (0.25, 0.75, [1.0, 0.0, 0.0]),
            (0.75, 0.75, [0.0, 1.0, 0.0]),
            (0.25, 0.25, [0.0, 0.0, 1.0]),
            (0.5, 0.75, [0.5, 0.5, 0.0]),
            (1.25, -0.25, [1.0, 0.0, 0.0]),
            (0.0, 0.75, [0.5, 0.5, 0.0]),
        ] {
            assert_eq!(texture.evaluate(Vec2::new(u, v)).to_array(), expected, "({u}, {v})");
        }
    }

    /// The picture at a place, by the definition in f64: pixel (i, j) has its center at u = (i + 1/2)/width, v = 1 - (j +
    /// 1/2)/height; every pixel weighs by how near it is, none beyond one pixel.
    fn by_definition(image: &Image, u: f64, v: f64) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for (place, pixel) in image.pixels.iter().enumerate() {
            let (column, row) = (place % image.width as usize, place / image.width as usize);
            let weight = |x: f64, center: usize, size: u32| {
                let away = x * f64::from(size) - (center as f64 + 0.5);
                // To the nearest of the pixel's repetitions and, in pictures of one pixel, to the next as well.
                let nearest = away - (away / f64::from(size)).round() * f64::from(size);
                let near = |away: f64| (1.0 - away.abs()).max(0.0);
                let others = if size == 1 { near(nearest - 1.0) + near(nearest + 1.0) } else { 0.0 };
                near(nearest) + others
            };
            let weight = weight(u, column, image.width) * weight(1.0 - v, row, image.height);
            for (sum, &channel) in sum.iter_mut().zip(pixel) {
                *sum += weight * f64::from(channel);
            }
        }
        sum
    }

    #[test]
    fn an_image_is_bilinear_and_repeats_at_its_edges_and_far_from_them() {
        let places = [
            0.0, 0.1, 0.25, 0.333, 0.5, 0.75, 0.99999994, 1.0, 1.0000001, 1e-40, 1e-30, 1e-9, 7.3, 1000.7, 65535.996,
            3000000.3, 1e9, 3e12,
        ];
        let places = places.into_iter().flat_map(|x| [x, -x]);
        for (width, height) in [(1, 1), (2, 2), (4, 3), (3, 1), (1, 5), (64, 7)] {
            let pixel = |i: u32| [(i % 5) as f32, (i * 7 % 11) as f32 / 11.0, 1.2 - (i * 3 % 8) as f32 / 8.0];
            let image = Image { width, height, pixels: (0..width * height).map(pixel).collect() };
            // u and 1 - v are rounded to 2^-24 of the picture's side, their products with the size to as much again; colors
            // differ by at most 4 from pixel to pixel, and are weighted with four roundings.
            let tolerance = 2f64.powi(-24) * 4.0 * f64::from(2 * width + 2 * height + 4);
            for (u, v) in places.clone().flat_map(|u| places.clone().map(move |v| (u, v))) {
                let found = image.bilinear(Vec2::new(u, v));
                let expected = by_definition(&image, f64::from(u), f64::from(v));
                for (found, expected) in found.to_array().into_iter().zip(expected) {
                    let error = (f64::from(found) - expected).abs();
                    assert!(error < tolerance, "{width}x{height} at ({u}, {v}): {found} instead of {expected}");
                }
            }
        }
    }
}
