//! Adds finished samples to the film.

use brewster_film::FilmTile;

use crate::queues::SamplesView;

/// Adds all samples to their pixels.
///
/// Reads: samples. Writes: the film's colors, squares and numbers of samples, rays and contributions that were no light.
pub fn fold(samples: SamplesView<'_>, tile: &mut FilmTile<'_>) {
    for (row, &pixel) in samples.pixel.iter().enumerate() {
        tile.add_sample(pixel, samples.light[row]);
        tile.add_rays(pixel, samples.rays[row]);
        tile.add_rejected(pixel, samples.rejected[row]);
    }
}
