//! Systems that prepare the world for flattening: keys and world transforms.

mod changes;
mod keys;
mod propagate;

pub(crate) use changes::{Watch, for_each_changed};
pub(crate) use keys::{FreeKey, assign_keys};
pub(crate) use propagate::{Moved, WorldMotions, propagate_transforms};
