//! A render: passes over the picture, each of which adds some samples to every pixel.

use std::fmt;
use std::ops::Range;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Instant;

use brewster_buffers::{Camera, Integrator, SceneBuffers};
use brewster_film::Film;
use brewster_lanes::Level;
use glam::Vec3;

use crate::adaptive::{next_look, unfinished};
use crate::batch::Batch;
use crate::context::Context;
use crate::guide::Guide;
use crate::integrator::{megakernel, path, whitted};
use crate::media::media_around;
use crate::policy::{Executor, Policy};
use crate::stats::{Recorder, Span, Stats};
use crate::survey::Survey;

/// Why a scene cannot be rendered as it is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Unsupported {
    /// There is no such camera; the number of cameras that the scene has.
    Camera(usize),
    /// Something that the integrator does not render.
    Feature {
        /// The scene's integrator.
        integrator: Integrator,
        /// What it is, in words.
        what: &'static str,
    },
    /// The camera goes through the boundary of a medium while the shutter is open, or that boundary past the camera.
    MediaAtCamera,
    /// The pool of threads could not be started.
    Threads(String),
}

impl fmt::Display for Unsupported {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Unsupported::Camera(0) => write!(f, "the scene has no camera"),
            Unsupported::Camera(count) => write!(f, "the scene has {count} cameras, not the one asked for"),
            Unsupported::Feature { integrator, what } => {
                let other = match integrator {
                    Integrator::Whitted => Integrator::Path,
                    Integrator::Path => Integrator::Whitted,
                };
                write!(f, "the integrator {integrator:?} does not render {what}; {other:?} does")
            }
            Unsupported::MediaAtCamera => {
                write!(f, "the camera goes into a dielectric, or comes out of it, while the shutter is open")
            }
            Unsupported::Threads(why) => write!(f, "cannot start the threads: {why}"),
        }
    }
}

impl std::error::Error for Unsupported {}

/// What the integrator does not render; the table at the head of [`integrator`](crate::integrator) says it in full.
pub(crate) fn check_integrator(scene: &SceneBuffers, camera: &Camera) -> Result<(), Unsupported> {
    check_media(scene, camera)?;
    let (metal, dielectric) = (scene.materials.metal.view(), scene.materials.dielectric.view());
    let cases = match scene.settings.integrator {
        Integrator::Whitted => vec![
            (camera.aperture_radius > 0.0, "a lens"),
            (!scene.materials.rough_diffuse.is_empty(), "rough diffuse materials"),
            (metal.alpha.iter().any(|&alpha| alpha > 0.0), "rough metals"),
            (dielectric.alpha.iter().any(|&alpha| alpha > 0.0), "rough dielectrics"),
            (dielectric.thin.contains(&true), "thin dielectrics"),
            (dielectric.bare.contains(&true), "media without a surface"),
            (dielectric.scattering.iter().any(|&part| part != Vec3::ZERO), "media that scatter"),
            (metal.film.iter().chain(dielectric.film).any(Option::is_some), "thin films"),
        ],
        Integrator::Path => vec![
            (!scene.materials.phong.is_empty(), "Phong materials"),
            (scene.settings.transparent_shadows, "transparent shadows"),
        ],
    };
    let integrator = scene.settings.integrator;
    cases
        .into_iter()
        .find(|(holds, _)| *holds)
        .map_or(Ok(()), |(_, what)| Err(Unsupported::Feature { integrator, what }))
}

/// Whether the camera stays in its media while the shutter is open: rays begin in those around it when that opens.
fn check_media(scene: &SceneBuffers, camera: &Camera) -> Result<(), Unsupported> {
    const LOOKS: u32 = 32;
    if !scene.moves() && camera.motion.is_empty() {
        return Ok(());
    }
    let around = |look: u32| {
        let time = (look as f32 / LOOKS as f32).min(1.0f32.next_down());
        media_around(scene, camera.frame(time).position, time, Level::detect())
    };
    let first = around(0);
    if (1..=LOOKS).all(|look| around(look) == first) { Ok(()) } else { Err(Unsupported::MediaAtCamera) }
}

/// What a render and those who watch it tell each other, from any thread.
#[derive(Debug, Default)]
pub struct Control {
    stop: AtomicBool,
    samples: AtomicU64,
}

impl Control {
    /// Asks the render to stop: in the first pass after the batches that run, later at the end of the pass.
    pub fn stop(&self) {
        self.stop.store(true, Ordering::Relaxed);
    }

    /// Whether it was asked to stop.
    pub fn stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// Counts samples as finished.
    pub(crate) fn count(&self, samples: u64) {
        self.samples.fetch_add(samples, Ordering::Relaxed);
    }

    /// Samples finished so far, over all pixels.
    pub fn samples(&self) -> u64 {
        self.samples.load(Ordering::Relaxed)
    }
}

/// A scene, a camera and the workers that render them.
///
/// The picture does not depend on the number of threads, the policy or how samples are cut into passes.
#[derive(Debug)]
pub struct Renderer<'a> {
    context: Context<'a>,
    batches: Vec<Batch>,
    pool: rayon::ThreadPool,
}

impl<'a> Renderer<'a> {
    /// Makes ready to render a scene through its camera number `camera` on `threads` threads (at least one).
    ///
    /// # Errors
    ///
    /// What the scene holds cannot be rendered, or the threads cannot be started.
    pub fn new(
        scene: &'a SceneBuffers,
        camera: usize,
        threads: usize,
        policy: Policy,
        timeline: bool,
    ) -> Result<Renderer<'a>, Unsupported> {
        let camera = scene.cameras.get(camera).ok_or(Unsupported::Camera(scene.cameras.len()))?;
        check_integrator(scene, camera)?;
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads.max(1))
            .thread_name(|worker| format!("brewster-{worker}"))
            .build()
            .map_err(|error| Unsupported::Threads(error.to_string()))?;
        // Queues take the memory of their capacity: no more rays at once than the whole picture begins with.
        let settings = &scene.settings;
        let camera_rays = settings.resolution.as_u64vec2().element_product() * u64::from(settings.samples);
        let policy = Policy { capacity: policy.capacity.min(camera_rays as usize).max(1), ..policy };
        let epoch = Instant::now();
        let batches = (0..threads.max(1) as u32)
            .map(|worker| {
                let mut recorder = Recorder::new(settings.max_depth, worker, epoch, timeline);
                recorder.survey = policy.survey.then(|| Survey::new(settings.max_depth));
                Batch::new(settings.max_depth, policy.capacity, recorder)
            })
            .collect();
        let context = pool.install(|| Context::new(scene, camera, policy));
        Ok(Renderer { context, batches, pool })
    }

    /// Adds samples to every pixel of the film, or, if it is stopped in the pass that holds sample 0, to those of the batches
    /// that had begun. Tells whether all pixels got them.
    ///
    /// Samples are numbered from 0 to the scene's number of samples; panics beyond. With a noise threshold, they are added to
    /// those pixels that have got all before them and are not [finished](Film::noise); panics if the film does not keep squares.
    pub fn pass(&mut self, samples: Range<u32>, film: &mut Film, control: &Control) -> bool {
        let settings = &self.context.scene.settings;
        assert!(samples.end <= settings.samples, "samples {samples:?} are not in the scene's");
        let Some(threshold) = settings.noise_threshold else {
            let all = 0..film.order().len() as u32;
            return self.pass_over(&[all], samples, film, control);
        };
        let mut start = samples.start;
        while start < samples.end {
            let end = next_look(start).min(samples.end);
            if !self.pass_over(&unfinished(film, start, threshold), start..end, film, control) {
                return false;
            }
            start = end;
        }
        true
    }

    /// Adds samples to some runs of pixels.
    fn pass_over(&mut self, runs: &[Range<u32>], samples: Range<u32>, film: &mut Film, control: &Control) -> bool {
        let first = samples.start == 0;
        let pixels = (self.context.policy.batch / samples.len().max(1)).max(1);
        let tiles = Mutex::new(film.tiles_of(runs, pixels).into_iter());
        let context = &self.context;
        self.pool.scope(|scope| {
            for batch in &mut self.batches {
                let (tiles, samples) = (&tiles, &samples);
                scope.spawn(move |_| {
                    while !(first && control.stopped()) {
                        let next = tiles.lock().expect("no holder of the lock can panic").next();
                        let Some(mut tile) = next else { break };
                        let follow = match (context.policy.executor, context.scene.settings.integrator) {
                            (Executor::Megakernel, _) => megakernel,
                            (Executor::Wavefront, Integrator::Whitted) => whitted,
                            (Executor::Wavefront, Integrator::Path) => path,
                        };
                        follow(context, samples.clone(), batch, &mut tile);
                        control.count((tile.len() * samples.len()) as u64);
                    }
                });
            }
        });
        let unfinished = tiles.into_inner().expect("no holder of the lock can panic").len();
        unfinished == 0
    }

    /// What guides rays, if anything does.
    pub fn guide(&self) -> Option<&Guide> {
        self.context.guide.as_ref()
    }

    /// Counts and times of all passes so far.
    pub fn stats(&self) -> Stats {
        let mut sum = Stats::new(self.context.scene.settings.max_depth);
        for batch in &self.batches {
            sum.add(&batch.recorder.stats);
            sum.attribution.merge(&batch.attribution);
            sum.queue_bytes = sum.queue_bytes.max(batch.queue_bytes());
        }
        sum
    }

    /// Forgets the counts and times of all passes so far, and what the queues looked like, as after a warm-up.
    pub fn restart_stats(&mut self) {
        let max_depth = self.context.scene.settings.max_depth;
        for Batch { recorder, .. } in &mut self.batches {
            recorder.stats = Stats::new(max_depth);
            recorder.survey = recorder.survey.as_ref().map(|_| Survey::new(max_depth));
        }
    }

    /// What the queues looked like in all passes so far, if the policy asks for that.
    pub fn survey(&self) -> Option<Survey> {
        let mut surveys = self.batches.iter().filter_map(|batch| batch.recorder.survey.as_ref());
        let mut sum = surveys.next()?.clone();
        surveys.for_each(|survey| sum.add(survey));
        Some(sum)
    }

    /// Every stretch of time that a worker spent in a stage, if a timeline was asked for.
    pub fn timeline(&self) -> impl Iterator<Item = &Span> {
        self.batches.iter().flat_map(|batch| batch.recorder.timeline.iter().flatten())
    }
}
