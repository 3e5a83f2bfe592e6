//! Sets of parameters, which change pictures, compared by the noise that is left after equal time.

use std::path::Path;

use brewster::buffers::SceneBuffers;
use brewster::film::Film;
use brewster::import::study::{self, Study};

use super::measure::{Block, Clock, Side, Took, in_turn};
use super::record::{ParameterResult, Quality};
use super::run::{Watch, load, render, renderer, scene_name, unless_interrupted};
use super::statistics::{Difference, Estimate, Verdict, are_enough, median};
use super::subject::{Subject, intervals};
use crate::commands::Failure;

/// What a round of a set came to: its two runs and those of the first set, and the pictures of either.
struct Round {
    block: Block,
    /// Linear pixels, of the first set and its own.
    pictures: [[Vec<f32>; 2]; 2],
}

impl Round {
    /// Variance of pixels, the first set's and its own.
    fn variances(&self) -> [f64; 2] {
        self.pictures.each_ref().map(|[a, b]| variance(a, b))
    }

    /// Efficiency, the first set's and its own.
    fn efficiencies(&self, clock: Clock) -> [f64; 2] {
        let seconds = [self.block.baseline, self.block.own].map(|[a, b]| a.on(clock) + b.on(clock));
        std::array::from_fn(|side| 2.0 / (self.variances()[side] * seconds[side]))
    }
}

/// Renders a scene with every set of parameters in turn, by the baseline's policy, with new seeds in every run.
pub(crate) fn quality(
    study: &Study,
    scene: &Path,
    subjects: &[Subject],
    watch: &Watch<'_>,
) -> Result<Quality, Failure> {
    let name = scene_name(scene);
    let sessions: Result<Vec<_>, _> =
        study.parameters.iter().map(|parameters| load(study, scene, parameters)).collect();
    let mut scenes: Vec<SceneBuffers> = sessions?.iter().map(|session| session.buffers().clone()).collect();
    scenes.insert(1, scenes[0].clone());
    let rounds = in_turn(scenes.len(), study.rounds, watch.stop, |place, round| {
        let parameters = &study.parameters[place - 1].name;
        (watch.step)(format!("{name}: round {} of {}, {parameters}", round + 1, study.rounds));
        let mut pictures: [[Vec<f32>; 2]; 2] = Default::default();
        let block = Block::run(|side, again| {
            let own = if side == Side::Own { place } else { 0 };
            let buffers = &mut scenes[own];
            // Every block draws numbers of its own; the control sees what the first set sees.
            let branch = 2 * place as u64 + u64::from(own > 1);
            buffers.settings.seed = branch << 32 | u64::from(2 * round) | u64::from(again);
            // Photons that guide paths are sent before the picture.
            let (mut renderer, before) = Took::by(|| renderer(buffers, &subjects[0], false))?;
            for _ in 0..study.warm_up {
                render(&mut renderer, buffers, watch.control)?;
            }
            let (film, took) = render(&mut renderer, buffers, watch.control)?;
            pictures[side as usize][usize::from(again)] = pixels(&film);
            Ok::<Took, Failure>(before.and(took))
        });
        Ok::<_, Failure>(unless_interrupted(block)?.map(|block| Round { block, pictures }))
    })?;
    if rounds[1].iter().any(|Round { pictures: [first, twin], .. }| first != twin) {
        return Err(Failure::Input(format!("{name}: the same seeds gave other pictures; the study fails")));
    }
    let width = scenes[0].settings.resolution.x as usize;
    let clock = if subjects[0].threads == 1 { Clock::Processor } else { Clock::Wall };
    Ok(quality_of(study, name, &rounds, (clock, intervals(study, subjects)), width))
}

/// `rounds` are those of every set, behind the control's.
fn quality_of(
    study: &Study,
    scene: String,
    rounds: &[Vec<Round>],
    (clock, intervals): (Clock, usize),
    width: usize,
) -> Quality {
    let ratio = |rounds: &[Round]| {
        let ratios = rounds.iter().map(|round| round.efficiencies(clock)).map(|[first, own]| own / first);
        let ratios: Vec<f64> = ratios.collect();
        // Without noise there is nothing to compare.
        Estimate::of(&ratios, intervals).filter(|_| ratios.iter().all(|ratio| ratio.is_finite()))
    };
    let blocks = |rounds: &[Round], side: usize| -> Vec<Vec<f64>> {
        rounds.iter().flat_map(|round| &round.pictures[side]).map(|pixels| block_means(pixels, width)).collect()
    };
    let control = ratio(&rounds[1]);
    let trusted = are_enough(rounds[1].len(), intervals) && control.is_some_and(|control| control.is_even());
    let parameters = study.parameters.iter().zip(&rounds[1..]).enumerate().map(|(number, (parameters, rounds))| {
        let ratio = ratio(rounds).filter(|_| number > 0);
        let own: Vec<f64> = rounds.iter().map(|round| round.efficiencies(clock)[1]).collect();
        let difference = match number {
            0 => Difference::default(),
            _ => Difference::between(&blocks(rounds, 1), &blocks(rounds, 0)),
        };
        let trusted = trusted && difference.is_known();
        ParameterResult {
            name: parameters.name.clone(),
            settings: parameter_settings(parameters),
            blocks: rounds.iter().map(|round| round.block).collect(),
            variances: rounds.iter().map(Round::variances).collect(),
            efficiency: median(&own).filter(|efficiency| efficiency.is_finite()),
            ratio,
            verdict: ratio.zip(control).map(|(ratio, control)| Verdict::of(&ratio, &control, trusted)),
            z: difference.z,
            events: difference.events,
            events_needed: (number > 0).then_some(difference.needed),
        }
    });
    Quality { scene, rounds: rounds[1].len(), clock, control, trusted, parameters: parameters.collect() }
}

fn parameter_settings(parameters: &study::Parameters) -> String {
    let study::Parameters { integrator, split_depth, guiding, samples, max_depth, .. } = parameters;
    let entries = [
        integrator.map(|integrator| format!("{integrator:?}")),
        split_depth.map(|depth| format!("split depth {depth}")),
        guiding.map(|guides| if guides { "guided" } else { "not guided" }.to_owned()),
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
    use brewster::import::study::load_study_text;
    use brewster::wavefront::Control;

    use super::*;
    use crate::study::subjects;

    /// By hand: differences of 2 and 0 over two values have the mean square 2, halved.
    #[test]
    fn two_pictures_tell_their_variance() {
        assert_eq!(variance(&[1.0, 5.0], &[3.0, 5.0]), 1.0);
        let pixels: Vec<f32> = (0..9 * 3).map(|value| (value / 3) as f32).collect();
        assert_eq!(block_means(&pixels, 9), [3.5, 8.0]);
    }

    fn guided_and_not(scene: &str) -> ParameterResult {
        let text = format!(
            "Study(name: \"n\", scenes: [{scene:?}], resolution: (48, 32), samples: 4, rounds: 7, warm_up: 0,
                parameters: {{ \"as they scatter\": (guiding: false), \"guided\": (guiding: true) }})"
        );
        let study = load_study_text(Path::new("study.ron"), &text).unwrap_or_else(|failure| panic!("{failure}")).0;
        let subjects = subjects(&study).unwrap_or_else(|failure| panic!("{failure:?}"));
        let control = Control::default();
        let watch = Watch { stop: &|| false, control: &control, step: &|_| () };
        let found = quality(&study, &study.scenes[0], &subjects, &watch);
        found.unwrap_or_else(|failure| panic!("{failure:?}")).parameters.remove(1)
    }

    /// A small lamp seen by way of glass, which four samples hardly ever find, and a sky, which they always do. Both sets are right.
    #[test]
    fn light_that_hardly_a_path_finds_is_not_judged() {
        let found = guided_and_not("../../tests/scenes/caustics.ron");
        assert_eq!((found.verdict, found.z), (Some(Verdict::Untrusted), None));
        let doubt = found.doubt().expect("its spread is not known");
        assert!(doubt.contains("times the samples"), "{doubt}");
        assert!(found.events < found.events_needed, "{found:?}");
        let found = guided_and_not("../../tests/references/glass-on-checker.ron");
        assert!(found.doubt().is_none() && found.z.is_some_and(|z| z.abs() < 3.5), "{found:?}");
    }
}
