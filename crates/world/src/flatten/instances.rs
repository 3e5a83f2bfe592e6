//! Instances: an entity is one if it has a shape and a material, each its own or another entity's, and a place. One without a
//! material is none: it holds a shape for others.

use std::collections::BTreeMap;

use bevy_ecs::entity::{Entity, EntityHashMap};
use bevy_ecs::lifecycle::RemovedComponents;
use bevy_ecs::query::Has;
use bevy_ecs::resource::Resource;
use bevy_ecs::system::{Query, Res, ResMut, SystemParam};
use brewster_buffers::{Instance, InstanceColumns, SceneBuffers};
use brewster_geometry::{Affine, Instances, Motion, Motions, TransformError};
use glam::Affine3A;

use super::directory::Owner;
use super::materials::MaterialIndex;
use super::report::{FlattenReport, Problem};
use super::shapes::ShapeIndex;
use super::{Buffers, Edits};
use crate::components::{Material, SceneKey, Shape, UsesMaterial, UsesShape, WorldTransform};
use crate::systems::{Moved, Watch, WorldMotions, for_each_changed};

/// Which entity has which row.
#[derive(Resource, Default)]
pub(super) struct InstanceIndex {
    /// Where each row comes from, parallel to the columns.
    pub(super) sources: Vec<Source>,
    /// The key under which an entity has a row.
    keys: EntityHashMap<u64>,
    /// How instances move, by key.
    motions: BTreeMap<u64, Motion>,
    /// Entities that would be instances, and what is in the way. They are tried again at every flatten.
    pub(super) invalid: BTreeMap<Entity, Problem>,
}

/// Where a row comes from.
#[derive(Clone, Copy, Debug)]
pub(super) struct Source {
    pub(super) entity: Entity,
    /// The row of its shape's owner in the directory of shapes.
    pub(super) shape: u32,
}

impl InstanceIndex {
    /// The row of an entity.
    fn row(&self, entity: Entity, columns: &InstanceColumns) -> Option<usize> {
        let key = self.keys.get(&entity)?;
        Some(columns.view().key.binary_search(key).expect("keys of the index are in the columns"))
    }

    /// Notes how the instance of a key moves.
    fn note_motion(&mut self, key: u64, motion: Option<Motion>) {
        match motion {
            Some(motion) => drop(self.motions.insert(key, motion)),
            None => drop(self.motions.remove(&key)),
        }
    }
}

/// What makes an entity an instance.
#[derive(SystemParam)]
pub(super) struct Wearers<'w, 's> {
    entities: Query<'w, 's, Wearer>,
    shapes: Res<'w, ShapeIndex>,
    materials: Res<'w, MaterialIndex>,
    motions: Res<'w, WorldMotions>,
}

type Wearer = (
    &'static SceneKey,
    &'static WorldTransform,
    (Has<Shape>, Option<&'static UsesShape>),
    (Has<Material>, Option<&'static UsesMaterial>),
);

impl Wearers<'_, '_> {
    /// The row of an entity, and how it moves; none if it is no instance, or if what it has of its own is left out already.
    fn resolve(&self, entity: Entity, buffers: &SceneBuffers) -> Result<Option<Resolved>, Problem> {
        let Ok((key, place, (has_shape, uses_shape), (has_material, uses_material))) = self.entities.get(entity) else {
            return Ok(None);
        };
        let shape_owner = if has_shape { Some(entity) } else { uses_shape.map(|uses| uses.0) };
        let material_owner = if has_material { Some(entity) } else { uses_material.map(|uses| uses.0) };
        let (Some(shape_owner), Some(material_owner)) = (shape_owner, material_owner) else { return Ok(None) };
        let Some((shape_row, shape)) = self.shapes.find(shape_owner) else {
            return if has_shape { Ok(None) } else { Err(Problem::UsesShape(shape_owner)) };
        };
        let Some(material) = self.materials.find(material_owner) else {
            return if has_material { Ok(None) } else { Err(Problem::UsesMaterial(material_owner)) };
        };
        if *key == SceneKey::UNASSIGNED {
            return Err(Problem::NoKey);
        }
        let object_to_world = Affine::from_affine3a(place.0).map_err(Problem::Transform)?;
        let world_to_object = object_to_world.inverse().map_err(Problem::Transform)?;
        let motion = self.motions.of(entity).map_or(Ok(None), |keys| motion(keys)).map_err(Problem::Transform)?;
        let alone = Instances {
            world_to_object: &[world_to_object],
            motions: &Motions::new([motion.as_ref()]),
            shapes: &[shape],
            table: &buffers.shapes,
            mesh_trees: &buffers.trees.meshes,
        };
        alone.bounds(0).map_err(|_| Problem::OutOfRange)?;
        let source = Source { entity, shape: shape_row };
        Ok(Some((source, Instance { object_to_world, world_to_object, shape, material, key: key.0 }, motion)))
    }
}

/// What becomes of an instance.
type Resolved = (Source, Instance, Option<Motion>);

/// A motion through places; none if they are all one.
fn motion(keys: &[Affine3A]) -> Result<Option<Motion>, TransformError> {
    Motion::new(&keys.iter().copied().map(Affine::from_affine3a).collect::<Result<Vec<_>, _>>()?)
}

/// Notes the entities that may have become an instance, may be one no longer, or may refer to something else.
pub(super) fn note_rewired_entities(
    (shapes, materials, keys): (Watch<UsesShape>, Watch<UsesMaterial>, Watch<SceneKey>),
    (mut shape_gone, mut uses_shape_gone): (RemovedComponents<Shape>, RemovedComponents<UsesShape>),
    (mut material_gone, mut uses_material_gone): (RemovedComponents<Material>, RemovedComponents<UsesMaterial>),
    (mut key_gone, mut place_gone): (RemovedComponents<SceneKey>, RemovedComponents<WorldTransform>),
    index: Res<InstanceIndex>,
    mut edits: ResMut<Edits>,
) {
    let rewired = &mut edits.rewired;
    for_each_changed(&shapes, |entity, _| rewired.push(entity));
    for_each_changed(&materials, |entity, _| rewired.push(entity));
    for_each_changed(&keys, |entity, _| rewired.push(entity));
    rewired.extend(shape_gone.read().chain(uses_shape_gone.read()));
    rewired.extend(material_gone.read().chain(uses_material_gone.read()));
    rewired.extend(key_gone.read().chain(place_gone.read()));
    rewired.extend(index.invalid.keys());
    rewired.sort();
    rewired.dedup();
}

/// Removes the rows of entities that are no instances any longer or have another key.
pub(super) fn flatten_removed_instances(
    wearers: Wearers,
    moved: Res<Moved>,
    mut index: ResMut<InstanceIndex>,
    mut edits: ResMut<Edits>,
    mut buffers: ResMut<Buffers>,
    mut report: ResMut<FlattenReport>,
) {
    let buffers = &mut buffers.0;
    let mut removed: Vec<usize> = Vec::new();
    for &entity in edits.rewired.iter().chain(&moved.0) {
        let Some(&key) = index.keys.get(&entity) else { continue };
        let resolved = wearers.resolve(entity, buffers);
        if matches!(&resolved, Ok(Some((_, instance, _))) if instance.key == key) {
            continue;
        }
        removed.extend(index.row(entity, &buffers.instances));
        index.keys.remove(&entity);
        index.note_motion(key, None);
        if let Err(problem) = resolved {
            index.invalid.insert(entity, problem);
        }
    }
    if removed.is_empty() {
        return;
    }
    removed.sort_unstable();
    remove_rows(&mut buffers.instances, &mut index.sources, &removed);
    edits.regrouped = true;
    report.instances.removed = removed.len();
}

/// Inserts rows for entities that have become instances.
pub(super) fn flatten_added_instances(
    wearers: Wearers,
    mut index: ResMut<InstanceIndex>,
    mut edits: ResMut<Edits>,
    mut buffers: ResMut<Buffers>,
    mut report: ResMut<FlattenReport>,
) {
    let index = &mut *index;
    let mut candidates: Vec<Owner> = Vec::new();
    // What stays in the list has a row already.
    edits.rewired.retain(|&entity| {
        let has_row = index.keys.contains_key(&entity);
        if !has_row {
            index.invalid.remove(&entity);
            candidates.extend(wearers.entities.get(entity).map(|(key, ..)| Owner { key: key.0, entity }));
        }
        has_row
    });
    candidates.sort_unstable_by_key(Owner::rank);

    let buffers = &mut buffers.0;
    let mut added = InstanceColumns::with_capacity(candidates.len());
    let mut sources = Vec::with_capacity(candidates.len());
    index.keys.reserve(candidates.len());
    for Owner { key, entity } in candidates {
        let is_taken =
            added.view().key.last() == Some(&key) || buffers.instances.view().key.binary_search(&key).is_ok();
        match wearers.resolve(entity, buffers) {
            Ok(Some(_)) if is_taken => {
                index.invalid.insert(entity, Problem::DuplicateKey(key));
            }
            Ok(Some((source, instance, motion))) => {
                index.note_motion(key, motion);
                added.push(instance);
                sources.push(source);
                index.keys.insert(entity, key);
            }
            Ok(None) => (),
            Err(problem) => {
                index.invalid.insert(entity, problem);
            }
        }
    }
    edits.regrouped |= !added.is_empty();
    report.instances.added = added.len();
    insert_rows(&mut buffers.instances, &mut index.sources, added, sources);
}

/// Rewrites the rows of instances that wear another shape or material than before, and has the top tree follow.
pub(super) fn flatten_rewired_instances(
    wearers: Wearers,
    mut index: ResMut<InstanceIndex>,
    mut edits: ResMut<Edits>,
    mut buffers: ResMut<Buffers>,
    mut report: ResMut<FlattenReport>,
) {
    let (buffers, edits) = (&mut buffers.0, &mut *edits);
    for &entity in &edits.rewired {
        let (Some(row), Ok(Some((source, instance, motion)))) =
            (index.row(entity, &buffers.instances), wearers.resolve(entity, buffers))
        else {
            continue;
        };
        // Another shape may have an end where the old one had none.
        edits.regrouped |= source.shape != index.sources[row].shape;
        if buffers.instances.get(row) != instance {
            report.instances.rewritten += 1;
            edits.rewritten.push(row as u32);
        }
        buffers.instances.set(row, instance);
        index.note_motion(instance.key, motion);
        index.sources[row] = source;
    }
    edits.touched.extend(
        edits.reshaped.iter().filter_map(|&entity| index.row(entity, &buffers.instances)).map(|row| row as u32),
    );
    edits.regrouped |= wearers.shapes.was_regrouped() && !edits.touched.is_empty();
}

/// Rewrites the transforms of instances that moved.
pub(super) fn flatten_moved_instances(
    wearers: Wearers,
    moved: Res<Moved>,
    mut index: ResMut<InstanceIndex>,
    mut edits: ResMut<Edits>,
    mut buffers: ResMut<Buffers>,
    mut report: ResMut<FlattenReport>,
) {
    let buffers = &mut buffers.0;
    for &entity in &moved.0 {
        let (Some(row), Ok(Some((_, instance, motion)))) =
            (index.row(entity, &buffers.instances), wearers.resolve(entity, buffers))
        else {
            continue;
        };
        report.instances.rewritten += 1;
        buffers.instances.set(row, instance);
        index.note_motion(instance.key, motion);
        edits.touched.push(row as u32);
    }
}

/// Has the table of motions follow: in place, or made anew where rows came or went or a motion has another number of keys.
pub(super) fn flatten_motions(index: Res<InstanceIndex>, edits: Res<Edits>, mut buffers: ResMut<Buffers>) {
    let SceneBuffers { instances, motions, .. } = &mut buffers.0;
    if index.motions.is_empty() && motions.is_empty() {
        return;
    }
    let of = |row: u32| index.motions.get(&instances.view().key[row as usize]);
    let mut changed = edits.touched.iter().chain(&edits.rewritten);
    if edits.regrouped || !changed.all(|&row| motions.set(row, of(row))) {
        *motions = Motions::new((0..instances.len() as u32).map(of));
    }
}

/// Removes the rows of an ascending list and closes the gaps; costs what lies behind the first of them.
fn remove_rows(columns: &mut InstanceColumns, sources: &mut Vec<Source>, rows: &[usize]) {
    let mut rows = rows.iter().copied().peekable();
    let Some(first) = rows.peek().copied() else { return };
    let mut end = first;
    for row in first..columns.len() {
        if rows.next_if_eq(&row).is_none() {
            columns.set(end, columns.get(row));
            sources[end] = sources[row];
            end += 1;
        }
    }
    columns.truncate(end);
    sources.truncate(end);
}

/// Inserts rows where their keys belong; both sides are in ascending order without a key in common. Costs what lies behind the
/// first of them.
fn insert_rows(
    columns: &mut InstanceColumns,
    sources: &mut Vec<Source>,
    added: InstanceColumns,
    added_sources: Vec<Source>,
) {
    if columns.is_empty() {
        (*columns, *sources) = (added, added_sources);
        return;
    }
    // From the back: what has not been read yet is always in front of what is being written.
    let (mut end, mut rest) = (columns.len(), added.len());
    columns.extend_from_view(added.view());
    sources.extend_from_slice(&added_sources);
    for row in (0..columns.len()).rev() {
        if rest == 0 {
            return;
        }
        if end > 0 && columns.view().key[end - 1] > added.view().key[rest - 1] {
            end -= 1;
            columns.set(row, columns.get(end));
            sources[row] = sources[end];
        } else {
            rest -= 1;
            columns.set(row, added.get(rest));
            sources[row] = added_sources[rest];
        }
    }
}
