//! What stands where.

use brewster_geometry::{Affine, ShapeRef};
use brewster_lanes::columns;

use crate::MaterialId;

columns! {
    /// A shape, placed. Its row index is its `InstanceId`, which pictures of ids and hits carry.
    pub struct Instance => InstanceColumns, InstancesView, InstancesViewMut {
        /// From object space to world space.
        pub object_to_world: Affine,
        /// Its inverse.
        pub world_to_object: Affine,
        /// The shape.
        pub shape: ShapeRef,
        /// The material.
        pub material: MaterialId,
        /// The entity's scene key; rows are in its order.
        pub key: u64,
    }
}
