//! Emitters: gathered anew when anything changed that may shine.

use bevy_ecs::system::{Res, ResMut};
use brewster_buffers::Emitters;

use super::report::FlattenReport;
use super::{Buffers, Edits};

/// Gathers emitters if instances, shapes, materials, textures or lights were written.
pub(super) fn flatten_emitters(edits: Res<Edits>, mut buffers: ResMut<Buffers>, report: Res<FlattenReport>) {
    let tables = [report.instances, report.shapes, report.materials, report.textures, report.lights];
    if edits.regrouped || !edits.touched.is_empty() || tables.iter().any(|edits| !edits.is_none()) {
        buffers.0.emitters = Emitters::new(&buffers.0);
    }
}
