//! The same picture, bit for bit, and the same counts on any number of threads.

use crate::scene::{SCENES, counts, load, render_with};
use brewster_wavefront::Policy;

#[test]
fn one_two_and_seven_threads_agree() {
    // Several batches for every thread.
    let policy = Policy { batch: 256, capacity: 256, ..Policy::default() };
    for name in SCENES {
        let mut scene = load(name);
        scene.settings.samples = 3;
        let (film, stats) = render_with(&scene, policy, 1);
        for threads in [2, 7] {
            let (other, counted) = render_with(&scene, policy, threads);
            assert!(other == film, "{name} on {threads} threads is another picture");
            assert_eq!(counts(&counted), counts(&stats), "{name} on {threads} threads");
        }
    }
}
