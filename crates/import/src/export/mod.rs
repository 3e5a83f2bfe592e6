//! Scenes to files: the text of a scene in RON beside the meshes and pictures that it needs.
//!
//! Numbers are written so that they are read back to the bit; only angles, of which some have no degrees in f32, and cameras, whose
//! format has a point to look at in the place of a matrix, may turn in the last digit. What RON has no words for is listed.

mod materials;
mod numbers;

use std::collections::{BTreeMap, HashMap};
use std::fmt::Write;
use std::sync::Arc;

use brewster_world::components as world;
use brewster_world::components::parts::{Backdrop, Background, Image, Integrator, Settings, Texels, TriangleMesh};
use glam::{Affine3A, Vec3};

use crate::mesh::ply;
use crate::scene::{Part, Row, Scene, world_transforms};

use numbers::{color, degrees, names, triple};

/// Nodes within nodes that are written as such; what is deeper stands in the scene's own space. The format bounds brackets.
const DEEPEST: u64 = 24;

/// A scene as files.
#[derive(Debug, Default)]
pub struct Exported {
    /// The scene's own text.
    pub text: String,
    /// Meshes and pictures: their names, seen from the scene's folder, and their bytes.
    pub files: Vec<(String, Vec<u8>)>,
    /// What RON cannot say, a sentence each.
    pub lost: Vec<String>,
}

/// What is being written.
struct Exporter<'s> {
    scene: &'s Scene,
    /// The folder for meshes and pictures.
    folder: &'s str,
    out: Exported,
    /// Names of the rows of materials.
    materials: HashMap<usize, String>,
    /// Names of shapes, by where their triangles are in memory.
    meshes: BTreeMap<*const TriangleMesh, String>,
    /// Names of files, by where their pixels are in memory.
    images: BTreeMap<*const Image, String>,
}

impl Scene {
    /// The scene as files; `folder` is the name of the folder beside it that takes meshes and pictures.
    pub fn export(&self, folder: &str) -> Exported {
        let mut exporter = Exporter {
            scene: self,
            folder,
            out: Exported::default(),
            materials: HashMap::new(),
            meshes: BTreeMap::new(),
            images: BTreeMap::new(),
        };
        let (places, depths) = world_transforms(&self.rows);
        if self.rows.iter().any(|row| row.motion.is_some()) {
            exporter.lose("motion: the converted scene stands as it does when the shutter opens");
        }
        let parts = [
            exporter.settings(),
            exporter.cameras(&places),
            exporter.background(),
            exporter.materials(),
            exporter.shapes(),
            exporter.entities(&places, &depths),
        ];
        exporter.out.text = format!("Scene(\n{})\n", parts.concat());
        exporter.out
    }
}

impl Exporter<'_> {
    fn lose(&mut self, what: impl Into<String>) {
        let what = what.into();
        if !self.out.lost.contains(&what) {
            self.out.lost.push(what);
        }
    }

    fn settings(&mut self) -> String {
        let Settings { resolution, integrator, max_depth, samples, noise_threshold, .. } = self.scene.settings.0;
        let Settings { seed, exposure, tone_mapping, ref backdrop, .. } = self.scene.settings.0;
        if *backdrop != Backdrop::Background {
            self.lose("what is behind things in the picture: the converted scene shows its background there");
        }
        let integrator = match integrator {
            Integrator::Whitted => "Whitted",
            Integrator::Path => "Path",
        };
        let threshold =
            noise_threshold.map(|threshold| format!(" noise_threshold: {threshold:?},")).unwrap_or_default();
        format!(
            "    settings: (\n        resolution: ({}, {}), integrator: {integrator}, max_depth: {max_depth}, samples: {samples},{threshold}\n        \
             seed: {seed}, exposure: {exposure:?}, tone_mapping: {tone_mapping:?},\n    ),\n",
            resolution.x, resolution.y
        )
    }

    /// All cameras by name, in their order.
    fn cameras(&mut self, places: &[Affine3A]) -> String {
        let rows =
            || self.scene.rows.iter().zip(places).filter_map(|(row, place)| Some((row, place, row.camera.as_deref()?)));
        let names = names(rows().map(|(row, ..)| row.name.as_deref()), "camera");
        let mut text = String::from("    cameras: {\n");
        for ((_, place, camera), name) in rows().zip(names) {
            let eye = Vec3::from(place.translation);
            let forward = -Vec3::from(place.matrix3.z_axis).normalize_or(Vec3::Z);
            let up = Vec3::from(place.matrix3.y_axis).normalize_or(Vec3::Y);
            let view = format!("eye: {}, target: {}, up: {}", triple(eye), triple(eye + forward), triple(up));
            let _ = match camera.projection {
                world::Projection::Perspective { vfov } => {
                    writeln!(text, "        {name:?}: Perspective({view}, vfov: {}),", degrees(vfov))
                }
                world::Projection::Orthographic { height } => {
                    writeln!(text, "        {name:?}: Orthographic({view}, height: {height:?}),")
                }
            };
        }
        text + "    },\n"
    }

    fn background(&mut self) -> String {
        match &self.scene.background.0 {
            Background::Constant(radiance) => format!("    background: {},\n", color(*radiance)),
            Background::Gradient { horizon, zenith, ground } => {
                let [horizon, zenith, ground] = [horizon, zenith, ground].map(|radiance| color(*radiance));
                format!("    background: Gradient(horizon: {horizon}, zenith: {zenith}, ground: {ground}),\n")
            }
            Background::Environment(map) => {
                let file = self.image(map.image());
                let rotation = degrees(map.rotation());
                let rows = map.rows();
                format!("    background: Environment(file: {file:?}, rotation: {rotation}, rows: {rows:?}),\n")
            }
        }
    }

    fn materials(&mut self) -> String {
        let scene = self.scene;
        let rows = || scene.rows.iter().enumerate().filter(|(_, row)| matches!(row.material, Part::Own(_)));
        let names = names(rows().map(|(_, row)| row.name.as_deref()), "material");
        let mut text = String::from("    materials: {\n");
        for ((at, row), name) in rows().zip(names) {
            if let Part::Own(material) = &row.material {
                let written = self.material(material, row.detail.as_deref());
                let _ = writeln!(text, "        {name:?}: {written},");
            }
            self.materials.insert(at, name);
        }
        text + "    },\n"
    }

    fn shapes(&mut self) -> String {
        let scene = self.scene;
        let mut text = String::from("    shapes: {\n");
        for row in &scene.rows {
            let Some(world::Shape::Mesh(mesh)) = scene.part(row, |row| &row.shape) else { continue };
            if self.meshes.contains_key(&Arc::as_ptr(mesh)) {
                continue;
            }
            let name = format!("mesh-{}", self.meshes.len());
            let file = format!("{}/{name}.ply", self.folder);
            let _ = writeln!(text, "        {name:?}: Mesh(file: {file:?}),");
            self.out.files.push((file, ply::write(mesh)));
            self.meshes.insert(Arc::as_ptr(mesh), name);
        }
        text + "    },\n"
    }

    /// The name of a picture's file, which is written once.
    fn image(&mut self, image: &Arc<Image>) -> String {
        if let Some(known) = self.images.get(&Arc::as_ptr(image)) {
            return known.clone();
        }
        let ending = if matches!(image.texels, Texels::Floats(_)) { "exr" } else { "png" };
        let file = format!("{}/image-{}.{ending}", self.folder, self.images.len());
        match crate::image::write(image) {
            Ok(bytes) => self.out.files.push((file.clone(), bytes)),
            Err(error) => self.lose(format!("a picture that cannot be written: {error}")),
        }
        self.images.insert(Arc::as_ptr(image), file.clone());
        file
    }

    fn entities(&mut self, places: &[Affine3A], depths: &[u64]) -> String {
        let scene = self.scene;
        let is_entity = |row: &Row| row.transform.is_some() && row.camera.is_none();
        let shown: Vec<usize> = (0..scene.rows.len()).filter(|&at| is_entity(&scene.rows[at])).collect();
        let given = names(shown.iter().map(|&at| scene.rows[at].name.as_deref()), "");
        let names: HashMap<usize, String> = shown.iter().copied().zip(given).collect();
        let mut below: HashMap<Option<usize>, Vec<usize>> = HashMap::new();
        for &at in &shown {
            let parent = scene.rows[at].parent.map(|parent| parent as usize).filter(|_| depths[at] <= DEEPEST);
            below.entry(parent).or_default().push(at);
        }
        let mut text = String::from("    entities: [\n");
        for at in below.get(&None).into_iter().flatten() {
            let place = if depths[*at] > DEEPEST { Some(places[*at]) } else { None };
            text += &self.entity(*at, place, &names, &below, 2);
        }
        text + "    ],\n"
    }

    fn entity(
        &mut self,
        at: usize,
        place: Option<Affine3A>,
        names: &HashMap<usize, String>,
        below: &HashMap<Option<usize>, Vec<usize>>,
        depth: usize,
    ) -> String {
        let scene = self.scene;
        let row = &scene.rows[at];
        let mut fields: Vec<String> = Vec::new();
        if !names[&at].is_empty() {
            fields.push(format!("name: {:?}", names[&at]));
        }
        match scene.part(row, |row| &row.shape) {
            Some(world::Shape::Mesh(mesh)) => fields.push(format!("shape: {:?}", self.meshes[&Arc::as_ptr(mesh)])),
            Some(other) => self.lose(format!("a shape: {other:?}")),
            None => {}
        }
        match row.material {
            Part::Of(material) => fields.push(format!("material: {:?}", self.materials[&(material as usize)])),
            Part::Own(_) => fields.push(format!("material: {:?}", self.materials[&at])),
            Part::None => {}
        }
        fields.extend(row.light.as_deref().map(|light| format!("light: {}", numbers::light(light))));
        fields.extend(numbers::place(place.or(row.transform).unwrap_or_default()));
        let indent = "    ".repeat(depth);
        let children = below.get(&Some(at)).map_or(&[][..], Vec::as_slice);
        if children.is_empty() {
            return format!("{indent}({}),\n", fields.join(", "));
        }
        let mut text =
            format!("{indent}({}{}children: [\n", fields.join(", "), if fields.is_empty() { "" } else { ", " });
        for &child in children {
            text += &self.entity(child, None, names, below, depth + 1);
        }
        text + &format!("{indent}]),\n")
    }
}
