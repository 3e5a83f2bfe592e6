//! World transforms from transforms and parents.
//!
//! Only what lies below an edit is computed anew, and no farther down than anything changes. Nothing here recurses, so a chain of
//! parents may be as long as memory lasts.

use std::sync::Arc;

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
use crate::components::{Motion, Transform, WorldTransform};

/// The entities that the last propagation moved, but for those that are new: whatever needs the place of a new entity is new
/// as well.
#[derive(Resource, Default)]
pub(crate) struct Moved(pub(crate) Vec<Entity>);

/// Where entities are that move while the shutter is open: maps to world space at equal steps of its time, two or more, the first of
/// them that of [`WorldTransform`]. Empty where nothing moves.
#[derive(Resource, Default)]
pub(crate) struct WorldMotions(EntityHashMap<Arc<[Affine3A]>>);

impl WorldMotions {
    /// How an entity moves; none if it does not.
    pub(crate) fn of(&self, entity: Entity) -> Option<&Arc<[Affine3A]>> {
        if self.0.is_empty() { None } else { self.0.get(&entity) }
    }

    /// Writes how an entity moves if it is another motion to the bit, and says whether.
    fn set(&mut self, entity: Entity, motion: Option<Arc<[Affine3A]>>) -> bool {
        let bits =
            |keys: &Arc<[Affine3A]>| keys.iter().map(|key| key.to_cols_array().map(f32::to_bits)).collect::<Vec<_>>();
        match (self.of(entity), motion) {
            (None, None) => false,
            (Some(old), Some(new)) if bits(old) == bits(&new) => false,
            (_, Some(new)) => {
                self.0.insert(entity, new);
                true
            }
            (Some(_), None) => self.0.remove(&entity).is_some(),
        }
    }
}

/// How an entity moves, by how what is above it moves, its place when the shutter opens, its transform and its own motion.
fn world_motion(
    (above, above_motion): (Affine3A, Option<&Arc<[Affine3A]>>),
    transform: Affine3A,
    own: Option<&Motion>,
) -> Option<Arc<[Affine3A]>> {
    let own_steps = own.map_or(&[][..], Motion::steps);
    let steps = match (above_motion.map_or(0, |keys| keys.len() - 1), own_steps.len()) {
        (0, 0) => return None,
        (steps, 0) | (0, steps) => steps,
        (a, b) => (1..).map(|times| times * a).find(|steps| steps % b == 0).unwrap_or(a).min(Motion::MOST_STEPS),
    };
    let key = |step: usize| {
        let above = above_motion.map_or(above, |keys| between(keys.len() - 1, |key| keys[key], step, steps));
        let own = |key: usize| if key == 0 { Affine3A::IDENTITY } else { own_steps[key - 1] };
        if own_steps.is_empty() {
            above * transform
        } else {
            above * transform * between(own_steps.len(), own, step, steps)
        }
    };
    Some((0..=steps).map(key).collect())
}

/// The place after some steps of many, where it is known for others.
fn between(known: usize, key: impl Fn(usize) -> Affine3A, step: usize, steps: usize) -> Affine3A {
    let (at, rest) = (step * known / steps, step * known % steps);
    if rest == 0 {
        return key(at);
    }
    let (from, to, s) = (key(at), key(at + 1), rest as f32 / steps as f32);
    Affine3A {
        matrix3: from.matrix3 + (to.matrix3 - from.matrix3) * s,
        translation: from.translation + (to.translation - from.translation) * s,
    }
}

/// What a propagation reads and writes of an entity.
type Node = (
    (Option<&'static Transform>, Option<&'static Motion>),
    Option<&'static ChildOf>,
    Option<&'static Children>,
    &'static mut WorldTransform,
);

/// Writes [`WorldTransform`], and how they move, of all entities at or below a transform, motion or parent that changed.
///
/// An entity in or below a cycle of parents gets one that is not finite.
pub(crate) fn propagate_transforms(
    (roots, others): (Watch<Transform, Without<ChildOf>>, Watch<Transform, With<ChildOf>>),
    (parents, motions): (Watch<ChildOf>, Watch<Motion>),
    (mut stripped, mut orphaned): (RemovedComponents<Transform>, RemovedComponents<ChildOf>),
    mut stopped: RemovedComponents<Motion>,
    mut nodes: Query<Node>,
    (mut moved, mut world_motions): (ResMut<Moved>, ResMut<WorldMotions>),
) {
    moved.0.clear();
    let mut depths = Depths { nodes: nodes.as_readonly(), parents: EntityHashMap::default(), path: Vec::new() };
    let mut edited: Vec<(u32, Entity)> = Vec::new();
    for_each_changed(&roots, |entity, _| edited.push((0, entity)));
    for_each_changed(&others, |entity, _| edited.push((depths.of(entity), entity)));
    for_each_changed(&parents, |entity, _| edited.push((depths.of(entity), entity)));
    for_each_changed(&motions, |entity, _| edited.push((depths.of(entity), entity)));
    edited
        .extend(stripped.read().chain(orphaned.read()).chain(stopped.read()).map(|entity| (depths.of(entity), entity)));
    // From the top down: when its turn comes, all above an entity is final.
    edited.sort_by_key(|&(depth, _)| depth);

    let mut pending: Vec<(Entity, Affine3A, Option<Entity>)> = Vec::new();
    for (depth, entity) in edited {
        let parent = || nodes.get(entity).ok().and_then(|(_, parent, ..)| parent).map(ChildOf::parent);
        let (above, parent) = match depth {
            0 => (Affine3A::IDENTITY, None),
            Depths::CYCLE => (Affine3A::NAN, None),
            _ => match parent().and_then(|parent| Some((nodes.get(parent).ok()?.3.0, parent))) {
                Some((place, parent)) => (place, Some(parent)),
                None => (Affine3A::IDENTITY, None),
            },
        };
        pending.push((entity, above, parent));
        while let Some((entity, above, parent)) = pending.pop() {
            let Ok(((transform, motion), _, children, mut world)) = nodes.get_mut(entity) else {
                world_motions.set(entity, None);
                continue;
            };
            let transform = transform.copied().unwrap_or_default().0;
            let above_motion = parent.and_then(|parent| world_motions.of(parent));
            let keys = world_motion((above, above_motion), transform, motion);
            if set_place(&mut world, above * transform) | world_motions.set(entity, keys) {
                pending.extend(children.into_iter().flatten().map(|&child| (child, world.0, Some(entity))));
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
            world.init_resource::<WorldMotions>();
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
