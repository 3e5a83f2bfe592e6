//! Sets of parameters, which change pictures, compared by the noise that is left after equal time.

use std::path::Path;

use brewster::buffers::SceneBuffers;
use brewster::film::Film;
use brewster::import::study::{self, Study};

use super::measure::{Seconds, interleave};
use super::record::{ParameterResult, Quality};
use super::run::{Watch, load, render, renderer, scene_name};
use super::statistics::{Estimate, Verdict, block_z, median};
use super::subject::Subject;
use crate::commands::Failure;

/// Renders a scene with every set of parameters in turn, by the baseline's policy, with new seeds in every run.
pub(crate) fn quality(study: &Study, scene: &Path, subject: &Subject, watch: &Watch<'_>) -> Result<Quality, Failure> {
    let name = scene_name(scene);
    let sessions: Result<Vec<_>, _> =
        study.parameters.iter().map(|parameters| load(study, scene, parameters)).collect();
    let mut scenes: Vec<SceneBuffers> = sessions?.iter().map(|session| session.buffers().clone()).collect();
    scenes.insert(1, scenes[0].clone());
    // Pictures of every subject, two a round, as linear pixels.
    let mut pictures: Vec<Vec<[Vec<f32>; 2]>> = vec![Vec::new(); scenes.len()];
    let seconds = interleave(scenes.len(), study.warm_up, study.rounds, watch.stop, |place, turn| {
        let parameters = &study.parameters[place.saturating_sub(1)].name;
        let round = turn.round.map_or("warm-up".to_owned(), |round| format!("round {} of {}", round + 1, study.rounds));
        (watch.step)(format!("{name}: {round}, {parameters}"));
        let buffers = &mut scenes[place];
        // The control sees what the first set sees; all others draw numbers of their own.
        let own = if place > 1 { place as u64 } else { 0 };
        buffers.settings.seed = own << 32 | u64::from(2 * turn.round.unwrap_or(0)) | u64::from(turn.back);
        let picture = render(&mut renderer(buffers, subject, false)?, buffers)?;
        if let Some(round) = turn.round {
            let pixels = pixels(&picture.film);
            let rounds = &mut pictures[place];
            rounds.resize(round as usize + 1, Default::default());
            rounds[round as usize][usize::from(turn.back)] = pixels;
        }
        Ok::<f64, Failure>(picture.seconds)
    })?;
    let rounds = seconds.first().map_or(0, Vec::len);
    pictures.iter_mut().for_each(|all| all.truncate(rounds));
    if pictures[0] != pictures[1] {
        return Err(Failure::Input(format!("{name}: the same seeds gave other pictures; the study fails")));
    }
    let width = scenes[0].settings.resolution.x as usize;
    Ok(quality_of(study, name, &seconds, &pictures, width))
}

fn quality_of(
    study: &Study,
    scene: String,
    seconds: &Seconds,
    pictures: &[Vec<[Vec<f32>; 2]>],
    width: usize,
) -> Quality {
    let variances: Vec<Vec<f64>> =
        pictures.iter().map(|rounds| rounds.iter().map(|[a, b]| variance(a, b)).collect()).collect();
    let efficiencies = |place: usize| -> Vec<f64> {
        let rounds = variances[place].iter().zip(&seconds[place]);
        rounds.map(|(variance, [forward, back])| 2.0 / (variance * (forward + back))).collect()
    };
    let ratio = |place: usize| {
        let ratios: Vec<f64> = efficiencies(place).iter().zip(efficiencies(0)).map(|(a, b)| a / b).collect();
        // Without noise there is nothing to compare.
        Estimate::of(&ratios).filter(|_| ratios.iter().all(|ratio| ratio.is_finite()))
    };
    let blocks = |place: usize| -> Vec<Vec<f64>> {
        pictures[place].iter().flatten().map(|pixels| block_means(pixels, width)).collect()
    };
    let first = blocks(0);
    let control = ratio(1);
    let parameters = study.parameters.iter().enumerate().map(|(number, parameters)| {
        let place = if number == 0 { 0 } else { number + 1 };
        let ratio = ratio(place).filter(|_| number > 0);
        ParameterResult {
            name: parameters.name.clone(),
            settings: parameter_settings(parameters),
            seconds: seconds[place].clone(),
            variances: variances[place].clone(),
            efficiency: median(&efficiencies(place)).filter(|efficiency| efficiency.is_finite()),
            ratio,
            verdict: ratio.zip(control).map(|(ratio, control)| Verdict::of(&ratio, &control)),
            z: if number > 0 { block_z(&blocks(place), &first) } else { None },
        }
    });
    Quality {
        scene,
        rounds: seconds[0].len(),
        control,
        trusted: control.is_some_and(|control| control.is_even()),
        parameters: parameters.collect(),
    }
}

fn parameter_settings(parameters: &study::Parameters) -> String {
    let study::Parameters { integrator, split_depth, samples, max_depth, .. } = parameters;
    let entries = [
        integrator.map(|integrator| format!("{integrator:?}")),
        split_depth.map(|depth| format!("split depth {depth}")),
        samples.map(|samples| format!("{samples} samples")),
        max_depth.map(|depth| format!("depth {depth}")),
    ];
    let entries: Vec<String> = entries.into_iter().flatten().collect();
    if entries.is_empty() { "as the scene says".to_owned() } else { entries.join(", ") }
}

/// Linear radiance, channel by channel, row by row.
fn pixels(film: &Film) -> Vec<f32> {
    film.resolve().image().color.into_iter().flatten().collect()
}

/// The variance of a pixel's channel, from two pictures with different seeds: half the mean squared difference.
fn variance(a: &[f32], b: &[f32]) -> f64 {
    let squares: f64 = a.iter().zip(b).map(|(a, b)| f64::from(a - b).powi(2)).sum();
    0.5 * squares / a.len().max(1) as f64
}

/// Pixels along the side of a block.
const BLOCK: usize = 8;

/// Mean radiance of every block of pixels, of all channels together.
fn block_means(pixels: &[f32], width: usize) -> Vec<f64> {
    let (across, height) = (width.div_ceil(BLOCK), pixels.len() / 3 / width);
    let mut sums = vec![(0.0, 0.0); across * height.div_ceil(BLOCK)];
    for (row, pixel) in pixels.chunks_exact(3).enumerate() {
        let (x, y) = (row % width, row / width);
        let (sum, count) = &mut sums[y / BLOCK * across + x / BLOCK];
        *sum += pixel.iter().map(|&value| f64::from(value)).sum::<f64>() / 3.0;
        *count += 1.0;
    }
    sums.into_iter().map(|(sum, count)| sum / count).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand: differences of 2 and 0 over two values have the mean square 2, halved.
    #[test]
    fn two_pictures_tell_their_variance() {
        assert_eq!(variance(&[1.0, 5.0], &[3.0, 5.0]), 1.0);
        let pixels: Vec<f32> = (0..9 * 3).map(|value| (value / 3) as f32).collect();
        assert_eq!(block_means(&pixels, 9), [3.5, 8.0]);
    }
}
