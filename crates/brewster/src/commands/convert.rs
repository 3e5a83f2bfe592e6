//! `brewster convert`: a glTF file as a scene that can be edited.

use std::io::Write;
use std::path::{Path, PathBuf};

use brewster::film::{FilmError, write_atomically};
use brewster::import::{Severity, load_scene};
use clap::Args;

use super::Failure;
use super::scene::SceneArguments;
use crate::terminal::{Terminal, complain};

/// Writes a glTF file as a scene in RON, beside its meshes and pictures.
///
/// OUT.ron is the scene, and the folder OUT beside it takes meshes as PLY and pictures as PNG, each as it is in memory: skins,
/// morph targets and animations as they stand at the moment that is chosen. What RON has no words for is told.
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,
    /// The scene to be written.
    #[arg(value_name = "OUT.ron")]
    output: PathBuf,
    /// Replace files that are there already.
    #[arg(long)]
    force: bool,
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Arguments { scene, output, .. } = arguments;
    let stem = output.file_stem().map(|stem| stem.to_string_lossy().into_owned());
    let (Some(stem), Some("ron")) = (stem, output.extension().and_then(|ending| ending.to_str())) else {
        return Err(Failure::Usage(format!("{}: expected a name that ends in .ron", output.display())));
    };
    let is_gltf = scene
        .scene
        .extension()
        .is_some_and(|ending| ["gltf", "glb"].into_iter().any(|known| ending.eq_ignore_ascii_case(known)));
    if !is_gltf {
        return Err(Failure::Usage(format!("{}: expected a name that ends in .gltf or .glb", scene.scene.display())));
    }
    let progress = Terminal::new(false).begin("load");
    let loaded =
        load_scene(&scene.scene, &scene.options()).map_err(|failure| Failure::Diagnostics(failure.to_string()))?;
    drop(progress);
    for warning in loaded.diagnostics.iter().filter(|said| said.severity == Severity::Warning) {
        complain(warning);
    }
    let exported = loaded.scene.export(&stem);
    let folder = output.parent().unwrap_or(Path::new(""));
    let mut written = exported.files.iter().map(|(name, _)| folder.join(name)).chain([output.clone()]);
    if let Some(path) = written.find(|path| !arguments.force && path.exists()) {
        return Err(Failure::Input(format!("{}: there is such a file already; --force replaces it", path.display())));
    }
    if !exported.files.is_empty() {
        let folder = folder.join(&stem);
        let failed = |error| Failure::Input(format!("{}: {error}", folder.display()));
        std::fs::create_dir_all(&folder).map_err(failed)?;
    }
    for (name, bytes) in &exported.files {
        write(&folder.join(name), bytes)?;
    }
    let from = scene.scene.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let lost: String = exported.lost.iter().map(|what| format!("// Not in it: {what}.\n")).collect();
    write(output, format!("// Converted from {from}.\n{lost}{}", exported.text).as_bytes())?;
    for what in &exported.lost {
        complain(format_args!("not converted: {what}"));
    }
    Ok(())
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    let failed = |source| FilmError::Io { path: path.to_path_buf(), source };
    Ok(write_atomically(path, |file| file.write_all(bytes).map_err(failed))?)
}
