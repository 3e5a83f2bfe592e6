//! Emitters: gathered when something changed that shines, or when rows changed their numbers. What else is edited costs a look at
//! the rows that were written.

use bevy_ecs::system::{Res, ResMut};
use brewster_buffers::{PrincipledColumns, SceneBuffers};

use super::report::{EmittersEdit, FlattenReport};
use super::{Buffers, Edits};

/// Has the emitters and their tree follow instances, materials and lights.
pub(super) fn flatten_emitters(edits: Res<Edits>, mut buffers: ResMut<Buffers>, mut report: ResMut<FlattenReport>) {
    let buffers = &mut buffers.0;
    let (emitters, tree_built) = match change(buffers, &edits, &report) {
        Change::None => return,
        Change::Places => std::mem::take(&mut buffers.emitters).follow(buffers, &edits.touched),
        Change::Any => std::mem::take(&mut buffers.emitters).update(buffers),
    };
    report.emitters = EmittersEdit::Gathered { sources: emitters.len(), tree_built };
    buffers.emitters = emitters;
}

/// What may have changed of what shines.
enum Change {
    None,
    /// Where instances are.
    Places,
    Any,
}

fn change(buffers: &SceneBuffers, edits: &Edits, report: &FlattenReport) -> Change {
    if !report.lights.is_none() {
        return Change::Any;
    }
    let emitters = buffers.emitters.rows();
    let materials = &buffers.materials;
    let is_dark = |principled: &PrincipledColumns| principled.view().emission.iter().all(|color| color.is_black());
    if emitters.is_empty() && materials.emissive.is_empty() && is_dark(&materials.principled) {
        return Change::None;
    }
    if edits.regrouped || !report.materials.is_none() || !report.textures.is_none() || !report.shapes.is_none() {
        return Change::Any;
    }
    let instances = buffers.instances.view();
    let shines = |row: u32| {
        let material = materials.rows.get(instances.material[row as usize].0 as usize);
        materials.emission(material).is_some_and(|emissive| !emissive.radiance.is_black())
    };
    let shone = |row: u32| emitters.instance.binary_search(&row).is_ok();
    let concerns = |rows: &[u32]| rows.iter().any(|&row| shines(row) || shone(row));
    match (concerns(&edits.rewritten), concerns(&edits.touched)) {
        (true, _) => Change::Any,
        (false, true) => Change::Places,
        (false, false) => Change::None,
    }
}
