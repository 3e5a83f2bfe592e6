//! How a scene's picture agrees with one that Mitsuba 3 made of the same scene.
//!
//! Both pictures are averaged over blocks of 8 by 8 pixels (larger ones where samples are few: means of few samples of a
//! caustic are not normally distributed). For each block and channel z is the difference over its standard
//! error; theirs is stored with the picture, ours comes from the spread of independent seeds. All |z| stay below the bound
//! that a set of so many exceeds by chance once in a hundred times (Bonferroni), and the means of the whole pictures differ by
//! less than 0.3 %. A block that Mitsuba knows exactly agrees within 10⁻⁴ of itself.
//!
//! The scenes and pictures are in `tests/references`.

use std::path::{Path, PathBuf};

use brewster_buffers::{SamplerKind, SceneBuffers};
use brewster_film::{Film, PixelOrder};
use brewster_import::Importer;
use brewster_wavefront::{Control, Policy, Renderer};
use brewster_world::Scene;
use exr::prelude::{ReadChannels, ReadLayers, read};

/// The scenes.
pub const REFERENCES: [&str; 12] = [
    "absorbing-glass",
    "diffuse-box",
    "fog-and-milk",
    "glass-knot",
    "glass-on-checker",
    "glass-rough",
    "many-lights",
    "metals-rough",
    "metals-smooth",
    "moving-things",
    "punctual-lights",
    "slab-stack",
];

/// Width and height of a block in pixels.
pub type Block = [usize; 2];

/// The block of a full comparison.
pub const BLOCK: Block = [8, 8];

/// How often a faultless tracer fails.
const FALSE_ALARMS: f64 = 0.01;

/// A comparison.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Agreement {
    /// The largest |z| of a block and channel.
    pub worst: f64,
    /// The corner of that block in pixels, from the top left.
    pub worst_at: [usize; 2],
    /// There, our radiance and Mitsuba's.
    pub worst_values: [f64; 2],
    /// What it must stay below.
    pub bound: f64,
    /// Difference of the mean over the whole picture, as a part of it.
    pub mean: f64,
    /// The middle, over blocks, of our standard error over Mitsuba's.
    pub error_ratio: f64,
    /// Blocks that Mitsuba knows exactly and that differ.
    pub exact_differ: usize,
}

impl Agreement {
    /// Whether the pictures agree.
    pub fn holds(&self) -> bool {
        self.worst < self.bound && self.mean.abs() < 0.003 && self.exact_differ == 0
    }
}

/// The folder of the references.
pub fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("references")
}

/// The columns of a reference scene; panics if it is not whole.
pub fn load(name: &str) -> SceneBuffers {
    let path = folder().join(name).with_extension("ron");
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let loaded = Importer::default().load_text(&path, &text).unwrap_or_else(|failure| panic!("{failure}"));
    let mut scene = Scene::new();
    loaded.scene.apply(scene.world_mut());
    let report = scene.flatten();
    assert!(report.invalid.is_empty(), "{}: {:?}", path.display(), report.invalid);
    scene.buffers().clone()
}

/// Means over blocks, channel after channel within a block.
pub type Blocks = Vec<f64>;

/// Averages over blocks; `value` gives a pixel's three channels.
fn blocks([width, height]: [usize; 2], [across, down]: Block, value: impl Fn(usize, usize) -> [f64; 3]) -> Blocks {
    let mut means = Vec::with_capacity(3 * width * height / (across * down));
    for top in (0..height).step_by(down) {
        for left in (0..width).step_by(across) {
            let mut sum = [0.0; 3];
            for (x, y) in (0..across * down).map(|i| (left + i % across, top + i / across)) {
                let value = value(x, y);
                (0..3).for_each(|channel| sum[channel] += value[channel]);
            }
            means.extend(sum.map(|sum| sum / (across * down) as f64));
        }
    }
    means
}

/// Mitsuba's picture: its size, means over blocks and their standard errors.
pub fn reference(name: &str, block: Block) -> ([usize; 2], Blocks, Blocks) {
    let path = folder().join(name).with_extension("exr");
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_file(&path)
        .unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let layer = &image.layer_data;
    let size = [layer.size.0, layer.size.1];
    assert!(size[0] % block[0] == 0 && size[1] % block[1] == 0, "{name} has no whole blocks");
    let channel = |name: &str| {
        let channel = layer.channel_data.list.iter().find(|channel| channel.name.eq(name));
        channel.unwrap_or_else(|| panic!("{} has no channel {name}", path.display()))
    };
    let color = ["R", "G", "B"].map(channel);
    let error = ["se.R", "se.G", "se.B"].map(channel);
    let at = |channel: &exr::prelude::AnyChannel<exr::prelude::FlatSamples>, x: usize, y: usize| {
        f64::from(channel.sample_data.value_by_flat_index(y * size[0] + x).to_f32())
    };
    let means = blocks(size, block, |x, y| color.map(|channel| at(channel, x, y)));
    // The error of a mean of n pixels is the root of the mean square error over n.
    let squares = blocks(size, block, |x, y| error.map(|channel| at(channel, x, y).powi(2)));
    let errors = squares.iter().map(|square| (square / (block[0] * block[1]) as f64).sqrt()).collect();
    (size, means, errors)
}

/// A scene's picture: channel after channel, pixel after pixel, row after row.
pub fn pixels(scene: &SceneBuffers, threads: usize) -> Vec<f64> {
    let size = scene.settings.resolution;
    let mut film = Film::new(PixelOrder::new(size.x, size.y, None).expect("a small picture"));
    let mut renderer = Renderer::new(scene, 0, threads, Policy::default(), false).expect("the scene can be rendered");
    assert!(renderer.pass(0..scene.settings.samples, &mut film, &Control::default()));
    assert_eq!((film.rejected(), film.saturated()), (0, 0), "light that is no number");
    let picture = film.resolve().pixels;
    (0..picture.len()).flat_map(|row| picture.get(row).color.map(f64::from)).collect()
}

/// Our picture with one seed, over blocks.
fn ours(scene: &SceneBuffers, block: Block, threads: usize) -> Blocks {
    let [width, height] = scene.settings.resolution.as_usizevec2().to_array();
    let pixels = pixels(scene, threads);
    blocks([width, height], block, |x, y| std::array::from_fn(|channel| pixels[3 * (y * width + x) + channel]))
}

/// Means over blocks of a scene's picture, and their standard errors, from the spread of `seeds` independent pictures.
pub fn estimate(scene: &SceneBuffers, block: Block, seeds: u64, threads: usize) -> (Blocks, Blocks) {
    let mut scene = scene.clone();
    let mut sums: Vec<[f64; 2]> = Vec::new();
    for seed in 0..seeds {
        scene.settings.seed = 1 + seed;
        let blocks = ours(&scene, block, threads);
        sums.resize(blocks.len(), [0.0; 2]);
        for ([sum, squares], value) in sums.iter_mut().zip(blocks) {
            *sum += value;
            *squares += value * value;
        }
    }
    let seeds = seeds as f64;
    let mean = |&[sum, squares]: &[f64; 2]| {
        let mean = sum / seeds;
        (mean, ((squares / seeds - mean * mean).max(0.0) / (seeds - 1.0)).sqrt())
    };
    sums.iter().map(mean).unzip()
}

/// The largest |z| of all blocks and channels of two scenes' pictures, of 40 seeds each, and its [`bound`].
pub fn compare(a: &SceneBuffers, b: &SceneBuffers, block: Block) -> (f64, f64) {
    const SEEDS: u64 = 40;
    let ((a, a_errors), (b, b_errors)) = (estimate(a, block, SEEDS, 2), estimate(b, block, SEEDS, 2));
    let errors = a_errors.iter().zip(&b_errors).map(|(a, b)| a.hypot(*b));
    let z = a.iter().zip(&b).zip(errors).map(|((a, b), error)| if a == b { 0.0 } else { (a - b).abs() / error });
    (z.fold(0.0, f64::max), bound(a.len()))
}

/// What |z| of `count` comparisons stays below but for false alarms.
pub fn bound(count: usize) -> f64 {
    normal_quantile(1.0 - 0.5 * FALSE_ALARMS / count as f64)
}

/// By how much Mitsuba's rays start off a surface, as a part of 1 + the largest of their coordinates: its `RayEpsilon` for
/// single precision, 1500 x 2⁻²⁴.
pub const MITSUBA_OFFSET: f32 = 1500.0 / (1 << 24) as f32;

/// Renders a reference scene with `seeds` seeds of `samples` samples a pixel each, and compares. `offset` is the scene's
/// `ray_offset`: 0, or [`MITSUBA_OFFSET`] to start rays where Mitsuba does.
pub fn agreement(name: &str, offset: f32, block: Block, [seeds, samples]: [u32; 2], threads: usize) -> Agreement {
    let mut scene = load(name);
    scene.settings.ray_offset = offset;
    let (size, theirs, their_errors) = reference(name, block);
    assert_eq!(scene.settings.resolution.as_usizevec2().to_array(), size, "{name}");
    scene.settings.samples = samples;
    scene.settings.sampler = SamplerKind::Independent;
    let (ours, our_errors) = estimate(&scene, block, u64::from(seeds), threads);
    let across = size[0] / block[0];
    let mut found = Agreement {
        worst: 0.0,
        worst_at: [0; 2],
        worst_values: [0.0; 2],
        bound: bound(theirs.len()),
        mean: ours.iter().sum::<f64>() / theirs.iter().sum::<f64>() - 1.0,
        error_ratio: 0.0,
        exact_differ: 0,
    };
    let mut ratios = Vec::new();
    for (place, (our, their)) in ours.iter().zip(&theirs).enumerate() {
        let (our_error, their_error) = (our_errors[place], their_errors[place]);
        if their_error == 0.0 {
            found.exact_differ += usize::from((our - their).abs() > (1e-4 * their).max(1e-6));
            continue;
        }
        let z = (our - their).abs() / our_error.hypot(their_error);
        if z > found.worst {
            let row = place / 3;
            found.worst = z;
            found.worst_at = [row % across * block[0], row / across * block[1]];
            found.worst_values = [*our, *their];
        }
        ratios.push(our_error / their_error);
    }
    ratios.sort_by(f64::total_cmp);
    found.error_ratio = ratios.get(ratios.len() / 2).copied().unwrap_or(0.0);
    found
}

/// The number below which a standard normal variable lies with a probability in ½..1: by bisection of the tail's continued
/// fraction (Abramowitz and Stegun 26.2.14).
fn normal_quantile(probability: f64) -> f64 {
    let tail = |x: f64| {
        let fraction = (1..60).rev().fold(0.0, |fraction, n| f64::from(n) / (x + fraction));
        (-0.5 * x * x).exp() / (std::f64::consts::TAU.sqrt() * (x + fraction))
    };
    let (mut low, mut high) = (1.0, 10.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if tail(middle) > 1.0 - probability { low = middle } else { high = middle }
    }
    low
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_the_tables() {
        // From tables: 97.5 % at 1.95996, 99.9 % at 3.09023, 99.9995 % at 4.41717.
        for (probability, quantile) in [(0.975, 1.959_96), (0.999, 3.090_23), (0.999_995, 4.417_17)] {
            assert!((normal_quantile(probability) - quantile).abs() < 1e-4, "{}", normal_quantile(probability));
        }
    }

    #[test]
    fn blocks_are_means_of_their_pixels() {
        let means = blocks([16, 8], BLOCK, |x, y| [x as f64, y as f64, 1.0]);
        assert_eq!(means, [3.5, 3.5, 1.0, 11.5, 3.5, 1.0]);
    }
}
