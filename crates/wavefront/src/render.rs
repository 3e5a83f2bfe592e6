//! A render: passes over the picture, each of which adds some samples to every pixel.

use std::fmt;
use std::ops::Range;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Instant;

use brewster_buffers::{Integrator, PixelFilter, SceneBuffers};
use brewster_film::{Film, Filter, FilterSampler};

use crate::batch::Batch;
use crate::context::Context;
use crate::integrator::whitted;
use crate::media::media_around;
use crate::pattern::pattern;
use crate::policy::Policy;
use crate::stats::{Recorder, Span, Stats};

/// Why a scene cannot be rendered as it is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Unsupported {
    /// There is no such camera; the number of cameras that the scene has.
    Camera(usize),
    /// A lens with an aperture, which the integrator `Whitted` does not have.
    Lens,
    /// An integrator that is none.
    Integrator(Integrator),
    /// What no material of the lectures does, in words; the integrator `Path` renders it.
    Material(&'static str),
    /// The pool of threads could not be started.
    Threads(String),
}

impl fmt::Display for Unsupported {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Unsupported::Camera(0) => write!(f, "the scene has no camera"),
            Unsupported::Camera(count) => write!(f, "the scene has {count} cameras, not the one asked for"),
            Unsupported::Lens => {
                write!(f, "the integrator Whitted renders pinhole and orthographic cameras, not a lens")
            }
            Unsupported::Integrator(integrator) => write!(f, "the integrator {integrator:?} renders nothing"),
            Unsupported::Material(what) => {
                write!(f, "the integrator Whitted does not render {what}; `integrator: Path` does")
            }
            Unsupported::Threads(why) => write!(f, "cannot start the threads: {why}"),
        }
    }
}

impl std::error::Error for Unsupported {}

/// What the integrator does not render.
fn check_integrator(scene: &SceneBuffers) -> Result<(), Unsupported> {
    if scene.settings.integrator == Integrator::Path {
        return Err(Unsupported::Integrator(Integrator::Path));
    }
    let (metal, dielectric) = (scene.materials.metal.view(), scene.materials.dielectric.view());
    let cases = [
        (!scene.materials.rough_diffuse.is_empty(), "rough diffuse materials"),
        (metal.alpha.iter().any(|&alpha| alpha > 0.0), "rough metals"),
        (dielectric.alpha.iter().any(|&alpha| alpha > 0.0), "rough dielectrics"),
        (dielectric.thin.contains(&true), "thin dielectrics"),
    ];
    cases.into_iter().try_for_each(|(holds, what)| if holds { Err(Unsupported::Material(what)) } else { Ok(()) })
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
        if camera.aperture_radius > 0.0 {
            return Err(Unsupported::Lens);
        }
        check_integrator(scene)?;
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads.max(1))
            .thread_name(|worker| format!("brewster-{worker}"))
            .build()
            .map_err(|error| Unsupported::Threads(error.to_string()))?;
        let settings = &scene.settings;
        // Queues take the memory of their capacity: no more rays at once than the whole picture begins with.
        let camera_rays = settings.resolution.as_u64vec2().element_product() * u64::from(settings.samples);
        let policy = Policy { capacity: policy.capacity.min(camera_rays as usize).max(1), ..policy };
        let filter = FilterSampler::new(match settings.filter {
            PixelFilter::Box => Filter::BOX,
            PixelFilter::Tent => Filter::TENT,
            PixelFilter::Gaussian => Filter::GAUSSIAN,
            PixelFilter::BlackmanHarris => Filter::BLACKMAN_HARRIS,
        })
        .expect("the built-in filters are valid");
        let epoch = Instant::now();
        let batches = (0..threads.max(1) as u32)
            .map(|worker| {
                let recorder = Recorder::new(settings.max_depth, worker, epoch, timeline);
                Batch::new(settings.max_depth, policy.capacity, recorder)
            })
            .collect();
        let context = Context {
            scene,
            geometry: scene.geometry(),
            camera,
            camera_media: media_around(scene, camera.position, policy.level),
            pattern: pattern(settings.samples, settings.seed, &filter),
            policy,
        };
        Ok(Renderer { context, batches, pool })
    }

    /// Adds samples to every pixel of the film, or, if it is stopped in the pass that holds sample 0, to those of the batches
    /// that had begun. Tells whether all pixels got them.
    ///
    /// Samples are numbered from 0 to the scene's number of samples; panics beyond.
    pub fn pass(&mut self, samples: Range<u32>, film: &mut Film, control: &Control) -> bool {
        assert!(samples.end as usize <= self.context.pattern.len(), "samples {samples:?} are not in the pattern");
        let first = samples.start == 0;
        let pixels = (self.context.policy.batch / samples.len().max(1)).max(1);
        let tiles = Mutex::new(film.tiles_mut(pixels).into_iter());
        let context = &self.context;
        self.pool.scope(|scope| {
            for batch in &mut self.batches {
                let (tiles, samples) = (&tiles, &samples);
                scope.spawn(move |_| {
                    while !(first && control.stopped()) {
                        let next = tiles.lock().expect("no holder of the lock can panic").next();
                        let Some(mut tile) = next else { break };
                        whitted(context, samples.clone(), batch, &mut tile);
                        control.samples.fetch_add((tile.len() * samples.len()) as u64, Ordering::Relaxed);
                    }
                });
            }
        });
        let unfinished = tiles.into_inner().expect("no holder of the lock can panic").len();
        unfinished == 0
    }

    /// Counts and times of all passes so far.
    pub fn stats(&self) -> Stats {
        let mut sum = Stats::new(self.context.scene.settings.max_depth);
        for batch in &self.batches {
            sum.add(&batch.recorder.stats);
            sum.queue_bytes = sum.queue_bytes.max(batch.queue_bytes());
        }
        sum
    }

    /// Every stretch of time that a worker spent in a stage, if a timeline was asked for.
    pub fn timeline(&self) -> impl Iterator<Item = &Span> {
        self.batches.iter().flat_map(|batch| batch.recorder.timeline.iter().flatten())
    }
}
