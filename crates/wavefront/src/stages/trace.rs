//! Finds the closest hits.

use brewster_film::FilmTile;
use brewster_geometry::{Hit, HitColumns, closest_hits};

use crate::context::Context;
use crate::queues::PathRaysView;

/// Finds what each ray hits first.
///
/// Reads: the rays and the trees. Writes: one hit a ray, in the rays' order, and the film's number of rays.
pub fn trace(context: &Context<'_>, rays: PathRaysView<'_>, hits: &mut HitColumns, tile: &mut FilmTile<'_>) {
    hits.resize(rays.len(), Hit::miss());
    closest_hits(&context.geometry, context.policy.level, rays.rays(), hits.view_mut());
    for &pixel in rays.pixel {
        tile.add_rays(pixel, 1);
    }
}
