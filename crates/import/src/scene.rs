//! A scene as a list of entities, and how a world is made to hold it.

use std::collections::HashMap;
use std::sync::Arc;

use bevy_ecs::component::{Component, Mutable};
use bevy_ecs::entity::{Entity, EntityHashSet};
use bevy_ecs::hierarchy::{ChildOf, Children};
use bevy_ecs::name::Name;
use bevy_ecs::query::With;
use bevy_ecs::resource::Resource;
use bevy_ecs::world::{EntityWorldMut, World};
use brewster_world::components as world;
use brewster_world::components::{SceneKey, Transform, UsesMaterial, UsesShape};
use glam::Affine3A;

use crate::source::Span;

/// The entity came from a file: [`Scene::apply`] may change and despawn it.
#[derive(Component, Clone, Copy, Debug)]
pub struct Imported;

/// A scene that was read: what its entities are to be. It does not change; a new load makes a new one.
#[derive(Debug)]
pub struct Scene {
    /// The scene's settings.
    pub settings: world::Settings,
    /// What rays see that meet nothing.
    pub background: world::Background,
    /// Every row before those that refer to it by [`Part::Of`].
    pub(crate) rows: Vec<Row>,
}

/// One entity to be.
#[derive(Clone, Debug)]
pub(crate) struct Row {
    pub key: u64,
    pub name: Option<Arc<str>>,
    /// The row in whose space it is.
    pub parent: Option<u32>,
    /// None for a definition, which is nowhere.
    pub transform: Option<Affine3A>,
    pub motion: Option<Arc<world::Motion>>,
    pub shape: Part<world::Shape>,
    pub material: Part<world::Material>,
    /// Of its own material.
    pub detail: Option<Arc<world::Detail>>,
    pub light: Option<Arc<world::Light>>,
    pub camera: Option<Arc<world::Camera>>,
    pub span: Span,
}

/// A component of an entity.
#[derive(Clone, Debug)]
pub(crate) enum Part<T> {
    None,
    /// Its own.
    Own(Arc<T>),
    /// That of another row.
    Of(u32),
}

/// How many entities [`Scene::apply`] touched.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Applied {
    /// Entities that were not there before.
    pub spawned: usize,
    /// Entities of which at least one component is another now.
    pub changed: usize,
    /// Entities that are gone.
    pub despawned: usize,
}

impl Scene {
    /// The number of entities, definitions of materials and shapes among them.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Whether there is nothing in it.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Makes a world hold this scene, whatever scene it held before.
    ///
    /// Entities are known by their [`SceneKey`]. Components that are equal already are not touched, so change detection sees
    /// the author's edit and nothing else; entities that are not [`Imported`] are left alone, unless they are children of one
    /// that goes. Afterwards the world equals one that the scene was applied to from the start.
    pub fn apply(&self, world: &mut World) -> Applied {
        let mut applied = Applied::default();
        set_resource(world, &self.settings);
        set_resource(world, &self.background);

        let mut known = world.query_filtered::<(Entity, &SceneKey), With<Imported>>();
        let mut known: HashMap<u64, Entity> = known.iter(world).map(|(entity, key)| (key.0, entity)).collect();
        let mut is_new = vec![false; self.rows.len()];
        let entities: Vec<Entity> = (self.rows.iter().zip(&mut is_new))
            .map(|(row, is_new)| {
                known.remove(&row.key).unwrap_or_else(|| {
                    *is_new = true;
                    let transform = row.transform.unwrap_or(Affine3A::IDENTITY);
                    world.spawn((Imported, SceneKey(row.key), Transform(transform))).id()
                })
            })
            .collect();
        for ((row, &entity), is_new) in self.rows.iter().zip(&entities).zip(is_new) {
            let changed = row.write(&entities, world.entity_mut(entity));
            applied.spawned += usize::from(is_new);
            applied.changed += usize::from(changed && !is_new);
        }
        // What stays has left what goes: a child goes with its parent.
        for entity in known.into_values() {
            applied.despawned += 1;
            despawn(world, entity);
        }
        applied
    }

    /// A component of a row, its own or another row's.
    pub(crate) fn part<'s, T>(&'s self, row: &'s Row, part: impl Fn(&Row) -> &Part<T>) -> Option<&'s T> {
        match part(row) {
            Part::None => None,
            Part::Own(value) => Some(value),
            Part::Of(other) => match part(&self.rows[*other as usize]) {
                Part::Own(value) => Some(value),
                _ => None,
            },
        }
    }
}

/// Despawns an entity with all below it, from the bottom up: bevy_ecs goes down by recursion, and stacks are short.
fn despawn(world: &mut World, entity: Entity) {
    let mut parents = vec![entity];
    let mut met: EntityHashSet = parents.iter().copied().collect();
    let mut at = 0;
    while let Some(&parent) = parents.get(at) {
        let children = world.get::<Children>(parent).into_iter().flatten().copied();
        parents.extend(children.filter(|&child| world.get::<Children>(child).is_some() && met.insert(child)));
        at += 1;
    }
    for parent in parents.into_iter().rev() {
        // Children without children go with their parents.
        if let Ok(parent) = world.get_entity_mut(parent) {
            parent.despawn();
        }
    }
}

/// From each row's space to the world's, and how many rows that takes. A parent may come after its children.
pub(crate) fn world_transforms(rows: &[Row]) -> (Vec<Affine3A>, Vec<u64>) {
    let mut places = vec![Affine3A::IDENTITY; rows.len()];
    let mut depths = vec![0; rows.len()];
    let mut chain = Vec::new();
    for start in 0..rows.len() {
        let mut at = Some(start);
        while let Some(row) = at.filter(|&row| depths[row] == 0) {
            chain.push(row);
            at = rows[row].parent.map(|parent| parent as usize);
        }
        let (mut above, mut depth) = at.map_or((Affine3A::IDENTITY, 0), |row| (places[row], depths[row]));
        while let Some(row) = chain.pop() {
            above *= rows[row].transform.unwrap_or(Affine3A::IDENTITY);
            depth += 1;
            (places[row], depths[row]) = (above, depth);
        }
    }
    (places, depths)
}

impl Row {
    /// A row with nothing in it, at the origin.
    pub(crate) fn at(key: u64, span: Span) -> Row {
        Row {
            key,
            name: None,
            parent: None,
            transform: Some(Affine3A::IDENTITY),
            motion: None,
            shape: Part::None,
            material: Part::None,
            detail: None,
            light: None,
            camera: None,
            span,
        }
    }

    /// Gives an entity this row's components; says whether one was another before.
    fn write(&self, entities: &[Entity], mut entity: EntityWorldMut) -> bool {
        let mut changed = false;
        let parent = self.parent.map(|row| entities[row as usize]);
        if entity.get::<ChildOf>().map(ChildOf::parent) != parent {
            changed = true;
            match parent {
                Some(parent) => entity.insert(ChildOf(parent)),
                None => entity.remove::<ChildOf>(),
            };
        }
        if let Some(transform) = self.transform {
            changed |= put(&mut entity, Some(Transform(transform)));
        }
        changed |= put_shared(&mut entity, self.motion.as_deref());
        let (shape, of) = self.shape.split();
        changed |= put_shared(&mut entity, shape);
        changed |= put(&mut entity, of.map(|row| UsesShape(entities[row as usize])));
        let (material, of) = self.material.split();
        changed |= put_shared(&mut entity, material);
        changed |= put(&mut entity, of.map(|row| UsesMaterial(entities[row as usize])));
        changed |= put_shared(&mut entity, self.detail.as_deref());
        changed |= put_shared(&mut entity, self.light.as_deref());
        changed |= put_shared(&mut entity, self.camera.as_deref());
        if entity.get::<Name>().map(Name::as_str) != self.name.as_deref() {
            changed = true;
            match &self.name {
                Some(name) => entity.insert(Name::new(name.to_string())),
                None => entity.remove::<Name>(),
            };
        }
        changed
    }
}

impl<T> Part<T> {
    fn split(&self) -> (Option<&T>, Option<u32>) {
        match self {
            Part::None => (None, None),
            Part::Own(value) => (Some(value), None),
            Part::Of(row) => (None, Some(*row)),
        }
    }
}

fn put<C: Component<Mutability = Mutable> + PartialEq + Clone>(entity: &mut EntityWorldMut, value: Option<C>) -> bool {
    put_shared(entity, value.as_ref())
}

/// Writes, adds or removes a component, if that changes anything.
fn put_shared<C: Component<Mutability = Mutable> + PartialEq + Clone>(
    entity: &mut EntityWorldMut,
    value: Option<&C>,
) -> bool {
    match (entity.get::<C>(), value) {
        (None, None) => return false,
        (Some(old), Some(new)) if old == new => return false,
        (_, Some(new)) => entity.insert(new.clone()),
        (Some(_), None) => entity.remove::<C>(),
    };
    true
}

fn set_resource<R: Resource<Mutability = Mutable> + PartialEq + Clone>(world: &mut World, value: &R) {
    if world.get_resource::<R>() != Some(value) {
        world.insert_resource(value.clone());
    }
}
