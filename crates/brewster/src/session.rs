//! A session: a scene from its file to its columns, and back again after every edit.

use std::fmt;
use std::path::{Path, PathBuf};

use brewster_buffers::{Integrator, SamplerKind, SceneBuffers, Settings};
use brewster_film::{FilmError, MAX_PIXELS};
use brewster_import::{Applied, Code, Diagnostic, Failure, Importer, Limits, LoadOptions, Loaded, Places};
use brewster_wavefront::Unsupported;
use brewster_wavefront::explain::ExplainError;
use brewster_world::components::SceneKey;
use brewster_world::{FlattenReport, Invalid, Scene};
use glam::UVec2;

use crate::explain::{Explanation, Samples};
use crate::{Render, RenderOptions, Timeline};

/// How a session reads its scene.
#[derive(Clone, Debug, Default)]
pub struct SessionOptions {
    /// Folders, overrides and limits.
    pub load: LoadOptions,
    /// What takes the place of the scene's settings.
    pub settings: SettingsChoices,
}

/// Settings that take the place of the scene's own.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SettingsChoices {
    /// Width and height in pixels.
    pub resolution: Option<UVec2>,
    /// How light is carried.
    pub integrator: Option<Integrator>,
    /// The number of interactions that may scatter on.
    pub max_depth: Option<u32>,
    /// Samples per pixel: so many for each, unless a threshold is given, too.
    pub samples: Option<u32>,
    /// The noise below which blocks of pixels get no more samples, above 0.
    pub noise_threshold: Option<f32>,
    /// What chooses the pattern of samples.
    pub seed: Option<u64>,
    /// Where random numbers come from.
    pub sampler: Option<SamplerKind>,
    /// Interactions before which a dielectric sends both rays.
    pub split_depth: Option<u32>,
    /// Whether diffuse surfaces look for the light that mirrors and glass throw on them.
    pub guiding: Option<bool>,
    /// The largest radiance that one contribution may bring, above 0.
    pub clamp: Option<f32>,
}

impl SettingsChoices {
    fn apply(&self, settings: &mut Settings) {
        let SettingsChoices {
            resolution,
            integrator,
            max_depth,
            samples,
            noise_threshold,
            seed,
            sampler,
            split_depth,
            guiding,
            clamp,
        } = *self;
        settings.resolution = resolution.unwrap_or(settings.resolution);
        settings.integrator = integrator.unwrap_or(settings.integrator);
        settings.max_depth = max_depth.unwrap_or(settings.max_depth);
        if let Some(samples) = samples {
            (settings.samples, settings.noise_threshold) = (samples, None);
        }
        settings.noise_threshold = noise_threshold.or(settings.noise_threshold);
        settings.seed = seed.unwrap_or(settings.seed);
        settings.sampler = sampler.unwrap_or(settings.sampler);
        settings.split_depth = split_depth.unwrap_or(settings.split_depth);
        settings.guiding = guiding.unwrap_or(settings.guiding);
        settings.clamp = clamp.unwrap_or(settings.clamp);
    }
}

/// What no film holds is refused where the scene's file asks for it.
const _: () = assert!(Limits::DEFAULT.picture_pixels == MAX_PIXELS);

/// A scene, from its file to its columns.
///
/// [`Session::load`], [`Session::flatten`], [`Session::render`], in this order; after an edit of the file the same again, at the
/// cost of the edit. A load that fails leaves the scene as it was.
pub struct Session {
    path: PathBuf,
    settings: SettingsChoices,
    importer: Importer,
    scene: Scene,
    places: Places,
    report: FlattenReport,
    warnings: Vec<Diagnostic>,
    dependencies: Vec<PathBuf>,
    hash: u64,
    timeline: Timeline,
}

impl Session {
    /// A session with the scene file at `path`, which is not read yet.
    pub fn new(path: impl Into<PathBuf>, options: SessionOptions) -> Session {
        let path = path.into();
        let SessionOptions { mut load, settings } = options;
        load.integrator = settings.integrator.or(load.integrator);
        load.resolution = settings.resolution.or(load.resolution);
        Session {
            dependencies: vec![path.clone()],
            path,
            settings,
            importer: Importer::new(load),
            scene: Scene::new(),
            places: Places::default(),
            report: FlattenReport::default(),
            warnings: Vec::new(),
            hash: 0,
            timeline: Timeline::default(),
        }
    }

    /// Chooses another moment of a glTF file's animation, in seconds, for the next load.
    pub fn set_time(&mut self, time: f32) {
        self.importer.set_time(time);
    }

    /// Reads the scene file and everything it refers to, and brings the entities up to date.
    ///
    /// # Errors
    ///
    /// The file, or one that it refers to, cannot be used.
    pub fn load(&mut self) -> Result<Applied, SessionError> {
        self.load_with(|importer, path| importer.load(path))
    }

    /// The same with a text in place of the scene file's.
    ///
    /// # Errors
    ///
    /// The text, or a file that it refers to, cannot be used.
    pub fn load_text(&mut self, text: &str) -> Result<Applied, SessionError> {
        self.load_with(|importer, path| importer.load_text(path, text))
    }

    fn load_with(
        &mut self,
        load: impl FnOnce(&mut Importer, &Path) -> Result<Loaded, Failure>,
    ) -> Result<Applied, SessionError> {
        let Session { importer, path, scene, settings, .. } = self;
        let result: Result<_, Failure> = self.timeline.time("load", || {
            let mut loaded = load(importer, path)?;
            settings.apply(&mut loaded.scene.settings.0);
            let applied = loaded.scene.apply(scene.world_mut());
            Ok((loaded, applied))
        });
        match result {
            Ok((loaded, applied)) => {
                self.places = loaded.places;
                self.warnings = loaded.diagnostics;
                self.dependencies = loaded.dependencies;
                self.hash = loaded.hash;
                Ok(applied)
            }
            Err(failure) => {
                self.dependencies.clone_from(&failure.dependencies);
                Err(SessionError::Import(failure))
            }
        }
    }

    /// Brings the columns up to date with the entities.
    ///
    /// # Errors
    ///
    /// Entities that cannot be flattened, with their places in the scene's files; the others are. [`Session::report`] has the entities.
    pub fn flatten(&mut self) -> Result<&FlattenReport, SessionError> {
        self.report = self.timeline.time("flatten", || self.scene.flatten());
        match self.report.invalid.is_empty() {
            true => Ok(&self.report),
            false => {
                Err(SessionError::Invalid(self.report.invalid.iter().map(|invalid| self.located(invalid)).collect()))
            }
        }
    }

    /// What is wrong with an entity, at its place.
    fn located(&self, invalid: &Invalid) -> Diagnostic {
        let key = self.scene.world().get::<SceneKey>(invalid.entity).copied().unwrap_or(SceneKey::UNASSIGNED);
        let message = match (&invalid.name, self.places.describe(key)) {
            (Some(name), _) => format!("{name:?}: {}", invalid.problem),
            (None, Some(_)) => invalid.problem.to_string(),
            (None, None) => invalid.to_string(),
        };
        self.places.error(key, Code::Invalid, message)
    }

    /// Makes ready to render what was flattened.
    ///
    /// # Errors
    ///
    /// There is no such camera, the integrator cannot render the scene, or the picture's size is out of bounds.
    pub fn render(&self, options: RenderOptions) -> Result<Render<'_>, SessionError> {
        Render::new(self, options)
    }

    /// Tells how the light of a pixel, by its column and row, came about.
    ///
    /// # Errors
    ///
    /// There is no such camera, pixel or sample, or the integrator cannot render the scene.
    pub fn explain(
        &self,
        camera: Option<&str>,
        pixel: [u32; 2],
        samples: Samples,
    ) -> Result<Explanation, SessionError> {
        Explanation::new(self, self.camera(camera)?, pixel, samples)
    }

    /// The number of the camera of that name, or of that number, or of the first one.
    ///
    /// # Errors
    ///
    /// The scene has no such camera, or none at all.
    pub fn camera(&self, name: Option<&str>) -> Result<usize, SessionError> {
        let cameras = &self.buffers().cameras;
        let found = match name {
            Some(name) => cameras.iter().position(|camera| camera.name == name),
            None => (!cameras.is_empty()).then_some(0),
        };
        // Cameras of glTF files often have no name: they may be asked for by number.
        let by_number = || name?.parse().ok().filter(|&number: &usize| number < cameras.len());
        let found = found.or_else(by_number);
        found.ok_or_else(|| SessionError::Camera {
            name: name.map(str::to_owned),
            known: cameras.iter().map(|camera| camera.name.clone()).collect(),
        })
    }

    /// The file that the scene comes from.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The entities, to look at and to edit; [`Session::flatten`] sees every edit.
    pub fn scene_mut(&mut self) -> &mut Scene {
        &mut self.scene
    }

    /// The entities.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The columns as the last flatten left them.
    pub fn buffers(&self) -> &SceneBuffers {
        self.scene.buffers()
    }

    /// Where the entities stand in the scene's files.
    pub fn places(&self) -> &Places {
        &self.places
    }

    /// What the last flatten did.
    pub fn report(&self) -> &FlattenReport {
        &self.report
    }

    /// What the last load that succeeded warned of, and its notes on what it did.
    pub fn warnings(&self) -> &[Diagnostic] {
        &self.warnings
    }

    /// The files that the last load asked for, whether it succeeded or not: when one changes, the scene may.
    pub fn dependencies(&self) -> &[PathBuf] {
        &self.dependencies
    }

    /// A hash of the scene's files and of the overrides.
    pub fn hash(&self) -> u64 {
        self.hash
    }

    /// When what was done.
    pub fn timeline(&self) -> &Timeline {
        &self.timeline
    }
}

/// What stands between a scene and its picture.
#[derive(Debug)]
pub enum SessionError {
    /// The file, or one that it refers to, cannot be used.
    Import(Failure),
    /// Entities that cannot be flattened.
    Invalid(Vec<Diagnostic>),
    /// There is no such camera.
    Camera {
        /// The one asked for; `None` for the first.
        name: Option<String>,
        /// The names of those that there are.
        known: Vec<String>,
    },
    /// The integrator cannot render the scene.
    Unsupported(Unsupported),
    /// There is no such pixel or sample, or it cannot be explained.
    Explain(ExplainError),
    /// The picture cannot be made or written.
    Film(FilmError),
}

impl fmt::Display for SessionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SessionError::Import(failure) => f.write_str(failure.to_string().trim_end()),
            SessionError::Invalid(invalid) => {
                let each: Vec<String> = invalid.iter().map(Diagnostic::to_string).collect();
                f.write_str(each.join("\n").trim_end())
            }
            SessionError::Camera { name: None, .. } => {
                f.write_str("the scene has no camera: it is given one by its file, or by `--eye` or `--orbit`")
            }
            SessionError::Camera { name: Some(name), known } => {
                let named: Vec<String> =
                    known.iter().filter(|name| !name.is_empty()).map(|name| format!("{name:?}")).collect();
                let those = match (known.len(), named.is_empty()) {
                    (0, _) => "it has none at all".to_owned(),
                    (1, true) => "its only one, number 0, has no name".to_owned(),
                    (count, true) => format!("its own have no names but numbers, 0 to {}", count - 1),
                    (_, false) => format!("there is {}", named.join(", ")),
                };
                write!(f, "the scene has no camera {name:?}: {those}")
            }
            SessionError::Unsupported(error) => error.fmt(f),
            SessionError::Explain(error) => error.fmt(f),
            SessionError::Film(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for SessionError {}

impl From<FilmError> for SessionError {
    fn from(error: FilmError) -> SessionError {
        SessionError::Film(error)
    }
}

impl From<Unsupported> for SessionError {
    fn from(error: Unsupported) -> SessionError {
        SessionError::Unsupported(error)
    }
}
