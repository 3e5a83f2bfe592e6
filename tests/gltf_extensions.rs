//! What extensions say reaches the scene: their numbers and, where they are absent, the defaults that their texts state; and
//! pictures whose values follow from the texts by hand.
//!
//! Further values are expected in `gltf_faults` (units of light, transmission, textures), in `gltf_agrees` (volumes, metals,
//! emission) and beside the importer (compression, animation, instances, visibility). Lobes and furnaces are `brewster-optics`'.

use std::f64::consts::PI;

use brewster_import::{GltfChoices, Importer, LoadOptions};
use brewster_world::Scene;
use brewster_world::components::{Color, Material, Principled, Scalar, Volume};
use glam::{DVec3, Vec3};
use serde_json::{Value, json};

use crate::gltf_faults::{floor, mean, near};
use crate::gltf_model::{Model, square};

/// The one material of a file whose material has extensions.
fn material(extensions: Value) -> Principled {
    let mut model = Model::new();
    let material = model.add("materials", json!({"extensions": extensions, "emissiveFactor": [0.5, 0.25, 1.0]}));
    let mesh = model.mesh(&square(1.0), material);
    model.node(json!({"mesh": mesh}));
    let mut scene = Scene::new();
    let world = scene.world_mut();
    model.load().scene.apply(world);
    match world.query::<&Material>().single(world).expect("one material") {
        Material::Principled(principled) => Principled::clone(principled),
        other => panic!("{other:?}"),
    }
}

#[test]
fn numbers_of_materials_are_those_of_the_file() {
    let found = material(json!({
        "KHR_materials_anisotropy": {"anisotropyStrength": 0.6, "anisotropyRotation": 1.25},
        "KHR_materials_clearcoat": {"clearcoatFactor": 0.75, "clearcoatRoughnessFactor": 0.125},
        "KHR_materials_diffuse_transmission": {
            "diffuseTransmissionFactor": 0.375,
            "diffuseTransmissionColorFactor": [0.5, 0.25, 0.125],
        },
        "KHR_materials_dispersion": {"dispersion": 0.5},
        "KHR_materials_emissive_strength": {"emissiveStrength": 4.0},
        "KHR_materials_ior": {"ior": 1.4},
        "KHR_materials_iridescence": {
            "iridescenceFactor": 0.5,
            "iridescenceIor": 1.8,
            "iridescenceThicknessMinimum": 200.0,
            "iridescenceThicknessMaximum": 800.0,
        },
        "KHR_materials_sheen": {"sheenColorFactor": [0.9, 0.6, 0.3], "sheenRoughnessFactor": 0.25},
        "KHR_materials_specular": {"specularFactor": 0.5, "specularColorFactor": [1.5, 1.0, 0.5]},
        "KHR_materials_transmission": {"transmissionFactor": 0.625},
        "KHR_materials_volume": {
            "thicknessFactor": 0.1,
            "attenuationDistance": 3.0,
            "attenuationColor": [0.5, 0.75, 1.0],
        },
        "KHR_materials_volume_scatter": {"multiscatterColor": [0.25, 0.5, 0.75], "scatterAnisotropy": -0.5},
    }));
    assert_eq!((found.anisotropy.strength, found.anisotropy.rotation), (0.6, 1.25));
    assert_eq!((found.clearcoat, found.clearcoat_roughness), (Scalar::constant(0.75), Scalar::constant(0.125)));
    assert_eq!(found.diffuse_transmission, Scalar::constant(0.375));
    assert_eq!(found.diffuse_transmission_color, Color::Constant(Vec3::new(0.5, 0.25, 0.125)));
    assert_eq!((found.dispersion, found.ior), (0.5, 1.4));
    assert_eq!(found.emission, Color::Constant(Vec3::new(2.0, 1.0, 4.0)));
    let film = found.iridescence;
    assert_eq!((film.factor, film.ior, film.thickness), (Scalar::constant(0.5), 1.8, [200.0, 800.0]));
    assert_eq!(found.sheen_color, Color::Constant(Vec3::new(0.9, 0.6, 0.3)));
    assert_eq!(found.sheen_roughness, Scalar::constant(0.25));
    assert_eq!(found.specular, Scalar::constant(0.5));
    assert_eq!(found.specular_color, Color::Constant(Vec3::new(1.5, 1.0, 0.5)));
    assert_eq!(found.transmission, Scalar::constant(0.625));
    let volume = Volume {
        attenuation_color: Vec3::new(0.5, 0.75, 1.0),
        attenuation_distance: 3.0,
        multiscatter_color: Vec3::new(0.25, 0.5, 0.75),
        anisotropy: -0.5,
        ..Volume::default()
    };
    assert_eq!(found.volume, Some(volume));
}

/// The tables of properties in the extensions' texts.
#[test]
fn defaults_are_those_of_the_extensions_texts() {
    let names = [
        "anisotropy",
        "clearcoat",
        "diffuse_transmission",
        "dispersion",
        "emissive_strength",
        "ior",
        "iridescence",
        "sheen",
        "specular",
        "transmission",
        "volume_scatter",
    ];
    let mut empty = json!({"KHR_materials_volume": {"thicknessFactor": 1.0}});
    for name in names {
        empty[format!("KHR_materials_{name}")] = json!({});
    }
    let found = material(empty);
    let (none, one) = (Scalar::constant(0.0), Scalar::constant(1.0));
    assert_eq!((found.anisotropy.strength, found.anisotropy.rotation, found.anisotropy.texture), (0.0, 0.0, None));
    assert_eq!((&found.clearcoat, &found.clearcoat_roughness), (&none, &none));
    assert_eq!(found.diffuse_transmission, none);
    assert_eq!(found.diffuse_transmission_color, Color::Constant(Vec3::ONE));
    assert_eq!((found.dispersion, found.ior), (0.0, 1.5));
    assert_eq!(found.emission, Color::Constant(Vec3::new(0.5, 0.25, 1.0)));
    let film = found.iridescence;
    assert_eq!((film.factor, film.ior, film.thickness), (none.clone(), 1.3, [100.0, 400.0]));
    assert_eq!((found.sheen_color, found.sheen_roughness), (Color::Constant(Vec3::ZERO), none.clone()));
    assert_eq!((found.specular, found.specular_color), (one, Color::Constant(Vec3::ONE)));
    assert_eq!(found.transmission, none);
    let volume = found.volume.expect("it has a thickness");
    assert_eq!((volume.attenuation_color, volume.attenuation_distance), (Vec3::ONE, f32::INFINITY));
    assert_eq!((volume.multiscatter_color, volume.anisotropy), (Vec3::ZERO, 0.0));
}

/// A square under a lamp, all that is seen.
fn seen(material: Value) -> DVec3 {
    let mut model = Model::new();
    model.camera(0.02, [0.0, 0.0, 1.0]);
    let material = model.add("materials", material);
    let mesh = model.mesh(&square(4.0), material);
    model.node(json!({"mesh": mesh}));
    model.light(json!({"type": "directional", "intensity": 2.0}), [0.0; 3]);
    mean(&model.buffers(0.0, [16, 1]))
}

#[test]
fn what_is_unlit_has_its_base_color() {
    let color = [0.25, 0.5, 0.75, 1.0];
    let unlit = json!({"pbrMetallicRoughness": {"baseColorFactor": color}, "extensions": {"KHR_materials_unlit": {}}});
    near(seen(unlit), DVec3::new(0.25, 0.5, 0.75), 1e-6);
}

/// The extension's text: F_0 is the specular color, alpha = (1 - glossiness)². Along the normal and for alpha = 1 the lobe D G / 4 is
/// 1/(4π). Without that color there is the diffuse one alone, but for what Schlick's value has at grazing angles.
#[test]
fn specular_and_glossiness_are_what_their_text_says() {
    let found = |diffuse: [f32; 4], specular: [f32; 3]| {
        seen(json!({"extensions": {"KHR_materials_pbrSpecularGlossiness": {
            "diffuseFactor": diffuse,
            "specularFactor": specular,
            "glossinessFactor": 0.0,
        }}}))
    };
    near(found([0.0, 0.0, 0.0, 1.0], [0.5, 0.25, 0.125]), 2.0 / PI / 4.0 * DVec3::new(0.5, 0.25, 0.125), 1e-4);
    near(found([0.2, 0.4, 0.8, 1.0], [0.0; 3]), 2.0 / PI * DVec3::new(0.2, 0.4, 0.8), 0.05);
}

/// The extension's text: 1 - (d/range)⁴ of the light is left, and of a cone's the square of what a ramp in the cosine says.
#[test]
fn ranges_and_cones_weaken_lights_as_recommended() {
    let chalk_sends = 0.8 / PI;
    let model = floor(|model| model.light(json!({"type": "point", "intensity": 3.0, "range": 4.0}), [0.0, 0.0, 2.0]));
    near(mean(&model.buffers(0.0, [16, 1])), DVec3::splat(chalk_sends * 3.0 / 4.0 * (1.0 - 0.0625)), 1e-3);
    // The cone shines straight down from aside: at an angle of 0.3 from its axis, over 2 of height.
    let (angle, inner, outer) = (0.3_f64, 0.1_f64, 0.5_f64);
    let spot = json!({"type": "spot", "intensity": 3.0, "spot": {"innerConeAngle": inner, "outerConeAngle": outer}});
    let model = floor(|model| model.light(spot, [2.0 * angle.tan() as f32, 0.0, 2.0]));
    let ramp = (angle.cos() - outer.cos()) / (inner.cos() - outer.cos());
    let expected = chalk_sends * 3.0 * ramp * ramp * angle.cos() * (angle.cos() / 2.0).powi(2);
    near(mean(&model.buffers(0.0, [16, 1])), DVec3::splat(expected), 0.01);
}

#[test]
fn variants_change_materials() {
    let mut model = Model::new();
    let unlit = |red: f32| json!({"pbrMetallicRoughness": {"baseColorFactor": [red, 0.0, 0.0, 1.0]}, "extensions": {"KHR_materials_unlit": {}}});
    model.set("extensionsUsed", json!(["KHR_materials_variants"]));
    model.set(
        "extensions",
        json!({"KHR_materials_variants": {"variants": [{"name": "day"}, {"name": "dusk"}, {"name": "night"}]}}),
    );
    for red in [0.25, 0.5, 0.75] {
        model.add("materials", unlit(red));
    }
    let mappings = json!([{"material": 1, "variants": [1]}, {"material": 2, "variants": [0]}]);
    let mesh = model.mesh(&square(1.0), 0);
    model.extend_primitive(mesh, json!({"KHR_materials_variants": {"mappings": mappings}}));
    model.node(json!({"mesh": mesh}));
    let red = |variant: Option<&str>| {
        let gltf = GltfChoices { variant: variant.map(str::to_owned), ..GltfChoices::default() };
        let options = LoadOptions { gltf, ..LoadOptions::default() };
        let loaded = Importer::new(options).load_gltf("a.glb".as_ref(), &model.glb());
        let mut scene = Scene::new();
        loaded.map_err(|failure| failure.to_string())?.scene.apply(scene.world_mut());
        let world = scene.world_mut();
        match world.query::<&Material>().single(world).expect("one material") {
            Material::Principled(principled) => Ok(principled.base_color.factor().x),
            other => Err(format!("{other:?}")),
        }
    };
    // By name, by number; without a word about a variant, or without one, the default.
    for (variant, expected) in
        [(Some("day"), 0.75), (Some("dusk"), 0.5), (Some("1"), 0.5), (Some("night"), 0.25), (None, 0.25)]
    {
        assert_eq!(red(variant), Ok(expected), "{variant:?}");
    }
    assert!(red(Some("dust")).is_err_and(|said| said.contains("dusk")));
}
