//! glTF files within scenes: what is in one becomes the content of an entity, as if a scene file were included.

use std::collections::HashMap;
use std::fmt::Write;
use std::path::Path;
use std::rc::Rc;
use std::sync::Arc;

use super::content::{Content, Defined, Prototype, Resolver};
use super::convert;
use super::schema::{self, Shape};
use super::values::{Named, Reference, Spanned};
use crate::diagnostics::Code;
use crate::gltf::{self, GltfChoices};
use crate::scene::{Part, Row};
use crate::source::Span;

/// Which materials take the places of a file's.
#[derive(Default)]
pub(super) struct Worn {
    /// The definition that everything wears.
    pub all: Option<u32>,
    /// Definitions by the names of the file's materials.
    pub by_name: Vec<(Spanned<String>, u32)>,
}

impl Resolver<'_, '_> {
    /// What a shape that is a glTF file brings, and what it wears; `path` is that of its entity.
    pub(super) fn model(&mut self, shape: &Spanned<Shape>, worn: &Worn, path: &str) -> Option<Rc<Content>> {
        let Shape::Gltf { file, node, scene, variant, animation, time, shutter, .. } = &shape.value else {
            return None;
        };
        if !gltf::is_gltf(Path::new(&file.value)) {
            let error = self.session.sources.error(Code::Gltf, file.span, format!("{:?} is no glTF file", file.value));
            self.session.found.push(error.expected("a file whose name ends in .gltf or .glb"));
            return None;
        }
        let choices = GltfChoices {
            scene: scene.clone(),
            variant: variant.clone(),
            animation: animation.clone(),
            time: *time,
            shutter: *shutter,
        };
        let asset = self.session.read_asset(&file.value, file.span)?;
        let mut key = format!("{}|{node:?}|{choices:?}|{:?}", asset.path.display(), worn.all);
        for (name, row) in &worn.by_name {
            let _ = write!(key, "|{:?}={row}", name.value);
        }
        if let Some(known) = self.models.get(&key) {
            return Some(Rc::clone(known));
        }
        let part = node.as_ref().map(|node| (node.value.as_str(), node.span));
        let rows = gltf::part(self.session, &asset, &choices, part, shape.span)?;
        let content = Rc::new(self.placed(rows, worn, path)?);
        self.models.insert(key, Rc::clone(&content));
        Some(content)
    }

    /// The definitions that take the places of materials of a file.
    pub(super) fn worn(
        &mut self,
        known: &HashMap<&str, Option<u32>>,
        materials: &Named<Reference<schema::Material>>,
        path: &str,
    ) -> Vec<(Spanned<String>, u32)> {
        let mut by_name = Vec::new();
        for (name, material) in &materials.rows {
            let row = match material.as_ref().map(|material| &material.value) {
                None => None,
                Some(Reference::Name(wanted)) => self.look_up("material", wanted, known),
                Some(Reference::InPlace(material)) => convert::material(self.session, material).map(|(is, detail)| {
                    let is = Defined::Material(Arc::new(is), detail.map(Arc::new));
                    let key = format!("{path}.shape.materials.{}", name.value);
                    self.define_used(&key, None, material.span, is)
                }),
            };
            by_name.extend(row.map(|row| (name.clone(), row)));
        }
        by_name
    }

    /// The rows of a file as entities, their materials as definitions.
    fn placed(&mut self, rows: Vec<Row>, worn: &Worn, path: &str) -> Option<Content> {
        let is_material = |row: &&Row| row.transform.is_none();
        let names: Vec<&str> = rows.iter().filter(is_material).filter_map(|row| row.name.as_deref()).collect();
        for (name, _) in &worn.by_name {
            if !names.contains(&name.value.as_str()) {
                let message = format!("the file has no material {:?} here", name.value);
                let error = self.session.sources.error(Code::UnknownName, name.span, message);
                self.session.found.push(error.nearest_name(&name.value, names.iter().copied()));
                return None;
            }
        }
        let mut definitions: Vec<Option<u32>> = vec![None; rows.len()];
        for (at, row) in rows.iter().enumerate().filter(|(_, row)| is_material(row)) {
            let named = row.name.as_deref();
            let given = worn.by_name.iter().find(|(name, _)| named == Some(&name.value)).map(|given| given.1);
            definitions[at] = worn.all.or(given).or_else(|| {
                let Part::Own(material) = &row.material else { return None };
                self.session.refuse_unless_rendered(material, row.span);
                let is = Defined::Material(Arc::clone(material), row.detail.clone());
                Some(self.define_used(&format!("{path}.shape.{at}"), row.name.clone(), row.span, is))
            });
        }
        // Entities name their parents, so that nothing here is as deep as the file's nodes.
        let placed = rows.into_iter().enumerate().filter(|(_, row)| row.transform.is_some());
        let prototypes: Vec<Prototype> = placed
            .map(|(at, row)| Prototype {
                name: row.name,
                parent: row.parent,
                transform: row.transform.unwrap_or_default(),
                motion: row.motion,
                shape: row.shape,
                material: match row.material {
                    Part::Of(row) => definitions[row as usize].map_or(Part::None, Part::Of),
                    _ => Part::None,
                },
                light: row.light,
                ..Prototype::empty(row.span, at as u32)
            })
            .collect();
        let count = prototypes.len() as u64;
        Some(Content { prototypes, count })
    }

    fn define_used(&mut self, key: &str, name: Option<Arc<str>>, span: Span, is: Defined) -> u32 {
        let key = self.keys.definition(key);
        self.push_definition(key, name, span, is, true)
    }
}
