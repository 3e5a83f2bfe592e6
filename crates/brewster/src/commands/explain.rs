//! `brewster explain`: how the light of one pixel came about.

use std::io::Write;
use std::path::{Path, PathBuf};

use brewster::SettingsChoices;
use brewster::buffers::Integrator;
use brewster::explain::{Explanation, Samples};
use brewster::film::{FilmError, write_atomically};
use clap::Args;
use glam::UVec2;

use super::scene::{SceneArguments, say_warnings};
use super::values::{self, INTEGRATORS};
use super::{Failure, print};
use crate::terminal::Terminal;

/// Tells how the light of one pixel came about: every ray, what it met, how that split it, and what light it brought.
///
/// The contributions add up to the pixel of a render, to the last unit; where a noise threshold lets pixels go without some of the
/// samples that the scene asks for, to one of all of them. Without an output file it is told as text.
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,
    /// The pixel: its column and row, counted from 0 at the top left.
    #[arg(long, value_name = "X,Y", value_parser = values::pixel)]
    pixel: [u32; 2],
    /// The sample, counted from 0; without it, all that the scene asks for.
    #[arg(long, value_name = "N")]
    sample: Option<u32>,
    /// The camera, by name or number; without it, the scene's first.
    #[arg(long, value_name = "NAME")]
    camera: Option<String>,
    /// Where it goes: .json, .txt, .svg or .html; may be given several times.
    #[arg(short, long, value_name = "FILE")]
    output: Vec<PathBuf>,
    /// Width and height in pixels.
    #[arg(long, value_name = "WxH", value_parser = values::resolution)]
    resolution: Option<UVec2>,
    /// Samples per pixel.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_048_576))]
    samples: Option<u32>,
    /// The number of interactions on a path that may scatter on.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=1000))]
    max_depth: Option<u32>,
    /// How light is carried.
    #[arg(long, value_name = "NAME", ignore_case = true, value_parser = values::one_of(INTEGRATORS))]
    integrator: Option<Integrator>,
    /// With the integrator Path: interactions before which a dielectric sends a ray to either side; later one by chance.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=1000))]
    split_depth: Option<u32>,
    /// With the integrator Path: whether diffuse surfaces look for the light that mirrors and glass throw on them.
    #[arg(long, value_name = "BOOL")]
    guiding: Option<bool>,
    /// With the integrator Path: the largest radiance that one contribution may bring.
    #[arg(long, value_name = "RADIANCE", value_parser = values::above_zero)]
    clamp: Option<f32>,
    /// Chooses the pattern of samples.
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let formats = arguments.output.iter().map(|path| format_of(path)).collect::<Result<Vec<_>, _>>()?;
    arguments.output.iter().try_for_each(|path| values::check_writable(path))?;
    let choices = SettingsChoices {
        resolution: arguments.resolution,
        integrator: arguments.integrator,
        max_depth: arguments.max_depth,
        samples: arguments.samples,
        split_depth: arguments.split_depth,
        guiding: arguments.guiding,
        clamp: arguments.clamp,
        seed: arguments.seed,
        ..SettingsChoices::default()
    };
    let mut session = arguments.scene.session(choices)?;
    let terminal = Terminal::new(false);
    let progress = terminal.begin("load");
    session.load()?;
    drop(progress);
    say_warnings(&session, Terminal::Lines);
    let progress = terminal.begin("flatten");
    session.flatten()?;
    drop(progress);
    let samples = arguments.sample.map_or(Samples::All, Samples::One);
    let explanation = session.explain(arguments.camera.as_deref(), arguments.pixel, samples)?;
    if arguments.output.is_empty() {
        return print(explanation.text());
    }
    for (path, format) in arguments.output.iter().zip(formats) {
        let io_error = |source| FilmError::Io { path: path.clone(), source };
        write_atomically(path, |file| file.write_all(format(&explanation).as_bytes()).map_err(io_error))?;
    }
    Ok(())
}

/// How a file of that name is written.
fn format_of(path: &Path) -> Result<fn(&Explanation) -> String, Failure> {
    let extension = path.extension().and_then(|extension| extension.to_str()).unwrap_or_default();
    match extension.to_ascii_lowercase().as_str() {
        "json" => Ok(Explanation::json),
        "txt" => Ok(Explanation::text),
        "svg" => Ok(Explanation::svg),
        "html" => Ok(Explanation::html),
        _ => {
            let expected = "expected a name that ends in .json, .txt, .svg or .html";
            Err(Failure::Usage(format!("{}: {expected}", path.display())))
        }
    }
}
