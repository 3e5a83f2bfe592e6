//! Adds finished samples to the film.

use brewster_film::FilmTile;

use crate::queues::{Sample, SamplesView};

/// Adds all samples to their pixels.
///
/// Reads: samples. Writes: the film's colors, squares and numbers of samples, rays and contributions that were no light.
pub fn fold(samples: SamplesView<'_>, tile: &mut FilmTile<'_>) {
    for row in 0..samples.len() {
        fold_one(&samples.get(row), tile);
    }
}

/// Adds one sample to its pixel.
#[inline(always)]
pub(crate) fn fold_one(sample: &Sample, tile: &mut FilmTile<'_>) {
    tile.add_sample(sample.pixel, sample.light);
    tile.add_rays(sample.pixel, sample.rays);
    tile.add_rejected(sample.pixel, sample.rejected);
}
