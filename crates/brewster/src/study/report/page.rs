//! The page itself.

use super::super::machine::Machine;
use super::super::record::{Experiment, PolicyResult, Quality, Results, clock_part, distrust};
use super::super::statistics::{Estimate, Verdict};
use super::Chart;
use super::charts::{GROUPS, by_stage, group};
use crate::plot::escaped;

/// The whole page.
pub(crate) fn html(results: &Results, charts: &[Chart]) -> String {
    let mut page = format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{}</title>\n<style>\n{}</style>\n</head>\n<body>\n",
        escaped(&results.name),
        include_str!("style.css")
    );
    page += &format!("<h1>{}</h1>\n", escaped(&results.name));
    for paragraph in results.text.split("\n\n").filter(|paragraph| !paragraph.trim().is_empty()) {
        page += &format!("<p>{}</p>\n", escaped(paragraph.trim()));
    }
    if !results.complete {
        page += "<p class=\"warn\">The study is not finished: what follows is of the whole rounds so far.</p>\n";
    }
    page += &facts(results);
    for experiment in &results.experiments {
        page += &experiment_section(experiment, charts, &results.machine);
    }
    for quality in &results.qualities {
        page += &quality_section(quality, charts);
    }
    page += &method(results);
    page += "</body>\n</html>\n";
    page
}

fn method(results: &Results) -> String {
    let clocks = "Of policies on one thread the processor's time for this program is compared, which does not go on while the machine \
        works for others; of several threads, and of building trees, the wall's. Both stand in the tables of runs.";
    let level = match results.intervals {
        0 => String::new(),
        intervals => format!(
            " The study has {intervals} intervals, of controls and of comparisons. Each is a {:.2} % interval, so that all together hold with \
             95 % (Bonferroni): that often no control leaves out 1 by chance, and no difference is reported that is none.",
            100.0 * results.confidence
        ),
    };
    METHOD.replace("LEVEL", &level).replace("CLOCKS", clocks)
}

const METHOD: &str = "<h2>How this was measured</h2>\n\
    <p>In every round each policy renders in a block of its own, two pictures between two of the baseline (A B B A), so that what drifts weighs on \
    both alike; a block's ratio is of the sums of both runs. Every block has queues and threads of its own, made in one order and in the other \
    by turns, for where these come to lie makes equals differ. CLOCKS Bars are medians of blocks with bootstrap intervals; no run is left out.LEVEL \
    The baseline takes a block with its twin in every round, as a control: where its interval leaves out 1, or rounds are too few for such an interval, nothing is judged, and a difference is \
    reported only where its own interval leaves out 1 and its median lies beyond what the control's reaches on either side. Every picture of every run was compared with the baseline's, bit for bit, and every policy's counts with the \
    baseline's counts. What a sort costs is in its policy's time.</p>\n\
    <p>Counts, lengths of runs, occupancy and visits come from a counting run; times come from runs without those, which look at the clock \
    twice for every call of a stage. Times of stages are means over all runs, on the wall's clock. Bytes are those of whole rows of \
    queues: what stages read of trees, materials and textures is not in them. Operations are counted by hand from the sources, in the usual \
    case, and may be off by half of themselves. Visits are those of a ray that goes alone, of one toward a light up to what stops it first; a \
    packet looks at more. Counters of the processor are read over one picture more, on all threads and outside the kernel, where the kernel lets a program do so.</p>\n";

fn facts(results: &Results) -> String {
    let machine = &results.machine;
    let caches: Vec<String> =
        machine.caches.iter().map(|cache| format!("L{} {} KiB", cache.level, cache.bytes >> 10)).collect();
    let speed = machine.megahertz.map_or("not readable".to_owned(), |speed| format!("{speed:.0} MHz now"));
    let memory = machine.bandwidth.last().map_or(0.0, |&(_, rate)| rate);
    let unknown = || "unknown".to_owned();
    let rows = [
        ("date", format!("{}, {}", results.date, results.program)),
        ("commit", results.commit.clone().unwrap_or_else(unknown)),
        ("processor", machine.processor.clone().unwrap_or_else(unknown)),
        ("threads at once", machine.threads.to_string()),
        ("instruction set", machine.level.to_owned()),
        ("speed", format!("{speed}; governor {}", machine.governor.clone().unwrap_or_else(unknown))),
        ("data caches", if caches.is_empty() { unknown() } else { caches.join(", ") }),
        ("memory, one thread", format!("{memory:.1} GB/s read")),
        ("arithmetic, one thread", format!("{:.0} Gflop/s, not fused", machine.arithmetic)),
        ("a look at the clock", format!("{:.0} ns", machine.clock)),
        ("counters", refused(machine)),
        ("system", machine.system.clone().unwrap_or_else(unknown)),
    ];
    let rows = rows.iter().map(|(name, value)| format!("<dt>{name}</dt><dd>{}</dd>\n", escaped(value)));
    format!("<dl>\n{}</dl>\n", rows.collect::<String>())
}

/// Which counters cannot be read; those of one reason together.
fn refused(machine: &Machine) -> String {
    let mut reasons: Vec<(&str, Vec<&str>)> = Vec::new();
    for refused in &machine.refused {
        match reasons.iter_mut().find(|(reason, _)| *reason == refused.reason) {
            Some((_, names)) => names.push(refused.name),
            None => reasons.push((&refused.reason, vec![refused.name])),
        }
    }
    let reasons: Vec<String> =
        reasons.iter().map(|(reason, names)| format!("no {}: {reason}", names.join(", "))).collect();
    if reasons.is_empty() { "all can be read".to_owned() } else { reasons.join("; ") }
}

/// The chart of that section and name, if there is one.
fn figure(charts: &[Chart], section: &str, name: &str) -> String {
    let wanted = format!("{section} {name}");
    charts.iter().find(|chart| chart.section == section && chart.name == wanted).map_or(String::new(), |chart| {
        let (svg, caption) = (chart.diagram.inline_svg(&wanted), escaped(&chart.caption));
        format!("<figure><div class=\"chart\">\n{svg}</div><figcaption>{caption}</figcaption></figure>\n")
    })
}

/// A table that scrolls where it is too wide.
fn table(names: &[&str], rows: impl Iterator<Item = Vec<String>>) -> String {
    let names: String = names.iter().map(|name| format!("<th>{name}</th>")).collect();
    let rows: String = rows
        .map(|cells| format!("<tr>{}</tr>\n", cells.iter().map(|cell| format!("<td>{cell}</td>")).collect::<String>()))
        .collect();
    format!("<div class=\"table\"><table>\n<thead><tr>{names}</tr></thead>\n<tbody>\n{rows}</tbody>\n</table></div>\n")
}

fn estimate(estimate: Option<Estimate>) -> [String; 2] {
    match estimate {
        Some(Estimate { median, low, high }) => [format!("{median:.3}"), format!("{low:.3} – {high:.3}")],
        None => ["1".to_owned(), "baseline".to_owned()],
    }
}

fn verdict(verdict: Option<Verdict>) -> String {
    let class = match verdict {
        Some(Verdict::Better) => "better",
        Some(Verdict::Worse) => "worse",
        Some(Verdict::NoDifference | Verdict::Untrusted) | None => "faint",
    };
    format!("<span class=\"{class}\">{}</span>", verdict.map_or("", Verdict::words))
}

/// A cell of words, which may take several lines.
fn words(text: &str) -> String {
    format!("<div class=\"words\">{}</div>", escaped(text))
}

fn control(control: Option<Estimate>, trusted: bool) -> String {
    match control {
        None => "<p class=\"warn\">No whole round was run.</p>\n".to_owned(),
        Some(Estimate { median, low, high }) => {
            let class = if trusted { "faint" } else { "warn" };
            let remark = distrust(&Estimate { median, low, high }, trusted);
            format!(
                "<p class=\"{class}\">Against itself the baseline shows {median:.3} ({low:.3} – {high:.3}){remark}.</p>\n"
            )
        }
    }
}

fn experiment_section(experiment: &Experiment, charts: &[Chart], machine: &Machine) -> String {
    let title = experiment.title();
    let [width, height] = experiment.resolution;
    let mut section = format!("<h2>{}</h2>\n", escaped(&title));
    section += &format!(
        "<p class=\"faint\">{}, {width} x {height}, {} samples, depth {}, {:.2} million rays, {} rounds. Picture {}. Looks at the clock take \
         {}.</p>\n",
        experiment.integrator,
        experiment.samples,
        experiment.max_depth,
        experiment.rays as f64 * 1e-6,
        experiment.rounds,
        experiment.picture,
        clock_part(experiment.overhead)
    );
    if experiment.policies.len() > 1 {
        section += &control(experiment.control, experiment.trusted);
    }
    section += "<h3>Policies</h3>\n";
    section += &figure(charts, &title, "policies");
    let names =
        ["policy", "Mrays/s", "times as fast", "interval", "", "on the wall", "queues, KiB", &words("settings")];
    section += &table(
        &names,
        experiment.policies.iter().map(|policy| {
            let [median, interval] = estimate(policy.speedup);
            let rate = policy.rate.map_or("–".to_owned(), |rate| format!("{rate:.3}"));
            let wall = policy.wall_speedup.map_or("–".to_owned(), |wall| format!("{:.3}", wall.median));
            let kibibytes = (policy.queue_bytes >> 10).to_string();
            vec![
                escaped(&policy.name),
                rate,
                median,
                interval,
                verdict(policy.verdict),
                wall,
                kibibytes,
                words(&policy.settings),
            ]
        }),
    );
    let batches = figure(charts, &title, "batches");
    if !batches.is_empty() {
        section += &format!("<h3>Batches</h3>\n{batches}");
    }
    section += &builds(experiment);
    section += &counters(experiment);
    if let Some(baseline) = experiment.policies.first() {
        section += &baseline_section(baseline, charts, &title, machine);
    }
    section
}

/// The time that trees took, where policies differ in their trees.
fn builds(experiment: &Experiment) -> String {
    if experiment.builds.is_empty() {
        return String::new();
    }
    let names = ["trees", "build, ms", "times as fast", "interval", "", "MiB"];
    let rows = experiment.builds.iter().enumerate().map(|(place, build)| {
        let [median, interval] = estimate(build.speedup);
        let name = if place == 1 { format!("{}, once more", build.name) } else { build.name.clone() };
        let time = build.median.map_or("–".to_owned(), |seconds| format!("{:.2}", 1e3 * seconds));
        let mebibytes = format!("{:.1}", build.bytes as f64 / f64::from(1 << 20));
        vec![escaped(&name), time, median, interval, verdict(build.verdict), mebibytes]
    });
    format!("<h3>Building trees, on all threads</h3>\n{}", table(&names, rows))
}

/// What the processor and the kernel counted.
fn counters(experiment: &Experiment) -> String {
    let Some(baseline) = experiment.policies.first().filter(|baseline| !baseline.counted.is_empty()) else {
        return String::new();
    };
    let counters: Vec<&str> = baseline.counted.iter().map(|counted| counted.name).collect();
    let names: Vec<String> =
        ["policy".to_owned()].into_iter().chain(counters.iter().map(|name| format!("{name} a ray"))).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let rows = experiment.policies.iter().map(|policy| {
        let count = |name: &&str| policy.counted.iter().find(|counted| counted.name == *name);
        let rays = experiment.rays.max(1) as f64;
        let cells = counters
            .iter()
            .map(|name| count(name).map_or("–".to_owned(), |counted| format!("{:.4}", counted.count as f64 / rays)));
        std::iter::once(escaped(&policy.name)).chain(cells).collect()
    });
    format!("<h3>Counters</h3>\n{}", table(&names, rows))
}

fn baseline_section(baseline: &PolicyResult, charts: &[Chart], title: &str, machine: &Machine) -> String {
    let mut section = "<h3>Where the baseline's time goes</h3>\n".to_owned();
    section += &figure(charts, title, "time per bounce");
    let bounces = baseline.stages.iter().map(|row| row.depth + 1).max().unwrap_or(0);
    let names: Vec<&str> = ["bounce"].into_iter().chain(GROUPS.map(|(name, _, _)| name)).chain(["all, ms"]).collect();
    section += &table(
        &names,
        (0..bounces).map(|depth| {
            let mut times = [0.0; GROUPS.len()];
            baseline
                .stages
                .iter()
                .filter(|row| row.depth == depth)
                .for_each(|row| times[group(row.stage)] += 1e3 * row.seconds);
            let all: f64 = times.iter().sum();
            let times = times.iter().map(|time| if *time > 0.0 { format!("{time:.2}") } else { "–".to_owned() });
            std::iter::once(depth.to_string()).chain(times).chain([format!("{all:.2}")]).collect()
        }),
    );
    section += "<h3>Queues</h3>\n";
    section += &figure(charts, title, "queues");
    section += &figure(charts, title, "queue lengths");
    let names = [
        "bounce",
        "queue",
        "rays",
        "times traced",
        "mean length",
        "octant runs",
        "material runs",
        "nodes a ray",
        "instances",
        "primitives",
        "shadow rays",
        "nodes",
        "instances",
        "primitives",
    ];
    section += &table(
        &names,
        baseline.queues.iter().map(|row| {
            let numbers = [
                row.rays as f64 / row.taken.max(1) as f64,
                row.octant_run,
                row.material_run,
                row.nodes,
                row.instances,
                row.primitives,
            ];
            let numbers = numbers.map(|number| format!("{number:.1}"));
            let shadows = [row.shadow_nodes, row.shadow_instances, row.shadow_primitives];
            let shadows = std::iter::once(row.shadow_rays.to_string())
                .chain(shadows.map(|number| if row.shadow_rays > 0 { format!("{number:.1}") } else { "–".to_owned() }));
            let counts = [row.rays.to_string(), row.taken.to_string()];
            [row.depth.to_string(), row.queue.to_owned()]
                .into_iter()
                .chain(counts)
                .chain(numbers)
                .chain(shadows)
                .collect()
        }),
    );
    section += "<h3>Stages, memory and arithmetic</h3>\n";
    section += &figure(charts, title, "roofline");
    section += &stage_table(baseline, machine);
    section
}

fn stage_table(baseline: &PolicyResult, machine: &Machine) -> String {
    let sums = by_stage(&baseline.stages);
    let all: f64 = sums.iter().map(|sum| sum.seconds).sum();
    let names = [
        "stage",
        "rays",
        "ns a ray",
        "% of time",
        "bytes a ray",
        "GB/s",
        "% of memory's",
        "operations a ray",
        "10^9 a second",
        "% of arithmetic",
        "lanes filled, %",
    ];
    let memory = machine.bandwidth.last().map_or(f64::INFINITY, |&(_, rate)| rate);
    let rows = sums.iter().filter(|sum| sum.seconds > 0.0).map(|sum| {
        let (nanoseconds, rate) = (1e9 * sum.seconds / sum.rays, 1e-9 * sum.bytes / sum.seconds);
        vec![
            sum.name.to_owned(),
            format!("{:.0}", sum.rays),
            format!("{nanoseconds:.1}"),
            format!("{:.1}", 100.0 * sum.seconds / all),
            format!("{:.0}", sum.bytes / sum.rays),
            format!("{rate:.2}"),
            format!("{:.0}", 100.0 * rate / memory),
            format!("{:.0}", sum.operations / sum.rays),
            format!("{:.2}", 1e-9 * sum.operations / sum.seconds),
            format!("{:.1}", 1e-7 * sum.operations / sum.seconds / machine.arithmetic),
            format!("{:.1}", 100.0 * sum.rays / sum.lanes.max(1.0)),
        ]
    });
    table(&names, rows)
}

fn quality_section(quality: &Quality, charts: &[Chart]) -> String {
    let mut section = format!("<h2>{}: noise after equal time</h2>\n", escaped(&quality.scene));
    section += &format!(
        "<p class=\"faint\">{} rounds, in each two pictures of a set and two of the first one, with seeds of their own. Efficiency is 1/(variance x seconds). z says how far \
         the pictures differ beyond their noise, in standard errors: beyond 3 they show different things. Neither is judged where noise comes from too few bright paths to tell its spread.</p>\n",
        quality.rounds
    );
    section += &control(quality.control, quality.trusted);
    section += &figure(charts, &quality.scene, "efficiency");
    let names = ["parameters", "seconds", "variance", "times as efficient", "interval", "", "z", &words("settings")];
    section += &table(
        &names,
        quality.parameters.iter().map(|set| {
            let [median, interval] = estimate(set.ratio);
            let count = set.blocks.len() as f64;
            let seconds = set.blocks.iter().flat_map(|block| block.own).map(|took| took.on(quality.clock)).sum::<f64>();
            let seconds = seconds / (2.0 * count);
            let variance = set.variances.iter().map(|[_, own]| own).sum::<f64>() / count;
            let z = set.z.map_or("–".to_owned(), |z| format!("{z:.1}"));
            let numbers =
                [format!("{seconds:.3}"), format!("{variance:.3e}"), median, interval, verdict(set.verdict), z];
            std::iter::once(escaped(&set.name)).chain(numbers).chain([words(&set.settings)]).collect()
        }),
    );
    for (set, doubt) in quality.parameters.iter().filter_map(|set| Some((set, set.doubt()?))) {
        section += &format!("<p class=\"warn\">{} is not judged: {}.</p>\n", escaped(&set.name), escaped(&doubt));
    }
    section
}
