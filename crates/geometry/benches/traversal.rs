//! Rays per second of every kernel, round by round in one process, on three scenes. A figure counts only if all kernels agree on
//! every hit; they are compared first.
//!
//! `cargo bench -p brewster-geometry --bench traversal [-- ROUNDS]`; one thread. The machine's minutes differ: compare only
//! figures of one run, best with best.

use std::time::{Duration, Instant};

use brewster_geometry::*;
use brewster_lanes::Level;
use glam::{Quat, Vec3};

#[path = "../tests/support.rs"]
#[allow(dead_code, reason = "the tests use the rest")]
mod support;
use support::*;

fn main() {
    let rounds = std::env::args().filter_map(|argument| argument.parse().ok()).next().unwrap_or(5);
    for (name, make) in [("blob", blob as fn() -> Scene), ("field", field), ("spheres", spheres)] {
        let begin = Instant::now();
        let scene = make();
        let bytes = scene.mesh_trees.iter().map(MeshTree::bytes).sum::<usize>() + scene.top.bytes();
        println!("{name}: made in {:.2?}, trees of {:.1} MB", begin.elapsed(), bytes as f64 * 1e-6);
        study(&scene, rounds);
    }
}

/// One displaced ball of 1.3 million triangles.
fn blob() -> Scene {
    let mesh = ball(8, hills);
    let mut scene = Scene::default();
    let begin = Instant::now();
    let shape = scene.mesh(mesh);
    println!("blob: tree built in {:.2?}", begin.elapsed());
    scene.place(shape, placed(Vec3::ONE, Quat::IDENTITY, Vec3::ZERO));
    scene.built()
}

/// Two thousand rocks of 5,120 triangles on a plane.
fn field() -> Scene {
    let mut random = Random::new(1);
    let (mut scene, shapes) = Scene::with_every_analytic_shape();
    let rock = scene.mesh(ball(4, hills));
    for _ in 0..2000 {
        let at = Vec3::new(random.signed(), 0.0, random.signed()) * 1.5;
        scene.place(rock, placed(Vec3::splat(0.02 + 0.03 * random.unit()), random.rotation(), at));
    }
    scene.place(shapes[1], placed(Vec3::ONE, Quat::IDENTITY, Vec3::new(0.0, -0.05, 0.0)));
    scene.built()
}

/// A hundred thousand spheres.
fn spheres() -> Scene {
    let mut random = Random::new(2);
    let (mut scene, shapes) = Scene::with_every_analytic_shape();
    for _ in 0..100_000 {
        scene.place(shapes[0], placed(Vec3::splat(0.02), Quat::IDENTITY, random.cube()));
    }
    scene.built()
}

/// Camera rays in tiles, two bounces of them, and shadow rays from the first hits.
fn ray_sets(scene: &Scene) -> Vec<(&'static str, RayColumns)> {
    let side = 512;
    let eye = Vec3::new(0.7, 1.2, 3.4);
    let forward = -eye.normalize();
    let right = forward.cross(Vec3::Y).normalize();
    let up = right.cross(forward);
    let primary: RayColumns = (0..side * side)
        .map(|i: usize| {
            let tile = i / 64;
            let (x, y) = (tile % (side / 8) * 8 + i % 8, tile / (side / 8) * 8 + i / 8 % 8);
            let at = |pixel: usize| (pixel as f32 + 0.5) / side as f32 * 0.8 - 0.4;
            Ray { origin: eye, direction: (forward + right * at(x) + up * at(y)).normalize(), time: 0.0 }
        })
        .collect();
    let mut random = Random::new(3);
    let mut leave = |from: &RayColumns, toward: &dyn Fn(&mut Random, &SurfacePoint) -> Vec3| -> RayColumns {
        let hits = hits_of(scene, Level::detect(), from.view());
        (0..hits.len())
            .filter(|&i| !hits.get(i).is_miss())
            .map(|i| {
                let ray = from.view().get(i);
                let mut point = surface(&scene.geometry(), &ray, &hits.get(i));
                if point.geometric_normal.dot(ray.direction) > 0.0 {
                    point.geometric_normal = -point.geometric_normal;
                }
                let direction = toward(&mut random, &point);
                Ray { origin: offset_origin(&point, direction), direction, time: 0.0 }
            })
            .collect()
    };
    let cosine =
        |random: &mut Random, point: &SurfacePoint| (point.geometric_normal * 1.0001 + random.direction()).normalize();
    let bounce = leave(&primary, &cosine);
    let bounce2 = leave(&bounce, &cosine);
    let lamp = |random: &mut Random, point: &SurfacePoint| {
        (Vec3::new(random.signed(), 4.0, random.signed()) - point.position).normalize()
    };
    let shadow = leave(&primary, &lamp);
    vec![("primary", primary), ("bounce", bounce), ("bounce2", bounce2), ("shadow", shadow)]
}

/// Time that this thread has had the processor, where the system says; neighbors then count less. Linux brings it up to date when a thread
/// yields, otherwise at ticks, 4 ms apart.
fn worked() -> Duration {
    std::thread::yield_now();
    static START: std::sync::LazyLock<Instant> = std::sync::LazyLock::new(Instant::now);
    let told = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let nanoseconds = told.and_then(|told| told.split(' ').next()?.parse().ok());
    nanoseconds.map_or_else(|| START.elapsed(), Duration::from_nanos)
}

fn study(scene: &Scene, rounds: usize) {
    for (name, rays) in ray_sets(scene) {
        let rays = rays.view();
        // Every level, many rays at a time and one.
        let kernels: Vec<(Level, bool)> = [false, true]
            .into_iter()
            .flat_map(|alone| Level::available().into_iter().map(move |level| (level, alone)))
            .collect();
        let reference = hits_of(scene, Level::BASELINE, rays);
        let limits = vec![f32::INFINITY; rays.len()];
        let mut best = vec![Duration::MAX; kernels.len()];
        let mut hits = HitColumns::new();
        hits.resize(rays.len(), Hit::miss());
        let mut out = vec![false; rays.len()];
        let mut memory = RayMemory::default();
        for _ in 0..rounds {
            for (&(level, alone), best) in kernels.iter().zip(&mut best) {
                let mut one = RayByRay::new(scene.geometry(), level, &mut memory);
                let begin = worked();
                match (name == "shadow", alone) {
                    (true, false) => occluded(&scene.geometry(), level, rays, &limits, &mut out),
                    (true, true) => (0..rays.len()).for_each(|i| out[i] = one.occluded(&rays.get(i), limits[i])),
                    (false, false) => closest_hits(&scene.geometry(), level, rays, hits.view_mut()),
                    (false, true) => (0..rays.len()).for_each(|i| hits.set(i, one.closest_hit(&rays.get(i)))),
                }
                *best = (worked() - begin).min(*best);
                if name == "shadow" {
                    assert!((0..rays.len()).all(|i| out[i] != reference.get(i).is_miss()), "{level:?} disagrees");
                } else {
                    assert!(hits == reference, "{level:?} disagrees");
                }
            }
        }
        print!(
            "  {name:8} {:7} rays, {:7} hit; Mrays/s",
            rays.len(),
            (0..rays.len()).filter(|&i| !reference.get(i).is_miss()).count()
        );
        for ((level, alone), best) in kernels.iter().zip(&best) {
            let rate = rays.len() as f64 / best.as_secs_f64() * 1e-6;
            print!("  {}{} {rate:.2}", level.name(), if *alone { " alone" } else { "" });
        }
        println!();
    }
}
