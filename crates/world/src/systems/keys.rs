//! Scene keys for entities that have none yet.

use bevy_ecs::entity::Entity;
use bevy_ecs::resource::Resource;
use bevy_ecs::system::{ParamSet, Query, ResMut};

use super::{Watch, for_each_changed};
use crate::components::SceneKey;

/// The key that the next entity without one gets: above all that this world has seen.
#[derive(Resource, Default)]
pub(crate) struct FreeKey(u64);

/// Gives keys to entities that have none, in the order of their ids. Should keys run out, the rest stay without.
pub(crate) fn assign_keys(mut free: ResMut<FreeKey>, mut keys: ParamSet<(Watch<SceneKey>, Query<&mut SceneKey>)>) {
    let mut unassigned: Vec<Entity> = Vec::new();
    for_each_changed(&keys.p0(), |entity, &key| match key {
        SceneKey::UNASSIGNED => unassigned.push(entity),
        SceneKey(key) => free.0 = free.0.max(key + 1),
    });
    unassigned.sort_unstable_by_key(|entity| entity.index_u32());
    let mut keys = keys.p1();
    for entity in unassigned {
        if let Ok(mut key) = keys.get_mut(entity)
            && free.0 < SceneKey::UNASSIGNED.0
        {
            key.0 = free.0;
            free.0 += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use bevy_ecs::schedule::Schedule;
    use bevy_ecs::world::World;

    use super::*;

    /// The keys that entities have after one run for each list of keys that are spawned.
    fn keys(runs: &[&[SceneKey]]) -> Vec<u64> {
        let mut world = World::new();
        world.init_resource::<FreeKey>();
        let mut schedule = Schedule::default();
        schedule.add_systems(assign_keys);
        let mut entities = Vec::new();
        for keys in runs {
            entities.extend(keys.iter().map(|&key| world.spawn(key).id()));
            schedule.run(&mut world);
        }
        entities.into_iter().map(|entity| world.get::<SceneKey>(entity).expect("it has one").0).collect()
    }

    #[test]
    fn free_keys_are_above_all_that_were_seen_in_the_order_of_entities() {
        const NEW: SceneKey = SceneKey::UNASSIGNED;
        let check = |runs: &[&[SceneKey]], expected: &[u64]| assert_eq!(keys(runs), expected, "{runs:?}");
        check(&[&[NEW, NEW, NEW]], &[0, 1, 2]);
        check(&[&[NEW, SceneKey(7), NEW]], &[8, 7, 9]);
        check(&[&[NEW, SceneKey(7)], &[NEW], &[SceneKey(3), NEW]], &[8, 7, 9, 3, 10]);
        check(&[&[]], &[]);
    }

    #[test]
    fn when_keys_run_out_the_rest_stay_without() {
        let (last, none) = (u64::MAX - 1, u64::MAX);
        let keys = keys(&[&[SceneKey(last - 1), SceneKey::UNASSIGNED, SceneKey::UNASSIGNED], &[SceneKey::UNASSIGNED]]);
        assert_eq!(keys, [last - 1, last, none, none]);
    }
}
