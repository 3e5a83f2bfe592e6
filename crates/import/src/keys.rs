//! Scene keys: what gives an entity the same key in every load, as far as its file says the same of it.
//!
//! A key follows from the document alone, so a world that an edit was applied to holds the same keys as a fresh one, and rows
//! come in the same order. From the highest bit down: a zero; two bits for what it is (cameras, materials and shapes,
//! entities); then
//!
//! - a camera's place in the file;
//! - a hash of the path of a material or a shape, such as `#materials.glass`;
//! - 29 bits for an entity of the file's list: a hash of its name, or its place among those without a name; then 32 bits
//!   that count what is placed with it, in order.
//!
//! So a named entity keeps its key wherever in the list it stands, and what is added to the list moves only entities without
//! a name that come later. Two equal hashes are told apart by taking the next free number.

use std::collections::HashSet;

use crate::hash;

/// The keys that are taken.
#[derive(Debug, Default)]
pub(crate) struct Keys {
    definitions: HashSet<u64>,
    named: HashSet<u64>,
    unnamed: u64,
}

const CLASS_BIT: u32 = 61;
const DEFINITIONS: u64 = 1 << CLASS_BIT;
const ENTITIES: u64 = 2 << CLASS_BIT;
/// Slots of entities without a name are below, those of names are not.
const NAMED: u64 = 1 << 28;

impl Keys {
    /// The key of a camera that takes the place of all others.
    pub(crate) const VIEW: u64 = DEFINITIONS - 1;

    /// The key of the camera at a place of the file.
    pub(crate) fn camera(place: u64) -> u64 {
        place
    }

    /// The key of a material or a shape.
    pub(crate) fn definition(&mut self, path: &str) -> u64 {
        DEFINITIONS | free(&mut self.definitions, hash::of(path.as_bytes()), DEFINITIONS)
    }

    /// The first of the 2³² keys of the node at a place of a glTF file.
    pub(crate) fn node(place: u64) -> u64 {
        ENTITIES | place << 32
    }

    /// The first of the 2³² keys of an entity of the file's list.
    pub(crate) fn entity(&mut self, name: Option<&str>) -> u64 {
        let slot = match name {
            Some(name) => NAMED | free(&mut self.named, hash::of(name.as_bytes()), NAMED),
            None => {
                self.unnamed += 1;
                self.unnamed - 1
            }
        };
        ENTITIES | slot << 32
    }
}

/// The number below `bound`, a power of two, that a hash stands for, or the next free one. It is taken from now on.
fn free(taken: &mut HashSet<u64>, hash: u64, bound: u64) -> u64 {
    let mut number = hash & (bound - 1);
    while !taken.insert(number) {
        number = (number + 1) & (bound - 1);
    }
    number
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_hashes_get_keys_of_their_own() {
        let mut taken = HashSet::new();
        let numbers = [free(&mut taken, 7, 4), free(&mut taken, 3, 4), free(&mut taken, 11, 4), free(&mut taken, 0, 4)];
        assert_eq!(numbers, [3, 0, 1, 2]);
    }

    #[test]
    fn classes_do_not_meet() {
        let mut keys = Keys::default();
        let all = [
            Keys::camera(0),
            Keys::camera(1),
            keys.definition("#materials.a"),
            keys.definition("#materials.a"),
            keys.entity(None),
            keys.entity(None),
            keys.entity(Some("a")),
            keys.entity(Some("b")),
        ];
        let distinct: HashSet<u64> = all.into_iter().collect();
        assert_eq!(distinct.len(), all.len());
        assert!(all.iter().all(|key| key >> 63 == 0));
        // An entity's key depends on its name or on its place among those without one.
        assert_eq!(Keys::default().entity(Some("b")), all[7]);
        assert!(all[0] < all[2] && all[2] < all[4] && all[4] < all[5] && all[5] < all[6]);
    }
}
