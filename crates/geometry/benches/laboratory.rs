//! Rays per second on a ray dump, one JSON line a measurement: to be put beside other programs that trace the same dump.
//!
//! `cargo bench -p brewster-geometry --bench laboratory -- DUMP RUNS THREADS [one]`, with paths from the folder of the crate; with `one`
//! each ray goes by itself. A dump holds, little endian: u32 0x3159524c, vertices, triangles, sets; vertices as 3 f32; triangles as 3 u32; and for each set
//! its name in 16 bytes, u32 rays, u32 kind (0 nearest hit, 1 any hit), and the rays as 8 f32: origin, 0, direction, greatest t.
//!
//! A line has `engine`, `mesh`, `what`, `config` and `threads`, and a `build` line `tris`, `build_s` (median), `build_min_s` and `mbytes`; a
//! `trace` line `api`, `rays`, `n`, `mrays_median`, `mrays_best`, `hits` and `sumt`, the sum of all distances.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use brewster_geometry::*;
use brewster_lanes::Level;
use glam::{Affine3A, Vec3};

#[path = "../tests/support.rs"]
#[allow(dead_code, reason = "the tests use the rest")]
mod support;
use support::{RayColumns, Scene};

/// Rays that a thread takes at once.
const BATCH: usize = 16_384;

/// Rays of one kind.
struct Set {
    name: String,
    any: bool,
    rays: RayColumns,
    t_max: Vec<f32>,
}

/// Words of a file, one after the other.
struct Words<'a>(&'a [u8]);

impl<'a> Words<'a> {
    fn bytes(&mut self, count: usize) -> &'a [u8] {
        let (taken, rest) = self.0.split_at_checked(count).expect("the dump ends too early");
        self.0 = rest;
        taken
    }

    fn word(&mut self) -> [u8; 4] {
        self.bytes(4).try_into().expect("four bytes")
    }

    fn count(&mut self) -> usize {
        u32::from_le_bytes(self.word()) as usize
    }

    fn vector(&mut self) -> Vec3 {
        Vec3::from_array([(); 3].map(|()| f32::from_le_bytes(self.word())))
    }
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    let (dump, runs, threads, alone) = match arguments.as_slice() {
        [dump, runs, threads] => (dump, runs, threads, false),
        [dump, runs, threads, one] if one == "one" => (dump, runs, threads, true),
        // `cargo bench` starts all benches of a package.
        _ => return println!("laboratory: no dump was named"),
    };
    let number = |text: &String| text.parse::<usize>().ok().filter(|&number| number > 0).expect("a number above 0");
    let (runs, threads) = (number(runs), number(threads));
    let bytes = std::fs::read(dump).unwrap_or_else(|error| panic!("{dump}: {error}"));
    let mesh_name = std::path::Path::new(dump).file_stem().map_or(String::new(), |stem| stem.to_string_lossy().into());
    let (mesh, sets) = read(&bytes);
    rayon::ThreadPoolBuilder::new().num_threads(threads).build_global().expect("the pool is made once");
    let (kernel, api) = if alone { ("single", "ray") } else { ("wave", "columns") };
    let config = format!("{} {kernel}", Level::detect().name());
    let start = format!(r#"{{"engine":"brewster","mesh":"{mesh_name}","threads":{threads},"config":"{config}""#);

    let mesh = Arc::new(mesh);
    let mut built: Vec<f64> = Vec::new();
    let tree = loop {
        let begin = Instant::now();
        let tree = MeshTree::build(mesh.clone(), TreeBuilder::default()).expect("the mesh is sound");
        built.push(begin.elapsed().as_secs_f64());
        if built.len() == 3 {
            break tree;
        }
    };
    built.sort_by(f64::total_cmp);
    let (triangles, megabytes) = (mesh.triangles.len(), tree.bytes() as f64 / f64::from(1 << 20));
    println!(
        r#"{start},"what":"build","tris":{triangles},"build_s":{:.4},"build_min_s":{:.4},"mbytes":{megabytes:.1}}}"#,
        built[1], built[0]
    );

    let mut scene = Scene::default();
    let shape = scene.mesh(Arc::unwrap_or_clone(mesh));
    scene.place(shape, Affine3A::IDENTITY);
    let scene = scene.built();
    for set in &sets {
        // The first run warms up.
        let mut runs: Vec<(f64, (usize, f64))> = (0..=runs)
            .map(|_| {
                let begin = Instant::now();
                let found = trace(&scene, set, threads, alone);
                (begin.elapsed().as_secs_f64(), found)
            })
            .skip(1)
            .collect();
        let (hits, sum) = runs[0].1;
        assert!(runs.iter().all(|run| run.1.0 == hits), "all runs find the same hits");
        runs.sort_by(|a, b| a.0.total_cmp(&b.0));
        let n = set.t_max.len();
        let rate = |run: usize| n as f64 / runs[run].0 * 1e-6;
        println!(
            r#"{start},"what":"trace","api":"{api}","rays":"{}","n":{n},"mrays_median":{:.3},"mrays_best":{:.3},"hits":{hits},"sumt":{sum:.3}}}"#,
            set.name,
            rate(runs.len() / 2),
            rate(0),
        );
    }
}

fn read(bytes: &[u8]) -> (TriangleMesh, Vec<Set>) {
    let mut words = Words(bytes);
    assert_eq!(words.count(), 0x3159_524c, "the file is no ray dump");
    let [vertices, triangles, sets] = [(); 3].map(|()| words.count());
    let positions = (0..vertices).map(|_| words.vector()).collect();
    let triangles = (0..triangles).map(|_| [(); 3].map(|()| words.count() as u32)).collect();
    let mesh = TriangleMesh { positions, triangles, ..TriangleMesh::default() };
    let set = |_| {
        let name = String::from_utf8_lossy(words.bytes(16)).trim_end_matches('\0').to_owned();
        let (count, any) = (words.count(), words.count() == 1);
        let (mut rays, mut t_max) = (RayColumns::default(), Vec::new());
        for _ in 0..count {
            let origin = words.vector();
            assert_eq!(f32::from_le_bytes(words.word()), 0.0, "rays begin at their origin");
            rays.push(Ray { origin, direction: words.vector(), time: 0.0 });
            t_max.push(f32::from_le_bytes(words.word()));
        }
        Set { name, any, rays, t_max }
    };
    (mesh, (0..sets).map(set).collect())
}

/// How many rays hit, and the sum of their distances.
fn trace(scene: &Scene, set: &Set, threads: usize, alone: bool) -> (usize, f64) {
    let next = AtomicUsize::new(0);
    let work = || {
        let mut hits = HitColumns::new();
        hits.resize(BATCH, Hit::miss());
        let mut found = vec![false; BATCH];
        let (mut count, mut sum) = (0, 0.0);
        let mut memory = RayMemory::default();
        let mut one = RayByRay::new(scene.geometry(), Level::detect(), &mut memory);
        loop {
            let from = next.fetch_add(BATCH, Ordering::Relaxed);
            if from >= set.t_max.len() {
                return (count, sum);
            }
            let run = from..(from + BATCH).min(set.t_max.len());
            let Rays { origin, direction, .. } = set.rays.view();
            let rays = Rays {
                origin: origin.map(|c| &c[run.clone()]),
                direction: direction.map(|c| &c[run.clone()]),
                time: &[],
            };
            if alone && set.any {
                let t_max = &set.t_max[run];
                (0..rays.len()).for_each(|ray| found[ray] = one.occluded(&rays.get(ray), t_max[ray]));
                count += found[..rays.len()].iter().filter(|&&found| found).count();
            } else if set.any {
                occluded(&scene.geometry(), Level::detect(), rays, &set.t_max[run], &mut found);
                count += found[..rays.len()].iter().filter(|&&found| found).count();
            } else {
                if alone {
                    (0..rays.len()).for_each(|ray| hits.set(ray, one.closest_hit(&rays.get(ray))));
                } else {
                    closest_hits(&scene.geometry(), Level::detect(), rays, hits.view_mut());
                }
                for &t in &hits.view().t[..rays.len()] {
                    let hit = t < f32::INFINITY;
                    count += usize::from(hit);
                    sum += if hit { f64::from(t) } else { 0.0 };
                }
            }
        }
    };
    if threads == 1 {
        return work();
    }
    std::thread::scope(|scope| {
        let workers: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
        let found = workers.into_iter().map(|worker| worker.join().expect("no thread panics"));
        found.fold((0, 0.0), |sum, found| (sum.0 + found.0, sum.1 + found.1))
    })
}
