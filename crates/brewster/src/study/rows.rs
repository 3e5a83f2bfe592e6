//! From what benches counted and timed to the rows of a study's results.

use brewster::wavefront::Stage;
use brewster::wavefront::arithmetic::operations;
use brewster::wavefront::queues::RaySource;
use brewster::wavefront::survey::{LANES, Survey};
use brewster::wavefront::traffic::traffic;

use super::machine::Machine;
use super::measure::{Seconds, speedups};
use super::record::{Experiment, PolicyResult, QueueRow, StageRow};
use super::run::Bench;
use super::statistics::{Estimate, Verdict, median};
use super::subject::Subject;

/// The results of all benches but the control, which is the second one.
pub(crate) fn policy_results(
    benches: &[Bench<'_>],
    seconds: &Seconds,
    control: Option<&Estimate>,
) -> Vec<PolicyResult> {
    let places = (0..benches.len()).filter(|&place| place != 1);
    let of = |place: usize| {
        let (bench, times) = (&benches[place], &seconds[place]);
        let Subject { name, policy, of_batches, .. } = bench.subject;
        let speedup = Estimate::of(&speedups(&seconds[0], times)).filter(|_| place > 0);
        let flat: Vec<f64> = times.iter().flatten().copied().collect();
        PolicyResult {
            name: name.clone(),
            settings: bench.subject.settings(benches[0].subject),
            batch: policy.batch,
            of_batches: *of_batches || place == 0,
            queue_bytes: bench.stats.queue_bytes,
            seconds: times.clone(),
            rate: median(&flat).map(|seconds| bench.stats.rays() as f64 / seconds * 1e-6),
            speedup,
            verdict: speedup.zip(control).map(|(speedup, control)| Verdict::of(&speedup, control)),
            counted: bench.counted.clone(),
            stages: stage_rows(bench),
            queues: queue_rows(&bench.survey),
        }
    };
    places.map(of).collect()
}

fn stage_rows(bench: &Bench<'_>) -> Vec<StageRow> {
    let times = bench.renderer.stats();
    let mut rows = Vec::new();
    for (depth, at) in bench.stats.depths.iter().enumerate() {
        for (source, stage) in RaySource::ALL.into_iter().flat_map(|source| Stage::ALL.map(|stage| (source, stage))) {
            let counts = &at.counts[source as usize];
            let calls = bench.survey.depths[depth][source as usize].stages[stage as usize];
            let rays = counts.stages[stage as usize];
            // Without queues no stage is called.
            if calls.calls == 0 {
                continue;
            }
            let sort = bench.subject.policy.sort;
            let moved = traffic(stage, counts, sort);
            let time = times.depths[depth].times[source as usize][stage as usize];
            rows.push(StageRow {
                depth,
                queue: source.name(),
                stage: stage.name(),
                rays,
                calls: calls.calls,
                occupancy: rays as f64 / (calls.registers as usize * LANES).max(1) as f64,
                seconds: time.as_secs_f64() / f64::from(bench.runs.max(1)),
                read: moved.read,
                written: moved.written,
                operations: operations(stage, counts, &bench.survey.depths[depth][source as usize], sort),
            });
        }
    }
    rows
}

fn queue_rows(survey: &Survey) -> Vec<QueueRow> {
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

/// The part of the baseline's time that looks at the clock take: two for every call of a stage.
pub(crate) fn overhead(experiment: &Experiment, machine: &Machine) -> f64 {
    let Some(baseline) = experiment.policies.first() else { return 0.0 };
    let calls: u64 = baseline.stages.iter().map(|row| row.calls).sum();
    let seconds: f64 = baseline.stages.iter().map(|row| row.seconds).sum();
    if seconds > 0.0 { 2.0 * calls as f64 * machine.clock * 1e-9 / seconds } else { 0.0 }
}
