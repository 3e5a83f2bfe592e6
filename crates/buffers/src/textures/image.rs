//! Pictures as a file holds them, and how they lie over a surface.

use std::sync::Arc;

use brewster_geometry::UvSet;
use brewster_lanes::math;
use brewster_optics::color::linear_from_srgb16;
use glam::{DVec4, Vec2, Vec3, Vec4};

use super::bytes::{SRGB, UNIT};
use super::pyramid::Pyramid;
use super::{Channel, Coordinates};

/// Pixels, row by row from the top. Many textures share one by an `Arc`.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Pixels in a row, at least 1.
    pub width: u32,
    /// Rows, at least 1.
    pub height: u32,
    /// `width * height` pixels.
    pub texels: Texels,
}

/// Pixels in the precision of the file that they are from: a picture of 4096 x 4096 bytes a channel takes 64 MiB.
#[derive(Clone, Debug, PartialEq)]
pub enum Texels {
    /// Red, green, blue and alpha; 255 is 1.
    Bytes(Vec<[u8; 4]>),
    /// Red, green, blue and alpha; 65535 is 1.
    Words(Vec<[u16; 4]>),
    /// Red, green and blue, always linear; alpha is 1.
    Floats(Vec<[f32; 3]>),
}

/// What the bytes and words of a picture stand for. Alpha is linear in any case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// Colors by the curve of sRGB.
    Srgb,
    /// The values themselves: data.
    Linear,
}

/// How a picture goes on beyond its edges.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wrap {
    /// From the beginning.
    Repeat,
    /// Backwards, then forwards again, and so on.
    Mirror,
    /// With the pixels at the edge.
    Clamp,
}

/// What lies between the centers of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filter {
    /// The nearest pixel.
    Nearest,
    /// A bilinear mean of the nearest four.
    Linear,
}

/// An affine map of texture coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UvTransform {
    /// What u and v become: factors of u, of v, and of 1.
    pub rows: [[f32; 3]; 2],
}

/// A picture over a surface; row 0 is at v = 1.
#[derive(Clone, Debug)]
pub struct ImageTexture {
    /// The pixels.
    pub image: Arc<Image>,
    /// What they stand for.
    pub encoding: Encoding,
    /// What lies beyond the edges along u and v.
    pub wrap: [Wrap; 2],
    /// What lies between pixels.
    pub filter: Filter,
    /// The coordinates that it is looked up by.
    pub uv_set: UvSet,
    /// What is done to them first.
    pub transform: UvTransform,
    /// Whether the colors of a mesh's vertices multiply it.
    pub vertex_colors: bool,
    /// What is seen of it from afar; without it, single pixels.
    pub pyramid: Option<Arc<Pyramid>>,
}

impl UvTransform {
    /// Leaves coordinates as they are.
    pub const IDENTITY: UvTransform = UvTransform::scale(1.0, 1.0);

    /// Scales coordinates: the picture repeats as often.
    pub const fn scale(u: f32, v: f32) -> UvTransform {
        UvTransform { rows: [[u, 0.0, 0.0], [0.0, v, 0.0]] }
    }

    /// The mapped coordinates.
    #[inline(always)]
    pub fn apply(&self, uv: Vec2) -> Vec2 {
        let [u, v] = &self.rows;
        Vec2::new(uv.x * u[0] + uv.y * u[1] + u[2], uv.x * v[0] + uv.y * v[1] + v[2])
    }

    /// How much the mapped coordinates grow where those before grow so much.
    #[inline(always)]
    pub fn gradients(&self, [of_u, of_v]: [Vec3; 2]) -> [Vec3; 2] {
        let [u, v] = &self.rows;
        [of_u * u[0] + of_v * u[1], of_u * v[0] + of_v * v[1]]
    }
}

impl Texels {
    /// How many there are.
    pub fn len(&self) -> usize {
        match self {
            Texels::Bytes(texels) => texels.len(),
            Texels::Words(texels) => texels.len(),
            Texels::Floats(texels) => texels.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

impl Image {
    /// Whether there are pixels, as many as width and height say and as u32 can count.
    pub fn is_sound(&self) -> bool {
        let texels = self.width as usize * self.height as usize;
        texels > 0 && self.texels.len() == texels && u32::try_from(texels).is_ok()
    }

    /// A pixel as linear color and alpha.
    #[inline(always)]
    pub fn texel(&self, index: usize, encoding: Encoding) -> Vec4 {
        match &self.texels {
            Texels::Bytes(texels) => of_bytes(texels[index], color_table(encoding)),
            Texels::Words(texels) => of_words(texels[index], encoding),
            Texels::Floats(texels) => Vec3::from_array(texels[index]).extend(1.0),
        }
    }

    /// Linear colors; empty if the pixels are bytes or words.
    #[inline(always)]
    pub fn floats(&self) -> &[[f32; 3]] {
        match &self.texels {
            Texels::Floats(texels) => texels,
            _ => &[],
        }
    }

    /// The same picture in linear colors, decoded from sRGB; itself if it is linear already.
    pub fn to_floats(self: &Arc<Image>) -> Arc<Image> {
        if let Texels::Floats(_) = self.texels {
            return Arc::clone(self);
        }
        let texels = (0..self.texels.len()).map(|index| self.texel(index, Encoding::Srgb).truncate().to_array());
        Arc::new(Image { width: self.width, height: self.height, texels: Texels::Floats(texels.collect()) })
    }
}

/// Textures are equal if they show the same pixels of memory in the same way.
impl PartialEq for ImageTexture {
    fn eq(&self, other: &ImageTexture) -> bool {
        let view = |texture: &ImageTexture| {
            let ImageTexture { encoding, wrap, filter, uv_set, transform, vertex_colors, ref pyramid, .. } = *texture;
            (encoding, wrap, filter, uv_set, transform, vertex_colors, pyramid.is_some())
        };
        Arc::ptr_eq(&self.image, &other.image) && view(self) == view(other)
    }
}

impl ImageTexture {
    /// A picture of colors that lies once over coordinates 0 to 1 and repeats beyond them.
    pub fn new(image: Arc<Image>) -> ImageTexture {
        ImageTexture {
            image,
            encoding: Encoding::Srgb,
            wrap: [Wrap::Repeat; 2],
            filter: Filter::Linear,
            uv_set: UvSet::First,
            transform: UvTransform::IDENTITY,
            vertex_colors: false,
            pyramid: None,
        }
    }

    /// Whether there is a picture and a finite transform.
    pub fn is_sound(&self) -> bool {
        self.image.is_sound() && self.transform.rows.as_flattened().iter().all(|number| number.is_finite())
    }

    /// Color and alpha at coordinates of its set.
    #[inline]
    pub(super) fn at(&self, uv: Vec2) -> Vec4 {
        self.look(self.transform.apply(uv))
    }

    /// How it lies over a surface.
    #[inline(always)]
    pub(super) fn lie(&self) -> Lie {
        let ImageTexture { ref image, wrap, filter, uv_set, transform, .. } = *self;
        Lie { size: [image.width, image.height], wrap, filter, uv_set, transform }
    }

    /// Where the two levels are looked up whose pixels are next to a part of the picture that is so many pixels wide, around coordinates
    /// of its set.
    #[inline]
    pub(super) fn spot(&self, uv: Vec2, pixels: f32) -> Spot {
        let uv = self.transform.apply(uv);
        let levels = self.pyramid.as_ref().map_or(&[][..], |pyramid| pyramid.levels());
        let level = if pixels > 1.0 { math::log2(pixels).min(levels.len() as f32) } else { 0.0 };
        let low = floor(level);
        let picture = |level: usize| match level.checked_sub(1).and_then(|below| levels.get(below)) {
            Some(below) => below,
            None => &*self.image,
        };
        let (level, part) = (low as usize, level - low);
        let fine = self.corners(picture(level), uv);
        let coarse = if part == 0.0 { fine } else { self.corners(picture(level + 1), uv) };
        Spot { level: level as u32, part, fine, coarse }
    }

    /// Color and alpha of all that lies around a spot: a mean of two levels.
    #[inline]
    pub(super) fn around(&self, spot: &Spot) -> Vec4 {
        let level = spot.level as usize;
        let fine = self.mean_of_level(level, &spot.fine);
        if spot.part == 0.0 {
            return fine;
        }
        fine * (1.0 - spot.part) + self.mean_of_level(level + 1, &spot.coarse) * spot.part
    }

    /// Color and alpha of a level between four of its pixels.
    #[inline]
    fn mean_of_level(&self, level: usize, corners: &Corners) -> Vec4 {
        let levels = self.pyramid.as_ref().map_or(&[][..], |pyramid| pyramid.levels());
        match level.checked_sub(1).and_then(|below| levels.get(below)) {
            // A level has words, or the floats of its picture.
            Some(level) => match &level.texels {
                Texels::Words(texels) => corners.mix(|index| numbers(texels[index])) * (1.0 / 65535.0),
                _ => corners.look(level, Encoding::Linear),
            },
            None => corners.look(&self.image, self.encoding),
        }
    }

    /// How many pixels of it lie across a meter of a surface, given by how much its coordinates grow along it.
    #[inline]
    pub(super) fn pixels_across(&self, gradients: [Vec3; 2]) -> f32 {
        let [u, v] = self.transform.gradients(gradients);
        let of_u = (u * self.image.width as f32).length_squared();
        of_u.max((v * self.image.height as f32).length_squared()).sqrt()
    }

    /// How much a channel grows with u and v of the picture, from half a pixel before to half a pixel behind.
    pub(crate) fn slope(&self, at: &Coordinates, channel: Channel) -> Vec2 {
        let uv = self.transform.apply(at.uvs[self.uv_set as usize]);
        let slope = |axis: Vec2, size: u32| {
            let half = axis * (0.5 / size as f32);
            (self.look(uv + half)[channel as usize] - self.look(uv - half)[channel as usize]) * size as f32
        };
        Vec2::new(slope(Vec2::X, self.image.width), slope(Vec2::Y, self.image.height))
    }

    /// Color and alpha at a place of the picture.
    #[inline]
    fn look(&self, uv: Vec2) -> Vec4 {
        self.corners(&self.image, uv).look(&self.image, self.encoding)
    }

    /// The pixels around a place of the picture in one of its sizes.
    #[inline(always)]
    fn corners(&self, image: &Image, uv: Vec2) -> Corners {
        let [wrap_u, wrap_v] = self.wrap;
        let (x, y) = (wrap_u.within(uv.x), 1.0 - wrap_v.within(uv.y));
        let ([left, right], across) = self.filter.between(x, image.width, wrap_u);
        let ([above, below], down) = self.filter.between(y, image.height, wrap_v);
        let (above, below) = (above * image.width, below * image.width);
        Corners { top: [above + left, above + right], bottom: [below + left, below + right], across, down }
    }

    /// The mean of all pixels.
    pub(super) fn mean(&self) -> Vec4 {
        let texels = (0..self.image.texels.len()).map(|index| self.image.texel(index, self.encoding));
        let sum = texels.fold(DVec4::ZERO, |sum, texel| sum + texel.as_dvec4());
        (sum / self.image.texels.len() as f64).as_vec4()
    }
}

/// How a picture lies over a surface: pictures that lie alike are looked up at the same pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Lie {
    size: [u32; 2],
    wrap: [Wrap; 2],
    filter: Filter,
    uv_set: UvSet,
    transform: UvTransform,
}

/// The pixels of two levels of a picture around a place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spot {
    /// The finer level; 0 is the picture itself.
    level: u32,
    /// How much of the coarser one is seen.
    part: f32,
    fine: Corners,
    coarse: Corners,
}

/// Four pixels around a place, and how far it is from the first ones to the others.
#[derive(Clone, Copy, Debug)]
struct Corners {
    top: [u32; 2],
    bottom: [u32; 2],
    across: f32,
    down: f32,
}

impl Corners {
    /// A bilinear mean.
    #[inline(always)]
    fn mix(&self, texel: impl Fn(usize) -> Vec4) -> Vec4 {
        let row =
            |[left, right]: [u32; 2]| texel(left as usize) * (1.0 - self.across) + texel(right as usize) * self.across;
        row(self.top) * (1.0 - self.down) + row(self.bottom) * self.down
    }

    /// Linear color and alpha between pixels of a picture.
    #[inline]
    fn look(&self, image: &Image, encoding: Encoding) -> Vec4 {
        match &image.texels {
            Texels::Bytes(texels) => {
                let table = color_table(encoding);
                self.mix(|index| of_bytes(texels[index], table))
            }
            Texels::Words(texels) => self.mix(|index| of_words(texels[index], encoding)),
            Texels::Floats(texels) => self.mix(|index| Vec3::from_array(texels[index]).extend(1.0)),
        }
    }
}

impl Filter {
    /// The two pixels of a row of `size` between which a place of it is, from 0 to 1 along the row, and how far it is from the first.
    #[inline(always)]
    fn between(self, place: f32, size: u32, wrap: Wrap) -> ([u32; 2], f32) {
        let place = place * size as f32;
        match self {
            Filter::Nearest => {
                let index = wrap.index(floor(place) as i32, size);
                ([index; 2], 0.0)
            }
            Filter::Linear => {
                let place = place - 0.5;
                let low = floor(place);
                ([wrap.index(low as i32, size), wrap.index(low as i32 + 1, size)], place - low)
            }
        }
    }
}

/// What lies in the colors of a picture of bytes.
#[inline(always)]
fn color_table(encoding: Encoding) -> &'static [f32; 256] {
    if encoding == Encoding::Srgb { &SRGB } else { &UNIT }
}

#[inline(always)]
fn of_bytes([r, g, b, a]: [u8; 4], table: &[f32; 256]) -> Vec4 {
    Vec4::new(table[usize::from(r)], table[usize::from(g)], table[usize::from(b)], UNIT[usize::from(a)])
}

/// Words as numbers from 0 to 65535.
#[inline(always)]
fn numbers([r, g, b, a]: [u16; 4]) -> Vec4 {
    Vec4::new(f32::from(r), f32::from(g), f32::from(b), f32::from(a))
}

#[inline(always)]
fn of_words([r, g, b, a]: [u16; 4], encoding: Encoding) -> Vec4 {
    let channel = |value| match encoding {
        Encoding::Srgb => linear_from_srgb16(value),
        Encoding::Linear => f32::from(value) / 65535.0,
    };
    Vec4::new(channel(r), channel(g), channel(b), f32::from(a) / 65535.0)
}

/// The largest whole number that is not above x, without the call that `f32::floor` is where SSE4.1 may be absent.
#[inline(always)]
fn floor(x: f32) -> f32 {
    /// From here on f32 has whole numbers alone.
    const WHOLE: f32 = 8_388_608.0;
    let toward_zero = x as i32 as f32;
    let down = if toward_zero > x { toward_zero - 1.0 } else { toward_zero };
    if x.abs() < WHOLE { down } else { x }
}

impl Wrap {
    /// Brings a coordinate near to 0, where f32 is fine: into the period of the picture, rounded to its end just below it.
    #[inline(always)]
    fn within(self, x: f32) -> f32 {
        match self {
            Wrap::Repeat => x - floor(x),
            Wrap::Mirror => x - 2.0 * floor(x * 0.5),
            Wrap::Clamp => x.clamp(0.0, 1.0),
        }
    }

    /// The pixel, of `size` in a row, that stands at a place of the row that goes on beyond its ends: at most a period before the
    /// first or behind the last.
    #[inline(always)]
    fn index(self, place: i32, size: u32) -> u32 {
        let size = size as i32;
        let within = |period: i32| match place {
            place if place < 0 => place + period,
            place if place >= period => place - period,
            place => place,
        };
        let index = match self {
            Wrap::Repeat => within(size),
            Wrap::Mirror => {
                let place = within(2 * size);
                place.min(2 * size - 1 - place)
            }
            Wrap::Clamp => place.clamp(0, size - 1),
        };
        index as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Red, green; blue, white.
    fn two_by_two() -> Arc<Image> {
        let pixels = vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 1.0, 1.0]];
        Arc::new(Image { width: 2, height: 2, texels: Texels::Floats(pixels) })
    }

    /// As `f32::floor` says.
    #[test]
    fn whole_numbers_are_found_without_a_call() {
        let near = [0.0, 0.3, 1.0, 1.5, 2.999_999_8, 7.0, 8_388_607.5, 8_388_608.0, 16_777_215.0, 3e9, 1e30];
        for x in near.into_iter().chain([f32::MIN_POSITIVE, 1e-40, f32::INFINITY]).flat_map(|x| [x, -x]) {
            assert_eq!(floor(x), x.floor(), "{x}");
        }
        assert!(floor(f32::NAN).is_nan());
    }

    #[test]
    fn an_image_has_its_first_row_at_the_top_and_repeats() {
        let texture = ImageTexture::new(two_by_two());
        for (u, v, expected) in [
            (0.25, 0.75, [1.0, 0.0, 0.0]),
            (0.75, 0.75, [0.0, 1.0, 0.0]),
            (0.25, 0.25, [0.0, 0.0, 1.0]),
            (0.5, 0.75, [0.5, 0.5, 0.0]),
            (1.25, -0.25, [1.0, 0.0, 0.0]),
            (0.0, 0.75, [0.5, 0.5, 0.0]),
        ] {
            assert_eq!(texture.at(Vec2::new(u, v)).truncate().to_array(), expected, "({u}, {v})");
        }
    }

    /// The picture at a place, by the definition in f64: pixel (i, j) has its center at u = (i + 1/2)/width, v = 1 - (j +
    /// 1/2)/height; every pixel weighs by how near it is, none beyond one pixel.
    fn by_definition(image: &Image, u: f64, v: f64) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for (place, pixel) in image.floats().iter().enumerate() {
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
            let texels = Texels::Floats((0..width * height).map(pixel).collect());
            let texture = ImageTexture::new(Arc::new(Image { width, height, texels }));
            // u and 1 - v are rounded to 2^-24 of the picture's side, their products with the size to as much again; colors
            // differ by at most 4 from pixel to pixel, and are weighted with four roundings.
            let tolerance = 2f64.powi(-24) * 4.0 * f64::from(2 * width + 2 * height + 4);
            for (u, v) in places.clone().flat_map(|u| places.clone().map(move |v| (u, v))) {
                let found = texture.at(Vec2::new(u, v)).truncate();
                let expected = by_definition(&texture.image, f64::from(u), f64::from(v));
                for (found, expected) in found.to_array().into_iter().zip(expected) {
                    let error = (f64::from(found) - expected).abs();
                    assert!(error < tolerance, "{width}x{height} at ({u}, {v}): {found} instead of {expected}");
                }
            }
        }
    }

    /// Four pixels in a row, 0 to 3.
    fn row(wrap: Wrap, filter: Filter) -> ImageTexture {
        let texels = Texels::Floats((0..4).map(|i| [i as f32; 3]).collect());
        let image = Arc::new(Image { width: 4, height: 1, texels });
        ImageTexture { wrap: [wrap, Wrap::Repeat], filter, ..ImageTexture::new(image) }
    }

    #[test]
    fn pictures_repeat_are_mirrored_or_end() {
        let places = [-0.9, -0.4, -0.1, 0.1, 0.3, 0.6, 0.9, 1.1, 1.4, 1.9, 2.1, 2.6];
        for (wrap, expected) in [
            (Wrap::Repeat, [0.0, 2.0, 3.0, 0.0, 1.0, 2.0, 3.0, 0.0, 1.0, 3.0, 0.0, 2.0]),
            (Wrap::Mirror, [3.0, 1.0, 0.0, 0.0, 1.0, 2.0, 3.0, 3.0, 2.0, 0.0, 0.0, 2.0]),
            (Wrap::Clamp, [0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 3.0, 3.0, 3.0, 3.0, 3.0, 3.0]),
        ] {
            let texture = row(wrap, Filter::Nearest);
            let found = places.map(|u| texture.at(Vec2::new(u, 0.5)).x);
            assert_eq!(found, expected, "{wrap:?}");
        }
        // Halfway between the last pixel and what comes next; and the mirrored row, which changes little there.
        for (wrap, at_the_end, beyond) in [(Wrap::Repeat, 1.5, 0.5), (Wrap::Mirror, 3.0, 2.5), (Wrap::Clamp, 3.0, 3.0)]
        {
            let texture = row(wrap, Filter::Linear);
            let found = [1.0, 1.25].map(|u| texture.at(Vec2::new(u, 0.5)).x);
            assert_eq!(found, [at_the_end, beyond], "{wrap:?}");
        }
    }

    #[test]
    fn along_v_a_mirrored_picture_turns_at_whole_numbers_too() {
        let image = two_by_two();
        let mirrored = ImageTexture { wrap: [Wrap::Repeat, Wrap::Mirror], ..ImageTexture::new(image) };
        let red = |v: f32| mirrored.at(Vec2::new(0.25, v)).truncate().to_array() == [1.0, 0.0, 0.0];
        for (v, expected) in [(0.75, true), (0.25, false), (1.25, true), (1.75, false), (-0.25, false), (-0.75, true)] {
            assert_eq!(red(v), expected, "{v}");
        }
    }

    #[test]
    fn transforms_come_before_the_wrap() {
        // A quarter turn and a shift: u' = v + 0.25, v' = 0.5 - u.
        let transform = UvTransform { rows: [[0.0, 1.0, 0.25], [-1.0, 0.0, 0.5]] };
        let turned = ImageTexture { transform, filter: Filter::Nearest, ..ImageTexture::new(two_by_two()) };
        for (u, v, expected) in [
            (0.75, 0.0, [1.0, 0.0, 0.0]),
            (0.75, 0.5, [0.0, 1.0, 0.0]),
            (0.25, 0.0, [0.0, 0.0, 1.0]),
            (0.25, 0.5, [1.0, 1.0, 1.0]),
        ] {
            assert_eq!(turned.at(Vec2::new(u, v)).truncate().to_array(), expected, "({u}, {v})");
        }
    }

    #[test]
    fn bytes_and_words_are_decoded_and_alpha_is_linear() {
        let bytes = Image { width: 1, height: 1, texels: Texels::Bytes(vec![[0, 128, 255, 51]]) };
        let words = Image { width: 1, height: 1, texels: Texels::Words(vec![[0, 32896, 65535, 13107]]) };
        for image in [bytes, words] {
            // 0x80 and 0x8080 are 128/255: 21.586 % by the curve of sRGB.
            for (encoding, middle) in [(Encoding::Srgb, 0.215_861), (Encoding::Linear, 128.0 / 255.0)] {
                let found = image.texel(0, encoding);
                let expected = Vec4::new(0.0, middle, 1.0, 0.2);
                assert!(found.abs_diff_eq(expected, 1e-6), "{encoding:?}: {found} instead of {expected}");
            }
        }
    }
}
