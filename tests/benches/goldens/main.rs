//! glTF models against pictures that other renderers made of them:
//! `cargo bench -p brewster-tests --bench goldens [-- [DIR] [--samples N] [--out DIR] [--compensated] [--pairs] [MODEL…]]`.
//!
//! DIR (`tests/gltf` without one) holds `models`, `env`, and in `goldens/MODEL` the pictures and `scenario.json`, which says what
//! they show: files as they are at time 0 of their first animation, and pictures that were made larger and shrunk as they are displayed,
//! as ours are: twice as wide and high, with a quarter of the samples. Every picture is compared over gray: the mean absolute difference
//! of display values, and FLIP. Prints a table and
//! writes it with the pictures side by side as `index.html` in the folder of `--out`, `target/goldens` without one.
//!
//! Renderers differ. A model agrees if the mean difference from some trusted picture is at most the largest one between two of
//! the trusted pictures, clamped to 0.012 to 0.03; where fewer than two are trusted, 0.02.
//!
//! With `--compensated`, rough metals keep the light that meets a second facet, which Appendix B's lobes lose. With `--pairs`, models
//! that DIR holds in two forms are compared with each other instead.

mod page;
mod pairs;
mod scenario;

use std::path::{Path, PathBuf};
use std::time::Instant;

use brewster::film::{LinearImage, ToneMap, flip, read_image, srgb_decode, srgb_encode};
use brewster::import::{EnvironmentChoice, GltfChoices, LoadOptions, ViewChoices};
use brewster::wavefront::Control;
use brewster::world::components::{Material, Settings, parts};
use brewster::{RenderOptions, Session, SessionOptions, SettingsChoices};
use glam::{UVec2, Vec3};

use scenario::Scenario;

/// How far the pictures are looked at from, for FLIP: 0.7 m from a screen of 0.7 m and 3840 pixels.
const PIXELS_PER_DEGREE: f32 = 67.0;

/// Goldens that show something else than the specification says, and why.
const DISTRUSTED: &[(&str, &str, &str)] = &[
    ("*", "gltf-sample-viewer", "a rasterizer"),
    ("*", "babylon", "a rasterizer"),
    ("TextureTransformTest", "three-gpu-pathtracer", "transforms in another order"),
    ("MultiUVTest", "vray", "one set of coordinates"),
    ("TriangleWithoutIndices", "vray", "contradicts the file"),
    ("SimpleSkin", "*", "by the notes of the set"),
    ("Fox", "*", "another pose"),
    ("LightsPunctualLamp", "blender-cycles", "another unit of light"),
    ("LightsPunctualLamp", "vray", "another unit of light"),
    ("EmissiveStrengthTest", "blender-cycles", "another unit of light"),
    ("EmissiveStrengthTest", "vray", "another unit of light"),
    ("IridescenceSuzanne", "blender-cycles", "no thin films"),
    ("AnisotropyStrengthTest", "blender-cycles", "no anisotropy"),
];

/// How pictures are made.
#[derive(Clone, Copy)]
pub(crate) struct Manner {
    /// For each pixel of a golden.
    pub(crate) samples: u32,
    pub(crate) seed: u64,
    /// As [`Principled::compensated`](brewster::world::components::Principled::compensated).
    pub(crate) compensated: bool,
}

/// What became of a model.
pub(crate) struct Outcome {
    name: String,
    seconds: f64,
    tolerance: f64,
    goldens: Vec<Comparison>,
}

/// Our picture beside another renderer's.
pub(crate) struct Comparison {
    renderer: String,
    distrust: Option<&'static str>,
    mean: f64,
    flip: f64,
}

impl Outcome {
    fn agrees(&self) -> bool {
        let trusted = |golden: &&Comparison| golden.distrust.is_none();
        let mut trusted = self.goldens.iter().filter(trusted).peekable();
        trusted.peek().is_none() || trusted.any(|golden| golden.mean <= self.tolerance)
    }
}

fn main() {
    let mut arguments: Vec<String> = std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    let mut take = |name: &str| {
        let at = arguments.iter().position(|argument| argument == name)?;
        arguments.remove(at);
        (at < arguments.len()).then(|| arguments.remove(at))
    };
    let samples: u32 = take("--samples").map_or(64, |samples| samples.parse().expect("--samples takes a number"));
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let out = take("--out").map_or(root.join("../target/goldens"), PathBuf::from);
    let mut is_asked = |name: &str| {
        let at = arguments.iter().position(|argument| argument == name);
        at.map(|at| arguments.remove(at)).is_some()
    };
    let compares_pairs = is_asked("--pairs");
    let manner = Manner { samples, seed: 0, compensated: is_asked("--compensated") };
    let folder = match arguments.first().map(PathBuf::from).filter(|path| path.is_dir()) {
        Some(folder) => {
            arguments.remove(0);
            folder
        }
        None => root.join("gltf"),
    };
    if compares_pairs {
        return pairs::compare(&folder, manner).unwrap_or_else(|error| panic!("{error}"));
    }
    std::fs::create_dir_all(&out).expect("a folder for the pictures");
    let mut names: Vec<String> = std::fs::read_dir(folder.join("goldens"))
        .expect("a folder `goldens`")
        .map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned())
        .filter(|name| arguments.is_empty() || arguments.contains(name))
        .collect();
    names.sort();
    println!("| model | golden | mean difference | FLIP | trusted | tolerance | agrees | seconds |");
    println!("| --- | --- | --- | --- | --- | --- | --- | --- |");
    let mut outcomes = Vec::new();
    for name in names {
        match compare(&folder, &name, &out, manner) {
            Ok(outcome) => {
                tell(&outcome);
                outcomes.push(outcome);
            }
            Err(error) => println!("| {name} | {error} | | | | | NO | |"),
        }
    }
    let agree = outcomes.iter().filter(|outcome| outcome.agrees()).count();
    println!("\n{agree} of {} models agree; {}", outcomes.len(), out.join("index.html").display());
    page::write(&out, &outcomes).expect("the page can be written");
}

fn tell(outcome: &Outcome) {
    for (at, golden) in outcome.goldens.iter().enumerate() {
        let Comparison { renderer, distrust, mean, flip } = golden;
        let trusted = distrust.map_or("yes".to_owned(), |why| format!("no: {why}"));
        let (name, end) = match at {
            0 => {
                let agrees = if outcome.agrees() { "yes" } else { "NO" };
                (outcome.name.as_str(), format!("{:.3} | {agrees} | {:.0}", outcome.tolerance, outcome.seconds))
            }
            _ => ("", " | | ".to_owned()),
        };
        println!("| {name} | {renderer} | {mean:.4} | {flip:.4} | {trusted} | {end} |");
    }
}

/// Renders a model's scenario and compares it with each golden.
fn compare(folder: &Path, name: &str, out: &Path, manner: Manner) -> Result<Outcome, String> {
    let goldens = folder.join("goldens").join(name);
    let scenario = Scenario::read(&goldens.join("scenario.json"))?;
    let begin = Instant::now();
    let light = render(folder, &scenario, manner)?;
    let seconds = begin.elapsed().as_secs_f64();
    let mut comparisons = Vec::new();
    for renderer in &scenario.goldens {
        let golden = read_image(&goldens.join(format!("{renderer}.png"))).map_err(|error| error.to_string())?;
        let golden = over_gray(&golden, |color| color.map(srgb_encode));
        let curve: fn(f32) -> f32 = if renderer == "three-gpu-pathtracer" { srgb_encode } else { power };
        let ours = over_gray(&light, |color| aces(color).map(curve)).halved();
        let mean = mean_difference(&ours, &golden);
        let (ours, golden) = (ours.decoded(), golden.decoded());
        let flip = flip(&golden, &ours, PIXELS_PER_DEGREE).map_err(|error| error.to_string())?.mean;
        page::picture(out, &format!("{name}-{renderer}"), &golden)?;
        page::picture(out, &format!("{name}-ours"), &ours)?;
        page::difference(out, &format!("{name}-{renderer}-difference"), &ours, &golden)?;
        let distrust = DISTRUSTED
            .iter()
            .find(|(model, of, _)| (*model == name || *model == "*") && (of == renderer || *of == "*"));
        comparisons.push(Comparison { renderer: renderer.clone(), distrust: distrust.map(|row| row.2), mean, flip });
    }
    let trusted: Vec<&str> =
        comparisons.iter().filter(|golden| golden.distrust.is_none()).map(|golden| golden.renderer.as_str()).collect();
    let tolerance = scenario.tolerance(&trusted);
    Ok(Outcome { name: name.to_owned(), seconds, tolerance, goldens: comparisons })
}

/// The picture of a scenario, twice as wide and high: radiance, black and transparent where the background is not to be seen.
fn render(folder: &Path, scenario: &Scenario, manner: Manner) -> Result<LinearImage, String> {
    let environment =
        EnvironmentChoice { file: Some(folder.join(&scenario.environment)), rotation: 0.0, strength: 1.0 };
    let backdrop = if scenario.shows_environment { parts::Backdrop::Background } else { parts::Backdrop::Transparent };
    let view = ViewChoices {
        target: Some(scenario.target),
        orbit: Some(scenario.orbit),
        vfov: Some(scenario.vfov),
        environment: Some(environment),
        backdrop: Some(backdrop),
        ..ViewChoices::default()
    };
    let settings = SettingsChoices {
        resolution: Some(2 * UVec2::from_array(scenario.size)),
        samples: Some(manner.samples.div_ceil(4)),
        seed: Some(manner.seed),
        ..SettingsChoices::default()
    };
    let gltf = GltfChoices { time: Some(0.0), ..GltfChoices::default() };
    let options = SessionOptions { load: LoadOptions { view, gltf, ..LoadOptions::default() }, settings };
    let mut session = Session::new(folder.join(&scenario.model), options);
    session.load().map_err(|error| error.to_string())?;
    let world = session.scene_mut().world_mut();
    world.resource_mut::<Settings>().0.filter = parts::PixelFilter::Box;
    for mut material in world.query::<&mut Material>().iter_mut(world) {
        if let Material::Principled(principled) = &mut *material {
            principled.compensated = manner.compensated;
        }
    }
    session.flatten().map_err(|error| error.to_string())?;
    let mut render = session.render(RenderOptions::default()).map_err(|error| error.to_string())?;
    let control = Control::default();
    while render.remaining() > 0 {
        render.pass(&control);
    }
    if render.film().rejected() > 0 {
        return Err(format!("{} contributions are no light", render.film().rejected()));
    }
    let image = render.film().resolve().image();
    // Where the environment is to be seen, nothing is transparent.
    Ok(if scenario.shows_environment { LinearImage { alpha: None, ..image } } else { image })
}

/// Display values.
struct Shown {
    width: u32,
    height: u32,
    values: Vec<[f32; 3]>,
}

impl Shown {
    /// The means of squares of four pixels.
    fn halved(&self) -> Shown {
        let (width, height) = (self.width / 2, self.height / 2);
        let value = |x: u32, y: u32| Vec3::from_array(self.values[(y * self.width + x) as usize]);
        let mean = |(x, y): (u32, u32)| {
            let (x, y) = (2 * x, 2 * y);
            (0.25 * (value(x, y) + value(x + 1, y) + value(x, y + 1) + value(x + 1, y + 1))).to_array()
        };
        let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        Shown { width, height, values: places.map(mean).collect() }
    }

    /// The light that a display makes of them.
    fn decoded(&self) -> LinearImage {
        let color = self.values.iter().map(|value| value.map(srgb_decode)).collect();
        LinearImage { width: self.width, height: self.height, color, alpha: None }
    }
}

/// A picture as it is shown over gray of 0.5.
fn over_gray(image: &LinearImage, encode: impl Fn([f32; 3]) -> [f32; 3]) -> Shown {
    let alpha = |pixel: usize| image.alpha.as_ref().map_or(1.0, |alpha| alpha[pixel]);
    let values = image.color.iter().enumerate().map(|(pixel, color)| {
        let alpha = alpha(pixel);
        let straight = if alpha > 0.0 { color.map(|value| value / alpha) } else { [0.0; 3] };
        encode(straight).map(|value| value * alpha + 0.5 * (1.0 - alpha))
    });
    Shown { width: image.width, height: image.height, values: values.collect() }
}

/// The goldens' tone mapping: ACES as three.js has it, exposed by 1 / 0.6; linear display light.
fn aces(color: [f32; 3]) -> [f32; 3] {
    ToneMap::Aces.encode(color.map(|value| value / 0.6)).map(srgb_decode)
}

/// A display's curve as a plain power.
fn power(value: f32) -> f32 {
    value.max(0.0).powf(1.0 / 2.2)
}

fn mean_difference(a: &Shown, b: &Shown) -> f64 {
    let pairs = a.values.as_flattened().iter().zip(b.values.as_flattened());
    pairs.map(|(a, b)| f64::from((a - b).abs())).sum::<f64>() / (3 * a.values.len()) as f64
}
