//! `brewster study`: which way of scheduling is faster.

use std::cell::RefCell;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use brewster::film::PngSettings;
use brewster::import::study::{Study, load_study, load_study_text};
use brewster::wavefront::Control;
use brewster::{PROGRAM, Render, RenderOptions, Session, SessionError};
use clap::{ArgGroup, Args};
use glam::UVec2;

use super::values;
use super::{Failure, print};
use crate::interrupt::Interrupt;
use crate::study::{self, Folder, Machine, Results, VERSION, Watch};
use crate::terminal::Terminal;

/// Measures which way of scheduling is faster, fairly and with the evidence kept.
///
/// A study file in RON, or the options, name scenes, policies and parameters. Every scene is rendered by every policy in turn, between
/// two pictures of the baseline; every picture is checked. What is found goes to a folder DATE-NAME with a report. Ctrl-C ends the study with a report
/// of the whole rounds so far.
#[derive(Debug, Args)]
#[command(group = ArgGroup::new("what").required(true).multiple(true).args(["file", "scene"]))]
pub(crate) struct Arguments {
    /// The study file.
    file: Option<PathBuf>,
    /// Without a file: a scene; may be given several times.
    #[arg(long, value_name = "SCENE", conflicts_with = "file")]
    scene: Vec<PathBuf>,
    /// Without a file: a policy, such as 'sorted=(sort: Octant)'; may be given several times, the baseline first.
    #[arg(long, value_name = "NAME=(…)", value_parser = named, conflicts_with = "file")]
    policy: Vec<(String, String)>,
    /// Without a file: a set of parameters, such as 'split=(split_depth: 3)'; may be given several times.
    #[arg(long, value_name = "NAME=(…)", value_parser = named, conflicts_with = "file")]
    parameters: Vec<(String, String)>,
    /// Without a file: batches to compare, such as 256,1024.
    #[arg(long, value_name = "N,N", value_delimiter = ',', conflicts_with = "file")]
    batches: Vec<u32>,
    /// The study's name, in place of the file's.
    #[arg(long, value_name = "NAME")]
    name: Option<String>,
    /// Rounds of measurement, in place of the file's.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    rounds: Option<u32>,
    /// Width and height of all pictures, in place of the file's.
    #[arg(long, value_name = "WxH", value_parser = values::resolution)]
    resolution: Option<UVec2>,
    /// Samples per pixel, in place of the file's.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_048_576))]
    samples: Option<u32>,
    /// The folder in which that of the results is made.
    #[arg(short, long, value_name = "DIR", default_value = ".")]
    output: PathBuf,
    /// Also write when every worker did what in one render by the baseline, for Perfetto.
    #[arg(long)]
    trace: bool,
    /// Say nothing but errors.
    #[arg(short, long)]
    quiet: bool,
}

/// `NAME=(…)`.
fn named(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((name, value)) if !name.trim().is_empty() && value.trim_start().starts_with('(') => {
            Ok((name.trim().to_owned(), value.trim().to_owned()))
        }
        _ => Err("expected NAME=(…), such as 'sorted=(sort: Octant)'".to_owned()),
    }
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let terminal = Terminal::new(arguments.quiet);
    let interrupt = Interrupt::listen()?;
    let (study, text) = arguments.study()?;
    let subjects = study::subjects(&study)?;
    // What cannot be rendered is said before anything is measured.
    for scene in &study.scenes {
        for parameters in &study.parameters {
            check(&study::load(&study, scene, parameters)?)?;
        }
    }
    let date = study::date();
    let folder = Folder::create(&arguments.output, &date, &study.name)
        .map_err(|error| Failure::Input(format!("{}: {error}", arguments.output.display())))?;
    folder.write_study(&text)?;
    terminal.say(format_args!("folder   {}", folder.path().display()));
    let progress = terminal.count("study", steps(&study, &subjects));
    progress.remark("looking at the machine".to_owned());
    let done = RefCell::new(0);
    let stop = || interrupt.asked();
    let step = |text: String| {
        progress.remark(text);
        progress.advance(*done.borrow());
        *done.borrow_mut() += 1;
    };
    let watch = Watch { stop: &stop, control: interrupt.control(), step: &step };
    let intervals = study::intervals(&study, &subjects);
    let mut results = Results {
        version: VERSION,
        program: PROGRAM,
        name: study.name.clone(),
        text: study.text.clone(),
        date,
        commit: study::commit(),
        rounds: study.rounds,
        complete: false,
        intervals,
        confidence: study::confidence(intervals),
        machine: Machine::look(),
        experiments: Vec::new(),
        qualities: Vec::new(),
    };
    for scene in &study.scenes {
        for parameters in &study.parameters {
            if stop() {
                break;
            }
            let session = study::load(&study, scene, parameters)?;
            let (experiment, image) =
                study::experiment(&study, &subjects, &session, &parameters.name, &results.machine, &watch)?;
            if let Some(image) = image {
                folder.write_picture(&experiment, &image, &PngSettings::default())?;
            }
            if arguments.trace && !stop() {
                write_trace(&session, &subjects[0], &folder, &experiment.title(), interrupt.control())?;
            }
            results.experiments.push(experiment);
            folder.write_results(&results)?;
        }
        if study.parameters.len() > 1 && !stop() {
            results.qualities.push(study::quality(&study, scene, &subjects, &watch)?);
            folder.write_results(&results)?;
        }
    }
    results.complete = results.is_whole(&study);
    folder.write_results(&results)?;
    progress.end(if results.complete { "done" } else { "interrupted; the report tells of the whole rounds" });
    print(results.summary())?;
    terminal.say(format_args!("wrote    {}", folder.path().join("report.html").display()));
    if results.complete { Ok(()) } else { Err(Failure::Interrupted) }
}

impl Arguments {
    /// The study, and its text.
    fn study(&self) -> Result<(Study, String), Failure> {
        let read = match &self.file {
            Some(file) => load_study(file),
            None => load_study_text(Path::new("command-line"), &self.text()),
        };
        let (mut study, text) =
            read.map_err(|failure| Failure::Diagnostics(failure.to_string().trim_end().to_owned()))?;
        study.name = self.name.clone().unwrap_or(study.name);
        study.rounds = self.rounds.unwrap_or(study.rounds);
        study.resolution = self.resolution.map(|size| size.to_array()).or(study.resolution);
        study.samples = self.samples.or(study.samples);
        Ok((study, text))
    }

    /// What the options say, as a study file says it.
    fn text(&self) -> String {
        let name = self.name.clone().unwrap_or_else(|| "study".to_owned());
        let mut text = format!("Study(\n    name: {name:?},\n    scenes: [");
        for scene in &self.scene {
            write!(text, "{:?}, ", scene.to_string_lossy()).expect("a string takes all that is written");
        }
        text.push_str("],\n");
        for (field, entries) in [("policies", &self.policy), ("parameters", &self.parameters)] {
            write!(text, "    {field}: {{").expect("as above");
            for (name, value) in entries {
                write!(text, "\n        {name:?}: {value},").expect("as above");
            }
            text.push_str("\n    },\n");
        }
        writeln!(text, "    batches: {:?},\n)", self.batches).expect("as above");
        text
    }
}

/// Whether a scene can be rendered.
fn check(session: &Session) -> Result<(), SessionError> {
    session.render(RenderOptions { threads: 1, ..RenderOptions::default() }).map(|_: Render<'_>| ())
}

/// Blocks of all experiments, and the runs that count.
fn steps(study: &Study, subjects: &[study::Subject]) -> u64 {
    let if_many = |number: u64| if number > 1 { number * u64::from(study.rounds) } else { 0 };
    let (policies, sets) = (subjects.len() as u64, study.parameters.len() as u64);
    let counting_and_blocks = policies + 2 + policies * u64::from(study.policy_rounds());
    let builds = if_many(study::ways(subjects).len() as u64);
    study.scenes.len() as u64 * (sets * (counting_and_blocks + builds) + if_many(sets))
}

/// Renders once more and writes what every worker did when.
fn write_trace(
    session: &Session,
    baseline: &study::Subject,
    folder: &Folder,
    title: &str,
    control: &Control,
) -> Result<(), Failure> {
    let options =
        RenderOptions { threads: baseline.threads, policy: baseline.policy, trace: true, ..Default::default() };
    let mut render = session.render(options)?;
    while render.remaining() > 0 && !control.stopped() {
        render.pass(control);
    }
    render.write_trace(&folder.path().join(format!("trace-{}.json", study::slug(title))))?;
    Ok(())
}
