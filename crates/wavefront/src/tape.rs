//! Tapes: the rays of one step of a batch, kept to go through that step again and again.
//!
//! A tape holds what waits in a queue before the step, with the samples and the sets of media that the rays name. A [`Replay`] runs
//! the ordinary step on it and tells each stage's time, or one stage alone from what the stages before it leave. What comes out is
//! hashed, so that runs can be held against each other.

use std::fmt::Write as _;
use std::ops::Range;
use std::time::{Duration, Instant};

use brewster_buffers::SceneBuffers;
use brewster_film::{Film, FilmError, Light, PixelOrder};
use brewster_geometry::HitColumns;

use crate::batch::Batch;
use crate::context::Context;
use crate::integrator::{begin, bounce, step};
use crate::media::{MediaId, Medium};
use crate::policy::Policy;
use crate::queues::{
    ContributionQueue, NO_INSTANCE, PathRay, PathRayColumns, RaySource, Sample, SampleColumns, ShadowQueue,
};
use crate::random::PixelKey;
use crate::render::{Unsupported, check_integrator};
use crate::stats::{Counts, Recorder, Stage, Stats};

/// The rays of one step.
#[derive(Clone, Debug, PartialEq)]
pub struct Tape {
    /// Their depth.
    pub depth: u32,
    /// The queue that they wait in.
    pub source: RaySource,
    /// The rays. Their samples are rows of `samples`, their media rows of `media`.
    pub rays: PathRayColumns,
    /// The samples, by column and row of the pixel and number.
    pub samples: Vec<[u32; 3]>,
    /// The sets of media: rows of dielectrics in the order in which they were entered.
    pub media: Vec<Vec<u32>>,
}

/// Why a tape cannot be recorded or replayed.
#[derive(Debug)]
pub enum TapeError {
    /// The scene cannot be rendered.
    Unsupported(Unsupported),
    /// The picture is too large.
    Film(FilmError),
    /// No ray comes to the queue.
    Nothing,
    /// The tape does not fit the scene: what is wrong with it.
    Unfit(&'static str),
    /// The stage came to something else when it ran again.
    Unsteady(Stage),
}

impl std::fmt::Display for TapeError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            TapeError::Unsupported(error) => error.fmt(f),
            TapeError::Film(error) => error.fmt(f),
            TapeError::Nothing => write!(f, "no ray of this picture comes to that depth and queue"),
            TapeError::Unfit(why) => write!(f, "the tape does not fit the scene: {why}"),
            TapeError::Unsteady(stage) => write!(f, "{} does not come to the same in every run", stage.name()),
        }
    }
}

impl std::error::Error for TapeError {}

impl From<Unsupported> for TapeError {
    fn from(error: Unsupported) -> TapeError {
        TapeError::Unsupported(error)
    }
}

impl Tape {
    /// Records the rays of a queue at a depth: of the first batch that fills half of the capacity, or else of the fullest one.
    ///
    /// # Errors
    ///
    /// The scene cannot be rendered, or no ray comes there.
    pub fn record(
        scene: &SceneBuffers,
        camera: usize,
        policy: Policy,
        at: (u32, RaySource),
    ) -> Result<Tape, TapeError> {
        let (context, mut film) = prepared(scene, camera, policy)?;
        let samples = scene.settings.samples;
        let pixels = (policy.batch / samples as usize).max(1);
        let mut best: Option<Tape> = None;
        for mut tile in film.tiles_mut(pixels) {
            let mut batch = batch_of(scene, policy.capacity);
            begin(&context, 0..samples, &mut batch, &tile);
            while let Some(next) = batch.levels.next(policy.order) {
                if next == at {
                    batch.levels.take(policy.order, &mut batch.rays);
                    let fullest = best.as_ref().map_or(0, |tape| tape.rays.len());
                    if batch.rays.len() > fullest {
                        best = Some(Tape::of(&batch, at));
                    }
                    break;
                }
                step(&context, &mut batch, &mut tile);
            }
            if best.as_ref().is_some_and(|tape| 2 * tape.rays.len() >= policy.capacity) {
                break;
            }
        }
        best.ok_or(TapeError::Nothing)
    }

    /// The rays that a batch has taken, with what they name.
    fn of(batch: &Batch, (depth, source): (u32, RaySource)) -> Tape {
        let (mut ids, mut media): (Vec<MediaId>, Vec<Vec<u32>>) = Default::default();
        let mut rays = PathRayColumns::new();
        for row in 0..batch.rays.len() {
            let ray = batch.rays.get(row);
            let set = ids.iter().position(|&id| id == ray.media).unwrap_or_else(|| {
                ids.push(ray.media);
                media.push(batch.stacks.entered(ray.media).iter().map(|medium| medium.0).collect());
                ids.len() - 1
            });
            rays.push(PathRay { media: MediaId(set as u32), ..ray });
        }
        let samples = batch.samples.view();
        let sample = |row: usize| {
            let (x, y) = samples.key[row].place();
            [x, y, samples.number[row]]
        };
        Tape { depth, source, rays, samples: (0..samples.len()).map(sample).collect(), media }
    }

    /// Whether everything that the rays name is there.
    fn check(&self, scene: &SceneBuffers) -> Result<(), TapeError> {
        let (rays, settings) = (self.rays.view(), &scene.settings);
        let [width, height] = settings.resolution.to_array();
        let below = |ids: &[u32], end: usize| ids.iter().all(|&id| (id as usize) < end);
        let left = rays.instance.iter().filter(|&&id| id != NO_INSTANCE);
        let cases = [
            (!rays.is_empty(), "it holds no rays"),
            (self.depth <= settings.max_depth, "its depth is beyond the maximum"),
            (below(rays.sample, self.samples.len()), "a ray is of no sample"),
            (rays.media.iter().all(|id| (id.0 as usize) < self.media.len()), "a ray is in no set of media"),
            (left.into_iter().all(|&id| (id as usize) < scene.instances.len()), "a ray left no instance"),
            (self.media.iter().all(|set| below(set, scene.materials.dielectric.len())), "a medium is no dielectric"),
            (
                self.samples.iter().all(|&[x, y, n]| x < width && y < height && n < settings.samples),
                "a sample is not in the picture",
            ),
        ];
        cases.into_iter().find(|(holds, _)| !holds).map_or(Ok(()), |(_, why)| Err(TapeError::Unfit(why)))
    }
}

/// What a run of a step came to.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// The stages that ran, the rays into each, and their times.
    pub stages: Vec<(Stage, u64, Duration)>,
    /// A hash of the hits, the light, and the rays that were sent on.
    pub hash: u64,
}

/// What runs of one stage alone came to.
#[derive(Clone, Debug, PartialEq)]
pub struct Alone {
    /// How often the step calls it.
    pub calls: u32,
    /// Rays into it, of all calls together.
    pub rays: u64,
    /// The time of all calls, run by run.
    pub times: Vec<Duration>,
    /// A hash of all queues behind every call.
    pub hash: u64,
}

/// A tape, ready to be run.
#[derive(Debug)]
pub struct Replay<'a> {
    context: Context<'a>,
    batch: Batch,
    film: Film,
    tape: &'a Tape,
}

impl<'a> Replay<'a> {
    /// Makes ready to run a tape that was recorded with this scene and camera.
    ///
    /// # Errors
    ///
    /// The scene cannot be rendered, or the tape does not fit it.
    pub fn new(scene: &'a SceneBuffers, camera: usize, policy: Policy, tape: &'a Tape) -> Result<Self, TapeError> {
        let policy = Policy { capacity: tape.rays.len().max(1), ..policy };
        let (context, film) = prepared(scene, camera, policy)?;
        tape.check(scene)?;
        Ok(Replay { context, batch: batch_of(scene, policy.capacity), film, tape })
    }

    /// Runs the step once.
    pub fn run(&mut self) -> Run {
        self.load();
        self.calls(0..u64::MAX);
        let hash = result_hash(&mut self.batch, self.tape.depth);
        let at = &self.batch.recorder.stats.depths[self.tape.depth as usize];
        let (counts, times) = (&at.counts[self.tape.source as usize], &at.times[self.tape.source as usize]);
        let stages = Stage::ALL.into_iter().filter(|&stage| counts.stages[stage as usize] > 0);
        let stages = stages.map(|stage| (stage, counts.stages[stage as usize], times[stage as usize])).collect();
        Run { stages, hash }
    }

    /// Runs one stage alone, again and again: goes through the step call by call, and at each call of the stage, of which there may be
    /// one for every kind of material, keeps what it finds, to run it from there so many times. No ray, no call.
    ///
    /// # Errors
    ///
    /// A run comes to something else than the first one, or all calls together to something else than the step at once.
    pub fn run_alone(&mut self, stage: Stage, runs: usize) -> Result<Alone, TapeError> {
        let whole = self.run();
        let calls = self.batch.recorder.calls;
        self.load();
        let mut kept = Kept::default();
        let mut alone = Alone { calls: 0, rays: 0, times: vec![Duration::ZERO; runs], hash: FNV };
        let mut counted = Vec::new();
        for call in 0..calls {
            kept.keep(&mut self.batch, self.tape.depth);
            self.film.clear();
            let (counts, _) = self.calls(call..call + 1);
            counted.push(counts);
            let rays = counts.stages[stage as usize];
            if rays == 0 {
                continue;
            }
            let first = self.queues_hash();
            for time in &mut alone.times {
                kept.restore(&mut self.batch, self.tape.depth);
                self.film.clear();
                let (again, times) = self.calls(call..call + 1);
                *time += times[stage as usize];
                if again != counts || self.queues_hash() != first {
                    return Err(TapeError::Unsteady(stage));
                }
            }
            alone.calls += 1;
            alone.rays += rays;
            alone.hash = (alone.hash ^ first).wrapping_mul(PRIME);
        }
        let into = |stage: &(Stage, u64, Duration)| {
            stage.1 == counted.iter().map(|counts| counts.stages[stage.0 as usize]).sum::<u64>()
        };
        let same = result_hash(&mut self.batch, self.tape.depth) == whole.hash && whole.stages.iter().all(into);
        if same { Ok(alone) } else { Err(TapeError::Unsteady(stage)) }
    }

    /// Runs some of the step's calls of stages, by number, and tells what they counted and how long they took.
    fn calls(&mut self, window: Range<u64>) -> (Counts, [Duration; Stage::ALL.len()]) {
        let Replay { context, batch, film, tape } = self;
        batch.recorder.stats = Stats::new(context.scene.settings.max_depth);
        (batch.recorder.window, batch.recorder.calls) = (window, 0);
        bounce(context, (tape.depth, tape.source), batch, &mut film.tile_mut());
        let at = &batch.recorder.stats.depths[tape.depth as usize];
        (at.counts[tape.source as usize], at.times[tape.source as usize])
    }

    /// Hashes what is in the queues, by its text, and the film's pixels of the samples.
    fn queues_hash(&self) -> u64 {
        let Batch { levels, rays, hits, sorted, draws, shadows, contributions, samples, .. } = &self.batch;
        let mut hash = TextHash(FNV);
        let pixels = self.film.pixels();
        let of_samples = samples.view().pixel.iter().map(|&pixel| pixels.get(pixel as usize)).collect::<Vec<_>>();
        let all = (levels, rays, hits, sorted, draws, shadows, contributions, samples, of_samples);
        write!(hash, "{all:?}").expect("a hash takes all that is written");
        hash.0
    }

    /// Makes the batch what it is when the step begins: the tape's rays are taken.
    fn load(&mut self) {
        let Replay { context, batch, film, tape } = self;
        film.clear();
        batch.stacks.reset();
        let dielectrics = context.scene.materials.dielectric.view();
        let enter = |set: &Vec<u32>| {
            let set: Vec<Medium> = set.iter().map(|&row| Medium(row)).collect();
            batch.stacks.enter_all(&set, &dielectrics)
        };
        let media: Vec<MediaId> = tape.media.iter().map(enter).collect();
        batch.samples.clear();
        for &[x, y, number] in &tape.samples {
            let pixel = film.order().index(x, y).expect("samples were checked");
            let key = PixelKey::new(x, y);
            batch.samples.push(Sample { pixel, key, number, light: Light::NONE, rays: 0, rejected: 0 });
        }
        batch.rays.clear();
        for row in 0..tape.rays.len() {
            let ray = tape.rays.get(row);
            batch.rays.push(PathRay { media: media[ray.media.0 as usize], ..ray });
        }
    }
}

/// What stages take from a batch or change in their place, and how many rays wait behind the step. All else that stages write they
/// empty before, or write to the same once more.
#[derive(Debug, Default)]
struct Kept {
    rays: PathRayColumns,
    hits: HitColumns,
    samples: SampleColumns,
    shadows: ShadowQueue,
    contributions: ContributionQueue,
    /// Transmissions of this depth, reflections and transmissions of the next.
    waiting: [usize; 3],
}

impl Kept {
    fn keep(&mut self, batch: &mut Batch, depth: u32) {
        macro_rules! copy {
            ($($column:ident)*) => {$(
                self.$column.clear();
                self.$column.extend_from_view(batch.$column.view());
            )*};
        }
        copy!(rays hits samples shadows contributions);
        let (here, next) = batch.levels.at(depth);
        let [reflections, transmissions] = next.map_or([0; 2], |next| [next.reflection.len(), next.transmission.len()]);
        self.waiting = [here.transmission.len(), reflections, transmissions];
    }

    /// Puts it back into the same memory.
    fn restore(&self, batch: &mut Batch, depth: u32) {
        macro_rules! copy {
            ($($column:ident)*) => {$(
                batch.$column.clear();
                batch.$column.extend_from_view(self.$column.view());
            )*};
        }
        copy!(rays hits samples shadows contributions);
        let (here, next) = batch.levels.at(depth);
        here.transmission.truncate(self.waiting[0]);
        if let Some(next) = next {
            next.reflection.truncate(self.waiting[1]);
            next.transmission.truncate(self.waiting[2]);
        }
    }
}

/// FNV-1a's start and prime of 64 bits.
const FNV: u64 = 0xcbf2_9ce4_8422_2325;
const PRIME: u64 = 0x0000_0100_0000_01b3;

/// FNV-1a of what is written.
struct TextHash(u64);

impl std::fmt::Write for TextHash {
    fn write_str(&mut self, text: &str) -> std::fmt::Result {
        self.0 = text.bytes().fold(self.0, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(PRIME));
        Ok(())
    }
}

/// Hashes what a step has left, and takes the rays that it sent out of the queues.
fn result_hash(batch: &mut Batch, depth: u32) -> u64 {
    let mut hash = FNV;
    let mut add = |word: u32| {
        // FNV-1a, by words.
        hash = (hash ^ u64::from(word)).wrapping_mul(PRIME);
    };
    for row in 0..batch.hits.len() {
        let hit = batch.hits.get(row);
        [hit.t.to_bits(), hit.u.to_bits(), hit.v.to_bits(), hit.instance, hit.primitive].into_iter().for_each(&mut add);
    }
    for row in 0..batch.samples.len() {
        let sample = batch.samples.get(row);
        sample.light.0.into_iter().for_each(|sum| add(sum as u32 ^ (sum >> 32) as u32));
        [sample.rays, sample.rejected].into_iter().for_each(&mut add);
    }
    let mut taken = PathRayColumns::new();
    let mut add_rays = |taken: &PathRayColumns| {
        for row in 0..taken.len() {
            let ray = taken.get(row);
            let floats = [ray.origin_x, ray.origin_y, ray.origin_z, ray.direction_x, ray.direction_y, ray.direction_z];
            floats.into_iter().chain(ray.weight.to_array()).chain([ray.pdf]).for_each(|number| add(number.to_bits()));
            [ray.sample, ray.branch, ray.trail.bits(), ray.instance].into_iter().for_each(&mut add);
        }
    };
    let (here, next) = batch.levels.at(depth);
    here.transmission.take(usize::MAX, &mut taken);
    add_rays(&taken);
    if let Some(next) = next {
        next.reflection.take(usize::MAX, &mut taken);
        add_rays(&taken);
        next.transmission.take(usize::MAX, &mut taken);
        add_rays(&taken);
    }
    hash
}

/// What a step needs of a scene and its camera.
fn prepared(scene: &SceneBuffers, camera: usize, policy: Policy) -> Result<(Context<'_>, Film), TapeError> {
    let camera = scene.cameras.get(camera).ok_or(Unsupported::Camera(scene.cameras.len()))?;
    check_integrator(scene, camera)?;
    let [width, height] = scene.settings.resolution.to_array();
    let order = PixelOrder::new(width, height, None).map_err(TapeError::Film)?;
    Ok((Context::new(scene, camera, policy), Film::new(order)))
}

fn batch_of(scene: &SceneBuffers, capacity: usize) -> Batch {
    let depth = scene.settings.max_depth;
    Batch::new(depth, capacity, Recorder::new(depth, 0, Instant::now(), false))
}
