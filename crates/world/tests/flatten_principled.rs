//! Principled materials become rows: of their own kind, of the dielectrics for what fills them, of the textures that they
//! name, and of the emitters.

use brewster_buffers::{Axis, Channel, ColorSource, Dielectric, MaterialKind, SceneBuffers, Texture, TextureId};
use brewster_world::Scene;
use brewster_world::components::*;
use glam::Vec3;

const BALL: Shape = Shape::Sphere { radius: 1.0 };

fn flattened(materials: impl IntoIterator<Item = Principled>) -> SceneBuffers {
    let mut scene = Scene::new();
    for material in materials {
        scene.spawn((BALL, Material::Principled(Box::new(material))));
    }
    let report = scene.flatten();
    assert_eq!(report.invalid.len(), 0, "{report}");
    scene.buffers().validate().unwrap();
    scene.buffers().clone()
}

fn glass(volume: Volume) -> Principled {
    let metallic = Scalar::constant(0.0);
    Principled { metallic, transmission: Scalar::constant(1.0), volume: Some(volume), ..Principled::default() }
}

/// e^-1 of the light is left after 2 m: 1/2 per meter.
#[test]
fn a_volume_is_a_row_of_the_dielectrics() {
    let volume = Volume {
        attenuation_color: Vec3::new(1.0, (-1.0f32).exp(), (-2.0f32).exp()),
        attenuation_distance: 2.0,
        priority: 3,
        ..Volume::default()
    };
    let sheet = Principled { volume: None, ..glass(volume.clone()) };
    let opaque = Principled { transmission: Scalar::constant(0.0), ..glass(volume.clone()) };
    let scattering = Principled {
        transmission: Scalar::constant(0.0),
        diffuse_transmission: Scalar::constant(0.5),
        ..glass(Volume::default())
    };
    let buffers = flattened([sheet, glass(volume), opaque, scattering]);
    let none = brewster_buffers::Principled::NO_MEDIUM;
    assert_eq!(buffers.materials.principled.view().medium, [none, 0, none, 1]);
    let Dielectric { ior, absorption, priority, thin, .. } = buffers.materials.dielectric.get(0);
    assert_eq!((ior, priority, thin), (1.5, 3, false));
    assert!(absorption.abs_diff_eq(Vec3::new(0.0, 0.5, 1.0), 1e-6), "{absorption}");
    assert_eq!(buffers.materials.dielectric.get(1).absorption, Vec3::ZERO, "an infinite distance absorbs nothing");
}

/// KHR_materials_dispersion: 20 over the Abbe number.
#[test]
fn dispersion_is_that_of_the_abbe_number() {
    let buffers = flattened([Principled { dispersion: 0.36, ..glass(Volume::default()) }]);
    let index = buffers.materials.dielectric.get(0).dispersion.expect("a dispersion");
    assert!((index.abbe_number() - 20.0 / 0.36).abs() < 0.01 && (index.ior() - 1.5).abs() < 1e-5, "{index:?}");
}

#[test]
fn textures_are_rows_in_the_order_of_fields() {
    let map = |size| Texture::Checker { a: Vec3::ZERO, b: Vec3::ONE, size };
    let gradient = Texture::Gradient { from: Vec3::ZERO, to: Vec3::ONE, axis: Axis::U };
    let material = Principled {
        base_color: Color::Texture(map(1.0)),
        roughness: Scalar { factor: 0.5, texture: Some((map(2.0), Channel::G)) },
        anisotropy: Anisotropy { strength: 1.0, rotation: 0.0, texture: Some(gradient.clone()) },
        ..Principled::default()
    };
    let buffers = flattened([material]);
    assert_eq!(buffers.textures.rows, [map(1.0), map(2.0), gradient]);
    let row = buffers.materials.principled.get(0);
    let of_textures = (row.base_color.texture, row.roughness.texture, row.anisotropy_texture);
    assert_eq!(of_textures, (TextureId(0), TextureId(1), TextureId(2)));
    assert_eq!((row.roughness.factor, row.roughness.channel), (0.5, Channel::G));
}

#[test]
fn what_shines_is_an_emitter() {
    let lamp = Principled { emission: Color::gray(5.0), ..Principled::default() };
    let picture = Principled { unlit: true, base_color: Color::gray(0.25), ..Principled::default() };
    let buffers = flattened([Principled::default(), lamp, picture]);
    let kinds = [MaterialKind::Principled, MaterialKind::Principled, MaterialKind::Emissive];
    assert_eq!(buffers.materials.rows.view().kind, kinds);
    let emitters = buffers.emitters.rows();
    assert_eq!(emitters.instance, [1, 2]);
    assert_eq!(emitters.two_sided, [true, true]);
    let constants = [5.0, 0.25].map(|nit| ColorSource::constant(Vec3::splat(nit)));
    assert_eq!(emitters.radiance, constants);
}

#[test]
fn a_light_that_is_switched_on_is_found_and_a_volume_that_fills_gets_its_row() {
    let mut scene = Scene::new();
    let of = |principled| Material::Principled(Box::new(principled));
    let entity = scene.spawn((BALL, of(Principled::default()))).id();
    scene.spawn((BALL, of(glass(Volume::default()))));
    scene.flatten();
    assert_eq!((scene.buffers().emitters.len(), scene.buffers().materials.dielectric.len()), (0, 1));
    let lamp = Principled { emission: Color::gray(5.0), ..glass(Volume { priority: 7, ..Volume::default() }) };
    *scene.world_mut().get_mut::<Material>(entity).unwrap() = of(lamp);
    scene.flatten();
    let buffers = scene.buffers();
    buffers.validate().unwrap();
    assert_eq!((buffers.emitters.len(), buffers.materials.dielectric.view().priority), (1, &[7, 0][..]));
}

#[test]
fn numbers_that_are_none_are_named() {
    let default = Principled::default;
    let film = |ior, thickness| {
        let iridescence = Iridescence { ior, thickness: [0.0, thickness], ..default().iridescence };
        Principled { iridescence, ..default() }
    };
    let volume = |attenuation_color, attenuation_distance| {
        let volume = Volume { attenuation_color, attenuation_distance, ..Volume::default() };
        Principled { volume: Some(volume), ..default() }
    };
    for (material, expected) in [
        (Principled { metallic: Scalar::constant(1.5), ..default() }, "a principled factor"),
        (Principled { transmission: Scalar::constant(f32::NAN), ..default() }, "a principled factor"),
        (Principled { base_color: Color::gray(1.5), ..default() }, "at most 1"),
        (Principled { emission: Color::gray(-1.0), ..default() }, "a color must be finite"),
        (Principled { ior: 0.5, ..default() }, "an index of refraction"),
        (Principled { dispersion: -1.0, ..default() }, "a dispersion"),
        (volume(Vec3::splat(2.0), 1.0), "a volume's colors"),
        (volume(Vec3::ONE, 0.0), "its distance above 0"),
        (
            Principled { volume: Some(Volume { anisotropy: -1.0, ..Volume::default() }), ..default() },
            "its anisotropy between -1 and 1",
        ),
        (film(0.5, 100.0), "an iridescent film"),
        (film(1.3, f32::NAN), "an iridescent film"),
    ] {
        let mut scene = Scene::new();
        scene.spawn((BALL, Material::Principled(Box::new(material))));
        let report = scene.flatten();
        let found: Vec<String> = report.invalid.iter().map(|invalid| invalid.to_string()).collect();
        assert!(found.len() == 1 && found[0].contains(expected), "{expected}: {found:?}");
    }
}
