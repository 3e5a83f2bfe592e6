//! Runs a study: loads its scenes, renders them in turn, and checks every picture.

use brewster::buffers::{Integrator, SceneBuffers};
use brewster::film::{Film, Keep, LinearImage, PixelOrder};
use brewster::import::study::{self, Study};
use brewster::wavefront::queues::RaySource;
use brewster::wavefront::stats::DepthStats;
use brewster::wavefront::survey::Survey;
use brewster::wavefront::{Control, Counts, Policy, Renderer, Stats};
use brewster::{Session, SessionOptions, SettingsChoices};
use glam::UVec2;
use std::path::Path;

use super::counters::{Counted, Counters};
use super::machine::Machine;
use super::measure::{Block, Clock, Side, Took, in_turn};
use super::record::Experiment;
use super::rows::{overhead, policy_results, speedup};
use super::samples::samples_apart;
use super::statistics::are_enough;
use super::subject::{Subject, intervals};
use super::trees::{Variants, builds};
use crate::commands::Failure;

/// What a study tells those who watch it.
pub(crate) struct Watch<'w> {
    /// Whether it should end.
    pub stop: &'w dyn Fn() -> bool,
    /// What ends a picture that is being rendered.
    pub control: &'w Control,
    /// Takes a line about what goes on, and one more step done.
    pub step: &'w dyn Fn(String),
}

/// Loads a scene with a set of parameters.
pub(crate) fn load(study: &Study, scene: &Path, parameters: &study::Parameters) -> Result<Session, Failure> {
    let settings = SettingsChoices {
        resolution: study.resolution.map(UVec2::from_array),
        samples: parameters.samples.or(study.samples),
        integrator: parameters.integrator,
        split_depth: parameters.split_depth,
        guiding: parameters.guiding,
        max_depth: parameters.max_depth,
        ..SettingsChoices::default()
    };
    let mut session = Session::new(scene, SessionOptions { settings, ..SessionOptions::default() });
    session.load()?;
    session.flatten()?;
    Ok(session)
}

/// The scene's name, that of its file.
pub(crate) fn scene_name(scene: &Path) -> String {
    scene.file_stem().unwrap_or(scene.as_os_str()).to_string_lossy().into_owned()
}

/// Renders one picture, unless it is interrupted; also what that took.
pub(crate) fn render(
    renderer: &mut Renderer<'_>,
    buffers: &SceneBuffers,
    control: &Control,
) -> Result<(Film, Took), Failure> {
    let settings = &buffers.settings;
    let mut film = empty_film(buffers)?;
    let pass = || Ok::<_, Failure>(renderer.pass(0..settings.samples, &mut film, control));
    match Took::by(pass)? {
        (true, took) => Ok((film, took)),
        (false, _) => Err(Failure::Interrupted),
    }
}

/// What was measured; none if that was interrupted.
pub(crate) fn unless_interrupted<T>(measured: Result<T, Failure>) -> Result<Option<T>, Failure> {
    match measured {
        Err(Failure::Interrupted) => Ok(None),
        measured => measured.map(Some),
    }
}

/// A film for a scene, with the squares that a noise threshold needs.
pub(crate) fn empty_film(buffers: &SceneBuffers) -> Result<Film, Failure> {
    let settings = &buffers.settings;
    let order = PixelOrder::new(settings.resolution.x, settings.resolution.y, None)?;
    Ok(Film::keeping(order, Keep { squares: settings.noise_threshold.is_some(), ..Keep::default() }))
}

pub(crate) fn renderer<'b>(
    buffers: &'b SceneBuffers,
    subject: &Subject,
    survey: bool,
) -> Result<Renderer<'b>, Failure> {
    let policy = Policy { survey, ..subject.policy };
    Renderer::new(buffers, 0, subject.threads, policy, false).map_err(Failure::input)
}

/// A policy under measurement.
pub(crate) struct Bench<'b> {
    pub subject: &'b Subject,
    buffers: &'b SceneBuffers,
    /// The times of all blocks' runs.
    pub times: Stats,
    /// From the counting run.
    pub stats: Stats,
    pub survey: Survey,
    /// What the processor counted in a run of its own.
    pub counted: Vec<Counted>,
    /// Runs that the times are of.
    pub runs: u32,
}

/// Runs a block of a subject, and checks every picture.
///
/// Where queues come to lie in memory, and threads on processors, makes a subject a little faster or slower than its equal. So every
/// block has renderers of its own, which are made in one order and in the other by turns.
fn block(
    scene: &str,
    benches: &mut [Bench<'_>],
    (place, round): (usize, u32),
    (warm_up, control): (u32, &Control),
    expected: Option<&Film>,
) -> Result<Block, Failure> {
    let make = |place: usize| renderer(benches[place].buffers, benches[place].subject, false);
    let mut pair = if round.is_multiple_of(2) {
        [make(0)?, make(place)?]
    } else {
        let own = make(place)?;
        [make(0)?, own]
    };
    let run = |pair: &mut [Renderer<'_>; 2], side: Side| {
        let Bench { subject, buffers, .. } = benches[if side == Side::Own { place } else { 0 }];
        let (film, took) = render(&mut pair[side as usize], buffers, control)?;
        expected.map_or(Ok(()), |expected| check_picture(scene, subject, expected, &film))?;
        Ok::<Took, Failure>(took)
    };
    // The baseline comes last: so it runs once after itself in the block, where it finds its memory in the caches, as its subject does.
    for side in [Side::Own, Side::Baseline].repeat(warm_up as usize) {
        run(&mut pair, side)?;
    }
    pair.iter_mut().for_each(Renderer::restart_stats);
    let block = Block::run(|side, _| run(&mut pair, side))?;
    for (place, renderer) in [0, place].into_iter().zip(&pair) {
        benches[place].times.add(&renderer.stats());
        benches[place].runs += 2;
    }
    Ok(block)
}

/// Renders a scene by every policy in turn; also its picture.
pub(crate) fn experiment(
    study: &Study,
    subjects: &[Subject],
    session: &Session,
    parameters: &str,
    machine: &Machine,
    watch: &Watch<'_>,
) -> Result<(Experiment, Option<LinearImage>), Failure> {
    let scene = scene_name(session.path());
    let variants = Variants::new(session.buffers(), subjects)?;
    let mut expected = None;
    let mut benches = Vec::new();
    // The baseline's control is its twin, at the place after it.
    for subject in subjects.iter().take(1).chain(subjects) {
        if (watch.stop)() {
            break;
        }
        (watch.step)(format!("{scene}: counting, {}", subject.name));
        let bench = bench(&scene, subject, variants.of(subject), &mut expected, watch.control);
        let Some(bench) = unless_interrupted(bench)? else { break };
        benches.push(bench);
    }
    let samples_apart = match (&expected, subjects.first()) {
        (Some(expected), Some(baseline)) => {
            samples_apart(&scene, (baseline, variants.of(baseline)), expected, machine, watch)?
        }
        _ => Vec::new(),
    };
    let counted = benches.len() == subjects.len() + 1;
    let rounds = if counted { study.policy_rounds() } else { 0 };
    let blocks = in_turn(benches.len(), rounds, watch.stop, |place, round| {
        (watch.step)(format!("{scene}: round {} of {rounds}, {}", round + 1, benches[place].subject.name));
        let expected = expected.as_ref().map(|(film, _)| film);
        let pace = (study.warm_up, watch.control);
        unless_interrupted(block(&scene, &mut benches, (place, round), pace, expected))
    })?;
    let settings = &session.buffers().settings;
    // On several threads the processor's time does not tell who is faster.
    let clock = if subjects.iter().all(|subject| subject.threads == 1) { Clock::Processor } else { Clock::Wall };
    let intervals = intervals(study, subjects);
    let control = blocks.get(1).and_then(|blocks| speedup(blocks, clock, intervals));
    let rounds = blocks.last().map_or(0, Vec::len);
    let trusted = are_enough(rounds, intervals) && control.is_some_and(|control| control.is_even());
    let builds = builds(study, subjects, session.buffers(), &scene, watch)?;
    let film = expected.map(|(film, _)| film);
    let policies = policy_results(&benches, &blocks, (clock, intervals), (control.as_ref(), trusted), machine);
    let experiment = Experiment {
        scene,
        parameters: parameters.to_owned(),
        integrator: integrator(settings.integrator),
        resolution: settings.resolution.to_array(),
        samples: settings.samples,
        max_depth: settings.max_depth,
        rays: benches.first().map_or(0, |bench| bench.stats.rays()),
        picture: film.as_ref().map_or(String::new(), |film| format!("{:016x}", hash(film))),
        rounds,
        clock,
        control,
        trusted,
        overhead: overhead(&policies, machine),
        builds,
        policies,
        samples_apart,
    };
    Ok((experiment, film.map(|film| film.resolve().image())))
}

/// The film that every run has to give, and what happened to the rays of each depth.
pub(crate) type Expected = (Film, Vec<Counts>);

/// Makes ready to measure a subject: counts, and checks the counts and the picture.
fn bench<'b>(
    scene: &str,
    subject: &'b Subject,
    buffers: &'b SceneBuffers,
    expected: &mut Option<Expected>,
    control: &Control,
) -> Result<Bench<'b>, Failure> {
    let mut counting = renderer(buffers, subject, true)?;
    let (film, _) = render(&mut counting, buffers, control)?;
    let (stats, survey) = (counting.stats(), counting.survey());
    conserve(&stats).map_err(|law| Failure::Input(format!("{scene}: policy {:?}: {law}", subject.name)))?;
    let totals: Vec<Counts> = stats.depths.iter().map(DepthStats::total).collect();
    let (expected, counts) = expected.get_or_insert_with(|| (film.clone(), totals.clone()));
    check_picture(scene, subject, expected, &film)?;
    if *counts != totals {
        return Err(Failure::Input(format!("{scene}: policy {:?} counts other rays than the baseline", subject.name)));
    }
    let (film, counted) = count(subject, buffers, control)?;
    if let Some(film) = film {
        check_picture(scene, subject, expected, &film)?;
    }
    let survey = survey.expect("one was asked for");
    let times = Stats::new(buffers.settings.max_depth);
    Ok(Bench { subject, buffers, times, stats, survey, counted, runs: 0 })
}

fn integrator(integrator: Integrator) -> String {
    format!("{integrator:?}")
}

pub(crate) fn check_picture(scene: &str, subject: &Subject, expected: &Film, found: &Film) -> Result<(), Failure> {
    if expected == found {
        return Ok(());
    }
    let (expected, found) = (hash(expected), hash(found));
    Err(Failure::Input(format!(
        "{scene}: policy {:?} gives another picture: {found:016x} where the baseline's is {expected:016x}; the study fails",
        subject.name
    )))
}

/// FNV-1a over the film's sums of light and their samples.
fn hash(film: &Film) -> u64 {
    let pixels = film.pixels();
    let words = pixels.color.iter().flat_map(|light| light.0.map(|sum| sum as u64));
    let words = words.chain(pixels.samples.iter().map(|&samples| u64::from(samples)));
    let bytes = words.flat_map(u64::to_le_bytes);
    bytes.fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

/// Renders twice and has the processor count the second time. The picture, unless nothing can be counted.
fn count(
    subject: &Subject,
    buffers: &SceneBuffers,
    control: &Control,
) -> Result<(Option<Film>, Vec<Counted>), Failure> {
    let mut counters = Counters::open();
    if counters.is_empty() {
        return Ok((None, Vec::new()));
    }
    // Counters see threads that start after them.
    let mut renderer = renderer(buffers, subject, false)?;
    render(&mut renderer, buffers, control)?;
    let (picture, counted) = counters.over(|| render(&mut renderer, buffers, control));
    Ok((Some(picture?.0), counted))
}

/// What has to hold of the counts of any render: no ray is lost or made up.
pub(crate) fn conserve(stats: &Stats) -> Result<(), String> {
    let totals: Vec<_> = stats.depths.iter().map(DepthStats::total).collect();
    for (depth, at) in stats.depths.iter().enumerate() {
        for (counts, source) in at.counts.iter().zip(RaySource::ALL) {
            let ends = counts.hits + counts.crossings + counts.scatterings + counts.escaped;
            if counts.traced() != ends {
                let name = source.name();
                return Err(format!("at depth {depth} {} {name} rays were traced and {ends} ended", counts.traced()));
            }
        }
        if depth > 0 {
            let sent = totals[depth - 1].reflections + totals[depth - 1].transmissions + totals[depth].crossings;
            let traced = totals[depth].traced();
            if sent != traced {
                return Err(format!("{sent} rays were sent to depth {depth} and {traced} were traced"));
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;
    use std::collections::BTreeMap;

    use brewster::import::study::load_study_text;

    use super::*;
    use crate::study::record::{SampleRecord, StageRow};
    use crate::study::subjects;

    const SCENE: &str = r#"Scene(
        settings: (resolution: (24, 16), samples: 2, max_depth: 3, integrator: Path),
        camera: Perspective(eye: (0, 1, 5), target: (0, 1, 0)),
        background: 0.8,
        entities: [
            (shape: Sphere(radius: 1), material: Dielectric(ior: 1.5), at: (-1, 1, 0)),
            (shape: Sphere(radius: 1), material: Metal(of: "gold"), at: (1, 1, 0)),
            (shape: Plane(), material: Lambert(albedo: 0.5)),
        ],
    )"#;

    const POLICIES: &str = r#"policies: {
        "plain": (), "threads": (threads: 2, batch: 64), "megakernel": (executor: Megakernel), "merged": (order: Merged, sort: OctantMorton, kernel: Obvhs, compaction: Cursor, tree: Clustered),
    }"#;

    fn study(fields: &str) -> Study {
        let text = format!("Study(name: \"n\", scenes: [\"Cargo.toml\"], rounds: 2, warm_up: 0, {fields})");
        load_study_text(Path::new("study.ron"), &text).unwrap_or_else(|failure| panic!("{failure}")).0
    }

    fn session() -> Session {
        let mut session = Session::new("scene.ron", SessionOptions::default());
        session.load_text(SCENE).expect("the scene is right");
        session.flatten().expect("as above");
        session
    }

    fn run(subjects: &[Subject], stop: &dyn Fn() -> bool) -> Result<Experiment, Failure> {
        run_study(&study(POLICIES), subjects, stop)
    }

    fn run_study(study: &Study, subjects: &[Subject], stop: &dyn Fn() -> bool) -> Result<Experiment, Failure> {
        let machine = Machine {
            processor: None,
            threads: 1,
            megahertz: None,
            governor: None,
            level: "",
            caches: Vec::new(),
            system: None,
            refused: Vec::new(),
            clock: 20.0,
            bandwidth: Vec::new(),
            arithmetic: 1.0,
        };
        let control = Control::default();
        let watch = Watch { stop, control: &control, step: &|_| () };
        experiment(study, subjects, &session(), "", &machine, &watch).map(|(experiment, _)| experiment)
    }

    fn policies() -> Vec<Subject> {
        subjects(&study(POLICIES)).unwrap_or_else(|failure| panic!("{failure:?}"))
    }

    /// By hand: 24 x 16 pixels of two samples; every ray traced at a depth is in one of its queues.
    #[test]
    fn every_policy_traces_the_same_rays() {
        let found = run(&policies(), &|| false).expect("nothing fails");
        assert_eq!((found.rounds, found.policies.len()), (2, 4));
        for policy in found.policies.iter().filter(|policy| policy.name != "megakernel") {
            let at =
                |depth: usize| policy.queues.iter().filter(|row| row.depth == depth).map(|row| row.rays).sum::<u64>();
            assert_eq!(at(0), 24 * 16 * 2, "{}", policy.name);
            assert_eq!(
                (1..4).map(at).collect::<Vec<_>>(),
                (1..4)
                    .map(|depth| {
                        let plain = found.policies[0].queues.iter().filter(|row| row.depth == depth);
                        plain.map(|row| row.rays).sum::<u64>()
                    })
                    .collect::<Vec<_>>(),
                "{}",
                policy.name
            );
            assert_eq!(policy.blocks.len(), 2, "{}", policy.name);
            assert!(policy.stages.iter().all(|row| row.calls > 0 && row.occupancy > 0.0 && row.occupancy <= 1.0));
        }
        assert!(found.policies[3].queues.iter().any(|row| row.queue == "merged"));
        assert!(found.overhead > 0.0 && found.control.is_some());
        let ways: Vec<_> = found.builds.iter().map(|build| build.name.as_str()).collect();
        assert_eq!(ways, ["Binned", "Binned", "Clustered"]);
        assert!(found.builds.iter().all(|build| build.blocks.len() == 2 && build.bytes > 0));
    }

    /// Rays, bytes read and operations of each depth, queue and stage, and bytes written of each depth and queue.
    fn work(rows: &[StageRow]) -> BTreeMap<(usize, &'static str, &'static str), [u64; 3]> {
        let mut sums = BTreeMap::new();
        for row in rows {
            let mut add = |stage, numbers: [u64; 3]| {
                let sum: &mut [u64; 3] = sums.entry((row.depth, row.queue, stage)).or_default();
                sum.iter_mut().zip(numbers).for_each(|(sum, number)| *sum += number);
            };
            add(row.stage, [row.rays, row.read, row.operations]);
            add("all", [row.written, 0, 0]);
        }
        sums
    }

    #[test]
    fn single_samples_add_up_to_all_on_any_threads_in_any_batches() {
        let [plain, threads] = [0, 1].map(|place| run(&policies()[place..=place], &|| false).expect("nothing fails"));
        for found in [&plain, &threads] {
            let samples: Vec<_> = found.samples_apart.iter().map(|record| (record.sample, record.samples)).collect();
            assert_eq!(samples, [(0, 1), (1, 1)]);
            let rows: Vec<StageRow> = found.samples_apart.iter().flat_map(|record| record.stages.clone()).collect();
            assert_eq!(work(&rows), work(&found.policies[0].stages), "{}", found.policies[0].name);
        }
        for (one, other) in plain.samples_apart.iter().zip(&threads.samples_apart) {
            assert_eq!(work(&one.stages), work(&other.stages), "sample {}", one.sample);
            assert!(one.stages.iter().all(|row| row.seconds > 0.0));
            let rays = |record: &SampleRecord| {
                record.queues.iter().map(|row| (row.depth, row.queue, row.rays)).collect::<Vec<_>>()
            };
            assert_eq!(rays(one), rays(other), "sample {}", one.sample);
        }
    }

    #[test]
    fn a_policy_that_changes_a_bit_fails_the_study_by_name() {
        let mut subjects = policies();
        subjects[1].seed_shift = 1;
        match run(&subjects, &|| false) {
            Err(Failure::Input(message)) => {
                assert!(message.contains("policy \"threads\" gives another picture"), "{message}");
            }
            other => panic!("{other:?}"),
        }
    }

    /// Five counting runs, of which one is the control's, a run of two samples, then four blocks a round, the first of which is the control's.
    #[test]
    fn a_stop_keeps_whole_rounds() {
        let asked = Cell::new(0);
        let stop = || {
            asked.set(asked.get() + 1);
            asked.get() > 5 + 3 + 4 + 2
        };
        let found = run(&policies(), &stop).expect("a stop is no failure");
        assert_eq!(found.rounds, 1);
        asked.set(12);
        let found = run(&policies(), &stop).expect("as above");
        assert_eq!((found.rounds, found.control), (0, None));
    }

    /// On one thread the stages of a picture take no longer than the picture.
    #[test]
    fn times_of_stages_leave_the_warm_up_out() {
        let policies = "policies: { \"plain\": () }, warm_up: 3, rounds: 1,";
        let study = load_study_text(
            Path::new("study.ron"),
            &format!("Study(name: \"n\", scenes: [\"Cargo.toml\"], {policies})"),
        );
        let study = study.unwrap_or_else(|failure| panic!("{failure}")).0;
        let subjects = subjects(&study).unwrap_or_else(|failure| panic!("{failure:?}"));
        let found = run_study(&study, &subjects, &|| false).expect("nothing fails");
        let policy = &found.policies[0];
        let stages: f64 = policy.stages.iter().map(|row| row.seconds).sum();
        let [before, after] = policy.blocks[0].baseline;
        assert!(stages > 0.0 && stages <= 0.5 * (before.wall + after.wall), "{stages} s in {:?}", policy.blocks);
    }

    #[test]
    fn a_lost_ray_is_found() {
        let session = session();
        let mut counting = renderer(session.buffers(), &policies()[0], true).expect("it can be rendered");
        render(&mut counting, session.buffers(), &Control::default()).expect("as above");
        let stats = counting.stats();
        assert_eq!(conserve(&stats), Ok(()));
        let mut lost = stats.clone();
        lost.depths[1].counts[1].escaped -= 1;
        assert!(conserve(&lost).unwrap_err().contains("at depth 1"));
        let mut lost = stats;
        lost.depths[0].counts[0].reflections += 1;
        assert!(conserve(&lost).unwrap_err().contains("sent to depth 1"));
    }
}
