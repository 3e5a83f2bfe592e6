//! The transmission queue: rays that went through a surface, refracted or straight on.

use super::RayQueue;

/// Marks rays that were transmitted.
#[derive(Debug)]
pub enum Transmission {}

/// Rays that were transmitted.
pub type TransmissionQueue = RayQueue<Transmission>;
