//! A scene's text in a world, and what its entities hold.

use bevy_ecs::entity::Entity;
use bevy_ecs::hierarchy::ChildOf;
use bevy_ecs::name::Name;
use bevy_ecs::world::World;
use brewster_import::{Importer, LoadOptions, Loaded};
use brewster_world::components::Transform;
use glam::{Affine3A, Vec3};

pub(crate) fn load(text: &str) -> (Loaded, World) {
    load_with(text, LoadOptions::default())
}

pub(crate) fn load_with(text: &str, options: LoadOptions) -> (Loaded, World) {
    let loaded =
        Importer::new(options).load_text("scene.ron".as_ref(), text).unwrap_or_else(|failure| panic!("{failure}"));
    let mut world = World::new();
    loaded.scene.apply(&mut world);
    (loaded, world)
}

pub(crate) fn named(world: &mut World, name: &str) -> Entity {
    let mut query = world.query::<(Entity, &Name)>();
    let found: Vec<Entity> =
        query.iter(world).filter(|(_, found)| found.as_str() == name).map(|(entity, _)| entity).collect();
    assert_eq!(found.len(), 1, "{name} is there once");
    found[0]
}

pub(crate) fn get<C: bevy_ecs::component::Component + Clone>(world: &mut World, name: &str) -> C {
    let entity = named(world, name);
    world.get::<C>(entity).unwrap_or_else(|| panic!("{name} has none")).clone()
}

/// From an entity's space to the world's.
pub(crate) fn place(world: &World, entity: Entity) -> Affine3A {
    let mut place = Affine3A::IDENTITY;
    let mut at = Some(entity);
    while let Some(entity) = at {
        place = world.get::<Transform>(entity).expect("it is somewhere").0 * place;
        at = world.get::<ChildOf>(entity).map(ChildOf::parent);
    }
    place
}

/// Where an entity's origin is in the world.
pub(crate) fn position(world: &World, entity: Entity) -> Vec3 {
    place(world, entity).translation.into()
}
