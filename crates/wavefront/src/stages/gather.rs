//! Adds contributions to the film.

use brewster_film::FilmTile;

use crate::queues::ContributionQueue;

/// Adds all contributions to their pixels and empties the queue.
///
/// Reads and empties: contributions. Writes: the film's colors.
pub fn gather(contributions: &mut ContributionQueue, tile: &mut FilmTile<'_>) {
    let view = contributions.view();
    for (radiance, &pixel) in view.radiance.iter().zip(view.pixel) {
        tile.add(pixel, radiance.to_array());
    }
    contributions.clear();
}
