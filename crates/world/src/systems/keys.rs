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
