//! `brewster replay`: one step of a batch, or one stage of it, again and again.

use std::fs::File;
use std::io::{Read, Write as _};
use std::path::{Path, PathBuf};
use std::time::Duration;

use brewster::buffers::Integrator;
use brewster::film::{FilmError, write_atomically};
use brewster::lanes::Level;
use brewster::tape::TapeFile;
use brewster::wavefront::queues::RaySource;
use brewster::wavefront::tape::{Replay, Run, Tape};
use brewster::wavefront::{Policy, Stage};
use brewster::{Session, SettingsChoices};
use clap::{ArgGroup, Args};
use glam::UVec2;

use super::scene::SceneArguments;
use super::values::{self, INTEGRATORS};
use super::{Failure, print};

/// Records the rays that wait in a queue, or runs them through their step, or one stage of it, again and again, and tells how long that
/// takes.
#[derive(Debug, Args)]
#[command(group = ArgGroup::new("what").required(true).args(["dump", "tape"]))]
pub(crate) struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,
    /// Record a tape into this file.
    #[arg(long, value_name = "FILE")]
    dump: Option<PathBuf>,
    /// Run this tape; it keeps the settings that it was recorded with.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["bounce", "queue", "camera", "resolution", "samples", "max_depth", "integrator", "batch"])]
    tape: Option<PathBuf>,
    /// The depth of the rays that are recorded: 0 for camera rays.
    #[arg(long, value_name = "N", default_value_t = 1)]
    bounce: u32,
    /// The queue that they wait in; at depth 0 without it, that of camera rays.
    #[arg(long, value_name = "NAME", ignore_case = true, value_parser = values::one_of(QUEUES))]
    queue: Option<RaySource>,
    /// The camera, by name or number; without it, the scene's first.
    #[arg(long, value_name = "NAME")]
    camera: Option<String>,
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
    /// Rays that are traced together: the most that a tape holds.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=16_777_216))]
    batch: Option<u32>,
    /// Runs that are timed, after one to warm up.
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    runs: u32,
    /// Run this stage alone: what it finds when the step comes to it is kept, and every run starts from that.
    #[arg(long, value_name = "NAME", value_parser = stage, requires = "tape")]
    stage: Option<Stage>,
    /// The instruction set that kernels run on; without it, the best of this machine.
    #[arg(long, value_name = "NAME", value_parser = level)]
    level: Option<Level>,
}

const QUEUES: &[(&str, RaySource)] = &[
    ("primary", RaySource::Primary),
    ("reflection", RaySource::Reflection),
    ("transmission", RaySource::Transmission),
];

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    match (&arguments.dump, &arguments.tape) {
        (Some(path), _) => record(arguments, path),
        (None, Some(path)) => replay(arguments, path),
        (None, None) => Err(Failure::Usage("a tape is recorded with --dump or run with --tape".to_owned())),
    }
}

fn record(arguments: &Arguments, path: &Path) -> Result<(), Failure> {
    values::check_writable(path)?;
    let session = session(
        arguments,
        SettingsChoices {
            resolution: arguments.resolution,
            samples: arguments.samples,
            max_depth: arguments.max_depth,
            integrator: arguments.integrator,
            ..SettingsChoices::default()
        },
    )?;
    let camera = session.camera(arguments.camera.as_deref())?;
    let by_depth = if arguments.bounce == 0 { RaySource::Primary } else { RaySource::Reflection };
    let at = (arguments.bounce, arguments.queue.unwrap_or(by_depth));
    let policy = match arguments.batch {
        Some(rays) => Policy { batch: rays as usize, capacity: rays as usize, ..Policy::default() },
        None => Policy::default(),
    };
    let tape = Tape::record(session.buffers(), camera, policy, at).map_err(Failure::input)?;
    let (rays, queue) = (tape.rays.len(), tape.source.name());
    let file = TapeFile::new(&session, camera, tape);
    let io_error = |source| FilmError::Io { path: path.to_path_buf(), source };
    write_atomically(path, |out| out.write_all(&file.bytes()).map_err(io_error))?;
    print(format!("{rays} rays of the {queue} queue at depth {}\n", arguments.bounce))
}

fn replay(arguments: &Arguments, path: &Path) -> Result<(), Failure> {
    let bad = |why: &dyn std::fmt::Display| Failure::Input(format!("{}: {why}", path.display()));
    let mut bytes = Vec::new();
    if path.exists() && !path.is_file() {
        return Err(bad(&"it is a folder, or no ordinary file"));
    }
    let file = File::open(path).map_err(|error| bad(&error))?;
    file.take(MOST_BYTES + 1).read_to_end(&mut bytes).map_err(|error| bad(&error))?;
    if bytes.len() as u64 > MOST_BYTES {
        return Err(bad(&format!("a tape has at most {MOST_BYTES} bytes")));
    }
    let TapeFile { header, tape } = TapeFile::read(&bytes).map_err(|why| bad(&why))?;
    let session = session(arguments, header.settings().map_err(|why| bad(&why))?)?;
    if !header.is_of(&session) {
        return Err(bad(&"it was recorded from another state of the scene's files, or with other overrides"));
    }
    let policy = Policy { level: arguments.level.unwrap_or_else(Level::detect), ..Policy::default() };
    let replay = Replay::new(session.buffers(), header.camera(), policy, &tape);
    let mut replay = replay.map_err(|error| bad(&error))?;
    let first = replay.run();
    let (runs, level) = (arguments.runs, policy.level.name());
    let mut table = format!("{} rays of the {} queue at depth {}, ", tape.rays.len(), tape.source.name(), tape.depth);
    let names =
        format!("{:20} {:>8} {:>11} {:>11} {:>11} {:>9}\n", "stage", "rays", "median ms", "least", "most", "Mrays/s");
    if let Some(stage) = arguments.stage {
        if first.stages.iter().all(|row| row.0 != stage) {
            let others: Vec<&str> = first.stages.iter().map(|row| row.0.name()).collect();
            return Err(bad(&format!("its step runs no {}; it runs {}", stage.name(), others.join(", "))));
        }
        let alone = replay.run_alone(stage, runs as usize).map_err(|error| bad(&error))?;
        let calls = if alone.calls == 1 { "call".to_owned() } else { format!("{} calls", alone.calls) };
        table += &format!("{runs} runs of one stage on {level}, result {:016x} in every run\n", alone.hash);
        table += &format!("the step's result is {:016x} at once and call by call\n\n{names}", first.hash);
        table += &row(stage, alone.rays, alone.times);
        table += &format!("\na run is the step's {calls} of the stage\n");
        return print(table);
    }
    let runs: Vec<Run> = (0..runs).map(|_| replay.run()).collect();
    if let Some(other) = runs.iter().find(|run| run.hash != first.hash) {
        return Err(bad(&format!("runs differ: {:016x} is not {:016x}", other.hash, first.hash)));
    }
    table += &format!("{} runs on {level}, result {:016x} in every run\n\n{names}", runs.len(), first.hash);
    for &(stage, rays, _) in &first.stages {
        let times = runs.iter().filter_map(|run| run.stages.iter().find(|row| row.0 == stage)).map(|row| row.2);
        table += &row(stage, rays, times.collect());
    }
    print(table)
}

/// A stage's line in the table.
fn row(stage: Stage, rays: u64, mut times: Vec<Duration>) -> String {
    times.sort();
    let [median, least, most] = [times.len() / 2, 0, times.len() - 1].map(|place| times[place].as_secs_f64());
    let rate = if median > 0.0 { rays as f64 / median * 1e-6 } else { 0.0 };
    let [median, least, most] = [median, least, most].map(|seconds| seconds * 1e3);
    format!("{:20} {rays:>8} {median:>11.4} {least:>11.4} {most:>11.4} {rate:>9.2}\n", stage.name())
}

/// Bytes of the largest tape that is read.
const MOST_BYTES: u64 = 4 << 30;

fn session(arguments: &Arguments, settings: SettingsChoices) -> Result<Session, Failure> {
    let mut session = arguments.scene.session(settings)?;
    session.load()?;
    session.flatten()?;
    Ok(session)
}

fn stage(name: &str) -> Result<Stage, String> {
    let found = Stage::ALL.into_iter().find(|stage| stage.name() == name);
    let of_steps = || Stage::ALL.into_iter().filter(|stage| !matches!(stage, Stage::Generate | Stage::Fold));
    found.ok_or_else(|| format!("expected one of {}", of_steps().map(Stage::name).collect::<Vec<_>>().join(", ")))
}

fn level(name: &str) -> Result<Level, String> {
    let names = || Level::available().iter().map(|level| level.name()).collect::<Vec<_>>().join(", ");
    Level::named(name).ok_or_else(|| format!("this machine has {}", names()))
}
