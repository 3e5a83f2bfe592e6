//! `brewster check`: what is wrong with a scene.

use brewster::import::{Code, Diagnostic, Severity};
use brewster::wavefront::{Policy, Renderer};
use brewster::world::components::SceneKey;
use brewster::{Session, SessionError, SettingsChoices};
use clap::{Args, ValueEnum};
use serde::Serialize;

use super::scene::SceneArguments;
use super::{Failure, print};
use crate::terminal::{Terminal, plural};

/// Tells what is wrong with a scene, without rendering it.
///
/// Errors make the exit code 1, warnings do not.
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,
    /// How it is told: for a person, or as JSON for an editor.
    #[arg(long, value_enum, default_value_t = TextFormat::Text)]
    format: TextFormat,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum TextFormat {
    Text,
    Json,
}

/// What `--format json` prints.
#[derive(Debug, Serialize)]
struct Findings {
    version: u32,
    errors: usize,
    warnings: usize,
    diagnostics: Vec<Diagnostic>,
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let mut session = arguments.scene.session(SettingsChoices::default())?;
    let progress = Terminal::new(false).begin("check");
    let diagnostics = findings(&mut session)?;
    drop(progress);
    let count = |severity| diagnostics.iter().filter(|finding| finding.severity == severity).count();
    let (errors, warnings) = (count(Severity::Error), count(Severity::Warning));
    let text = match arguments.format {
        TextFormat::Json => {
            let findings = Findings { version: 1, errors, warnings, diagnostics };
            serde_json::to_string_pretty(&findings).map_err(Failure::input)?
        }
        TextFormat::Text => {
            let [errors, warnings] = [(errors, "error"), (warnings, "warning")].map(|(n, noun)| plural(n as u64, noun));
            let summary = format!("{}: {errors}, {warnings}", session.path().display());
            diagnostics.iter().map(Diagnostic::to_string).chain([summary]).collect::<Vec<_>>().join("\n")
        }
    };
    print(text + "\n")?;
    if errors == 0 { Ok(()) } else { Err(Failure::Told) }
}

/// Everything that loading, flattening and making ready to render have to say.
fn findings(session: &mut Session) -> Result<Vec<Diagnostic>, Failure> {
    match session.load() {
        Err(SessionError::Import(failure)) => return Ok(failure.diagnostics),
        loaded => drop(loaded?),
    }
    let mut found = session.warnings().to_vec();
    match session.flatten() {
        Err(SessionError::Invalid(invalid)) => found.extend(invalid),
        flattened => drop(flattened?),
    }
    let buffers = session.buffers();
    for (number, camera) in buffers.cameras.iter().enumerate() {
        if let Err(error) = Renderer::new(buffers, number, 1, Policy::default(), false) {
            found.push(session.places().error(SceneKey(camera.key), Code::Integrator, error.to_string()));
        }
    }
    Ok(found)
}
