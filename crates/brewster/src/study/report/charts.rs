//! The charts of a report.

use super::super::record::{Experiment, PolicyResult, Quality, Results, StageRow};
use super::super::statistics::{Estimate, Verdict};
use super::Chart;
use crate::plot::{Anchor, Axis, Diagram, Frame, INK, Ink, Pen};

const GRAY: Ink = Ink(0x77, 0x77, 0x77);
const BLUE: Ink = Ink(0x1f, 0x6f, 0xb4);
const CYAN: Ink = Ink(0x12, 0x8a, 0x9c);
const ORANGE: Ink = Ink(0xd9, 0x79, 0x06);
const GREEN: Ink = Ink(0x4d, 0x8f, 0x2c);
const RED: Ink = Ink(0xc0, 0x39, 0x2b);
const VIOLET: Ink = Ink(0x6f, 0x4f, 0xa8);
const PINK: Ink = Ink(0xb4, 0x50, 0x8c);
const BROWN: Ink = Ink(0x8a, 0x67, 0x2a);

/// Of a page: words on it, of 14, can be read on a phone that shows its whole width.
const WIDTH: u32 = 560;
/// The right edge of frames.
const RIGHT: f32 = 536.0;
/// The left edge of frames with names of rows beside them.
const NAMED: f32 = 186.0;

/// Stages that are drawn as one, with their color.
pub(super) const GROUPS: [(&str, Ink, &[&str]); 9] = [
    ("generate", GRAY, &["generate"]),
    ("order", BROWN, &["order"]),
    ("trace", BLUE, &["trace"]),
    ("absorb, fly", CYAN, &["absorb", "fly"]),
    ("sort", ORANGE, &["sort"]),
    ("escape, cross, record", GREEN, &["escape", "cross", "record"]),
    ("shade, scatter", RED, &[]),
    ("shadow", VIOLET, &["shadow"]),
    ("gather, fold", PINK, &["gather", "fold"]),
];

/// The group of a stage: shading where no other names it.
pub(super) fn group(stage: &str) -> usize {
    GROUPS.iter().position(|(_, _, stages)| stages.contains(&stage)).unwrap_or(6)
}

/// All charts, in the order of the report.
pub(crate) fn charts(results: &Results) -> Vec<Chart> {
    let mut charts = Vec::new();
    for experiment in &results.experiments {
        let section = experiment.title();
        let mut add = |name: &str, caption: &str, diagram: Option<Diagram>| {
            charts.extend(diagram.map(|diagram| Chart {
                name: format!("{section} {name}"),
                section: section.clone(),
                caption: caption.to_owned(),
                diagram,
            }));
        };
        add(
            "policies",
            "How many times as fast as the baseline: medians and intervals, as wide as the study's number of comparisons asks for. Gray: no difference seen, or not judged. The band is what the baseline \
             shows against itself.",
            policies(experiment),
        );
        add(
            "batches",
            "Throughput against rays in a batch. Dashed: where a batch's queues fill a cache.",
            batches(experiment, results),
        );
        let Some(baseline) = experiment.policies.first() else { continue };
        add("time per bounce", "Time of the baseline by bounce and stage.", time_per_bounce(baseline));
        add("queues", "Rays traced at every bounce, by the queue they came from.", population(baseline));
        add(
            "queue lengths",
            "How long queues were when they were traced: the share of the times, over all bounces. Short ones fill registers in part.",
            lengths(baseline),
        );
        add(
            "roofline",
            "Every stage's operations on numbers, counted by hand from its source, against how many there are for a byte of its queues. \
             Lines: what memory of a level and the arithmetic of one thread let through. Stages far below wait for something else: trees, \
             textures, branches.",
            roofline(baseline, results),
        );
    }
    for quality in &results.qualities {
        charts.extend(efficiencies(quality).map(|diagram| Chart {
            name: format!("{} efficiency", quality.scene),
            section: quality.scene.clone(),
            caption: "1/(variance x seconds) over that of the first set: how much sooner a picture of the same noise is there.".to_owned(),
            diagram,
        }));
    }
    charts
}

/// Rows of estimates around 1, with what the control's band covers.
fn forest(name: &str, rows: &[(&str, Estimate, Option<Verdict>)], control: Option<Estimate>) -> Option<Diagram> {
    let shown = rows.iter().map(|(_, estimate, _)| *estimate).chain(control);
    let (low, high) =
        shown.fold((0.95f64, 1.05f64), |(low, high), estimate| (low.min(estimate.low), high.max(estimate.high)));
    if rows.is_empty() || !(low > 0.0 && high.is_finite()) {
        return None;
    }
    let height = 34.0 * rows.len() as f32;
    let mut page = Diagram::new([WIDTH, (height + 110.0) as u32]);
    let spread = (high / low).ln();
    let steps: &[f64] = match spread {
        spread if spread < 0.25 => &[0.8, 0.85, 0.9, 0.95, 1.0, 1.05, 1.1, 1.15, 1.2, 1.25],
        spread if spread < 1.2 => &[0.25, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.2, 1.4, 1.6, 2.0, 3.0],
        _ => &[0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0],
    };
    let (low, high) = (low / (0.06 * spread).exp(), high * (0.06 * spread).exp());
    let ticks = steps.iter().filter(|&&step| (low..=high).contains(&step)).map(|&step| (step, format!("{step}")));
    let x = Axis { name: name.to_owned(), range: [low, high], is_log: true, ticks: ticks.collect() };
    let y = Axis { name: String::new(), range: [0.0, rows.len() as f64], is_log: false, ticks: Vec::new() };
    let frame = Frame { edges: [NAMED, 24.0, RIGHT, 24.0 + height], x, y };
    if let Some(control) = control {
        let [from, to] = [frame.place(control.low, 0.0), frame.place(control.high, rows.len() as f64)];
        page.block(from, [to[0].max(from[0] + 1.0), to[1]], BAND);
    }
    frame.draw(&mut page);
    page.line(
        [0.0, rows.len() as f64].map(|y| frame.place(1.0, y)).to_vec(),
        Pen { ink: INK, width: 1.2, dash: &[4.0, 4.0] },
    );
    for (row, (name, estimate, verdict)) in rows.iter().enumerate() {
        let y = rows.len() as f64 - row as f64 - 0.5;
        let ink = match verdict {
            Some(Verdict::Better) => GREEN,
            Some(Verdict::Worse) => RED,
            _ => GRAY,
        };
        let [low, middle, high] = [estimate.low, estimate.median, estimate.high].map(|x| frame.place(x, y));
        page.line(vec![low, high], Pen { ink, width: 3.0, dash: &[] });
        page.dot(middle, 5.5, ink);
        page.word(shortened(name, 22), [NAMED - 10.0, middle[1] + 5.0], 14.0, Anchor::End, INK);
    }
    Some(page)
}

/// The ground of the control's band.
const BAND: Ink = Ink(0xe8, 0xe8, 0xee);

fn shortened(text: &str, most: usize) -> String {
    match text.chars().count() > most {
        true => text.chars().take(most - 1).chain(['…']).collect(),
        false => text.to_owned(),
    }
}

fn policies(experiment: &Experiment) -> Option<Diagram> {
    let rows =
        experiment.policies.iter().filter_map(|policy| Some((policy.name.as_str(), policy.speedup?, policy.verdict)));
    forest("times as fast as the baseline", &rows.collect::<Vec<_>>(), experiment.control)
}

fn efficiencies(quality: &Quality) -> Option<Diagram> {
    let rows = quality.parameters.iter().filter_map(|set| Some((set.name.as_str(), set.ratio?, set.verdict)));
    forest("times as efficient as the first set", &rows.collect::<Vec<_>>(), quality.control)
}

/// Throughput against batch size.
fn batches(experiment: &Experiment, results: &Results) -> Option<Diagram> {
    let mut points: Vec<(&PolicyResult, f64)> =
        experiment.policies.iter().filter(|policy| policy.of_batches).filter_map(|p| Some((p, p.rate?))).collect();
    points.sort_by_key(|(policy, _)| policy.batch);
    let ((first, _), (last, _)) = (points.first()?, points.last()?);
    if points.len() < 3 {
        return None;
    }
    let mut page = Diagram::new([WIDTH, 380]);
    let ends = [first.batch as f64, last.batch as f64];
    let x = Axis::factors("rays in a batch", 2.0, ends, |rays| count(rays as u64));
    let most = points.iter().map(|(_, rate)| *rate).fold(0.0, f64::max);
    let frame = Frame { edges: [64.0, 40.0, RIGHT, 320.0], x, y: Axis::up_to("Mrays/s", most) };
    frame.draw(&mut page);
    for cache in &results.machine.caches {
        if let Some(rays) =
            rays_that_fill(&points, cache.bytes as f64).filter(|rays| (ends[0]..=ends[1]).contains(rays))
        {
            let [top, bottom] = [frame.y.range[1], 0.0].map(|y| frame.place(rays, y));
            page.line(vec![top, bottom], Pen { ink: ORANGE, width: 1.6, dash: &[6.0, 4.0] });
            page.word(format!("L{}", cache.level), [top[0] + 5.0, top[1] + 14.0], 14.0, Anchor::Start, ORANGE);
        }
    }
    let places: Vec<[f32; 2]> = points.iter().map(|(policy, rate)| frame.place(policy.batch as f64, *rate)).collect();
    page.line(places.clone(), Pen { ink: BLUE, width: 2.0, dash: &[] });
    places.into_iter().for_each(|place| page.dot(place, 4.5, BLUE));
    Some(page)
}

/// The batch whose queues take so many bytes, between those that were measured, along a straight line of logarithms.
fn rays_that_fill(points: &[(&PolicyResult, f64)], bytes: f64) -> Option<f64> {
    points.windows(2).find_map(|pair| {
        let [(a, _), (b, _)] = pair else { return None };
        let (low, high) = (a.queue_bytes as f64, b.queue_bytes as f64);
        let part = (bytes / low).ln() / (high / low).ln();
        let (from, to) = (a.batch as f64, b.batch as f64);
        (low <= bytes && bytes < high).then(|| from * (to / from).powf(part))
    })
}

/// Horizontal bars, one a bounce, of what stages took.
fn time_per_bounce(baseline: &PolicyResult) -> Option<Diagram> {
    let bounces = baseline.stages.iter().map(|row| row.depth + 1).max()?;
    let mut times = vec![[0.0f64; GROUPS.len()]; bounces];
    for row in &baseline.stages {
        times[row.depth][group(row.stage)] += 1e3 * row.seconds;
    }
    let most = times.iter().map(|stages| stages.iter().sum::<f64>()).fold(0.0, f64::max);
    if most <= 0.0 {
        return None;
    }
    let height = 26.0 * bounces as f32;
    let mut page = Diagram::new([WIDTH, (height + 160.0) as u32]);
    let ticks = (0..bounces).map(|depth| (bounces as f64 - depth as f64 - 0.5, depth.to_string())).collect();
    let y = Axis { name: "bounce".to_owned(), range: [0.0, bounces as f64], is_log: false, ticks };
    let frame = Frame { edges: [64.0, 96.0, RIGHT, 96.0 + height], x: Axis::up_to("ms a picture", most), y };
    frame.draw(&mut page);
    for (depth, stages) in times.iter().enumerate() {
        let (mut sum, middle) = (0.0, bounces as f64 - depth as f64 - 0.5);
        for ((_, ink, _), time) in GROUPS.iter().zip(stages).filter(|(_, time)| **time > 0.0) {
            let ([left, y], [right, _]) = (frame.place(sum, middle), frame.place(sum + time, middle));
            page.block([left, y - 9.0], [right, y + 9.0], *ink);
            sum += time;
        }
    }
    legend(&mut page, GROUPS.iter().map(|(name, ink, _)| (*name, *ink)));
    Some(page)
}

/// Colored names in rows of three at the top.
fn legend<'n>(page: &mut Diagram, entries: impl Iterator<Item = (&'n str, Ink)>) {
    for (place, (name, ink)) in entries.enumerate() {
        let (x, y) = (24.0 + 178.0 * (place % 3) as f32, 12.0 + 22.0 * (place / 3) as f32);
        page.block([x, y - 6.0], [x + 12.0, y + 6.0], ink);
        page.word(name, [x + 18.0, y + 5.0], 14.0, Anchor::Start, INK);
    }
}

const QUEUES: [(&str, Ink); 4] =
    [("primary", GRAY), ("reflection", BLUE), ("transmission", ORANGE), ("merged", VIOLET)];

/// Groups of columns, one a bounce, of the rays of each queue.
fn population(baseline: &PolicyResult) -> Option<Diagram> {
    let bounces = baseline.queues.iter().map(|row| row.depth + 1).max()?;
    let most = baseline.queues.iter().map(|row| row.rays).max()? as f64;
    let (unit, name) = if most >= 1e6 { (1e6, "million rays") } else { (1e3, "thousand rays") };
    let mut page = Diagram::new([WIDTH, 380]);
    let ticks = (0..bounces).map(|depth| (depth as f64 + 0.5, depth.to_string())).collect();
    let x = Axis { name: "bounce".to_owned(), range: [0.0, bounces as f64], is_log: false, ticks };
    let frame = Frame { edges: [64.0, 66.0, RIGHT, 320.0], x, y: Axis::up_to(name, most / unit) };
    frame.draw(&mut page);
    for row in &baseline.queues {
        let Some(queue) = QUEUES.iter().position(|(name, _)| *name == row.queue) else { continue };
        // Camera rays and merged ones stand in the middle, the others side by side.
        let shift = [-0.2, -0.4, 0.0, -0.2][queue];
        let left = frame.place(row.depth as f64 + 0.5 + shift, row.rays as f64 / unit);
        let right = frame.place(row.depth as f64 + 0.5 + shift + 0.38, 0.0);
        page.block(left, right, QUEUES[queue].1);
    }
    let used = QUEUES.into_iter().filter(|(name, _)| baseline.queues.iter().any(|row| row.queue == *name));
    legend(&mut page, used);
    Some(page)
}

/// Columns for queues of 1, 2 to 3, 4 to 7 rays, and so on: how often each was traced.
fn lengths(baseline: &PolicyResult) -> Option<Diagram> {
    let buckets = baseline.queues.iter().map(|row| row.lengths.len()).max()?;
    let shares = QUEUES.map(|(name, _)| {
        let rows = || baseline.queues.iter().filter(|row| row.queue == name);
        let times: u64 = rows().map(|row| row.taken).sum();
        let share = |bucket: usize| {
            let traced: u64 = rows().filter_map(|row| row.lengths.get(bucket)).sum();
            100.0 * traced as f64 / times.max(1) as f64
        };
        (0..buckets).map(share).collect::<Vec<f64>>()
    });
    let most = shares.iter().flatten().fold(0.0f64, |most, &share| most.max(share));
    let first = (0..buckets).find(|&bucket| shares.iter().any(|shares| shares[bucket] > 0.0))?;
    let mut page = Diagram::new([WIDTH, 380]);
    let ticks = (first..buckets).map(|bucket| (bucket as f64 + 0.5, count(1 << bucket))).collect();
    let range = [first as f64, buckets as f64];
    let x = Axis { name: "rays in the queue, from this to twice as many".to_owned(), range, is_log: false, ticks };
    let frame = Frame { edges: [64.0, 66.0, RIGHT, 320.0], x, y: Axis::up_to("% of the times", most) };
    frame.draw(&mut page);
    let used: Vec<usize> = (0..QUEUES.len()).filter(|&queue| shares[queue].iter().any(|share| *share > 0.0)).collect();
    let width = 0.84 / used.len() as f64;
    for (place, &queue) in used.iter().enumerate() {
        for bucket in (first..buckets).filter(|&bucket| shares[queue][bucket] > 0.0) {
            let left = bucket as f64 + 0.08 + width * place as f64;
            let corner = frame.place(left, shares[queue][bucket]);
            page.block(corner, frame.place(left + 0.94 * width, 0.0), QUEUES[queue].1);
        }
    }
    legend(&mut page, used.iter().map(|&queue| QUEUES[queue]));
    Some(page)
}

/// A number of rays in few letters.
fn count(rays: u64) -> String {
    match rays {
        rays if rays >= 1 << 20 => format!("{}M", rays >> 20),
        rays if rays >= 1 << 10 => format!("{}k", rays >> 10),
        rays => rays.to_string(),
    }
}

/// Stages of all bounces together: operations a second against operations a byte, under what memory and arithmetic let through.
fn roofline(baseline: &PolicyResult, results: &Results) -> Option<Diagram> {
    let stages = by_stage(&baseline.stages);
    let points: Vec<(&str, f64, f64)> = stages
        .iter()
        .filter(|stage| stage.bytes > 0.0 && stage.seconds > 0.0 && stage.operations > 0.0)
        .map(|stage| (stage.name, stage.operations / stage.bytes, stage.operations / stage.seconds * 1e-9))
        .collect();
    let machine = &results.machine;
    let levels =
        machine.caches.iter().map(|cache| (format!("L{}", cache.level), machine.bandwidth_at(cache.bytes / 2)));
    let memory = machine.bandwidth.last().map(|&(_, rate)| ("memory".to_owned(), rate));
    let levels: Vec<(String, f64)> = levels.chain(memory).collect();
    let peak = machine.arithmetic;
    let bounds = |values: &mut dyn Iterator<Item = f64>| {
        values.fold([f64::INFINITY, 0.0], |[a, b]: [f64; 2], v| [a.min(v), b.max(v)])
    };
    let across = bounds(&mut points.iter().map(|(_, x, _)| *x));
    let up = bounds(&mut points.iter().map(|(_, _, y)| *y));
    if points.is_empty() || levels.is_empty() {
        return None;
    }
    let across = [across[0].min(0.1), across[1].max(10.0)];
    let up = [0.8 * up[0], up[1].max(2.0 * peak)];
    let x = Axis::factors("operations for a byte of queues", 10.0, across, |number| format!("{number}"));
    let y = Axis::factors("10^9 operations a second", 10.0, up, |rate| format!("{rate}"));
    let mut page = Diagram::new([WIDTH, 500]);
    let frame = Frame { edges: [64.0, 36.0, RIGHT, 440.0], x, y };
    frame.draw(&mut page);
    let [left, right] = frame.x.range;
    let pen = Pen { ink: ORANGE, width: 1.6, dash: &[] };
    let ridge = levels.iter().map(|(_, rate)| peak / rate).fold(f64::INFINITY, f64::min).max(left);
    page.line([ridge.min(right), right].map(|x| frame.place(x, peak)).to_vec(), pen);
    let [x, y] = frame.place(right, peak);
    page.word(format!("arithmetic, {peak:.0}"), [x - 8.0, y - 9.0], 13.0, Anchor::End, ORANGE);
    let mut taken = Vec::new();
    for (place, (name, rate)) in levels.iter().enumerate() {
        let roof = |x: f64| frame.place(x, rate * x);
        // From where the chart begins, below or left, to the peak.
        let ends = [left.max(frame.y.range[0] / rate), right.min(peak / rate)];
        if ends[0] >= ends[1] {
            continue;
        }
        page.line(ends.map(roof).to_vec(), pen);
        // Names stand side by side, for the lines may be close to each other.
        let [from, to] = ends.map(f64::ln);
        let [x, y] = roof((from + (to - from) * (0.06 + 0.22 * place as f64)).exp());
        let name = format!("{name}, {rate:.0} GB/s");
        taken.push([x - 6.0, y - 23.0, x - 6.0 + LETTER * name.len() as f32, y - 11.0]);
        page.word(name, [x - 6.0, y - 12.0], 13.0, Anchor::Start, ORANGE);
    }
    label(&mut page, &frame, &points, taken);
    Some(page)
}

/// About how wide a letter of 13 is.
const LETTER: f32 = 7.4;

/// Dots with names that keep out of each other's way, and of what else is taken, as far as there is room.
fn label(page: &mut Diagram, frame: &Frame, points: &[(&str, f64, f64)], mut taken: Vec<[f32; 4]>) {
    let places: Vec<[f32; 2]> = points.iter().map(|(_, x, y)| frame.place(*x, *y)).collect();
    taken.extend(places.iter().map(|[x, y]| [x - 6.0, y - 6.0, x + 6.0, y + 6.0]));
    for ((name, _, _), [x, y]) in points.iter().zip(&places) {
        let width = LETTER * name.len() as f32;
        let sides = [(x + 9.0, Anchor::Start), (x - 9.0, Anchor::End)];
        let shifts = [0.0f32, -13.0, 13.0, -26.0, 26.0, -39.0, 39.0, 52.0, 65.0];
        let mut options = shifts.iter().flat_map(|shift| sides.map(|(x, anchor)| (x, y + shift, anchor)));
        let extent = |(x, y, anchor): (f32, f32, Anchor)| {
            let left = if anchor == Anchor::Start { x } else { x - width };
            [left, y - 6.0, left + width, y + 6.0]
        };
        let is_free = |option: &(f32, f32, Anchor)| {
            let [left, top, right, bottom] = extent(*option);
            let [frame_left, frame_top, frame_right, frame_bottom] = frame.edges;
            let inside = left > frame_left && right < frame_right && top > frame_top && bottom < frame_bottom;
            inside
                && !taken.iter().any(|other| left < other[2] && other[0] < right && top < other[3] && other[1] < bottom)
        };
        let place = options.find(is_free).unwrap_or((x + 9.0, *y, Anchor::Start));
        taken.push(extent(place));
        let ink = GROUPS[group(name)].1;
        page.dot([*x, *y], 5.0, ink);
        page.word(*name, [place.0, place.1 + 5.0], 13.0, place.2, ink);
    }
}

/// A stage over all bounces and queues.
pub(super) struct StageSum {
    pub name: &'static str,
    pub rays: f64,
    pub seconds: f64,
    pub bytes: f64,
    pub operations: f64,
    /// Lanes of the registers that its calls filled.
    pub lanes: f64,
}

/// Sums over bounces and queues, in the order of stages.
pub(super) fn by_stage(rows: &[StageRow]) -> Vec<StageSum> {
    let mut sums: Vec<StageSum> = Vec::new();
    for row in rows {
        let place = sums.iter().position(|sum| sum.name == row.stage).unwrap_or_else(|| {
            sums.push(StageSum { name: row.stage, rays: 0.0, seconds: 0.0, bytes: 0.0, operations: 0.0, lanes: 0.0 });
            sums.len() - 1
        });
        let sum = &mut sums[place];
        sum.rays += row.rays as f64;
        sum.seconds += row.seconds;
        sum.bytes += (row.read + row.written) as f64;
        sum.operations += row.operations as f64;
        sum.lanes += row.rays as f64 / row.occupancy.max(1e-9);
    }
    sums
}
