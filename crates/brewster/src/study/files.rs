//! The folder of a study: its file, what was measured as JSON and CSV, charts, pictures and the report.

use std::fmt::{Display, Write as _};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{SystemTime, UNIX_EPOCH};
use std::{fs, io};

use brewster::film::{FilmError, LinearImage, PngSettings, write_atomically, write_png};

use serde::Serialize;
use serde_json::{Value, json};

use super::counters::Counted;
use super::measure::{Block, Clock};
use super::record::{Experiment, QueueRow, Results, StageRow};
use super::report;
use super::statistics::{Estimate, Verdict};

/// Where a study's results go.
pub(crate) struct Folder {
    path: PathBuf,
}

impl Folder {
    /// Makes the folder DATE-NAME in another one, which is made, too, if it is not there; with a number behind it if there is one
    /// already.
    pub(crate) fn create(parent: &Path, date: &str, name: &str) -> io::Result<Folder> {
        fs::create_dir_all(parent)?;
        let stem = format!("{date}-{}", slug(name));
        let names = (1..1000).map(|number| if number == 1 { stem.clone() } else { format!("{stem}-{number}") });
        for name in names {
            let path = parent.join(name);
            match fs::create_dir(&path) {
                Ok(()) => return Ok(Folder { path }),
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                Err(error) => return Err(error),
            }
        }
        Err(io::Error::from(io::ErrorKind::AlreadyExists))
    }

    /// The folder.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Writes the study file, as it was read.
    pub(crate) fn write_study(&self, text: &str) -> Result<(), FilmError> {
        self.write("study.ron", text)
    }

    /// Writes the picture of an experiment.
    pub(crate) fn write_picture(
        &self,
        experiment: &Experiment,
        image: &LinearImage,
        png: &PngSettings,
    ) -> Result<(), FilmError> {
        let name = format!("{}.png", slug(&experiment.title()));
        let folder = self.path.join("pictures");
        fs::create_dir_all(&folder).map_err(|source| FilmError::Io { path: folder.clone(), source })?;
        write_png(&folder.join(name), image, png)
    }

    /// Writes everything that was measured so far, and the report of it.
    pub(crate) fn write_results(&self, results: &Results) -> Result<(), FilmError> {
        self.write_json("results.json", results)?;
        self.write_json("samples.json", &samples(results))?;
        for (name, table) in tables(results) {
            self.write(name, &table)?;
        }
        let charts = report::charts(results);
        for chart in &charts {
            self.write(&format!("charts/{}.svg", slug(&chart.name)), &chart.diagram.svg())?;
        }
        self.write("report.html", &report::html(results, &charts))
    }

    fn write_json(&self, name: &str, value: &impl Serialize) -> Result<(), FilmError> {
        let json = serde_json::to_string(value).expect("plain values have a text");
        self.write(name, &(json + "\n"))
    }

    fn write(&self, name: &str, text: &str) -> Result<(), FilmError> {
        let path = self.path.join(name);
        let io_error = |source| FilmError::Io { path: path.clone(), source };
        fs::create_dir_all(path.parent().unwrap_or(&self.path)).map_err(io_error)?;
        write_atomically(&path, |file| file.write_all(text.as_bytes()).map_err(io_error))
    }
}

/// A name as files bear it: small letters, digits and dashes.
pub(crate) fn slug(name: &str) -> String {
    let mut slug = String::new();
    for letter in name.to_lowercase().chars() {
        if letter.is_alphanumeric() {
            slug.push(letter);
        } else if !slug.ends_with('-') {
            slug.push('-');
        }
    }
    slug.trim_matches('-').to_owned()
}

/// The day in UTC, such as 2026-11-22.
pub(crate) fn date() -> String {
    let seconds = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |time| time.as_secs());
    day(seconds / 86_400)
}

/// The civil date of a day counted from 1970-01-01.
fn day(mut days: u64) -> String {
    let leap = |year: u64| year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400));
    let mut year = 1970;
    while days >= 365 + u64::from(leap(year)) {
        days -= 365 + u64::from(leap(year));
        year += 1;
    }
    let mut month = 0;
    let lengths = [31, 28 + u64::from(leap(year)), 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];
    while days >= lengths[month] {
        days -= lengths[month];
        month += 1;
    }
    format!("{year}-{:02}-{:02}", month + 1, days + 1)
}

/// The commit of the current folder, with `+` behind it where files differ from it.
pub(crate) fn commit() -> Option<String> {
    let git = |arguments: &[&str]| {
        let output = Command::new("git").args(arguments).output().ok().filter(|output| output.status.success())?;
        Some(String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    let commit = git(&["rev-parse", "HEAD"])?;
    let mark = if git(&["status", "--porcelain", "-uno"])?.is_empty() { "" } else { "+" };
    Some(commit + mark)
}

/// What the baselines did sample by sample.
fn samples(results: &Results) -> Value {
    let of = |experiment: &Experiment| {
        let Experiment { scene, parameters, samples_apart, .. } = experiment;
        json!({ "scene": scene, "parameters": parameters, "samples": samples_apart })
    };
    let experiments: Vec<Value> = results.experiments.iter().map(of).collect();
    let Results { version, program, name, commit, .. } = results;
    json!({ "version": version, "program": program, "name": name, "commit": commit, "experiments": experiments })
}

/// The columns of what stages did.
const STAGES: &str =
    "depth,queue,stage,rays,calls,occupancy,seconds,bytes_read,bytes_written,operations,gigaoperations_per_second,roof";

/// The columns of what queues looked like.
const QUEUES: &str = "depth,queue,rays,taken,octant_run,material_run,nodes,instances,primitives,lengths,shadow_rays,shadow_nodes,shadow_instances,shadow_primitives";

/// Comma-separated tables; each begins with a row of names.
fn tables(results: &Results) -> [(&'static str, String); 10] {
    let experiments = || results.experiments.iter();
    let policies =
        || experiments().flat_map(|experiment| experiment.policies.iter().map(move |policy| (experiment, policy)));
    let mut rates = Table::new(
        "scene,parameters,policy,settings,mrays_per_second,clock,speedup,low,high,verdict,wall_speedup,wall_low,wall_high,queue_bytes",
    );
    let mut stages = Table::new(&format!("scene,parameters,policy,{STAGES}"));
    let mut queues = Table::new(&format!("scene,parameters,policy,{QUEUES}"));
    let mut counters = Table::new("scene,parameters,policy,counter,count,count_per_ray");
    for (experiment, policy) in policies() {
        let names = [&experiment.scene, &experiment.parameters, &policy.name].map(|name| quoted(name)).join(",");
        let (settings, rate) = (quoted(&policy.settings), optional(policy.rate));
        let clock = clock(experiment.clock);
        let (ratio, wall) = (bounds(policy.speedup), bounds(policy.wall_speedup));
        rates.row(&[&names, &settings, &rate, &clock, &ratio, &words(policy.verdict), &wall, &policy.queue_bytes]);
        for Counted { name, count } in &policy.counted {
            counters.row(&[&names, name, count, &(*count as f64 / experiment.rays.max(1) as f64)]);
        }
        policy.stages.iter().for_each(|row| stages.stage(&names, row));
        policy.queues.iter().for_each(|row| queues.queue(&names, row));
    }
    let mut sample_stages = Table::new(&format!("scene,parameters,sample,samples,{STAGES}"));
    let mut sample_queues = Table::new(&format!("scene,parameters,sample,samples,{QUEUES}"));
    for (experiment, record) in experiments().flat_map(|of| of.samples_apart.iter().map(move |record| (of, record))) {
        let names = [&experiment.scene, &experiment.parameters].map(|name| quoted(name)).join(",");
        let names = format!("{names},{},{}", record.sample, record.samples);
        record.stages.iter().for_each(|row| sample_stages.stage(&names, row));
        record.queues.iter().for_each(|row| sample_queues.queue(&names, row));
    }
    [
        ("experiments.csv", experiments_table(results).0),
        ("runs.csv", runs(results).0),
        ("policies.csv", rates.0),
        ("stages.csv", stages.0),
        ("queues.csv", queues.0),
        ("sample-stages.csv", sample_stages.0),
        ("sample-queues.csv", sample_queues.0),
        ("counters.csv", counters.0),
        ("builds.csv", builds(results).0),
        ("parameters.csv", parameters(results).0),
    ]
}

/// What was rendered, and what the baseline shows against itself.
fn experiments_table(results: &Results) -> Table {
    let mut table = Table::new(
        "scene,parameters,integrator,width,height,samples,max_depth,rays,picture,rounds,clock,control,low,high,intervals,confidence,overhead",
    );
    for experiment in &results.experiments {
        let Experiment { integrator, resolution: [width, height], samples, max_depth, rays, picture, .. } = experiment;
        let names = [&experiment.scene, &experiment.parameters].map(|name| quoted(name)).join(",");
        let size = [width, height, samples, max_depth].map(u32::to_string).join(",");
        let (clock, control) = (clock(experiment.clock), bounds(experiment.control));
        let level = format!("{},{}", results.intervals, results.confidence);
        let (rounds, overhead) = (experiment.rounds, experiment.overhead);
        table.row(&[&names, integrator, &size, rays, picture, &rounds, &clock, &control, &level, &overhead]);
    }
    table
}

/// Every run. What is compared stands in one row: a subject's run, and the one of the baseline beside it.
fn runs(results: &Results) -> Table {
    let mut table = Table::new("scene,subject,round,run,seconds,cpu_seconds,baseline_seconds,baseline_cpu_seconds");
    let mut add = |scene: &str, subject: &str, blocks: &[Block]| {
        let names = [scene, subject].map(quoted).join(",");
        for (round, Block { baseline, own }) in blocks.iter().enumerate() {
            for (run, (own, baseline)) in own.iter().zip(baseline).enumerate() {
                let [own_cpu, baseline_cpu] = [own, baseline].map(|took| optional(took.cpu));
                table.row(&[&names, &round, &run, &own.wall, &own_cpu, &baseline.wall, &baseline_cpu]);
            }
        }
    };
    for experiment in &results.experiments {
        let title = experiment.title();
        experiment.policies.iter().for_each(|policy| add(&title, &policy.name, &policy.blocks));
        experiment.builds.iter().skip(1).for_each(|build| add(&title, &format!("trees {}", build.name), &build.blocks));
    }
    for quality in &results.qualities {
        quality.parameters.iter().for_each(|set| add(&quality.scene, &set.name, &set.blocks));
    }
    table
}

fn clock(clock: Clock) -> &'static str {
    match clock {
        Clock::Wall => "wall",
        Clock::Processor => "processor",
    }
}

fn builds(results: &Results) -> Table {
    let mut table = Table::new("scene,parameters,trees,median_seconds,bytes,speedup,low,high,verdict");
    for experiment in &results.experiments {
        for build in &experiment.builds {
            let names = [&experiment.scene, &experiment.parameters, &build.name].map(|name| quoted(name)).join(",");
            let (seconds, verdict) = (optional(build.median), words(build.verdict));
            table.row(&[&names, &seconds, &build.bytes, &bounds(build.speedup), &verdict]);
        }
    }
    table
}

fn parameters(results: &Results) -> Table {
    let mut table = Table::new("scene,parameters,settings,efficiency,ratio,low,high,verdict,z,events,events_needed");
    for quality in &results.qualities {
        for set in &quality.parameters {
            let names = [&quality.scene, &set.name, &set.settings].map(|name| quoted(name)).join(",");
            let numbers = [set.z, set.events, set.events_needed].map(optional).join(",");
            table.row(&[&names, &optional(set.efficiency), &bounds(set.ratio), &words(set.verdict), &numbers]);
        }
    }
    table
}

/// A table that grows row by row.
struct Table(String);

impl Table {
    fn new(names: &str) -> Table {
        Table(format!("{names}\n"))
    }

    fn row(&mut self, cells: &[&dyn Display]) {
        for (place, cell) in cells.iter().enumerate() {
            let comma = if place > 0 { "," } else { "" };
            write!(self.0, "{comma}{cell}").expect("a string takes all that is written");
        }
        self.0.push('\n');
    }

    /// A row of [`STAGES`], behind cells of one's own.
    fn stage(&mut self, names: &str, row: &StageRow) {
        let StageRow { depth, queue, stage, rays, calls, occupancy, seconds, .. } = row;
        let work = [row.read, row.written, row.operations].map(|number| number.to_string()).join(",");
        self.row(&[&names, depth, queue, stage, rays, calls, occupancy, seconds, &work, &row.rate, &row.roof]);
    }

    /// A row of [`QUEUES`], likewise.
    fn queue(&mut self, names: &str, row: &QueueRow) {
        let lengths: Vec<String> = row.lengths.iter().map(u64::to_string).collect();
        let QueueRow { depth, queue, rays, taken, octant_run, material_run, shadow_rays, .. } = row;
        let visits = [row.nodes, row.instances, row.primitives].map(|number| number.to_string()).join(",");
        let shadows = [row.shadow_nodes, row.shadow_instances, row.shadow_primitives];
        let shadows = shadows.map(|number| number.to_string()).join(",");
        let runs = [octant_run, material_run].map(|number| number.to_string()).join(",");
        self.row(&[&names, depth, queue, rays, taken, &runs, &visits, &lengths.join(" "), shadow_rays, &shadows]);
    }
}

fn optional(value: Option<f64>) -> String {
    value.map_or(String::new(), |value| value.to_string())
}

/// Median, low and high: three cells.
fn bounds(estimate: Option<Estimate>) -> String {
    match estimate {
        Some(Estimate { median, low, high }) => format!("{median},{low},{high}"),
        None => ",,".to_owned(),
    }
}

fn words(verdict: Option<Verdict>) -> &'static str {
    verdict.map_or("", Verdict::words)
}

/// A cell that may hold commas.
fn quoted(text: &str) -> String {
    match text.contains([',', '"', '\n']) {
        true => format!("\"{}\"", text.replace('"', "\"\"")),
        false => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// From a calendar.
    #[test]
    fn days_have_dates() {
        for (days, expected) in [
            (0, "1970-01-01"),
            (59, "1970-03-01"),
            (11_016, "2000-02-29"),
            (20_778, "2026-11-21"),
            (20_818, "2026-12-31"),
        ] {
            assert_eq!(day(days), expected, "{days}");
        }
    }

    #[test]
    fn folders_are_made_in_one_another_and_never_twice() {
        let desk = tempfile::tempdir().expect("a folder");
        let parent = desk.path().join("kept/runs");
        let [first, second] =
            [(); 2].map(|()| Folder::create(&parent, "2026-11-22", "Two orders").expect("a folder").path);
        assert_eq!(first, parent.join("2026-11-22-two-orders"));
        assert_eq!(second, parent.join("2026-11-22-two-orders-2"));
        assert!(first.is_dir() && second.is_dir());
    }

    #[test]
    fn names_become_names_of_files() {
        for (name, expected) in [("Batch size", "batch-size"), ("a/../b: 50 %", "a-b-50"), ("Glas – grün", "glas-grün")]
        {
            assert_eq!(slug(name), expected);
        }
    }

    #[test]
    fn cells_with_commas_are_quoted() {
        assert_eq!(quoted("a, \"b\""), "\"a, \"\"b\"\"\"");
        assert_eq!(quoted("plain"), "plain");
    }
}
