//! How fast the reference scenes converge: `cargo bench -p brewster-tests --bench speed [-- SCENE…] [--threads N] [--spp N]`.
//!
//! Prints one JSON line a scene, with the fields that `tools/mitsuba/speed.py` prints for Mitsuba: `render_s`, the median of three
//! pictures; `msamples_s`, million samples a second; `error`, the mean squared difference from the reference, values up to 10, less
//! what the reference itself is off by; and `efficiency`, 1/(error x seconds). The ratio of two efficiencies is that of the times
//! to one error.
//!
//! Fails where a picture's mean is off by more than a hundredth.

use std::time::Instant;

use brewster_tests::agreement::{REFERENCES, load, pixels, reference};
use serde_json::{Value, json};

/// Pictures of a scene.
const PICTURES: u64 = 3;

fn main() {
    let (mut asked, mut threads, mut samples) = (Vec::new(), 1, 64);
    let mut arguments = std::env::args().skip(1).filter(|argument| argument != "--bench");
    while let Some(argument) = arguments.next() {
        let mut number = || arguments.next().and_then(|value| value.parse().ok()).expect("a whole number");
        match argument.as_str() {
            "--threads" => threads = number(),
            "--spp" => samples = number(),
            name if REFERENCES.contains(&name) => asked.push(argument),
            _ => panic!("there is no {argument}: --threads, --spp or one of {REFERENCES:?} was expected"),
        }
    }
    for name in REFERENCES.iter().filter(|&&name| asked.is_empty() || asked.iter().any(|asked| asked == name)) {
        println!("{}", measure(name, threads, samples));
    }
}

fn measure(name: &str, threads: usize, samples: usize) -> Value {
    let mut scene = load(name);
    scene.settings.samples = samples as u32;
    let (size, expected, errors) = reference(name, [1, 1]);
    let count = expected.len() as f64;
    let (mut times, mut squares, mut sum) = (Vec::new(), 0.0, 0.0);
    for seed in 0..=PICTURES {
        scene.settings.seed = seed;
        let start = Instant::now();
        let picture = pixels(&scene, threads);
        // The first one warms up.
        if seed > 0 {
            times.push(start.elapsed().as_secs_f64());
            squares += picture.iter().zip(&expected).map(|(a, b)| (a.min(10.0) - b.min(10.0)).powi(2)).sum::<f64>();
            sum += picture.iter().sum::<f64>();
        }
    }
    let off = sum / (PICTURES as f64 * expected.iter().sum::<f64>()) - 1.0;
    assert!(off.abs() < 0.01, "{name}: the mean is off by {off}");
    times.sort_by(f64::total_cmp);
    let median = times[times.len() / 2];
    let error = squares / (PICTURES as f64 * count) - errors.iter().map(|error| error * error).sum::<f64>() / count;
    json!({
        "engine": concat!("brewster ", env!("CARGO_PKG_VERSION")),
        "scene": name,
        "spp": samples,
        "threads": threads,
        "render_s": median,
        "msamples_s": (size[0] * size[1] * samples) as f64 / median * 1e-6,
        "error": error,
        "efficiency": 1.0 / (error * median),
    })
}
