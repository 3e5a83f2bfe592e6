//! glTF 2.0 files: [`container`] takes the file apart, [`document`] types and checks its JSON and reads its buffers,
//! [`accessors`] reads numbers and [`fields`] objects, [`nodes`] lists the entities with their [`meshes`], [`materials`],
//! [`cameras`] and lights. [`extensions`] holds what extensions add.
//!
//! A broken file is one error, which names the place in the JSON. What is left out without harm is a warning. What is made of
//! every extension, and of what the specification leaves open, is a note.

mod accessors;
mod animations;
mod cameras;
mod container;
mod document;
mod extensions;
mod fields;
mod materials;
mod meshes;
mod nodes;
mod skins;
mod tangents;
#[cfg(test)]
mod testing;
mod textures;
mod validate;

use std::path::Path;

use brewster_world::components as world;
use brewster_world::components::parts;
use gltf::json::Value;
use serde::de::DeserializeOwned;

use crate::diagnostics::{Code, Diagnostic, Severity};
use crate::environment::View;
use crate::findings::Findings;
use crate::scene::{Part, Row, Scene};
use crate::session::{Asset, Session};
use crate::source::{Source, Span};
use crate::{LoadOptions, view};

use document::Document;

/// Which of the things that a glTF file offers are taken.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GltfChoices {
    /// The scene, by name or number; the file's default one, otherwise its first.
    pub scene: Option<String>,
    /// The variant of the materials, by name or number; none for the default materials.
    pub variant: Option<String>,
    /// The animation, by name or number, or `all`; the first.
    pub animation: Option<String>,
    /// The moment of the animation in seconds; none for the pose that the nodes have without it.
    pub time: Option<f32>,
    /// How long the shutter is open from that moment on, in seconds: nodes move on meanwhile. None for a still picture.
    pub shutter: Option<f32>,
}

impl GltfChoices {
    /// The option of the command line that chooses anything, if one does.
    pub(crate) fn first(&self) -> Option<&'static str> {
        let GltfChoices { scene, variant, animation, time, shutter } = self;
        let chosen = [
            (scene.is_some(), "`--scene`"),
            (variant.is_some(), "`--variant`"),
            (animation.is_some(), "`--animation`"),
            (shutter.is_some(), "`--shutter`"),
            (time.is_some(), "`--time` or `--frames`"),
        ];
        chosen.into_iter().find_map(|(is_chosen, option)| is_chosen.then_some(option))
    }
}

/// A result, or what is wrong with the file.
type Found<T> = Result<T, Box<Diagnostic>>;

/// An error at a place of the JSON.
fn broken(path: impl Into<String>, message: impl Into<String>) -> Diagnostic {
    Diagnostic::about_path(Severity::Error, Code::Gltf, path, message)
}

/// An error about a limit.
fn too_much(path: impl Into<String>, message: impl Into<String>) -> Diagnostic {
    Diagnostic { code: Code::Limit, ..broken(path, message) }
}

/// A value of the JSON as a type; `path` is its place.
fn typed<T: DeserializeOwned>(value: &Value, path: &str) -> Found<T> {
    serde_path_to_error::deserialize(value).map_err(|error| {
        let place = match error.path().to_string() {
            within if within == "." => path.to_owned(),
            within if path.is_empty() || within.starts_with('[') => format!("{path}{within}"),
            within => format!("{path}.{within}"),
        };
        Box::new(broken(place, error.inner().to_string()))
    })
}

/// Collects what there is to say about the file beside errors.
struct Reporter {
    file: String,
    said: Vec<Diagnostic>,
}

impl Reporter {
    fn new(file: impl Into<String>) -> Reporter {
        Reporter { file: file.into(), said: Vec::new() }
    }

    fn warn(&mut self, code: Code, path: impl Into<String>, message: impl Into<String>) {
        self.say(Severity::Warning, code, path, message);
    }

    fn note(&mut self, code: Code, path: impl Into<String>, message: impl Into<String>) {
        self.say(Severity::Note, code, path, message);
    }

    /// Says something, the same about many places once.
    fn say(&mut self, severity: Severity, code: Code, path: impl Into<String>, message: impl Into<String>) {
        let message = message.into();
        if !self.said.iter().any(|said| said.message == message) {
            self.said.push(Diagnostic::about_path(severity, code, path, message).in_file(self.file.clone()));
        }
    }

    /// Says what was an error elsewhere.
    fn say_as(&mut self, severity: Severity, problem: Diagnostic) {
        self.said.push(Diagnostic { severity, ..problem.in_file(self.file.clone()) });
    }

    fn finish(self, found: &mut Findings) {
        self.said.into_iter().for_each(|diagnostic| found.push(diagnostic));
    }
}

/// Whether a file of that name is for this importer.
pub(crate) fn is_gltf(path: &Path) -> bool {
    path.extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("gltf") || extension.eq_ignore_ascii_case("glb"))
}

/// The scene in a file, or `None` after an error.
pub(crate) fn load(session: &mut Session, path: &Path, options: &LoadOptions) -> Option<Scene> {
    let bytes = session.read_gltf(path)?;
    load_bytes(session, path, &bytes, options)
}

/// The same of a file whose bytes are known.
pub(crate) fn load_bytes(session: &mut Session, path: &Path, bytes: &[u8], options: &LoadOptions) -> Option<Scene> {
    let mut reporter = Reporter::new(path.to_string_lossy());
    let scene = read(session, &mut reporter, path, bytes, options);
    let file = reporter.file.clone();
    reporter.finish(&mut session.found);
    scene.map_err(|error| session.found.push(error.in_file(file))).ok().flatten()
}

fn read(
    session: &mut Session,
    reporter: &mut Reporter,
    path: &Path,
    bytes: &[u8],
    options: &LoadOptions,
) -> Found<Option<Scene>> {
    if let Some((path, _)) = options.overrides.first() {
        let problem = broken("", format!("there is no {path:?} to set: values of glTF files cannot be overridden"));
        return Err(problem.expected("a scene in RON").into());
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let folder = folder.canonicalize().unwrap_or_else(|_| folder.to_path_buf());
    let mut document = Document::open(session, reporter, bytes, &folder)?;
    animations::pose(&mut document, reporter, &options.gltf)?;
    let name = reporter.file.clone();
    let source = session.sources.add(Source { name, folder, text: String::new() });
    let source = source.ok_or_else(|| broken("", "too many files"))?;
    let span = Span { source, start: 0, end: 0 };
    let rows = nodes::read((session, reporter), &document, &options.gltf, span, None)?;
    if rows.iter().all(|row| matches!(row.shape, Part::None)) {
        reporter.warn(Code::Nothing, "", "no node of the scene has a mesh with triangles: there is nothing to see");
    }
    let sky = match nodes::chosen_scene(&document.root, &options.gltf)? {
        Some(scene) if options.view.environment.is_none() => {
            extensions::ext_lights_image_based::of_scene((session, reporter), &document, scene)?
        }
        _ => None,
    };
    let is_dark = sky.is_none() && !rows.iter().any(|row| row.light.is_some());
    let mut scene = Scene { settings: world::Settings(settings()), background: world::Background::default(), rows };
    if let Some(sky) = sky {
        scene.background.0 = parts::Background::Environment(sky);
        scene.settings.0.backdrop = parts::Backdrop::Other(view::PAPER);
        reporter.note(Code::Decision, "", "the scene's image-based light is not seen behind things, but gray paper");
    }
    if is_dark && options.view.environment.is_none() {
        let Some(studio) = view::studio(session, View::PLAIN) else { return Ok(None) };
        scene.background.0 = studio;
        scene.settings.0.backdrop = parts::Backdrop::Other(view::PAPER);
        reporter.note(Code::Decision, "", "the file has no lights: a studio lights it");
    } else if !is_dark && scene.background.0.is_black() && options.view.environment.is_none() {
        let message = "the file's lights alone light it; `--environment studio` adds a studio";
        reporter.note(Code::Decision, "", message);
    }
    Ok(view::apply(session, &mut scene, &options.view, span).map(|()| scene))
}

/// The entities of a file that a scene asks for at `span`, or of the node of a name with all below it, materials before those that
/// wear them. `None` after an error.
pub(crate) fn part(
    session: &mut Session,
    asset: &Asset,
    choices: &GltfChoices,
    node: Option<(&str, Span)>,
    span: Span,
) -> Option<Vec<Row>> {
    let mut reporter = Reporter::new(asset.name.as_str());
    let rows = read_part((session, &mut reporter), asset, choices, node, span);
    reporter.finish(&mut session.found);
    match rows {
        Ok(rows) => rows,
        Err(error) => {
            let error = error.in_file(asset.name.as_str());
            session.found.push(error.note(format!("read for {}", session.sources.describe(span))));
            None
        }
    }
}

fn read_part(
    (session, reporter): (&mut Session, &mut Reporter),
    asset: &Asset,
    choices: &GltfChoices,
    node: Option<(&str, Span)>,
    span: Span,
) -> Found<Option<Vec<Row>>> {
    let folder = asset.path.parent().unwrap_or(Path::new("/"));
    let mut document = Document::open(session, reporter, &asset.bytes, folder)?;
    animations::pose(&mut document, reporter, choices)?;
    let part = match node {
        None => None,
        Some((name, span)) => {
            let names = || document.root.nodes.iter().map(|node| node.name.as_deref());
            let Some(found) = names().position(|known| known == Some(name)) else {
                let error = session.sources.error(Code::UnknownName, span, format!("the file has no node {name:?}"));
                let error =
                    if names().flatten().next().is_none() { error.help("its nodes have no names") } else { error };
                session.found.push(error.nearest_name(name, names().flatten()));
                return Ok(None);
            };
            Some(found)
        }
    };
    nodes::read((session, reporter), &document, choices, span, part).map(Some)
}

/// The settings of files that have none. Grain is hardly seen at this noise, and two cores get there within a minute.
fn settings() -> parts::Settings {
    parts::Settings {
        integrator: parts::Integrator::Path,
        max_depth: 12,
        samples: 256,
        noise_threshold: Some(0.015),
        tone_mapping: parts::ToneMapping::PbrNeutral,
        ..Default::default()
    }
}

/// The row of a list that a name or a number means.
fn choose<'n>(chosen: &str, names: impl Iterator<Item = Option<&'n str>>, what: &str) -> Found<usize> {
    let names: Vec<Option<&str>> = names.collect();
    let by_name = names.iter().position(|name| *name == Some(chosen));
    let by_number = || chosen.parse::<usize>().ok().filter(|&number| number < names.len());
    by_name.or_else(by_number).ok_or_else(|| {
        let problem = broken("", format!("the file has no {what} {chosen:?}"));
        let numbers = match names.len() {
            0 => format!("the file has no {what} at all"),
            1 => "its name, or 0".to_owned(),
            count => format!("a name, or a number from 0 to {}", count - 1),
        };
        Box::new(problem.expected(numbers).nearest_name(chosen, names.into_iter().flatten()))
    })
}
