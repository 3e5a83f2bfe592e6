//! The twelve reference scenes against Mitsuba's pictures, in full: `cargo bench -p brewster-tests --bench references [-- SCENE…]`.
//! `-- offset SCENE…` starts rays as far off the surfaces as Mitsuba does.
//!
//! Prints one line a scene, and fails if one does not agree. Samples are as many as make our standard error no larger than
//! Mitsuba's.

use std::time::Instant;

use brewster_tests::agreement::{BLOCK, MITSUBA_OFFSET, REFERENCES, agreement};

/// Independent pictures of a scene.
const SEEDS: u32 = 64;

fn main() {
    let mut asked: Vec<String> = std::env::args().skip(1).filter(|argument| !argument.starts_with('-')).collect();
    let offset = if asked.iter().any(|word| word == "offset") { MITSUBA_OFFSET } else { 0.0 };
    asked.retain(|word| word != "offset");
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    println!(
        "| scene | samples a pixel | largest z | at (ours, Mitsuba's) | bound | mean | our error / Mitsuba's | agrees | seconds |"
    );
    println!("| --- | --- | --- | --- | --- | --- | --- | --- | --- |");
    let mut failures = 0;
    for name in REFERENCES.iter().filter(|&&name| asked.is_empty() || asked.iter().any(|asked| asked == name)) {
        let start = Instant::now();
        let mut samples = 16u32;
        let found = loop {
            let found = agreement(name, offset, BLOCK, [SEEDS, samples], threads);
            // The error falls with the root of the samples; a tenth more, as it is itself uncertain.
            if found.error_ratio <= 1.0 || samples >= 1 << 12 {
                break found;
            }
            samples = (f64::from(samples) * found.error_ratio.powi(2) * 1.1).ceil() as u32;
        };
        failures += usize::from(!found.holds());
        println!(
            "| {name} | {} | {:.2} | {:?} ({:.5}, {:.5}) | {:.2} | {:+.3} % | {:.2} | {} | {:.0} |",
            SEEDS * samples,
            found.worst,
            found.worst_at,
            found.worst_values[0],
            found.worst_values[1],
            found.bound,
            100.0 * found.mean,
            found.error_ratio,
            if found.holds() { "yes" } else { "NO" },
            start.elapsed().as_secs_f64()
        );
    }
    assert_eq!(failures, 0, "scenes that do not agree");
}
