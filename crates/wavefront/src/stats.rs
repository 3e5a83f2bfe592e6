//! Counts and times: per depth, queue and stage.
//!
//! Counts are sums over rays and do not depend on threads, batches or policies. Times do.

use std::ops::Range;
use std::time::{Duration, Instant};

use brewster_buffers::Integrator;
use brewster_film::Light;

use crate::attribution::Attribution;
use crate::ledger::Ledger;
use crate::queues::RaySource;
use crate::survey::Survey;

/// The stages of a bounce, in order; the only list of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u8)]
pub enum Stage {
    /// Makes camera rays.
    Generate,
    /// Orders rays.
    Order,
    /// Finds the closest hits.
    Trace,
    /// Weakens rays by the medium they went through.
    Absorb,
    /// In its place where media scatter or have no surface: takes rays through them.
    Fly,
    /// Parts hits by kind of material, and those that escaped.
    Sort,
    /// Lets rays cross boundaries that are none.
    Cross,
    /// Writes down what camera rays hit first.
    Record,
    /// Gives escaped rays the background.
    Escape,
    /// Shades hits on Phong materials.
    ShadePhong,
    /// Shades hits on Lambert materials.
    ShadeLambert,
    /// Shades hits on metals.
    ShadeMetal,
    /// Shades hits on dielectrics.
    ShadeDielectric,
    /// Shades hits on emissive surfaces.
    ShadeEmissive,
    /// Gives hits on principled materials the light that these send out.
    Glow,
    /// Draws the random numbers of hits.
    Draw,
    /// Scatters at Lambert materials.
    ScatterLambert,
    /// Scatters at rough diffuse materials.
    ScatterRoughDiffuse,
    /// Scatters at metals.
    ScatterMetal,
    /// Scatters at dielectrics.
    ScatterDielectric,
    /// Scatters at principled materials.
    ScatterPrincipled,
    /// Scatters at coated materials.
    ScatterCoated,
    /// Scatters in media.
    ScatterMedium,
    /// Tests rays toward lights.
    Shadow,
    /// Adds contributions to their samples.
    Gather,
    /// Adds finished samples to the film.
    Fold,
}

impl Stage {
    /// All stages.
    pub const ALL: [Stage; 26] = [
        Stage::Generate,
        Stage::Order,
        Stage::Trace,
        Stage::Absorb,
        Stage::Fly,
        Stage::Sort,
        Stage::Cross,
        Stage::Record,
        Stage::Escape,
        Stage::ShadePhong,
        Stage::ShadeLambert,
        Stage::ShadeMetal,
        Stage::ShadeDielectric,
        Stage::ShadeEmissive,
        Stage::Glow,
        Stage::Draw,
        Stage::ScatterLambert,
        Stage::ScatterRoughDiffuse,
        Stage::ScatterMetal,
        Stage::ScatterDielectric,
        Stage::ScatterPrincipled,
        Stage::ScatterCoated,
        Stage::ScatterMedium,
        Stage::Shadow,
        Stage::Gather,
        Stage::Fold,
    ];

    /// Whether an integrator has this stage.
    pub fn runs_in(self, integrator: Integrator) -> bool {
        match self {
            Stage::ShadePhong | Stage::ShadeLambert | Stage::ShadeMetal | Stage::ShadeDielectric => {
                integrator == Integrator::Whitted
            }
            Stage::Fly
            | Stage::Glow
            | Stage::Draw
            | Stage::ScatterLambert
            | Stage::ScatterRoughDiffuse
            | Stage::ScatterMetal
            | Stage::ScatterDielectric
            | Stage::ScatterPrincipled
            | Stage::ScatterCoated
            | Stage::ScatterMedium => integrator == Integrator::Path,
            _ => true,
        }
    }

    /// The name used in files, counters and reports: that of the function.
    pub fn name(self) -> &'static str {
        match self {
            Stage::Generate => "generate",
            Stage::Order => "order",
            Stage::Trace => "trace",
            Stage::Absorb => "absorb",
            Stage::Fly => "fly",
            Stage::Sort => "sort",
            Stage::Cross => "cross",
            Stage::Record => "record",
            Stage::Escape => "escape",
            Stage::ShadePhong => "shade_phong",
            Stage::ShadeLambert => "shade_lambert",
            Stage::ShadeMetal => "shade_metal",
            Stage::ShadeDielectric => "shade_dielectric",
            Stage::ShadeEmissive => "shade_emissive",
            Stage::Glow => "glow",
            Stage::Draw => "draw",
            Stage::ScatterLambert => "scatter_lambert",
            Stage::ScatterRoughDiffuse => "scatter_rough_diffuse",
            Stage::ScatterMetal => "scatter_metal",
            Stage::ScatterDielectric => "scatter_dielectric",
            Stage::ScatterPrincipled => "scatter_principled",
            Stage::ScatterCoated => "scatter_coated",
            Stage::ScatterMedium => "scatter_medium",
            Stage::Shadow => "shadow",
            Stage::Gather => "gather",
            Stage::Fold => "fold",
        }
    }
}

/// What happened to the rays of one depth and queue.
///
/// Every ray traced is a hit, a crossing, scattered in a medium or escaped; every hit is shaded once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Rays into each stage, in the order of [`Stage::ALL`].
    pub stages: [u64; Stage::ALL.len()],
    /// Rays that met nothing.
    pub escaped: u64,
    /// Rays that were traced on behind surfaces that were not there, and behind boundaries without a surface, each time.
    pub passed: u64,
    /// Hits on boundaries that are none.
    pub crossings: u64,
    /// Rays that a medium scattered before they met anything.
    pub scatterings: u64,
    /// Rays that met a surface.
    pub hits: u64,
    /// Rays sent into the reflection queue of the next depth.
    pub reflections: u64,
    /// Rays sent into the transmission queue of the next depth.
    pub transmissions: u64,
    /// Hits on dielectrics that reflect everything (total internal reflection).
    pub totally_reflected: u64,
    /// Reflections and transmissions not followed because they lie beyond the maximum depth.
    pub cut_by_depth: u64,
    /// Reflections and transmissions not followed because their weight lies below the threshold.
    pub below_threshold: u64,
    /// Paths ended by chance because they had become too weak; those that chance spared weigh more.
    pub given_up: u64,
    /// Scattered rays that came out black, nowhere or as no number: what the surface absorbed, by its sampler's choice.
    pub absorbed: u64,
    /// Scattered rays beyond one a hit, where a split sends two.
    pub branched: u64,
    /// Where the energy went, if the policy asks for a ledger.
    pub ledger: Ledger,
    /// Light that the scene's clamp held back.
    pub clamped: Light,
    /// Rays sent toward lights.
    pub shadow_rays: u64,
    /// Those that something stopped.
    pub shadowed: u64,
    /// Rays traced on behalf of shadow rays; more than `shadow_rays` where these pass dielectrics.
    pub shadow_segments: u64,
}

impl Counts {
    /// Rays that entered `trace`.
    pub fn traced(&self) -> u64 {
        self.stages[Stage::Trace as usize]
    }

    fn add(&mut self, other: &Counts) {
        for (sum, count) in self.stages.iter_mut().zip(other.stages) {
            *sum += count;
        }
        self.escaped += other.escaped;
        self.passed += other.passed;
        self.crossings += other.crossings;
        self.scatterings += other.scatterings;
        self.hits += other.hits;
        self.reflections += other.reflections;
        self.transmissions += other.transmissions;
        self.totally_reflected += other.totally_reflected;
        self.cut_by_depth += other.cut_by_depth;
        self.below_threshold += other.below_threshold;
        self.given_up += other.given_up;
        self.absorbed += other.absorbed;
        self.branched += other.branched;
        self.ledger.merge(&other.ledger);
        self.clamped.add(other.clamped);
        self.shadow_rays += other.shadow_rays;
        self.shadowed += other.shadowed;
        self.shadow_segments += other.shadow_segments;
    }
}

/// Counts and times of one depth, by queue in the order of [`RaySource::ALL`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DepthStats {
    /// What happened to the rays.
    pub counts: [Counts; RaySource::ALL.len()],
    /// Time spent in each stage, in the order of [`Stage::ALL`], summed over threads.
    pub times: [[Duration; Stage::ALL.len()]; RaySource::ALL.len()],
}

impl DepthStats {
    /// What happened to the rays of all queues: the same however these are taken.
    pub fn total(&self) -> Counts {
        let mut sum = Counts::default();
        self.counts.iter().for_each(|counts| sum.add(counts));
        sum
    }

    /// Where the energy of all queues' rays went.
    pub fn ledger(&self) -> Ledger {
        let mut sum = Ledger::default();
        self.counts.iter().for_each(|counts| sum.merge(&counts.ledger));
        sum
    }
}

/// One stretch of time spent in a stage, for a timeline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// The stage.
    pub stage: Stage,
    /// The rays' depth.
    pub depth: u32,
    /// The rays' queue.
    pub source: RaySource,
    /// Rays that went in.
    pub rays: u32,
    /// The worker, from 0.
    pub worker: u32,
    /// When it began, from the start of the render.
    pub start: Duration,
    /// How long it took.
    pub time: Duration,
}

/// Counts and times of a render or a part of one.
#[derive(Clone, Debug, PartialEq)]
pub struct Stats {
    /// One a depth, from 0 to the maximum.
    pub depths: Vec<DepthStats>,
    /// The contributions that are worth a look.
    pub attribution: Attribution,
    /// The most bytes that one batch's queues took.
    pub queue_bytes: usize,
    /// Time spent where there are no stages to tell apart, by the megakernel.
    pub unstaged: Duration,
}

impl Stats {
    /// Nothing yet, for depths up to a maximum.
    pub fn new(max_depth: u32) -> Stats {
        let depths = vec![DepthStats::default(); max_depth as usize + 1];
        Stats { depths, attribution: Attribution::default(), queue_bytes: 0, unstaged: Duration::ZERO }
    }

    /// Adds what another part of the render counted.
    pub fn add(&mut self, other: &Stats) {
        for (sum, depth) in self.depths.iter_mut().zip(&other.depths) {
            for source in 0..RaySource::ALL.len() {
                sum.counts[source].add(&depth.counts[source]);
                for (time, other) in sum.times[source].iter_mut().zip(depth.times[source]) {
                    *time += other;
                }
            }
        }
        self.attribution.merge(&other.attribution);
        self.queue_bytes = self.queue_bytes.max(other.queue_bytes);
        self.unstaged += other.unstaged;
    }

    /// What happened to the rays of one queue, over all depths.
    pub fn of_source(&self, source: RaySource) -> Counts {
        let mut sum = Counts::default();
        for depth in &self.depths {
            sum.add(&depth.counts[source as usize]);
        }
        sum
    }

    /// Where the energy of all rays went.
    pub fn ledger(&self) -> Ledger {
        let mut sum = Ledger::default();
        self.depths.iter().for_each(|depth| sum.merge(&depth.ledger()));
        sum
    }

    /// What happened to all rays.
    pub fn total(&self) -> Counts {
        let mut sum = Counts::default();
        for source in RaySource::ALL {
            sum.add(&self.of_source(source));
        }
        sum
    }

    /// Time spent in a stage, summed over threads.
    pub fn time(&self, stage: Stage) -> Duration {
        self.depths.iter().flat_map(|depth| depth.times.iter().map(|times| times[stage as usize])).sum()
    }

    /// Rays traced of any kind, those toward lights too.
    pub fn rays(&self) -> u64 {
        let total = self.total();
        total.traced() + total.passed + total.shadow_segments
    }
}

/// Notes what a worker does. Its own cost is two clock readings a stage.
#[derive(Debug)]
pub struct Recorder {
    /// The sums so far.
    pub stats: Stats,
    /// Each stretch of time, if asked for.
    pub timeline: Option<Vec<Span>>,
    /// What the queues look like, if asked for.
    pub survey: Option<Survey>,
    /// The calls of stages that are run, by number; all others are left out.
    pub(crate) window: Range<u64>,
    /// Calls so far, with those that had no rays.
    pub(crate) calls: u64,
    worker: u32,
    epoch: Instant,
}

impl Recorder {
    /// A recorder of one worker; `epoch` is the start of the render.
    pub fn new(max_depth: u32, worker: u32, epoch: Instant, timeline: bool) -> Recorder {
        Recorder {
            stats: Stats::new(max_depth),
            timeline: timeline.then(Vec::new),
            survey: None,
            window: 0..u64::MAX,
            calls: 0,
            worker,
            epoch,
        }
    }

    /// Runs a stage over `rays` rays of a depth and queue, and notes the time and their number. Stages without rays are
    /// neither run nor noted.
    #[inline]
    pub fn stage(
        &mut self,
        (stage, depth, source): (Stage, u32, RaySource),
        rays: usize,
        run: impl FnOnce(&mut Counts),
    ) {
        let call = self.calls;
        self.calls += 1;
        if rays == 0 || !self.window.contains(&call) {
            return;
        }
        let start = Instant::now();
        let at = &mut self.stats.depths[depth as usize];
        at.counts[source as usize].stages[stage as usize] += rays as u64;
        run(&mut at.counts[source as usize]);
        let time = start.elapsed();
        at.times[source as usize][stage as usize] += time;
        if let Some(survey) = &mut self.survey {
            survey.call((stage, depth, source), rays);
        }
        if let Some(timeline) = &mut self.timeline {
            let start = start.duration_since(self.epoch);
            timeline.push(Span { stage, depth, source, rays: rays as u32, worker: self.worker, start, time });
        }
    }
}
