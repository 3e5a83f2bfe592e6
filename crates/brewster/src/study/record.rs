//! What a study found out, as files hold it. Fields may be added within a version; when one goes or gets another meaning,
//! [`VERSION`] is raised.

use brewster::import::study::Study;
use serde::Serialize;
use std::fmt::Write as _;

use super::counters::Counted;
use super::machine::Machine;
use super::measure::{Block, Clock};
use super::statistics::{Estimate, Verdict};

/// The version of the format.
pub(crate) const VERSION: u32 = 2;

/// All of it.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Results {
    pub version: u32,
    pub program: &'static str,
    /// The study's name.
    pub name: String,
    /// What it is about, in the author's words.
    pub text: String,
    /// The day, in UTC.
    pub date: String,
    /// The commit of the folder that the study was run in, with a mark where files differ from it.
    pub commit: Option<String>,
    /// Rounds asked for.
    pub rounds: u32,
    /// Whether all rounds were run.
    pub complete: bool,
    /// Intervals in the study that are judged, controls and comparisons: together they hold the truth with 95 %.
    pub intervals: usize,
    /// How often each of them does, so that all do.
    pub confidence: f64,
    pub machine: Machine,
    /// One for every scene and set of parameters.
    pub experiments: Vec<Experiment>,
    /// Where there are several sets of parameters, one for every scene.
    pub qualities: Vec<Quality>,
}

/// A scene rendered by every policy.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Experiment {
    pub scene: String,
    /// The set of parameters; empty where there is one only.
    pub parameters: String,
    pub integrator: String,
    pub resolution: [u32; 2],
    pub samples: u32,
    pub max_depth: u32,
    /// Rays of every kind.
    pub rays: u64,
    /// A hash of the film's sums, which every run had.
    pub picture: String,
    /// Whole rounds that were run.
    pub rounds: usize,
    /// The clock whose times are compared.
    pub clock: Clock,
    /// The baseline against itself.
    pub control: Option<Estimate>,
    /// Whether the control's interval holds 1, and rounds are enough for intervals of that confidence.
    pub trusted: bool,
    /// The largest part of a policy's time that looks at the clock take.
    pub overhead: f64,
    /// How trees were built, where policies differ in that: the baseline's way, the same once more as a control, then the others.
    pub builds: Vec<BuildResult>,
    /// The baseline first.
    pub policies: Vec<PolicyResult>,
    /// The baseline sample by sample, in a file of its own.
    #[serde(skip)]
    pub samples_apart: Vec<SampleRecord>,
}

/// What the baseline did for one sample of every pixel, or for a few where there are very many.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct SampleRecord {
    /// The number of the sample, or of the first one.
    pub sample: u32,
    /// How many they are.
    pub samples: u32,
    pub stages: Vec<StageRow>,
    pub queues: Vec<QueueRow>,
}

/// What a policy did.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct PolicyResult {
    pub name: String,
    /// Its settings in words.
    pub settings: String,
    pub batch: usize,
    /// Whether it differs from the baseline in its batch alone.
    pub of_batches: bool,
    /// The most bytes that one batch's queues took.
    pub queue_bytes: usize,
    /// Its two runs of every round with the baseline's around them; of the baseline, those with its twin.
    pub blocks: Vec<Block>,
    /// Rays of every kind a second, in millions, in the median run.
    pub rate: Option<f64>,
    /// How many times as fast as the baseline.
    pub speedup: Option<Estimate>,
    pub verdict: Option<Verdict>,
    /// The same on the wall's clock, where that of the processor is compared.
    pub wall_speedup: Option<Estimate>,
    /// What the processor and the kernel counted while one picture was rendered.
    pub counted: Vec<Counted>,
    pub stages: Vec<StageRow>,
    pub queues: Vec<QueueRow>,
}

/// What a way of building trees took.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct BuildResult {
    pub name: String,
    /// Bytes of the trees.
    pub bytes: usize,
    /// Its two runs of every round, on all threads, with the baseline's around them.
    pub blocks: Vec<Block>,
    /// Seconds of the median run.
    pub median: Option<f64>,
    /// How many times as fast as the baseline's way.
    pub speedup: Option<Estimate>,
    pub verdict: Option<Verdict>,
}

/// What a stage did at a depth for the rays of a queue.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct StageRow {
    pub depth: usize,
    pub queue: &'static str,
    pub stage: &'static str,
    pub rays: u64,
    /// How often it was called.
    pub calls: u64,
    /// The part of lanes that hold rays, of registers of sixteen lanes.
    pub occupancy: f64,
    /// Seconds over all threads, the mean of the runs.
    pub seconds: f64,
    /// Bytes of queues that it read.
    pub read: u64,
    /// Bytes of queues that it wrote.
    pub written: u64,
    /// Operations on numbers, by a count of the sources by hand.
    pub operations: u64,
    /// 10^9 operations a second, over all threads' time: with operations over bytes, its place on the roofline.
    pub rate: f64,
    /// The roof above that place, on one thread: what arithmetic lets through, or the memory that holds a batch's queues.
    pub roof: f64,
}

/// What the rays of a queue looked like at a depth.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct QueueRow {
    pub depth: usize,
    pub queue: &'static str,
    pub rays: u64,
    /// How often the queue was traced.
    pub taken: u64,
    /// How often there were 1, 2 to 3, 4 to 7 rays, and so on.
    pub lengths: Vec<u64>,
    /// Mean length of runs in one octant of directions.
    pub octant_run: f64,
    /// Mean length of runs that met one material.
    pub material_run: f64,
    /// Nodes visited by a ray, each alone.
    pub nodes: f64,
    /// Instances.
    pub instances: f64,
    /// Shapes and triangles.
    pub primitives: f64,
    /// Rays that its hits sent toward lights.
    pub shadow_rays: u64,
    /// Nodes visited by one of these.
    pub shadow_nodes: f64,
    /// Instances.
    pub shadow_instances: f64,
    /// Shapes and triangles.
    pub shadow_primitives: f64,
}

/// A scene with every set of parameters.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Quality {
    pub scene: String,
    /// Whole rounds that were run; in each, a set and the first one took two pictures each with seeds of their own.
    pub rounds: usize,
    /// The clock whose times are compared.
    pub clock: Clock,
    /// The first set's efficiency against itself.
    pub control: Option<Estimate>,
    pub trusted: bool,
    pub parameters: Vec<ParameterResult>,
}

/// What a set of parameters did.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct ParameterResult {
    pub name: String,
    pub settings: String,
    /// Its two runs of every round with the first set's around them; of the first set, those with its twin.
    pub blocks: Vec<Block>,
    /// Variance of pixels, the first set's and its own, each from two pictures of a round.
    pub variances: Vec<[f64; 2]>,
    /// 1 / (variance x seconds), in the median round.
    pub efficiency: Option<f64>,
    /// Efficiency over the first set's.
    pub ratio: Option<Estimate>,
    pub verdict: Option<Verdict>,
    /// How far the pictures differ from the first set's, in standard errors; none where that is not known.
    pub z: Option<f64>,
    /// How many bright events, of a block of pixels in all pictures, would make noise of such tails; none where it has none.
    pub events: Option<f64>,
    /// As many as there have to be for the spread to be known; with fewer neither efficiency nor z is judged.
    pub events_needed: Option<f64>,
}

impl Experiment {
    /// The scene, with the parameters where there are several sets.
    pub(crate) fn title(&self) -> String {
        match self.parameters.as_str() {
            "" => self.scene.clone(),
            parameters => format!("{}, {parameters}", self.scene),
        }
    }
}

impl ParameterResult {
    /// Why it is not judged although the control is even, if so.
    pub(crate) fn doubt(&self) -> Option<String> {
        let (events, needed) = self.events.zip(self.events_needed).filter(|(events, needed)| events < needed)?;
        let times =
            if events > 0.0 { format!("at least {:.0} times", (needed / events).ceil()) } else { "many times".into() };
        Some(format!(
            "noise comes from so few bright paths, {events:.1} for a block of pixels in all pictures, that its spread is not known; {times} the \
             samples, or the rounds, are needed for {needed:.0}"
        ))
    }
}

impl Results {
    /// Whether every round was run that the study asks for.
    pub(crate) fn is_whole(&self, study: &Study) -> bool {
        let (scenes, sets) = (study.scenes.len(), study.parameters.len());
        let mut rounds = self.experiments.iter().map(|experiment| experiment.rounds);
        let mut others = self.qualities.iter().map(|quality| quality.rounds);
        self.experiments.len() == scenes * sets
            && self.qualities.len() == if sets > 1 { scenes } else { 0 }
            && rounds.all(|rounds| rounds == study.policy_rounds() as usize)
            && others.all(|rounds| rounds == study.rounds as usize)
    }

    /// What came out, as plain text.
    pub(crate) fn summary(&self) -> String {
        let mut text = match self.intervals {
            0 => String::new(),
            intervals => {
                format!("{:.2} % intervals: all {intervals} together hold with 95 %\n", 100.0 * self.confidence)
            }
        };
        for experiment in &self.experiments {
            let rate = experiment.policies.first().and_then(|policy| policy.rate).unwrap_or(0.0);
            write!(text, "{}: baseline {rate:.2} Mrays/s", experiment.title()).expect(WRITES);
            let compares = experiment.policies.len() > 1;
            let control = if compares { control(experiment.control, experiment.trusted) } else { String::new() };
            writeln!(text, "{control}; looks at the clock took {}", clock_part(experiment.overhead)).expect(WRITES);
            for policy in experiment.policies.iter().skip(1) {
                text += &line(&policy.name, policy.speedup, policy.verdict, "");
            }
            for build in experiment.builds.iter().skip(2) {
                text += &line(&format!("building trees, {}", build.name), build.speedup, build.verdict, "");
            }
        }
        for quality in &self.qualities {
            writeln!(text, "{}: efficiency{}", quality.scene, control(quality.control, quality.trusted)).expect(WRITES);
            for set in quality.parameters.iter().skip(1) {
                let z = set.z.map_or(String::new(), |z| format!(", pictures differ by z = {z:.1}"));
                let z = set.doubt().map_or(z, |doubt| format!(": {doubt}"));
                text += &line(&set.name, set.ratio, set.verdict, &z);
            }
        }
        text
    }
}

/// The part of the time that looks at the clock took, in words. More than two parts in a hundred would be felt in what is measured.
pub(crate) fn clock_part(part: f64) -> String {
    let remark = if part > 0.02 { ", which is too much: larger batches need fewer" } else { "" };
    format!("{:.2} % of a policy's time at most{remark}", 100.0 * part)
}

const WRITES: &str = "a string takes all that is written";

fn control(control: Option<Estimate>, trusted: bool) -> String {
    match control {
        None => ", no whole round".to_owned(),
        Some(Estimate { median, low, high }) => {
            let remark = distrust(&Estimate { median, low, high }, trusted);
            format!(", against itself {median:.3} ({low:.3} to {high:.3}){remark}")
        }
    }
}

/// Why nothing is judged beside a control, if so.
pub(crate) fn distrust(control: &Estimate, trusted: bool) -> &'static str {
    match (trusted, control.is_even()) {
        (true, _) => "",
        (false, true) => ": rounds are too few for intervals of that confidence, and nothing is judged",
        (false, false) => ": it leaves out 1, so that the numbers are not to be trusted and nothing is judged",
    }
}

fn line(name: &str, ratio: Option<Estimate>, verdict: Option<Verdict>, remark: &str) -> String {
    match ratio.zip(verdict) {
        None => format!("  {name:24} not measured{remark}\n"),
        Some((Estimate { median, low, high }, verdict)) => {
            format!("  {name:24} {median:.3} ({low:.3} to {high:.3}), {}{remark}\n", verdict.words())
        }
    }
}
