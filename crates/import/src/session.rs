//! What one load goes through: files are found, bounded, read and remembered, and what is wrong with them is collected.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use brewster_world::components::parts::{Encoding, EnvironmentMap, Image, Integrator, Pyramid, TriangleMesh};

use glam::UVec2;

use crate::diagnostics::{Code, Diagnostic, Severity, nearest};
use crate::environment::View;
use crate::findings::Findings;
use crate::hash::{self, Digest};
use crate::limits::{Budget, Limits};
use crate::sandbox::{Refusal, Sandbox, read_bounded};
use crate::source::{Source, SourceId, Sources, Span};

/// The state of one load.
pub(crate) struct Session<'i> {
    pub limits: Limits,
    pub sources: Sources,
    pub found: Findings,
    /// Every file that was asked for, in order, whether it could be read or not.
    pub dependencies: Vec<PathBuf>,
    pub digest: Digest,
    pub budgets: Budgets,
    pub assets: &'i mut Assets,
    /// Digests of the glTF files that were read.
    pub models: Vec<u64>,
    /// The size of the picture that is to be taken, if it is known before the scene is.
    pub resolution: Option<UVec2>,
    /// The integrator that is to render the scene.
    pub integrator: Integrator,
    /// What it does not render, with the place.
    pub refused: Vec<(Span, &'static str)>,
    sandbox: Sandbox,
}

/// What pictures and meshes may still take.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Budgets {
    pub pixels: Budget,
    pub vertices: Budget,
    pub triangles: Budget,
}

/// Pictures and meshes that were read before, with the digests of their files: an unchanged file gives the same `Arc`.
#[derive(Debug, Default)]
pub(crate) struct Assets {
    pub images: BTreeMap<PathBuf, (u64, Arc<Image>)>,
    pub meshes: BTreeMap<PathBuf, (u64, Arc<TriangleMesh>)>,
    /// Triangles of the last scene's glTF files, by a file's digest, mesh and primitive.
    pub primitives: BTreeMap<(u64, usize, usize), Arc<TriangleMesh>>,
    /// Pictures of glTF files, by the digests of their bytes.
    pub pictures: BTreeMap<u64, Arc<Image>>,
    /// What is seen of pictures from afar, by where they are in memory and whether they are colors.
    pub pyramids: BTreeMap<(*const Image, bool), Levels>,
    /// The last picture of the sky that was asked for beside the scene, by the digest of its file.
    pub sky_file: Option<(u64, Arc<Image>)>,
    /// The studio that lights files without light.
    pub studio: Option<Arc<Image>>,
    /// The last map of the sky, and what it was made of.
    pub sky: Option<(Arc<Image>, View, Arc<EnvironmentMap>)>,
}

impl Assets {
    /// The levels of a picture, made once.
    pub(crate) fn pyramid(&mut self, image: &Arc<Image>, encoding: Encoding) -> Arc<Pyramid> {
        let key = (Arc::as_ptr(image), encoding == Encoding::Srgb);
        let make = || (Arc::clone(image), Arc::new(Pyramid::new(image, encoding)));
        Arc::clone(&self.pyramids.entry(key).or_insert_with(make).1)
    }
}

/// A picture, which stays in memory as long, and what is seen of it from afar.
pub(crate) type Levels = (Arc<Image>, Arc<Pyramid>);

/// A file that a scene refers to.
pub(crate) struct Asset {
    /// Canonical.
    pub path: PathBuf,
    /// What a message calls it.
    pub name: String,
    pub bytes: Vec<u8>,
    pub digest: u64,
}

impl<'i> Session<'i> {
    pub(crate) fn new(scene: &Path, allowed: &[PathBuf], limits: Limits, assets: &'i mut Assets) -> Session<'i> {
        let budgets = Budgets {
            pixels: Budget::new("image_pixels", limits.image_pixels),
            vertices: Budget::new("vertices", limits.vertices),
            triangles: Budget::new("triangles", limits.triangles),
        };
        Session {
            limits,
            sources: Sources::new(&limits),
            found: Findings::new(&limits),
            dependencies: Vec::new(),
            digest: Digest::default(),
            budgets,
            assets,
            models: Vec::new(),
            resolution: None,
            integrator: Integrator::Whitted,
            refused: Vec::new(),
            sandbox: Sandbox::new(scene, allowed),
        }
    }

    /// Reads the scene file itself.
    pub(crate) fn read_scene(&mut self, path: &Path) -> Option<SourceId> {
        self.depend(path);
        match read_bounded(path, "scene_bytes", self.limits.scene_bytes) {
            Ok(bytes) => self.add_scene(path, bytes),
            Err(refusal) => {
                let (code, message) = describe(&refusal);
                let name = path.to_string_lossy();
                let message = format!("cannot read the file: {message}");
                self.found.push(Diagnostic::about_file(Severity::Error, code, name, message));
                None
            }
        }
    }

    /// Reads a glTF file.
    pub(crate) fn read_gltf(&mut self, path: &Path) -> Option<Vec<u8>> {
        self.depend(path);
        match read_bounded(path, "asset_bytes", self.limits.asset_bytes) {
            Ok(bytes) => {
                self.digest.update(&bytes);
                Some(bytes)
            }
            Err(refusal) => {
                let (code, message) = describe(&refusal);
                let message = format!("cannot read the file: {message}");
                self.found.push(Diagnostic::about_file(Severity::Error, code, path.to_string_lossy(), message));
                None
            }
        }
    }

    /// Takes a text for the scene file's.
    pub(crate) fn add_scene(&mut self, path: &Path, bytes: Vec<u8>) -> Option<SourceId> {
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let folder = folder.canonicalize().unwrap_or_else(|_| folder.to_path_buf());
        self.add_text(path.to_string_lossy().into_owned(), folder, bytes)
    }

    /// Finds a scene file that another one includes at `span`, without reading it.
    pub(crate) fn find(&mut self, name: &str, span: Span) -> Option<PathBuf> {
        let folder = &self.sources.get(span.source).folder;
        let wanted = folder.join(name);
        match self.sandbox.resolve(folder, Path::new(name)) {
            Ok(path) => {
                self.depend(&path);
                Some(path)
            }
            Err(refusal) => {
                self.depend(&wanted);
                self.refuse(name, span, &refusal);
                None
            }
        }
    }

    /// Reads an included scene file.
    pub(crate) fn read_include(&mut self, path: &Path, name: &str, span: Span) -> Option<SourceId> {
        match read_bounded(path, "scene_bytes", self.limits.scene_bytes) {
            Ok(bytes) => {
                let folder = path.parent().unwrap_or(Path::new("/")).to_path_buf();
                self.add_text(self.sources.name_beside(span.source, name), folder, bytes)
            }
            Err(refusal) => {
                self.refuse(name, span, &refusal);
                None
            }
        }
    }

    /// Reads a picture or a mesh.
    pub(crate) fn read_asset(&mut self, name: &str, span: Span) -> Option<Asset> {
        let path = self.find(name, span)?;
        match read_bounded(&path, "asset_bytes", self.limits.asset_bytes) {
            Ok(bytes) => {
                let digest = self.count_in(&bytes);
                let name = self.sources.name_beside(span.source, name);
                Some(Asset { path, name, bytes, digest })
            }
            Err(refusal) => {
                self.refuse(name, span, &refusal);
                None
            }
        }
    }

    /// Reads a file that another one in `folder` refers to, without a word to the author.
    pub(crate) fn read_beside(&mut self, folder: &Path, name: &str) -> Result<(Vec<u8>, u64), Refusal> {
        let resolved = self.sandbox.resolve(folder, Path::new(name));
        self.depend(resolved.as_deref().unwrap_or(&folder.join(name)));
        let bytes = read_bounded(&resolved?, "asset_bytes", self.limits.asset_bytes)?;
        let digest = self.count_in(&bytes);
        Ok((bytes, digest))
    }

    /// Reads a file that does not come from the scene but from the one who asks for a picture; its digest.
    pub(crate) fn read_outside(&mut self, path: &Path) -> Result<(Vec<u8>, u64), Refusal> {
        self.depend(path);
        let bytes = read_bounded(path, "asset_bytes", self.limits.asset_bytes)?;
        let digest = self.count_in(&bytes);
        Ok((bytes, digest))
    }

    /// Makes a file's bytes count in the scene's digest; their own.
    fn count_in(&mut self, bytes: &[u8]) -> u64 {
        let digest = hash::of(bytes);
        self.digest.update(&digest.to_le_bytes());
        digest
    }

    pub(crate) fn error(&mut self, code: Code, span: Span, message: impl Into<String>) {
        self.found.push(self.sources.error(code, span, message));
    }

    fn add_text(&mut self, name: String, folder: PathBuf, bytes: Vec<u8>) -> Option<SourceId> {
        self.digest.update(&bytes);
        let text = match String::from_utf8(bytes) {
            Ok(text) => text,
            Err(error) => {
                let valid = error.utf8_error().valid_up_to() as u32;
                let text = String::from_utf8_lossy(error.as_bytes());
                let place = Diagnostic::about_text(Severity::Error, Code::File, &name, &text, (valid, valid + 1));
                self.found.push(place.message("the file is not text in UTF-8").help("save it in this encoding"));
                return None;
            }
        };
        let id = self.sources.add(Source { name: name.clone(), folder, text });
        if id.is_none() {
            let message = "a scene is made of at most 65535 files of less than 4 GiB";
            self.found.push(Diagnostic::about_file(Severity::Error, Code::Limit, name, message));
        }
        id
    }

    fn depend(&mut self, path: &Path) {
        if !self.dependencies.iter().any(|known| known == path) {
            self.dependencies.push(path.to_path_buf());
        }
    }

    fn refuse(&mut self, name: &str, span: Span, refusal: &Refusal) {
        let (code, message) = describe(refusal);
        let error = self.sources.error(code, span, format!("cannot read {name:?}: {message}"));
        let error = match refusal {
            Refusal::Outside => error
                .expected("a file in the folder of the scene or below it")
                .help("other folders are allowed by `--allow-path DIR`"),
            Refusal::Io(reason) if reason.kind() == io::ErrorKind::NotFound => {
                match self.neighbor(&self.sources.get(span.source).folder, name) {
                    Some(neighbor) => error.help(format!("did you mean {neighbor:?}?")),
                    None => error,
                }
            }
            _ => error,
        };
        self.found.push(error);
    }

    /// The file with the nearest name in the same folder, if scenes may read there.
    pub(crate) fn neighbor(&self, folder: &Path, name: &str) -> Option<String> {
        let wanted = folder.join(name);
        let folder = wanted.parent()?.canonicalize().ok()?;
        let entries = std::fs::read_dir(&folder).ok()?.take(1000).filter_map(Result::ok);
        let mut names: Vec<String> = entries
            .map(|entry| entry.file_name().to_string_lossy().into_owned())
            .filter(|entry| self.sandbox.resolve(&folder, Path::new(entry)).is_ok())
            .collect();
        names.sort_unstable();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let near = nearest(&wanted.file_name()?.to_string_lossy(), &names)?;
        let beside = Path::new(name).parent().unwrap_or(Path::new("")).join(near);
        Some(beside.to_string_lossy().replace('\\', "/"))
    }
}

/// The kind of a refusal, and the reason in words.
pub(crate) fn describe(refusal: &Refusal) -> (Code, String) {
    match refusal {
        Refusal::Outside => (Code::Sandbox, "it lies outside the folder of the scene".into()),
        Refusal::NotAFile => (Code::File, "it is a folder, or no ordinary file".into()),
        Refusal::TooLarge(exceeded) => (Code::Limit, format!("it is too large: {exceeded}")),
        Refusal::Io(error) => match error.kind() {
            io::ErrorKind::NotFound => (Code::File, "there is no such file".into()),
            io::ErrorKind::PermissionDenied => (Code::File, "it may not be read".into()),
            _ => (Code::File, error.to_string()),
        },
    }
}
