//! The statistics of a render as a file: versioned JSON.
//!
//! Everything but `times` is the same for the same picture, whatever the number of threads, the batch size or the machine.
//! Fields may be added within a version; when one goes or gets another meaning, [`STATS_VERSION`] is raised. The crate's
//! `README.md` lists them all.

use std::time::Duration;

use brewster_film::SCALE;
use brewster_wavefront::guide::Guide;
use brewster_wavefront::ledger::Ledger;
use brewster_wavefront::queues::RaySource;
use brewster_wavefront::{Counts, Stage, Stats};
use brewster_world::{FlattenReport, RowEdits, TopTreeEdit};
use serde::{Serialize, Serializer};

use crate::origin::NamedOrigin;
use crate::{PROGRAM, Render};

/// The version of the format.
pub const STATS_VERSION: u32 = 1;

/// What `brewster render --stats` writes.
#[derive(Clone, Debug, Serialize)]
pub struct StatsFile {
    version: u32,
    program: &'static str,
    scene: SceneStats,
    settings: SettingsStats,
    guide: Option<GuideStats>,
    samples: SampleStats,
    depths: Vec<DepthStats>,
    totals: TotalStats,
    flatten: FlattenStats,
    film: FilmStats,
    not_light: Vec<NamedOrigin>,
    fireflies: Vec<NamedOrigin>,
    times: TimeStats,
}

#[derive(Clone, Debug, Serialize)]
struct SceneStats {
    file: String,
    hash: String,
    warnings: usize,
}

#[derive(Clone, Debug, Serialize)]
struct SettingsStats {
    resolution: [u32; 2],
    crop: Option<[u32; 4]>,
    camera: String,
    integrator: String,
    max_depth: u32,
    samples: u32,
    noise_threshold: Option<f32>,
    seed: u64,
    sampler: String,
    split_depth: u32,
    roulette: bool,
    guiding: bool,
    /// None where nothing is held back.
    clamp: Option<f32>,
    filter: String,
    transparent_shadows: bool,
    contribution_threshold: f32,
    exposure: f32,
    tone_mapping: String,
}

/// Photons of the path guide.
#[derive(Clone, Debug, Serialize)]
struct GuideStats {
    photons: u64,
    kept: usize,
    rays: u64,
    bytes: usize,
}

#[derive(Clone, Debug, Serialize)]
struct SampleStats {
    asked: u32,
    least: u32,
    most: u32,
    total: u64,
}

#[derive(Clone, Debug, Serialize)]
struct DepthStats {
    depth: u32,
    #[serde(skip_serializing_if = "Option::is_none")]
    energy: Option<EnergyStats>,
    queues: Named<QueueStats>,
}

/// Energy in camera rays' weights, by channel.
#[derive(Clone, Debug, Serialize)]
struct EnergyStats {
    z: [f64; 3],
    stray_z: [f64; 3],
    entries: Named<[f64; 3]>,
}

#[derive(Clone, Debug, Serialize)]
struct QueueStats {
    traced: u64,
    hits: u64,
    escaped: u64,
    passed: u64,
    crossings: u64,
    scatterings: u64,
    reflections: u64,
    transmissions: u64,
    totally_reflected: u64,
    cut_by_depth: u64,
    below_threshold: u64,
    given_up: u64,
    absorbed: u64,
    branched: u64,
    shadow_rays: u64,
    shadowed: u64,
    shadow_segments: u64,
    stages: Named<u64>,
}

#[derive(Clone, Debug, Serialize)]
struct TotalStats {
    #[serde(skip_serializing_if = "Option::is_none")]
    energy: Option<EnergyStats>,
    rays: u64,
    primary: u64,
    reflection: u64,
    transmission: u64,
    shadow: u64,
}

#[derive(Clone, Debug, Serialize)]
struct FlattenStats {
    rows: Named<RowStats>,
    mesh_trees: MeshTreeStats,
    top_tree: TopTreeStats,
}

#[derive(Clone, Debug, Serialize)]
struct RowStats {
    added: usize,
    removed: usize,
    rewritten: usize,
}

#[derive(Clone, Debug, Serialize)]
struct MeshTreeStats {
    built: usize,
    triangles: usize,
    dropped: usize,
}

#[derive(Clone, Debug, Serialize)]
struct TopTreeStats {
    edit: &'static str,
    instances: usize,
}

#[derive(Clone, Debug, Serialize)]
struct FilmStats {
    rejected: u64,
    saturated: u64,
    clamped: [f64; 3],
}

/// What differs from run to run: times in seconds, and what they depend on.
#[derive(Clone, Debug, Serialize)]
struct TimeStats {
    threads: usize,
    batch: usize,
    instruction_set: String,
    load: f64,
    flatten: f64,
    trees: f64,
    prepare: f64,
    guide: f64,
    trace: f64,
    encode: f64,
    rays_per_second: f64,
    systems: Named<f64>,
    stages: Named<f64>,
    depths: Vec<DepthTimes>,
    queue_bytes: usize,
    peak_memory_bytes: Option<u64>,
}

#[derive(Clone, Debug, Serialize)]
struct DepthTimes {
    depth: u32,
    queues: Named<Named<f64>>,
}

/// A map that keeps the order of its names.
#[derive(Clone, Debug)]
struct Named<T>(Vec<(&'static str, T)>);

impl<T: Serialize> Serialize for Named<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(name, value)| (name, value)))
    }
}

impl<T> FromIterator<(&'static str, T)> for Named<T> {
    fn from_iter<I: IntoIterator<Item = (&'static str, T)>>(rows: I) -> Self {
        Named(rows.into_iter().collect())
    }
}

impl StatsFile {
    pub(crate) fn new(render: &Render<'_>) -> StatsFile {
        let (session, stats, samples) = (render.session, render.stats(), render.samples());
        let total = stats.total();
        let traced = |source| stats.of_source(source).traced();
        StatsFile {
            version: STATS_VERSION,
            program: PROGRAM,
            scene: SceneStats {
                file: session.path().display().to_string(),
                hash: hash_text(session.hash()),
                warnings: session.warnings().len(),
            },
            settings: SettingsStats::new(render),
            guide: render.guide().map(GuideStats::new),
            samples: SampleStats {
                asked: samples.asked,
                least: samples.least,
                most: samples.most,
                total: samples.total,
            },
            depths: (stats.depths.iter().zip(0..))
                .map(|(at, depth)| DepthStats {
                    depth,
                    energy: energy(&at.ledger()),
                    queues: by_source(|source| queue(&at.counts[source as usize])),
                })
                .collect(),
            totals: TotalStats {
                energy: energy(&stats.ledger()),
                rays: stats.rays(),
                primary: traced(RaySource::Primary),
                reflection: traced(RaySource::Reflection),
                transmission: traced(RaySource::Transmission),
                shadow: total.shadow_segments,
            },
            flatten: FlattenStats::new(session.report()),
            film: FilmStats {
                rejected: render.film().rejected(),
                saturated: render.film().saturated(),
                clamped: total.clamped.0.map(|sum| sum as f64 / SCALE),
            },
            not_light: render.not_light(),
            fireflies: render.fireflies(),
            times: TimeStats::new(render, &stats),
        }
    }
}

impl GuideStats {
    fn new(guide: &Guide) -> GuideStats {
        GuideStats { photons: guide.sent, kept: guide.kept(), rays: guide.rays, bytes: guide.bytes() }
    }
}

impl SettingsStats {
    fn new(render: &Render<'_>) -> SettingsStats {
        let buffers = render.session.buffers();
        let settings = &buffers.settings;
        SettingsStats {
            resolution: settings.resolution.to_array(),
            crop: render.options.crop.map(|crop| [crop.x, crop.y, crop.width, crop.height]),
            camera: buffers.cameras[render.camera].name.clone(),
            integrator: format!("{:?}", settings.integrator),
            max_depth: settings.max_depth,
            samples: settings.samples,
            noise_threshold: settings.noise_threshold,
            seed: settings.seed,
            sampler: format!("{:?}", settings.sampler),
            split_depth: settings.split_depth,
            roulette: settings.roulette,
            guiding: settings.guiding,
            clamp: settings.clamp.is_finite().then_some(settings.clamp),
            filter: format!("{:?}", settings.filter),
            transparent_shadows: settings.transparent_shadows,
            contribution_threshold: settings.contribution_threshold,
            exposure: settings.exposure,
            tone_mapping: format!("{:?}", settings.tone_mapping),
        }
    }
}

impl FlattenStats {
    fn new(report: &FlattenReport) -> FlattenStats {
        let row = |RowEdits { added, removed, rewritten }| RowStats { added, removed, rewritten };
        let trees = report.mesh_trees;
        let (edit, instances) = match report.top_tree {
            TopTreeEdit::Kept => ("kept", 0),
            TopTreeEdit::Refitted(instances) => ("refitted", instances),
            TopTreeEdit::Rebuilt(instances) => ("rebuilt", instances),
        };
        FlattenStats {
            rows: report.rows().into_iter().map(|(name, edits)| (name, row(edits))).collect(),
            mesh_trees: MeshTreeStats { built: trees.built, triangles: trees.triangles, dropped: trees.dropped },
            top_tree: TopTreeStats { edit, instances },
        }
    }
}

impl TimeStats {
    fn new(render: &Render<'_>, stats: &Stats) -> TimeStats {
        let (report, timeline) = (render.session.report(), render.timeline());
        let seconds = |name| timeline.total(name).as_secs_f64();
        let trace = seconds("trace");
        TimeStats {
            threads: render.options.threads,
            batch: render.options.policy.batch,
            instruction_set: format!("{:?}", render.options.policy.level),
            load: seconds("load"),
            flatten: seconds("flatten"),
            trees: tree_time(report).as_secs_f64(),
            prepare: seconds("prepare"),
            guide: render.guide().map_or(0.0, |guide| guide.time.as_secs_f64()),
            trace,
            encode: seconds("encode"),
            rays_per_second: if trace > 0.0 { stats.rays() as f64 / trace } else { 0.0 },
            systems: report.times.iter().map(|&(name, time)| (name, time.as_secs_f64())).collect(),
            stages: by_stage(|stage| stats.time(stage).as_secs_f64()),
            depths: (stats.depths.iter().zip(0..))
                .map(|(at, depth)| {
                    let of =
                        |source: RaySource| by_stage(|stage| at.times[source as usize][stage as usize].as_secs_f64());
                    DepthTimes { depth, queues: by_source(of) }
                })
                .collect(),
            queue_bytes: stats.queue_bytes,
            peak_memory_bytes: peak_memory(),
        }
    }
}

/// What a ledger says; nothing where none was kept.
fn energy(ledger: &Ledger) -> Option<EnergyStats> {
    let entries = || ledger.entries().map(|(name, energy)| (name, energy.value())).collect();
    (*ledger != Ledger::default()).then(|| EnergyStats { z: ledger.z(), stray_z: ledger.stray_z(), entries: entries() })
}

fn queue(counts: &Counts) -> QueueStats {
    QueueStats {
        traced: counts.traced(),
        hits: counts.hits,
        escaped: counts.escaped,
        passed: counts.passed,
        crossings: counts.crossings,
        scatterings: counts.scatterings,
        reflections: counts.reflections,
        transmissions: counts.transmissions,
        totally_reflected: counts.totally_reflected,
        cut_by_depth: counts.cut_by_depth,
        below_threshold: counts.below_threshold,
        given_up: counts.given_up,
        absorbed: counts.absorbed,
        branched: counts.branched,
        shadow_rays: counts.shadow_rays,
        shadowed: counts.shadowed,
        shadow_segments: counts.shadow_segments,
        stages: by_stage(|stage| counts.stages[stage as usize]),
    }
}

fn by_source<T>(of: impl Fn(RaySource) -> T) -> Named<T> {
    RaySource::APART.into_iter().map(|source| (source.name(), of(source))).collect()
}

fn by_stage<T>(of: impl Fn(Stage) -> T) -> Named<T> {
    Stage::ALL.into_iter().map(|stage| (stage.name(), of(stage))).collect()
}

/// The time that trees took in a flatten, which is in that of the flatten as well.
pub fn tree_time(report: &FlattenReport) -> Duration {
    let top = report.times.iter().find(|(name, _)| *name == "fit_top_tree");
    report.mesh_trees.time + top.map(|&(_, time)| time).unwrap_or_default()
}

/// The settings of a render in one line of JSON, as an EXR keeps them.
pub(crate) fn settings_text(render: &Render<'_>) -> String {
    serde_json::to_string(&SettingsStats::new(render)).expect("plain values have a text")
}

/// A scene's hash as files show it.
pub(crate) fn hash_text(hash: u64) -> String {
    format!("{hash:016x}")
}

/// The most memory that this process has had, in bytes, where the system tells.
pub fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes * 1024)
}

/// Seconds that the processor has worked for this program on all its threads, where the system tells.
#[cfg(target_os = "linux")]
pub fn processor_seconds() -> Option<f64> {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    Some(time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64)
}

/// Other systems are not asked.
#[cfg(not(target_os = "linux"))]
pub fn processor_seconds() -> Option<f64> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(target_os = "linux")]
    fn memory_grows_with_what_is_taken() {
        let before = peak_memory().expect("Linux tells");
        let block = vec![1u8; 64 << 20];
        assert!(block.iter().step_by(4096).all(|&byte| byte == 1));
        assert!(peak_memory().expect("as above") >= before.max(64 << 20));
    }
}
