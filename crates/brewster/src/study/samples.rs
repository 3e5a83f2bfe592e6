//! What the baseline did sample by sample: passes of one sample of every pixel, each counted by one renderer and timed by another.

use brewster::buffers::SceneBuffers;
use brewster::wavefront::stats::DepthStats;
use brewster::wavefront::{Counts, Stats};

use super::machine::Machine;
use super::record::SampleRecord;
use super::rows::{queue_rows, stage_rows};
use super::run::{Expected, Watch, check_picture, empty_film, render, renderer, unless_interrupted};
use super::subject::Subject;
use crate::commands::Failure;

/// Records at most; of more samples than that, neighbors share one.
const MOST: u32 = 256;

/// Renders a scene once more, sample by sample, and checks that the picture is the expected one and that rays add up to those of all
/// samples. A stop ends it after a whole sample.
///
/// Rays, bytes and operations are those of every policy, but for the names of merged queues and what a sort moves; calls, lanes and
/// runs are those of batches filled by one sample of their pixels. Where the baseline has no queues there is nothing to record.
pub(crate) fn samples_apart(
    scene: &str,
    (subject, buffers): (&Subject, &SceneBuffers),
    (picture, counts): &Expected,
    machine: &Machine,
    watch: &Watch<'_>,
) -> Result<Vec<SampleRecord>, Failure> {
    (watch.step)(format!("{scene}: sample by sample"));
    let (mut records, settings) = (Vec::new(), &buffers.settings);
    if (watch.stop)() {
        return Ok(records);
    }
    let mut films = [empty_film(buffers)?, empty_film(buffers)?];
    let [mut counting, mut timed] = [renderer(buffers, subject, true)?, renderer(buffers, subject, false)?];
    // So that the first sample finds queues as large as the others do.
    if unless_interrupted(render(&mut timed, buffers, watch.control))?.is_none() {
        return Ok(records);
    }
    let mut sum = Stats::new(settings.max_depth);
    let step = settings.samples.div_ceil(MOST);
    for sample in (0..settings.samples).step_by(step as usize) {
        if (watch.stop)() {
            return Ok(records);
        }
        let end = settings.samples.min(sample + step);
        for (renderer, film) in [&mut counting, &mut timed].into_iter().zip(&mut films) {
            renderer.restart_stats();
            if !renderer.pass(sample..end, film, watch.control) {
                return Ok(records);
            }
        }
        let (stats, survey) = (counting.stats(), counting.survey().expect("one was asked for"));
        sum.add(&stats);
        records.push(SampleRecord {
            sample,
            samples: end - sample,
            stages: stage_rows(subject, (&stats, &survey), (&timed.stats(), 1), machine),
            queues: queue_rows(&survey),
        });
    }
    films.iter().try_for_each(|film| check_picture(scene, subject, picture, film))?;
    let totals: Vec<Counts> = sum.depths.iter().map(DepthStats::total).collect();
    if totals != *counts {
        return Err(Failure::Input(format!("{scene}: the rays of single samples do not add up to those of all")));
    }
    Ok(records)
}
