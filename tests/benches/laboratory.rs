//! Renders a scene of a performance laboratory and prints one JSON line with the fields of the other renderers' lines:
//! `cargo bench -p brewster-tests --bench laboratory -- SCENE.json [--threads N] [--spp N] [--runs N] [--rr] [--guided] [--hdr FILE] [--ron FILE]`.
//! `--rr` renders with Russian roulette, `--guided` with guided paths. The last two write the picture, and the scene for other commands, to be kept beside its files.
//!
//! A `SCENE.json` has `width`, `height`, `spp`, `max_depth` (of a path's rays, the one from the light included), `camera` (`origin`,
//! `target`, `fov_deg`), `environment` (null, `constant` with `radiance`, or `map` with `file`), `materials` (`diffuse` and `mirror` with
//! `color`, `glass` with `ior`, `light` with `radiance`), `meshes` (`ply`, `material`) and `objects` (`mesh`, `matrix`); files are beside it.
//!
//! Times are in seconds: `load_s` until the scene is ready to be traced, `render_s` of pictures after the first. `variance` is
//! half of the mean squared difference of two seeds, values up to 10; `efficiency` is 1/(variance x seconds).

use std::path::Path;
use std::time::Instant;

use brewster::film::{LinearImage, write_hdr};
use brewster::{Session, SessionOptions};
use brewster_tests::agreement::pixels;
use serde_json::{Value, json};

/// What is asked for.
struct Options {
    threads: usize,
    samples: Option<u64>,
    runs: usize,
    roulette: bool,
    guided: bool,
    hdr: Option<String>,
    ron: Option<String>,
}

fn main() {
    let begin = Instant::now();
    let mut arguments = std::env::args().skip(1).filter(|argument| argument != "--bench");
    // `cargo bench` starts all benches of a package.
    let Some(scene) = arguments.next() else { return println!("laboratory: no scene was named") };
    let mut options =
        Options { threads: 1, samples: None, runs: 3, roulette: false, guided: false, hdr: None, ron: None };
    while let Some(name) = arguments.next() {
        if let Some(flag) = match name.as_str() {
            "--rr" => Some(&mut options.roulette),
            "--guided" => Some(&mut options.guided),
            _ => None,
        } {
            *flag = true;
            continue;
        }
        let value = arguments.next().unwrap_or_else(|| panic!("{name} needs a value"));
        let number = || value.parse::<u64>().unwrap_or_else(|_| panic!("{name} {value}: a whole number was expected"));
        match name.as_str() {
            "--threads" => options.threads = number() as usize,
            "--spp" => options.samples = Some(number()),
            "--runs" => options.runs = number() as usize,
            "--hdr" => options.hdr = Some(value),
            "--ron" => options.ron = Some(value),
            _ => panic!("there is no {name}: --threads, --spp, --runs, --rr, --guided, --hdr or --ron was expected"),
        }
    }
    println!("{}", measure(Path::new(&scene), &options, begin));
}

fn measure(path: &Path, options: &Options, begin: Instant) -> Value {
    let text = std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let description: Value = serde_json::from_str(&text).expect("the scene is JSON");
    let samples = options.samples.unwrap_or_else(|| whole(&description["spp"]));
    let start = Instant::now();
    let mut session = Session::new(path, SessionOptions::default());
    let scene = ron(&description, samples, options);
    if let Some(file) = &options.ron {
        std::fs::write(file, &scene).expect("the scene can be written");
    }
    session.load_text(&scene).unwrap_or_else(|error| panic!("{error}"));
    session.flatten().unwrap_or_else(|error| panic!("{error}"));
    let mut scene = session.buffers().clone();
    let load = start.elapsed().as_secs_f64();
    let (mut times, mut pictures) = (Vec::new(), Vec::new());
    for seed in 0..=options.runs.max(1) {
        scene.settings.seed = seed as u64;
        let start = Instant::now();
        let picture = pixels(&scene, options.threads);
        times.push(start.elapsed().as_secs_f64());
        if seed < 2 {
            pictures.push(picture);
        }
    }
    let squares = pictures[0].iter().zip(&pictures[1]).map(|(a, b)| (a.min(10.0) - b.min(10.0)).powi(2));
    let variance = 0.5 * squares.sum::<f64>() / pictures[0].len() as f64;
    if let Some(file) = &options.hdr {
        let colors = pictures[0].as_chunks().0.iter().map(|color: &[f64; 3]| color.map(|value| value as f32)).collect();
        let size = scene.settings.resolution;
        let image = LinearImage { width: size.x, height: size.y, color: colors, alpha: None };
        write_hdr(Path::new(file), &image).expect("the picture can be written");
    }
    let mut later = times[1..].to_vec();
    later.sort_by(f64::total_cmp);
    let median = later[later.len() / 2];
    let size = whole(&description["width"]);
    json!({
        "engine": concat!("brewster ", env!("CARGO_PKG_VERSION")),
        "scene": description["name"],
        "res": size,
        "spp": samples,
        "max_depth": description["max_depth"],
        "rr": options.roulette,
        "guided": options.guided,
        "threads": options.threads,
        "load_s": load,
        "first_render_s": times[0],
        "render_s": {"n": later.len(), "min": later[0], "median": median, "max": later[later.len() - 1]},
        "total_s": load + times[0],
        "process_s": begin.elapsed().as_secs_f64() - times[1..].iter().sum::<f64>(),
        "msamples_s": (size * whole(&description["height"]) * samples) as f64 / median * 1e-6,
        "variance": variance,
        "efficiency": 1.0 / (variance * median).max(1e-12),
        "peak_rss_mb": brewster::peak_memory().map(|bytes| bytes as f64 / f64::from(1 << 20)),
        "tag": "",
    })
}

fn whole(value: &Value) -> u64 {
    value.as_u64().expect("a whole number")
}

/// The scene in our own format.
fn ron(description: &Value, samples: u64, &Options { roulette, guided, .. }: &Options) -> String {
    let name = |value: &Value| value.as_str().expect("a name").to_owned();
    let entries = |field: &str| description[field].as_object().expect("a map").iter();
    let materials = entries("materials").map(|(key, material)| {
        let color = || vector(&material["color"]);
        let written = match material["type"].as_str() {
            Some("diffuse") => format!("Lambert(albedo: {})", written(&color())),
            // The same color at every angle.
            Some("mirror") => format!("Metal(r0: {0}, r90: {0})", written(&color())),
            Some("glass") => format!("Dielectric(ior: {})", material["ior"]),
            Some("light") => format!("Emissive(radiance: {}, sides: Front)", written(&vector(&material["radiance"]))),
            other => panic!("{key}: there is no material {other:?}"),
        };
        format!("{key:?}: {written},\n")
    });
    let meshes = entries("meshes").map(|(key, mesh)| format!("{key:?}: Mesh(file: {:?}),\n", name(&mesh["ply"])));
    let objects = description["objects"].as_array().expect("a list").iter().map(|object| {
        let mesh = name(&object["mesh"]);
        let material = name(&description["meshes"][mesh.as_str()]["material"]);
        let transform = object["matrix"].as_array().map_or(String::new(), |rows| {
            let rows: Vec<String> = rows[..3].iter().map(|row| written(&vector(row))).collect();
            format!(", transform: ({})", rows.join(", "))
        });
        format!("(shape: {mesh:?}, material: {material:?}{transform}),\n")
    });
    let environment = &description["environment"];
    let background = match environment["type"].as_str() {
        Some("constant") => written(&vector(&environment["radiance"])),
        Some("map") => format!("Environment(file: {:?}, rotation: -90, rows: Poles)", name(&environment["file"])),
        _ => "0".to_owned(),
    };
    let (camera, max_depth) = (&description["camera"], whole(&description["max_depth"]) - 1);
    format!(
        "Scene(
            settings: (
                integrator: Path, resolution: ({}, {}), samples: {samples}, max_depth: {max_depth}, filter: Box,
                roulette: {roulette}, guiding: {guided},
            ),
            camera: Perspective(eye: {}, target: {}, vfov: {}),
            background: {background},
            materials: {{{}}},
            shapes: {{{}}},
            entities: [{}],
        )",
        description["width"],
        description["height"],
        written(&vector(&camera["origin"])),
        written(&vector(&camera["target"])),
        camera["fov_deg"],
        materials.collect::<String>(),
        meshes.collect::<String>(),
        objects.collect::<String>(),
    )
}

fn vector(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(|number| number.as_f64().expect("a number")).collect()
}

fn written(numbers: &[f64]) -> String {
    let numbers: Vec<String> = numbers.iter().map(f64::to_string).collect();
    format!("({})", numbers.join(", "))
}
