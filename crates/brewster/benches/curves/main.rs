//! What a scene costs as it grows: `cargo bench -p brewster --bench curves -- run [FAMILY…] [FILE.svg]`.
//!
//! Each family makes scenes of one kind in many sizes. Every scene is built, flattened and rendered in a process of its own, so that
//! its peak of memory is its own; flattening and trees take all threads, rendering takes one. A picture's mean has to be what it is
//! in the family's other sizes, or what a closed form says, and its count of camera rays that hit, too, before a figure is
//! printed. `-- mesh TRIANGLES FILE.ply` writes a mesh of the first family for other programs.

mod families;
#[path = "../../src/plot/mod.rs"]
#[allow(dead_code, unused_imports, reason = "the program draws more with it")]
mod plot;
mod svg;

use std::process::Command;
use std::time::{Duration, Instant};

use brewster::film::{Film, PixelOrder};
use brewster::wavefront::{Control, Policy, Renderer};
use brewster::{peak_memory, tree_time};
use serde::{Deserialize, Serialize};

use families::{FAMILIES, Family, hilly};

/// What a scene cost.
#[derive(Clone, Debug, Deserialize, Serialize)]
struct Cost {
    size: u64,
    /// Seconds of a flatten of all, trees too, and of the trees alone.
    flatten: f64,
    trees: f64,
    /// The most bytes that the process had, from its start to the end of the picture.
    peak: u64,
    /// Rays of every kind a second on one thread, in millions.
    rate: f64,
    /// Rays of every kind for one picture.
    rays: u64,
    /// The part of the camera rays that hit.
    hits: f64,
    /// The picture's mean, of all channels.
    mean: f64,
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>().as_slice() {
        ["run", wanted @ ..] => run(wanted),
        ["case", family, size] => {
            let family = FAMILIES.iter().find(|known| known.name == *family).expect("a family's name");
            let cost = measure(family, size.parse().expect("a size"));
            println!("{}", serde_json::to_string(&cost).expect("plain values have a text"));
        }
        ["mesh", triangles, file] => write_mesh(triangles.parse().expect("a number of triangles"), file),
        // `cargo bench` starts all benches of a package.
        _ => println!("curves: nothing was asked for"),
    }
}

/// Runs all sizes of the families that are named, or of all, and prints their tables.
fn run(wanted: &[&str]) {
    let (files, names): (Vec<&str>, Vec<&str>) = wanted.iter().partition(|word| word.ends_with(".svg"));
    let mut curves = Vec::new();
    for family in FAMILIES.iter().filter(|family| names.is_empty() || names.contains(&family.name)) {
        let costs: Vec<Cost> = family.sizes.iter().map(|&size| in_its_own_process(family, size)).collect();
        check(family, &costs);
        print(family, &costs);
        curves.push((family, costs));
    }
    for file in files {
        std::fs::write(file, svg::draw(&curves)).unwrap_or_else(|error| panic!("{file}: {error}"));
    }
}

fn in_its_own_process(family: &Family, size: u64) -> Cost {
    let program = std::env::current_exe().expect("a process has a program");
    let output = Command::new(program).args(["case", family.name, &size.to_string()]).output().expect("it starts");
    let (out, err) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "{} of size {size}: {err}", family.name);
    serde_json::from_str(&out).unwrap_or_else(|error| panic!("{} of size {size}: {error}: {out}", family.name))
}

/// The least time that pictures are rendered for.
const TIME: Duration = Duration::from_millis(1500);

/// Builds, flattens and renders one scene.
fn measure(family: &Family, size: u64) -> Cost {
    let mut scene = (family.scene)(size);
    let begin = Instant::now();
    let report = scene.flatten();
    let flatten = begin.elapsed().as_secs_f64();
    assert!(report.invalid.is_empty(), "{:?}", report.invalid);
    let buffers = scene.buffers();
    let settings = &buffers.settings;
    let order = PixelOrder::new(settings.resolution.x, settings.resolution.y, None).expect("the picture is small");
    let mut film = Film::new(order);
    let mut renderer = Renderer::new(buffers, 0, 1, Policy::default(), false).expect("the scene can be rendered");
    let mut best = Duration::MAX;
    let begin = Instant::now();
    // The first picture warms up.
    for picture in 0.. {
        film.clear();
        let start = Instant::now();
        renderer.pass(0..settings.samples, &mut film, &Control::default());
        if picture > 0 {
            best = best.min(start.elapsed());
        }
        if picture > 1 && begin.elapsed() > TIME {
            let (pictures, stats) = (picture + 1, renderer.stats());
            let rays = stats.rays() / pictures;
            let camera = stats.depths[0].total();
            let pixels = film.resolve().image().color;
            let sum: f64 = pixels.iter().flatten().map(|&value| f64::from(value)).sum();
            return Cost {
                size,
                flatten,
                trees: tree_time(&report).as_secs_f64(),
                peak: peak_memory().unwrap_or(0),
                rate: rays as f64 / best.as_secs_f64() * 1e-6,
                rays,
                hits: camera.hits as f64 / camera.traced() as f64,
                mean: sum / (3 * pixels.len()) as f64,
            };
        }
    }
    unreachable!("the time ends")
}

/// Writes the hills as a binary PLY file.
fn write_mesh(triangles: u64, file: &str) {
    let mesh = hilly(triangles);
    let (vertices, faces) = (mesh.positions.len(), mesh.triangles.len());
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    .into_bytes();
    mesh.positions.iter().flat_map(|place| place.to_array()).for_each(|number| bytes.extend(number.to_le_bytes()));
    for corners in &mesh.triangles {
        bytes.push(3);
        corners.iter().for_each(|corner| bytes.extend(corner.to_le_bytes()));
    }
    std::fs::write(file, bytes).unwrap_or_else(|error| panic!("{file}: {error}"));
}

/// Sizes that should agree do.
fn check(family: &Family, costs: &[Cost]) {
    let Some(last) = costs.last() else { return };
    for cost in costs.iter().filter(|cost| cost.size >= family.comparable_from) {
        let expected = (family.mean)(cost.size).unwrap_or(last.mean);
        let off = cost.mean / expected - 1.0;
        assert!(off.abs() <= family.tolerance, "{}: {cost:?}, not a mean of {expected}", family.name);
        assert!((cost.hits - last.hits).abs() < 0.01, "{}: {cost:?}, not as many hits as {last:?}", family.name);
    }
}

fn print(family: &Family, costs: &[Cost]) {
    println!("**{}**: {}\n", family.name, family.text);
    println!("| {} | flatten, s | of that trees, s | peak MiB | Mrays/s | rays a picture | mean |", family.unit);
    println!("| --- | --- | --- | --- | --- | --- | --- |");
    for cost in costs {
        let Cost { size, flatten, trees, peak, rate, rays, mean, .. } = cost;
        let peak = *peak as f64 / f64::from(1 << 20);
        let million = *rays as f64 * 1e-6;
        println!("| {size} | {flatten:.4} | {trees:.4} | {peak:.0} | {rate:.2} | {million:.2} M | {mean:.4} |");
    }
    println!();
}
