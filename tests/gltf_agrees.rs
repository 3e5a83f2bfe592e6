//! A ball in a glTF file is the same ball with the material that its own should come to: glass with a volume is the dielectric
//! that absorbs, chalk is Lambert's, metal is the rough conductor of Schlick's color.

use std::path::Path;

use brewster_buffers::{SamplerKind, SceneBuffers};
use brewster_import::Importer;
use brewster_world::Scene;
use serde_json::{Value, json};

use crate::gltf_model::{Model, ball};
use crate::principled::alike;

/// The ball under a sky, over a floor, beside a lamp; it wears its own material or another.
fn scene(folder: &Path, material: &str) -> SceneBuffers {
    let text = format!(
        r#"Scene(
            settings: (integrator: Path, resolution: (48, 32), max_depth: 8, samples: 8, filter: Box),
            camera: Perspective(eye: (0, 1.5, 5), target: (0, 0.8, 0), vfov: 36),
            background: Gradient(horizon: (1, 0.9, 0.8), zenith: (0.2, 0.4, 0.9), ground: 0.2),
            entities: [
                (shape: Quad(size: (12, 12)), material: Lambert(albedo: Checker(a: 0.2, b: 0.7, size: 0.125)), rotate: (x: -90)),
                (shape: Gltf(file: "ball.glb"), {material} at: (0, 0.9, 0), scale: 0.8),
                (shape: Quad(size: (0.5, 0.5)), material: Emissive(radiance: 20), at: (2, 2.5, 1), rotate: (y: 40, x: 70)),
            ],
        )"#
    );
    let loaded = Importer::default().load_text(&folder.join("scene.ron"), &text);
    let mut scene = Scene::new();
    loaded.unwrap_or_else(|failure| panic!("{failure}")).scene.apply(scene.world_mut());
    assert!(scene.flatten().invalid.is_empty());
    let mut buffers = scene.buffers().clone();
    buffers.settings.sampler = SamplerKind::Independent;
    buffers
}

#[track_caller]
fn agree(material: Value, other: &str) {
    let folder = tempfile::tempdir().expect("a folder");
    let mut model = Model::new();
    let material = model.add("materials", material);
    let mesh = model.mesh(&ball(4), material);
    model.node(json!({"mesh": mesh}));
    std::fs::write(folder.path().join("ball.glb"), model.glb()).expect("a file");
    alike(scene(folder.path(), ""), scene(folder.path(), &format!("material: {other},")), other);
}

/// e^-1 of the light is left after half a meter: 2 per meter.
#[test]
fn glass_with_a_volume_is_a_dielectric_that_absorbs() {
    for (roughness, ior, other) in [
        (0.0, 1.5, "Dielectric(ior: 1.5, absorption: (0, 1, 2))"),
        (0.5, 1.33, "Dielectric(ior: 1.33, alpha: 0.25, absorption: (0, 1, 2))"),
    ] {
        agree(
            json!({
                "pbrMetallicRoughness": {"metallicFactor": 0.0, "roughnessFactor": roughness},
                "extensions": {
                    "KHR_materials_transmission": {"transmissionFactor": 1.0},
                    "KHR_materials_ior": {"ior": ior},
                    "KHR_materials_volume": {
                        "thicknessFactor": 0.01,
                        "attenuationDistance": 0.5,
                        "attenuationColor": [1.0, 0.606_530_66, 0.367_879_44],
                    },
                },
            }),
            other,
        );
    }
}

/// Black lets all be absorbed; white by many scatterings, all be scattered.
#[test]
fn a_volume_that_scatters_is_a_dielectric_that_does() {
    for (multiple, inside) in [(0.0, "absorption: (0, 1, 2)"), (1.0, "scattering: (0, 1, 2), anisotropy: 0.6")] {
        agree(
            json!({
                "pbrMetallicRoughness": {"metallicFactor": 0.0, "roughnessFactor": 0.0},
                "extensions": {
                    "KHR_materials_transmission": {"transmissionFactor": 1.0},
                    "KHR_materials_volume": {
                        "thicknessFactor": 0.01,
                        "attenuationDistance": 0.5,
                        "attenuationColor": [1.0, 0.606_530_66, 0.367_879_44],
                    },
                    "KHR_materials_volume_scatter": {
                        "multiscatterColor": [multiple, multiple, multiple],
                        "scatterAnisotropy": 0.6,
                    },
                },
            }),
            &format!("Dielectric(ior: 1.5, {inside})"),
        );
    }
}

#[test]
fn chalk_is_lamberts_and_metal_a_rough_conductor() {
    let color = [0.9, 0.6, 0.3, 1.0];
    agree(
        json!({
            "pbrMetallicRoughness": {"baseColorFactor": color, "metallicFactor": 0.0},
            "extensions": {"KHR_materials_specular": {"specularFactor": 0.0}},
        }),
        "Lambert(albedo: (0.9, 0.6, 0.3))",
    );
    for (roughness, alpha) in [(0.5, 0.25), (1.0, 1.0)] {
        agree(
            json!({"pbrMetallicRoughness": {"baseColorFactor": color, "roughnessFactor": roughness}}),
            &format!("Metal(r0: (0.9, 0.6, 0.3), alpha: {alpha})"),
        );
    }
}

#[test]
fn what_shines_in_a_file_lights_what_is_around_it() {
    agree(
        json!({
            "pbrMetallicRoughness": {"baseColorFactor": [0.0, 0.0, 0.0, 1.0], "metallicFactor": 0.0},
            "emissiveFactor": [1.0, 0.6, 0.2],
            "extensions": {
                "KHR_materials_emissive_strength": {"emissiveStrength": 5.0},
                "KHR_materials_specular": {"specularFactor": 0.0},
            },
        }),
        "Emissive(radiance: (5, 3, 1), sides: Front)",
    );
}
