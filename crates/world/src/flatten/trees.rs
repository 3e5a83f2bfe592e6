//! The tree over all instances: built when instances come, go or get a shape with another end; refitted when they only move, as long
//! as that leaves a good tree.

use bevy_ecs::resource::Resource;
use bevy_ecs::system::{Res, ResMut};
use brewster_geometry::{TopTree, TreeBuilder};

use super::report::{FlattenReport, TopTreeEdit};
use super::{Buffers, Edits};

/// How trees are built.
#[derive(Resource, Default)]
pub(crate) struct Builder(pub(crate) TreeBuilder);

/// How the top tree has worn.
#[derive(Resource, Default)]
pub(super) struct Wear {
    /// Its area when it was built.
    area_when_built: f32,
    /// Instances that were refitted since its area was last looked at.
    refitted: usize,
}

/// A tree whose boxes have grown to this much of their area is built anew.
///
/// Rays slow down as the area grows, whoever moved: of 100,000 balls in a box, all moved by a ball's size made 1.17 times the area
/// and rays 1.25 times as slow, all moved by three sizes 2.0 and 1.9, 112 moved anywhere 2.2 and 2.3, 1,000 moved anywhere 9.5 and
/// 7.9. A build takes as long as tracing 100,000 rays.
const WORN: f32 = 1.2;

/// The area is looked at once this share of the instances was refitted: it costs as much as refitting a thousandth.
const LOOK_EVERY: usize = 1000;

/// Has the top tree follow the instances.
pub(super) fn fit_top_tree(
    builder: Res<Builder>,
    mut edits: ResMut<Edits>,
    mut wear: ResMut<Wear>,
    mut buffers: ResMut<Buffers>,
    mut report: ResMut<FlattenReport>,
) {
    let buffers = &mut buffers.0;
    let mut is_stale = edits.regrouped;
    if !is_stale && !edits.touched.is_empty() {
        edits.touched.sort_unstable();
        edits.touched.dedup();
        let mut top = std::mem::take(&mut buffers.trees.top);
        let refitted = top.refit(&buffers.geometry().instances(), &edits.touched);
        refitted.expect("instances are checked when their rows are written");
        report.top_tree = TopTreeEdit::Refitted(edits.touched.len());
        wear.refitted += edits.touched.len();
        if wear.refitted * LOOK_EVERY >= buffers.instances.len() {
            wear.refitted = 0;
            is_stale = top.half_area() > WORN * wear.area_when_built;
        }
        buffers.trees.top = top;
    }
    if is_stale {
        let instances = buffers.geometry().instances();
        let (top, planes) = (TopTree::build(&instances, builder.0), instances.planes());
        report.top_tree = TopTreeEdit::Rebuilt(instances.len());
        buffers.trees.top = top.expect("instances are checked when their rows are written");
        buffers.trees.planes = planes;
        *wear = Wear { area_when_built: buffers.trees.top.half_area(), refitted: 0 };
    }
}
