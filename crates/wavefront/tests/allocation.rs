//! No stage allocates: once its queues have grown to what tiles need, a batch follows their rays without taking memory.

#![expect(unsafe_code, reason = "an allocator that counts is the only way to see allocations")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::path::Path;
use std::time::Instant;

use brewster_buffers::{Integrator, SceneBuffers};
use brewster_film::{Film, PixelOrder};
use brewster_import::Importer;
use brewster_wavefront::batch::Batch;
use brewster_wavefront::context::Context;
use brewster_wavefront::integrator::{megakernel, path, whitted};
use brewster_wavefront::stats::Recorder;
use brewster_wavefront::{Executor, Policy, QueueOrder, SortKey, Stage};
use brewster_world::Scene;

/// The system's allocator, counting.
struct Counting;

thread_local! {
    /// Allocations of this thread so far.
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

// SAFETY: everything is passed on to the system's allocator; counting allocates nothing, since the thread's counter is
// a constant at first and has nothing to drop.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.set(ALLOCATIONS.get() + 1);
        // SAFETY: the caller's promises are the system's conditions.
        unsafe { System.alloc(layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        ALLOCATIONS.set(ALLOCATIONS.get() + 1);
        // SAFETY: the caller's promises are the system's conditions.
        unsafe { System.realloc(pointer, layout, size) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller's promises are the system's conditions.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

/// Follows one sample of every pixel, tile by tile; the allocations of the integrator's calls, and not those of the list of
/// tiles.
fn pass(context: &Context<'_>, batch: &mut Batch) -> usize {
    let size = context.scene.settings.resolution;
    let mut film = Film::new(PixelOrder::new(size.x, size.y, None).expect("a small picture"));
    let mut tiles = film.tiles_mut(context.policy.batch);
    let before = ALLOCATIONS.get();
    for tile in &mut tiles {
        match (context.policy.executor, context.scene.settings.integrator) {
            (Executor::Megakernel, _) => megakernel(context, 0..1, batch, tile),
            (Executor::Wavefront, Integrator::Whitted) => whitted(context, 0..1, batch, tile),
            (Executor::Wavefront, Integrator::Path) => path(context, 0..1, batch, tile),
        }
    }
    ALLOCATIONS.get() - before
}

/// A scene from a file of the tests.
fn scene(name: &str) -> SceneBuffers {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests").join(name);
    let loaded = Importer::default().load(&path).unwrap_or_else(|failure| panic!("{failure}"));
    let mut scene = Scene::new();
    loaded.scene.apply(scene.world_mut());
    scene.flatten();
    scene.buffers().clone()
}

/// Every one of `stages` is run and none allocates.
fn check(scene: &SceneBuffers, stages: &[Stage], policy: Policy) {
    let context = Context::new(scene, &scene.cameras[0], policy);
    let depth = scene.settings.max_depth;
    let mut batch = Batch::new(depth, policy.capacity, Recorder::new(depth, 0, Instant::now(), false));
    assert!(pass(&context, &mut batch) > 0, "the allocator does not count");
    let first = batch.recorder.stats.total();
    assert_eq!(pass(&context, &mut batch), 0, "allocations in the second pass by {policy:?}");
    let second = batch.recorder.stats.total();
    for &stage in stages {
        let rays = second.stages[stage as usize] - first.stages[stage as usize];
        assert!(rays > 0, "no ray goes through {} by {policy:?}", stage.name());
    }
}

/// In tiles smaller and larger than what is traced at once, with every queue order and shadow.
#[test]
fn a_second_pass_over_the_tiles_allocates_nothing() {
    // A scene whose rays go through every stage and every queue.
    let mut scene = scene("scenes/shapes.ron");
    let stages: Vec<Stage> = Stage::ALL.into_iter().filter(|stage| stage.runs_in(Integrator::Whitted)).collect();
    for transparent in [false, true] {
        scene.settings.transparent_shadows = transparent;
        for (batch, capacity) in [(64, 4096), (4096, 4096), (1000, 64), (1000, 7)] {
            for (sort, order) in [
                (SortKey::None, QueueOrder::ReflectionFirst),
                (SortKey::Octant, QueueOrder::TransmissionFirst),
                (SortKey::OctantMorton, QueueOrder::Merged),
            ] {
                check(&scene, &stages, Policy { batch, capacity, sort, order, ..Policy::default() });
            }
        }
    }
}

#[test]
fn nor_does_a_second_pass_of_paths() {
    let always = [Stage::Generate, Stage::Trace, Stage::Absorb, Stage::Sort, Stage::Record, Stage::Gather, Stage::Fold];
    for (name, own) in [
        ("absorbing-glass", Stage::ScatterDielectric),
        ("many-lights", Stage::Shadow),
        ("metals-rough", Stage::ScatterMetal),
    ] {
        let mut scene = scene(&format!("references/{name}.ron"));
        scene.settings.resolution /= 4;
        let stages: Vec<Stage> = always.into_iter().chain([own]).collect();
        for (batch, capacity) in [(64, 4096), (4096, 4096), (1000, 7)] {
            check(&scene, &stages, Policy { batch, capacity, ..Policy::default() });
        }
    }
}

/// Through fog, from boundary to boundary, and past them toward lights.
#[test]
fn nor_does_a_second_pass_through_media() {
    let scene = scene("scenes/fog.ron");
    let stages = [Stage::Fly, Stage::ScatterMedium, Stage::Cross, Stage::Shadow, Stage::ScatterPrincipled];
    for (batch, capacity) in [(64, 4096), (4096, 4096), (1000, 7)] {
        check(&scene, &stages, Policy { batch, capacity, ..Policy::default() });
    }
}

#[test]
fn nor_does_a_second_pass_without_queues() {
    let policy = Policy { executor: Executor::Megakernel, ..Policy::default() };
    check(&scene("scenes/shapes.ron"), &[Stage::Trace, Stage::ShadeDielectric, Stage::Shadow], policy);
    let mut scene = scene("references/absorbing-glass.ron");
    scene.settings.resolution /= 4;
    check(&scene, &[Stage::Trace, Stage::ScatterDielectric], policy);
}
