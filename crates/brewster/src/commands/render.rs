//! `brewster render`: a scene's picture.

use std::collections::BTreeSet;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use brewster::buffers::{Backdrop, Integrator, SamplerKind, Settings, ToneMapping};
use brewster::film::{Display, Format, Keep, PngAlpha, PngDepth, PngSettings, SCALE, ToneMap, Window};
use brewster::import::Severity;
use brewster::optics::fresnel::FresnelModel;
use brewster::wavefront::ledger::{Energy, Ledger};
use brewster::wavefront::queues::RaySource;
use brewster::wavefront::{Control, Executor, Policy, Stage};
use brewster::{NamedOrigin, Render, RenderOptions, Session, SettingsChoices, peak_memory, tree_time};
use clap::{Args, ValueEnum};
use glam::UVec2;

use super::scene::{SceneArguments, say_warnings};
use super::values::{self, DisplayArguments, INTEGRATORS};
use super::{Failure, frames, models, watch};
use crate::interrupt::Interrupt;
use crate::terminal::{Progress, Terminal, count, duration, plural};

/// Renders a scene to picture files.
///
/// Ctrl-C, like a time limit, saves what is finished and says how much that is; a second Ctrl-C ends at once.
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    pub scene: SceneArguments,
    /// Where the picture goes: .png, .exr with every layer, or .hdr; may be given several times. Without it, the scene's name
    /// with .png in the current folder.
    #[arg(short, long, value_name = "FILE")]
    pub output: Vec<PathBuf>,
    /// Width and height in pixels.
    #[arg(long, value_name = "WxH", value_parser = values::resolution)]
    pub resolution: Option<UVec2>,
    /// Samples per pixel: so many for each, unless `--noise-threshold` is given, too.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_048_576))]
    pub samples: Option<u32>,
    /// Give no more samples to blocks of 8 by 8 pixels whose noise, as estimated after 16, 32, 64 and so on samples, is below
    /// this part of the display's range, such as 0.01.
    #[arg(long, value_name = "PART", value_parser = values::above_zero)]
    pub noise_threshold: Option<f32>,
    /// The number of interactions on a path that may scatter on.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=1000))]
    pub max_depth: Option<u32>,
    /// How light is carried.
    #[arg(long, value_name = "NAME", ignore_case = true, value_parser = values::one_of(INTEGRATORS))]
    pub integrator: Option<Integrator>,
    /// With the integrator Path: interactions before which a dielectric sends a ray to either side; later one by chance.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=1000))]
    pub split_depth: Option<u32>,
    /// With the integrator Path: whether diffuse surfaces look for the light that mirrors and glass throw on them.
    #[arg(long, value_name = "BOOL")]
    pub guiding: Option<bool>,
    /// With the integrator Path: the largest radiance that one contribution may bring. Less noise, and light is missing.
    #[arg(long, value_name = "RADIANCE", value_parser = values::above_zero)]
    pub clamp: Option<f32>,
    /// Where random numbers come from.
    #[arg(long, value_name = "NAME", ignore_case = true, value_parser = values::one_of(SAMPLERS))]
    pub sampler: Option<SamplerKind>,
    /// Stop after so many seconds of tracing, at the end of a pass; the picture has the samples that it then has.
    #[arg(long, value_name = "SECONDS", value_parser = values::seconds)]
    pub time_limit: Option<Duration>,
    /// Threads; without it, as many as there are cores.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Rays that are traced together; it changes the time and not the picture.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=16_777_216))]
    pub batch: Option<u32>,
    /// How paths are followed: many at a time from queue to queue, or one after the other without queues; it changes the time
    /// and not the picture.
    #[arg(long, value_name = "NAME", ignore_case = true, value_parser = values::one_of(EXECUTORS), default_value = "Wavefront")]
    pub executor: Executor,
    /// The camera, by name or number; without it, the scene's first.
    #[arg(long, value_name = "NAME")]
    pub camera: Option<String>,
    /// Render a part of the picture: left, top, width and height in pixels.
    #[arg(long, value_name = "X,Y,W,H", value_parser = values::window)]
    pub crop: Option<Window>,
    /// Chooses the pattern of samples.
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    #[command(flatten)]
    pub display: DisplayArguments,
    /// Take noise out of the picture when it is written, by a filter that keeps edges; faint detail in mirrors and shadows may go with it.
    /// An EXR stays as it was rendered.
    #[arg(long)]
    pub denoise: bool,
    /// Bits per channel of a PNG: 8, dithered, or 16.
    #[arg(long, value_name = "BITS", value_enum, default_value_t = PngBits::Eight)]
    pub png_depth: PngBits,
    /// Render again whenever the scene or a file that it refers to changes; Ctrl-C ends.
    #[arg(long, conflicts_with_all = ["stats", "trace", "time_limit"])]
    pub watch: bool,
    /// Render the frames A to B of a glTF file's animation, each to a file with its number.
    #[arg(long, value_name = "A..B", value_parser = values::frames, conflicts_with_all = ["time", "watch", "stats", "trace", "time_limit", "fireflies"])]
    pub frames: Option<RangeInclusive<u32>>,
    /// Frames in a second of the animation.
    #[arg(long, value_name = "N", value_parser = values::above_zero, default_value_t = 24.0)]
    pub fps: f32,
    /// Write counts and times as JSON.
    #[arg(long, value_name = "FILE.json")]
    pub stats: Option<PathBuf>,
    /// Write when every worker did what, for Perfetto.
    #[arg(long, value_name = "FILE.json")]
    pub trace: Option<PathBuf>,
    /// Say which contributions were the largest, and where they came from.
    #[arg(long, conflicts_with = "watch")]
    pub fireflies: bool,
    /// Write, in place of the picture, what another Fresnel model changes in it, over the same paths: .exr, the signed difference, or
    /// .png, its size.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["output", "watch", "frames", "stats", "trace", "time_limit", "fireflies"])]
    pub fresnel_error: Option<PathBuf>,
    /// The other model.
    #[arg(long, value_name = "NAME", ignore_case = true, value_parser = values::one_of(APPROXIMATIONS), default_value = "Schlick", requires = "fresnel_error")]
    pub approximation: FresnelModel,
    /// Say nothing but errors.
    #[arg(short, long)]
    pub quiet: bool,
}

const EXECUTORS: &[(&str, Executor)] = &[("Wavefront", Executor::Wavefront), ("Megakernel", Executor::Megakernel)];

const APPROXIMATIONS: &[(&str, FresnelModel)] =
    &[("Schlick", FresnelModel::Schlick), ("SchlickThetaM", FresnelModel::SchlickThetaM)];

const SAMPLERS: &[(&str, SamplerKind)] = &[("Sobol", SamplerKind::Sobol), ("Independent", SamplerKind::Independent)];

/// Bits per channel of a PNG.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum PngBits {
    /// Dithered.
    #[value(name = "8")]
    Eight,
    /// Rounded.
    #[value(name = "16")]
    Sixteen,
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let outputs = arguments.outputs()?;
    let terminal = Terminal::new(arguments.quiet);
    let interrupt = Interrupt::listen()?;
    let mut session = arguments.scene.session(arguments.settings())?;
    if let Some(path) = &arguments.fresnel_error {
        return models::run(arguments, &mut session, path, terminal, &interrupt);
    }
    if arguments.watch {
        return watch::run(arguments, &mut session, &outputs, terminal, &interrupt);
    }
    if let Some(frames) = &arguments.frames {
        return frames::run(arguments, frames.clone(), &mut session, &outputs, terminal, &interrupt);
    }

    let warnings = load(&mut session, terminal)?;
    let mut render = session.render(arguments.options())?;
    if let Some(guide) = render.guide() {
        let [photons, kept] = [guide.sent, guide.kept() as u64].map(|count| plural(count, "photon"));
        terminal.say(format_args!("guide    {}, {photons}, {kept} kept", duration(guide.time)));
    }
    let begin = Instant::now();
    let is_late = || arguments.time_limit.is_some_and(|limit| begin.elapsed() >= limit);
    let complete = trace(&mut render, terminal, || interrupt.asked() || is_late(), |_, _| true);
    if render.samples().most == 0 {
        if !interrupt.asked() {
            return Err(Failure::input("the time limit was over before the first sample; nothing is written"));
        }
        terminal.say("interrupted before the first sample; nothing is written");
        return Err(Failure::Interrupted);
    }
    let progress = terminal.begin("encode");
    let written = render.write(&outputs, &arguments.png(&session.buffers().settings));
    progress.end(duration(render.timeline().total("encode")));
    written?;
    if let Some(path) = &arguments.stats {
        render.write_stats(path)?;
    }
    if let Some(path) = &arguments.trace {
        render.write_trace(path)?;
    }
    summarize(&render, terminal, warnings);
    for note in session.warnings().iter().filter(|diagnostic| diagnostic.severity == Severity::Note) {
        terminal.say(format_args!("note     {}", note.message));
    }
    if arguments.fireflies {
        list("largest", &render.fireflies(), terminal);
    }
    for path in outputs.iter().chain(&arguments.stats).chain(&arguments.trace) {
        terminal.say(format_args!("wrote    {}", path.display()));
    }
    if complete || !interrupt.asked() { Ok(()) } else { Err(Failure::Interrupted) }
}

impl Arguments {
    /// Where the picture goes, checked before any work is done.
    fn outputs(&self) -> Result<Vec<PathBuf>, Failure> {
        if let Some(path) = &self.fresnel_error {
            if !matches!(Format::of(path), Ok(Format::Png | Format::Exr)) {
                return Err(Failure::Usage(format!("{}: a difference is an .exr or a .png file", path.display())));
            }
            values::check_writable(path)?;
            return Ok(Vec::new());
        }
        let mut outputs = self.output.clone();
        if outputs.is_empty() {
            let name = self.scene.scene.file_name().unwrap_or("picture".as_ref());
            outputs.push(Path::new(name).with_extension("png"));
        }
        for path in &outputs {
            Format::of(path).map_err(|error| Failure::Usage(error.to_string()))?;
        }
        let mut known = BTreeSet::new();
        for path in outputs.iter().chain(&self.stats).chain(&self.trace) {
            if !known.insert(path) {
                return Err(Failure::Usage(format!("{}: named for two files", path.display())));
            }
            values::check_writable(path)?;
        }
        Ok(outputs)
    }

    fn settings(&self) -> SettingsChoices {
        SettingsChoices {
            resolution: self.resolution,
            integrator: self.integrator,
            max_depth: self.max_depth,
            samples: self.samples,
            noise_threshold: self.noise_threshold,
            seed: self.seed,
            sampler: self.sampler,
            split_depth: self.split_depth,
            guiding: self.guiding,
            clamp: self.clamp,
        }
    }

    /// How the picture is rendered.
    pub(crate) fn options(&self) -> RenderOptions {
        let default = RenderOptions::default();
        let policy = Policy { ledger: true, executor: self.executor, ..Policy::default() };
        let policy = match self.batch {
            Some(rays) => Policy { batch: rays as usize, capacity: rays as usize, ..policy },
            None => policy,
        };
        RenderOptions {
            camera: self.camera.clone(),
            crop: self.crop,
            threads: self.threads.map_or(default.threads, usize::from),
            policy,
            // A pass is what a time limit may be late by.
            pass_time: self.time_limit.map_or(default.pass_time, |limit| default.pass_time.min(limit / 10)),
            keep: if self.output.iter().any(|path| matches!(Format::of(path), Ok(Format::Exr))) {
                Keep::ALL
            } else {
                Keep::default()
            },
            denoise: self.denoise,
            trace: self.trace.is_some(),
        }
    }

    /// How a PNG shows the picture.
    pub(crate) fn png(&self, settings: &Settings) -> PngSettings {
        let tone_map = match settings.tone_mapping {
            ToneMapping::None => ToneMap::None,
            ToneMapping::Srgb => ToneMap::Srgb,
            ToneMapping::Filmic => ToneMap::Filmic,
            ToneMapping::Aces => ToneMap::Aces,
            ToneMapping::Agx => ToneMap::Agx,
            ToneMapping::PbrNeutral => ToneMap::PbrNeutral,
        };
        let depth = match self.png_depth {
            PngBits::Eight => PngDepth::Eight,
            PngBits::Sixteen => PngDepth::Sixteen,
        };
        let display = self.display.over(Display { exposure: settings.exposure, tone_map });
        let alpha = if settings.backdrop == Backdrop::Transparent { PngAlpha::Straight } else { PngAlpha::Opaque };
        PngSettings { display, depth, alpha }
    }
}

/// Reads and flattens the scene; the number of warnings.
pub(crate) fn load(session: &mut Session, terminal: Terminal) -> Result<usize, Failure> {
    let progress = terminal.begin("load");
    let applied = session.load()?;
    let files = plural(session.dependencies().len() as u64, "file");
    let time = duration(session.timeline().total("load"));
    progress.end(format_args!("{time}, {files}, {}", plural(applied.spawned as u64, "entity")));
    let warnings = say_warnings(session, terminal);

    let progress = terminal.begin("flatten");
    session.flatten()?;
    let report = session.report();
    let rows = plural(report.rows_written() as u64, "row");
    progress.end(format_args!("{}, {rows}", duration(report.total())));
    let trees = report.mesh_trees;
    let progress = terminal.begin("trees");
    progress.end(format_args!(
        "{}, {} of {}, over {}",
        duration(tree_time(report)),
        plural(trees.built as u64, "mesh"),
        plural(trees.triangles as u64, "triangle"),
        plural(session.buffers().instances.len() as u64, "instance"),
    ));
    Ok(warnings)
}

/// Renders pass by pass until the picture is complete, `stop` says so, or `after`, which sees every pass, says not to go on.
/// Tells whether the picture is complete.
pub(crate) fn trace(
    render: &mut Render<'_>,
    terminal: Terminal,
    stop: impl Fn() -> bool + Sync,
    mut after: impl FnMut(&mut Render<'_>, &Progress) -> bool,
) -> bool {
    let pixels = render.film().order().len() as u64;
    let progress = terminal.count("trace", pixels * u64::from(render.samples().asked));
    let control = Control::default();
    watched(&control, &progress, &stop, || {
        while render.remaining() > 0 && !control.stopped() && !stop() {
            render.pass(&control);
            progress.remark(format!("{:.2} Mrays/s", rate(render)));
            if !after(render, &progress) {
                break;
            }
        }
    });
    let samples = render.samples();
    let time = duration(render.timeline().total("trace"));
    progress.end(format_args!("{time}, {:.2} Mrays/s", rate(render)));
    if render.is_complete() {
        return true;
    }
    let has = match samples.least == samples.most {
        true => format!("every pixel has {}", plural(u64::from(samples.most), "sample")),
        false => format!("pixels have {} to {}", samples.least, plural(u64::from(samples.most), "sample")),
    };
    terminal.say(format_args!("stopped  {has} of {}", samples.asked));
    false
}

/// Works while another thread shows how far it is, and asks for a stop when `stop` says so.
pub(crate) fn watched<T>(
    control: &Control,
    progress: &Progress,
    stop: impl Fn() -> bool + Sync,
    work: impl FnOnce() -> T,
) -> T {
    let ended = AtomicBool::new(false);
    thread::scope(|scope| {
        let watcher = scope.spawn(|| {
            while !ended.load(Ordering::Relaxed) {
                if stop() {
                    control.stop();
                }
                progress.advance(control.samples());
                thread::park_timeout(Duration::from_millis(50));
            }
        });
        // However the work ends, the watcher ends with it.
        let _end = OnDrop(|| {
            ended.store(true, Ordering::Relaxed);
            watcher.thread().unpark();
        });
        work()
    })
}

/// Runs something when it goes.
struct OnDrop<F: Fn()>(F);

impl<F: Fn()> Drop for OnDrop<F> {
    fn drop(&mut self) {
        (self.0)();
    }
}

/// Millions of rays a second so far.
fn rate(render: &Render<'_>) -> f64 {
    let seconds = render.timeline().total("trace").as_secs_f64();
    if seconds > 0.0 { render.stats().rays() as f64 / seconds * 1e-6 } else { 0.0 }
}

/// Says where the energy went that camera rays set out with, the mean of the channels.
fn energy(ledger: &Ledger, terminal: Terminal) {
    let mean = |energy: Energy| energy.value().iter().sum::<f64>() / 3.0;
    let launched = mean(ledger.entered) - mean(ledger.crossed) - mean(ledger.onward);
    if launched <= 0.0 {
        return;
    }
    terminal.say(format_args!("energy   of what camera rays set out with"));
    let roulette = mean(ledger.roulette_removed) - mean(ledger.roulette_added);
    let [[x, y, z], stray] = [ledger.z(), ledger.stray_z()];
    let stray = format!(", zero in mean: {:.1}, {:.1}, {:.1} standard errors", stray[0], stray[1], stray[2]);
    let rows = [
        ("escaped", mean(ledger.escaped), String::new()),
        ("to emitters", mean(ledger.emitters), String::new()),
        ("in surfaces", mean(ledger.absorbed), ", by theory".to_owned()),
        ("in media", mean(ledger.volume), String::new()),
        ("by free flights", mean(ledger.strayed), stray),
        ("cut by depth", mean(ledger.cut), String::new()),
        ("below surfaces", mean(ledger.below_surface), ", where shading normals point".to_owned()),
        ("by dispersion", -mean(ledger.recolored), ", zero in mean".to_owned()),
        ("by roulette", roulette, ", zero in mean".to_owned()),
        ("by sampling", mean(ledger.residual), format!(", zero in mean: {x:.1}, {y:.1}, {z:.1} standard errors")),
    ];
    for (name, part, note) in rows {
        if part != 0.0 {
            terminal.say(format_args!("  {name:16} {:>11.3}%{note}", 100.0 * part / launched));
        }
    }
}

/// Says where contributions came from.
fn list(what: &str, origins: &[NamedOrigin], terminal: Terminal) {
    for origin in origins {
        terminal.say(format_args!("{what:8} {origin}"));
    }
}

/// Says what was done, in how much time and memory.
fn summarize(render: &Render<'_>, terminal: Terminal, warnings: usize) {
    let stats = render.stats();
    let work: Duration = Stage::ALL.into_iter().map(|stage| stats.time(stage)).sum();
    terminal.say(format_args!("stages   {} over all threads", duration(work)));
    for stage in Stage::ALL {
        let time = stats.time(stage);
        if !time.is_zero() {
            let share = 100.0 * time.as_secs_f64() / work.as_secs_f64();
            terminal.say(format_args!("  {:16} {:>12} {share:>5.1}%", stage.name(), duration(time)));
        }
    }
    terminal.say(format_args!("rays     {}", count(stats.rays())));
    let traced = RaySource::APART.map(|source| (source.name(), stats.of_source(source).traced()));
    for (queue, rays) in traced.into_iter().chain([("shadow", stats.total().shadow_segments)]) {
        terminal.say(format_args!("  {queue:16} {:>12}", count(rays)));
    }
    energy(&stats.ledger(), terminal);
    let (film, samples) = (render.film(), render.samples());
    if samples.least < samples.most {
        let mean = samples.total as f64 / film.order().len() as f64;
        terminal.say(format_args!("samples  {} to {} a pixel, {mean:.1} on average", samples.least, samples.most));
    }
    for (number, what) in [(film.rejected(), "that are no light, left out"), (film.saturated(), "too bright, cut off")]
    {
        if number > 0 {
            terminal.say(format_args!("film     {} {what}", plural(number, "contribution")));
        }
    }
    list("no light", &render.not_light(), terminal);
    let clamped = stats.total().clamped.0.map(|sum| sum as f64 / (SCALE * samples.total.max(1) as f64));
    if let [r, g, b] = clamped
        && r + g + b > 0.0
    {
        terminal.say(format_args!("clamp    took {r:.5} {g:.5} {b:.5} off the picture's mean"));
    }
    if let Some(bytes) = peak_memory() {
        terminal.say(format_args!("memory   {} MiB at its peak", bytes.div_ceil(1 << 20)));
    }
    if warnings > 0 {
        terminal.say(format_args!("warnings {warnings}, above"));
    }
}
