//! The arguments that name a scene and say how it is read: those of every command that takes one.

use std::path::PathBuf;

use brewster::buffers::Backdrop;
use brewster::import::{EnvironmentChoice, GltfChoices, LoadOptions, Severity, ViewChoices};
use brewster::{Session, SessionOptions, SettingsChoices};
use clap::Args;
use glam::Vec3;

use super::{Failure, values};
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
    /// The scene of a glTF file, by name or number.
    #[arg(long = "scene", value_name = "NAME", help_heading = GLTF)]
    pub gltf_scene: Option<String>,
    /// The variant of a glTF file's materials, by name or number.
    #[arg(long, value_name = "NAME", help_heading = GLTF)]
    pub variant: Option<String>,
    /// The moment of a glTF file's animation, in seconds.
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true, value_parser = values::finite, help_heading = GLTF)]
    pub time: Option<f32>,
    /// How long the shutter is open from that moment on, in seconds: nodes that move meanwhile are blurred.
    #[arg(long, value_name = "SECONDS", value_parser = values::above_zero, help_heading = GLTF)]
    pub shutter: Option<f32>,
    /// The animation, by name or number, or `all`; without it, the first.
    #[arg(long, value_name = "NAME", help_heading = GLTF)]
    pub animation: Option<String>,
    #[command(flatten)]
    pub view: ViewArguments,
}

const GLTF: &str = "What of a glTF file";

const VIEW: &str = "View";

/// What takes the place of the scene's cameras and surroundings.
#[derive(Debug, Args)]
pub(crate) struct ViewArguments {
    /// Where the camera is.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = values::vector, conflicts_with = "orbit", help_heading = VIEW)]
    pub eye: Option<Vec3>,
    /// A point in the middle of the picture; without it, the middle of the scene.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = values::vector, help_heading = VIEW)]
    pub target: Option<Vec3>,
    /// A direction that points up in the picture; without it, +Y.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = values::vector, help_heading = VIEW)]
    pub up: Option<Vec3>,
    /// The full vertical angle of view in degrees.
    #[arg(long, value_name = "DEGREES", value_parser = values::angle_of_view, help_heading = VIEW)]
    pub vfov: Option<f32>,
    /// Where the camera is about its target: degrees from +Z toward +X, degrees from +Y, and meters.
    #[arg(long, value_name = "THETA,PHI,RADIUS", allow_hyphen_values = true, value_parser = values::vector, help_heading = VIEW)]
    pub orbit: Option<Vec3>,
    /// A picture of the whole sky that takes the place of the scene's background, or `studio`, which lights glTF files without lights.
    #[arg(long, value_name = "FILE.hdr", help_heading = VIEW)]
    pub environment: Option<PathBuf>,
    /// By how much it is turned about +Y.
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true, value_parser = values::finite, requires = "environment", help_heading = VIEW)]
    pub environment_rotation: Option<f32>,
    /// A factor of its light.
    #[arg(long, value_name = "FACTOR", value_parser = values::above_zero, requires = "environment", help_heading = VIEW)]
    pub environment_strength: Option<f32>,
    /// What is behind the things in the picture: `transparent`, `environment`, #rrggbb, or linear red,green,blue.
    #[arg(long, value_name = "WHAT", value_parser = values::backdrop, help_heading = VIEW)]
    pub background: Option<Backdrop>,
}

impl ViewArguments {
    fn choices(&self) -> ViewChoices {
        let environment = self.environment.clone().map(|file| EnvironmentChoice {
            file: Some(file).filter(|file| file.as_os_str() != "studio"),
            rotation: self.environment_rotation.unwrap_or(0.0).to_radians(),
            strength: self.environment_strength.unwrap_or(1.0),
        });
        ViewChoices {
            eye: self.eye,
            target: self.target,
            up: self.up,
            vfov: self.vfov.map(f32::to_radians),
            orbit: self.orbit.map(|orbit| [orbit.x.to_radians(), orbit.y.to_radians(), orbit.z]),
            environment,
            backdrop: self.background.clone(),
        }
    }
}

impl SceneArguments {
    /// A session with the scene, which is not read yet.
    pub(crate) fn session(&self, settings: SettingsChoices) -> Result<Session, Failure> {
        if let Some(folder) = self.allow_path.iter().find(|folder| !folder.is_dir()) {
            return Err(Failure::Usage(format!("{}: expected a folder", folder.display())));
        }
        Ok(Session::new(&self.scene, SessionOptions { load: self.options(), settings }))
    }

    /// How the scene is read.
    pub(crate) fn options(&self) -> LoadOptions {
        LoadOptions {
            allow_paths: self.allow_path.clone(),
            overrides: self.set.clone(),
            gltf: GltfChoices {
                scene: self.gltf_scene.clone(),
                variant: self.variant.clone(),
                animation: self.animation.clone(),
                time: self.time,
                shutter: self.shutter,
            },
            view: self.view.choices(),
            ..LoadOptions::default()
        }
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
