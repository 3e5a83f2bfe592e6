//! One picture uses every stage and every queue.

use brewster_wavefront::Stage;
use brewster_wavefront::queues::RaySource;

use crate::scene::{load, render};

#[test]
fn one_picture_crosses_every_stage_and_every_queue() {
    let scene = load("shapes");
    let (_, stats) = render(&scene);
    let total = stats.total();
    for stage in Stage::ALL.into_iter().filter(|stage| stage.runs_in(scene.settings.integrator)) {
        assert!(total.stages[stage as usize] > 0, "no ray goes through {}", stage.name());
    }
    for source in RaySource::APART {
        assert!(stats.of_source(source).traced() > 0, "no {} ray", source.name());
    }
    let queues = [total.crossings, total.escaped, total.hits, total.shadow_rays, total.shadowed];
    assert!(queues.iter().all(|&rays| rays > 0), "{queues:?}");
}
