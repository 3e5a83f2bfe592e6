//! Resolved files to rows, one for every entity: instances and includes are placed as often as they are asked for.

use std::collections::HashMap;
use std::sync::Arc;

use brewster_world::components as world;
use glam::Affine3A;

use crate::diagnostics::Code;
use crate::keys::Keys;
use crate::limits::Exceeded;
use crate::scene::{Part, Row, Scene};
use crate::session::Session;
use crate::source::Span;

use super::content::{Content, Defined, Prototype, Resolver};
use super::convert;
use super::schema;
use super::values::Spanned;

/// The rows of a scene. An error takes the place of rows that would be too many.
pub(crate) fn spawn(resolver: &mut Resolver, scene: &schema::Scene, content: &Content) -> Option<Scene> {
    let cameras = cameras(resolver.session, scene);
    let background = convert::background(resolver.session, &scene.background);
    let mut rows = Vec::new();
    check_count(resolver, content, cameras.len())?;
    for definition in std::mem::take(&mut resolver.definitions) {
        let (shape, material, detail) = match definition.is {
            Defined::Shape(shape, _) => (Part::Own(Arc::new(shape)), Part::None, None),
            Defined::Material(material, detail) => (Part::None, Part::Own(material), detail),
        };
        let row = Row { name: definition.name, ..Row::at(definition.key, definition.span) };
        rows.push(Row { shape, material, detail, transform: None, ..row });
    }
    rows.extend(cameras);
    let mut placer = Placer { rows, next: 0 };
    let mut placed = HashMap::new();
    for prototype in &content.prototypes {
        placer.next = resolver.keys.entity(prototype.name.as_deref());
        placer.prototype(prototype, None, Affine3A::IDENTITY, &mut placed);
    }
    placer.adopt(content, &placed);
    Some(Scene {
        settings: world::Settings(convert::settings(&scene.settings, resolver.session.integrator)),
        background: world::Background(background?),
        rows: placer.rows,
    })
}

/// Reports the entity with which a scene has too many.
fn check_count(resolver: &mut Resolver, content: &Content, cameras: usize) -> Option<()> {
    let bound = resolver.session.limits.entities;
    let mut count = (resolver.definitions.len() + cameras) as u64;
    for prototype in &content.prototypes {
        count = count.saturating_add(prototype.count());
        if count > bound {
            let exceeded = Exceeded { name: "entities", bound };
            let message = format!("with this the scene has too many entities: {exceeded}");
            resolver.session.error(Code::Limit, prototype.span, message);
            return None;
        }
    }
    Some(())
}

/// The cameras: first the one without a name, then the others in order.
fn cameras(session: &mut Session, scene: &schema::Scene) -> Vec<Row> {
    let mut rows: Vec<Row> = Vec::new();
    let mut places: HashMap<&str, Span> = HashMap::new();
    let mut add = |session: &mut Session, camera: &Spanned<schema::Camera>, name: Option<&str>| {
        if let Some((component, place, motion)) = convert::camera(session, camera) {
            let row = Row { name: name.map(Arc::from), ..Row::at(Keys::camera(rows.len() as u64), camera.span) };
            let motion = motion.map(Arc::new);
            rows.push(Row { transform: Some(place), motion, camera: Some(Arc::new(component)), ..row });
        }
    };
    if let Some(camera) = &scene.camera {
        add(session, camera, None);
    }
    for (name, camera) in &scene.cameras.rows {
        if let Some(first) = places.insert(&name.value, name.span) {
            let first = format!("first given at {}", session.sources.describe(first));
            let message = format!("the name {:?} is given twice in `cameras`", name.value);
            session.found.push(session.sources.error(Code::Duplicate, name.span, message).note(first));
        } else if let Some(camera) = camera {
            add(session, camera, Some(&name.value));
        }
    }
    rows
}

struct Placer {
    rows: Vec<Row>,
    /// The key of the next row.
    next: u64,
}

impl Placer {
    /// Places an entity and everything in it. `within` comes before the entity's own transform; `placed` collects the rows of
    /// a file's entities by their numbers.
    fn prototype(
        &mut self,
        prototype: &Prototype,
        parent: Option<u32>,
        within: Affine3A,
        placed: &mut HashMap<u32, u32>,
    ) {
        let transform = match prototype.parent {
            Some(_) => prototype.transform,
            None => within * prototype.transform,
        };
        let Some(places) = &prototype.instances else {
            let row = self.whole(prototype, parent, transform, placed);
            self.rows[row as usize].motion = prototype.own_motion();
            return;
        };
        let group = self.push(prototype, parent, transform);
        self.rows[group as usize].motion.clone_from(&prototype.motion);
        placed.insert(prototype.index, group);
        for &place in places {
            // What is repeated has no names that could be asked for.
            let unasked = &mut HashMap::new();
            if prototype.has_components() {
                let row = self.whole(prototype, Some(group), place, unasked);
                self.rows[row as usize].name = None;
            } else {
                self.below(prototype, group, place, unasked);
            }
        }
    }

    /// Places an entity with its components and what is below it; returns its row.
    fn whole(
        &mut self,
        prototype: &Prototype,
        parent: Option<u32>,
        transform: Affine3A,
        placed: &mut HashMap<u32, u32>,
    ) -> u32 {
        let separate = prototype.has_separate_shape();
        let own = if separate { transform } else { transform * prototype.shape_place };
        let row = self.push(prototype, parent, own);
        placed.insert(prototype.index, row);
        self.rows[row as usize].light.clone_from(&prototype.light);
        let surface = if separate { self.push(prototype, Some(row), prototype.shape_place) } else { row };
        let surface = &mut self.rows[surface as usize];
        surface.shape.clone_from(&prototype.shape);
        surface.material.clone_from(&prototype.material);
        surface.detail.clone_from(&prototype.detail);
        self.below(prototype, row, Affine3A::IDENTITY, placed);
        row
    }

    /// Places what is in an entity's space.
    fn below(&mut self, prototype: &Prototype, row: u32, within: Affine3A, placed: &mut HashMap<u32, u32>) {
        for child in &prototype.children {
            self.prototype(child, Some(row), within, placed);
        }
        if let Some(content) = &prototype.include {
            let mut placed = HashMap::new();
            for prototype in &content.prototypes {
                self.prototype(prototype, Some(row), within, &mut placed);
            }
            self.adopt(content, &placed);
        }
    }

    /// Gives the entities of a file the parents that they name.
    fn adopt(&mut self, content: &Content, placed: &HashMap<u32, u32>) {
        for prototype in &content.prototypes {
            if let Some(parent) = prototype.parent {
                self.rows[placed[&prototype.index] as usize].parent = placed.get(&parent).copied();
            }
        }
    }

    /// A row without components but with the entity's name.
    fn push(&mut self, prototype: &Prototype, parent: Option<u32>, transform: Affine3A) -> u32 {
        let row = Row { name: prototype.name.clone(), ..Row::at(self.next, prototype.span) };
        self.rows.push(Row { parent, transform: Some(transform), ..row });
        self.next += 1;
        self.rows.len() as u32 - 1
    }
}
