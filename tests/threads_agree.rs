//! The same picture, bit for bit, and the same counts on any number of threads.

use brewster_buffers::SceneBuffers;
use brewster_tests::agreement::REFERENCES;
use brewster_wavefront::Policy;

use crate::scene::{SCENES, counts, load, render_with, small_reference};

fn check(name: &str, scene: &SceneBuffers) {
    // Several batches for every thread.
    let policy = Policy { batch: 256, capacity: 256, ..Policy::default() };
    let (film, stats) = render_with(scene, policy, 1);
    for threads in [2, 7] {
        let (other, counted) = render_with(scene, policy, threads);
        assert!(other == film, "{name} on {threads} threads is another picture");
        assert_eq!(counted.attribution, stats.attribution, "{name} on {threads} threads");
        assert_eq!(counts(&counted), counts(&stats), "{name} on {threads} threads");
    }
}

#[test]
fn one_two_and_seven_threads_agree() {
    for name in SCENES.into_iter().chain(["principled", "fog", "moving", "moving_paths", "caustics"]) {
        let mut scene = load(name);
        scene.settings.samples = 3;
        check(name, &scene);
    }
}

#[test]
fn paths_on_one_two_and_seven_threads_agree() {
    REFERENCES.iter().for_each(|name| check(name, &small_reference(name)));
}
