//! An explanation: the trees of rays behind one pixel, with names; as text, JSON, a drawing and a page.
//!
//! What is told of a ray is what the tracer's own stages did with it ([`brewster_wavefront::explain`]); the light of all
//! contributions adds up to the pixel's, to the last unit.

mod drawing;
mod named;
mod page;
mod text;

use brewster_film::{Light, SCALE};
use brewster_wavefront::explain::Explainer;
use serde::Serialize;

use crate::stats::hash_text;
use crate::{PROGRAM, Session, SessionError};

pub use named::{NamedFresnel, NamedLayer, NamedLight, NamedMedium, NamedRay, NamedSurface};

/// The version of the format.
pub const EXPLANATION_VERSION: u32 = 1;

/// Which samples of a pixel are explained.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Samples {
    /// One, by its number.
    One(u32),
    /// All that the scene's settings ask for.
    All,
}

/// How the light of one pixel came about.
#[derive(Clone, Debug, Serialize)]
pub struct Explanation {
    version: u32,
    program: &'static str,
    scene: String,
    hash: String,
    camera: String,
    integrator: String,
    resolution: [u32; 2],
    max_depth: u32,
    /// Column and row.
    pixel: [u32; 2],
    /// Samples that the settings ask for; those below may be fewer.
    samples_asked: u32,
    /// The mean of the samples below.
    radiance: [f64; 3],
    /// The sum over the samples below, in units of 2^-32.
    units: [i64; 3],
    samples: Vec<ExplainedSample>,
}

/// How the light of one sample came about.
#[derive(Clone, Debug, Serialize)]
pub struct ExplainedSample {
    /// Its number.
    pub number: u32,
    /// What it adds to the pixel.
    pub radiance: [f64; 3],
    /// The same in the film's units of 2^-32: the sum of those of all its lights.
    pub units: [i64; 3],
    /// Contributions that were no light.
    pub rejected: u32,
    /// The rays, each behind the one that sent it; the first is the camera's.
    pub rays: Vec<NamedRay>,
}

impl Explanation {
    pub(crate) fn new(
        session: &Session,
        camera: usize,
        pixel: [u32; 2],
        samples: Samples,
    ) -> Result<Explanation, SessionError> {
        let (scene, settings) = (session.buffers(), &session.buffers().settings);
        let mut explainer = Explainer::new(scene, camera).map_err(SessionError::Explain)?;
        let numbers = match samples {
            Samples::One(number) => number..number.saturating_add(1),
            Samples::All => 0..settings.samples,
        };
        let mut sum = Light::NONE;
        let mut explained = Vec::new();
        for number in numbers {
            let tree = explainer.sample(pixel, number).map_err(SessionError::Explain)?;
            sum.add(tree.light);
            explained.push(ExplainedSample {
                number,
                radiance: radiance(tree.light),
                units: tree.light.0,
                rejected: tree.rejected,
                rays: tree.rays.iter().map(|ray| NamedRay::new(session, ray)).collect(),
            });
        }
        Ok(Explanation {
            version: EXPLANATION_VERSION,
            program: PROGRAM,
            scene: session.path().display().to_string(),
            hash: hash_text(session.hash()),
            camera: scene.cameras[camera].name.clone(),
            integrator: format!("{:?}", settings.integrator),
            resolution: settings.resolution.to_array(),
            max_depth: settings.max_depth,
            pixel,
            samples_asked: settings.samples,
            radiance: radiance(sum).map(|sum| sum / explained.len().max(1) as f64),
            units: sum.0,
            samples: explained,
        })
    }

    /// The explained samples.
    pub fn samples(&self) -> &[ExplainedSample] {
        &self.samples
    }

    /// The sum of their light, in the film's units.
    pub fn units(&self) -> [i64; 3] {
        self.units
    }

    /// As JSON, with a line break at its end.
    pub fn json(&self) -> String {
        let json = serde_json::to_string_pretty(self).expect("strings, numbers and lists are JSON");
        json + "\n"
    }

    /// What its radiance is that of.
    fn what(&self) -> String {
        match &self.samples[..] {
            [sample] => format!("of sample {} of {}", sample.number, self.samples_asked),
            samples => format!("the mean of {} samples", samples.len()),
        }
    }

    /// What it is about, in a line.
    fn title(&self) -> String {
        let ([x, y], [width, height]) = (self.pixel, self.resolution);
        let camera = if self.camera.is_empty() { String::new() } else { format!(", camera {}", self.camera) };
        format!("pixel {x},{y} of {width} x {height}{camera}, {}", self.integrator)
    }
}

fn radiance(light: Light) -> [f64; 3] {
    light.0.map(|units| units as f64 / SCALE)
}

/// A number in few places, small ones by their exponent.
fn short(value: f64) -> String {
    let text = match value.abs() {
        0.0 => return "0".to_owned(),
        small if small < 0.001 => return format!("{value:.2e}"),
        large if large >= 1000.0 => format!("{value:.1}"),
        _ => format!("{value:.4}"),
    };
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// Three channels, or one number where they are alike.
fn channels<T: Into<f64> + Copy>(color: [T; 3]) -> String {
    let [r, g, b] = color.map(|channel| short(channel.into()));
    if r == g && g == b { r } else { format!("{r} {g} {b}") }
}

/// A word of at most `most` characters.
fn clipped(word: &str, most: usize) -> String {
    if word.chars().count() <= most {
        return word.to_owned();
    }
    word.chars().take(most - 1).chain(['…']).collect()
}
