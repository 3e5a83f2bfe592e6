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

#[cfg(test)]
mod tests {
    use bevy_ecs::schedule::Schedule;
    use bevy_ecs::world::World;
    use glam::Vec3;

    use super::*;

    /// A world whose transforms are propagated on demand.
    struct Stage {
        world: World,
        schedule: Schedule,
    }

    impl Stage {
        fn new() -> Stage {
            let mut world = World::new();
            world.init_resource::<Moved>();
            let mut schedule = Schedule::default();
            schedule.add_systems(propagate_transforms);
            Stage { world, schedule }
        }

        /// Spawns an entity at a place in its parent's space.
        fn spawn(&mut self, at: Vec3, parent: Option<Entity>) -> Entity {
            let entity = self.world.spawn(Transform(Affine3A::from_translation(at))).id();
            if let Some(parent) = parent {
                self.world.entity_mut(entity).insert(ChildOf(parent));
            }
            entity
        }

        fn put(&mut self, entity: Entity, transform: Affine3A) {
            self.world.entity_mut(entity).insert(Transform(transform));
        }

        /// Propagates; the entities that moved, in the order of their ids.
        fn run(&mut self) -> Vec<Entity> {
            self.schedule.run(&mut self.world);
            self.world.clear_trackers();
            let mut moved = self.world.resource::<Moved>().0.clone();
            moved.sort_by_key(|entity| entity.index_u32());
            moved
        }

        /// The origin of an entity's space in the world.
        fn origin(&self, entity: Entity) -> Vec3 {
            self.world.get::<WorldTransform>(entity).expect("every transform has one").0.translation.into()
        }
    }

    const X: Vec3 = Vec3::X;
    const QUARTER_ABOUT_Y: Affine3A =
        Affine3A::from_cols(glam::Vec3A::NEG_Z, glam::Vec3A::Y, glam::Vec3A::X, glam::Vec3A::ZERO);

    /// A root, its child and its grandchild, each a meter along x from the last.
    fn chain(stage: &mut Stage) -> [Entity; 3] {
        let root = stage.spawn(X, None);
        let child = stage.spawn(X, Some(root));
        let grandchild = stage.spawn(X, Some(child));
        assert_eq!(stage.run(), [], "what is new has not moved");
        [root, child, grandchild]
    }

    #[test]
    fn an_edit_reaches_what_is_below_it_and_nothing_else() {
        let mut stage = Stage::new();
        let [root, child, grandchild] = chain(&mut stage);
        let other = stage.spawn(Vec3::Y, None);
        stage.run();
        assert_eq!([root, child, grandchild].map(|entity| stage.origin(entity)), [X, 2.0 * X, 3.0 * X]);

        // A quarter turn about y takes +X to -Z.
        stage.put(root, QUARTER_ABOUT_Y);
        assert_eq!(stage.run(), [root, child, grandchild]);
        assert_eq!([child, grandchild].map(|entity| stage.origin(entity)), [-Vec3::Z, -2.0 * Vec3::Z]);
        stage.put(grandchild, Affine3A::from_translation(3.0 * X));
        assert_eq!(stage.run(), [grandchild]);
        assert_eq!(stage.origin(grandchild), -4.0 * Vec3::Z);
        assert_eq!(stage.origin(other), Vec3::Y);
        assert_eq!(stage.run(), [], "nothing was edited");
    }

    #[test]
    fn an_edit_that_changes_nothing_moves_nothing() {
        let mut stage = Stage::new();
        let [root, child, _] = chain(&mut stage);
        stage.put(root, Affine3A::from_translation(X));
        assert_eq!(stage.run(), []);
        // The root goes one way and its child the other: what is below stays.
        stage.put(root, Affine3A::from_translation(2.0 * X));
        stage.put(child, Affine3A::IDENTITY);
        assert_eq!(stage.run(), [root]);
        assert_eq!(stage.origin(child), 2.0 * X);
    }

    #[test]
    fn edits_at_several_depths_count_from_the_top_down() {
        let mut stage = Stage::new();
        let [root, child, grandchild] = chain(&mut stage);
        for (entity, length) in [(grandchild, 100.0), (root, 1.0), (child, 10.0)] {
            stage.put(entity, Affine3A::from_translation(length * Vec3::Z));
        }
        stage.run();
        assert_eq!([root, child, grandchild].map(|entity| stage.origin(entity).z), [1.0, 11.0, 111.0]);
    }

    #[test]
    fn parents_are_changed_lost_and_found() {
        let mut stage = Stage::new();
        let [root, child, grandchild] = chain(&mut stage);
        let far = stage.spawn(10.0 * X, None);
        stage.run();
        stage.world.entity_mut(child).insert(ChildOf(far));
        assert_eq!(stage.run(), [child, grandchild]);
        assert_eq!([child, grandchild].map(|entity| stage.origin(entity)), [11.0 * X, 12.0 * X]);
        stage.world.entity_mut(child).remove::<ChildOf>();
        assert_eq!(stage.run(), [child, grandchild]);
        assert_eq!([child, grandchild].map(|entity| stage.origin(entity)), [X, 2.0 * X]);
        stage.world.entity_mut(root).insert(ChildOf(grandchild));
        assert_eq!(stage.run(), [root]);
        assert_eq!(stage.origin(root), 3.0 * X);
    }

    #[test]
    fn without_a_transform_an_entity_is_where_its_parent_is() {
        let mut stage = Stage::new();
        let [root, child, grandchild] = chain(&mut stage);
        stage.world.entity_mut(child).remove::<Transform>();
        assert_eq!(stage.run(), [child, grandchild]);
        assert_eq!([root, child, grandchild].map(|entity| stage.origin(entity)), [X, X, 2.0 * X]);
    }

    #[test]
    fn in_a_cycle_and_below_it_there_is_no_place_until_it_is_opened() {
        let mut stage = Stage::new();
        let [root, child, grandchild] = chain(&mut stage);
        let other = stage.spawn(Vec3::Y, None);
        stage.world.entity_mut(root).insert(ChildOf(child));
        stage.run();
        for entity in [root, child, grandchild] {
            assert!(stage.origin(entity).is_nan(), "{entity}");
        }
        assert_eq!(stage.origin(other), Vec3::Y);
        // An edit in it changes nothing, and ends.
        stage.put(child, Affine3A::IDENTITY);
        assert_eq!(stage.run(), []);
        stage.world.entity_mut(root).remove::<ChildOf>();
        assert_eq!(stage.run(), [root, child, grandchild]);
        assert_eq!([root, child, grandchild].map(|entity| stage.origin(entity)), [X, X, 2.0 * X]);
    }

    #[test]
    fn transforms_that_are_not_finite_leave_no_place_below_them() {
        let mut stage = Stage::new();
        let [root, child, grandchild] = chain(&mut stage);
        stage.put(child, Affine3A::from_scale(Vec3::splat(f32::INFINITY)));
        assert_eq!(stage.run(), [child, grandchild]);
        assert!(stage.origin(root) == X && stage.origin(grandchild).is_nan());
        // Another one is no move: what has no place cannot go.
        stage.put(child, Affine3A::from_translation(Vec3::splat(f32::NAN)));
        assert_eq!(stage.run(), []);
    }

    #[test]
    fn a_chain_may_be_very_long() {
        const LENGTH: usize = 20_000;
        let mut stage = Stage::new();
        let root = stage.spawn(X, None);
        let mut last = root;
        for _ in 1..LENGTH {
            last = stage.spawn(X, Some(last));
        }
        stage.run();
        // Sums of ones are exact.
        assert_eq!(stage.origin(last), LENGTH as f32 * X);
        stage.put(root, Affine3A::IDENTITY);
        assert_eq!(stage.run().len(), LENGTH);
        assert_eq!(stage.origin(last), (LENGTH - 1) as f32 * X);
    }
}
