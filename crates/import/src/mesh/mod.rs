//! Mesh files to triangles: [`obj`] and [`ply`] read, what they have in common is here.

mod obj;
pub(crate) mod ply;

use std::path::Path;
use std::sync::Arc;

use brewster_world::components::parts::TriangleMesh;
use glam::Vec3;

use crate::diagnostics::{Code, Diagnostic, Severity};
use crate::limits::Exceeded;
use crate::session::{Asset, Budgets, Session};
use crate::source::Span;

/// Why a mesh file cannot be used, and where in it.
#[derive(Debug)]
struct Problem {
    code: Code,
    /// Bytes in the file; none where no place can be told.
    place: Option<(u32, u32)>,
    message: String,
    expected: Option<&'static str>,
}

impl Problem {
    fn new(place: Option<(u32, u32)>, message: impl Into<String>) -> Problem {
        Problem { code: Code::Mesh, place, message: message.into(), expected: None }
    }

    fn exceeded(place: Option<(u32, u32)>, what: &str, exceeded: Exceeded) -> Problem {
        Problem { code: Code::Limit, ..Problem::new(place, format!("the mesh has too many {what}: {exceeded}")) }
    }
}

/// The mesh in a file that is named at `span`.
pub(crate) fn load(session: &mut Session, name: &str, span: Span) -> Option<Arc<TriangleMesh>> {
    let read = match Path::new(name).extension().map(|extension| extension.to_string_lossy().to_lowercase()).as_deref()
    {
        Some("obj") => obj::read,
        Some("ply") => ply::read,
        _ => {
            let error = session.sources.error(Code::Mesh, span, format!("{name:?} is no mesh file"));
            session.found.push(error.expected("a file whose name ends in .obj or .ply"));
            return None;
        }
    };
    let asset = session.read_asset(name, span)?;
    if let Some((digest, mesh)) = session.assets.meshes.get(&asset.path)
        && *digest == asset.digest
    {
        let mesh = Arc::clone(mesh);
        let taken = take(&mut session.budgets, mesh.positions.len(), mesh.triangles.len());
        return match taken {
            Ok(()) => {
                check(session, &mesh, span);
                Some(mesh)
            }
            Err(problem) => {
                report(session, &asset, span, problem);
                None
            }
        };
    }
    match read(&asset.bytes, &mut session.budgets) {
        Ok(mesh) if !check(session, &mesh, span) => None,
        Ok(mesh) => {
            let mesh = Arc::new(mesh);
            session.assets.meshes.insert(asset.path, (asset.digest, Arc::clone(&mesh)));
            Some(mesh)
        }
        Err(problem) => {
            report(session, &asset, span, problem);
            None
        }
    }
}

/// Takes a mesh's vertices and triangles from what a scene may have.
fn take(budgets: &mut Budgets, vertices: usize, triangles: usize) -> Result<(), Problem> {
    budgets.vertices.take(vertices as u64).map_err(|over| Problem::exceeded(None, "vertices", over))?;
    budgets.triangles.take(triangles as u64).map_err(|over| Problem::exceeded(None, "triangles", over))
}

/// Reports a problem in the mesh file, and where the scene asks for it.
fn report(session: &mut Session, asset: &Asset, span: Span, problem: Problem) {
    let text = String::from_utf8_lossy(&asset.bytes);
    let diagnostic = match problem.place {
        Some(place) => Diagnostic::about_text(Severity::Error, problem.code, &asset.name, &text, place),
        None => Diagnostic::about_file(Severity::Error, problem.code, asset.name.as_str(), ""),
    };
    let diagnostic = diagnostic.message(problem.message).note(format!("read for {}", session.sources.describe(span)));
    session.found.push(match problem.expected {
        Some(expected) => diagnostic.expected(expected),
        None => diagnostic,
    });
}

/// Whether a mesh can be used; reports what is wrong with it and what looks wrong.
pub(crate) fn check(session: &mut Session, mesh: &TriangleMesh, span: Span) -> bool {
    if let Err(error) = mesh.validate() {
        session.error(Code::Mesh, span, error.to_string());
        return false;
    }
    let degenerate = mesh.degenerate_triangles();
    if let Some(first) = degenerate.first() {
        let message = format!("{} without area, the first is triangle {first}", count(degenerate.len(), "triangle"));
        session.found.push(session.sources.warning(Code::Degenerate, span, message).help("no ray hits them"));
    }
    let off = |normal: &Vec3| (normal.length_squared() - 1.0).abs() > 1e-3;
    let crooked = mesh.normals.iter().filter(|normal| off(normal)).count();
    if let Some(first) = mesh.normals.iter().position(off) {
        let length = mesh.normals[first].length();
        let message =
            format!("{} not of unit length, the first is that of vertex {first}: {length}", count(crooked, "normal"));
        session.found.push(session.sources.warning(Code::Normal, span, message).help("only their directions count"));
    }
    true
}

fn count(number: usize, noun: &str) -> String {
    if number == 1 { format!("one {noun}") } else { format!("{number} {noun}s") }
}
