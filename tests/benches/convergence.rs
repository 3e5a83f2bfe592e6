//! Error against samples on the reference scenes: `cargo bench -p brewster-tests --bench convergence [-- FILE.svg]`.
//!
//! The error is the root of the mean square over pixels and channels of half the difference between two pictures with seeds of
//! their own, over the picture's mean. Independent samples would have it fall with the power -½ of their number; the Sobol
//! points fall at least as fast. Prints a table with the slope of each scene, draws the plot, and fails where a slope is above
//! -0.45.

use std::fmt::Write;

use brewster_tests::agreement::{REFERENCES, load, pixels};

/// Samples a pixel.
const SAMPLES: [u32; 5] = [1, 4, 16, 64, 256];

fn main() {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    println!("| scene, samples a pixel | {} | slope |", SAMPLES.map(|samples| samples.to_string()).join(" | "));
    println!("| --- | {}", "--- | ".repeat(SAMPLES.len() + 1));
    let curves = REFERENCES.map(|name| {
        let errors = SAMPLES.map(|samples| error(name, samples, threads));
        let row = errors.map(|error| format!("{:.3} %", 100.0 * error)).join(" | ");
        println!("| {name} | {row} | {:.2} |", slope(&errors));
        (name, errors)
    });
    if let Some(file) = std::env::args().skip(1).find(|argument| !argument.starts_with('-')) {
        std::fs::write(&file, plot(&curves)).unwrap_or_else(|error| panic!("{file}: {error}"));
    }
    let slow: Vec<_> = curves.iter().filter(|(_, errors)| slope(errors) > -0.45).map(|(name, _)| name).collect();
    assert!(slow.is_empty(), "{slow:?} converge slowly");
}

/// The relative error of a picture with so many samples a pixel.
fn error(name: &str, samples: u32, threads: usize) -> f64 {
    let mut scene = load(name);
    scene.settings.samples = samples;
    let [a, b] = [1, 2].map(|seed| {
        scene.settings.seed = seed;
        pixels(&scene, threads)
    });
    let squares: f64 = a.iter().zip(&b).map(|(a, b)| (a - b) * (a - b) / 2.0).sum();
    let mean = a.iter().chain(&b).sum::<f64>() / (a.len() + b.len()) as f64;
    (squares / a.len() as f64).sqrt() / mean
}

/// The power with which errors fall: the least-squares line over logarithms.
fn slope(errors: &[f64]) -> f64 {
    let points = || SAMPLES.iter().zip(errors).map(|(&samples, error)| (f64::from(samples).ln(), error.ln()));
    let count = errors.len() as f64;
    let (x, y) = points().fold((0.0, 0.0), |sum, point| (sum.0 + point.0 / count, sum.1 + point.1 / count));
    let (above, below) = points()
        .fold((0.0, 0.0), |sum, point| (sum.0 + (point.0 - x) * (point.1 - y), sum.1 + (point.0 - x) * (point.0 - x)));
    above / below
}

/// The curves on logarithmic axes, with a dashed line of slope -½.
fn plot(curves: &[(&str, [f64; SAMPLES.len()])]) -> String {
    const INKS: [&str; 10] =
        ["#1f77b4", "#ff7f0e", "#2ca02c", "#d62728", "#9467bd", "#8c564b", "#e377c2", "#7f7f7f", "#bcbd22", "#17becf"];
    let x = |samples: f64| 80.0 + 500.0 * samples.log10() / 256f64.log10();
    let y = |error: f64| 60.0 + 420.0 * (1.0 - error.log10()) / 5.0;
    let mut svg = String::from(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"800\" height=\"540\" font-family=\"sans-serif\" font-size=\"14\">\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\
         <text x=\"80\" y=\"32\" font-size=\"18\">Relative error against samples a pixel</text>\n",
    );
    for power in -4..=1 {
        let (at, error) = (y(10f64.powi(power)), 10f64.powi(power + 2));
        writeln!(
            svg,
            "<path d=\"M80 {at}H580\" stroke=\"#ddd\"/><text x=\"72\" y=\"{}\" text-anchor=\"end\">{error} %</text>",
            at + 5.0
        )
        .expect("a string takes all");
    }
    for samples in SAMPLES {
        let at = x(f64::from(samples));
        writeln!(svg, "<path d=\"M{at} 60V480\" stroke=\"#ddd\"/><text x=\"{at}\" y=\"500\" text-anchor=\"middle\">{samples}</text>")
            .expect("a string takes all");
    }
    let mut line = |name: &str, errors: &[f64], ink: &str, dash: &str, row: usize| {
        let points: Vec<String> = SAMPLES
            .iter()
            .zip(errors)
            .map(|(&samples, &error)| format!("{:.1},{:.1}", x(f64::from(samples)), y(error)))
            .collect();
        let at = 70 + 22 * row;
        writeln!(
            svg,
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{ink}\" stroke-width=\"2\"{dash}/>\
             <path d=\"M600 {at}h30\" stroke=\"{ink}\" stroke-width=\"2\"{dash}/><text x=\"638\" y=\"{}\">{name}</text>",
            points.join(" "),
            at + 5
        )
        .expect("a string takes all");
    };
    for (row, (name, errors)) in curves.iter().enumerate() {
        line(name, errors, INKS[row], "", row);
    }
    let half = SAMPLES.map(|samples| 0.5 / f64::from(samples).sqrt());
    line("slope -½", &half, "black", " stroke-dasharray=\"6 4\"", curves.len());
    svg + "</svg>\n"
}
