//! The reflection queue: rays that a surface sent back to the side they came from.
//!
//! Kept apart from transmissions all the way: their rays stay in the medium they were in, and neighbors stay coherent.

use super::RayQueue;

/// Marks rays that were reflected.
#[derive(Debug)]
pub enum Reflection {}

/// Rays that were reflected.
pub type ReflectionQueue = RayQueue<Reflection>;
