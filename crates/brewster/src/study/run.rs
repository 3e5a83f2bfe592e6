//! Runs a study: loads its scenes, renders them in turn, and checks every picture.

use brewster::buffers::{Integrator, SceneBuffers};
use brewster::film::{Film, LinearImage, PixelOrder};
use brewster::import::study::{self, Study};
use brewster::lanes::Level;
use brewster::wavefront::queues::RaySource;
use brewster::wavefront::stats::DepthStats;
use brewster::wavefront::survey::{LANES, Survey};
use brewster::wavefront::traffic::traffic;
use brewster::wavefront::{Control, Executor, Policy, QueueOrder, Renderer, SortKey, Stage, Stats};
use brewster::{Session, SessionOptions, SettingsChoices, geometry};
use glam::UVec2;
use std::path::Path;
use std::time::Instant;

use super::machine::Machine;
use super::measure::{Seconds, interleave, speedups};
use super::record::{Experiment, ParameterResult, PolicyResult, Quality, QueueRow, StageRow};
use super::statistics::{Estimate, Verdict, block_z, median};
use crate::commands::Failure;

/// A policy, ready to be run.
#[derive(Clone, Debug)]
pub(crate) struct Subject {
    /// Its name.
    pub name: String,
    pub policy: Policy,
    pub threads: usize,
    pub of_batches: bool,
    /// Added to the scene's seed: a stand-in for a policy that changes bits, in tests.
    pub seed_shift: u64,
}

impl Subject {
    fn new(policy: &study::Policy) -> Result<Subject, Failure> {
        let wanted = match policy.level {
            None => Level::detect().name(),
            Some(study::Level::Avx512) => "avx512",
            Some(study::Level::Avx2) => "avx2",
            Some(study::Level::Baseline) => "baseline",
        };
        let missing = || Failure::Input(format!("policy {:?}: this machine has no {wanted}", policy.name));
        Ok(Subject {
            name: policy.name.clone(),
            policy: Policy {
                batch: policy.batch as usize,
                capacity: policy.capacity as usize,
                order: match policy.order {
                    study::Order::ReflectionFirst => QueueOrder::ReflectionFirst,
                    study::Order::TransmissionFirst => QueueOrder::TransmissionFirst,
                    study::Order::Merged => QueueOrder::Merged,
                },
                sort: match policy.sort {
                    study::Sort::None => SortKey::None,
                    study::Sort::Material => SortKey::Material,
                    study::Sort::Octant => SortKey::Octant,
                    study::Sort::Morton => SortKey::Morton,
                    study::Sort::OctantMorton => SortKey::OctantMorton,
                },
                kernel: match policy.kernel {
                    study::Kernel::Packets => geometry::Kernel::Packets,
                    study::Kernel::Wave => geometry::Kernel::Wave,
                    study::Kernel::Single => geometry::Kernel::Single,
                },
                level: Level::named(wanted).ok_or_else(missing)?,
                executor: match policy.executor {
                    study::Executor::Wavefront => Executor::Wavefront,
                    study::Executor::Megakernel => Executor::Megakernel,
                },
                ..Policy::default()
            },
            threads: policy.threads as usize,
            of_batches: policy.of_batches,
            seed_shift: 0,
        })
    }

    /// The settings in words: of the baseline all, of others what differs from it.
    fn settings(&self, baseline: &Subject) -> String {
        let mine = self.setting_list();
        let is_new = |place: usize| self.name == baseline.name || mine[place] != baseline.setting_list()[place];
        let new: Vec<&str> = (0..mine.len()).filter(|&place| is_new(place)).map(|place| mine[place].as_str()).collect();
        new.join(", ")
    }

    fn setting_list(&self) -> [String; 8] {
        let Policy { batch, capacity, order, sort, kernel, level, executor, .. } = self.policy;
        [
            format!("{executor:?}"),
            format!("batch {batch}"),
            format!("capacity {capacity}"),
            format!("threads {}", self.threads),
            format!("order {order:?}"),
            format!("sort {sort:?}"),
            format!("kernel {kernel:?}"),
            level.name().to_owned(),
        ]
    }
}

/// All policies of a study, the baseline first.
pub(crate) fn subjects(study: &Study) -> Result<Vec<Subject>, Failure> {
    study.policies.iter().map(Subject::new).collect()
}

/// What a study tells those who watch it.
pub(crate) struct Watch<'w> {
    /// Whether it should end.
    pub stop: &'w dyn Fn() -> bool,
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

/// A whole picture: its film and how long it took.
struct Picture {
    film: Film,
    seconds: f64,
}

/// Renders one picture.
fn render(renderer: &mut Renderer<'_>, buffers: &SceneBuffers) -> Result<Picture, Failure> {
    let settings = &buffers.settings;
    let mut film = Film::new(PixelOrder::new(settings.resolution.x, settings.resolution.y, None)?);
    let begin = Instant::now();
    renderer.pass(0..settings.samples, &mut film, &Control::default());
    Ok(Picture { film, seconds: begin.elapsed().as_secs_f64() })
}

fn renderer<'b>(buffers: &'b SceneBuffers, subject: &Subject, survey: bool) -> Result<Renderer<'b>, Failure> {
    let policy = Policy { survey, ..subject.policy };
    Renderer::new(buffers, 0, subject.threads, policy, false).map_err(Failure::input)
}

/// A policy under measurement.
struct Bench<'b> {
    subject: &'b Subject,
    buffers: &'b SceneBuffers,
    renderer: Renderer<'b>,
    /// From the counting run.
    stats: Stats,
    survey: Survey,
    runs: u32,
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
    let shifted: Vec<SceneBuffers> = subjects.iter().map(|subject| shifted(session.buffers(), subject)).collect();
    let mut expected: Option<(Film, Vec<_>)> = None;
    let mut benches = Vec::new();
    // The baseline's control is its twin, at the place after it.
    let twice = subjects.iter().zip(&shifted).take(1).chain(subjects.iter().zip(&shifted));
    for (subject, buffers) in twice {
        if (watch.stop)() {
            break;
        }
        (watch.step)(format!("{scene}: counting, {}", subject.name));
        let mut counting = renderer(buffers, subject, true)?;
        let picture = render(&mut counting, buffers)?;
        let (stats, survey) = (counting.stats(), counting.survey());
        conserve(&stats).map_err(|law| Failure::Input(format!("{scene}: policy {:?}: {law}", subject.name)))?;
        let totals: Vec<_> = stats.depths.iter().map(DepthStats::total).collect();
        let (film, counts) = expected.get_or_insert_with(|| (picture.film.clone(), totals.clone()));
        check_picture(&scene, subject, film, &picture.film)?;
        if *counts != totals {
            return Err(Failure::Input(format!(
                "{scene}: policy {:?} counts other rays than the baseline",
                subject.name
            )));
        }
        let survey = survey.expect("one was asked for");
        benches.push(Bench { subject, buffers, renderer: renderer(buffers, subject, false)?, stats, survey, runs: 0 });
    }
    let counted = benches.len() == subjects.len() + 1;
    let rounds = if counted { study.rounds } else { 0 };
    let seconds = interleave(benches.len(), study.warm_up, rounds, watch.stop, |place, turn| {
        let bench = &mut benches[place];
        let round = turn.round.map_or("warm-up".to_owned(), |round| format!("round {} of {}", round + 1, study.rounds));
        (watch.step)(format!("{scene}: {round}, {}", bench.subject.name));
        let picture = render(&mut bench.renderer, bench.buffers)?;
        bench.runs += 1;
        if let Some((film, _)) = &expected {
            check_picture(&scene, bench.subject, film, &picture.film)?;
        }
        Ok::<f64, Failure>(picture.seconds)
    })?;
    let settings = &session.buffers().settings;
    let control = seconds.get(1).and_then(|control| Estimate::of(&speedups(&seconds[0], control)));
    let film = expected.map(|(film, _)| film);
    let mut experiment = Experiment {
        scene,
        parameters: parameters.to_owned(),
        integrator: integrator(settings.integrator),
        resolution: settings.resolution.to_array(),
        samples: settings.samples,
        max_depth: settings.max_depth,
        rays: benches.first().map_or(0, |bench| bench.stats.rays()),
        picture: film.as_ref().map_or(String::new(), |film| format!("{:016x}", hash(film))),
        rounds: seconds.first().map_or(0, Vec::len),
        control,
        trusted: control.is_some_and(|control| control.contains(1.0)),
        overhead: 0.0,
        policies: policy_results(&benches, &seconds, control.as_ref()),
    };
    experiment.overhead = overhead(&experiment, machine);
    Ok((experiment, film.map(|film| film.resolve().image())))
}

fn shifted(buffers: &SceneBuffers, subject: &Subject) -> SceneBuffers {
    let mut buffers = buffers.clone();
    buffers.settings.seed = buffers.settings.seed.wrapping_add(subject.seed_shift);
    buffers
}

fn integrator(integrator: Integrator) -> String {
    format!("{integrator:?}")
}

/// The part of the baseline's time that looks at the clock take: two for every call of a stage.
fn overhead(experiment: &Experiment, machine: &Machine) -> f64 {
    let Some(baseline) = experiment.policies.first() else { return 0.0 };
    let calls: u64 = baseline.stages.iter().map(|row| row.calls).sum();
    let seconds: f64 = baseline.stages.iter().map(|row| row.seconds).sum();
    if seconds > 0.0 { 2.0 * calls as f64 * machine.clock * 1e-9 / seconds } else { 0.0 }
}

fn check_picture(scene: &str, subject: &Subject, expected: &Film, found: &Film) -> Result<(), Failure> {
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

/// What has to hold of the counts of any render: no ray is lost or made up.
pub(crate) fn conserve(stats: &Stats) -> Result<(), String> {
    let totals: Vec<_> = stats.depths.iter().map(DepthStats::total).collect();
    for (depth, at) in stats.depths.iter().enumerate() {
        for (counts, source) in at.counts.iter().zip(RaySource::ALL) {
            let ends = counts.hits + counts.crossings + counts.escaped;
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

/// The results of all benches but the control, which is the second one.
fn policy_results(benches: &[Bench<'_>], seconds: &Seconds, control: Option<&Estimate>) -> Vec<PolicyResult> {
    let places = (0..benches.len()).filter(|&place| place != 1);
    let of = |place: usize| {
        let (bench, times) = (&benches[place], &seconds[place]);
        let Subject { name, policy, of_batches, .. } = bench.subject;
        let speedup = Estimate::of(&speedups(&seconds[0], times)).filter(|_| place > 0);
        let flat: Vec<f64> = times.iter().flatten().copied().collect();
        PolicyResult {
            name: name.clone(),
            settings: bench.subject.settings(benches[0].subject),
            batch: policy.batch,
            of_batches: *of_batches || place == 0,
            queue_bytes: bench.stats.queue_bytes,
            seconds: times.clone(),
            rate: median(&flat).map(|seconds| bench.stats.rays() as f64 / seconds * 1e-6),
            speedup,
            verdict: speedup.zip(control).map(|(speedup, control)| Verdict::of(&speedup, control)),
            stages: stage_rows(bench),
            queues: queue_rows(&bench.survey),
        }
    };
    places.map(of).collect()
}

fn stage_rows(bench: &Bench<'_>) -> Vec<StageRow> {
    let times = bench.renderer.stats();
    let mut rows = Vec::new();
    for (depth, at) in bench.stats.depths.iter().enumerate() {
        for (source, stage) in RaySource::ALL.into_iter().flat_map(|source| Stage::ALL.map(|stage| (source, stage))) {
            let counts = &at.counts[source as usize];
            let calls = bench.survey.depths[depth][source as usize].stages[stage as usize];
            let rays = counts.stages[stage as usize];
            // Without queues no stage is called.
            if calls.calls == 0 {
                continue;
            }
            let moved = traffic(stage, counts, bench.subject.policy.sort);
            let time = times.depths[depth].times[source as usize][stage as usize];
            rows.push(StageRow {
                depth,
                queue: source.name(),
                stage: stage.name(),
                rays,
                calls: calls.calls,
                occupancy: rays as f64 / (calls.registers as usize * LANES).max(1) as f64,
                seconds: time.as_secs_f64() / f64::from(bench.runs.max(1)),
                read: moved.read,
                written: moved.written,
            });
        }
    }
    rows
}

fn queue_rows(survey: &Survey) -> Vec<QueueRow> {
    let mut rows = Vec::new();
    for (depth, at) in survey.depths.iter().enumerate() {
        for (seen, source) in at.iter().zip(RaySource::ALL).filter(|(seen, _)| seen.rays > 0) {
            let longest = seen.lengths.iter().rposition(|&times| times > 0).map_or(0, |place| place + 1);
            let rays = seen.rays as f64;
            let [nodes, instances, primitives] = seen.visits.map(|visits| visits as f64 / rays);
            rows.push(QueueRow {
                depth,
                queue: source.name(),
                rays: seen.rays,
                taken: seen.taken,
                lengths: seen.lengths[..longest].to_vec(),
                octant_run: rays / seen.octant_runs.max(1) as f64,
                material_run: rays / seen.material_runs.max(1) as f64,
                nodes,
                instances,
                primitives,
            });
        }
    }
    rows
}

/// Renders a scene with every set of parameters in turn, by the baseline's policy, with new seeds in every run.
pub(crate) fn quality(study: &Study, scene: &Path, subject: &Subject, watch: &Watch<'_>) -> Result<Quality, Failure> {
    let name = scene_name(scene);
    let sessions: Result<Vec<_>, _> =
        study.parameters.iter().map(|parameters| load(study, scene, parameters)).collect();
    let mut scenes: Vec<SceneBuffers> = sessions?.iter().map(|session| session.buffers().clone()).collect();
    scenes.insert(1, scenes[0].clone());
    // Pictures of every subject, two a round, as linear pixels.
    let mut pictures: Vec<Vec<[Vec<f32>; 2]>> = vec![Vec::new(); scenes.len()];
    let seconds = interleave(scenes.len(), study.warm_up, study.rounds, watch.stop, |place, turn| {
        let parameters = &study.parameters[place.saturating_sub(1)].name;
        let round = turn.round.map_or("warm-up".to_owned(), |round| format!("round {} of {}", round + 1, study.rounds));
        (watch.step)(format!("{name}: {round}, {parameters}"));
        let buffers = &mut scenes[place];
        // The control sees what the first set sees; all others draw numbers of their own.
        let own = if place > 1 { place as u64 } else { 0 };
        buffers.settings.seed = own << 32 | u64::from(2 * turn.round.unwrap_or(0)) | u64::from(turn.back);
        let picture = render(&mut renderer(buffers, subject, false)?, buffers)?;
        if let Some(round) = turn.round {
            let pixels = pixels(&picture.film);
            let rounds = &mut pictures[place];
            rounds.resize(round as usize + 1, Default::default());
            rounds[round as usize][usize::from(turn.back)] = pixels;
        }
        Ok::<f64, Failure>(picture.seconds)
    })?;
    let rounds = seconds.first().map_or(0, Vec::len);
    pictures.iter_mut().for_each(|all| all.truncate(rounds));
    if pictures[0] != pictures[1] {
        return Err(Failure::Input(format!("{name}: the same seeds gave other pictures; the study fails")));
    }
    let width = scenes[0].settings.resolution.x as usize;
    Ok(quality_of(study, name, &seconds, &pictures, width))
}

fn quality_of(
    study: &Study,
    scene: String,
    seconds: &Seconds,
    pictures: &[Vec<[Vec<f32>; 2]>],
    width: usize,
) -> Quality {
    let variances: Vec<Vec<f64>> =
        pictures.iter().map(|rounds| rounds.iter().map(|[a, b]| variance(a, b)).collect()).collect();
    let efficiencies = |place: usize| -> Vec<f64> {
        let rounds = variances[place].iter().zip(&seconds[place]);
        rounds.map(|(variance, [forward, back])| 2.0 / (variance * (forward + back))).collect()
    };
    let ratio = |place: usize| {
        let ratios: Vec<f64> = efficiencies(place).iter().zip(efficiencies(0)).map(|(a, b)| a / b).collect();
        // Without noise there is nothing to compare.
        Estimate::of(&ratios).filter(|_| ratios.iter().all(|ratio| ratio.is_finite()))
    };
    let blocks = |place: usize| -> Vec<Vec<f64>> {
        pictures[place].iter().flatten().map(|pixels| block_means(pixels, width)).collect()
    };
    let first = blocks(0);
    let control = ratio(1);
    let parameters = study.parameters.iter().enumerate().map(|(number, parameters)| {
        let place = if number == 0 { 0 } else { number + 1 };
        let ratio = ratio(place).filter(|_| number > 0);
        ParameterResult {
            name: parameters.name.clone(),
            settings: parameter_settings(parameters),
            seconds: seconds[place].clone(),
            variances: variances[place].clone(),
            efficiency: median(&efficiencies(place)).filter(|efficiency| efficiency.is_finite()),
            ratio,
            verdict: ratio.zip(control).map(|(ratio, control)| Verdict::of(&ratio, &control)),
            z: if number > 0 { block_z(&blocks(place), &first) } else { None },
        }
    });
    Quality {
        scene,
        rounds: seconds[0].len(),
        control,
        trusted: control.is_some_and(|control| control.contains(1.0)),
        parameters: parameters.collect(),
    }
}

fn parameter_settings(parameters: &study::Parameters) -> String {
    let study::Parameters { integrator, split_depth, samples, max_depth, .. } = parameters;
    let entries = [
        integrator.map(|integrator| format!("{integrator:?}")),
        split_depth.map(|depth| format!("split depth {depth}")),
        samples.map(|samples| format!("{samples} samples")),
        max_depth.map(|depth| format!("depth {depth}")),
    ];
    let entries: Vec<String> = entries.into_iter().flatten().collect();
    if entries.is_empty() { "as the scene says".to_owned() } else { entries.join(", ") }
}

/// Linear radiance, channel by channel, row by row.
fn pixels(film: &Film) -> Vec<f32> {
    film.resolve().image().color.into_iter().flatten().collect()
}

/// The variance of a pixel's channel, from two pictures with different seeds: half the mean squared difference.
fn variance(a: &[f32], b: &[f32]) -> f64 {
    let squares: f64 = a.iter().zip(b).map(|(a, b)| f64::from(a - b).powi(2)).sum();
    0.5 * squares / a.len().max(1) as f64
}

/// Pixels along the side of a block.
const BLOCK: usize = 8;

/// Mean radiance of every block of pixels, of all channels together.
fn block_means(pixels: &[f32], width: usize) -> Vec<f64> {
    let (across, height) = (width.div_ceil(BLOCK), pixels.len() / 3 / width);
    let mut sums = vec![(0.0, 0.0); across * height.div_ceil(BLOCK)];
    for (row, pixel) in pixels.chunks_exact(3).enumerate() {
        let (x, y) = (row % width, row / width);
        let (sum, count) = &mut sums[y / BLOCK * across + x / BLOCK];
        *sum += pixel.iter().map(|&value| f64::from(value)).sum::<f64>() / 3.0;
        *count += 1.0;
    }
    sums.into_iter().map(|(sum, count)| sum / count).collect()
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use brewster::import::study::load_study_text;

    use super::*;

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
        "plain": (), "threads": (threads: 2, batch: 64), "megakernel": (executor: Megakernel), "merged": (order: Merged, sort: OctantMorton, kernel: Single),
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
        let machine = Machine {
            processor: None,
            threads: 1,
            megahertz: None,
            governor: None,
            level: "",
            caches: Vec::new(),
            system: None,
            clock: 20.0,
            bandwidth: Vec::new(),
            arithmetic: 1.0,
        };
        let watch = Watch { stop, step: &|_| () };
        experiment(&study(POLICIES), subjects, &session(), "", &machine, &watch).map(|(experiment, _)| experiment)
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
            assert_eq!(policy.seconds.len(), 2, "{}", policy.name);
            assert!(policy.stages.iter().all(|row| row.calls > 0 && row.occupancy > 0.0 && row.occupancy <= 1.0));
        }
        assert!(found.policies[3].queues.iter().any(|row| row.queue == "merged"));
        assert!(found.overhead > 0.0 && found.control.is_some());
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

    /// Five counting runs, of which one is the control's, then the runs of a round forward and back.
    #[test]
    fn a_stop_keeps_whole_rounds() {
        let asked = Cell::new(0);
        let stop = || {
            asked.set(asked.get() + 1);
            asked.get() > 5 + 10 + 3
        };
        let found = run(&policies(), &stop).expect("a stop is no failure");
        assert_eq!(found.rounds, 1);
        asked.set(14);
        let found = run(&policies(), &stop).expect("as above");
        assert_eq!((found.rounds, found.control), (0, None));
    }

    #[test]
    fn a_lost_ray_is_found() {
        let session = session();
        let mut counting = renderer(session.buffers(), &policies()[0], true).expect("it can be rendered");
        render(&mut counting, session.buffers()).expect("as above");
        let stats = counting.stats();
        assert_eq!(conserve(&stats), Ok(()));
        let mut lost = stats.clone();
        lost.depths[1].counts[1].escaped -= 1;
        assert!(conserve(&lost).unwrap_err().contains("at depth 1"));
        let mut lost = stats;
        lost.depths[0].counts[0].reflections += 1;
        assert!(conserve(&lost).unwrap_err().contains("sent to depth 1"));
    }

    /// By hand: differences of 2 and 0 over two values have the mean square 2, halved.
    #[test]
    fn two_pictures_tell_their_variance() {
        assert_eq!(variance(&[1.0, 5.0], &[3.0, 5.0]), 1.0);
        let pixels: Vec<f32> = (0..9 * 3).map(|value| (value / 3) as f32).collect();
        assert_eq!(block_means(&pixels, 9), [3.5, 8.0]);
    }
}
