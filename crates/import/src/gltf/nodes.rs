//! Nodes to entities.
//!
//! A node is an entity, with a child for each primitive of its mesh and one for its camera; a mesh with one primitive is the
//! node's own. Nodes that share a mesh share its triangles in memory, so that they are instances of one tree. A mesh with a
//! skin stands where its joints put it, whatever the place of its node: glTF 2.0, 3.7.3.3.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use brewster_world::components as world;
use brewster_world::components::parts::{Affine, TriangleMesh};
use glam::{Affine3A, Mat3A, Quat, Vec3};
use gltf::json::mesh::Semantic;
use gltf::json::validation::Checked;
use gltf::json::{Index, Node, Root};

use super::document::Document;
use super::extensions::{ext_mesh_gpu_instancing, khr_lights_punctual, khr_materials_variants, khr_node_visibility};
use super::meshes::Pose;
use super::textures::Textures;
use super::{Found, GltfChoices, Reporter, broken, cameras, choose, materials, meshes, skins, too_much};
use crate::diagnostics::Code;
use crate::keys::Keys;
use crate::limits::{Budget, Exceeded};
use crate::scene::{Part, Row};
use crate::session::Session;
use crate::source::Span;

/// The entities of the chosen scene, or of the `part` below one of its nodes, which stands where it stands there; materials
/// before those that wear them.
pub(super) fn read(
    (session, reporter): (&mut Session, &mut Reporter),
    document: &Document,
    choices: &GltfChoices,
    span: Span,
    part: Option<usize>,
) -> Found<Vec<Row>> {
    let roots = roots(document, choices)?;
    let (mut order, mut parents) = walk(document, &roots, session.limits.hierarchy)?;
    let local = |node: usize| local(&document.root.nodes[node], &format!("nodes[{node}]"));
    let places = world_places(&order, &parents, local)?;
    let steps = document.steps.iter().map(|locals| world_places(&order, &parents, |node| Ok(locals[node])));
    let steps = steps.collect::<Found<Vec<_>>>()?;
    if let Some(part) = part {
        let mut is_part = vec![false; parents.len()];
        order.retain(|&node| {
            is_part[node] = node == part || parents[node].is_some_and(|parent| is_part[parent]);
            is_part[node]
        });
        if order.is_empty() {
            return Err(broken(format!("nodes[{part}]"), "the node is not in the scene").into());
        }
        parents[part] = None;
    }
    let mut digest = document.digest;
    digest.update(choices.variant.as_deref().unwrap_or_default().as_bytes());
    let digest = digest.finish();
    session.models.push(digest);
    let budget = Budget::new("entities", session.limits.entities);
    let mut spawner = Spawner {
        session,
        reporter,
        document,
        places,
        steps,
        span,
        budget,
        keys: Keys::default(),
        definitions: Vec::new(),
        materials: BTreeMap::new(),
        variant: khr_materials_variants::chosen(&document.root, choices.variant.as_deref())?,
        textures: Textures::default(),
        digest,
        meshes: BTreeMap::new(),
        rows: Vec::new(),
    };
    spawner.textures.read_ahead(spawner.session, document, &worn(document, &order, spawner.variant));
    let mut rows: BTreeMap<usize, Option<u32>> = BTreeMap::new();
    for &node in &order {
        // What is below a hidden node is hidden.
        let parent = match parents[node] {
            None => None,
            Some(parent) => match rows.get(&parent) {
                Some(&row) => Some(row),
                None => continue,
            },
        };
        if khr_node_visibility::is_visible(&document.root.nodes[node], &format!("nodes[{node}]"))? {
            rows.insert(node, spawner.node(node, parent)?);
        }
    }
    Ok(spawner.finish())
}

/// The materials that nodes wear.
fn worn(document: &Document, nodes: &[usize], variant: Option<usize>) -> BTreeSet<usize> {
    let root = &document.root;
    let meshes: BTreeSet<usize> = nodes.iter().filter_map(|&node| Some(root.nodes[node].mesh?.value())).collect();
    let primitives = meshes.into_iter().flat_map(|mesh| &root.meshes[mesh].primitives);
    let of = |primitive| khr_materials_variants::material(root, primitive, variant, "").ok().flatten();
    primitives.filter_map(of).collect()
}

/// The number of the chosen scene; none in a file without scenes.
pub(super) fn chosen_scene(root: &Root, choices: &GltfChoices) -> Found<Option<usize>> {
    match &choices.scene {
        Some(chosen) => choose(chosen, root.scenes.iter().map(|scene| scene.name.as_deref()), "scene").map(Some),
        None => Ok(root.scene.map(|scene| scene.value()).or((!root.scenes.is_empty()).then_some(0))),
    }
}

/// The nodes that the chosen scene begins with: all that have no parent in a file without scenes.
fn roots(document: &Document, choices: &GltfChoices) -> Found<Vec<usize>> {
    let root = &document.root;
    Ok(match chosen_scene(root, choices)? {
        Some(scene) => root.scenes[scene].nodes.iter().map(Index::value).collect(),
        None => {
            let children = root.nodes.iter().filter_map(|node| node.children.as_ref()).flatten();
            let mut is_child = vec![false; root.nodes.len()];
            children.for_each(|child| is_child[child.value()] = true);
            (0..root.nodes.len()).filter(|&node| !is_child[node]).collect()
        }
    })
}

/// The nodes below the roots, each after its parent, and all nodes' parents. No node has two, or is above itself.
fn walk(document: &Document, roots: &[usize], deepest: u64) -> Found<(Vec<usize>, Vec<Option<usize>>)> {
    let nodes = &document.root.nodes;
    let mut parents: Vec<Option<usize>> = vec![None; nodes.len()];
    let mut is_met = vec![false; nodes.len()];
    let mut order = Vec::new();
    let mut open: Vec<(usize, u64)> = Vec::new();
    for &root in roots {
        if std::mem::replace(&mut is_met[root], true) {
            return Err(broken("scenes", format!("node {root} is in the scene twice, or has a parent there")).into());
        }
        open.push((root, 1));
        while let Some((node, depth)) = open.pop() {
            if depth > deepest {
                let exceeded = Exceeded { name: "hierarchy", bound: deepest };
                let message = format!("too many parents of parents: {exceeded}");
                return Err(too_much(format!("nodes[{node}]"), message).into());
            }
            order.push(node);
            let children = nodes[node].children.as_deref().unwrap_or_default();
            for (at, child) in children.iter().enumerate().rev() {
                let child = child.value();
                if std::mem::replace(&mut is_met[child], true) {
                    let message = format!("node {child} has another parent, or is above itself");
                    let problem = broken(format!("nodes[{node}].children[{at}]"), message);
                    return Err(problem.expected("a node with one parent").into());
                }
                parents[child] = Some(node);
                open.push((child, depth + 1));
            }
        }
    }
    Ok((order, parents))
}

/// From every node's space to the world's, by the maps to their parents'.
fn world_places(
    order: &[usize],
    parents: &[Option<usize>],
    local: impl Fn(usize) -> Found<Affine3A>,
) -> Found<Vec<Affine3A>> {
    let mut places = vec![Affine3A::IDENTITY; parents.len()];
    for &node in order {
        let local = local(node)?;
        places[node] = parents[node].map_or(local, |parent| places[parent] * local);
    }
    Ok(places)
}

/// From a node's space to its parent's.
pub(super) fn local(node: &Node, path: &str) -> Found<Affine3A> {
    let place = match &node.matrix {
        Some(matrix) => skins::affine(matrix),
        None => {
            let rotation = node.rotation.map_or(Quat::IDENTITY, |rotation| Quat::from_array(rotation.0));
            let length = rotation.length();
            if !(length > 0.0 && length.is_finite()) {
                let problem = broken(format!("{path}.rotation"), "the rotation is a quaternion of no length");
                return Err(problem.expected("a quaternion x, y, z, w of length 1").into());
            }
            let scale = node.scale.map_or(Vec3::ONE, Vec3::from_array);
            let translation = node.translation.map_or(Vec3::ZERO, Vec3::from_array);
            Affine3A::from_scale_rotation_translation(scale, rotation / length, translation)
        }
    };
    if place.is_finite() { Ok(place) } else { Err(broken(path, "the node's place is not finite").into()) }
}

/// The primitives of a mesh: triangles and the row of the material.
type Primitives = Vec<(Arc<world::Shape>, u32)>;

struct Spawner<'s, 'i> {
    session: &'s mut Session<'i>,
    reporter: &'s mut Reporter,
    document: &'s Document,
    /// From every node's space to the world's.
    places: Vec<Affine3A>,
    /// The same after each step of the shutter's time.
    steps: Vec<Vec<Affine3A>>,
    span: Span,
    budget: Budget,
    keys: Keys,
    /// The rows of materials.
    definitions: Vec<Row>,
    /// Rows in `definitions`, by the file's materials and for the default one, and whether colors of vertices tint them.
    materials: BTreeMap<(Option<usize>, bool), u32>,
    variant: Option<usize>,
    textures: Textures,
    /// Of the file, its buffers and the chosen variant.
    digest: u64,
    /// By mesh, the shapes of those that are not bent.
    meshes: BTreeMap<usize, Vec<Option<Arc<world::Shape>>>>,
    /// Rows of entities: their parents are rows in this list.
    rows: Vec<Row>,
}

impl Spawner<'_, '_> {
    /// The row of a node below its parent's, and those of what it carries; none for a node whose transform, or whose parent's,
    /// flattens space: of that only a mesh with a skin is seen.
    fn node(&mut self, index: usize, parent: Option<Option<u32>>) -> Found<Option<u32>> {
        let path = format!("nodes[{index}]");
        let document = self.document;
        let node = &document.root.nodes[index];
        let mut key = Keys::node(index as u64);
        if parent == Some(None) || !is_regular(&self.places[index]) {
            let message = "a node whose transform flattens space is left out, with all below it but meshes with skins";
            self.reporter.note(Code::Decision, path, message);
            if let (Some(mesh), Some(_)) = (node.mesh, node.skin) {
                let primitives = self.mesh(index, mesh.value())?;
                self.place(index, None, key, &primitives)?;
            }
            return Ok(None);
        }
        let parent = parent.flatten();
        let transform = if parent.is_some() { local(node, &path)? } else { self.places[index] };
        let row = self.push(key, node.name.as_deref(), parent, transform)?;
        let steps = if parent.is_some() { &document.steps } else { &self.steps };
        let steps: Vec<Affine3A> = steps.iter().map(|step| step[index]).collect();
        self.rows[row as usize].motion = self.motion(transform, &steps, &path);
        self.rows[row as usize].light = khr_lights_punctual::of_node(&document.root, node, &path)?.map(Arc::new);
        if let Some(camera) = node.camera {
            let of = &document.root.cameras[camera.value()];
            let aspect = self.session.resolution.map_or(16.0 / 9.0, |size| size.x as f32 / size.y as f32);
            let component = cameras::camera(of, aspect, &format!("cameras[{}]", camera.value()))?;
            key += 1;
            let name = of.name.as_deref().or(node.name.as_deref());
            let row = self.push(key, name, Some(row), Affine3A::IDENTITY)?;
            self.rows[row as usize].camera = Some(Arc::new(component));
        }
        if let Some(mesh) = node.mesh {
            let primitives = self.mesh(index, mesh.value())?;
            self.place(index, Some(row), key, &primitives)?;
        }
        Ok(Some(row))
    }

    /// How a node moves from a place through others.
    fn motion(&mut self, from: Affine3A, steps: &[Affine3A], path: &str) -> Option<Arc<world::Motion>> {
        if steps.iter().all(|step| *step == from) {
            return None;
        }
        if !steps.iter().all(is_regular) {
            let message =
                "a node whose transform flattens space while the shutter is open stays where it is when it opens";
            self.reporter.note(Code::Decision, path, message);
            return None;
        }
        let back = from.inverse();
        world::Motion::through(steps.iter().map(|&step| back * step).collect::<Vec<_>>()).map(Arc::new)
    }

    /// Gives a node's row its primitives, in every place if there are many. Those of a skin stand in the scene, where its joints
    /// put them, and so do its instances' places.
    fn place(
        &mut self,
        node: usize,
        row: Option<u32>,
        mut key: u64,
        primitives: &[(Arc<world::Shape>, u32)],
    ) -> Found<()> {
        let path = format!("nodes[{node}]");
        let within = self.places[node];
        let node = &self.document.root.nodes[node];
        let instances = ext_mesh_gpu_instancing::places(self.document, node, &path)?;
        let parent = row.filter(|_| node.skin.is_none());
        match (primitives, &instances, parent) {
            ([(shape, material)], None, Some(row)) => self.wear(row, shape, *material),
            _ => {
                for place in instances.unwrap_or_else(|| vec![Affine3A::IDENTITY]) {
                    if !is_regular(&place) || !is_regular(&parent.map_or(place, |_| within * place)) {
                        let message = "an instance whose transform flattens space is left out";
                        self.reporter.note(Code::Decision, path.as_str(), message);
                        continue;
                    }
                    for (shape, material) in primitives {
                        key += 1;
                        let row = self.push(key, None, parent, place)?;
                        self.wear(row, shape, *material);
                    }
                }
            }
        }
        Ok(())
    }

    fn wear(&mut self, row: u32, shape: &Arc<world::Shape>, material: u32) {
        let row = &mut self.rows[row as usize];
        row.shape = Part::Own(Arc::clone(shape));
        row.material = Part::Of(material);
    }

    /// The primitives of a node's mesh as the node bends it.
    fn mesh(&mut self, node: usize, index: usize) -> Found<Primitives> {
        let document = self.document;
        let mesh = &document.root.meshes[index];
        let joints = match document.root.nodes[node].skin {
            Some(skin) => skins::joints(document, skin, &self.places)?,
            None => Vec::new(),
        };
        let weights = document.root.nodes[node].weights.as_ref().or(mesh.weights.as_ref());
        let pose = Pose { weights: weights.map_or(&[], Vec::as_slice), joints: &joints };
        let known = self.meshes.get(&index).filter(|_| pose.is_rest()).cloned();
        let shapes = match known {
            Some(shapes) => shapes,
            None => {
                let shapes: Vec<_> = (0..mesh.primitives.len())
                    .map(|primitive| self.shape((index, primitive), pose))
                    .collect::<Found<_>>()?;
                if pose.is_rest() {
                    self.meshes.insert(index, shapes.clone());
                }
                shapes
            }
        };
        let mut primitives = Vec::new();
        for (at, (shape, primitive)) in shapes.into_iter().zip(&mesh.primitives).enumerate() {
            if let Some(shape) = shape {
                let path = format!("meshes[{index}].primitives[{at}]");
                let material = khr_materials_variants::material(&document.root, primitive, self.variant, &path)?;
                let is_tinted = primitive.attributes.contains_key(&Checked::Valid(Semantic::Colors(0)));
                primitives.push((shape, self.material(material, is_tinted)?));
            }
        }
        Ok(primitives)
    }

    /// The shape of a primitive of a mesh; none if it has no area.
    fn shape(&mut self, (mesh, primitive): (usize, usize), pose: Pose) -> Found<Option<Arc<world::Shape>>> {
        let path = format!("meshes[{mesh}].primitives[{primitive}]");
        let of = &self.document.root.meshes[mesh].primitives[primitive];
        let place = (self.digest, mesh, primitive);
        let known = self.session.assets.primitives.get(&place).filter(|_| pose.is_rest());
        if let Some(mesh) = known {
            return Ok(Some(Arc::new(world::Shape::Mesh(Arc::clone(mesh)))));
        }
        let material = khr_materials_variants::material(&self.document.root, of, self.variant, &path)?;
        let tangents = materials::tangents(self.document, material);
        let read: Option<TriangleMesh> =
            meshes::read(self.document, &mut self.session.budgets, self.reporter, of, &path, (pose, tangents))?;
        let Some(mesh) = read.map(Arc::new) else { return Ok(None) };
        if pose.is_rest() {
            self.session.assets.primitives.insert(place, Arc::clone(&mesh));
        }
        Ok(Some(Arc::new(world::Shape::Mesh(mesh))))
    }

    /// The row of a material.
    fn material(&mut self, index: Option<usize>, is_tinted: bool) -> Found<u32> {
        if let Some(&row) = self.materials.get(&(index, is_tinted)) {
            return Ok(row);
        }
        let (material, detail) =
            materials::material((self.session, self.reporter), self.document, &mut self.textures, index, is_tinted)?;
        let tint = if is_tinted { ".tinted" } else { "" };
        let (path, name) = match index {
            Some(index) => (format!("#materials.{index}{tint}"), self.document.root.materials[index].name.as_deref()),
            None => (format!("#material{tint}"), None),
        };
        let key = self.keys.definition(&path);
        let row = Row { name: name.map(Arc::from), transform: None, ..Row::at(key, self.span) };
        let detail = Some(detail).filter(|detail| *detail != world::Detail::default()).map(Arc::new);
        self.definitions.push(Row { material: Part::Own(Arc::new(material)), detail, ..row });
        let row = self.definitions.len() as u32 - 1;
        self.materials.insert((index, is_tinted), row);
        Ok(row)
    }

    fn push(&mut self, key: u64, name: Option<&str>, parent: Option<u32>, place: Affine3A) -> Found<u32> {
        let taken = self.budget.take(1);
        taken.map_err(|over| too_much("nodes", format!("the scene has too many entities: {over}")))?;
        let row = Row { name: name.map(Arc::from), parent, transform: Some(place), ..Row::at(key, self.span) };
        self.rows.push(row);
        Ok(self.rows.len() as u32 - 1)
    }

    /// All rows, materials first.
    fn finish(self) -> Vec<Row> {
        let offset = self.definitions.len() as u32;
        let placed = self.rows.into_iter().map(|row| Row { parent: row.parent.map(|parent| parent + offset), ..row });
        self.definitions.into_iter().chain(placed).collect()
    }
}

/// Whether a transform can be undone, by the tracer, too: the inverse has to be finite.
fn is_regular(place: &Affine3A) -> bool {
    let Mat3A { x_axis: x, y_axis: y, z_axis: z } = place.matrix3;
    let volume = x.cross(y).dot(z).abs();
    let is_flat = volume <= 1e-9 * x.length() * y.length() * z.length() || volume <= f32::MIN_POSITIVE;
    !is_flat && Affine::from_affine3a(*place).is_ok_and(|place| place.inverse().is_ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transforms_whose_inverse_is_not_finite_are_not_regular() {
        let shrunk = |size: f32, far: f32| {
            Affine3A::from_scale_rotation_translation(Vec3::splat(size), Quat::IDENTITY, Vec3::X * far)
        };
        // The inverse is 1/size times a point less far.
        for (size, far, expected) in [(1.0, 1e30, true), (1e-3, 1e30, true), (1e-3, 1e38, false), (1e-12, 1e30, false)]
        {
            assert_eq!(is_regular(&shrunk(size, far)), expected, "{size} at {far}");
        }
        assert!(!is_regular(&Affine3A::from_scale(Vec3::new(1.0, 0.0, 1.0))));
    }
}
