//! The scene: a world, and the systems that flatten it.

use bevy_ecs::bundle::Bundle;
use bevy_ecs::hierarchy::{ChildOf, Children};
use bevy_ecs::name::Name;
use bevy_ecs::schedule::Schedule;
use bevy_ecs::world::{EntityWorldMut, World};
use brewster_buffers::SceneBuffers;
use brewster_geometry::TreeBuilder;

use crate::components::{SceneKey, Transform};
use crate::flatten::{self, Buffers, Builder, FlattenReport};

/// A scene as entities, and as the columns that [`Scene::flatten`] last wrote.
///
/// Spawn and edit components as in any world of bevy_ecs, whenever and in whatever order; nothing is read before the next flatten.
/// Who only compares and then writes (`set_if_neq`) spares work: a component counts as changed once it was borrowed mutably.
pub struct Scene {
    world: World,
    schedule: Schedule,
}

impl Default for Scene {
    fn default() -> Self {
        Scene::new()
    }
}

impl Scene {
    /// A scene with nothing in it, and default settings.
    pub fn new() -> Scene {
        Scene::with_tree_builder(TreeBuilder::default())
    }

    /// A scene with nothing in it, whose trees are built in some way.
    pub fn with_tree_builder(builder: TreeBuilder) -> Scene {
        let mut world = World::new();
        // A group needs no components of its own: it stands where its transform says, or where its parent is.
        world.register_required_components::<ChildOf, Transform>();
        world.register_required_components::<Children, Transform>();
        flatten::init_resources(&mut world);
        world.insert_resource(Builder(builder));
        Scene { world, schedule: flatten::schedule() }
    }

    /// The entities.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// The entities, to edit.
    pub fn world_mut(&mut self) -> &mut World {
        &mut self.world
    }

    /// Spawns an entity: `world_mut().spawn(bundle)`.
    pub fn spawn(&mut self, bundle: impl Bundle) -> EntityWorldMut<'_> {
        self.world.spawn(bundle)
    }

    /// The name of the entity of that key, if it has one.
    pub fn name_of(&self, key: SceneKey) -> Option<&str> {
        let mut named = self.world.try_query::<(&SceneKey, &Name)>()?;
        named.iter(&self.world).find(|(other, _)| **other == key).map(|(_, name)| name.as_str())
    }

    /// Brings the columns up to date with the entities. Costs what was edited since the last time; the columns are those of a new
    /// scene with the same entities and keys.
    pub fn flatten(&mut self) -> FlattenReport {
        flatten::run(&mut self.world, &mut self.schedule)
    }

    /// The columns as the last flatten left them.
    pub fn buffers(&self) -> &SceneBuffers {
        &self.world.resource::<Buffers>().0
    }
}
