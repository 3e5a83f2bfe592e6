//! What the crate promises, one module for each claim.

/// Trees, kernels and refits change no hit: everything agrees to the bit with trying every primitive.
mod agreement;
/// Points drawn on shapes are spread evenly over areas worked out by other means, and are found by rays.
mod area_sampling;
/// Trees are the same for any number of threads, valid and within the memory that is stated.
mod building;
/// Surfaces found for many rays at once are those found ray by ray, to the bit.
mod many_at_once;
/// What moves is met where it is at the ray's time, as in a still scene that is placed so.
mod moving;
/// Rays that leave a surface start on the right side of it, however they graze it and wherever it stands.
mod spawning;
/// Scenes and random numbers for the tests.
mod support;
/// No ray slips through a closed mesh.
mod watertight;
