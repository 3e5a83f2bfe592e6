//! A render: one picture of a session's scene, sample by sample.

use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use brewster_film::{
    Film, FilmError, Format, Keep, Metadata, PixelOrder, PngSettings, Window, write_atomically, write_picture,
};
use brewster_wavefront::guide::Guide;
use brewster_wavefront::{Control, Policy, Renderer, Stats};

use crate::origin::NamedOrigin;
use crate::pace::Pace;
use crate::stats::{self, StatsFile};
use crate::{PROGRAM, Session, SessionError, Timeline};

/// How a picture is rendered. Of these only the camera and the crop window change its bits.
#[derive(Clone, Debug)]
pub struct RenderOptions {
    /// The camera's name; `None` for the first.
    pub camera: Option<String>,
    /// The part of the picture that is rendered; `None` for all.
    pub crop: Option<Window>,
    /// Threads; at least 1.
    pub threads: usize,
    /// How batches are scheduled.
    pub policy: Policy,
    /// About how long a pass takes, after the first, which takes one sample: what a stop may have to wait for.
    pub pass_time: Duration,
    /// What the film keeps for the layers of an EXR beside those that are always there.
    pub keep: Keep,
    /// Whether pictures are denoised when they are written, for which the film keeps everything. What is in an EXR stays as it was
    /// rendered.
    pub denoise: bool,
    /// Whether to note what every worker did when, for [`Render::write_trace`].
    pub trace: bool,
}

impl Default for RenderOptions {
    /// All cores.
    fn default() -> Self {
        RenderOptions {
            camera: None,
            crop: None,
            threads: std::thread::available_parallelism().map_or(1, usize::from),
            policy: Policy::default(),
            pass_time: Duration::from_secs(1),
            keep: Keep::default(),
            denoise: false,
            trace: false,
        }
    }
}

/// How many samples a picture's pixels have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SampleCounts {
    /// Those that the settings ask for.
    pub asked: u32,
    /// Those of the pixel with the fewest: less than `most` only after a stop in the first pass or with a noise threshold.
    pub least: u32,
    /// Those of the pixel with the most.
    pub most: u32,
    /// Those of all pixels together.
    pub total: u64,
}

/// A picture that is being rendered.
pub struct Render<'s> {
    pub(crate) session: &'s Session,
    pub(crate) options: RenderOptions,
    pub(crate) camera: usize,
    pub(crate) timeline: Timeline,
    renderer: Renderer<'s>,
    /// When the renderer's clock began.
    start: Duration,
    film: Film,
    pace: Pace,
    done: u32,
    stopped: bool,
}

impl<'s> Render<'s> {
    pub(crate) fn new(session: &'s Session, options: RenderOptions) -> Result<Render<'s>, SessionError> {
        let buffers = session.buffers();
        let camera = session.camera(options.camera.as_deref())?;
        let order = PixelOrder::new(buffers.settings.resolution.x, buffers.settings.resolution.y, options.crop)?;
        let mut timeline = session.timeline().clone();
        let (begin, start) = (Instant::now(), timeline.now());
        let renderer = Renderer::new(buffers, camera, options.threads, options.policy, options.trace)?;
        let keep = if options.denoise { Keep::ALL } else { options.keep };
        let squares = keep.squares || buffers.settings.noise_threshold.is_some();
        let film = Film::keeping(order, Keep { squares, ..keep });
        timeline.note("prepare", begin);
        let pace = Pace::new(options.pass_time);
        Ok(Render { session, options, camera, timeline, renderer, start, film, pace, done: 0, stopped: false })
    }

    /// Samples per pixel that are still to be taken; none after a stop in the first pass.
    pub fn remaining(&self) -> u32 {
        if self.stopped { 0 } else { self.session.buffers().settings.samples - self.done }
    }

    /// Whether all pixels have the samples that are asked for, or all that the noise threshold lets them have.
    pub fn is_complete(&self) -> bool {
        !self.stopped && self.remaining() == 0
    }

    /// Adds samples to every pixel: first one, later as many as take about [`RenderOptions::pass_time`]. A stop ends the first
    /// pass after the batches that run, and nothing can be added then.
    pub fn pass(&mut self, control: &Control) {
        let samples = self.pace.next(self.remaining());
        if samples == 0 {
            return;
        }
        let begin = Instant::now();
        if self.renderer.pass(self.done..self.done + samples, &mut self.film, control) {
            self.done += samples;
            self.pace.learn(samples, begin.elapsed());
        } else {
            self.stopped = true;
        }
        self.timeline.note("trace", begin);
    }

    /// The picture so far.
    pub fn film(&self) -> &Film {
        &self.film
    }

    /// What guides rays, if anything does.
    pub fn guide(&self) -> Option<&Guide> {
        self.renderer.guide()
    }

    /// What was counted and timed so far.
    pub fn stats(&self) -> Stats {
        self.renderer.stats()
    }

    /// Contributions that were no light, at most [`KEPT`](brewster_wavefront::attribution::KEPT): the first by pixel and sample.
    pub fn not_light(&self) -> Vec<NamedOrigin> {
        let name = |origin| NamedOrigin::new(self.session, origin);
        self.stats().attribution.not_light().iter().map(name).collect()
    }

    /// The largest contributions that came by way of a surface, as many at most, the largest first.
    pub fn fireflies(&self) -> Vec<NamedOrigin> {
        let name = |origin| NamedOrigin::new(self.session, origin);
        self.stats().attribution.largest().iter().map(name).collect()
    }

    /// Samples per pixel so far.
    pub fn samples(&self) -> SampleCounts {
        let samples = self.film.pixels().samples;
        SampleCounts {
            asked: self.session.buffers().settings.samples,
            least: samples.iter().copied().min().unwrap_or(0),
            most: samples.iter().copied().max().unwrap_or(0),
            total: samples.iter().map(|&samples| u64::from(samples)).sum(),
        }
    }

    /// When what was done, this render's passes and files included.
    pub fn timeline(&self) -> &Timeline {
        &self.timeline
    }

    /// Writes the picture so far in the formats that the files' names tell, each whole or not at all. All are tried.
    ///
    /// # Errors
    ///
    /// The first file that cannot be written.
    pub fn write(&mut self, paths: &[PathBuf], png: &PngSettings) -> Result<(), FilmError> {
        let begin = Instant::now();
        let layers = self.film.resolve();
        let metadata = Metadata {
            scene_hash: stats::hash_text(self.session.hash()),
            settings: stats::settings_text(self),
            version: PROGRAM.to_owned(),
        };
        let denoised = self.options.denoise.then(|| {
            let mut denoised = layers.clone();
            denoised.denoise(self.options.threads);
            denoised
        });
        let mut result = Ok(());
        for path in paths {
            let shown = denoised.as_ref().filter(|_| !matches!(Format::of(path), Ok(Format::Exr)));
            result = result.and(write_picture(path, shown.unwrap_or(&layers), png, &metadata));
        }
        self.timeline.note("encode", begin);
        result
    }

    /// Counts and times as a file holds them.
    pub fn stats_file(&self) -> StatsFile {
        StatsFile::new(self)
    }

    /// Writes [`Render::stats_file`] as JSON.
    ///
    /// # Errors
    ///
    /// The file cannot be written.
    pub fn write_stats(&self, path: &Path) -> Result<(), FilmError> {
        let io_error = |source| FilmError::Io { path: path.to_path_buf(), source };
        write_atomically(path, |file| {
            serde_json::to_writer_pretty(&mut *file, &self.stats_file()).map_err(io::Error::from).map_err(io_error)?;
            io::Write::write_all(file, b"\n").map_err(io_error)
        })
    }

    /// Writes when what was done, in the trace format that Perfetto opens.
    ///
    /// # Errors
    ///
    /// The file cannot be written.
    pub fn write_trace(&self, path: &Path) -> Result<(), FilmError> {
        let io_error = |source| FilmError::Io { path: path.to_path_buf(), source };
        write_atomically(path, |file| {
            self.timeline.write_trace(self.renderer.timeline(), self.start, file).map_err(io_error)
        })
    }
}
