//! The built-in denoiser: a filter that keeps edges, for pictures of few samples.
//!
//! The picture less the color of the first surfaces is averaged over neighborhoods that grow from round to round (the à-trous
//! wavelets of H. Dammertz et al., *Edge-Avoiding À-Trous Wavelet Transform for fast Global Illumination Filtering*, HPG 2010). A
//! neighbor counts as far as its normal, its depth, its albedo and its coverage are the pixel's, and its light is the pixel's within a few standard
//! errors, which sink from round to round as C. Schied et al. have it (*Spatiotemporal Variance-Guided Filtering*, HPG 2017). Then the
//! color of the surfaces comes back, so that textures stay sharp.
//!
//! It is no oracle: what has few samples and looks like noise goes with the noise. That is fine detail which the first surface does not
//! show, in mirrors, in shadows and behind glass, of less contrast than some standard errors. It makes no light and loses little, since neighbors are averaged;
//! the picture's mean changes by less than the noise does. A picture without noise stays as it is. It depends on the film's layers alone,
//! not on the number of threads.

use brewster_lanes::math;

use crate::{Layers, LightLayersView};

/// Rounds: the last one looks 2⁴ pixels to either side, twice.
const ROUNDS: u32 = 5;

/// How many standard errors two pixels of the same light may differ by: at that the weight of a neighbor is 1/e.
const ERRORS: f32 = 3.0;

/// Binomial weights of the neighbors at distances of 0, 1 and 2 steps.
const KERNEL: [f32; 3] = [0.375, 0.25, 0.0625];

/// What is added to albedos before light is divided by them.
const DARK: f32 = 0.02;

/// One pixel while it is filtered: light by channel, less the color of the surface, and the squared standard error of its mean over the channels.
#[derive(Clone, Copy)]
struct Filtered {
    light: [f32; 3],
    variance: f32,
}

/// What does not change from round to round.
#[derive(Clone, Copy)]
struct Guide {
    normal: [f32; 3],
    depth: f32,
    /// By how much depth changes from pixel to pixel, across and down.
    slope: [f32; 2],
    albedo: [f32; 3],
    alpha: f32,
}

/// The rows of a picture.
#[derive(Clone, Copy)]
struct Grid {
    width: usize,
    height: usize,
}

impl Layers {
    /// Takes noise out of the color; other layers stay. Needs the standard errors and the albedo, which a film keeps if it is told to
    /// ([`Keep::ALL`](crate::Keep::ALL)); without them nothing changes. Takes 80 bytes a pixel, on some threads.
    pub fn denoise(&mut self, threads: usize) {
        let (Some(errors), Some(light)) = (&self.errors, &self.light) else { return };
        let grid = Grid { width: self.window.width as usize, height: self.window.height as usize };
        let guides = self.guides(grid, light.view());
        let pixels = self.pixels.view();
        let first = |at: usize| {
            let Guide { albedo, .. } = guides[at];
            let divide = |values: [f32; 3]| std::array::from_fn(|c| values[c] / (albedo[c] + DARK));
            // Channels err together, as far as anybody knows.
            let error = mean(divide(errors[at]));
            Filtered { light: divide(pixels.color[at]), variance: if error.is_finite() { error * error } else { 1e12 } }
        };
        let mut picture: Vec<Filtered> = (0..guides.len()).map(first).collect();
        for round in 0..ROUNDS {
            let before = picture.clone();
            grid.fill(threads, &mut picture, |x, y| filter(grid, &guides, &before, [x, y], 1 << round));
        }
        let color = self.pixels.view_mut().color;
        for (at, color) in color.iter_mut().enumerate() {
            *color = std::array::from_fn(|c| picture[at].light[c] * (guides[at].albedo[c] + DARK));
        }
    }

    fn guides(&self, grid: Grid, light: LightLayersView<'_>) -> Vec<Guide> {
        let pixels = self.pixels.view();
        let depth = |x: usize, y: usize| pixels.depth[y * grid.width + x];
        // The smaller of both differences: the other may cross an edge.
        let smaller = |here: f32, before: Option<f32>, after: Option<f32>| {
            let differences = [before, after].into_iter().flatten().map(|there| (there - here).abs());
            differences.filter(|difference| difference.is_finite()).fold(f32::INFINITY, f32::min)
        };
        let guide = |at: usize| {
            let (x, y) = (at % grid.width, at / grid.width);
            let here = depth(x, y);
            let across =
                smaller(here, x.checked_sub(1).map(|x| depth(x, y)), (x + 1 < grid.width).then(|| depth(x + 1, y)));
            let down =
                smaller(here, y.checked_sub(1).map(|y| depth(x, y)), (y + 1 < grid.height).then(|| depth(x, y + 1)));
            let slope = [across, down].map(|slope| if slope.is_finite() { slope } else { 0.0 });
            let normal = pixels.normal[at];
            let length = dot(normal, normal).sqrt();
            let normal = if length > 0.0 { normal.map(|value| value / length) } else { normal };
            Guide { normal, depth: here, slope, albedo: light.albedo[at], alpha: pixels.alpha[at] }
        };
        (0..grid.width * grid.height).map(guide).collect()
    }
}

/// One pixel of the next round.
fn filter(grid: Grid, guides: &[Guide], before: &[Filtered], place: [usize; 2], step: usize) -> Filtered {
    let at = place[1] * grid.width + place[0];
    let (guide, own) = (&guides[at], &before[at]);
    let level = mean(own.light);
    // A variance is as uncertain as what it is of: that of the neighborhood.
    let noise = ERRORS * grid.around(place, |at| before[at].variance).sqrt() + 1e-4 * level;
    let (mut light, mut variance, mut sum) = ([0.0; 3], 0.0, 0.0);
    for (dy, row) in grid.steps(place[1], grid.height, step) {
        for (dx, column) in grid.steps(place[0], grid.width, step) {
            let other = row * grid.width + column;
            let there = &before[other];
            let kernel = KERNEL[dx.unsigned_abs()] * KERNEL[dy.unsigned_abs()];
            let away = [dx, dy].map(|steps| (steps.unsigned_abs() * step) as f32);
            let weight = match other == at {
                true => kernel,
                false => {
                    let differs = (mean(there.light) - level).abs() / noise.max(f32::MIN_POSITIVE);
                    kernel * guide.likeness(&guides[other], away) * math::exp(-differs)
                }
            };
            for (sum, value) in light.iter_mut().zip(there.light) {
                *sum += weight * value;
            }
            variance += weight * weight * there.variance;
            sum += weight;
        }
    }
    Filtered { light: light.map(|value| value / sum), variance: variance / (sum * sum) }
}

impl Guide {
    /// How much a neighbor shows the same surface, 0 to 1.
    #[inline]
    fn likeness(&self, other: &Guide, away: [f32; 2]) -> f32 {
        if (self.alpha > 0.0) != (other.alpha > 0.0) {
            return 0.0;
        }
        let facing = dot(self.normal, other.normal).clamp(0.0, 1.0);
        let bent = if self.alpha > 0.0 { (1.0 - facing) * 40.0 } else { 0.0 };
        let expected = self.slope[0] * away[0] + self.slope[1] * away[1] + 0.002 * self.depth;
        let deeper = match self.depth.is_finite() && other.depth.is_finite() {
            true => (self.depth - other.depth).abs() / expected.max(f32::MIN_POSITIVE),
            false => 0.0,
        };
        let albedo: f32 = (0..3).map(|c| (self.albedo[c] - other.albedo[c]).abs()).sum();
        math::exp(-(bent + deeper + 4.0 * albedo + 8.0 * (self.alpha - other.alpha).abs()))
    }
}

impl Grid {
    /// Steps to either side that stay on the grid, and where they lead.
    fn steps(self, from: usize, size: usize, step: usize) -> impl Iterator<Item = (isize, usize)> {
        (-2..=2isize).filter_map(move |steps| {
            let to = from.checked_add_signed(steps * step as isize)?;
            (to < size).then_some((steps, to))
        })
    }

    /// The mean over the pixel and its eight neighbors, by how near they are.
    fn around(self, [x, y]: [usize; 2], value: impl Fn(usize) -> f32) -> f32 {
        let (mut sum, mut weights) = (0.0, 0.0);
        for row in y.saturating_sub(1)..(y + 2).min(self.height) {
            for column in x.saturating_sub(1)..(x + 2).min(self.width) {
                let weight = if row == y { 2.0 } else { 1.0 } * if column == x { 2.0 } else { 1.0 };
                sum += weight * value(row * self.width + column);
                weights += weight;
            }
        }
        sum / weights
    }

    /// Computes all pixels, runs of rows on threads of their own.
    fn fill(self, threads: usize, out: &mut [Filtered], pixel: impl Fn(usize, usize) -> Filtered + Sync) {
        let rows = self.height.div_ceil(threads.max(1)).max(1);
        let pixel = &pixel;
        std::thread::scope(|scope| {
            for (part, run) in out.chunks_mut((rows * self.width).max(1)).enumerate() {
                scope.spawn(move || {
                    for (at, filtered) in run.iter_mut().enumerate() {
                        *filtered = pixel(at % self.width, part * rows + at / self.width);
                    }
                });
            }
        });
    }
}

fn mean([r, g, b]: [f32; 3]) -> f32 {
    (r + g + b) * (1.0 / 3.0)
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Film, FirstHit, Keep, Light, Part, PixelOrder};

    const SIDE: u32 = 32;

    /// A wall of a checkered color whose left half is lit by 1 and whose right half, turned another way, by 0.25; `noise` is what
    /// samples are off by, up or down.
    fn film(samples: u32, noise: f32) -> Film {
        let order = PixelOrder::new(SIDE, SIDE, None).expect("a small picture");
        let mut film = Film::keeping(order, Keep::ALL);
        let mut tile = film.tile_mut();
        let mut state = 1u64;
        for (x, y) in (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (x, y))) {
            let pixel = order.index(x, y).expect("it is in the picture");
            let (albedo, light, normal) = truth(x, y);
            for sample in 0..samples {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                let random = (state >> 40) as f32 / (1u64 << 24) as f32 - 0.5;
                let value = albedo * light * (1.0 + noise * 2.0 * random);
                let radiance = Light::new([value; 3]).expect("it is light");
                tile.add_sample(pixel, radiance);
                tile.add_part(pixel, Part::Reflection, radiance);
                let hit = FirstHit { depth: 2.0, normal, albedo: [albedo; 3], material: 0, entity: 0 };
                tile.add_first_hit(pixel, sample, hit);
            }
        }
        film
    }

    fn truth(x: u32, y: u32) -> (f32, f32, [f32; 3]) {
        let albedo = if (x / 2 + y / 2).is_multiple_of(2) { 0.8 } else { 0.2 };
        if x < SIDE / 2 { (albedo, 1.0, [0.0, 0.0, 1.0]) } else { (albedo, 0.25, [1.0, 0.0, 0.0]) }
    }

    /// The root of the mean square difference from the truth.
    fn error(layers: &Layers) -> f64 {
        let pixels = layers.pixels.view();
        let squares = pixels.color.iter().enumerate().map(|(at, color)| {
            let (albedo, light, _) = truth(at as u32 % SIDE, at as u32 / SIDE);
            f64::from(color[1] - albedo * light).powi(2)
        });
        (squares.sum::<f64>() / pixels.color.len() as f64).sqrt()
    }

    #[test]
    fn noise_goes_and_edges_and_textures_stay() {
        let mut layers = film(4, 1.0).resolve();
        let before = error(&layers);
        layers.denoise(2);
        let after = error(&layers);
        // An average over as many pixels as a round of 5 by 5 sees would take a fifth.
        assert!(after < 0.2 * before, "{before} {after}");
        // Where both edges meet nothing has run over.
        let color = |x: u32| layers.pixels.view().color[(8 * SIDE + x) as usize][1];
        for x in [SIDE / 2 - 1, SIDE / 2] {
            let (albedo, light, _) = truth(x, 8);
            assert!((color(x) / (albedo * light) - 1.0).abs() < 0.15, "{x}: {} {}", color(x), albedo * light);
        }
    }

    #[test]
    fn the_mean_stays_and_threads_do_not_matter() {
        let noisy = film(8, 0.7).resolve();
        let mean = |layers: &Layers| layers.pixels.view().color.iter().map(|color| f64::from(color[0])).sum::<f64>();
        let denoised = [1, 3, 64].map(|threads| {
            let mut layers = noisy.clone();
            layers.denoise(threads);
            layers
        });
        assert!((mean(&denoised[0]) / mean(&noisy) - 1.0).abs() < 5e-3);
        assert!(denoised[0] == denoised[1] && denoised[0] == denoised[2]);
    }

    #[test]
    fn what_has_no_noise_or_no_guides_stays() {
        let mut quiet = film(2, 0.0).resolve();
        let before = error(&quiet);
        quiet.denoise(1);
        assert!(before < 1e-6 && error(&quiet) < 1e-4, "{}", error(&quiet));
        let order = PixelOrder::new(2, 1, None).expect("a small picture");
        let mut bare = Film::new(order).resolve();
        let same = bare.clone();
        bare.denoise(1);
        assert_eq!(bare, same);
    }

    /// One sample has no standard error, and an empty picture no light: all of it stays a number.
    #[test]
    fn single_samples_are_averaged_and_emptiness_stays_black() {
        let mut single = film(1, 1.0).resolve();
        let before = error(&single);
        single.denoise(1);
        assert!(error(&single) < 0.5 * before, "{} {before}", error(&single));
        let order = PixelOrder::new(3, 3, None).expect("a small picture");
        let mut empty = Film::keeping(order, Keep::ALL).resolve();
        empty.denoise(2);
        assert!(empty.pixels.view().color.iter().all(|color| *color == [0.0; 3]));
    }
}
