//! Scene files in RON: [`parse`] makes a tree of the text, [`overrides`] change it, [`decode`] makes the types of [`schema`]
//! of the tree, [`content`] looks names up and reads other files, [`spawn`] lists the entities, [`check`] looks them over.

mod check;
mod content;
mod convert;
pub(crate) mod decode;
pub(crate) mod info;
mod models;
mod names;
mod node;
mod overrides;
mod parse;
mod patterns;
pub(crate) mod schema;
mod spawn;
mod values;

use std::path::Path;

use brewster_world::components::parts::Integrator;

use crate::diagnostics::Code;
use crate::scene::Scene;
use crate::session::Session;
use crate::source::SourceId;

use content::Resolver;
pub(crate) use convert::{check_resolution, integrator as convert_integrator};
use decode::{Context, Decode, check_name};
pub(crate) use values::Named;

/// The scene in a source that was read from `path`, or `None` after an error.
pub(crate) fn load(
    session: &mut Session,
    source: SourceId,
    path: &Path,
    overrides: &[(String, String)],
    integrator: Option<Integrator>,
) -> Option<Scene> {
    let name = session.sources.get(source).name.clone();
    let scene = read(session, source, overrides)?;
    if session.resolution.is_none() {
        convert::check_resolution(session, &scene.settings.resolution);
    }
    session.integrator = integrator.unwrap_or(convert::integrator(&scene.settings.integrator));
    let canonical = path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
    let mut resolver = Resolver::new(session, canonical, name.clone());
    let content = resolver.content("", &scene);
    if resolver.session.integrator == Integrator::Path && scene.settings.transparent_shadows.value {
        resolver.session.refused.push((scene.settings.transparent_shadows.span, "transparent shadows"));
    }
    let scene = spawn::spawn(&mut resolver, &scene, &content);
    report_refused(resolver.session);
    let scene = scene?;
    if session.found.errors() == 0 {
        check::check(session, &scene, &name);
    }
    (session.found.errors() == 0).then_some(scene)
}

/// A study file.
pub(crate) fn read_study(session: &mut Session, source: SourceId) -> Option<schema::study::Study> {
    let root = match parse::parse(&session.sources, source, 0, &session.limits) {
        Ok(root) => root,
        Err(error) => {
            session.found.push(*error);
            return None;
        }
    };
    let errors = session.found.errors();
    let mut context = Context::new(&session.sources, &mut session.found);
    check_name(&root, schema::study::Study::INFO, &mut context);
    // What is no study has no fields that would mean anything.
    if context.found.errors() > errors { None } else { schema::study::Study::decode(&root, &mut context) }
}

/// Reports what the integrator does not render, each kind of thing once.
fn report_refused(session: &mut Session) {
    let refused = std::mem::take(&mut session.refused);
    for (at, &(span, what)) in refused.iter().enumerate() {
        if refused[..at].iter().any(|&(_, earlier)| earlier == what) {
            continue;
        }
        let message = format!("the integrator {:?} does not render {what}", session.integrator);
        let others = refused[at + 1..].iter().filter(|&&(_, other)| other == what).count();
        let error = session.sources.error(Code::Integrator, span, message).help(match session.integrator {
            Integrator::Whitted => "`settings: (integrator: Path)` does",
            Integrator::Path => "`settings: (integrator: Whitted)` does",
        });
        session.found.push(if others > 0 { error.note(format!("this is the first of {}", others + 1)) } else { error });
    }
}

/// What a source says, as far as it can be read. Errors are reported; `None` stands for nothing at all.
fn read(session: &mut Session, source: SourceId, overrides: &[(String, String)]) -> Option<schema::Scene> {
    let mut root = match parse::parse(&session.sources, source, 0, &session.limits) {
        Ok(root) => root,
        Err(error) => {
            session.found.push(*error);
            return None;
        }
    };
    overrides::apply(&mut root, overrides, session);
    schema::Scene::decode(&root, &mut Context::new(&session.sources, &mut session.found))
}
