//! The faults that path tracers of glTF are known for, each with the file that shows it: texture coordinates and transforms that
//! only some textures follow, lights of another unit or weakened by sharing, glass that blocks light or takes its color twice,
//! numbers that are none, lamps that paths have to find by chance, materials that are mixed up, mirrored nodes turned inside out,
//! encodings that are refused.
//!
//! Skins, morph targets and Draco have their tests beside the importer. Unless it is about something else, a surface is chalk:
//! without specular reflection glTF's material is Lambert's.

use std::collections::BTreeSet;
use std::f64::consts::PI;

use brewster_buffers::SceneBuffers;
use brewster_import::{Importer, LoadOptions, Severity};
use brewster_world::Scene;
use brewster_world::components::parts::{Texture, UvSet};
use brewster_world::components::{Color, Detail, Material, Principled, Scalar, UsesMaterial};
use glam::{DVec3, Vec2, Vec3};
use serde_json::{Value, json};

use crate::gltf_model::{Model, cuboid, square};
use crate::scene::picture;

/// The mean color of a scene's picture.
pub(crate) fn mean(scene: &SceneBuffers) -> DVec3 {
    let pixels = picture(scene);
    pixels.iter().map(|(_, color)| *color).sum::<DVec3>() / pixels.len() as f64
}

#[track_caller]
pub(crate) fn near(found: DVec3, expected: impl Into<DVec3>, tolerance: f64) {
    let expected = expected.into();
    let off = (found - expected).abs().max_element();
    assert!(off <= tolerance * expected.max_element(), "{found} instead of {expected}");
}

fn chalk(albedo: f32) -> Value {
    json!({
        "pbrMetallicRoughness": {"baseColorFactor": [albedo, albedo, albedo, 1.0], "metallicFactor": 0.0},
        "doubleSided": true,
        "extensions": {"KHR_materials_specular": {"specularFactor": 0.0}},
    })
}

/// Glass with a color; further extensions by their names.
fn glass(color: [f32; 3], roughness: f32, more: &[(&str, Value)]) -> Value {
    let [r, g, b] = color;
    let pbr = json!({"baseColorFactor": [r, g, b, 1.0], "metallicFactor": 0.0, "roughnessFactor": roughness});
    let transmission = json!({"transmissionFactor": 1.0});
    let mut glass = json!({"pbrMetallicRoughness": pbr, "extensions": {"KHR_materials_transmission": transmission}});
    for (name, extension) in more {
        glass["extensions"][name] = extension.clone();
    }
    glass
}

/// A floor of chalk with albedo 0.8, seen from 1 above, and what lights it.
pub(crate) fn floor(light: impl FnOnce(&mut Model)) -> Model {
    let mut model = Model::new();
    model.camera(0.02, [0.0, 0.0, 1.0]);
    let material = model.add("materials", chalk(0.8));
    let mesh = model.mesh(&square(4.0), material);
    model.node(json!({"mesh": mesh}));
    light(&mut model);
    model
}

/// Adds a square lamp, which shines to both sides.
fn lamp(model: &mut Model, (width, radiance): (f32, f32), at: [f32; 3]) {
    let material = model.add(
        "materials",
        json!({
            "emissiveFactor": [1.0, 1.0, 1.0],
            "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": radiance}},
        }),
    );
    let mesh = model.mesh(&square(width), material);
    model.node(json!({"mesh": mesh, "translation": at}));
}

/// A candela at a distance d is 1/d² lux, and chalk sends back albedo/π of that, whatever else there is to sample: no 683, no π
/// too many, and no part for what paths could have met.
#[test]
fn lights_without_size_are_as_bright_as_their_units_say() {
    for (light, expected) in [
        (json!({"type": "point", "intensity": 3.0}), 0.8 / PI * 3.0 / 4.0),
        (json!({"type": "spot", "intensity": 3.0, "spot": {"outerConeAngle": 0.5}}), 0.8 / PI * 3.0 / 4.0),
        (json!({"type": "directional", "intensity": 2.0}), 0.8 / PI * 2.0),
    ] {
        let model = floor(|model| {
            model.light(light.clone(), [0.0, 0.0, 2.0]);
            // Below the floor: it is there to be chosen, and lights nothing that is seen.
            lamp(model, (1.0, 1.0), [0.0, 0.0, -1.0]);
        });
        // 16 pixels choose between two lights 4096 times each.
        near(mean(&model.buffers(0.0, [4096, 1])), DVec3::splat(expected), 0.01);
    }
}

#[test]
fn emission_is_radiance() {
    let mut model = Model::new();
    model.camera(0.02, [0.0, 0.0, 1.0]);
    lamp(&mut model, (1.0, 7.5), [0.0; 3]);
    near(mean(&model.buffers(0.0, [4, 1])), DVec3::splat(7.5), 1e-6);
}

/// A lamp of 1 cm at 1 m fills 1/31,416 of the hemisphere: of 1024 paths that go anywhere none or one would meet it.
#[test]
fn lamps_are_sampled() {
    let model = floor(|model| lamp(model, (0.01, 5000.0), [0.0, 0.0, 2.0]));
    // L A/d² is off by a part of A/d² only.
    near(mean(&model.buffers(0.0, [64, 1])), DVec3::splat(0.8 / PI * 5000.0 * 1e-4 / 4.0), 2e-3);
}

/// A sheet reflects 0.04 along its normal and colors what it lets through, once. Light without size comes straight through smooth
/// sheets, and by way of the sheet through rough ones.
#[test]
fn light_passes_smooth_and_rough_glass() {
    let color = [0.5, 1.0, 0.25];
    let through = 0.8 / PI * 2.0 * 0.96 * DVec3::from(color.map(f64::from));
    // Of the light from above, facets of alpha 0.25 pass on the integral of D G/4 over the hemisphere, which is 0.9158.
    for (roughness, depth, samples, part, tolerance) in [(0.0, 1, 16, 1.0, 1e-4), (0.5, 2, 8192, 0.9158, 0.01)] {
        let model = floor(|model| {
            model.light(json!({"type": "directional", "intensity": 2.0}), [0.0; 3]);
            let material = model.add("materials", glass(color, roughness, &[]));
            let mesh = model.mesh(&square(400.0), material);
            // Above the camera.
            model.node(json!({"mesh": mesh, "translation": [0.0, 0.0, 1.5]}));
        });
        near(mean(&model.buffers(0.0, [samples, depth])), part * through, tolerance);
    }
    // Two sheets, and a veil that is half there before them.
    let model = floor(|model| {
        model.light(json!({"type": "point", "intensity": 2.0}), [0.0, 0.0, 2.0]);
        let mut veil = glass(color, 0.0, &[]);
        veil["alphaMode"] = json!("BLEND");
        veil["pbrMetallicRoughness"]["baseColorFactor"][3] = json!(0.5);
        for (material, height) in [(glass(color, 0.0, &[]), 1.25), (glass(color, 0.0, &[]), 1.5), (veil, 1.75)] {
            let material = model.add("materials", material);
            let mesh = model.mesh(&square(4.0), material);
            model.node(json!({"mesh": mesh, "translation": [0.0, 0.0, height]}));
        }
    });
    let once = 0.96 * DVec3::from(color.map(f64::from));
    near(mean(&model.buffers(0.0, [16, 1])), 0.8 / PI * 0.5 * once * once * (0.5 + 0.5 * once), 1e-4);
}

/// Even light of 1: a sheet passes on 0.96 of it in its color, a slab the rest of two crossings, with what goes to and fro in it.
#[test]
fn glass_colors_light_once_a_crossing() {
    let seen = |material: Value, depth: f32| {
        let mut model = Model::new();
        model.camera(0.02, [0.0, 0.0, 3.0]);
        let material = model.add("materials", material);
        let mesh = if depth > 0.0 { cuboid(Vec3::new(2.0, 2.0, depth)) } else { square(2.0) };
        let mesh = model.mesh(&mesh, material);
        model.node(json!({"mesh": mesh}));
        mean(&model.buffers(1.0, [1024, 32]))
    };
    let volume = ("KHR_materials_volume", json!({"thicknessFactor": 1.0}));
    near(seen(glass([0.5; 3], 0.0, &[]), 0.0), DVec3::splat(0.04 + 0.96 * 0.5), 2e-3);
    near(seen(glass([0.5; 3], 0.0, std::slice::from_ref(&volume)), 1.0), DVec3::splat(0.04 + 0.96 * 0.25), 5e-3);
    // Without a distance nothing is absorbed, whatever the color; with one, by its power of the way.
    let clear = ("KHR_materials_ior", json!({"ior": 1.0}));
    let black = ("KHR_materials_volume", json!({"thicknessFactor": 1.0, "attenuationColor": [0.0, 0.0, 0.0]}));
    near(seen(glass([1.0; 3], 0.0, &[black, clear.clone()]), 1.0), DVec3::ONE, 1e-5);
    let gray = json!({"thicknessFactor": 0.1, "attenuationColor": [0.25, 0.5, 1.0], "attenuationDistance": 0.5});
    let gray = ("KHR_materials_volume", gray);
    near(seen(glass([1.0; 3], 0.0, &[gray, clear.clone()]), 1.0), DVec3::new(0.0625, 0.25, 1.0), 1e-5);
    // What bends nothing is not there, dispersed or not, smooth or rough.
    let dispersion = ("KHR_materials_dispersion", json!({"dispersion": 5.0}));
    for roughness in [0.0, 0.5] {
        let nothing = glass([1.0; 3], roughness, &[volume.clone(), clear.clone()]);
        near(seen(nothing, 1.0), DVec3::ONE, 1e-5);
        // Light that stands for one wavelength weighs what that wavelength does.
        let nothing = glass([1.0; 3], roughness, &[volume.clone(), clear.clone(), dispersion.clone()]);
        near(seen(nothing, 1.0), DVec3::ONE, 0.02);
    }
}

/// All textures of a material, named by the fields of the file.
fn textures(principled: &Principled, detail: &Detail) -> Vec<(&'static str, Texture)> {
    let p = principled;
    let color = |color: &Color| color.texture().cloned();
    let number = |number: &Scalar| number.texture.as_ref().map(|(texture, _)| texture.clone());
    let slots = [
        ("baseColorTexture", color(&p.base_color)),
        ("metallicRoughnessTexture", number(&p.metallic)),
        ("metallicRoughnessTexture", number(&p.roughness)),
        ("emissiveTexture", color(&p.emission)),
        ("normalTexture", detail.normal.as_ref().map(|map| map.texture.clone())),
        ("specularTexture", number(&p.specular)),
        ("specularColorTexture", color(&p.specular_color)),
        ("clearcoatTexture", number(&p.clearcoat)),
        ("clearcoatRoughnessTexture", number(&p.clearcoat_roughness)),
        ("clearcoatNormalTexture", p.clearcoat_normal.as_ref().map(|map| map.texture.clone())),
        ("sheenColorTexture", color(&p.sheen_color)),
        ("sheenRoughnessTexture", number(&p.sheen_roughness)),
        ("anisotropyTexture", p.anisotropy.texture.clone()),
        ("transmissionTexture", number(&p.transmission)),
        ("diffuseTransmissionTexture", number(&p.diffuse_transmission)),
        ("diffuseTransmissionColorTexture", color(&p.diffuse_transmission_color)),
        ("iridescenceTexture", number(&p.iridescence.factor)),
        ("iridescenceThicknessTexture", p.iridescence.thickness_texture.clone().map(|(texture, _)| texture)),
    ];
    slots.into_iter().map(|(name, texture)| (name, texture.unwrap_or_else(|| panic!("no {name}")))).collect()
}

/// Every texture of every extension has a set of coordinates and a transform of its own. (Occlusion textures are not used.)
#[test]
fn every_texture_follows_its_own_coordinates_and_transform() {
    let mut model = Model::new();
    let view = model.view(include_bytes!("scenes/colors.png"));
    model.add("images", json!({"bufferView": view, "mimeType": "image/png"}));
    model.add("textures", json!({"source": 0}));
    // The second set by the reference, the second set by the transform, the first with an offset that is found again.
    let count = std::cell::Cell::new(0);
    let offset = |number: u32| [number as f32 / 64.0, 0.5];
    let mut numbers: Vec<&'static str> = Vec::new();
    let mut next = |name: &'static str| {
        let number = count.replace(count.get() + 1);
        numbers.push(name);
        let mut transform = json!({"offset": offset(number)});
        if number % 3 == 1 {
            transform["texCoord"] = json!(1);
        }
        let set = u32::from(number.is_multiple_of(3));
        json!({"index": 0, "texCoord": set, "extensions": {"KHR_texture_transform": transform}})
    };
    let one = [1.0, 1.0, 1.0];
    let material = json!({
        "pbrMetallicRoughness": {
            "baseColorTexture": next("baseColorTexture"),
            "metallicRoughnessTexture": next("metallicRoughnessTexture"),
        },
        "emissiveFactor": one,
        "emissiveTexture": next("emissiveTexture"),
        "normalTexture": next("normalTexture"),
        "extensions": {
            "KHR_materials_specular": {
                "specularTexture": next("specularTexture"),
                "specularColorTexture": next("specularColorTexture"),
            },
            "KHR_materials_clearcoat": {
                "clearcoatFactor": 1.0,
                "clearcoatTexture": next("clearcoatTexture"),
                "clearcoatRoughnessFactor": 1.0,
                "clearcoatRoughnessTexture": next("clearcoatRoughnessTexture"),
                "clearcoatNormalTexture": next("clearcoatNormalTexture"),
            },
            "KHR_materials_sheen": {
                "sheenColorFactor": one,
                "sheenColorTexture": next("sheenColorTexture"),
                "sheenRoughnessFactor": 1.0,
                "sheenRoughnessTexture": next("sheenRoughnessTexture"),
            },
            "KHR_materials_anisotropy": {"anisotropyStrength": 1.0, "anisotropyTexture": next("anisotropyTexture")},
            "KHR_materials_transmission": {"transmissionFactor": 1.0, "transmissionTexture": next("transmissionTexture")},
            "KHR_materials_diffuse_transmission": {
                "diffuseTransmissionFactor": 1.0,
                "diffuseTransmissionTexture": next("diffuseTransmissionTexture"),
                "diffuseTransmissionColorTexture": next("diffuseTransmissionColorTexture"),
            },
            "KHR_materials_iridescence": {
                "iridescenceFactor": 1.0,
                "iridescenceTexture": next("iridescenceTexture"),
                "iridescenceThicknessTexture": next("iridescenceThicknessTexture"),
            },
        },
    });
    let material = model.add("materials", material);
    let mesh = model.mesh(&square(1.0), material);
    model.node(json!({"mesh": mesh}));
    let mut scene = Scene::new();
    let world = scene.world_mut();
    model.load().scene.apply(world);
    let mut query = world.query::<(&Material, &Detail)>();
    let (material, detail) = query.single(world).expect("one material");
    let Material::Principled(principled) = material else { panic!("{material:?}") };
    for (name, texture) in textures(principled, detail) {
        let Texture::Image(image) = texture else { panic!("{name}: {texture:?}") };
        let number = numbers.iter().position(|known| *known == name).expect("it is in the file") as u32;
        assert_eq!(image.uv_set, if number % 3 < 2 { UvSet::Second } else { UvSet::First }, "{name}");
        // glTF's v points down, and 0 is the picture's upper edge: here that is 1.
        let [u, v] = offset(number);
        assert_eq!(image.transform.apply(Vec2::ZERO), Vec2::new(u, 1.0 - v), "{name}");
    }
}

/// Two meshes of the same numbers with materials of their own, and many instances of a mesh with two.
#[test]
fn instances_wear_the_materials_of_their_primitives() {
    let mut model = Model::new();
    for red in [0.25, 0.5] {
        model.add("materials", json!({"pbrMetallicRoughness": {"baseColorFactor": [red, 0.0, 0.0, 1.0]}}));
    }
    let first = model.mesh(&square(1.0), 0);
    let attributes = json!({"POSITION": 0, "NORMAL": 1});
    let primitive = |material: u32| json!({"attributes": attributes, "indices": 3, "material": material});
    let second = model.add("meshes", json!({"primitives": [primitive(1)]}));
    let both = model.add("meshes", json!({"primitives": [primitive(1), primitive(0)]}));
    let places = model.floats(&[[0.0, 0.0, 1.0], [0.0, 0.0, 2.0], [0.0, 0.0, 3.0]]);
    model.node(json!({"mesh": first}));
    model.node(json!({"mesh": second}));
    model.node(json!({
        "mesh": both,
        "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": places}}},
    }));
    let mut scene = Scene::new();
    let world = scene.world_mut();
    model.load().scene.apply(world);
    let mut query = world.query::<(&brewster_world::components::SceneKey, &UsesMaterial)>();
    let mut worn: Vec<_> = query.iter(world).map(|(key, worn)| (key.0, worn.0)).collect();
    worn.sort();
    let reds: Vec<f32> = worn
        .iter()
        .map(|&(_, entity)| match world.get::<Material>(entity) {
            Some(Material::Principled(principled)) => principled.base_color.factor().x,
            other => panic!("{other:?}"),
        })
        .collect();
    assert_eq!(reds, [0.25, 0.5, 0.5, 0.25, 0.5, 0.25, 0.5, 0.25]);
    assert_eq!(worn.iter().map(|row| row.1).collect::<BTreeSet<_>>().len(), 2, "two materials are two entities");
}

/// glTF 2.0, 3.7.4: a node whose transform has a negative determinant reverses the winding of its triangles. So fronts stay where the
/// normals point, toward +Z here unless z is mirrored.
#[test]
fn mirrored_nodes_keep_their_fronts() {
    for signs in 0..8 {
        let scale = [0, 1, 2].map(|axis| if signs >> axis & 1 == 0 { 1.0 } else { -1.0 });
        let mut model = Model::new();
        model.camera(0.02, [0.0, 0.0, 1.0]);
        let material = model.add("materials", json!({"emissiveFactor": [1.0, 1.0, 1.0]}));
        let mesh = model.mesh(&square(1.0), material);
        model.node(json!({"mesh": mesh, "scale": scale}));
        let expected = if scale[2] > 0.0 { 1.0 } else { 0.0 };
        let found = mean(&model.buffers(0.0, [4, 1]));
        assert_eq!(found, DVec3::splat(expected), "scale {scale:?}");
    }
}

/// A picture of one pixel, from the questions and answers on Google's WebP pages.
const WEBP: &str = "524946461a000000574542505650384c0d0000002f00000010071011118888fe0700";

#[test]
fn webp_is_read() {
    let bytes: Vec<u8> =
        (0..WEBP.len() / 2).map(|byte| u8::from_str_radix(&WEBP[2 * byte..2 * byte + 2], 16).expect("hex")).collect();
    let mut model = Model::new();
    model.set("extensionsRequired", json!(["EXT_texture_webp"]));
    let view = model.view(&bytes);
    model.add("images", json!({"bufferView": view, "mimeType": "image/webp"}));
    model.add("textures", json!({"extensions": {"EXT_texture_webp": {"source": 0}}}));
    let material = model.add("materials", json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}));
    let mesh = model.mesh(&square(1.0), material);
    model.node(json!({"mesh": mesh}));
    let loaded = Importer::new(LoadOptions::default()).load_gltf("a.glb".as_ref(), &model.glb()).expect("it is right");
    let warned: Vec<_> = loaded.diagnostics.iter().filter(|said| said.severity != Severity::Note).collect();
    assert!(warned.is_empty(), "{warned:?}");
    let mut scene = Scene::new();
    let world = scene.world_mut();
    loaded.scene.apply(world);
    let material = world.query::<&Material>().single(world).expect("one material");
    let Material::Principled(principled) = material else { panic!("{material:?}") };
    let Some(Texture::Image(image)) = principled.base_color.texture() else { panic!("{principled:?}") };
    assert_eq!((image.image.width, image.image.height), (1, 1));
}
