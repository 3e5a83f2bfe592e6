//! What a flatten did, what it cost, and what it had to leave out.

use std::fmt;
use std::time::{Duration, Instant};

use bevy_ecs::entity::Entity;
use bevy_ecs::name::Name;
use bevy_ecs::resource::Resource;
use bevy_ecs::system::{In, IntoSystem, Query, Res, ResMut, System};
use brewster_geometry::{MeshError, ShapeError, TransformError};

use super::camera::CameraIndex;
use super::instances::InstanceIndex;
use super::lights::LightIndex;
use super::materials::MaterialIndex;
use super::shapes::ShapeIndex;

/// What one flatten did.
#[derive(Resource, Clone, Debug, Default)]
pub struct FlattenReport {
    /// Edits of [`SceneBuffers::instances`](brewster_buffers::SceneBuffers::instances).
    pub instances: RowEdits,
    /// Edits of the shape table, all kinds together.
    pub shapes: RowEdits,
    /// Edits of materials; a material counts once, whatever columns it is in.
    pub materials: RowEdits,
    /// Edits of textures.
    pub textures: RowEdits,
    /// Edits of lights.
    pub lights: RowEdits,
    /// Edits of cameras.
    pub cameras: RowEdits,
    /// What happened to the bottom-level trees.
    pub mesh_trees: MeshTreeEdits,
    /// What happened to the top-level tree.
    pub top_tree: TopTreeEdit,
    /// What happened to the emitters.
    pub emitters: EmittersEdit,
    /// What could not be flattened, in the order of entities: reported by every flatten until it is mended.
    pub invalid: Vec<Invalid>,
    /// The time of each system, in the order in which they ran.
    pub times: Vec<(&'static str, Duration)>,
}

/// What happened to the rows of a table.
///
/// Instances are inserted and removed where they belong. Other tables are written over from the first row to the last: there
/// the added and removed rows are the difference in length, and a row is rewritten if another one stood in its place.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RowEdits {
    /// Rows that are new.
    pub added: usize,
    /// Rows that are gone.
    pub removed: usize,
    /// Rows that got other contents.
    pub rewritten: usize,
}

/// What happened to the bottom-level trees.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MeshTreeEdits {
    /// Trees that were built.
    pub built: usize,
    /// Triangles in them.
    pub triangles: usize,
    /// Trees whose mesh no entity has any longer.
    pub dropped: usize,
    /// The time of building, which is in that of the system as well.
    pub time: Duration,
}

/// What happened to the top-level tree.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TopTreeEdit {
    /// Nothing.
    #[default]
    Kept,
    /// Its boxes were fitted to this many instances that moved or changed their shape.
    Refitted(usize),
    /// It was built anew over this many instances: some came, went or got another kind of shape, or so many moved so far that
    /// rays would have become slow.
    Rebuilt(usize),
}

/// What happened to what sends out light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum EmittersEdit {
    /// Nothing.
    #[default]
    Kept,
    /// They were gathered from all instances and lights.
    Gathered {
        /// Instances and lights that shine.
        sources: usize,
        /// Whether the light tree was built: it is kept where sources only changed their rows.
        tree_built: bool,
    },
}

/// An entity that was left out, or one of its roles.
#[derive(Clone, Debug, PartialEq)]
pub struct Invalid {
    /// The entity.
    pub entity: Entity,
    /// Its name, where it has one.
    pub name: Option<String>,
    /// What is wrong with it.
    pub problem: Problem,
}

/// Why something was left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Problem {
    /// It has no place.
    Transform(TransformError),
    /// Its bounds cannot be computed with.
    OutOfRange,
    /// Its shape cannot be.
    Shape(ShapeError),
    /// Its mesh cannot be used.
    Mesh(MeshError),
    /// Its material cannot be; what must hold.
    Material(&'static str),
    /// Its light cannot be; what must hold.
    Light(&'static str),
    /// Its camera cannot be; what must hold.
    Camera(&'static str),
    /// It wears the shape of an entity that has none, or none that can be.
    UsesShape(Entity),
    /// It wears the material of an entity that has none, or none that can be.
    UsesMaterial(Entity),
    /// Another entity has its scene key.
    DuplicateKey(u64),
    /// It has no scene key and none is left.
    NoKey,
}

impl RowEdits {
    /// Rows that were written: new ones and others.
    pub fn written(self) -> usize {
        self.added + self.rewritten
    }

    /// Whether nothing happened.
    pub fn is_none(self) -> bool {
        self == RowEdits::default()
    }

    /// Counts a row that was written where there had been `before` rows.
    pub(super) fn count(&mut self, row: usize, before: usize, differs: bool) {
        if row >= before {
            self.added += 1;
        } else if differs {
            self.rewritten += 1;
        }
    }
}

impl FlattenReport {
    /// The edits of each table, by its name.
    pub fn rows(&self) -> [(&'static str, RowEdits); 6] {
        [
            ("instances", self.instances),
            ("shapes", self.shapes),
            ("materials", self.materials),
            ("textures", self.textures),
            ("lights", self.lights),
            ("cameras", self.cameras),
        ]
    }

    /// Rows written in all tables.
    pub fn rows_written(&self) -> usize {
        self.rows().into_iter().map(|(_, edits)| edits.written()).sum()
    }

    /// The time of all systems.
    pub fn total(&self) -> Duration {
        self.times.iter().map(|&(_, time)| time).sum()
    }
}

impl fmt::Display for FlattenReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let milliseconds = |time: Duration| time.as_secs_f64() * 1e3;
        for (name, edits) in self.rows().into_iter().filter(|(_, edits)| !edits.is_none()) {
            let RowEdits { added, removed, rewritten } = edits;
            writeln!(f, "{name}: {added} added, {removed} removed, {rewritten} rewritten")?;
        }
        let MeshTreeEdits { built, triangles, dropped, time } = self.mesh_trees;
        if built + dropped > 0 {
            let time = milliseconds(time);
            writeln!(f, "mesh trees: {built} built over {triangles} triangles in {time:.3} ms, {dropped} dropped")?;
        }
        match self.top_tree {
            TopTreeEdit::Kept => writeln!(f, "top tree: kept")?,
            TopTreeEdit::Refitted(moved) => writeln!(f, "top tree: refitted to {moved} instances")?,
            TopTreeEdit::Rebuilt(instances) => writeln!(f, "top tree: rebuilt over {instances} instances")?,
        }
        if let EmittersEdit::Gathered { sources, tree_built } = self.emitters {
            let tree = if tree_built { "built" } else { "kept" };
            writeln!(f, "emitters: {sources} gathered, light tree {tree}")?;
        }
        for invalid in &self.invalid {
            writeln!(f, "left out: {invalid}")?;
        }
        writeln!(f, "{:.3} ms", milliseconds(self.total()))?;
        for &(name, time) in &self.times {
            writeln!(f, "  {name}: {:.3} ms", milliseconds(time))?;
        }
        Ok(())
    }
}

impl fmt::Display for Invalid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.name {
            Some(name) => write!(f, "\"{name}\" (entity {}): {}", self.entity, self.problem),
            None => write!(f, "entity {}: {}", self.entity, self.problem),
        }
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Problem::Transform(TransformError::NotAffine) => {
                f.write_str("it has no place: a transform at or above it is not finite, or its parents form a cycle")
            }
            Problem::Transform(error) => error.fmt(f),
            Problem::OutOfRange => f.write_str("it lies beyond 1e15 m, or its transform flattens it"),
            Problem::Shape(error) => error.fmt(f),
            Problem::Mesh(error) => error.fmt(f),
            Problem::Material(rule) | Problem::Light(rule) | Problem::Camera(rule) => f.write_str(rule),
            Problem::UsesShape(owner) => write!(f, "it wears the shape of entity {owner}, which has none that can be"),
            Problem::UsesMaterial(owner) => {
                write!(f, "it wears the material of entity {owner}, which has none that can be")
            }
            Problem::DuplicateKey(key) => write!(f, "another entity has its scene key {key}"),
            Problem::NoKey => f.write_str("it has no scene key, and none is left"),
        }
    }
}

impl std::error::Error for Invalid {}

/// When the running system began.
#[derive(Resource)]
pub(super) struct Clock(Instant);

impl Default for Clock {
    fn default() -> Self {
        Clock(Instant::now())
    }
}

impl Clock {
    /// The next system begins now.
    pub(super) fn restart(&mut self) {
        self.0 = Instant::now();
    }
}

/// The same system; its time goes into the report under `name`.
pub(super) fn timed<M>(name: &'static str, system: impl IntoSystem<(), (), M>) -> impl System<In = (), Out = ()> {
    let stop = move |_: In<()>, mut clock: ResMut<Clock>, mut report: ResMut<FlattenReport>| {
        let now = Instant::now();
        report.times.push((name, now - clock.0));
        clock.0 = now;
    };
    IntoSystem::into_system(system.pipe(stop))
}

/// Gathers what each table left out.
pub(super) fn report_invalid(
    (shapes, materials): (Res<ShapeIndex>, Res<MaterialIndex>),
    (instances, lights, cameras): (Res<InstanceIndex>, Res<LightIndex>, Res<CameraIndex>),
    names: Query<&Name>,
    mut report: ResMut<FlattenReport>,
) {
    let directories = [&shapes.directory.invalid, &materials.directory.invalid];
    let tables = [&instances.invalid, &lights.invalid, &cameras.invalid];
    report.invalid = directories
        .into_iter()
        .chain(tables)
        .flatten()
        .map(|(&entity, &problem)| {
            let name = names.get(entity).ok().map(|name| name.as_str().to_owned());
            Invalid { entity, name, problem }
        })
        .collect();
    report.invalid.sort_by_key(|invalid| invalid.entity.index_u32());
}
