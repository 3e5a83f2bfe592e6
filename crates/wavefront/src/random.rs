//! Random numbers, keyed by (seed, pixel, sample, branch, dimension) and by nothing else: whoever asks, whenever, gets
//! the same.
//!
//! A [`Sampler`] turns a pixel, a sample and a branch into a [`Stream`], two words that a ray may carry, and a stream and a
//! [`Dimension`] into one, two or four numbers that belong together:
//!
//! | decision | numbers | what it decides |
//! | --- | --- | --- |
//! | [`Decision::Camera`] | pair, or four with a lens | place in the pixel filter; then the place on the lens |
//! | [`Decision::Time`] | one | moment of the shutter's time |
//! | [`Decision::Wavelength`] | one | hero wavelength or channel |
//! | [`Decision::Lobe`] | one | lobe of a material; reflection or transmission |
//! | [`Decision::Direction`] | pair | direction within the lobe, or of scattering in a medium |
//! | [`Decision::Light`] | one | which light |
//! | [`Decision::LightPoint`] | pair | place on the light, or direction toward the environment |
//! | [`Decision::Roulette`] | one | whether the path goes on |
//! | [`Decision::Distance`] | pair | channel and distance of a free flight in a medium |
//! | [`Decision::Crossing`] | one | whether a partly transparent surface is met; which of two mixed materials |
//! | [`Decision::Audit`] | four without relation | which hits the ledger asks, and what: no picture depends on it |
//!
//! The camera's decisions are taken at depth 0, the others once a depth; what is decided several times at one depth
//! (crossings, media one after the other, more than one light sample) numbers its [repeats](Dimension::repeat).
//!
//! # Sobol points in screen-space order
//!
//! All pixels share one sequence for each dimension: the Z-order curve through the picture cuts the sequence into blocks of
//! 2ᵏ points, one block for each pixel (Ahmed and Wonka 2020, "Screen-space blue-noise diffusion of Monte Carlo sampling
//! error via hierarchical ordering of pixels"). The points are the first two Sobol dimensions, a (0,2)-sequence, or the
//! first four, and are Owen-scrambled. The order of the blocks, and of the samples in a block, is shuffled as a tree for each
//! dimension anew, so that dimensions are independent of each other. As any aligned run of 2ᵐ points is a net, so are the
//! samples of a pixel, their first 2ᵐ, and those of any aligned square of pixels together: neighbors make up for each
//! other's errors, and what noise remains is of high frequency (a smooth function at one sample a pixel keeps a tenth of white
//! noise's power at wavelengths from 16 pixels on).
//!
//! - Nothing is looked up: the second Sobol matrix is Pascal's triangle, five steps of shift and exclusive or; the third and
//!   fourth are 32 words each, made by the compiler; the tree permutation is a hash. (The crate `sobol_burley` ends at 65,536
//!   points, less than a picture has pixels.)
//! - An index has 32 bits. Pixels beyond the square that fits, and samples beyond 2ᵏ, take part in the key: the sequence is
//!   reseeded there. Depths and dimensions have no end.
//! - Integers only; a number is the upper 24 bits of a word, times 2⁻²⁴: 1 is never reached.

mod sobol;

pub use brewster_buffers::SamplerKind;
use brewster_lanes::{columns, dispatch};

use self::sobol::{SOBOL_3, SOBOL_4, pascal, permuted, product, scrambled};

/// A pixel's place on the Z-order curve: bits of x and y in turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct PixelKey(u32);

impl PixelKey {
    /// The key of the pixel at (0, 0).
    pub const ORIGIN: PixelKey = PixelKey(0);

    /// The key of a pixel of the picture; coordinates are below 65,536.
    #[inline(always)]
    pub fn new(x: u32, y: u32) -> PixelKey {
        PixelKey(spread_bits(x) | spread_bits(y) << 1)
    }

    /// The pixel's place (x, y) in the picture.
    pub fn place(self) -> (u32, u32) {
        let every_other = |bits: u32| (0..16).fold(0, |place, bit| place | (bits >> (2 * bit) & 1) << bit);
        (every_other(self.0), every_other(self.0 >> 1))
    }
}

/// What a number decides: the table at the head of the [module](self).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
#[expect(missing_docs, reason = "the module's table documents them side by side")]
pub enum Decision {
    Camera,
    Time,
    Wavelength,
    Lobe,
    Direction,
    Light,
    LightPoint,
    Roulette,
    Distance,
    Crossing = 10,
    Audit,
}

impl Decision {
    /// The dimension of this decision at a depth below 65,536.
    #[inline(always)]
    pub const fn at(self, depth: u32) -> Dimension {
        Dimension(depth << 4 | self as u32)
    }
}

/// A block of up to four numbers, independent of every other block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dimension(u32);

impl Dimension {
    /// The same decision taken again at one depth; 0 is the first time, up to 4095.
    #[inline(always)]
    pub const fn repeat(self, number: u32) -> Dimension {
        Dimension(self.0 ^ number << 20)
    }
}

columns! {
    /// The random numbers of one branch of one sample of a pixel; only the sampler that made it can read it.
    pub struct Stream => StreamColumns, StreamsView, StreamsViewMut {
        /// The place in the sequence.
        pub index: u32,
        /// Which sequence.
        pub key: u32,
    }
}

/// A source of random numbers in 0 ≤ u < 1; plain data, free to copy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sampler {
    kind: SamplerKind,
    seed: [u32; 2],
    /// Bits of an index that count samples; the others count pixels along the curve.
    sample_bits: u32,
    /// The bits of a reversed index that come from the pixel's y.
    rows: u32,
}

impl Sampler {
    /// A sampler for about `samples` samples a pixel. A power of two gets the most of the screen-space order; samples beyond
    /// the next power of two are drawn from new sequences.
    pub const fn new(kind: SamplerKind, seed: u64, samples: u32) -> Sampler {
        let sample_bits = match samples {
            0 | 1 => 0,
            _ => (samples - 1).ilog2() + 1,
        };
        // Eight pixels by eight remain in any case.
        let sample_bits = if sample_bits < 26 { sample_bits } else { 26 };
        let rows = 0x5555_5555 << (sample_bits & 1) >> sample_bits;
        let seed = mix_wide(seed);
        Sampler { kind, seed: [seed as u32, (seed >> 32) as u32], sample_bits, rows }
    }

    /// The numbers of a branch of a sample of a pixel. A path that never splits stays branch 1.
    #[inline(always)]
    pub fn stream(&self, pixel: PixelKey, sample: u32, branch: u32) -> Stream {
        let (index, tile, round) = match self.kind {
            SamplerKind::Sobol => {
                let pixel_bits = (32 - self.sample_bits) & !1;
                let in_round = sample & ((1 << self.sample_bits) - 1);
                let tile = (u64::from(pixel.0) >> pixel_bits) as u32;
                let index = (pixel.0 << self.sample_bits | in_round).reverse_bits();
                (index, tile, sample >> self.sample_bits)
            }
            SamplerKind::Independent => (mix(pixel.0), 0, sample),
        };
        let key = mix(mix(mix(self.seed[0] ^ tile).wrapping_add(self.seed[1]) ^ round).wrapping_add(branch));
        Stream { index, key }
    }

    /// One number.
    #[inline(always)]
    pub fn one(&self, stream: Stream, dimension: Dimension) -> f32 {
        unit(match self.kind {
            SamplerKind::Sobol => {
                let (index, key) = self.shuffled(stream, dimension);
                scrambled(index, key, 0)
            }
            SamplerKind::Independent => independent(stream, dimension)[0],
        })
    }

    /// Two numbers that fill the square evenly; the first is that of [`one`](Self::one).
    #[inline(always)]
    pub fn pair(&self, stream: Stream, dimension: Dimension) -> [f32; 2] {
        match self.kind {
            SamplerKind::Sobol => {
                let (index, key) = self.shuffled(stream, dimension);
                [scrambled(index, key, 0), scrambled(pascal(index), key, 1)].map(unit)
            }
            SamplerKind::Independent => {
                let [a, b, ..] = independent(stream, dimension);
                [a, b].map(unit)
            }
        }
    }

    /// Four numbers that fill the hypercube evenly; the first two are those of [`pair`](Self::pair).
    ///
    /// Two pairs leave what they do together to chance; for a smooth function of all four numbers, 64 samples have a
    /// third of the error of two pairs, 1024 a tenth.
    #[inline(always)]
    pub fn four(&self, stream: Stream, dimension: Dimension) -> [f32; 4] {
        match self.kind {
            SamplerKind::Sobol => {
                let (index, key) = self.shuffled(stream, dimension);
                let sobol = [index, pascal(index), product(&SOBOL_3, index), product(&SOBOL_4, index)];
                std::array::from_fn(|i| unit(scrambled(sobol[i], key, i as u32)))
            }
            SamplerKind::Independent => independent(stream, dimension).map(unit),
        }
    }

    /// One number without relation to any other, for what is decided once or not at all wherever a few words say: evenly spread it is
    /// not.
    #[inline]
    pub fn scattered(&self, stream: Stream, dimension: Dimension, words: [u32; 3]) -> f32 {
        let key = words.into_iter().fold(stream.key, |key, word| mix(key.wrapping_add(word)));
        self.strewn(Stream { index: stream.index, key }, dimension)[0]
    }

    /// Four numbers without relation to any other or to each other, whatever the kind of sampler: for what is judged by the laws of
    /// chance.
    #[inline]
    pub fn strewn(&self, stream: Stream, dimension: Dimension) -> [f32; 4] {
        independent(stream, dimension).map(unit)
    }

    /// The stream's place in the dimension's order of pixels and samples, and the dimension's key.
    ///
    /// Whether the rows or the columns of a square of four pixels stay together is drawn for each size of square: a fixed
    /// choice leaves up to twice as much low-frequency noise along one axis as along the other.
    #[inline(always)]
    fn shuffled(&self, stream: Stream, dimension: Dimension) -> (u32, u32) {
        let key = mix(stream.key ^ dimension.0.wrapping_mul(0x9e37_79b9));
        let differ = (stream.index ^ stream.index >> 1) & key & self.rows;
        let index = stream.index ^ differ ^ differ << 1;
        (permuted(index, key).reverse_bits(), key)
    }
}

dispatch! {
    /// [`Sampler::one`] of every stream.
    pub fn ones(sampler: &Sampler, streams: StreamsView<'_>, dimension: Dimension, out: &mut [f32]) {
        let sampler = *sampler;
        for ((&index, &key), out) in streams.index.iter().zip(streams.key).zip(out) {
            *out = sampler.one(Stream { index, key }, dimension);
        }
    }

    /// [`Sampler::pair`] of every stream.
    pub fn pairs(
        sampler: &Sampler,
        streams: StreamsView<'_>,
        dimension: Dimension,
        first: &mut [f32],
        second: &mut [f32],
    ) {
        let sampler = *sampler;
        for (((&index, &key), first), second) in streams.index.iter().zip(streams.key).zip(first).zip(second) {
            [*first, *second] = sampler.pair(Stream { index, key }, dimension);
        }
    }
}

/// A word as a number in 0 ≤ u < 1.
#[inline(always)]
fn unit(word: u32) -> f32 {
    // The detour through i32 has an instruction on every level.
    (word >> 8) as i32 as f32 * (1.0 / 16_777_216.0)
}

/// Four words without relation to any others' (Jarzynski and Olano 2020, "Hash functions for GPU rendering", pcg4d).
#[inline(always)]
fn independent(stream: Stream, dimension: Dimension) -> [u32; 4] {
    let step = |word: u32| word.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    let [mut x, mut y, mut z, mut w] = [stream.index, stream.key, dimension.0, 0].map(step);
    for round in 0..2 {
        x = x.wrapping_add(y.wrapping_mul(w));
        y = y.wrapping_add(z.wrapping_mul(x));
        z = z.wrapping_add(x.wrapping_mul(y));
        w = w.wrapping_add(y.wrapping_mul(z));
        if round == 0 {
            [x, y, z, w] = [x, y, z, w].map(|word| word ^ word >> 16);
        }
    }
    [x, y, z, w]
}

/// Spreads the bits of a word over all of it, one to one (Wellons 2018, "Prospecting for hash functions").
#[inline(always)]
const fn mix(x: u32) -> u32 {
    let x = (x ^ x >> 16).wrapping_mul(0x21f0_aaad);
    let x = (x ^ x >> 15).wrapping_mul(0x735a_2d97);
    x ^ x >> 15
}

/// The same for two words (Steele, Lea and Flood 2014, SplitMix64).
const fn mix_wide(x: u64) -> u64 {
    let x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let x = (x ^ x >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ x >> 31
}

/// Moves bit i of the lower 16 to place 2i.
#[inline(always)]
fn spread_bits(x: u32) -> u32 {
    let x = x & 0xffff;
    let x = (x | x << 8) & 0x00ff_00ff;
    let x = (x | x << 4) & 0x0f0f_0f0f;
    let x = (x | x << 2) & 0x3333_3333;
    (x | x << 1) & 0x5555_5555
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use brewster_lanes::Level;

    use super::*;

    const KINDS: [SamplerKind; 2] = [SamplerKind::Sobol, SamplerKind::Independent];

    /// Blocks of one pixel that differ in one thing each.
    fn blocks(sampler: &Sampler) -> Vec<(PixelKey, u32, Dimension)> {
        let (pixel, dimension) = (PixelKey::new(37, 1201), Decision::Direction.at(3));
        assert_eq!(sampler.sample_bits, 8, "the tests below count on 256 samples");
        vec![
            (pixel, 1, dimension),
            (PixelKey::new(0, 0), 1, dimension),
            (PixelKey::new(65_535, 65_535), 1, dimension),
            (pixel, 2, dimension),
            (pixel, 0xffff_ffff, dimension),
            (pixel, 1, Decision::Camera.at(0)),
            (pixel, 1, Decision::Direction.at(65_535)),
            (pixel, 1, dimension.repeat(4095)),
        ]
    }

    /// How many points lie in each box of a grid with 2^sides[i] cells along dimension i.
    fn count<const N: usize>(points: &[[f32; N]], sides: [u32; N]) -> Vec<u32> {
        let mut counts = vec![0; 1 << sides.iter().sum::<u32>()];
        for point in points {
            let cell =
                point.iter().zip(sides).fold(0, |cell, (&x, side)| cell << side | (x * (1u32 << side) as f32) as usize);
            counts[cell] += 1;
        }
        counts
    }

    #[test]
    fn keys_tell_their_place() {
        for place in [(0, 0), (1, 0), (0, 1), (5, 9), (65_535, 12_345), (40_000, 65_535)] {
            assert_eq!(PixelKey::new(place.0, place.1).place(), place);
        }
    }

    #[test]
    fn a_pair_is_a_net_in_a_pixel_and_in_a_square_of_pixels() {
        let check = |points: &[[f32; 2]], what: &str| {
            for m in 0..=points.len().ilog2() {
                for side in 0..=m {
                    let counts = count(&points[..1 << m], [side, m - side]);
                    assert!(counts.iter().all(|&count| count == 1), "{what}: 2^{m} points, {side} columns: {counts:?}");
                }
            }
        };
        let sampler = Sampler::new(SamplerKind::Sobol, 7, 256);
        for (pixel, branch, dimension) in blocks(&sampler) {
            let draw = |sample| sampler.pair(sampler.stream(pixel, sample, branch), dimension);
            check(&(0..256).map(draw).collect::<Vec<_>>(), "in a round");
            check(&(512..768).map(draw).collect::<Vec<_>>(), "in a later round");
        }
        let one_each = Sampler::new(SamplerKind::Sobol, 8, 1);
        for size in [2u32, 8, 32] {
            let place = |i: u32| PixelKey::new(5 * size + i % size, 9 * size + i / size);
            let draw = |i| one_each.pair(one_each.stream(place(i), 0, 1), Decision::Light.at(2));
            let points: Vec<_> = (0..size * size).map(draw).collect();
            let m = points.len().ilog2();
            for side in 0..=m {
                assert!(count(&points, [side, m - side]).iter().all(|&count| count == 1), "a square of {size} pixels");
            }
        }
    }

    /// The quality parameter of the first four Sobol dimensions is 0 + 0 + 1 + 2: degrees of the polynomials, less one.
    #[test]
    fn four_numbers_are_a_net_of_quality_3() {
        let sampler = Sampler::new(SamplerKind::Sobol, 7, 256);
        for (pixel, branch, dimension) in blocks(&sampler) {
            let stream = |sample| sampler.stream(pixel, sample, branch);
            let points: Vec<_> = (0..256).map(|sample| sampler.four(stream(sample), dimension)).collect();
            for (a, b, c) in (0..216).map(|i| (i % 6, i / 6 % 6, i / 36)).filter(|(a, b, c)| a + b + c <= 5) {
                let counts = count(&points, [a, b, c, 5 - a - b - c]);
                assert!(counts.iter().all(|&count| count == 8), "{a} {b} {c}: {counts:?}");
            }
            for (sample, [a, b, ..]) in (0..).zip(points) {
                assert_eq!(sampler.pair(stream(sample), dimension), [a, b]);
                assert_eq!(sampler.one(stream(sample), dimension), a);
            }
        }
    }

    #[test]
    fn numbers_stay_below_one() {
        assert_eq!((unit(0), unit(255)), (0.0, 0.0));
        assert_eq!(unit(u32::MAX), 1.0f32.next_down());
    }

    /// Pearson's sum over 16 by 16 cells, less its mean, in standard deviations.
    fn chi_squared(points: &[[f32; 2]]) -> f64 {
        let counts = count(points, [4, 4]);
        let expected = points.len() as f64 / 256.0;
        let sum: f64 = counts.iter().map(|&count| (f64::from(count) - expected).powi(2) / expected).sum();
        (sum - 255.0) / 510f64.sqrt()
    }

    /// Pairs made of two numbers that have nothing in common fill the square like tosses of dice, or better.
    #[test]
    fn keys_that_differ_in_anything_are_independent() {
        let dimension = Decision::Lobe.at(1);
        for kind in KINDS {
            let sampler = Sampler::new(kind, 1, 4);
            let reseeded = Sampler::new(kind, 2, 4);
            let other = |what: u32, x: u32, y: u32, sample: u32| {
                let stream = |branch| sampler.stream(PixelKey::new(x, y), sample, branch);
                match what {
                    0 => sampler.one(stream(1), Decision::Light.at(1)),
                    1 => sampler.one(stream(1), Decision::Lobe.at(2)),
                    2 => sampler.one(stream(1), dimension.repeat(1)),
                    3 => sampler.one(stream(2), dimension),
                    4 => sampler.one(sampler.stream(PixelKey::new(x, y), sample + 4, 1), dimension),
                    5 => sampler.one(sampler.stream(PixelKey::new(x + 32_768, y), sample, 1), dimension),
                    6 => reseeded.one(reseeded.stream(PixelKey::new(x, y), sample, 1), dimension),
                    7 => sampler.pair(stream(1), dimension)[1],
                    8 => sampler.four(stream(1), dimension)[2],
                    _ => sampler.four(stream(1), dimension)[3],
                }
            };
            for what in 0..10 {
                let points: Vec<[f32; 2]> = (0..1 << 16)
                    .map(|i| {
                        let (x, y, sample) = (i & 127, i >> 7 & 127, i >> 14);
                        let stream = sampler.stream(PixelKey::new(x, y), sample, 1);
                        [sampler.one(stream, dimension), other(what, x, y, sample)]
                    })
                    .collect();
                let deviation = chi_squared(&points);
                assert!(deviation < 4.5, "{kind:?}, difference {what}: {deviation} sigma");
                if kind == SamplerKind::Independent {
                    assert!(deviation > -4.5, "difference {what}: {deviation} sigma is too even");
                }
            }
        }
    }

    #[test]
    fn a_change_of_any_part_of_the_key_changes_the_number() {
        for kind in KINDS {
            let number = |seed, (x, y), sample, branch, dimension| {
                let sampler = Sampler::new(kind, seed, 16);
                sampler.one(sampler.stream(PixelKey::new(x, y), sample, branch), dimension).to_bits()
            };
            let dimension = Decision::Lobe.at(1);
            let mut numbers = vec![
                number(0, (3, 4), 5, 1, dimension),
                number(1, (3, 4), 5, 1, dimension),
                number(1 << 63, (3, 4), 5, 1, dimension),
                number(0, (4, 3), 5, 1, dimension),
                number(0, (3 + 32_768, 4), 5, 1, dimension),
                number(0, (3, 4), 6, 1, dimension),
                number(0, (3, 4), 5 + 16, 1, dimension),
                number(0, (3, 4), u32::MAX, 1, dimension),
                number(0, (3, 4), 5, 3, dimension),
                number(0, (3, 4), 5, 1, Decision::Lobe.at(2)),
                number(0, (3, 4), 5, 1, Decision::Roulette.at(1)),
                number(0, (3, 4), 5, 1, dimension.repeat(1)),
            ];
            let count = numbers.len();
            numbers.sort_unstable();
            numbers.dedup();
            assert_eq!(numbers.len(), count, "{kind:?}");
        }
    }

    /// A smooth bump; its integral over the square is the product of two of the error function, by quadrature.
    fn bump([u, v]: [f32; 2]) -> f64 {
        (-6.0 * ((f64::from(u) - 0.4).powi(2) + (f64::from(v) - 0.3).powi(2))).exp()
    }

    fn bump_integral() -> f64 {
        let side = |center: f64| {
            let steps = 10_000;
            (0..steps).map(|i| (-6.0 * ((f64::from(i) + 0.5) / f64::from(steps) - center).powi(2)).exp()).sum::<f64>()
                / f64::from(steps)
        };
        side(0.4) * side(0.3)
    }

    /// The root mean square error of the bump's integral over many pixels of 2^m samples.
    fn error(kind: SamplerKind, m: u32) -> f64 {
        let sampler = Sampler::new(kind, 3, 1 << m);
        let integral = bump_integral();
        let of_pixel = |pixel| {
            let draw = |sample| bump(sampler.pair(sampler.stream(pixel, sample, 1), Decision::LightPoint.at(0)));
            (0..1 << m).map(draw).sum::<f64>() / f64::from(1 << m) - integral
        };
        let pixels = 400;
        ((0..pixels).map(|x| of_pixel(PixelKey::new(x * 7, x)).powi(2)).sum::<f64>() / f64::from(pixels)).sqrt()
    }

    /// Owen 1997: the error of scrambled nets falls as n^-3/2 (log n)^½ where the function is smooth.
    #[test]
    fn smooth_functions_converge_faster_than_chance() {
        let slope = |kind| (error(kind, 10) / error(kind, 4)).log2() / 6.0;
        let (sobol, independent) = (slope(SamplerKind::Sobol), slope(SamplerKind::Independent));
        assert!((-0.55..-0.45).contains(&independent), "{independent}");
        assert!((-1.7..-1.3).contains(&sobol), "{sobol}");
        assert!(error(SamplerKind::Sobol, 10) < 0.02 * error(SamplerKind::Independent, 10));
    }

    /// Errors of the bump at one sample a pixel, over a square of pixels that is aligned with nothing.
    fn error_picture(kind: SamplerKind, seed: u64, size: u32) -> Vec<f64> {
        let (sampler, integral) = (Sampler::new(kind, seed, 1), bump_integral());
        (0..size * size)
            .map(|i| {
                let pixel = PixelKey::new(333 + i % size, 517 + i / size);
                bump(sampler.pair(sampler.stream(pixel, 0, 1), Decision::LightPoint.at(0))) - integral
            })
            .collect()
    }

    /// The mean power of the frequencies of 1 to 4 waves across the picture, over the mean power of all.
    fn low_frequencies(picture: &[f64], size: usize) -> f64 {
        let total: f64 = picture.iter().map(|error| error * error).sum();
        let power = |(kx, ky): (i32, i32)| {
            let (mut re, mut im) = (0.0, 0.0);
            for (i, error) in picture.iter().enumerate() {
                let angle = TAU * (f64::from(kx) * (i % size) as f64 + f64::from(ky) * (i / size) as f64) / size as f64;
                re += error * angle.cos();
                im += error * angle.sin();
            }
            re * re + im * im
        };
        let waves: Vec<_> =
            (0..81).map(|i| (i % 9 - 4, i / 9 - 4)).filter(|&(x, y)| (1..=16).contains(&(x * x + y * y))).collect();
        waves.iter().copied().map(power).sum::<f64>() / (waves.len() as f64 * total)
    }

    #[test]
    fn noise_of_neighbors_is_blue() {
        let seeds = 6;
        let mean = |kind| {
            (0..seeds).map(|seed| low_frequencies(&error_picture(kind, seed, 64), 64)).sum::<f64>() / seeds as f64
        };
        let (sobol, white) = (mean(SamplerKind::Sobol), mean(SamplerKind::Independent));
        assert!((0.8..1.2).contains(&white), "white noise has the same power everywhere: {white}");
        assert!(sobol < 0.15, "low frequencies keep {sobol} of white noise's power");
    }

    #[test]
    fn neighbors_make_up_for_errors_and_strangers_do_not_know_each_other() {
        let (mut variance, mut neighbors, mut strangers) = (0.0, 0.0, 0.0);
        for seed in 0..16 {
            let picture = error_picture(SamplerKind::Sobol, seed, 64);
            for row in picture.chunks_exact(64) {
                for x in 0..32 {
                    variance += row[x] * row[x];
                    neighbors += row[x] * row[x + 1];
                    strangers += row[x] * row[x + 31];
                }
            }
        }
        let (neighbors, strangers) = (neighbors / variance, strangers / variance);
        assert!((-0.5..-0.1).contains(&neighbors), "{neighbors}");
        assert!(strangers.abs() < 0.03, "{strangers}");
    }

    /// The numbers below were drawn once, on x86-64; integer arithmetic holds them on every platform.
    #[test]
    fn numbers_are_the_same_for_ever() {
        let draw = |kind| {
            let sampler = Sampler::new(kind, 42, 100);
            let stream = sampler.stream(PixelKey::new(640, 359), 17, 5);
            sampler.four(stream, Decision::Direction.at(2)).map(|u| (u * 16_777_216.0) as u32)
        };
        assert_eq!(draw(SamplerKind::Sobol), [9789705, 10012170, 5412818, 14897845]);
        assert_eq!(draw(SamplerKind::Independent), [9034876, 14830952, 8561724, 5258624]);
    }

    #[test]
    fn columns_hold_the_same_numbers_at_every_level() {
        for kind in KINDS {
            let sampler = Sampler::new(kind, 9, 8);
            let streams: StreamColumns =
                (0..1000).map(|i| sampler.stream(PixelKey::new(i % 31, i / 31), i % 11, i % 3)).collect();
            let dimension = Decision::Distance.at(7);
            for level in Level::available() {
                let mut columns = [(); 3].map(|()| vec![0f32; streams.len()]);
                let [a, b, c] = &mut columns;
                ones(level, &sampler, streams.view(), dimension, a);
                pairs(level, &sampler, streams.view(), dimension, b, c);
                let rows = (0..streams.len()).map(|i| columns.each_ref().map(|column| column[i]));
                let expected = (0..streams.len()).map(|i| {
                    let [x, y, ..] = sampler.four(streams.get(i), dimension);
                    [x, x, y]
                });
                assert!(rows.eq(expected), "{kind:?}, {level:?}");
            }
        }
    }
}
