//! The film: integer sums per pixel, to which contributions are added in any order.

use brewster_lanes::columns;

use crate::{FilmError, PixelOrder};

/// The id of a pixel whose first sample hit nothing.
pub const NO_ID: u32 = u32::MAX;

/// Units of a color or normal sum in 1: a sum counts in steps of 2^-32 and saturates at 2^31, about 2.1e9.
pub const SCALE: f64 = 4_294_967_296.0;

/// Units of a depth sum in a meter: a sum counts in steps of 2^-24 m (60 nm) and saturates at 2^39 m (5.5e11 m).
pub const DEPTH_SCALE: f64 = 16_777_216.0;

columns! {
    /// What one pixel has gathered. Empty: all zero, without ids ([`Pixel::EMPTY`]).
    pub struct Pixel => PixelColumns, PixelView, PixelViewMut {
        /// Sums of radiance x weight in linear Rec.709, in units of 1 / [`SCALE`] nit; never negative.
        pub color: [i64; 3],
        /// Samples (paths) that the sums stand for.
        pub samples: u32,
        /// Samples whose camera ray hit something; hits / samples is alpha.
        pub hits: u32,
        /// Sum over the hits of the depth from the camera, in units of 1 / [`DEPTH_SCALE`] m; never negative.
        pub depth: i64,
        /// Sums over the hits of the world-space normal, in units of 1 / [`SCALE`].
        pub normal: [i64; 3],
        /// The material that sample 0 hit, or [`NO_ID`].
        pub material: u32,
        /// The entity that sample 0 hit, or [`NO_ID`].
        pub entity: u32,
        /// Rays traced, of every kind.
        pub rays: u32,
        /// Contributions that were not finite or out of range; they are in no sum.
        pub rejected: u32,
    }
}

impl Pixel {
    /// A pixel that has gathered nothing.
    pub const EMPTY: Pixel = Pixel {
        color: [0; 3],
        samples: 0,
        hits: 0,
        depth: 0,
        normal: [0; 3],
        material: NO_ID,
        entity: NO_ID,
        rays: 0,
        rejected: 0,
    };
}

/// What a camera ray hit first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstHit {
    /// Depth from the camera in meters, measured as the tracer sees fit; finite and >= 0.
    pub depth: f32,
    /// Unit normal in world space.
    pub normal: [f32; 3],
    /// The material's id.
    pub material: u32,
    /// The entity's id.
    pub entity: u32,
}

/// The sums of all pixels in a crop window, in [`PixelOrder`].
///
/// Every sum is an integer, so that neither the order of contributions nor the way in which films are split and merged
/// can change a bit of it. A contribution is rounded once, to the nearest step and halfway cases away from zero, by
/// exact arithmetic. Sums saturate; [`Film::saturated`] counts those. A contribution that is NaN, infinite or negative is
/// counted in its pixel (`rejected`) and not added; without negative terms a saturated sum, too, is the same in any order.
///
/// One owner makes tiles ([`Film::tiles_mut`]); each tile is written by one thread, without locks or atomics. A pixel takes
/// 80 bytes.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    order: PixelOrder,
    pub(crate) pixels: PixelColumns,
}

impl Film {
    /// An empty film; takes all its memory at once.
    pub fn new(order: PixelOrder) -> Film {
        let mut pixels = PixelColumns::new();
        pixels.resize(order.len(), Pixel::EMPTY);
        Film { order, pixels }
    }

    /// The order of the pixels.
    pub fn order(&self) -> &PixelOrder {
        &self.order
    }

    /// The sums, in [`PixelOrder`].
    pub fn pixels(&self) -> PixelView<'_> {
        self.pixels.view()
    }

    /// Empties every pixel; keeps the memory.
    pub fn clear(&mut self) {
        self.pixels.clear();
        self.pixels.resize(self.order.len(), Pixel::EMPTY);
    }

    /// The whole film as one tile.
    pub fn tile_mut(&mut self) -> FilmTile<'_> {
        FilmTile { order: self.order, first: 0, pixels: self.pixels.view_mut() }
    }

    /// The film cut into tiles of `pixels_per_tile` consecutive pixels (the last may have fewer; 0 counts as 1), in order.
    pub fn tiles_mut(&mut self, pixels_per_tile: usize) -> Vec<FilmTile<'_>> {
        let pixels_per_tile = pixels_per_tile.max(1);
        let mut tiles = Vec::with_capacity(self.pixels.len().div_ceil(pixels_per_tile));
        let mut rest = self.tile_mut();
        while rest.len() > pixels_per_tile {
            let (tile, after) = rest.split_at(pixels_per_tile);
            tiles.push(tile);
            rest = after;
        }
        tiles.push(rest);
        tiles
    }

    /// Contributions that were not finite or out of range, over all pixels.
    pub fn rejected(&self) -> u64 {
        self.pixels.view().rejected.iter().map(|&count| u64::from(count)).sum()
    }

    /// Sums that stand at their limit: the pixels' colors or depths that are too small by an unknown amount.
    pub fn saturated(&self) -> u64 {
        let pixels = self.pixels.view();
        let colors = pixels.color.as_flattened().iter().filter(|&&sum| sum == i64::MAX).count();
        let depths = pixels.depth.iter().filter(|&&sum| sum == i64::MAX).count();
        (colors + depths) as u64
    }

    /// Adds another film's sums: the result is, to the bit, the film that gathered the contributions of both.
    ///
    /// # Errors
    ///
    /// The films differ in size or crop window.
    pub fn merge(&mut self, other: &Film) -> Result<(), FilmError> {
        crate::merge::merge(self, other)
    }
}

/// Exclusive access to a run of consecutive pixels; pixels are named by their place in the run, from 0 on.
///
/// Methods panic if a pixel lies beyond the run. None allocates.
#[derive(Debug)]
pub struct FilmTile<'a> {
    order: PixelOrder,
    first: u32,
    pixels: PixelViewMut<'a>,
}

impl<'a> FilmTile<'a> {
    /// The number of pixels.
    #[inline]
    pub fn len(&self) -> usize {
        self.pixels.len()
    }

    /// Whether the tile has no pixels.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The index in [`PixelOrder`] of the tile's first pixel.
    #[inline]
    pub fn first(&self) -> u32 {
        self.first
    }

    /// The place (x, y) in the picture of one of the tile's pixels.
    #[inline]
    pub fn pixel(&self, local: u32) -> (u32, u32) {
        self.order.pixel(self.first + local)
    }

    /// The tile's sums.
    #[inline]
    pub fn pixels(&self) -> PixelView<'_> {
        self.pixels.as_view()
    }

    /// The tile's first `middle` pixels and the others.
    pub fn split_at(self, middle: usize) -> (FilmTile<'a>, FilmTile<'a>) {
        let FilmTile { order, first, pixels } = self;
        let (before, after) = pixels.split_at(middle);
        (FilmTile { order, first, pixels: before }, FilmTile { order, first: first + middle as u32, pixels: after })
    }

    /// Adds linear Rec.709 radiance x weight, in nit, each component finite and >= 0; otherwise all of it is rejected.
    #[inline]
    pub fn add(&mut self, local: u32, color: [f32; 3]) {
        let local = local as usize;
        if !color.iter().all(|&value| in_range(value)) {
            return self.reject(local);
        }
        for (sum, value) in self.pixels.color[local].iter_mut().zip(color) {
            *sum = sum.saturating_add(to_fixed(value, SCALE));
        }
    }

    /// Counts one more sample.
    #[inline]
    pub fn add_sample(&mut self, local: u32) {
        let samples = &mut self.pixels.samples[local as usize];
        *samples = samples.saturating_add(1);
    }

    /// Counts rays traced for a pixel.
    #[inline]
    pub fn add_rays(&mut self, local: u32, count: u32) {
        let rays = &mut self.pixels.rays[local as usize];
        *rays = rays.saturating_add(count);
    }

    /// Adds what the camera ray of sample number `sample` hit. Sample 0 gives the pixel its ids.
    ///
    /// A depth that is NaN, infinite or negative, or a normal that is not finite, rejects all of it.
    #[inline]
    pub fn add_first_hit(&mut self, local: u32, sample: u32, hit: FirstHit) {
        let local = local as usize;
        if !in_range(hit.depth) || !hit.normal.iter().all(|value| value.is_finite()) {
            return self.reject(local);
        }
        let hits = &mut self.pixels.hits[local];
        *hits = hits.saturating_add(1);
        let depth = &mut self.pixels.depth[local];
        *depth = depth.saturating_add(to_fixed(hit.depth, DEPTH_SCALE));
        for (sum, value) in self.pixels.normal[local].iter_mut().zip(hit.normal) {
            *sum = sum.saturating_add(to_fixed(value, SCALE));
        }
        if sample == 0 {
            self.pixels.material[local] = hit.material;
            self.pixels.entity[local] = hit.entity;
        }
    }

    #[cold]
    fn reject(&mut self, local: usize) {
        let rejected = &mut self.pixels.rejected[local];
        *rejected = rejected.saturating_add(1);
    }
}

/// Whether a value is finite and not negative; -0 counts as 0.
#[inline(always)]
fn in_range(value: f32) -> bool {
    (0.0..=f32::MAX).contains(&value)
}

/// The nearest multiple of 1 / `scale` (a power of two), halfway cases away from zero; saturates.
///
/// Every step is exact: an f32 times a power of two is an f64, and where adding a half would have to round, the product
/// is an even integer already, to which the sum rounds back.
#[inline(always)]
fn to_fixed(value: f32, scale: f64) -> i64 {
    let scaled = f64::from(value) * scale;
    (scaled + 0.5f64.copysign(scaled)) as i64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rounds to steps of 2^-`bits` by shifting the significand, as one would by hand.
    fn rounded_by_shifting(value: f32, bits: i32) -> i64 {
        let significand = i128::from(value.to_bits() & 0x7f_ffff);
        let exponent = (value.to_bits() >> 23 & 0xff) as i32;
        let (significand, exponent) = if exponent == 0 { (significand, 1) } else { (significand | 1 << 23, exponent) };
        let shift = exponent - 150 + bits;
        let magnitude = match shift {
            64.. => i128::MAX,
            0.. => significand << shift,
            -64..0 => (significand + (1 << (-shift - 1))) >> -shift,
            _ => 0,
        };
        let limit = if value < 0.0 { -i128::from(i64::MIN) } else { i128::from(i64::MAX) };
        let magnitude = magnitude.min(limit);
        (if value < 0.0 { -magnitude } else { magnitude }) as i64
    }

    #[test]
    fn contributions_are_rounded_once_to_the_nearest_step() {
        let step = 1.0 / SCALE as f32;
        let cases = [
            (0.0, 0),
            (1.0, 1 << 32),
            (-1.0, -1 << 32),
            (0.5 * step, 1),
            (-0.5 * step, -1),
            (0.499 * step, 0),
            (2.5 * step, 3),
            (f32::MIN_POSITIVE, 0),
            (2_147_483_520.0, 2_147_483_520 << 32),
            (2_147_483_648.0, i64::MAX),
            (f32::MAX, i64::MAX),
            (f32::MIN, i64::MIN),
        ];
        for (value, expected) in cases {
            assert_eq!(to_fixed(value, SCALE), expected, "{value:e}");
        }
        for i in 0..1 << 16 {
            let value = f32::from_bits((i as u32) << 16 | (i as u32).wrapping_mul(0x9e37) & 0xffff);
            if value.is_finite() {
                assert_eq!(to_fixed(value, SCALE), rounded_by_shifting(value, 32), "{value:e}");
                assert_eq!(to_fixed(value, DEPTH_SCALE), rounded_by_shifting(value, 24), "{value:e}");
            }
        }
    }

    #[test]
    fn bad_contributions_are_counted_and_not_added() {
        let mut film = Film::new(PixelOrder::new(2, 1, None).unwrap());
        let mut tile = film.tile_mut();
        let hit = FirstHit { depth: 1.0, normal: [0.0, 1.0, 0.0], material: 3, entity: 4 };
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0] {
            tile.add(1, [1.0, bad, 1.0]);
            tile.add_first_hit(1, 0, FirstHit { depth: bad, ..hit });
        }
        tile.add_first_hit(1, 0, FirstHit { normal: [f32::NAN, 0.0, 0.0], ..hit });
        assert_eq!(film.pixels().get(0), Pixel::EMPTY);
        assert_eq!(film.pixels().get(1), Pixel { rejected: 9, ..Pixel::EMPTY });
        assert_eq!((film.rejected(), film.saturated()), (9, 0));
    }

    #[test]
    fn sums_saturate_and_are_counted() {
        let mut film = Film::new(PixelOrder::new(1, 1, None).unwrap());
        let mut tile = film.tile_mut();
        for _ in 0..3 {
            tile.add(0, [1.5e9, 1.0, 3.0e9]);
        }
        assert_eq!(film.pixels().get(0).color, [i64::MAX, 3 << 32, i64::MAX]);
        assert_eq!((film.rejected(), film.saturated()), (0, 2));
    }

    #[test]
    fn tiles_are_runs_of_the_order() {
        let order = PixelOrder::new(13, 9, None).unwrap();
        let mut film = Film::new(order);
        for pixels_per_tile in [0, 1, 7, 64, 117, 1000] {
            let mut next = 0;
            for mut tile in film.tiles_mut(pixels_per_tile) {
                assert_eq!(tile.first(), next);
                for local in 0..tile.len() as u32 {
                    assert_eq!(tile.pixel(local), order.pixel(next + local));
                    tile.add_sample(local);
                }
                next += tile.len() as u32;
            }
            assert_eq!(next as usize, order.len());
        }
        assert!(film.pixels().samples.iter().all(|&samples| samples == 6));
        film.clear();
        assert_eq!(film, Film::new(order));
    }

    #[test]
    fn sample_zero_gives_the_ids() {
        let mut film = Film::new(PixelOrder::new(1, 1, None).unwrap());
        let mut tile = film.tile_mut();
        let hit = FirstHit { depth: 2.0, normal: [0.0, 0.0, -1.0], material: 7, entity: 9 };
        tile.add_first_hit(0, 1, FirstHit { material: 1, entity: 2, ..hit });
        assert_eq!((tile.pixels().material[0], tile.pixels().entity[0]), (NO_ID, NO_ID));
        tile.add_first_hit(0, 0, hit);
        tile.add_first_hit(0, 2, FirstHit { material: 0, entity: 0, ..hit });
        tile.add_rays(0, 5);
        let expected = Pixel {
            hits: 3,
            depth: 6 << 24,
            normal: [0, 0, -3 << 32],
            material: 7,
            entity: 9,
            rays: 5,
            ..Pixel::EMPTY
        };
        assert_eq!(film.pixels().get(0), expected);
    }

    #[test]
    fn a_pixel_takes_what_the_page_says() {
        assert_eq!(PixelColumns::BYTES_PER_ROW, 80);
        assert_eq!(crate::MAX_PIXELS * 80, 10 << 30);
    }
}
