//! The tree over all instances.

use bevy_ecs::system::{Res, ResMut};
use brewster_geometry::TopTree;

use super::report::{FlattenReport, TopTreeEdit};
use super::{Buffers, Edits};

/// Builds the top tree if instances came, went or changed their kind of shape; refits it if some only moved.
pub(super) fn fit_top_tree(edits: Res<Edits>, mut buffers: ResMut<Buffers>, mut report: ResMut<FlattenReport>) {
    let buffers = &mut buffers.0;
    if edits.regrouped {
        let instances = buffers.geometry().instances();
        let (top, planes) = (TopTree::build(&instances), instances.planes());
        report.top_tree = TopTreeEdit::Rebuilt(instances.len());
        buffers.trees.top = top.expect("instances are checked when their rows are written");
        buffers.trees.planes = planes;
    } else if !edits.touched.is_empty() {
        let mut top = std::mem::take(&mut buffers.trees.top);
        let refitted = top.refit(&buffers.geometry().instances(), &edits.touched);
        refitted.expect("instances are checked when their rows are written");
        buffers.trees.top = top;
        report.top_tree = TopTreeEdit::Refitted(edits.touched.len());
    }
}
