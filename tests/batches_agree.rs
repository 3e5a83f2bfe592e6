//! The same picture, bit for bit, and the same counts however work is scheduled: in batches of any size, with levels cut at any
//! capacity, either queue first or both as one, rays sorted by any key or not, escaped ones parted in either way, by every kernel on
//! every instruction set, all samples in one pass or few at a time, and without any queue.

use std::sync::Arc;

use brewster_buffers::SceneBuffers;
use brewster_geometry::{Kernel, ObvhsTrees};
use brewster_lanes::Level;
use brewster_wavefront::queues::RaySource;
use brewster_wavefront::stats::DepthStats;
use brewster_wavefront::{Compaction, Control, Executor, Policy, QueueOrder, Renderer, SortKey, Stats};
use glam::UVec2;

use crate::scene::{SCENES, counts, film, load, load_file, render_with, small_reference};

const SAMPLES: u32 = 4;

/// Reference scenes whose paths meet every kind of surface and light.
const PATHS: [&str; 5] = ["absorbing-glass", "diffuse-box", "glass-rough", "many-lights", "metals-rough"];

fn scene(name: &str) -> SceneBuffers {
    let mut scene = load(name);
    scene.settings.samples = SAMPLES;
    scene.settings.resolution /= 2;
    scene
}

/// The scene with obvhs's trees beside its own.
fn with_obvhs(mut scene: SceneBuffers) -> SceneBuffers {
    let eye = scene.cameras[0].position.abs().max_element();
    scene.trees.obvhs = Some(Arc::new(ObvhsTrees::build(&scene.geometry(), eye)));
    scene
}

#[track_caller]
fn check(name: &str, scene: &SceneBuffers, policies: impl IntoIterator<Item = Policy>) {
    let (film, stats) = render_with(scene, Policy::default(), 1);
    for policy in policies {
        let (other, counted) = render_with(scene, policy, 1);
        assert!(other == film, "{name} is another picture by {policy:?}");
        assert_eq!(counted.attribution, stats.attribution, "{name} by {policy:?}");
        if policy.order == QueueOrder::Merged {
            let totals = |stats: &Stats| stats.depths.iter().map(DepthStats::total).collect::<Vec<_>>();
            assert_eq!(totals(&counted), totals(&stats), "{name} by {policy:?}");
            // Crossings that fill their queue go before all others, by themselves.
            assert!(counted.of_source(RaySource::Merged).traced() > 0, "{name} by {policy:?}");
            assert_eq!(counted.of_source(RaySource::Reflection).traced(), 0, "{name} by {policy:?}");
        } else {
            assert_eq!(counts(&counted), counts(&stats), "{name} by {policy:?}");
        }
    }
}

/// From one pixel at a time to the whole picture at once.
#[test]
fn in_batches_of_any_size() {
    for name in SCENES.into_iter().chain(["moving", "moving_paths", "caustics"]) {
        let sizes = [1, 13, 200, 1_000_000];
        check(name, &scene(name), sizes.map(|batch| Policy { batch, ..Policy::default() }));
    }
}

/// Paths too: what a sample found is summed before it is squared, whatever the batch.
#[test]
fn paths_in_batches_of_any_size_cut_at_any_capacity() {
    for name in PATHS {
        let sizes = [(1, 4096), (13, 7), (200, 1_000_000), (1_000_000, 100)];
        let policies = sizes.map(|(batch, capacity)| Policy { batch, capacity, ..Policy::default() });
        check(name, &small_reference(name), policies);
    }
    for name in ["principled", "fog"] {
        let policies = [(1, 4096), (13, 7), (1_000_000, 100)];
        let policies = policies.map(|(batch, capacity)| Policy { batch, capacity, ..Policy::default() });
        check(name, &scene(name), policies);
    }
}

/// From one ray at a time: levels are cut and finished part by part.
#[test]
fn with_levels_cut_at_any_capacity() {
    for name in ["nested", "smooth", "shapes", "slabs"] {
        let capacities = [1, 7, 100, 1_000_000];
        check(name, &scene(name), capacities.map(|capacity| Policy { capacity, ..Policy::default() }));
    }
}

/// Every order, key and kernel beside different others, and capacities that are smaller than a batch.
#[test]
fn in_any_order_on_every_instruction_set() {
    let cases = [
        (QueueOrder::ReflectionFirst, SortKey::None, Kernel::Packets, 50),
        (QueueOrder::TransmissionFirst, SortKey::None, Kernel::Single, 4096),
        (QueueOrder::ReflectionFirst, SortKey::Octant, Kernel::Wave, 4096),
        (QueueOrder::TransmissionFirst, SortKey::Octant, Kernel::Packets, 50),
        (QueueOrder::TransmissionFirst, SortKey::Material, Kernel::Single, 50),
        (QueueOrder::ReflectionFirst, SortKey::Morton, Kernel::Packets, 4096),
        (QueueOrder::Merged, SortKey::OctantMorton, Kernel::Wave, 50),
        (QueueOrder::Merged, SortKey::None, Kernel::Packets, 4096),
        (QueueOrder::ReflectionFirst, SortKey::None, Kernel::Obvhs, 4096),
    ];
    let mut policies = Vec::new();
    for level in Level::available() {
        policies.extend(cases.map(|(order, sort, kernel, capacity)| Policy {
            batch: 300,
            capacity,
            order,
            sort,
            kernel,
            level,
            ..Policy::default()
        }));
        policies.push(Policy { compaction: Compaction::Cursor, batch: 300, level, ..Policy::default() });
    }
    for name in
        ["colored_shadows", "fog", "nested", "principled", "shapes", "smooth", "moving", "moving_paths", "caustics"]
    {
        check(name, &with_obvhs(scene(name)), policies.iter().copied());
    }
    for name in PATHS {
        check(name, &with_obvhs(small_reference(name)), policies.iter().copied());
    }
}

/// obvhs's trees lead to the same hits on every scene of the gallery, as it is but for its size.
#[test]
fn by_another_traversal_on_the_whole_gallery() {
    let mut names = Vec::new();
    for entry in std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes")).expect("the gallery") {
        let path = entry.expect("it can be read").path();
        if path.extension().is_none_or(|extension| extension != "ron") {
            continue;
        }
        let mut scene = load_file(&path);
        scene.settings.samples = 1;
        scene.settings.resolution = UVec2::new(24, 16);
        let name = path.file_stem().expect("a name").to_string_lossy().into_owned();
        check(&name, &with_obvhs(scene), [Policy { kernel: Kernel::Obvhs, ..Policy::default() }]);
        names.push(name);
    }
    assert!(names.len() >= 25, "{names:?}");
}

/// Path after path, ray by ray: neither queues nor the traversal of many rays have a say in what is found.
#[test]
fn without_queues() {
    let policies = Level::available().into_iter();
    let policies = policies.map(|level| Policy { executor: Executor::Megakernel, level, ..Policy::default() });
    let policies: Vec<Policy> = policies.flat_map(|policy| [policy, Policy { batch: 13, ..policy }]).collect();
    for name in SCENES.into_iter().chain(["moving", "moving_paths", "caustics"]) {
        check(name, &scene(name), policies.iter().copied());
    }
    for name in ["principled", "details", "fog"] {
        check(name, &scene(name), policies.iter().copied());
    }
    for name in PATHS {
        let mut scene = small_reference(name);
        check(name, &scene, policies.iter().copied());
        (scene.settings.split_depth, scene.settings.clamp) = (3, 0.5);
        check(name, &scene, policies.iter().copied());
    }
}

/// A survey changes no picture, depends on no thread, and counts the rays that the stages count.
#[test]
fn with_a_close_look_at_the_queues() {
    for (name, scene) in [("shapes", scene("shapes")), ("diffuse-box", small_reference("diffuse-box"))] {
        let policy = Policy { batch: 300, survey: true, ..Policy::default() };
        check(name, &scene, [policy]);
        let surveyed = |threads| {
            let mut renderer = Renderer::new(&scene, 0, threads, policy, false).expect("the scene can be rendered");
            assert!(renderer.pass(0..scene.settings.samples, &mut film(&scene), &Control::default()));
            (renderer.survey().expect("one was asked for"), renderer.stats())
        };
        let (survey, stats) = surveyed(1);
        assert!(survey == surveyed(3).0, "{name}: the survey depends on threads");
        for (seen, counted) in survey.depths.iter().flatten().zip(stats.depths.iter().flat_map(|depth| &depth.counts)) {
            assert_eq!(seen.rays, counted.traced(), "{name}");
            assert_eq!(seen.lengths.iter().sum::<u64>(), seen.taken, "{name}");
            assert!(seen.octant_runs <= seen.rays && seen.material_runs <= seen.rays, "{name}: {seen:?}");
            assert!(seen.rays == 0 || seen.octant_runs > 0 && seen.visits[0] + seen.visits[1] > 0, "{name}: {seen:?}");
        }
    }
}

/// Passes of any number of samples add up, and so do films that got some samples each.
#[test]
fn in_any_number_of_passes() {
    let scenes = ["lights", "prism"].map(|name| (name, scene(name)));
    for (name, scene) in scenes.into_iter().chain(PATHS.map(|name| (name, small_reference(name)))) {
        let (whole, stats) = render_with(&scene, Policy::default(), 1);
        let renderer = || Renderer::new(&scene, 0, 1, Policy::default(), false).expect("the scene can be rendered");
        let passes = [0..1, 1..3, 3..SAMPLES];

        let (mut sum, mut one) = (film(&scene), renderer());
        for samples in passes.clone() {
            assert!(one.pass(samples, &mut sum, &Control::default()));
        }
        assert!(sum == whole, "{name} is another picture in passes");
        assert_eq!(one.stats().attribution, stats.attribution, "{name} in passes");
        assert_eq!(counts(&one.stats()), counts(&stats), "{name} in passes");

        let mut merged = film(&scene);
        for samples in passes.into_iter().rev() {
            let mut part = film(&scene);
            assert!(renderer().pass(samples, &mut part, &Control::default()));
            merged.merge(&part).expect("films of one size");
        }
        assert!(merged == whole, "{name} is another picture merged");
    }
}
