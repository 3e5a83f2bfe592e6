//! Adaptive sampling: which pixels get more samples.
//!
//! With a noise threshold, each tile of 8 by 8 pixels is looked at when it has 16 samples, and again whenever their number has
//! doubled. A tile whose [noise](Film::noise) is below the threshold gets no more. Nothing but the film's sums decides, at these
//! numbers of samples and whatever the passes, so the picture is the same on any number of threads and in any batches. As the
//! numbers are powers of two, the Sobol points of a pixel are a whole net wherever it stops.
//!
//! The estimate is made of the samples that it decides upon, so the picture is not quite unbiased: a tile whose samples have
//! all missed something rare and bright looks finished and stays too dark. A lower threshold makes less of it, and without one
//! there is none.

use std::ops::Range;

use brewster_film::Film;

/// The fewest samples that noise is estimated from.
const FIRST_LOOK: u32 = 16;

/// The lowest number of samples above `samples` at which tiles are looked at.
pub(crate) fn next_look(samples: u32) -> u32 {
    (samples + 1).next_power_of_two().max(FIRST_LOOK)
}

/// The runs of pixels that get sample number `sample`: of the tiles that have got all samples before it, those that are not
/// finished.
pub(crate) fn unfinished(film: &Film, sample: u32, threshold: f32) -> Vec<Range<u32>> {
    let samples = film.pixels().samples;
    let is_look = sample >= FIRST_LOOK && sample.is_power_of_two();
    let mut runs: Vec<Range<u32>> = Vec::new();
    for tile in film.order().tiles() {
        if samples[tile.start as usize] != sample || is_look && film.noise(tile.clone()) < f64::from(threshold) {
            continue;
        }
        match runs.last_mut().filter(|last| last.end == tile.start) {
            Some(last) => last.end = tile.end,
            None => runs.push(tile),
        }
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn looks_are_taken_whenever_the_samples_have_doubled() {
        let mut looks = vec![next_look(0)];
        while looks[looks.len() - 1] < 1000 {
            looks.push(next_look(looks[looks.len() - 1]));
        }
        assert_eq!(looks, [16, 32, 64, 128, 256, 512, 1024]);
        assert_eq!([1, 15, 17, 33].map(next_look), [16, 16, 32, 64]);
    }
}
