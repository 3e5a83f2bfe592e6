//! The arguments that name a scene and say how it is read: those of every command that takes one.

use std::path::PathBuf;

use brewster::import::{LoadOptions, Severity};
use brewster::{Session, SessionOptions, SettingsChoices};
use clap::Args;

use super::Failure;
use crate::terminal::Terminal;

/// A scene and how it is read.
#[derive(Debug, Args)]
pub(crate) struct SceneArguments {
    /// The scene file.
    #[arg(value_name = "SCENE")]
    pub scene: PathBuf,
    /// Put a value in the place of the scene file's, such as materials.glass.ior=1.33; may be given several times.
    #[arg(long, value_name = "PATH=VALUE", value_parser = assignment)]
    pub set: Vec<(String, String)>,
    /// A folder beside the scene's own that it may read from; may be given several times.
    #[arg(long, value_name = "DIR")]
    pub allow_path: Vec<PathBuf>,
}

impl SceneArguments {
    /// A session with the scene, which is not read yet.
    pub(crate) fn session(&self, settings: SettingsChoices) -> Result<Session, Failure> {
        if let Some(folder) = self.allow_path.iter().find(|folder| !folder.is_dir()) {
            return Err(Failure::Usage(format!("{}: expected a folder", folder.display())));
        }
        let load =
            LoadOptions { allow_paths: self.allow_path.clone(), overrides: self.set.clone(), ..LoadOptions::default() };
        Ok(Session::new(&self.scene, SessionOptions { load, settings }))
    }
}

/// Says what the last load warned of; the number of warnings.
pub(crate) fn say_warnings(session: &Session, terminal: Terminal) -> usize {
    let warnings = session.warnings().iter().filter(|diagnostic| diagnostic.severity == Severity::Warning);
    warnings.map(|warning| terminal.say(warning)).count()
}

fn assignment(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((path, value)) if !path.trim().is_empty() && !value.trim().is_empty() => {
            Ok((path.trim().to_owned(), value.to_owned()))
        }
        _ => Err("expected PATH=VALUE, such as materials.glass.ior=1.33".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn assignments_split_at_the_first_sign() {
        let expected = ("entities.a.at".to_owned(), "(0, 1, 0)".to_owned());
        assert_eq!(assignment("entities.a.at=(0, 1, 0)"), Ok(expected));
        assert_eq!(assignment("a=\"x=y\"").unwrap().1, "\"x=y\"");
        for wrong in ["", "a", "=1", "a=", " = "] {
            assert!(assignment(wrong).is_err(), "{wrong}");
        }
    }
}
