//! `brewster check`: what is wrong with a scene.

use brewster::film::PixelOrder;
use brewster::import::{Diagnostic, Severity};
use brewster::wavefront::{Policy, Renderer};
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
    diagnostics: Vec<Finding>,
}

/// A diagnostic about the scene's text, or a problem that shows only in the scene as a whole.
#[derive(Debug, Serialize)]
#[serde(untagged)]
enum Finding {
    Text(Diagnostic),
    Whole { severity: Severity, code: &'static str, message: String, file: String, line: u32, column: u32 },
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let mut session = arguments.scene.session(SettingsChoices::default())?;
    let progress = Terminal::new(false).begin("check");
    let diagnostics = findings(&mut session);
    drop(progress);
    let count = |severity| diagnostics.iter().filter(|finding| finding.severity() == severity).count();
    let (errors, warnings) = (count(Severity::Error), count(Severity::Warning));
    let text = match arguments.format {
        TextFormat::Json => {
            let findings = Findings { version: 1, errors, warnings, diagnostics };
            serde_json::to_string_pretty(&findings).map_err(Failure::input)?
        }
        TextFormat::Text => {
            let [errors, warnings] = [(errors, "error"), (warnings, "warning")].map(|(n, noun)| plural(n as u64, noun));
            let summary = format!("{}: {errors}, {warnings}", session.path().display());
            diagnostics.iter().map(Finding::text).chain([summary]).collect::<Vec<_>>().join("\n")
        }
    };
    print(text + "\n")?;
    if errors == 0 { Ok(()) } else { Err(Failure::Told) }
}

/// Everything that loading, flattening and making ready to render have to say.
fn findings(session: &mut Session) -> Vec<Finding> {
    let file = session.path().display().to_string();
    let problem = |code, message| {
        let (severity, file) = (Severity::Error, file.clone());
        Finding::Whole { severity, code, message, file, line: 0, column: 0 }
    };
    if let Err(error) = session.load() {
        return match error {
            SessionError::Import(failure) => failure.diagnostics.into_iter().map(Finding::Text).collect(),
            other => vec![problem("load", other.to_string())],
        };
    }
    let mut found: Vec<_> = session.warnings().iter().cloned().map(Finding::Text).collect();
    if let Err(error) = session.flatten() {
        match error {
            SessionError::Invalid(invalid) => {
                found.extend(invalid.iter().map(|invalid| problem("invalid-entity", invalid.to_string())));
            }
            other => found.push(problem("invalid-entity", other.to_string())),
        }
    }
    let buffers = session.buffers();
    let [width, height] = buffers.settings.resolution.to_array();
    found.extend(PixelOrder::new(width, height, None).err().map(|error| problem("unsupported", error.to_string())));
    for (number, camera) in buffers.cameras.iter().enumerate() {
        if let Err(error) = Renderer::new(buffers, number, 1, Policy::default(), false) {
            let name = if camera.name.is_empty() { String::new() } else { format!(" {:?}", camera.name) };
            found.push(problem("unsupported", format!("camera{name}: {error}")));
        }
    }
    found
}

impl Finding {
    fn severity(&self) -> Severity {
        match self {
            Finding::Text(diagnostic) => diagnostic.severity,
            Finding::Whole { severity, .. } => *severity,
        }
    }

    fn text(&self) -> String {
        match self {
            Finding::Text(diagnostic) => diagnostic.to_string(),
            Finding::Whole { severity, code, message, file, .. } => {
                format!("{severity}[{code}]: {message}\n--> {file}\n")
            }
        }
    }
}
