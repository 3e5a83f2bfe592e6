//! Files to entities.
//!
//! [`load_scene`] reads a scene in RON, with everything that it refers to, and gives a [`Scene`]: the list of entities to be.
//! [`Scene::apply`] makes a world hold them; applied to a world that holds an earlier state of the scene it writes only what
//! is another now. What the author should know comes as [`Diagnostic`]s, each with file, line, column, the offending text and
//! the nearest valid name. The format is described in this crate's `README.md`.
//!
//! ```
//! use bevy_ecs::world::World;
//! use brewster_import::{Importer, LoadOptions};
//! use brewster_world::components::Shape;
//!
//! let mut importer = Importer::new(LoadOptions::default());
//! let text = r#"Scene(
//!     camera: Perspective(eye: (0, 0, 5)),
//!     materials: { "gold": Metal(of: "Au") },
//!     entities: [
//!         (shape: Sphere(), material: "gold"),
//!         (light: Point(intensity: 40), at: (3, 4, 5)),
//!     ],
//! )"#;
//! let loaded = importer.load_text("ball.ron".as_ref(), text).expect("the scene is right");
//! let mut world = World::new();
//! loaded.scene.apply(&mut world);
//! assert_eq!(world.query::<&Shape>().iter(&world).count(), 1);
//!
//! let failure = importer.load_text("ball.ron".as_ref(), &text.replace("\"gold\"),", "\"golf\"),")).unwrap_err();
//! assert_eq!(failure.diagnostics[0].help.as_deref(), Some("did you mean \"gold\"?"));
//!
//! // An edit touches what it changes and nothing else.
//! let loaded = importer.load_text("ball.ron".as_ref(), &text.replace("40", "60")).expect("the scene is right");
//! assert_eq!(loaded.scene.apply(&mut world).changed, 1);
//! ```

mod diagnostics;
mod environment;
mod export;
mod findings;
mod gltf;
mod hash;
mod image;
mod keys;
mod limits;
pub mod manual;
mod mesh;
mod places;
mod ron;
mod sandbox;
mod scene;
mod session;
mod source;
pub mod study;
mod view;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use brewster_world::components::parts::Integrator;
use glam::UVec2;

pub use diagnostics::{Code, Diagnostic, Excerpt, Severity};
pub use export::Exported;
pub use gltf::GltfChoices;
pub use limits::Limits;
pub use places::Places;
pub use scene::{Applied, Imported, Scene};
pub use view::{EnvironmentChoice, ViewChoices};

use session::{Assets, Session};

/// How scenes are read.
#[derive(Clone, Debug, Default)]
pub struct LoadOptions {
    /// Folders beside the scene's own that files may be read from.
    pub allow_paths: Vec<PathBuf>,
    /// Paths and values that take the place of what the scene file says, such as `materials.glass.ior` and `1.33`.
    pub overrides: Vec<(String, String)>,
    /// The integrator that takes the place of the scene's; what it does not render is an error.
    pub integrator: Option<Integrator>,
    /// The size of the picture that takes the place of the scene's: some of glTF's cameras depend on it.
    pub resolution: Option<UVec2>,
    /// What is taken of a glTF file.
    pub gltf: GltfChoices,
    /// What takes the place of a scene's cameras and surroundings.
    pub view: ViewChoices,
    /// How large a scene may be.
    pub limits: Limits,
}

/// A scene that was read.
#[derive(Debug)]
pub struct Loaded {
    /// What its entities are to be.
    pub scene: Scene,
    /// Where they stand in the scene's files.
    pub places: Places,
    /// Warnings, and notes on what was made of the file.
    pub diagnostics: Vec<Diagnostic>,
    /// The files that were read, the scene's own first: when one changes, the scene may.
    pub dependencies: Vec<PathBuf>,
    /// A hash of these files' contents and of the overrides.
    pub hash: u64,
}

/// A scene that could not be read.
#[derive(Debug)]
pub struct Failure {
    /// Errors, and warnings beside them.
    pub diagnostics: Vec<Diagnostic>,
    /// The files that were asked for, whether they could be read or not: when one changes, the scene may be whole again.
    pub dependencies: Vec<PathBuf>,
}

impl std::fmt::Display for Failure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.diagnostics.iter().try_for_each(|diagnostic| writeln!(f, "{diagnostic}"))
    }
}

impl std::error::Error for Failure {}

/// Reads a scene once. To read it again after an edit, keep an [`Importer`].
pub fn load_scene(path: &Path, options: &LoadOptions) -> Result<Loaded, Failure> {
    Importer::new(options.clone()).load(path)
}

/// Reads scenes and remembers pictures and meshes: a file that did not change is not decoded again, and the mesh it holds is
/// the same one in memory.
#[derive(Debug, Default)]
pub struct Importer {
    options: LoadOptions,
    assets: Assets,
}

impl Importer {
    /// An importer that remembers nothing yet.
    pub fn new(options: LoadOptions) -> Importer {
        Importer { options, assets: Assets::default() }
    }

    /// Chooses another moment of a glTF file's animation: the next load writes what is elsewhere then.
    pub fn set_time(&mut self, time: f32) {
        self.options.gltf.time = Some(time);
    }

    /// Reads the scene in a file: glTF if the name ends so, otherwise RON.
    pub fn load(&mut self, path: &Path) -> Result<Loaded, Failure> {
        self.load_with(path, |session, options| match gltf::is_gltf(path) {
            true => gltf::load(session, path, options),
            false => {
                let source = session.read_scene(path)?;
                Importer::load_ron(session, source, path, options)
            }
        })
    }

    /// Reads a scene in RON whose file would stand at `path` and say `text`: an editor's buffer, or a scene made by a program.
    pub fn load_text(&mut self, path: &Path, text: &str) -> Result<Loaded, Failure> {
        self.load_with(path, |session, options| {
            let source = session.add_scene(path, text.as_bytes().to_vec())?;
            Importer::load_ron(session, source, path, options)
        })
    }

    /// Reads a glTF file, binary or JSON, that would stand at `path` and hold `bytes`: one made by a program.
    pub fn load_gltf(&mut self, path: &Path, bytes: &[u8]) -> Result<Loaded, Failure> {
        self.load_with(path, |session, options| {
            session.digest.update(bytes);
            gltf::load_bytes(session, path, bytes, options)
        })
    }

    fn load_ron(session: &mut Session, source: source::SourceId, path: &Path, options: &LoadOptions) -> Option<Scene> {
        if let Some(choice) = options.gltf.first() {
            let name = session.sources.get(source).name.clone();
            let message = format!("{choice} chooses from a glTF file, and this is a scene in RON");
            let error = Diagnostic::about_file(Severity::Error, Code::Conflict, name, message);
            session.found.push(error.help("for a file within the scene, `shape: Gltf(…)` says what is chosen"));
            return None;
        }
        let mut scene = ron::load(session, source, path, &options.overrides, options.integrator)?;
        if options.view != ViewChoices::default() {
            view::apply(session, &mut scene, &options.view, source::Span { source, start: 0, end: 0 })?;
        }
        Some(scene)
    }

    fn load_with(
        &mut self,
        path: &Path,
        read: impl FnOnce(&mut Session, &LoadOptions) -> Option<Scene>,
    ) -> Result<Loaded, Failure> {
        let options = &self.options;
        let mut session = Session::new(path, &options.allow_paths, options.limits, &mut self.assets);
        session.resolution = options.resolution;
        let scene = read(&mut session, options);
        session.digest.update(format!("{:?}{:?}", options.view, options.gltf).as_bytes());
        let models = std::mem::take(&mut session.models);
        // Pictures that nobody else holds will not be asked for again.
        let pyramids = &session.assets.pyramids;
        let levels = |image| [true, false].iter().filter(|&&srgb| pyramids.contains_key(&(image, srgb))).count();
        session.assets.pictures.retain(|_, image| Arc::strong_count(image) > 1 + levels(Arc::as_ptr(image)));
        session.assets.pyramids.retain(|_, (image, _)| Arc::strong_count(image) > 1);
        session.assets.primitives.retain(|known, _| models.contains(&known.0));
        let (dependencies, hash) = (session.dependencies, session.digest.finish());
        let diagnostics = session.found.finish();
        match scene {
            Some(scene) => {
                let places = Places::new(&scene.rows, session.sources);
                Ok(Loaded { scene, places, diagnostics, dependencies, hash })
            }
            None => Err(Failure { diagnostics, dependencies }),
        }
    }
}
