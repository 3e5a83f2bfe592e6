//! A scene file with its names looked up: every reference leads somewhere, every file it includes is read, and what is
//! named or may be placed more than once stands in a list of definitions. Errors that need more than one entity are found
//! here, once for each place in a file, however often the file is included.

use std::collections::{HashMap, HashSet};
use std::path::PathBuf;
use std::rc::Rc;
use std::sync::Arc;

use brewster_world::components as world;
use glam::Affine3A;

use crate::diagnostics::{Code, Diagnostic};
use crate::keys::Keys;
use crate::limits::{Budget, Exceeded};
use crate::scene::Part;
use crate::session::Session;
use crate::source::Span;

use super::convert::{self, Place};
use super::models::Worn;
use super::schema;
use super::values::{Named, Reference, Spanned};
use super::{names, patterns, read};

/// The entities of one file.
#[derive(Debug, Default)]
pub(crate) struct Content {
    pub prototypes: Vec<Prototype>,
    /// How many entities it makes each time it is placed.
    pub count: u64,
}

/// An entity as often as it may be placed.
#[derive(Debug)]
pub(crate) struct Prototype {
    pub span: Span,
    pub name: Option<Arc<str>>,
    /// Its number in the file, and that of the entity it names as its parent.
    pub index: u32,
    pub parent: Option<u32>,
    /// Whether another entity names it as its parent.
    pub is_named_parent: bool,
    pub transform: Affine3A,
    pub motion: Option<Arc<world::Motion>>,
    pub shape: Part<world::Shape>,
    /// The shape's place in the entity's space.
    pub shape_place: Affine3A,
    pub material: Part<world::Material>,
    /// Of its own material.
    pub detail: Option<Arc<world::Detail>>,
    pub light: Option<Arc<world::Light>>,
    pub children: Vec<Prototype>,
    pub include: Option<Rc<Content>>,
    /// Where everything in it is repeated.
    pub instances: Option<Vec<Affine3A>>,
}

/// A component that entities share.
#[derive(Debug)]
pub(crate) struct Definition {
    pub key: u64,
    pub name: Option<Arc<str>>,
    pub span: Span,
    pub is: Defined,
    used: bool,
}

#[derive(Debug)]
pub(crate) enum Defined {
    /// A shape, and its place in its entity's space.
    Shape(world::Shape, Affine3A),
    Material(Arc<world::Material>, Option<Arc<world::Detail>>),
}

impl Prototype {
    /// One with nothing in it, at the origin.
    pub(crate) fn empty(span: Span, index: u32) -> Prototype {
        Prototype {
            span,
            name: None,
            index,
            parent: None,
            is_named_parent: false,
            transform: Affine3A::IDENTITY,
            motion: None,
            shape: Part::None,
            shape_place: Affine3A::IDENTITY,
            material: Part::None,
            detail: None,
            light: None,
            children: Vec::new(),
            include: None,
            instances: None,
        }
    }

    /// Whether it has anything beside what is placed in its space.
    pub(crate) fn has_components(&self) -> bool {
        self.light.is_some() || !matches!((&self.shape, &self.material), (Part::None, Part::None))
    }

    /// Whether its shape has to be an entity of its own, since its place is not the entity's.
    pub(crate) fn has_separate_shape(&self) -> bool {
        self.shape_place != Affine3A::IDENTITY
            && (self.light.is_some() || !self.children.is_empty() || self.include.is_some() || self.is_named_parent)
    }

    /// How its own row moves, which may stand where its shape has its place.
    pub(crate) fn own_motion(&self) -> Option<Arc<world::Motion>> {
        let motion = self.motion.as_ref()?;
        if self.has_separate_shape() || self.shape_place == Affine3A::IDENTITY {
            return Some(Arc::clone(motion));
        }
        let back = self.shape_place.inverse();
        let steps: Vec<_> = motion.steps().iter().map(|&step| back * step * self.shape_place).collect();
        world::Motion::through(steps).map(Arc::new)
    }

    /// How many entities it makes.
    pub(crate) fn count(&self) -> u64 {
        let below = self.children.iter().map(Prototype::count).fold(0, u64::saturating_add);
        let below = below.saturating_add(self.include.as_ref().map_or(0, |content| content.count));
        let own = 1 + u64::from(self.has_separate_shape());
        match &self.instances {
            None => below.saturating_add(own),
            Some(places) => {
                let each = below.saturating_add(if self.has_components() { own } else { 0 });
                each.saturating_mul(places.len() as u64).saturating_add(1)
            }
        }
    }
}

/// Looks names up and reads files.
pub(crate) struct Resolver<'s, 'i> {
    pub session: &'s mut Session<'i>,
    pub definitions: Vec<Definition>,
    pub keys: Keys,
    budget: Budget,
    /// Included files that were read already.
    files: HashMap<PathBuf, Rc<Content>>,
    /// What glTF files brought, by all that it depends on.
    pub(super) models: HashMap<String, Rc<Content>>,
    /// The files that are being read: each includes the next.
    stack: Vec<(PathBuf, String)>,
}

/// What the entities of one file see.
struct Scope<'f> {
    materials: HashMap<&'f str, Option<u32>>,
    shapes: HashMap<&'f str, Option<u32>>,
    parents: HashMap<u32, u32>,
    named_parents: HashSet<u32>,
    next: u32,
}

impl<'s, 'i> Resolver<'s, 'i> {
    /// A resolver that reads a file at `path`.
    pub(crate) fn new(session: &'s mut Session<'i>, path: PathBuf, name: String) -> Resolver<'s, 'i> {
        let budget = Budget::new("entities", session.limits.entities);
        Resolver {
            session,
            definitions: Vec::new(),
            keys: Keys::default(),
            budget,
            files: HashMap::new(),
            models: HashMap::new(),
            stack: vec![(path, name)],
        }
    }

    /// The content of a file that was read. `file` is empty for the scene itself.
    pub(crate) fn content(&mut self, file: &str, scene: &schema::Scene) -> Content {
        let first = self.definitions.len();
        let materials = self.materials(file, &scene.materials);
        let shapes = self.shapes(file, &scene.shapes);
        let parents = names::parents(self.session, &scene.entities);
        let named_parents = parents.values().copied().collect();
        let mut scope = Scope { materials, shapes, parents, named_parents, next: 0 };
        let mut prototypes = Vec::with_capacity(scene.entities.len());
        for (index, entity) in scene.entities.iter().enumerate() {
            let path = match &entity.name {
                Some(name) => format!("{file}#entities.{}", name.value),
                None => format!("{file}#entities.{index}"),
            };
            let prototype = self.entity(&mut scope, entity, &path, !file.is_empty());
            prototypes.push(prototype);
        }
        self.warn_unused(first);
        let count = prototypes.iter().map(Prototype::count).fold(0, u64::saturating_add);
        Content { prototypes, count }
    }

    fn materials<'f>(&mut self, file: &str, materials: &'f Named<schema::Material>) -> HashMap<&'f str, Option<u32>> {
        self.define(file, "materials", materials, |session, material| {
            convert::material(session, material)
                .map(|(material, detail)| Defined::Material(Arc::new(material), detail.map(Arc::new)))
        })
    }

    fn shapes<'f>(&mut self, file: &str, shapes: &'f Named<schema::Shape>) -> HashMap<&'f str, Option<u32>> {
        self.define(file, "shapes", shapes, |session, shape| {
            convert::shape(session, shape).map(|(shape, place)| Defined::Shape(shape, place))
        })
    }

    /// Makes definitions of named things; `None` stands for one that was reported.
    fn define<'f, T>(
        &mut self,
        file: &str,
        kind: &str,
        named: &'f Named<T>,
        convert: impl Fn(&mut Session, &Spanned<T>) -> Option<Defined>,
    ) -> HashMap<&'f str, Option<u32>> {
        let mut rows: HashMap<&str, Option<u32>> = HashMap::new();
        let mut places: HashMap<&str, Span> = HashMap::new();
        for (name, value) in &named.rows {
            let text = name.value.as_str();
            if let Some(first) = places.insert(text, name.span) {
                self.duplicate(kind, name, first);
                continue;
            }
            let value = value.as_ref().and_then(|value| Some((convert(self.session, value)?, name.span)));
            let row = value.map(|(is, span)| {
                let key = self.keys.definition(&format!("{file}#{kind}.{text}"));
                self.push_definition(key, Some(text.into()), span, is, false)
            });
            rows.insert(text, row);
        }
        rows
    }

    fn duplicate(&mut self, kind: &str, name: &Spanned<String>, first: Span) {
        let message = format!("the name {:?} is given twice in `{kind}`", name.value);
        let first = format!("first given at {}", self.session.sources.describe(first));
        self.session.found.push(self.session.sources.error(Code::Duplicate, name.span, message).note(first));
    }

    pub(super) fn push_definition(
        &mut self,
        key: u64,
        name: Option<Arc<str>>,
        span: Span,
        is: Defined,
        used: bool,
    ) -> u32 {
        self.definitions.push(Definition { key, name, span, is, used });
        self.definitions.len() as u32 - 1
    }

    /// `repeated` says that the entity may be placed more than once.
    fn entity(&mut self, scope: &mut Scope, entity: &schema::Entity, path: &str, repeated: bool) -> Prototype {
        let index = scope.next;
        scope.next += 1;
        let repeated = repeated || entity.instances.is_some();
        let schema::Entity { at, rotate, scale, look_at, transform, .. } = entity;
        let place = Place {
            at: *at,
            rotate: rotate.as_ref(),
            scale: *scale,
            look_at: look_at.as_ref(),
            transform: transform.as_ref(),
        };
        let model = entity.model();
        let (shape, shape_place) = self.shape(scope, entity, path, repeated);
        let (mut material, detail) = self.material(scope, entity, path, repeated || model.is_some());
        let include = match model {
            None => entity.include.as_ref().and_then(|include| self.include(include)),
            Some((model, materials)) => {
                // What is in the file wears what the entity would.
                let all = match std::mem::replace(&mut material, Part::None) {
                    Part::Of(row) => Some(row),
                    _ => None,
                };
                let worn = Worn { all, by_name: self.worn(&scope.materials, materials, path) };
                self.model(model, &worn, path)
            }
        };
        let transform = convert::place(self.session, &place);
        let motion = entity.motion.as_ref().and_then(|motion| convert::motion(self.session, motion, transform));
        let prototype = Prototype {
            span: entity.span,
            name: entity.name.as_ref().map(|name| name.value.as_str().into()),
            index,
            parent: scope.parents.get(&index).copied(),
            is_named_parent: scope.named_parents.contains(&index),
            transform,
            motion: motion.map(Arc::new),
            shape,
            shape_place,
            material,
            detail,
            light: entity.light.as_ref().and_then(|light| convert::light(self.session, light)).map(Arc::new),
            include,
            instances: entity
                .instances
                .as_ref()
                .and_then(|instances| patterns::places(self.session, &mut self.budget, instances)),
            children: (entity.children.iter().enumerate())
                .map(|(row, child)| self.entity(scope, child, &format!("{path}.{row}"), repeated))
                .collect(),
        };
        if entity.intact {
            self.check_composition(entity, &prototype);
        }
        prototype
    }

    fn shape(
        &mut self,
        scope: &Scope,
        entity: &schema::Entity,
        path: &str,
        repeated: bool,
    ) -> (Part<world::Shape>, Affine3A) {
        let nothing = (Part::None, Affine3A::IDENTITY);
        match &entity.shape {
            None => nothing,
            Some(_) if entity.model().is_some() => nothing,
            Some(Reference::Name(name)) => match self.look_up("shape", name, &scope.shapes) {
                Some(row) => match &self.definitions[row as usize].is {
                    Defined::Shape(_, place) => (Part::Of(row), *place),
                    Defined::Material(..) => nothing,
                },
                None => nothing,
            },
            Some(Reference::InPlace(shape)) => match convert::shape(self.session, shape) {
                Some((shape, place)) if !repeated => (Part::Own(Arc::new(shape)), place),
                Some((is, place)) => {
                    let key = self.keys.definition(&format!("{path}.shape"));
                    let is = Defined::Shape(is, place);
                    let row = self.push_definition(key, None, shape.span, is, true);
                    (Part::Of(row), place)
                }
                None => nothing,
            },
        }
    }

    fn material(
        &mut self,
        scope: &Scope,
        entity: &schema::Entity,
        path: &str,
        repeated: bool,
    ) -> (Part<world::Material>, Option<Arc<world::Detail>>) {
        let part = match &entity.material {
            None => Part::None,
            Some(Reference::Name(name)) => {
                self.look_up("material", name, &scope.materials).map_or(Part::None, Part::Of)
            }
            Some(Reference::InPlace(material)) => match convert::material(self.session, material) {
                Some((material, detail)) if !repeated => {
                    return (Part::Own(Arc::new(material)), detail.map(Arc::new));
                }
                Some((is, detail)) => {
                    let key = self.keys.definition(&format!("{path}.material"));
                    let (span, is) = (material.span, Defined::Material(Arc::new(is), detail.map(Arc::new)));
                    Part::Of(self.push_definition(key, None, span, is, true))
                }
                None => Part::None,
            },
        };
        (part, None)
    }

    /// The definition of that name; reports a name that nothing has.
    pub(super) fn look_up(
        &mut self,
        kind: &str,
        name: &Spanned<String>,
        known: &HashMap<&str, Option<u32>>,
    ) -> Option<u32> {
        match known.get(name.value.as_str()) {
            Some(row) => {
                let row = (*row)?;
                self.definitions[row as usize].used = true;
                Some(row)
            }
            None => {
                let mut names: Vec<&str> = known.keys().copied().collect();
                names.sort_unstable();
                let message = format!("there is no {kind} {:?}", name.value);
                let error = self.session.sources.error(Code::UnknownName, name.span, message);
                let error = error.expected(format!("a name from `{kind}s`, or a {kind} in place"));
                self.session.found.push(error.nearest_name(&name.value, names));
                None
            }
        }
    }

    /// Parts that do not go together. Entities with other errors are not looked at.
    fn check_composition(&mut self, entity: &schema::Entity, prototype: &Prototype) {
        let sources = &self.session.sources;
        let mut reports: Vec<Diagnostic> = Vec::new();
        match (&entity.shape, &entity.material) {
            (Some(shape), _) if entity.model().is_some() && entity.include.is_some() => {
                let error = sources.error(Code::Conflict, shape.span(), "a glTF file and an included scene at once");
                reports.push(error.help("`children` may have one each"));
            }
            _ if entity.model().is_some() => {}
            (Some(shape), None) => {
                let error = sources.error(Code::Composition, shape.span(), "a shape without a material cannot be seen");
                reports.push(error.expected("`material` beside `shape`"));
            }
            (None, Some(material)) => {
                let warning =
                    sources.warning(Code::Composition, material.span(), "a material without a shape shows nothing");
                reports.push(warning.help("children do not take over their parent's material"));
            }
            (Some(shape), Some(_)) if self.is_plane(prototype) && self.is_emissive(prototype) => {
                let error = sources.error(Code::Composition, shape.span(), "a plane without end cannot send out light");
                reports.push(error.help("a Quad can"));
            }
            _ => {}
        }
        if let Some(instances) = &entity.instances {
            let empty = !prototype.has_components()
                && entity.model().is_none()
                && prototype.children.is_empty()
                && entity.include.is_none();
            if empty {
                reports.push(sources.warning(Code::Composition, instances.span, "there is nothing to repeat"));
            }
        }
        reports.into_iter().for_each(|report| self.session.found.push(report));
    }

    fn is_plane(&self, prototype: &Prototype) -> bool {
        match &prototype.shape {
            Part::Own(shape) => **shape == world::Shape::Plane,
            Part::Of(row) => matches!(self.definitions[*row as usize].is, Defined::Shape(world::Shape::Plane, _)),
            Part::None => false,
        }
    }

    fn is_emissive(&self, prototype: &Prototype) -> bool {
        let material = match &prototype.material {
            Part::Own(material) => &**material,
            Part::Of(row) => match &self.definitions[*row as usize].is {
                Defined::Material(material, _) => material,
                Defined::Shape(..) => return false,
            },
            Part::None => return false,
        };
        material.shines()
    }

    /// The content of an included file, read once.
    fn include(&mut self, name: &Spanned<String>) -> Option<Rc<Content>> {
        let path = self.session.find(&name.value, name.span)?;
        if let Some(from) = self.stack.iter().position(|(open, _)| *open == path) {
            let chain: Vec<&str> = self.stack[from..].iter().map(|(_, name)| name.as_str()).collect();
            let message = format!("{} includes itself", self.stack[from].1);
            let error = self.session.sources.error(Code::Cycle, name.span, message);
            self.session.found.push(error.note(format!("{} → {}", chain.join(" → "), self.stack[from].1)));
            return None;
        }
        if let Some(content) = self.files.get(&path) {
            return Some(Rc::clone(content));
        }
        let depth = self.session.limits.include_depth;
        if self.stack.len() as u64 > depth {
            let exceeded = Exceeded { name: "include_depth", bound: depth };
            self.session.error(Code::Limit, name.span, format!("too many files within files: {exceeded}"));
            return None;
        }
        let shown = self.session.sources.name_beside(name.span.source, &name.value);
        let content = match self.session.read_include(&path, &name.value, name.span) {
            Some(source) => {
                self.stack.push((path.clone(), shown.clone()));
                let content = read(self.session, source, &[]).map(|scene| self.content(&shown, &scene));
                self.stack.pop();
                content.unwrap_or_default()
            }
            // It was reported; as empty content it is not reported again.
            None => Content::default(),
        };
        let content = Rc::new(content);
        self.files.insert(path, Rc::clone(&content));
        Some(content)
    }

    /// Warns of named definitions, from the row `first` on, that nothing uses. Beside an error that may be its doing.
    fn warn_unused(&mut self, first: usize) {
        if self.session.found.errors() > 0 {
            return;
        }
        for definition in &self.definitions[first..] {
            if let (Some(name), false) = (&definition.name, definition.used) {
                let kind = if matches!(definition.is, Defined::Material(..)) { "material" } else { "shape" };
                let message = format!("the {kind} {name:?} is not used");
                self.session.found.push(self.session.sources.warning(Code::Unused, definition.span, message));
            }
        }
    }
}
