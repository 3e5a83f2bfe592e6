//! From entities to columns.
//!
//! The systems run one after another in the order of [`FlattenSet`]; each looks only at what changed since it last ran. What a file
//! writes, and what makes it stale, stands at its head.

mod camera;
mod details;
mod directory;
mod emitters;
mod environment;
mod instances;
mod lights;
mod materials;
mod meshes;
mod principled;
mod report;
mod rows;
mod shapes;
mod textures;
mod trees;

use bevy_ecs::entity::Entity;
use bevy_ecs::resource::Resource;
use bevy_ecs::schedule::{IntoScheduleConfigs, Schedule, SingleThreadedExecutor, SystemSet};
use bevy_ecs::world::World;
use brewster_buffers::SceneBuffers;

use self::report::{Clock, timed};
use crate::components::{Background, Settings};
use crate::systems::{FreeKey, Moved, WorldMotions, assign_keys, propagate_transforms};

pub(crate) use self::trees::Builder;

pub use self::report::{EmittersEdit, FlattenReport, Invalid, MeshTreeEdits, Problem, RowEdits, TopTreeEdit};

/// The columns that flattening keeps up to date.
#[derive(Resource, Default)]
pub(crate) struct Buffers(pub(crate) SceneBuffers);

/// The order of a flatten.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum FlattenSet {
    /// Entities without a scene key get one: everything after goes by keys.
    Keys,
    /// World transforms follow transforms and parents.
    Transforms,
    /// Shapes, meshes with their trees, materials and textures: what instances refer to.
    Referents,
    /// Rows of what is no instance any longer go first, so that their keys are free.
    RemovedInstances,
    /// New instances get rows.
    AddedInstances,
    /// Instances that wear something else, or moved, get their rows rewritten where they now stand.
    ChangedInstances,
    /// Lights, emitters, cameras, background and settings: whatever no other row refers to.
    Surroundings,
    /// The top tree follows the instances.
    Trees,
    /// What was left out is gathered.
    Report,
}

/// What the systems of one flatten tell each other about instances.
#[derive(Resource, Default)]
struct Edits {
    /// Entities that may have become an instance, may be one no longer, or may refer to something else.
    rewired: Vec<Entity>,
    /// Instances whose shape is another one than before.
    reshaped: Vec<Entity>,
    /// Rows whose bounds changed.
    touched: Vec<u32>,
    /// Rows that refer to another shape or material than before.
    rewritten: Vec<u32>,
    /// Whether the top tree has to be built anew, since rows came, went or changed their kind.
    regrouped: bool,
}

/// Adds what the systems read and write.
pub(crate) fn init_resources(world: &mut World) {
    world.init_resource::<Settings>();
    world.init_resource::<Background>();
    world.init_resource::<FreeKey>();
    world.init_resource::<Moved>();
    world.init_resource::<WorldMotions>();
    world.init_resource::<Buffers>();
    world.init_resource::<Edits>();
    world.init_resource::<shapes::ShapeIndex>();
    world.init_resource::<materials::MaterialIndex>();
    world.init_resource::<instances::InstanceIndex>();
    world.init_resource::<lights::LightIndex>();
    world.init_resource::<camera::CameraIndex>();
    world.init_resource::<Builder>();
    world.init_resource::<trees::Wear>();
    world.init_resource::<FlattenReport>();
    world.init_resource::<Clock>();
}

/// The systems in their order, on one thread: they all write the same columns, and the trees, which take longest, are built on all
/// threads anyway.
pub(crate) fn schedule() -> Schedule {
    use FlattenSet as Set;
    let mut schedule = Schedule::default();
    schedule.set_executor(SingleThreadedExecutor::new());
    schedule.configure_sets(
        (
            Set::Keys,
            Set::Transforms,
            Set::Referents,
            Set::RemovedInstances,
            Set::AddedInstances,
            Set::ChangedInstances,
            Set::Surroundings,
            Set::Trees,
            Set::Report,
        )
            .chain(),
    );
    schedule.add_systems((
        timed("assign_keys", assign_keys).in_set(Set::Keys),
        timed("propagate_transforms", propagate_transforms).in_set(Set::Transforms),
        (
            timed("flatten_changed_shapes", shapes::flatten_changed_shapes),
            timed("regroup_shapes", shapes::regroup_shapes),
            timed("note_reshaped_instances", shapes::note_reshaped_instances),
            timed("flatten_changed_materials", materials::flatten_changed_materials),
            timed("regroup_materials", materials::regroup_materials),
        )
            .chain()
            .in_set(Set::Referents),
        (
            timed("note_rewired_entities", instances::note_rewired_entities),
            timed("flatten_removed_instances", instances::flatten_removed_instances),
        )
            .chain()
            .in_set(Set::RemovedInstances),
        timed("flatten_added_instances", instances::flatten_added_instances).in_set(Set::AddedInstances),
        (
            timed("flatten_rewired_instances", instances::flatten_rewired_instances),
            timed("flatten_moved_instances", instances::flatten_moved_instances),
            timed("flatten_motions", instances::flatten_motions),
        )
            .chain()
            .in_set(Set::ChangedInstances),
        (
            timed("flatten_lights", lights::flatten_lights),
            timed("flatten_emitters", emitters::flatten_emitters),
            timed("flatten_cameras", camera::flatten_cameras),
            timed("flatten_background", environment::flatten_background),
            timed("flatten_settings", environment::flatten_settings),
        )
            .chain()
            .in_set(Set::Surroundings),
        timed("fit_top_tree", trees::fit_top_tree).in_set(Set::Trees),
        timed("report_invalid", report::report_invalid).in_set(Set::Report),
    ));
    schedule
}

/// Runs the systems once, and forgets the changes that they have seen.
pub(crate) fn run(world: &mut World, schedule: &mut Schedule) -> FlattenReport {
    *world.resource_mut::<FlattenReport>() = FlattenReport::default();
    *world.resource_mut::<Edits>() = Edits::default();
    world.resource_mut::<Clock>().restart();
    schedule.run(world);
    world.clear_trackers();
    std::mem::take(&mut *world.resource_mut::<FlattenReport>())
}
