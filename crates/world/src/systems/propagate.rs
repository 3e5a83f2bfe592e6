//! World transforms from transforms and parents.
//!
//! Only what lies below an edit is computed anew, and no farther down than anything changes. Nothing here recurses, so a chain of
//! parents may be as long as memory lasts.

use bevy_ecs::change_detection::DetectChanges;
use bevy_ecs::entity::{Entity, EntityHashMap};
use bevy_ecs::hierarchy::{ChildOf, Children};
use bevy_ecs::lifecycle::RemovedComponents;
use bevy_ecs::query::{QueryData, With, Without};
use bevy_ecs::resource::Resource;
use bevy_ecs::system::{Query, ResMut};
use bevy_ecs::world::Mut;
use glam::Affine3A;

use super::{Watch, for_each_changed};
use crate::components::{Transform, WorldTransform};

/// The entities that the last propagation moved, but for those that are new: whatever needs the place of a new entity is new
/// as well.
#[derive(Resource, Default)]
pub(crate) struct Moved(pub(crate) Vec<Entity>);

/// What a propagation reads and writes of an entity.
type Node =
    (Option<&'static Transform>, Option<&'static ChildOf>, Option<&'static Children>, &'static mut WorldTransform);

/// Writes [`WorldTransform`] of all entities at or below a transform or parent that changed.
///
/// An entity in or below a cycle of parents gets one that is not finite.
pub(crate) fn propagate_transforms(
    (roots, others): (Watch<Transform, Without<ChildOf>>, Watch<Transform, With<ChildOf>>),
    parents: Watch<ChildOf>,
    (mut stripped, mut orphaned): (RemovedComponents<Transform>, RemovedComponents<ChildOf>),
    mut nodes: Query<Node>,
    mut moved: ResMut<Moved>,
) {
    moved.0.clear();
    let mut depths = Depths { nodes: nodes.as_readonly(), parents: EntityHashMap::default(), path: Vec::new() };
    let mut edited: Vec<(u32, Entity)> = Vec::new();
    for_each_changed(&roots, |entity, _| edited.push((0, entity)));
    for_each_changed(&others, |entity, _| edited.push((depths.of(entity), entity)));
    for_each_changed(&parents, |entity, _| edited.push((depths.of(entity), entity)));
    edited.extend(stripped.read().chain(orphaned.read()).map(|entity| (depths.of(entity), entity)));
    // From the top down: when its turn comes, all above an entity is final.
    edited.sort_by_key(|&(depth, _)| depth);

    let mut pending: Vec<(Entity, Affine3A)> = Vec::new();
    for (depth, entity) in edited {
        let above = match depth {
            0 => Affine3A::IDENTITY,
            Depths::CYCLE => Affine3A::NAN,
            _ => nodes.get(entity).map_or(Affine3A::IDENTITY, |(_, parent, ..)| {
                let parent = parent.and_then(|parent| nodes.get(parent.parent()).ok());
                parent.map_or(Affine3A::IDENTITY, |(.., place)| place.0)
            }),
        };
        pending.push((entity, above));
        while let Some((entity, above)) = pending.pop() {
            let Ok((transform, _, children, mut world)) = nodes.get_mut(entity) else { continue };
            let place = above * transform.copied().unwrap_or_default().0;
            if set_place(&mut world, place) {
                pending.extend(children.into_iter().flatten().map(|&child| (child, world.0)));
                if !world.is_added() {
                    moved.0.push(entity);
                }
            }
        }
    }
}

/// Writes a place if it is another one to the bit, and says whether. All places that are not finite count as one.
fn set_place(world: &mut Mut<WorldTransform>, place: Affine3A) -> bool {
    let place = if place.is_finite() { place } else { Affine3A::NAN };
    let bits = |place: Affine3A| place.to_cols_array().map(f32::to_bits);
    let other = bits(world.0) != bits(place);
    if other {
        world.0 = place;
    }
    other
}

/// How many parents are above an entity; those of parents are remembered, so that a chain is climbed once.
struct Depths<'w, 's> {
    nodes: Query<'w, 's, <Node as QueryData>::ReadOnly>,
    parents: EntityHashMap<u32>,
    path: Vec<Entity>,
}

impl Depths<'_, '_> {
    /// In or below a cycle.
    const CYCLE: u32 = u32::MAX;
    /// Being climbed: who meets it has gone round in a cycle.
    const OPEN: u32 = u32::MAX - 1;

    fn of(&mut self, entity: Entity) -> u32 {
        self.parent_of(entity).map_or(0, |parent| one_below(self.of_parent(parent)))
    }

    fn of_parent(&mut self, parent: Entity) -> u32 {
        let mut top = Some(parent);
        let mut depth = loop {
            let Some(entity) = top else { break None };
            match self.parents.get(&entity) {
                Some(&Self::OPEN) => break Some(Self::CYCLE),
                Some(&depth) => break Some(depth),
                None => self.parents.insert(entity, Self::OPEN),
            };
            self.path.push(entity);
            top = self.parent_of(entity);
        };
        while let Some(entity) = self.path.pop() {
            let below = depth.map_or(0, one_below);
            self.parents.insert(entity, below);
            depth = Some(below);
        }
        depth.expect("the parent itself was on the path or known")
    }

    fn parent_of(&self, entity: Entity) -> Option<Entity> {
        self.nodes.get(entity).ok()?.1.map(ChildOf::parent)
    }
}

/// One farther down; a cycle has no depth.
fn one_below(depth: u32) -> u32 {
    if depth == Depths::CYCLE { depth } else { depth + 1 }
}
