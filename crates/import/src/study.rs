//! Study files: which scenes a throughput study renders, and how.
//!
//! They are RON, read with the same diagnostics as scenes; the crate's `study.md` describes the format.

use std::path::{Path, PathBuf};

use brewster_world::components::parts::Integrator;

use crate::Failure;
use crate::diagnostics::Code;
use crate::limits::{Exceeded, Limits};
use crate::ron::schema::study as schema;
use crate::ron::{check_resolution, convert_integrator, read_study};
use crate::session::{Assets, Session};
use crate::source::{SourceId, Span};

/// What a study compares.
#[derive(Clone, Debug, PartialEq)]
pub struct Study {
    /// Its name.
    pub name: String,
    /// What it is about, in the author's words.
    pub text: String,
    /// Scene files.
    pub scenes: Vec<PathBuf>,
    /// Ways of scheduling, the baseline first; at least one.
    pub policies: Vec<Policy>,
    /// Settings that change pictures; at least one, which may be that of no change.
    pub parameters: Vec<Parameters>,
    /// Width and height of all pictures, if not as the scenes say.
    pub resolution: Option<[u32; 2]>,
    /// Samples of all pictures, if not as the scenes say.
    pub samples: Option<u32>,
    /// Rounds of measurement.
    pub rounds: u32,
    /// Runs before a block that are thrown away.
    pub warm_up: u32,
}

impl Study {
    /// Rounds in which policies take turns: one where there is a single policy, which has nothing to be compared with.
    pub fn policy_rounds(&self) -> u32 {
        if self.policies.len() > 1 { self.rounds } else { 1 }
    }
}

/// How work is scheduled.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Policy {
    /// Its name.
    pub name: String,
    /// Camera rays in a batch.
    pub batch: u32,
    /// Rays traced at once.
    pub capacity: u32,
    /// Threads.
    pub threads: u32,
    /// The key by which rays are ordered.
    pub sort: Sort,
    /// Which queue goes first.
    pub order: Order,
    /// How rays are taken through the trees.
    pub kernel: Kernel,
    /// How escaped rays leave the queue of hits.
    pub compaction: Compaction,
    /// How trees are built.
    pub tree: Tree,
    /// The instruction set; the best for `None`.
    pub level: Option<Level>,
    /// How paths are followed.
    pub executor: Executor,
    /// Whether it comes from the list of batches.
    pub of_batches: bool,
}

/// Settings that change a picture.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Parameters {
    /// Their name; empty where the study has none.
    pub name: String,
    /// How light is carried.
    pub integrator: Option<Integrator>,
    /// Interactions before which a dielectric sends both rays.
    pub split_depth: Option<u32>,
    /// Whether diffuse surfaces look for the light that mirrors and glass throw on them.
    pub guiding: Option<bool>,
    /// Samples per pixel.
    pub samples: Option<u32>,
    /// Interactions that may scatter on.
    pub max_depth: Option<u32>,
}

macro_rules! choices {
    ($($(#[$meta:meta])* $name:ident { $($(#[$variant_meta:meta])* $variant:ident,)+ })+) => {$(
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum $name { $($(#[$variant_meta])* $variant,)+ }

        impl From<schema::$name> for $name {
            fn from(choice: schema::$name) -> $name {
                match choice { $(schema::$name::$variant {} => $name::$variant,)+ }
            }
        }
    )+};
}

choices! {
    /// The key by which rays are ordered before they are traced.
    Sort {
        /// As they come.
        None,
        /// By the material of the surface that they left.
        Material,
        /// By the octant of their direction.
        Octant,
        /// Along a Morton curve.
        Morton,
        /// By octant, then along the curve.
        OctantMorton,
    }
    /// Which queue of a depth is traced first.
    Order {
        /// Reflections.
        ReflectionFirst,
        /// Transmissions.
        TransmissionFirst,
        /// Both together.
        Merged,
    }
    /// How paths are followed.
    Executor {
        /// From queue to queue.
        Wavefront,
        /// One at a time.
        Megakernel,
    }
    /// How escaped rays leave the queue of hits.
    Compaction {
        /// Row by row, at a branch.
        Branch,
        /// Ahead of the others, by a cursor.
        Cursor,
    }
    /// How trees are built.
    Tree {
        /// From the top down.
        Binned,
        /// From the bottom up.
        Clustered,
    }
    /// How rays are taken through the trees.
    Kernel {
        /// Packets and waves.
        Packets,
        /// Waves.
        Wave,
        /// One by one.
        Single,
        /// One by one, by obvhs's traversal.
        Obvhs,
    }
}

/// An instruction set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// AVX-512.
    Avx512,
    /// AVX2 and FMA.
    Avx2,
    /// What every machine has.
    Baseline,
}

/// Reads a study file.
///
/// # Errors
///
/// What is wrong with it, with places and nearest names.
pub fn load_study(path: &Path) -> Result<(Study, String), Failure> {
    load(path, |session| session.read_scene(path))
}

/// Reads a study whose file would stand at `path` and say `text`.
///
/// # Errors
///
/// As [`load_study`].
pub fn load_study_text(path: &Path, text: &str) -> Result<(Study, String), Failure> {
    load(path, |session| session.add_scene(path, text.as_bytes().to_vec()))
}

fn load(path: &Path, read: impl FnOnce(&mut Session<'_>) -> Option<SourceId>) -> Result<(Study, String), Failure> {
    let mut assets = Assets::default();
    // A study reads nothing but itself, and may name scenes anywhere; what these may read is for their own sandbox to say.
    let anywhere = [PathBuf::from("/")];
    let mut session = Session::new(path, &anywhere, Limits::DEFAULT, &mut assets);
    let source = read(&mut session);
    let study = source.and_then(|source| {
        let file = read_study(&mut session, source)?;
        check_combinations(&mut session, &file)?;
        Some((resolve(&mut session, file, path), session.sources.get(source).text.clone()))
    });
    let (errors, dependencies) = (session.found.errors(), session.dependencies);
    match study {
        Some(study) if errors == 0 => Ok(study),
        _ => Err(Failure { diagnostics: session.found.finish(), dependencies }),
    }
}

/// Refuses, at its longest list, a study of more combinations than anyone waits for. None if it is refused.
fn check_combinations(session: &mut Session<'_>, file: &schema::Study) -> Option<()> {
    let schema::Study { scenes, policies, batches, parameters, .. } = file;
    let lists = [
        (scenes.value.len(), scenes.span),
        (policies.value.rows.len(), policies.span),
        (batches.value.len(), batches.span),
        (parameters.value.rows.len(), parameters.span),
    ];
    let [scenes, policies, batches, sets] = lists.map(|(len, _)| len as u64);
    let combinations = scenes.saturating_mul(policies.max(1) + batches).saturating_mul(sets.max(1));
    let bound = session.limits.study_combinations;
    if combinations <= bound {
        return Some(());
    }
    let exceeded = Exceeded { name: "study_combinations", bound };
    let (_, longest) = lists.into_iter().max_by_key(|&(len, _)| len)?;
    let message = format!("{combinations} combinations of scenes, policies and parameters are too many: {exceeded}");
    session.error(Code::Limit, longest, message);
    None
}

/// Looks names up and reports what does not go together.
fn resolve(session: &mut Session<'_>, file: schema::Study, path: &Path) -> Study {
    let schema::Study { span, name, text, scenes, resolution, samples, rounds, warm_up, .. } = file;
    if name.trim().is_empty() {
        session.error(Code::Range, span, "the study has no name");
    }
    if let Some(resolution) = &resolution {
        check_resolution(session, resolution);
    }
    let resolution = resolution.map(|resolution| resolution.value);
    let folder = path.parent().unwrap_or(Path::new(""));
    if scenes.value.is_empty() {
        session.error(Code::MissingField, scenes.span, "there is no scene to render");
    }
    let scenes = scenes.value.iter().map(|scene| {
        if !folder.join(&scene.value).is_file() {
            let error = session.sources.error(Code::File, scene.span, format!("there is no file {:?}", scene.value));
            let folder = session.sources.get(scene.span.source).folder.clone();
            let near = session.neighbor(&folder, &scene.value);
            session.found.push(match near {
                Some(near) => error.help(format!("did you mean {near:?}?")),
                None => error,
            });
        }
        folder.join(&scene.value)
    });
    let scenes = scenes.collect();
    let mut policies: Vec<Policy> = named(session, "policies", file.policies.value).into_iter().map(policy).collect();
    if policies.is_empty() {
        policies.push(policy(("as it is".to_owned(), default_policy(span))));
    }
    if let Some(baseline) = file.baseline {
        match policies.iter().position(|policy| policy.name == baseline.value) {
            Some(place) => policies[..=place].rotate_right(1),
            None => {
                let message = format!("there is no policy {:?}", baseline.value);
                let error = session.sources.error(Code::UnknownName, baseline.span, message);
                let names = policies.iter().map(|policy| policy.name.as_str());
                session.found.push(error.nearest_name(&baseline.value, names));
            }
        }
    }
    for batch in file.batches.value {
        let same = |policy: &Policy| policy.batch == batch && policy.capacity == batch;
        if !same(&policies[0]) && !policies.iter().any(|policy| policy.of_batches && same(policy)) {
            let name = format!("batch {batch}");
            policies.push(Policy { name, batch, capacity: batch, of_batches: true, ..policies[0].clone() });
        }
    }
    let parameters = named(session, "parameters", file.parameters.value).into_iter().map(parameters);
    let mut parameters: Vec<Parameters> = parameters.collect();
    if parameters.is_empty() {
        parameters.push(Parameters::default());
    }
    Study { name, text, scenes, policies, parameters, resolution, samples, rounds, warm_up }
}

/// Named values; a name that is given twice is reported.
fn named<T>(session: &mut Session<'_>, kind: &str, named: crate::ron::Named<T>) -> Vec<(String, T)> {
    let mut rows: Vec<(String, T)> = Vec::new();
    for (name, value) in named.rows {
        if rows.iter().any(|(known, _)| *known == name.value) {
            session.error(Code::Duplicate, name.span, format!("the name {:?} is given twice in `{kind}`", name.value));
        }
        rows.extend(value.map(|value| (name.value, value.value)));
    }
    rows
}

fn default_policy(span: Span) -> schema::Policy {
    schema::Policy {
        span,
        intact: true,
        batch: 4096,
        capacity: None,
        threads: 1,
        sort: schema::Sort::None {},
        order: schema::Order::ReflectionFirst {},
        kernel: schema::Kernel::Packets {},
        compaction: schema::Compaction::Branch {},
        tree: schema::Tree::Binned {},
        level: schema::Level::Best {},
        executor: schema::Executor::Wavefront {},
    }
}

fn policy((name, policy): (String, schema::Policy)) -> Policy {
    let schema::Policy { batch, capacity, threads, sort, order, kernel, compaction, tree, level, executor, .. } =
        policy;
    Policy {
        name,
        batch,
        capacity: capacity.unwrap_or(batch),
        threads,
        sort: sort.into(),
        order: order.into(),
        kernel: kernel.into(),
        compaction: compaction.into(),
        tree: tree.into(),
        level: match level {
            schema::Level::Best {} => None,
            schema::Level::Avx512 {} => Some(Level::Avx512),
            schema::Level::Avx2 {} => Some(Level::Avx2),
            schema::Level::Baseline {} => Some(Level::Baseline),
        },
        executor: executor.into(),
        of_batches: false,
    }
}

fn parameters((name, parameters): (String, schema::Parameters)) -> Parameters {
    let schema::Parameters { integrator, split_depth, guiding, samples, max_depth, .. } = parameters;
    Parameters {
        name,
        integrator: integrator.map(|integrator| convert_integrator(&integrator)),
        split_depth,
        guiding,
        samples,
        max_depth,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(text: &str) -> String {
        match load_study_text(Path::new("tests/a.ron"), text) {
            Ok((study, _)) => format!("{study:?}"),
            Err(failure) => failure.to_string(),
        }
    }

    #[test]
    fn a_study_is_all_that_its_file_says() {
        let text = r#"Study(name: "n", scenes: ["../Cargo.toml"], baseline: "b", policies: {
            "a": (sort: Octant), "b": (batch: 512, threads: 2),
        }, batches: [64, 512], parameters: {"deep": (integrator: Path, max_depth: 9)})"#;
        let (study, kept) = load_study_text(Path::new("tests/a.ron"), text).expect("the study is right");
        assert_eq!(kept, text);
        let names: Vec<_> =
            study.policies.iter().map(|policy| (policy.name.as_str(), policy.batch, policy.threads)).collect();
        assert_eq!(names, [("b", 512, 2), ("a", 4096, 1), ("batch 64", 64, 2)]);
        assert_eq!((study.policies[1].sort, study.rounds), (Sort::Octant, 9));
        let deep = &study.parameters[0];
        assert_eq!((deep.integrator, deep.max_depth, deep.split_depth), (Some(Integrator::Path), Some(9), None));
    }

    /// The messages by hand, as a scene's would be.
    #[test]
    fn broken_studies_are_told_where_and_what_was_meant() {
        let study = |fields: &str| format!("Study(name: \"n\", scenes: [\"../Cargo.toml\"], {fields})");
        for (text, expected) in [
            (study("policies: {\"a\": (sort: Octent)}"), "`Octent` is no Sort\n --> tests/a.ron:1:68\n"),
            (study("policies: {\"a\": (sort: Octent)}"), "help: did you mean `Octant`?"),
            (study("polices: {}"), "help: did you mean `policies`?"),
            (study("policies: {\"plain\": ()}, baseline: \"plane\""), "help: did you mean \"plain\"?"),
            (study("policies: {\"a\": (), \"a\": ()}"), "the name \"a\" is given twice in `policies`"),
            (study("batches: [0]"), "out of range for `batches`"),
            (study("rounds: 0"), "1 to 1000"),
            (study("resolution: (0, 10)"), "1 to 65536"),
            (study("resolution: (60000, 60000)"), "limit `picture_pixels` is 134217728\n --> tests/a.ron:1:57\n"),
            ("Study(name: \"n\", scenes: [\"../Cargo.tom\"])".into(), "did you mean \"../Cargo.toml\"?"),
            ("Study(name: \"n\", scenes: [])".into(), "there is no scene to render\n --> tests/a.ron:1:26\n"),
            ("Study(scenes: [\"../Cargo.toml\"])".into(), "the field `name` is missing"),
            ("Study(name: \"n\"".into(), "error[syntax]"),
            ("Scene()".into(), "expected `Study(…)`, found `Scene`"),
        ] {
            assert!(found(&text).contains(expected), "{text}: {expected:?} is not in\n{}", found(&text));
        }
    }

    /// By hand: scenes times policies times sets of parameters; the place is that of the longest list.
    #[test]
    fn studies_that_would_never_end_are_refused() {
        let study = |scenes: usize, batches: usize, sets: usize| {
            let scenes = "\"../Cargo.toml\",".repeat(scenes);
            let batches: String = (1..=batches).map(|batch| format!("{batch},")).collect();
            let sets: String = (0..sets).map(|set| format!("\"{set}\": (),")).collect();
            found(&format!("Study(name: \"n\", scenes: [{scenes}],\nbatches: [{batches}],\nparameters: {{{sets}}})"))
        };
        let message = "combinations of scenes, policies and parameters are too many: limit `study_combinations` is 4096\n --> tests/a.ron";
        for (found, expected) in [
            (study(1, 4095, 0), "rounds: 9".to_owned()),
            (study(1, 4096, 0), format!("error[limit]: 4097 {message}:2:10\n")),
            (study(4097, 0, 1), format!("error[limit]: 4097 {message}:1:26\n")),
            (study(3, 15, 86), format!("error[limit]: 4128 {message}:3:13\n")),
        ] {
            assert!(found.contains(&expected), "{expected:?} is not in\n{}", &found[..found.len().min(1000)]);
        }
    }
}
