//! A model that is stored in another way is the same model, to the bit: quantized or plain, its picture as WebP, as KTX2 or as PNG.
//! Where an encoder rounds, a picture is off by a twentieth of what other samples make of it at most.

use std::io::Cursor;
use std::path::Path;

use brewster_buffers::SceneBuffers;
use brewster_import::{Importer, LoadOptions};
use brewster_world::Scene;
use glam::{DVec2, DVec3, UVec2, Vec3};
use image::{ImageFormat, Rgb, RgbImage};
use serde_json::json;

use crate::gltf_model::{Model, Triangles, cuboid};
use crate::scene::{picture as pixels, render};

/// A picture's type and its file.
type Picture = (&'static str, Vec<u8>);

/// A picture of squares in some colors.
fn picture(format: ImageFormat) -> Picture {
    let picture = RgbImage::from_fn(32, 16, |x, y| Rgb([(x / 4 * 30) as u8, (y / 4 * 80) as u8, 40]));
    let mut bytes = Vec::new();
    picture.write_to(&mut Cursor::new(&mut bytes), format).expect("a picture");
    (format.to_mime_type(), bytes)
}

/// A box that wears it and stands askew, under a lamp.
fn model((kind, bytes): &Picture, add_mesh: impl FnOnce(&mut Model, &Triangles, usize) -> usize) -> SceneBuffers {
    let mut model = Model::new();
    let view = model.view(bytes);
    model.add("images", json!({"bufferView": view, "mimeType": kind}));
    model.add(
        "textures",
        match *kind {
            "image/webp" => json!({"extensions": {"EXT_texture_webp": {"source": 0}}}),
            "image/ktx2" => json!({"extensions": {"KHR_texture_basisu": {"source": 0}}}),
            _ => json!({"source": 0}),
        },
    );
    let color = json!({"baseColorTexture": {"index": 0}, "metallicFactor": 0.0});
    let material = model.add("materials", json!({"pbrMetallicRoughness": color, "alphaMode": "BLEND"}));
    // Its corners are at 1 and -1, its normals along axes, its texture coordinates 0 and 1: integers stand for these exactly.
    let mesh = add_mesh(&mut model, &cuboid(Vec3::splat(2.0)), material);
    model.node(json!({"mesh": mesh, "rotation": [0.2, 0.3, 0.1, 0.927_361_849_549_570_4], "scale": [0.4, 0.5, 0.6]}));
    model.light(json!({"type": "point", "intensity": 50}), [1.0, 2.0, 3.0]);
    model.camera(1.5, [0.0, 0.0, 4.0]);
    model.buffers(0.25, [64, 3])
}

fn plain(model: &mut Model, mesh: &Triangles, material: usize) -> usize {
    model.mesh(mesh, material)
}

/// KHR_mesh_quantization: positions in steps of 1/32767, normals of 1/127, texture coordinates of 1/65535.
fn quantized(model: &mut Model, mesh: &Triangles, material: usize) -> usize {
    model.set("extensionsRequired", json!(["KHR_mesh_quantization"]));
    let mut attribute = |bytes: Vec<u8>, stride: usize, (component, kind): (u32, &str)| {
        let (view, count) = (model.strided(&bytes, stride), mesh.positions.len());
        let accessor = json!({
            "bufferView": view, "componentType": component, "normalized": true, "count": count, "type": kind,
        });
        model.add("accessors", accessor)
    };
    // Rows of three numbers are filled up to a multiple of four bytes.
    let words = |p: &Vec3| [p.x, p.y, p.z, 0.0].map(|x| ((x * 32767.0).round() as i16).to_le_bytes());
    let bytes = |n: &Vec3| [n.x, n.y, n.z, 0.0].map(|x| (x * 127.0).round() as i8 as u8);
    let positions = attribute(mesh.positions.iter().flat_map(words).flatten().collect(), 8, (5122, "VEC3"));
    let normals = attribute(mesh.normals.iter().flat_map(bytes).collect(), 4, (5120, "VEC3"));
    let uvs = mesh.uvs.iter().flat_map(|uv| [uv.x, uv.y]).map(|x| ((x * 65535.0).round() as u16).to_le_bytes());
    let uvs = attribute(uvs.flatten().collect(), 4, (5123, "VEC2"));
    let corners: Vec<u8> = mesh.triangles.as_flattened().iter().map(|&corner| corner as u8).collect();
    let view = model.view(&corners);
    let indices = json!({"bufferView": view, "componentType": 5121, "count": corners.len(), "type": "SCALAR"});
    let indices = model.add("accessors", indices);
    let attributes = json!({"POSITION": positions, "NORMAL": normals, "TEXCOORD_0": uvs});
    model.add("meshes", json!({"primitives": [{"attributes": attributes, "indices": indices, "material": material}]}))
}

/// The pixels of a picture of one model and of another, which shows something.
#[track_caller]
fn alike(found: &SceneBuffers, expected: &SceneBuffers, what: &str) {
    let (expected, _) = render(expected);
    let colors = expected.resolve().pixels;
    assert!((0..colors.len()).any(|row| colors.get(row).color != colors.get(0).color), "the picture shows nothing");
    assert!(render(found).0 == expected, "{what}");
}

#[test]
fn variants_of_a_model_make_one_picture() {
    let (png, webp) = (picture(ImageFormat::Png), picture(ImageFormat::WebP));
    let expected = model(&png, plain);
    alike(&model(&png, quantized), &expected, "quantized");
    alike(&model(&webp, plain), &expected, "with a WebP picture");
    alike(&model(&webp, quantized), &expected, "quantized, with a WebP picture");
}

/// The PNGs are what Basis Universal's own transcoder makes of the files that its encoder wrote: both its codecs, the second with
/// and without Zstandard.
#[test]
fn basis_pictures_are_what_their_makers_read_in_them() {
    let read = |name: &str| {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("gltf/pictures").join(name);
        std::fs::read(path).expect("the picture")
    };
    for (name, decoded) in [("etc1s.ktx2", "etc1s.png"), ("uastc.ktx2", "uastc.png"), ("uastc-zstd.ktx2", "uastc.png")]
    {
        let (basis, png) = (("image/ktx2", read(name)), ("image/png", read(decoded)));
        alike(&model(&basis, plain), &model(&png, plain), name);
    }
}

/// The columns of a file, for a small picture.
fn stored(name: &str) -> SceneBuffers {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("gltf/models").join(name);
    let loaded = Importer::new(LoadOptions::default()).load(&path).unwrap_or_else(|failure| panic!("{failure}"));
    let mut scene = Scene::new();
    loaded.scene.apply(scene.world_mut());
    scene.flatten();
    let mut buffers = scene.buffers().clone();
    buffers.settings.resolution = UVec2::new(32, 24);
    buffers.settings.samples = 16;
    buffers
}

#[test]
fn files_of_a_model_make_one_picture() {
    let (fox, avocado, cube) = ("Fox/glTF-Binary/Fox.glb", "AvocadoSmall/Avocado.glb", "Box/glTF-Binary/Box.glb");
    alike(&stored("AvocadoSmall/Avocado-webp.glb"), &stored(avocado), "WebP without losses");
    for (plain, twin) in [
        (cube, "Box/glTF-Draco/Box.gltf"),
        (avocado, "AvocadoSmall/Avocado-draco.glb"),
        (avocado, "AvocadoSmall/Avocado-meshopt.glb"),
        (avocado, "AvocadoSmall/Avocado-quantized.glb"),
        (fox, "FoxDraco/Fox-draco.glb"),
        (fox, "FoxMeshopt/Fox-meshopt-cc.glb"),
    ] {
        let plain = stored(plain);
        let mut other_samples = plain.clone();
        other_samples.settings.seed += 1;
        let [plain, twin_pixels, other_samples] = [&plain, &stored(twin), &other_samples].map(pixels);
        let apart = |a: &[(DVec2, DVec3)], b: &[(DVec2, DVec3)]| -> f64 {
            a.iter().zip(b).map(|(a, b)| (a.1 - b.1).abs().element_sum()).sum::<f64>() / a.len() as f64
        };
        let (found, noise) = (apart(&plain, &twin_pixels), apart(&plain, &other_samples));
        assert!(found < 0.05 * noise, "{twin}: {found} apart, and {noise} with other samples");
    }
}
