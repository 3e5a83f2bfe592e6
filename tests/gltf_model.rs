//! glTF files made in tests, and their columns.

use std::path::Path;

use brewster_buffers::{Backdrop, Background, SceneBuffers};
use brewster_import::{Importer, LoadOptions, Loaded};
use brewster_world::Scene;
use glam::{UVec2, Vec2, Vec3, Vec3Swizzles};
use serde_json::{Value, json};

/// A glTF file to be.
pub(crate) struct Model {
    json: Value,
    bytes: Vec<u8>,
}

impl Model {
    /// A file with nothing in it.
    pub(crate) fn new() -> Model {
        let json = json!({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}]});
        Model { json, bytes: Vec::new() }
    }

    /// Adds to a list of the root object; the new one's number.
    pub(crate) fn add(&mut self, list: &str, value: Value) -> usize {
        let lists = self.json.as_object_mut().expect("the root is an object");
        let list = lists.entry(list).or_insert_with(|| json!([])).as_array_mut().expect("a list");
        list.push(value);
        list.len() - 1
    }

    /// Sets a member of the root object.
    pub(crate) fn set(&mut self, name: &str, value: Value) {
        self.json[name] = value;
    }

    /// Adds a view of bytes.
    pub(crate) fn view(&mut self, bytes: &[u8]) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let offset = self.bytes.len();
        self.bytes.extend(bytes);
        self.add("bufferViews", json!({"buffer": 0, "byteOffset": offset, "byteLength": bytes.len()}))
    }

    /// Adds a view of rows of so many bytes.
    pub(crate) fn strided(&mut self, bytes: &[u8], stride: usize) -> usize {
        let view = self.view(bytes);
        self.json["bufferViews"][view]["byteStride"] = json!(stride);
        view
    }

    /// Adds an accessor of floats.
    pub(crate) fn floats<const N: usize>(&mut self, rows: &[[f32; N]]) -> usize {
        let bytes: Vec<u8> = rows.as_flattened().iter().flat_map(|value| value.to_le_bytes()).collect();
        let view = self.view(&bytes);
        let kind = ["", "SCALAR", "VEC2", "VEC3", "VEC4"][N];
        self.add("accessors", json!({"bufferView": view, "componentType": 5126, "count": rows.len(), "type": kind}))
    }

    /// Adds a mesh of one primitive with a material.
    pub(crate) fn mesh(&mut self, mesh: &Triangles, material: usize) -> usize {
        let positions = self.floats(&mesh.positions.iter().map(Vec3::to_array).collect::<Vec<_>>());
        let normals = self.floats(&mesh.normals.iter().map(Vec3::to_array).collect::<Vec<_>>());
        let uvs = self.floats(&mesh.uvs.iter().map(Vec2::to_array).collect::<Vec<_>>());
        let bytes: Vec<u8> = mesh.triangles.as_flattened().iter().flat_map(|corner| corner.to_le_bytes()).collect();
        let view = self.view(&bytes);
        let count = 3 * mesh.triangles.len();
        let indices =
            self.add("accessors", json!({"bufferView": view, "componentType": 5125, "count": count, "type": "SCALAR"}));
        let attributes = json!({"POSITION": positions, "NORMAL": normals, "TEXCOORD_0": uvs});
        let primitive = json!({"attributes": attributes, "indices": indices, "material": material});
        self.add("meshes", json!({"primitives": [primitive]}))
    }

    /// Gives the primitive of a mesh extensions.
    pub(crate) fn extend_primitive(&mut self, mesh: usize, extensions: Value) {
        self.json["meshes"][mesh]["primitives"][0]["extensions"] = extensions;
    }

    /// Adds a node to the scene.
    pub(crate) fn node(&mut self, node: Value) -> usize {
        let node = self.add("nodes", node);
        self.json["scenes"][0]["nodes"].as_array_mut().expect("a list").push(json!(node));
        node
    }

    /// Adds a light at a node, which shines along -Z.
    pub(crate) fn light(&mut self, light: Value, at: [f32; 3]) {
        let lights = &mut self.json["extensions"]["KHR_lights_punctual"]["lights"];
        let number = lights.as_array().map_or(0, Vec::len);
        match lights.as_array_mut() {
            Some(lights) => lights.push(light),
            None => *lights = json!([light]),
        }
        self.node(json!({"translation": at, "extensions": {"KHR_lights_punctual": {"light": number}}}));
    }

    /// Adds a camera that looks along -Z at a square of a width.
    pub(crate) fn camera(&mut self, width: f32, at: [f32; 3]) {
        let size = 0.5 * width;
        let view = json!({"xmag": size, "ymag": size, "znear": 0.0, "zfar": 100.0});
        let camera = self.add("cameras", json!({"type": "orthographic", "orthographic": view}));
        self.node(json!({"camera": camera, "translation": at}));
    }

    /// The file in its binary form.
    pub(crate) fn glb(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        let mut binary = self.bytes.clone();
        binary.resize(binary.len().next_multiple_of(4), 0);
        if !binary.is_empty() {
            json["buffers"] = json!([{"byteLength": binary.len()}]);
        }
        let mut text = json.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let number = |value: usize| (value as u32).to_le_bytes();
        let length = 12 + 8 + text.len() + if binary.is_empty() { 0 } else { 8 + binary.len() };
        let mut file = [*b"glTF", number(2), number(length), number(text.len()), *b"JSON"].concat();
        file.extend(text);
        if !binary.is_empty() {
            file.extend([number(binary.len()), *b"BIN\0"].concat());
            file.extend(binary);
        }
        file
    }

    /// The scene in it, for a square picture.
    pub(crate) fn load(&self) -> Loaded {
        let options = LoadOptions { resolution: Some(UVec2::splat(SIZE)), ..LoadOptions::default() };
        let path = Path::new("in a test.glb");
        Importer::new(options).load_gltf(path, &self.glb()).unwrap_or_else(|failure| panic!("{failure}"))
    }

    /// Its columns, for a square picture of independent samples, before a background that is the same everywhere.
    pub(crate) fn buffers(&self, background: f32, [samples, max_depth]: [u32; 2]) -> SceneBuffers {
        let mut scene = Scene::new();
        self.load().scene.apply(scene.world_mut());
        let report = scene.flatten();
        assert!(report.invalid.is_empty(), "{:?}", report.invalid);
        let mut buffers = scene.buffers().clone();
        buffers.background = Background::Constant(Vec3::splat(background));
        buffers.settings.backdrop = Backdrop::Background;
        buffers.settings.resolution = UVec2::splat(SIZE);
        buffers.settings.samples = samples;
        buffers.settings.max_depth = max_depth;
        buffers
    }
}

/// Width and height of pictures of models.
const SIZE: u32 = 4;

/// Triangles with smooth normals.
pub(crate) struct Triangles {
    pub(crate) positions: Vec<Vec3>,
    pub(crate) normals: Vec<Vec3>,
    pub(crate) uvs: Vec<Vec2>,
    pub(crate) triangles: Vec<[u32; 3]>,
}

/// A square around the origin that faces +Z.
pub(crate) fn square(width: f32) -> Triangles {
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(Vec2::from);
    Triangles {
        positions: corners.map(|uv| ((uv - 0.5) * width).extend(0.0)).to_vec(),
        normals: vec![Vec3::Z; 4],
        uvs: corners.to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    }
}

/// A box around the origin whose sides are flat.
pub(crate) fn cuboid(size: Vec3) -> Triangles {
    let mut all = Triangles { positions: vec![], normals: vec![], uvs: vec![], triangles: vec![] };
    for axis in [Vec3::X, Vec3::Y, Vec3::Z].into_iter().flat_map(|axis| [axis, -axis]) {
        let u = axis.yzx().abs();
        let v = axis.cross(u);
        let first = all.positions.len() as u32;
        for [a, b] in [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]] {
            all.positions.push(0.5 * size * (axis + a * u + b * v));
            all.normals.push(axis);
            all.uvs.push(0.5 * Vec2::new(a + 1.0, b + 1.0));
        }
        all.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }
    all
}

/// A ball around the origin: an octahedron, its sides parted in four `times` over, with the normals of the sphere.
pub(crate) fn ball(times: u32) -> Triangles {
    let mut corners = Vec::new();
    for x in [Vec3::X, -Vec3::X] {
        for y in [Vec3::Y, -Vec3::Y] {
            for z in [Vec3::Z, -Vec3::Z] {
                corners.push(if x.cross(y).dot(z) > 0.0 { [x, y, z] } else { [y, x, z] });
            }
        }
    }
    for _ in 0..times {
        let parted = corners.into_iter().flat_map(|[a, b, c]| {
            let [ab, bc, ca] = [a + b, b + c, c + a].map(Vec3::normalize);
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        });
        corners = parted.collect();
    }
    let positions: Vec<Vec3> = corners.into_iter().flatten().collect();
    let triangles = (0..positions.len() as u32 / 3).map(|triangle| [0, 1, 2].map(|corner| 3 * triangle + corner));
    let triangles = triangles.collect();
    Triangles { normals: positions.clone(), uvs: vec![Vec2::ZERO; positions.len()], positions, triangles }
}
