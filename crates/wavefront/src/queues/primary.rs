//! The primary queue: rays from the camera.

use super::RayQueue;

/// Marks rays that came from the camera.
#[derive(Debug)]
pub enum Primary {}

/// Rays from the camera.
pub type PrimaryQueue = RayQueue<Primary>;
