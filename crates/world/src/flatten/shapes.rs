//! Shapes: every entity with a [`Shape`] owns a row of its kind, in the order of keys; entities with one mesh own its row together.
//!
//! A shape that changes within its kind costs one row. Anything else (one more, one less, another kind or mesh) writes the table
//! over from the first row to the last and takes the instances along.

use std::sync::Arc;

use bevy_ecs::entity::Entity;
use bevy_ecs::lifecycle::RemovedComponents;
use bevy_ecs::query::With;
use bevy_ecs::resource::Resource;
use bevy_ecs::system::{Query, Res, ResMut};
use brewster_buffers::SceneBuffers;
use brewster_geometry as geometry;
use brewster_geometry::{Analytic, ShapeError, ShapeKind, ShapeRef, ShapeTable, TreeBuilder};

use super::directory::{Directory, Owner};
use super::instances::{InstanceIndex, Source};
use super::meshes::MeshRows;
use super::report::{FlattenReport, Problem, RowEdits};
use super::rows::Rows;
use super::{Buffers, Builder, Edits};
use crate::components::{SceneKey, Shape};
use crate::systems::{Watch, for_each_changed};

/// Which entity has which shape.
#[derive(Resource, Default)]
pub(super) struct ShapeIndex {
    pub(super) directory: Directory,
    /// The shape of each row of the directory.
    shapes: Vec<ShapeRef>,
    /// Entities whose shape is new or another one.
    changed: Vec<Entity>,
    /// Whether the table has to be written over.
    stale: bool,
}

impl ShapeIndex {
    /// Whether the last flatten wrote the table over.
    pub(super) fn was_regrouped(&self) -> bool {
        self.stale
    }

    /// The row of an entity in the directory, and its shape.
    pub(super) fn find(&self, entity: Entity) -> Option<(u32, ShapeRef)> {
        let row = self.directory.row(entity)?;
        Some((row, self.shapes[row as usize]))
    }
}

/// Writes the row of each shape that changed within its kind, unless that is not enough.
pub(super) fn flatten_changed_shapes(
    (watch, keys): (Watch<Shape>, Watch<SceneKey, With<Shape>>),
    mut removed: RemovedComponents<Shape>,
    shapes: Query<&Shape>,
    mut index: ResMut<ShapeIndex>,
    mut buffers: ResMut<Buffers>,
    mut report: ResMut<FlattenReport>,
) {
    let (index, table) = (&mut *index, &mut buffers.0.shapes);
    let gone = |&entity: &Entity| index.directory.knows(entity) && !shapes.contains(entity);
    let mut stale = removed.read().filter(gone).count() > 0;
    for_each_changed(&keys, |entity, key| stale |= index.directory.is_out_of_order(entity, key));
    index.changed.clear();
    for_each_changed(&watch, |entity, shape| {
        stale = stale || !index.find(entity).is_some_and(|(_, old)| keeps_row(shape, old, table));
        index.changed.push(entity);
    });
    index.stale = stale;
    if stale {
        return;
    }
    for &entity in &index.changed {
        let (Ok(shape), Some((_, old))) = (shapes.get(entity), index.find(entity)) else { continue };
        match put(table, shape, old.row) {
            Ok(differs) => report.shapes.rewritten += usize::from(differs),
            Err(_) => index.stale = true,
        }
    }
}

/// Whether a shape can be written over an earlier one.
fn keeps_row(shape: &Shape, old: ShapeRef, table: &ShapeTable) -> bool {
    match shape {
        Shape::Mesh(mesh) => old.kind == ShapeKind::Mesh && Arc::ptr_eq(mesh, &table.meshes[old.row as usize]),
        _ => kind(shape) == old.kind,
    }
}

/// Where shapes came or went: writes the whole table over and gives instances the new rows of their shapes.
pub(super) fn regroup_shapes(
    shapes: Query<(Entity, &SceneKey, &Shape)>,
    builder: Res<Builder>,
    mut index: ResMut<ShapeIndex>,
    mut instances: ResMut<InstanceIndex>,
    mut edits: ResMut<Edits>,
    mut buffers: ResMut<Buffers>,
    mut report: ResMut<FlattenReport>,
) {
    let index = &mut *index;
    if !index.stale {
        return;
    }
    let mut sorted: Vec<(Owner, &Shape)> =
        shapes.iter().map(|(entity, key, shape)| (Owner { key: key.0, entity }, shape)).collect();
    sorted.sort_unstable_by_key(|(owner, _)| owner.rank());

    index.directory.invalid.clear();
    index.shapes.clear();
    let mut owners = Vec::with_capacity(sorted.len());
    let mut writer = TableWriter::new(&mut buffers.0, builder.0);
    for (owner, shape) in sorted {
        match writer.write(shape) {
            Ok(shape) => {
                owners.push(owner);
                index.shapes.push(shape);
            }
            Err(problem) => {
                index.directory.invalid.insert(owner.entity, problem);
            }
        }
    }
    writer.finish(&mut report);

    let moves = index.directory.reorder(owners);
    let instance_shapes = buffers.0.instances.view_mut().shape;
    for (source, shape) in instances.sources.iter_mut().zip(instance_shapes) {
        let Some(row) = moves.of(source.shape) else {
            edits.rewired.push(source.entity);
            continue;
        };
        source.shape = row;
        let new = index.shapes[row as usize];
        report.instances.rewritten += usize::from(*shape != new);
        *shape = new;
    }
    edits.rewired.extend(moves.arrived);
    // One that wore another's shape and has got a bad one of its own is no instance any longer.
    edits.rewired.extend(index.directory.invalid.keys());
}

/// Notes the instances whose shape is another one than before: they may be out of bounds now, and the top tree has to follow.
pub(super) fn note_reshaped_instances(index: Res<ShapeIndex>, instances: Res<InstanceIndex>, mut edits: ResMut<Edits>) {
    if index.changed.is_empty() {
        return;
    }
    let mut is_changed = vec![false; index.directory.len()];
    for row in index.changed.iter().filter_map(|&entity| index.directory.row(entity)) {
        is_changed[row as usize] = true;
    }
    let wears_changed = |source: &&Source| is_changed.get(source.shape as usize) == Some(&true);
    let edits = &mut *edits;
    edits.reshaped.extend(instances.sources.iter().filter(wears_changed).map(|source| source.entity));
    edits.rewired.extend(&edits.reshaped);
}

/// The kind of a shape.
fn kind(shape: &Shape) -> ShapeKind {
    match shape {
        Shape::Sphere { .. } => ShapeKind::Sphere,
        Shape::Plane => ShapeKind::Plane,
        Shape::Quad { .. } => ShapeKind::Quad,
        Shape::Disk { .. } => ShapeKind::Disk,
        Shape::Cuboid { .. } => ShapeKind::Cuboid,
        Shape::Cylinder { .. } => ShapeKind::Cylinder,
        Shape::Cone { .. } => ShapeKind::Cone,
        Shape::Torus { .. } => ShapeKind::Torus,
        Shape::Mesh(_) => ShapeKind::Mesh,
    }
}

/// Writes a shape to a row of its kind and says whether another one stood there; a mesh is there already.
fn put(table: &mut ShapeTable, shape: &Shape, row: u32) -> Result<bool, ShapeError> {
    fn checked<T: Analytic>(column: &mut Vec<T>, row: u32, shape: T) -> Result<bool, ShapeError> {
        shape.validate()?;
        Ok(column.put(row as usize, shape))
    }
    match *shape {
        Shape::Sphere { radius } => checked(&mut table.spheres, row, geometry::Sphere { radius }),
        Shape::Plane => checked(&mut table.planes, row, geometry::Plane),
        Shape::Quad { size } => checked(&mut table.quads, row, geometry::Quad { half: 0.5 * size }),
        Shape::Disk { radius, inner_radius } => checked(&mut table.disks, row, geometry::Disk { radius, inner_radius }),
        Shape::Cuboid { size } => checked(&mut table.cuboids, row, geometry::Cuboid { half: 0.5 * size }),
        Shape::Cylinder { radius, height } => checked(&mut table.cylinders, row, geometry::Cylinder { radius, height }),
        Shape::Cone { radius, height } => checked(&mut table.cones, row, geometry::Cone { radius, height }),
        Shape::Torus { major_radius, minor_radius } => {
            checked(&mut table.tori, row, geometry::Torus { major_radius, minor_radius })
        }
        Shape::Mesh(_) => Ok(false),
    }
}

/// Writes a shape table over, from the first row of each kind.
struct TableWriter<'a> {
    buffers: &'a mut SceneBuffers,
    meshes: MeshRows,
    /// Rows written so far, by kind.
    written: [usize; ShapeKind::ALL.len()],
    /// Rows that there were, by kind.
    before: [usize; ShapeKind::ALL.len()],
    edits: RowEdits,
}

impl TableWriter<'_> {
    fn new(buffers: &mut SceneBuffers, builder: TreeBuilder) -> TableWriter<'_> {
        let before = ShapeKind::ALL.map(|kind| buffers.shapes.len(kind));
        let meshes = MeshRows::new(std::mem::take(&mut buffers.trees.meshes), builder);
        TableWriter { buffers, meshes, written: [0; 9], before, edits: RowEdits::default() }
    }

    fn write(&mut self, shape: &Shape) -> Result<ShapeRef, Problem> {
        let kind = kind(shape);
        if let Shape::Mesh(mesh) = shape {
            return self.meshes.row(mesh).map(|row| ShapeRef { kind, row }).map_err(Problem::Mesh);
        }
        let row = self.written[kind as usize];
        let differs = put(&mut self.buffers.shapes, shape, row as u32).map_err(Problem::Shape)?;
        self.edits.count(row, self.before[kind as usize], differs);
        self.written[kind as usize] += 1;
        Ok(ShapeRef { kind, row: row as u32 })
    }

    fn finish(mut self, report: &mut FlattenReport) {
        let table = &mut self.buffers.shapes;
        let (trees, mesh_trees) = self.meshes.finish();
        report.mesh_trees = mesh_trees;
        for (row, tree) in trees.iter().enumerate() {
            let differs = !table.meshes.get(row).is_some_and(|old| Arc::ptr_eq(old, tree.mesh()));
            self.edits.count(row, self.before[ShapeKind::Mesh as usize], differs);
        }
        self.written[ShapeKind::Mesh as usize] = trees.len();
        table.meshes = trees.iter().map(|tree| tree.mesh().clone()).collect();
        self.buffers.trees.meshes = trees;

        let [spheres, planes, quads, disks, cuboids, cylinders, cones, tori, _] = self.written;
        table.spheres.truncate(spheres);
        table.planes.truncate(planes);
        table.quads.truncate(quads);
        table.disks.truncate(disks);
        table.cuboids.truncate(cuboids);
        table.cylinders.truncate(cylinders);
        table.cones.truncate(cones);
        table.tori.truncate(tori);
        self.edits.removed +=
            self.before.iter().zip(self.written).map(|(before, now)| before.saturating_sub(now)).sum::<usize>();
        report.shapes = self.edits;
    }
}
