//! The path integrator's ledger closes: to the last digit where it is arithmetic, in mean where it is chance.

use brewster_buffers::SceneBuffers;
use brewster_wavefront::ledger::Ledger;
use brewster_wavefront::{Counts, Policy, Stats};

use crate::scene::{parse, render_with};

/// A scene with everything that gains or loses energy: absorbing and overlapping glass, rough and smooth metal, diffuse and
/// rough diffuse surfaces, thin films, dispersion, principled surfaces, a mesh whose shading normals are far from its own, a lamp.
fn scene() -> SceneBuffers {
    parse(
        r#"Scene(
            settings: (integrator: Path, resolution: (48, 32), samples: 16, max_depth: 12, filter: Box),
            camera: Perspective(eye: (0, 1.5, 6), target: (0, 0.8, 0), vfov: 40),
            background: Gradient(horizon: (1, 0.9, 0.8), zenith: (0.3, 0.5, 1), ground: 0.2),
            shapes: {"ball": Mesh(file: "ball.obj")},
            materials: {
                "floor": Lambert(albedo: Checker(a: 0.2, b: (0.8, 0.7, 0.5), size: 0.1)),
                "gold": Metal(of: "Au"),
                "dull gold": Metal(of: "Au", alpha: 0.3),
                "paint": Metal(r0: (0.9, 0.3, 0.2), alpha: 0.1),
                "bright gold": Metal(of: "Au", alpha: 0.6, compensated: true),
                "temper": Metal(of: "Fe", alpha: 0.15, film: (ior: 2.2, thickness: 60)),
                "bottle": Dielectric(ior: 1.5, absorption: (1.2, 0.3, 0.9), priority: 1),
                "wine": Dielectric(ior: 1.34, absorption: (0.2, 2, 1.5)),
                "frost": Dielectric(ior: 1.5, alpha: 0.2),
                "oily frost": Dielectric(ior: 1.5, alpha: 0.3, film: (ior: 1.3, thickness: 350)),
                "flint": Dielectric(ior: 1.7, dispersion: Abbe(number: 25)),
                "china": Coated(base: Lambert(albedo: (0.8, 0.85, 0.9)), roughness: 0.3),
                "lacquer": Coated(base: Metal(of: "Cu", alpha: 0.2), absorption: (10, 200, 900)),
                "plastic": Principled(base_color: (0.9, 0.5, 0.1), roughness: 0.5),
                "milk glass": Principled(transmission: 0.6, roughness: 0.3, diffuse_transmission: 0.5, clearcoat: 1, volume: ()),
                "bubble": Dielectric(ior: 1, film: (ior: 1.33, thickness: 420)),
            },
            entities: [
                (shape: Quad(size: (12, 12)), material: "floor", rotate: (x: -90)),
                (shape: Sphere(radius: 0.7), material: "gold", at: (-2, 0.7, 0)),
                (shape: Sphere(radius: 0.7), material: "dull gold", at: (-0.5, 0.7, -1)),
                (shape: Sphere(radius: 0.5), material: "paint", at: (2.3, 0.5, -0.6)),
                (shape: Sphere(radius: 0.7), material: "bottle", at: (0.6, 0.7, 0.8)),
                (shape: Sphere(radius: 0.6), material: "wine", at: (0.7, 0.7, 0.7)),
                (shape: Sphere(radius: 0.6), material: "frost", at: (-1, 0.6, 1.4)),
                (shape: Sphere(radius: 0.4), material: "temper", at: (-2.4, 0.4, 1.2)),
                (shape: Sphere(radius: 0.5), material: "oily frost", at: (0.1, 0.5, 2)),
                (shape: Sphere(radius: 0.4), material: "bubble", at: (-0.2, 1.7, 0.5)),
                (shape: Sphere(radius: 0.4), material: "flint", at: (1.5, 0.4, 2)),
                (shape: Sphere(radius: 0.4), material: "bright gold", at: (-1.6, 0.4, 2.2)),
                (shape: Sphere(radius: 0.3), material: "china", at: (1.2, 0.3, 2.8)),
                (shape: Sphere(radius: 0.3), material: "lacquer", at: (-0.6, 0.3, 2.8)),
                (shape: Sphere(radius: 0.5), material: "plastic", at: (-2.8, 0.5, 0.4)),
                (shape: Sphere(radius: 0.4), material: "milk glass", at: (2.8, 0.4, 0.6)),
                (shape: "ball", material: "bottle", at: (2, 0.8, 1), scale: 0.6),
                (shape: Sphere(radius: 0.2), material: Emissive(radiance: 8), at: (0.5, 3, 1)),
                (light: Point(intensity: 10), at: (-2, 4, 3)),
            ],
        )"#,
    )
}

fn stats(scene: &SceneBuffers, threads: usize) -> Stats {
    render_with(scene, Policy { ledger: true, ..Policy::default() }, threads).1
}

/// A depth's counts and energies, over its queues.
fn sums(stats: &Stats) -> Vec<(Vec<Counts>, Ledger)> {
    stats.depths.iter().map(|depth| (depth.counts.to_vec(), depth.ledger())).collect()
}

#[test]
fn what_enters_leaves_to_the_last_digit() {
    let scene = scene();
    for split_depth in [0, 3] {
        let mut scene = scene.clone();
        scene.settings.split_depth = split_depth;
        let depths = sums(&stats(&scene, 1));
        let samples = i64::from(scene.settings.resolution.element_product() * scene.settings.samples);
        let mut sent = [samples << 24; 3];
        for (depth, (_, of)) in depths.iter().enumerate() {
            for (channel, sent) in sent.iter_mut().enumerate() {
                let at = |energy: brewster_wavefront::ledger::Energy| energy.0[channel];
                let context = format!("depth {depth}, channel {channel}, split below {split_depth}");
                let became = at(of.volume) + at(of.escaped) + at(of.crossed) + at(of.emitters) + at(of.cut);
                assert_eq!(at(of.entered), became + at(of.scattered), "{context}");
                assert_eq!(at(of.entered), *sent + at(of.crossed), "{context}");
                let scattered = at(of.absorbed) + at(of.residual) + at(of.below_surface) + at(of.onward);
                let scattered = scattered + at(of.roulette_removed) - at(of.roulette_added);
                assert_eq!(at(of.scattered) + at(of.recolored), scattered, "{context}");
                *sent = at(of.onward);
            }
        }
        assert_eq!(sent, [0; 3]);
    }
}

#[test]
fn rays_are_counted_without_remainder() {
    for (depth, (queues, _)) in sums(&stats(&scene(), 1)).iter().enumerate() {
        for counts in queues {
            assert_eq!(counts.traced(), counts.hits + counts.escaped + counts.crossings, "depth {depth}");
            let on_emitters = counts.stages[brewster_wavefront::Stage::ShadeEmissive as usize];
            let sent = counts.reflections + counts.transmissions;
            let ended = counts.given_up + counts.absorbed + counts.cut_by_depth;
            assert_eq!(counts.hits - on_emitters + counts.branched, sent + ended, "depth {depth}");
        }
    }
}

#[test]
fn surfaces_absorb_what_theory_expects() {
    let mut scene = scene();
    scene.settings.samples = 64;
    for (depth, (_, ledger)) in sums(&stats(&scene, 2)).iter().enumerate() {
        for (channel, z) in ledger.z().into_iter().enumerate() {
            assert!(z.abs() < 4.0, "depth {depth}, channel {channel}: {z:.1} standard errors");
        }
        let [removed, added] = [ledger.roulette_removed, ledger.roulette_added].map(|energy| energy.value()[0]);
        let scale = removed.max(added);
        assert!((removed - added).abs() < 0.1 * scale + 20.0, "depth {depth}: roulette took {removed}, gave {added}");
    }
}

#[test]
fn the_ledger_is_the_same_on_any_number_of_threads() {
    let scene = scene();
    assert_eq!(sums(&stats(&scene, 1)), sums(&stats(&scene, 2)));
}
