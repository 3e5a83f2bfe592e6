//! A split tree of any depth stays within the memory that the page of the queues states.

use brewster_buffers::SceneBuffers;
use brewster_geometry::HitColumns;
use brewster_wavefront::Policy;
use brewster_wavefront::queues::{
    ContributionQueue, CrossingQueue, EscapedQueue, PathRayColumns, SampleColumns, ShadowQueue, SurfaceHitColumns,
};

use crate::scene::{load, render_with};

/// The most bytes that a batch's queues may take, as the head of `queues/mod.rs` counts rows.
fn bound(scene: &SceneBuffers, camera_rays: usize, capacity: usize) -> usize {
    let waiting = camera_rays + capacity * (2 + 4 * scene.settings.max_depth as usize);
    let hits = HitColumns::BYTES_PER_ROW;
    // Those on five kinds of material, and those that became nothing.
    let sorted = 5 * SurfaceHitColumns::BYTES_PER_ROW + CrossingQueue::BYTES_PER_ROW + EscapedQueue::BYTES_PER_ROW;
    let toward_lights = ShadowQueue::BYTES_PER_ROW + hits + size_of::<bool>();
    (waiting + 4 * capacity) * PathRayColumns::BYTES_PER_ROW
        + 2 * capacity * (hits + sorted)
        + 4 * capacity * ContributionQueue::BYTES_PER_ROW
        + camera_rays * SampleColumns::BYTES_PER_ROW
        + 2 * capacity.max(scene.lights.len()) * toward_lights
}

#[test]
fn in_a_glass_of_water_at_every_capacity_and_depth() {
    let mut scene = load("nested");
    for transparent in [false, true] {
        scene.settings.transparent_shadows = transparent;
        for max_depth in [1, 5, 9] {
            scene.settings.max_depth = max_depth;
            for capacity in [64, 256] {
                let policy = Policy { batch: 1000, capacity, ..Policy::default() };
                let (_, stats) = render_with(&scene, policy, 1);
                let bound = bound(&scene, policy.batch, capacity);
                let context = format!("depth {max_depth}, {policy:?}");
                assert!(stats.queue_bytes <= bound, "{context}: {} bytes, not {bound}", stats.queue_bytes);
                // The bound says something: the queues come near it.
                assert!(2 * stats.queue_bytes > bound, "{context}: {} bytes of {bound}", stats.queue_bytes);
            }
        }
    }
    let widest = render_with(&scene, Policy::default(), 1)
        .1
        .depths
        .iter()
        .map(|at| at.counts.map(|c| c.traced()).iter().sum::<u64>())
        .max();
    assert!(widest.is_some_and(|rays| rays > 10_000), "the tree is cut nowhere: {widest:?} rays at its widest");
}
