//! Where an entity is, and its place in the order of rows.

use bevy_ecs::component::Component;
use glam::Affine3A;

/// From the entity's space to its parent's (`ChildOf`), or to the world's where it has none. Invertible.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq)]
#[require(WorldTransform)]
#[component(summary_tick)]
pub struct Transform(pub Affine3A);

/// From the entity's space to the world's: written by the propagating system alone, at a flatten. Not finite where the entity
/// has no place: its parents form a cycle, or a transform above it is not finite.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq)]
pub struct WorldTransform(pub Affine3A);

/// The entity's stable place: rows are ordered by it, so that an edited world and a fresh one give the same columns.
///
/// Unique among the entities of a world. Entities that are spawned without one get the next free key when they are first
/// flattened, in the order of their ids.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[component(summary_tick)]
pub struct SceneKey(pub u64);

impl SceneKey {
    /// Not a key yet: the next flatten gives one out.
    pub const UNASSIGNED: SceneKey = SceneKey(u64::MAX);
}

impl Default for SceneKey {
    fn default() -> Self {
        SceneKey::UNASSIGNED
    }
}
