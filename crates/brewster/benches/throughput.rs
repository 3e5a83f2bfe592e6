//! What tracing, building and memory cost: `cargo bench -p brewster [-- ROUNDS]`.
//!
//! Prints, in this order: the memory that 10 million instanced triangles take, the time to build a tree over a million triangles, and
//! for three scenes of the gallery the rays per second of every stage and what a second thread gains. One and two threads take
//! turns, round by round; every picture is compared with the first, bit for bit.

use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use brewster::film::Film;
use brewster::geometry::{MeshTree, TreeBuilder, TriangleMesh};
use brewster::wavefront::{Control, Stage, Stats};
use brewster::world::Scene;
use brewster::world::components::{Color, Material, Shape, Transform, UsesMaterial, UsesShape};
use brewster::{RenderOptions, Session, SessionOptions, SettingsChoices, peak_memory};
use glam::{Affine3A, UVec2, Vec3};

const SCENES: [&str; 3] = ["metal-spheres", "water-glass", "meadow"];

fn main() {
    let rounds = std::env::args().skip(1).find_map(|argument| argument.parse().ok()).unwrap_or(5);
    instances();
    tree(rounds);
    for scene in SCENES {
        tracing(scene, rounds);
    }
}

/// A square of `cells` by `cells` cells, two triangles each, over hills.
fn hills(cells: u32) -> TriangleMesh {
    let height = |x: u32, y: u32| 0.1 * ((x * 7 % 31) as f32 / 31.0 + (y * 5 % 23) as f32 / 23.0);
    let places = (0..=cells).flat_map(|y| (0..=cells).map(move |x| (x, y)));
    let positions = places.map(|(x, y)| Vec3::new(x as f32, height(x, y), y as f32) / cells as f32).collect();
    let corner = |x: u32, y: u32| y * (cells + 1) + x;
    let squares = (0..cells).flat_map(|y| (0..cells).map(move |x| (x, y)));
    let triangles = squares
        .flat_map(|(x, y)| {
            let [a, b, c, d] = [corner(x, y), corner(x, y + 1), corner(x + 1, y + 1), corner(x + 1, y)];
            [[a, b, c], [a, c, d]]
        })
        .collect();
    TriangleMesh { positions, triangles, ..Default::default() }
}

/// 2,000 instances of a mesh of 5,000 triangles.
fn instances() {
    let mut scene = Scene::new();
    let mesh = scene.spawn(Shape::Mesh(Arc::new(hills(50)))).id();
    let material = scene.spawn(Material::Lambert { albedo: Color::gray(0.5) }).id();
    for index in 0..2000 {
        let place = Vec3::new((index % 50) as f32, 0.0, (index / 50) as f32);
        let transform = Transform(Affine3A::from_translation(place));
        scene.spawn((transform, UsesShape(mesh), UsesMaterial(material)));
    }
    scene.flatten();
    let buffers = scene.buffers();
    let triangles = buffers.instances.len() * buffers.shapes.meshes[0].triangles.len();
    assert_eq!((buffers.instances.len(), triangles), (2000, 10_000_000));
    buffers.validate().expect("the columns fit together");
    let memory =
        peak_memory().map_or("unknown".into(), |bytes| format!("{:.0} MiB", bytes as f64 / f64::from(1 << 20)));
    println!("10 M triangles in 2,000 instances: {memory} at most, the whole process");
}

/// A million triangles.
fn tree(rounds: usize) {
    let mesh = Arc::new(hills(708));
    let times = (0..rounds).map(|_| {
        let start = Instant::now();
        let tree = MeshTree::build(mesh.clone(), TreeBuilder::default()).expect("the mesh is whole");
        let time = start.elapsed();
        tree.validate().expect("the tree holds every triangle");
        (time, tree.bytes())
    });
    let mut times: Vec<_> = times.collect();
    times.sort();
    let (median, bytes) = times[rounds / 2];
    println!(
        "tree over {} triangles: {:.2} s best, {:.2} s median, {} bytes a triangle\n",
        mesh.triangles.len(),
        times[0].0.as_secs_f64(),
        median.as_secs_f64(),
        bytes / mesh.triangles.len()
    );
}

/// Renders a scene of the gallery with one and two threads in turn.
fn tracing(name: &str, rounds: usize) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes").join(name).with_extension("ron");
    let settings = SettingsChoices { resolution: Some(UVec2::new(480, 270)), samples: Some(16), ..Default::default() };
    let mut session = Session::new(path, SessionOptions { settings, ..Default::default() });
    session.load().expect("the gallery is whole");
    session.flatten().expect("the gallery is whole");
    let (first, _, _) = render(&session, 1);
    let mut pairs = Vec::new();
    let mut best: Option<(Duration, Stats)> = None;
    for _ in 0..rounds {
        let (one_film, one, stats) = render(&session, 1);
        let (two_film, two, _) = render(&session, 2);
        assert!(one_film == first && two_film == first, "{name}: the picture depends on the threads");
        pairs.push((one, two));
        if best.as_ref().is_none_or(|(time, _)| one < *time) {
            best = Some((one, stats));
        }
    }
    let (time, stats) = best.expect("at least one round");
    let mut gains: Vec<f64> = pairs.iter().map(|(one, two)| one.as_secs_f64() / two.as_secs_f64()).collect();
    gains.sort_by(f64::total_cmp);
    println!(
        "{name}: {:.2} Mrays/s on one thread; two threads {:.2} times as fast (median of {rounds} pairs, {:.2} to {:.2})",
        stats.rays() as f64 / time.as_secs_f64() / 1e6,
        gains[rounds / 2],
        gains[0],
        gains[rounds - 1]
    );
    for stage in Stage::ALL {
        let rays: u64 =
            stats.depths.iter().flat_map(|depth| depth.counts.iter().map(|c| c.stages[stage as usize])).sum();
        if rays > 0 {
            let seconds = stats.time(stage).as_secs_f64();
            let share = 100.0 * seconds / time.as_secs_f64();
            println!("  {:<16} {:>8.2} Mrays/s {share:>6.1} % of the time", stage.name(), rays as f64 / seconds / 1e6);
        }
    }
    println!();
}

fn render(session: &Session, threads: usize) -> (Film, Duration, Stats) {
    let mut render =
        session.render(RenderOptions { threads, ..Default::default() }).expect("the gallery can be rendered");
    let start = Instant::now();
    while render.remaining() > 0 {
        render.pass(&Control::default());
    }
    (render.film().clone(), start.elapsed(), render.stats())
}
