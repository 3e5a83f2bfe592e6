//! A glTF file that was converted to RON makes the picture that the file makes, bit for bit where lamps are not chosen among by
//! chance: their order is another then, and the pictures agree in the mean.
//!
//! Cameras are taken over from the file, since RON's have a point to look at in the place of a matrix.

use std::path::Path;

use brewster_buffers::{Backdrop, SceneBuffers};
use brewster_import::{Importer, LoadOptions, Loaded};
use brewster_world::Scene;
use glam::{UVec2, Vec3};
use serde_json::json;

use crate::gltf_model::{Model, square};
use crate::scene::render;

fn buffers(loaded: &Loaded) -> SceneBuffers {
    let mut scene = Scene::new();
    loaded.scene.apply(scene.world_mut());
    let report = scene.flatten();
    assert!(report.invalid.is_empty(), "{:?}", report.invalid);
    let mut buffers = scene.buffers().clone();
    buffers.settings.resolution = UVec2::new(24, 16);
    buffers.settings.samples = 4;
    buffers.settings.backdrop = Backdrop::Background;
    buffers
}

/// A scene as it is, and after it was written and read again; and what was not written.
fn both(loaded: &Loaded) -> ([SceneBuffers; 2], Vec<String>) {
    let folder = tempfile::tempdir().expect("a folder");
    let exported = loaded.scene.export("parts");
    std::fs::create_dir(folder.path().join("parts")).expect("a folder");
    for (name, bytes) in &exported.files {
        std::fs::write(folder.path().join(name), bytes).expect("a file");
    }
    let converted = Importer::default().load_text(&folder.path().join("scene.ron"), &exported.text);
    let converted = converted.unwrap_or_else(|failure| panic!("{failure}\n{}", exported.text));
    let (ours, mut theirs) = (buffers(loaded), buffers(&converted));
    assert_eq!(ours.settings, theirs.settings);
    assert_eq!(ours.cameras.len(), theirs.cameras.len());
    for (ours, theirs) in ours.cameras.iter().zip(&theirs.cameras) {
        assert_eq!(ours.projection, theirs.projection);
        for (ours, theirs) in [(ours.position, theirs.position), (ours.forward, theirs.forward), (ours.up, theirs.up)] {
            assert!(ours.abs_diff_eq(theirs, 1e-5 * (1.0 + ours.length())), "{ours} {theirs}");
        }
    }
    theirs.cameras.clone_from(&ours.cameras);
    ([ours, theirs], exported.lost)
}

#[test]
fn models_make_the_same_picture_to_the_bit() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("gltf/models");
    for name in [
        "Box/glTF-Binary/Box.glb",
        "BoxInterleaved/glTF-Binary/BoxInterleaved.glb",
        "MultiUVTest/glTF-Binary/MultiUVTest.glb",
        "TextureSettingsTest/glTF-Binary/TextureSettingsTest.glb",
        "TextureTransformTest/glTF/TextureTransformTest.gltf",
        "VertexColorTest/glTF-Binary/VertexColorTest.glb",
        "AttenuationTest/glTF-Binary/AttenuationTest.glb",
        "AnisotropyStrengthTest/glTF-Binary/AnisotropyStrengthTest.glb",
        "SpecularTest/glTF-Binary/SpecularTest.glb",
        "UnlitTest/glTF-Binary/UnlitTest.glb",
        "SuzanneAnimationPointer/SuzanneAnimationPointer.glb",
        "SimpleInstancing/glTF-Binary/SimpleInstancing.glb",
        "Fox/glTF-Binary/Fox.glb",
    ] {
        let loaded = Importer::new(LoadOptions::default()).load(&folder.join(name)).expect(name);
        let ([ours, theirs], lost) = both(&loaded);
        let is_backdrop = |what: &String| what.starts_with("what is behind things");
        assert!(lost.iter().all(is_backdrop), "{name}: {lost:?}");
        let [(ours, _), (theirs, _)] = [render(&ours), render(&theirs)];
        assert!(ours.resolve().pixels.view().color == theirs.resolve().pixels.view().color, "{name}");
    }
}

/// Lights of all kinds with ranges, a lamp, textures of every extension, and a camera of its own.
#[test]
fn lights_and_materials_of_every_kind_are_written() {
    let mut model = Model::new();
    model.camera(3.0, [0.0, 0.0, 4.0]);
    let view = model.view(include_bytes!("scenes/colors.png"));
    model.add("images", json!({"bufferView": view, "mimeType": "image/png"}));
    model.add("samplers", json!({"wrapS": 33071, "wrapT": 33648, "magFilter": 9728}));
    model.add("textures", json!({"source": 0, "sampler": 0}));
    let texture = json!({"index": 0, "extensions": {"KHR_texture_transform": {"offset": [0.1, 0.3], "rotation": 0.4}}});
    let material = model.add(
        "materials",
        json!({
            "name": "all",
            "pbrMetallicRoughness": {"baseColorTexture": texture, "metallicRoughnessTexture": texture},
            "normalTexture": {"index": 0, "scale": 0.3},
            "alphaMode": "MASK",
            "alphaCutoff": 0.1,
            "extensions": {
                "KHR_materials_clearcoat": {"clearcoatFactor": 0.5, "clearcoatTexture": texture, "clearcoatNormalTexture": texture},
                "KHR_materials_sheen": {"sheenColorFactor": [0.3, 0.2, 0.1], "sheenColorTexture": texture, "sheenRoughnessFactor": 0.3},
                "KHR_materials_iridescence": {"iridescenceFactor": 0.7, "iridescenceThicknessTexture": texture},
                "KHR_materials_specular": {"specularFactor": 0.8, "specularColorFactor": [2.0, 1.0, 0.5]},
                "KHR_materials_ior": {"ior": 0.0},
            },
        }),
    );
    let mesh = model.mesh(&square(2.0), material);
    let turned = json!([0.0, 0.258_819, 0.0, 0.965_926]);
    model.node(json!({"mesh": mesh, "name": "same", "rotation": turned}));
    let window = model.add(
        "materials",
        json!({
            "alphaMode": "BLEND",
            "pbrMetallicRoughness": {"baseColorFactor": [0.2, 0.9, 0.3, 0.4]},
            "extensions": {
                "KHR_materials_transmission": {"transmissionFactor": 0.9},
                "KHR_materials_volume": {"thicknessFactor": 0.1, "attenuationDistance": 0.7, "attenuationColor": [0.2, 0.3, 0.9]},
                "KHR_materials_dispersion": {"dispersion": 0.7},
                "KHR_materials_diffuse_transmission": {"diffuseTransmissionFactor": 0.3, "diffuseTransmissionColorFactor": [0.5, 0.2, 0.1]},
                "KHR_materials_anisotropy": {"anisotropyStrength": 0.6, "anisotropyRotation": 1.1, "anisotropyTexture": texture},
            },
        }),
    );
    let mesh = model.mesh(&square(0.5), window);
    model.node(json!({"mesh": mesh, "name": "same", "translation": [0.3, 0.1, 1.0]}));
    let lamp = model.add("materials", json!({"emissiveFactor": [0.9, 0.5, 0.1]}));
    let mesh = model.mesh(&square(0.3), lamp);
    model.node(json!({"mesh": mesh, "translation": [-1.0, 0.7, 0.5]}));
    model.light(json!({"type": "point", "intensity": 3.0, "range": 9.0, "color": [1.0, 0.5, 0.2]}), [1.0, 1.0, 2.0]);
    model.light(
        json!({"type": "spot", "intensity": 5.0, "spot": {"innerConeAngle": 0.1, "outerConeAngle": 0.9}}),
        [0.0; 3],
    );
    model.light(json!({"type": "directional", "intensity": 0.5}), [0.0; 3]);
    let ([mut ours, mut theirs], lost) = both(&model.load());
    assert!(lost.is_empty(), "{lost:?}");
    assert_eq!(ours.materials.rows.len(), theirs.materials.rows.len());
    assert_eq!(ours.lights.len(), 3);
    let mean = |buffers: &mut SceneBuffers| {
        buffers.settings.samples = 256;
        let pixels = render(buffers).0.resolve().pixels;
        (0..pixels.len()).map(|row| Vec3::from_array(pixels.get(row).color)).sum::<Vec3>() / pixels.len() as f32
    };
    let (ours, theirs) = (mean(&mut ours), mean(&mut theirs));
    assert!((ours - theirs).abs().max_element() < 0.01 * ours.max_element(), "{ours} {theirs}");
}
