//! From what benches counted and timed to the rows of a study's results.

use brewster::wavefront::arithmetic::operations;
use brewster::wavefront::queues::RaySource;
use brewster::wavefront::survey::{LANES, Survey};
use brewster::wavefront::traffic::traffic;
use brewster::wavefront::{Stage, Stats};

use super::machine::Machine;
use super::measure::{Block, Clock};
use super::record::{PolicyResult, QueueRow, StageRow};
use super::run::Bench;
use super::statistics::{Estimate, Verdict, median};
use super::subject::Subject;

/// The results of all benches but the control, which is the second one.
pub(crate) fn policy_results(
    benches: &[Bench<'_>],
    blocks: &[Vec<Block>],
    (clock, intervals): (Clock, usize),
    (control, is_trusted): (Option<&Estimate>, bool),
    machine: &Machine,
) -> Vec<PolicyResult> {
    let places = (0..benches.len()).filter(|&place| place != 1);
    let of = |place: usize| {
        let bench = &benches[place];
        let Subject { name, policy, of_batches, .. } = bench.subject;
        let runs: Vec<f64> = match place {
            0 => blocks.iter().flatten().flat_map(|block| block.baseline).map(|took| took.on(clock)).collect(),
            _ => blocks[place].iter().flat_map(|block| block.own).map(|took| took.on(clock)).collect(),
        };
        let of_blocks = |clock| speedup(&blocks[place], clock, intervals);
        let speedup = if place > 0 { of_blocks(clock) } else { None };
        PolicyResult {
            name: name.clone(),
            settings: bench.subject.settings(benches[0].subject),
            batch: policy.batch,
            of_batches: *of_batches || place == 0,
            queue_bytes: bench.stats.queue_bytes,
            // The baseline's are those of its control.
            blocks: blocks.get(place.max(1)).cloned().unwrap_or_default(),
            rate: median(&runs).map(|seconds| bench.stats.rays() as f64 / seconds * 1e-6),
            speedup,
            verdict: speedup.zip(control).map(|(speedup, control)| Verdict::of(&speedup, control, is_trusted)),
            wall_speedup: if place > 0 && clock != Clock::Wall { of_blocks(Clock::Wall) } else { None },
            counted: bench.counted.clone(),
            stages: stage_rows(bench.subject, (&bench.stats, &bench.survey), (&bench.times, bench.runs), machine),
            queues: queue_rows(&bench.survey),
        }
    };
    places.map(of).collect()
}

/// How many times as fast as the baseline, in the median block.
pub(crate) fn speedup(blocks: &[Block], clock: Clock, intervals: usize) -> Option<Estimate> {
    let speedups: Vec<f64> = blocks.iter().map(|block| block.speedup(clock)).collect();
    Estimate::of(&speedups, intervals)
}

/// What stages did, from what was counted and from the times of some runs without a survey.
pub(crate) fn stage_rows(
    subject: &Subject,
    (stats, survey): (&Stats, &Survey),
    (times, runs): (&Stats, u32),
    machine: &Machine,
) -> Vec<StageRow> {
    let bandwidth = machine.bandwidth_at(stats.queue_bytes);
    let mut rows = Vec::new();
    for (depth, at) in stats.depths.iter().enumerate() {
        for (source, stage) in RaySource::ALL.into_iter().flat_map(|source| Stage::ALL.map(|stage| (source, stage))) {
            let counts = &at.counts[source as usize];
            let surveyed = &survey.depths[depth][source as usize];
            let calls = surveyed.stages[stage as usize];
            let rays = counts.stages[stage as usize];
            // Without queues no stage is called.
            if calls.calls == 0 {
                continue;
            }
            let sort = subject.policy.sort;
            let moved = traffic(stage, counts, sort);
            let time = times.depths[depth].times[source as usize][stage as usize];
            let seconds = time.as_secs_f64() / f64::from(runs.max(1));
            let operations = operations(stage, counts, surveyed, sort);
            let intensity = operations as f64 / moved.total().max(1) as f64;
            rows.push(StageRow {
                depth,
                queue: source.name(),
                stage: stage.name(),
                rays,
                calls: calls.calls,
                occupancy: rays as f64 / (calls.registers as usize * LANES).max(1) as f64,
                seconds,
                read: moved.read,
                written: moved.written,
                operations,
                rate: if seconds > 0.0 { 1e-9 * operations as f64 / seconds } else { 0.0 },
                roof: machine.arithmetic.min(intensity * bandwidth),
            });
        }
    }
    rows
}

/// What queues looked like.
pub(crate) fn queue_rows(survey: &Survey) -> Vec<QueueRow> {
    let mut rows = Vec::new();
    for (depth, at) in survey.depths.iter().enumerate() {
        for (seen, source) in at.iter().zip(RaySource::ALL).filter(|(seen, _)| seen.rays > 0) {
            let longest = seen.lengths.iter().rposition(|&times| times > 0).map_or(0, |place| place + 1);
            let rays = seen.rays as f64;
            let [nodes, instances, primitives] = seen.visits.map(|visits| visits as f64 / rays);
            let [shadow_nodes, shadow_instances, shadow_primitives] =
                seen.shadow_visits.map(|visits| visits as f64 / seen.shadow_rays.max(1) as f64);
            rows.push(QueueRow {
                depth,
                queue: source.name(),
                rays: seen.rays,
                taken: seen.taken,
                lengths: seen.lengths[..longest].to_vec(),
                octant_run: rays / seen.octant_runs.max(1) as f64,
                material_run: rays / seen.material_runs.max(1) as f64,
                nodes,
                instances,
                primitives,
                shadow_rays: seen.shadow_rays,
                shadow_nodes,
                shadow_instances,
                shadow_primitives,
            });
        }
    }
    rows
}

/// The largest part of a policy's time that looks at the clock take: two for every call of a stage.
pub(crate) fn overhead(policies: &[PolicyResult], machine: &Machine) -> f64 {
    let of = |policy: &PolicyResult| {
        let calls: u64 = policy.stages.iter().map(|row| row.calls).sum();
        let seconds: f64 = policy.stages.iter().map(|row| row.seconds).sum();
        if seconds > 0.0 { 2.0 * calls as f64 * machine.clock * 1e-9 / seconds } else { 0.0 }
    };
    policies.iter().map(of).fold(0.0, f64::max)
}
