//! Which entity has which row of a table that instances refer to.

use std::collections::BTreeMap;

use bevy_ecs::entity::{Entity, EntityHashMap};

use super::report::Problem;
use crate::components::SceneKey;

/// The owners of a table's rows, in their order, and the entities that own none because something is wrong with them.
#[derive(Default)]
pub(super) struct Directory {
    owners: Vec<Owner>,
    rows: EntityHashMap<u32>,
    /// Entities that were left out.
    pub(super) invalid: BTreeMap<Entity, Problem>,
}

/// An entity that owns a row; owners stand in the order of their ranks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Owner {
    pub(super) key: u64,
    pub(super) entity: Entity,
}

/// Where rows went: a new row for each old one, or none.
pub(super) struct Moves {
    to: Vec<Option<u32>>,
    /// Entities whose row is new.
    pub(super) arrived: Vec<Entity>,
}

impl Owner {
    /// Its key; among entities with the same one, the first in the world.
    pub(super) fn rank(&self) -> (u64, u32) {
        (self.key, self.entity.index_u32())
    }

    /// Whether the entity has a key of its own, given the owner before it.
    pub(super) fn check_after(self, last: Option<&Owner>) -> Result<(), Problem> {
        if SceneKey(self.key) == SceneKey::UNASSIGNED {
            Err(Problem::NoKey)
        } else if last.is_some_and(|last| last.key == self.key) {
            Err(Problem::DuplicateKey(self.key))
        } else {
            Ok(())
        }
    }
}

impl Directory {
    /// The row of an entity.
    pub(super) fn row(&self, entity: Entity) -> Option<u32> {
        self.rows.get(&entity).copied()
    }

    /// The number of rows.
    pub(super) fn len(&self) -> usize {
        self.owners.len()
    }

    /// Whether the entity has a row or is left out.
    pub(super) fn knows(&self, entity: Entity) -> bool {
        self.rows.contains_key(&entity) || self.invalid.contains_key(&entity)
    }

    /// Whether the entity, which now has this key, belongs elsewhere.
    pub(super) fn is_out_of_order(&self, entity: Entity, key: &SceneKey) -> bool {
        self.row(entity).is_some_and(|row| self.owners[row as usize].key != key.0) || self.invalid.contains_key(&entity)
    }

    /// Makes `owners`, in ascending order, the owners of the rows.
    pub(super) fn reorder(&mut self, owners: Vec<Owner>) -> Moves {
        let rows: EntityHashMap<u32> = owners.iter().zip(0..).map(|(owner, row)| (owner.entity, row)).collect();
        let to = self.owners.iter().map(|old| rows.get(&old.entity).copied()).collect();
        let new = |owner: &&Owner| !self.rows.contains_key(&owner.entity);
        let arrived = owners.iter().filter(new).map(|owner| owner.entity).collect();
        self.owners = owners;
        self.rows = rows;
        Moves { to, arrived }
    }
}

impl Moves {
    /// Where an old row is now.
    pub(super) fn of(&self, old: u32) -> Option<u32> {
        self.to[old as usize]
    }
}

#[cfg(test)]
mod tests {
    use bevy_ecs::world::World;

    use super::*;

    fn entities<const N: usize>() -> [Entity; N] {
        let mut world = World::new();
        std::array::from_fn(|_| world.spawn_empty().id())
    }

    fn owners<const N: usize>(rows: [(u64, Entity); N]) -> Vec<Owner> {
        rows.into_iter().map(|(key, entity)| Owner { key, entity }).collect()
    }

    #[test]
    fn rows_follow_their_owners() {
        let [a, b, c, d] = entities();
        let mut directory = Directory::default();
        let moves = directory.reorder(owners([(1, a), (5, b), (9, c)]));
        assert_eq!(moves.arrived, [a, b, c]);
        assert_eq!(
            ([a, b, c, d].map(|entity| directory.row(entity)), directory.len()),
            ([Some(0), Some(1), Some(2), None], 3)
        );

        // b goes, d comes first, a and c change places.
        let moves = directory.reorder(owners([(0, d), (9, c), (10, a)]));
        assert_eq!([0, 1, 2].map(|old| moves.of(old)), [Some(2), None, Some(1)]);
        assert_eq!(moves.arrived, [d]);
        assert_eq!([a, b, c, d].map(|entity| directory.row(entity)), [Some(2), None, Some(1), Some(0)]);

        let moves = directory.reorder(Vec::new());
        assert_eq!([0, 1, 2].map(|old| moves.of(old)), [None; 3]);
        assert!(moves.arrived.is_empty() && directory.len() == 0);
    }

    #[test]
    fn who_has_a_row_or_was_left_out_is_known() {
        let [a, b, c] = entities();
        let mut directory = Directory::default();
        directory.reorder(owners([(1, a)]));
        directory.invalid.insert(b, Problem::NoKey);
        assert_eq!([a, b, c].map(|entity| directory.knows(entity)), [true, true, false]);
        // One that was left out may have got a key that mends it.
        for (entity, key, expected) in [(a, 1, false), (a, 2, true), (b, 1, true), (c, 1, false)] {
            assert_eq!(directory.is_out_of_order(entity, &SceneKey(key)), expected, "{entity} with key {key}");
        }
    }

    #[test]
    fn keys_are_ones_own() {
        let [a, b] = entities();
        let owner = |key, entity| Owner { key, entity };
        let unassigned = SceneKey::UNASSIGNED.0;
        for (last, next, expected) in [
            (None, owner(0, a), Ok(())),
            (Some(owner(3, a)), owner(4, b), Ok(())),
            (Some(owner(3, a)), owner(3, b), Err(Problem::DuplicateKey(3))),
            (None, owner(unassigned, b), Err(Problem::NoKey)),
            (Some(owner(unassigned, a)), owner(unassigned, b), Err(Problem::NoKey)),
        ] {
            assert_eq!(next.check_after(last.as_ref()), expected, "{next:?} after {last:?}");
        }
        // The first in the world keeps a key that two have.
        let mut both = [owner(3, b), owner(2, b), owner(3, a)];
        both.sort_unstable_by_key(Owner::rank);
        assert_eq!(both, [owner(2, b), owner(3, a), owner(3, b)]);
    }
}
