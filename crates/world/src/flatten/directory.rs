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
