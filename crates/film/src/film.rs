//! The film: integer sums per pixel, to which samples are added in any order.

use std::ops::Range;

use brewster_lanes::columns;

use crate::light::{in_range, to_fixed};
use crate::{FilmError, Light, PixelOrder};

/// The id of a pixel whose first sample hit nothing.
pub const NO_ID: u32 = u32::MAX;

/// Units of a color or normal sum in 1: a sum counts in steps of 2^-32 and saturates at 2^31, about 2.1e9.
pub const SCALE: f64 = 4_294_967_296.0;

/// Units of a sum of squares in 1: squares of sums are kept whole, in steps of 2^-64, and saturate at 2^64, about 1.8e19.
pub const SQUARE_SCALE: f64 = SCALE * SCALE;

/// Units of a depth sum in a meter: a sum counts in steps of 2^-24 m (60 nm) and saturates at 2^39 m (5.5e11 m).
pub const DEPTH_SCALE: f64 = 16_777_216.0;

columns! {
    /// What one pixel has gathered. Empty: all zero, without ids ([`Pixel::EMPTY`]).
    pub struct Pixel => PixelColumns, PixelView, PixelViewMut {
        /// Sums of radiance x weight in linear Rec.709, in units of 1 / [`SCALE`] nit; never negative.
        pub color: Light,
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
        color: Light::NONE,
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

columns! {
    /// What tells how far a pixel's samples differ from each other.
    pub struct Squares => SquaresColumns, SquaresView, SquaresViewMut {
        /// Sums over the samples of the square of each one's light, in units of 1 / [`SQUARE_SCALE`]. Neither a firefly of the
        /// greatest sum nor the square of a single step is lost to rounding.
        pub light: [u128; 3],
    }
}

columns! {
    /// What a pixel's light is made of, and what it fell on. The light that is neither reflected nor transmitted by the first
    /// surface is the pixel's color less the two: direct light.
    pub struct Parts => PartsColumns, PartsView, PartsViewMut {
        /// Sums over the hits of the part of the light that the surface sends back or lets through, each 0 to 1.
        pub albedo: Light,
        /// Sums of the light that the first surface reflected.
        pub reflection: Light,
        /// Sums of the light that the first surface transmitted.
        pub transmission: Light,
    }
}

impl Parts {
    const EMPTY: Parts = Parts { albedo: Light::NONE, reflection: Light::NONE, transmission: Light::NONE };
}

/// How light came through the first surface that a camera ray met.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Seen directly: sent out by what the camera sees, or by a light and scattered once.
    Direct,
    /// By way of a ray that the first surface reflected.
    Reflection,
    /// By way of a ray that the first surface transmitted.
    Transmission,
}

/// What a film keeps beside its [`Pixel`]s, at a cost in memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Keep {
    /// [`Squares`], for standard errors: 48 bytes a pixel.
    pub squares: bool,
    /// [`Parts`], for layers of light and albedo: 72 bytes a pixel.
    pub parts: bool,
}

impl Keep {
    /// Everything.
    pub const ALL: Keep = Keep { squares: true, parts: true };
}

/// What a camera ray hit first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstHit {
    /// Depth from the camera in meters, measured as the tracer sees fit; finite and >= 0.
    pub depth: f32,
    /// Unit normal in world space.
    pub normal: [f32; 3],
    /// The part of the light that the surface sends back or lets through; finite and >= 0.
    pub albedo: [f32; 3],
    /// The material's id.
    pub material: u32,
    /// The entity's id.
    pub entity: u32,
}

/// The sums of all pixels in a crop window, in [`PixelOrder`].
///
/// Every sum is an integer, so that neither the order of samples nor the way in which films are split and merged can change
/// a bit of it. A contribution to a sample is rounded once, when it becomes [`Light`]; the samples' sums and squares are exact.
/// Sums saturate; [`Film::saturated`] counts those. A contribution that is NaN, infinite or negative is counted in its pixel
/// (`rejected`) and not added; without negative terms a saturated sum, too, is the same in any order.
///
/// One owner makes tiles ([`Film::tiles_mut`]); each tile is written by one thread, without locks or atomics. A pixel takes
/// 80 bytes, and those of what else the film [keeps](Keep).
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    order: PixelOrder,
    pub(crate) pixels: PixelColumns,
    pub(crate) squares: Option<SquaresColumns>,
    pub(crate) parts: Option<PartsColumns>,
}

impl Film {
    /// An empty film of [`Pixel`]s alone; takes all its memory at once.
    pub fn new(order: PixelOrder) -> Film {
        Film::keeping(order, Keep::default())
    }

    /// An empty film that keeps more; takes all its memory at once.
    pub fn keeping(order: PixelOrder, keep: Keep) -> Film {
        let (squares, parts) = (keep.squares.then(SquaresColumns::new), keep.parts.then(PartsColumns::new));
        let mut film = Film { order, pixels: PixelColumns::new(), squares, parts };
        film.clear();
        film
    }

    /// The order of the pixels.
    pub fn order(&self) -> &PixelOrder {
        &self.order
    }

    /// What the film keeps beside pixels.
    pub fn kept(&self) -> Keep {
        Keep { squares: self.squares.is_some(), parts: self.parts.is_some() }
    }

    /// The sums, in [`PixelOrder`].
    pub fn pixels(&self) -> PixelView<'_> {
        self.pixels.view()
    }

    /// The sums of squares, in [`PixelOrder`], if the film keeps them.
    pub fn squares(&self) -> Option<SquaresView<'_>> {
        self.squares.as_ref().map(SquaresColumns::view)
    }

    /// What the pixels' light is made of, in [`PixelOrder`], if the film keeps it.
    pub fn parts(&self) -> Option<PartsView<'_>> {
        self.parts.as_ref().map(PartsColumns::view)
    }

    /// Empties every pixel; keeps the memory.
    pub fn clear(&mut self) {
        self.pixels.clear();
        self.pixels.resize(self.order.len(), Pixel::EMPTY);
        if let Some(squares) = &mut self.squares {
            squares.clear();
            squares.resize(self.order.len(), Squares { light: [0; 3] });
        }
        if let Some(parts) = &mut self.parts {
            parts.clear();
            parts.resize(self.order.len(), Parts::EMPTY);
        }
    }

    /// The whole film as one tile.
    pub fn tile_mut(&mut self) -> FilmTile<'_> {
        let squares = self.squares.as_mut().map(SquaresColumns::view_mut);
        let parts = self.parts.as_mut().map(PartsColumns::view_mut);
        FilmTile { order: self.order, first: 0, pixels: self.pixels.view_mut(), squares, parts }
    }

    /// The film cut into tiles of `pixels_per_tile` consecutive pixels (the last may have fewer; 0 counts as 1), in order.
    pub fn tiles_mut(&mut self, pixels_per_tile: usize) -> Vec<FilmTile<'_>> {
        let all = 0..self.pixels.len() as u32;
        self.tiles_of(&[all], pixels_per_tile)
    }

    /// The same of some runs of pixels, each behind the one before it.
    ///
    /// # Panics
    ///
    /// Runs overlap, are in another order, or leave the film.
    pub fn tiles_of(&mut self, runs: &[Range<u32>], pixels_per_tile: usize) -> Vec<FilmTile<'_>> {
        let pixels_per_tile = pixels_per_tile.max(1);
        let mut tiles = Vec::with_capacity(runs.iter().map(|run| run.len().div_ceil(pixels_per_tile)).sum());
        let mut rest = self.tile_mut();
        for run in runs {
            let skipped = run.start.checked_sub(rest.first).expect("runs follow each other");
            rest = rest.split_at(skipped as usize).1;
            for start in run.clone().step_by(pixels_per_tile) {
                let (tile, after) = rest.split_at(pixels_per_tile.min((run.end - start) as usize));
                tiles.push(tile);
                rest = after;
            }
        }
        tiles
    }

    /// Contributions that were not finite or out of range, over all pixels.
    pub fn rejected(&self) -> u64 {
        self.pixels.view().rejected.iter().map(|&count| u64::from(count)).sum()
    }

    /// Sums that stand at their limit: the pixels' colors, squares or depths that are too small by an unknown amount.
    pub fn saturated(&self) -> u64 {
        let pixels = self.pixels.view();
        let colors = pixels.color.iter().flat_map(|color| color.0).filter(|&sum| sum == i64::MAX).count();
        let squares = self.squares().map_or(&[][..], |squares| squares.light).as_flattened();
        let squares = squares.iter().filter(|&&sum| sum == u128::MAX).count();
        let depths = pixels.depth.iter().filter(|&&sum| sum == i64::MAX).count();
        (colors + squares + depths) as u64
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
    squares: Option<SquaresViewMut<'a>>,
    parts: Option<PartsViewMut<'a>>,
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
        let FilmTile { order, first, pixels, squares, parts } = self;
        let pixels = pixels.split_at(middle);
        let squares = squares.map(|squares| squares.split_at(middle)).unzip();
        let parts = parts.map(|parts| parts.split_at(middle)).unzip();
        (
            FilmTile { order, first, pixels: pixels.0, squares: squares.0, parts: parts.0 },
            FilmTile { order, first: first + middle as u32, pixels: pixels.1, squares: squares.1, parts: parts.1 },
        )
    }

    /// Adds one more sample: all the light that it found.
    #[inline]
    pub fn add_sample(&mut self, local: u32, light: Light) {
        let local = local as usize;
        let samples = &mut self.pixels.samples[local];
        *samples = samples.saturating_add(1);
        self.pixels.color[local].add(light);
        if let Some(squares) = &mut self.squares {
            for (sum, value) in squares.light[local].iter_mut().zip(light.0) {
                let value = u128::from(value.unsigned_abs());
                *sum = sum.saturating_add(value * value);
            }
        }
    }

    /// Whether the film keeps [`Parts`].
    #[inline]
    pub fn keeps_parts(&self) -> bool {
        self.parts.is_some()
    }

    /// Says of some of a sample's light how it came, if the film keeps that.
    #[inline]
    pub fn add_part(&mut self, local: u32, part: Part, light: Light) {
        let Some(parts) = &mut self.parts else { return };
        match part {
            Part::Direct => {}
            Part::Reflection => parts.reflection[local as usize].add(light),
            Part::Transmission => parts.transmission[local as usize].add(light),
        }
    }

    /// Counts contributions that were no light.
    #[inline]
    pub fn add_rejected(&mut self, local: u32, count: u32) {
        let rejected = &mut self.pixels.rejected[local as usize];
        *rejected = rejected.saturating_add(count);
    }

    /// Counts rays traced for a pixel.
    #[inline]
    pub fn add_rays(&mut self, local: u32, count: u32) {
        let rays = &mut self.pixels.rays[local as usize];
        *rays = rays.saturating_add(count);
    }

    /// Adds what the camera ray of sample number `sample` hit. Sample 0 gives the pixel its ids.
    ///
    /// A depth or an albedo that is NaN, infinite or negative, or a normal that is not finite, rejects all of it.
    #[inline]
    pub fn add_first_hit(&mut self, local: u32, sample: u32, hit: FirstHit) {
        let local = local as usize;
        let albedo = Light::new(hit.albedo).filter(|_| in_range(hit.depth));
        let Some(albedo) = albedo.filter(|_| hit.normal.iter().all(|value| value.is_finite())) else {
            return self.add_rejected(local as u32, 1);
        };
        if let Some(parts) = &mut self.parts {
            parts.albedo[local].add(albedo);
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
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bad_hits_are_counted_and_not_added() {
        let mut film = Film::new(PixelOrder::new(2, 1, None).unwrap());
        let mut tile = film.tile_mut();
        let hit = FirstHit { depth: 1.0, normal: [0.0, 1.0, 0.0], albedo: [0.5; 3], material: 3, entity: 4 };
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0] {
            tile.add_first_hit(1, 0, FirstHit { depth: bad, ..hit });
            tile.add_first_hit(1, 0, FirstHit { albedo: [0.5, 0.5, bad], ..hit });
        }
        tile.add_first_hit(1, 0, FirstHit { normal: [f32::NAN, 0.0, 0.0], ..hit });
        tile.add_rejected(1, 1);
        assert_eq!(film.pixels().get(0), Pixel::EMPTY);
        assert_eq!(film.pixels().get(1), Pixel { rejected: 10, ..Pixel::EMPTY });
        assert_eq!((film.rejected(), film.saturated()), (10, 0));
    }

    #[test]
    fn sums_saturate_and_are_counted() {
        let mut film = Film::new(PixelOrder::new(1, 1, None).unwrap());
        let mut tile = film.tile_mut();
        for _ in 0..3 {
            tile.add_sample(0, Light::new([1.5e9, 1.0, 3.0e9]).unwrap());
        }
        assert_eq!(film.pixels().get(0).color, Light([i64::MAX, 3 << 32, i64::MAX]));
        assert_eq!((film.rejected(), film.saturated()), (0, 2));
    }

    /// Of the least and of the greatest sum, worked out by hand: 1 step squared is 1; 2^31 - 2^-32 squared, less than 2^62,
    /// fits four times below 2^64.
    #[test]
    fn squares_are_kept_whole_and_saturate() {
        let mut film = Film::keeping(PixelOrder::new(2, 1, None).unwrap(), Keep::ALL);
        let mut tile = film.tile_mut();
        let greatest = i64::MAX as u128;
        tile.add_sample(1, Light([1, 3 << 32, i64::MAX]));
        tile.add_sample(1, Light([2, 4 << 32, i64::MAX]));
        let square = film.squares().unwrap().get(1).light;
        assert_eq!(square, [5, 25 << 64, 2 * greatest * greatest]);
        assert_eq!(film.saturated(), 1, "a color");
        (0..3).for_each(|_| film.tile_mut().add_sample(1, Light([0, 0, i64::MAX])));
        assert_eq!(film.squares().unwrap().get(1).light[2], u128::MAX);
        assert_eq!(film.saturated(), 2, "a color and its squares");
        assert_eq!(film.squares().unwrap().get(0).light, [0; 3]);
    }

    #[test]
    fn light_is_kept_by_the_way_it_came() {
        let mut film = Film::keeping(PixelOrder::new(2, 1, None).unwrap(), Keep::ALL);
        let mut tile = film.tile_mut();
        let parts = [(Part::Direct, 1), (Part::Reflection, 2), (Part::Transmission, 4), (Part::Reflection, 8)];
        for (part, steps) in parts {
            tile.add_part(1, part, Light([steps, 0, 100]));
        }
        let hit = FirstHit { depth: 2.0, normal: [0.0; 3], albedo: [0.5, 0.25, 1.0], material: 7, entity: 9 };
        (0..3).for_each(|sample| tile.add_first_hit(1, sample, hit));
        let expected = Parts {
            albedo: Light([3 << 31, 3 << 30, 3 << 32]),
            reflection: Light([10, 0, 200]),
            transmission: Light([4, 0, 100]),
        };
        assert_eq!(film.parts().unwrap().get(1), expected);
        assert_eq!(film.parts().unwrap().get(0), Parts::EMPTY);
        assert!(!Film::new(*film.order()).tile_mut().keeps_parts());
    }

    #[test]
    fn tiles_are_runs_of_the_order() {
        let order = PixelOrder::new(13, 9, None).unwrap();
        let mut film = Film::keeping(order, Keep::ALL);
        for pixels_per_tile in [0, 1, 7, 64, 117, 1000] {
            let mut next = 0;
            for mut tile in film.tiles_mut(pixels_per_tile) {
                assert_eq!(tile.first(), next);
                for local in 0..tile.len() as u32 {
                    assert_eq!(tile.pixel(local), order.pixel(next + local));
                    tile.add_sample(local, Light::NONE);
                }
                next += tile.len() as u32;
            }
            assert_eq!(next as usize, order.len());
        }
        assert!(film.pixels().samples.iter().all(|&samples| samples == 6));
        film.clear();
        assert_eq!(film, Film::keeping(order, Keep::ALL));
    }

    #[test]
    fn tiles_of_runs_leave_the_rest_alone() {
        let mut film = Film::keeping(PixelOrder::new(13, 9, None).unwrap(), Keep::ALL);
        let runs = [3..4, 4..20, 60..117];
        for pixels_per_tile in [1, 7, 1000] {
            for mut tile in film.tiles_of(&runs, pixels_per_tile) {
                assert!(tile.len() <= pixels_per_tile);
                (0..tile.len() as u32).for_each(|local| tile.add_sample(local, Light::NONE));
            }
        }
        for (index, &samples) in (0..).zip(film.pixels().samples) {
            let expected = if runs.iter().any(|run| run.contains(&index)) { 3 } else { 0 };
            assert_eq!(samples, expected, "pixel {index}");
        }
        assert!(film.tiles_of(&[], 5).is_empty());
    }

    #[test]
    fn sample_zero_gives_the_ids() {
        let mut film = Film::new(PixelOrder::new(1, 1, None).unwrap());
        let mut tile = film.tile_mut();
        let hit = FirstHit { depth: 2.0, normal: [0.0, 0.0, -1.0], albedo: [0.5; 3], material: 7, entity: 9 };
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
        assert_eq!((SquaresColumns::BYTES_PER_ROW, PartsColumns::BYTES_PER_ROW), (48, 72));
    }
}
