//! Colors and numbers that vary over texture coordinates.

mod bytes;
mod image;
mod pyramid;
mod seen;

pub use image::{Encoding, Filter, Image, ImageTexture, Texels, UvTransform, Wrap};
pub use pyramid::Pyramid;
pub use seen::SeenPlace;

use brewster_geometry::UvSet;
use glam::{Vec2, Vec3, Vec4};

use crate::{SceneBuffers, TextureId};

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
    /// The colors of a mesh's vertices; white on other shapes.
    VertexColors,
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

/// What a texture can depend on at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coordinates {
    /// Texture coordinates of both sets.
    pub uvs: [Vec2; 2],
    /// The color of a mesh's vertices.
    pub color: Vec4,
}

impl Coordinates {
    /// The same coordinates in both sets, on a shape without colors.
    #[inline(always)]
    pub fn of(uv: Vec2) -> Coordinates {
        Coordinates { uvs: [uv; 2], color: Vec4::ONE }
    }
}

impl SceneBuffers {
    /// The color of a source at a place.
    #[inline(always)]
    pub fn color(&self, source: ColorSource, place: &SeenPlace) -> Vec3 {
        if source.texture == TextureId::NONE {
            source.factor
        } else {
            source.factor * self.texture(source.texture, place).truncate()
        }
    }

    /// The number of a source at a place.
    #[inline(always)]
    pub fn number(&self, source: ScalarSource, place: &SeenPlace) -> f32 {
        if source.texture == TextureId::NONE {
            source.factor
        } else {
            source.factor * self.texture(source.texture, place)[source.channel as usize]
        }
    }

    /// Linear color and alpha of a texture at a place.
    #[inline]
    pub fn texture(&self, texture: TextureId, place: &SeenPlace) -> Vec4 {
        let (last, found) = place.last.get();
        if last == texture {
            return found;
        }
        let found = self.looked_up(&self.textures.rows[texture.0 as usize], place);
        place.last.set((texture, found));
        found
    }

    #[inline]
    fn looked_up(&self, texture: &Texture, place: &SeenPlace) -> Vec4 {
        if let Texture::Image(image) = texture
            && place.width > 0.0
            && image.pyramid.is_some()
        {
            return self.seen_from_afar(image, place);
        }
        if texture.asks_vertices() {
            texture.evaluate(&self.coordinates(place))
        } else {
            texture.evaluate(&Coordinates::of(place.uv))
        }
    }

    fn seen_from_afar(&self, image: &ImageTexture, place: &SeenPlace) -> Vec4 {
        let lie = image.lie();
        let spot = match place.spot.get() {
            Some((known, spot)) if known == lie => spot,
            _ => {
                let pixels = place.width * image.pixels_across(self.uv_gradients(place, image.uv_set));
                let spot = image.spot(self.geometry().uv(place, image.uv_set), pixels);
                place.spot.set(Some((lie, spot)));
                spot
            }
        };
        let color = image.around(&spot);
        if image.vertex_colors { color * self.geometry().vertex_color(place) } else { color }
    }

    /// All that a texture can depend on.
    pub fn coordinates(&self, place: &SeenPlace) -> Coordinates {
        let geometry = self.geometry();
        Coordinates { uvs: [place.uv, geometry.uv(place, UvSet::Second)], color: geometry.vertex_color(place) }
    }
}

impl Textures {
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
            Texture::VertexColors => true,
        }
    }

    /// The mean of all that it can show. Looks at every pixel of a picture.
    fn mean(&self) -> Vec4 {
        match self {
            Texture::Checker { a, b, .. } => (*a * 0.5 + *b * 0.5).extend(1.0),
            Texture::Gradient { from, to, .. } => (*from * 0.5 + *to * 0.5).extend(1.0),
            Texture::Image(texture) => texture.mean(),
            Texture::VertexColors => Vec4::ONE,
        }
    }

    /// Whether it depends on more than the first texture coordinates.
    #[inline(always)]
    fn asks_vertices(&self) -> bool {
        match self {
            Texture::Checker { .. } | Texture::Gradient { .. } => false,
            Texture::Image(image) => image.uv_set == UvSet::Second || image.vertex_colors,
            Texture::VertexColors => true,
        }
    }

    /// Linear color and alpha.
    pub fn evaluate(&self, at: &Coordinates) -> Vec4 {
        let uv = at.uvs[0];
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
            Texture::Image(texture) => {
                let color = texture.at(at.uvs[texture.uv_set as usize]);
                if texture.vertex_colors { color * at.color } else { color }
            }
            Texture::VertexColors => at.color,
        }
    }
}

#[cfg(test)]
mod tests {
    use brewster_geometry::SurfacePlace;

    use super::*;

    #[test]
    fn checker_squares_alternate_across_zero() {
        let checker = Texture::Checker { a: Vec3::X, b: Vec3::Y, size: 0.5 };
        for (u, v, expected) in
            [(0.1, 0.1, Vec3::X), (0.6, 0.1, Vec3::Y), (0.6, 0.6, Vec3::X), (-0.1, 0.1, Vec3::Y), (-0.1, -0.1, Vec3::X)]
        {
            assert_eq!(checker.evaluate(&Coordinates::of(Vec2::new(u, v))), expected.extend(1.0), "({u}, {v})");
        }
    }

    /// A texture of one pixel: half red, a quarter green, blue.
    fn pixel() -> ImageTexture {
        let texels = Texels::Bytes(vec![[51, 102, 255, 204]]);
        let image = std::sync::Arc::new(Image { width: 1, height: 1, texels });
        ImageTexture { encoding: Encoding::Linear, ..ImageTexture::new(image) }
    }

    #[test]
    fn factors_scale_colors_and_channels() {
        let scene =
            SceneBuffers { textures: Textures { rows: vec![Texture::Image(pixel())] }, ..SceneBuffers::default() };
        let place =
            SurfacePlace { instance: 0, primitive: 0, position: Vec3::ZERO, uv: Vec2::ZERO, width: 0.0, time: 0.0 }
                .into();
        let texture = TextureId(0);
        let color = ColorSource { factor: Vec3::new(1.0, 2.0, 0.5), texture };
        assert_eq!(scene.color(color, &place), Vec3::new(0.2, 0.8, 0.5));
        assert_eq!(scene.textures.mean(color), Vec3::new(0.2, 0.8, 0.5));
        let number = |channel| scene.number(ScalarSource { factor: 2.0, texture, channel }, &place);
        assert_eq!([Channel::R, Channel::G, Channel::B, Channel::A].map(number), [0.4, 0.8, 2.0, 1.6]);
        assert_eq!(scene.number(ScalarSource::constant(0.5), &place), 0.5);
    }

    #[test]
    fn pictures_take_the_set_and_the_colors_that_they_ask_for() {
        let at =
            Coordinates { uvs: [Vec2::new(0.5, 0.25), Vec2::new(0.5, 0.75)], color: Vec4::new(0.5, 1.0, 0.0, 0.25) };
        let texels = Texels::Bytes(vec![[255; 4], [0, 0, 0, 255]]);
        let image = std::sync::Arc::new(Image { width: 1, height: 2, texels });
        // The black row is below: at v from 0 to 1/2.
        let column = ImageTexture { filter: Filter::Nearest, ..ImageTexture::new(image) };
        for (uv_set, vertex_colors, expected) in [
            (UvSet::First, false, Vec4::W),
            (UvSet::Second, false, Vec4::ONE),
            (UvSet::Second, true, at.color),
            (UvSet::First, true, Vec4::W * 0.25),
        ] {
            let texture = Texture::Image(ImageTexture { uv_set, vertex_colors, ..column.clone() });
            assert_eq!(texture.evaluate(&at), expected, "{uv_set:?} {vertex_colors}");
        }
        assert_eq!(Texture::VertexColors.evaluate(&at), at.color);
    }
}
