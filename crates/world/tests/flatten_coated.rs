//! Coats become rows of their own, and what lies below them rows of its kind.

use brewster_buffers::{Coated, MaterialKind};
use brewster_world::Scene;
use brewster_world::components::*;
use glam::Vec3;

const BALL: Shape = Shape::Sphere { radius: 1.0 };

fn coat(base: Material, absorption: f32) -> Material {
    let absorption = Vec3::new(absorption, 0.0, 1.0);
    Material::Coated { base: Box::new(base), ior: 1.5, alpha: 0.25, absorption, thickness: 0.5 }
}

fn lambert(albedo: f32) -> Material {
    Material::Lambert { albedo: Color::gray(albedo) }
}

#[test]
fn what_lies_below_a_coat_has_a_row_in_order() {
    let mut scene = Scene::new();
    let entity = scene.spawn((BALL, lambert(0.1))).id();
    scene.spawn((BALL, coat(lambert(0.2), 4.0)));
    scene.spawn((BALL, lambert(0.3)));
    assert_eq!(scene.flatten().invalid.len(), 0);
    let buffers = scene.buffers();
    buffers.validate().unwrap();
    let albedos = |scene: &Scene| scene.buffers().materials.lambert.view().albedo.iter().map(|c| c.factor.x).collect();
    let found: Vec<f32> = albedos(&scene);
    assert_eq!(found, [0.1, 0.2, 0.3]);
    let base = MaterialKind::Lambert;
    let expected = Coated { base, base_row: 1, ior: 1.5, alpha: 0.25, depth: Vec3::new(2.0, 0.0, 0.5) };
    assert_eq!(buffers.materials.coated.get(0), expected);

    *scene.world_mut().get_mut::<Material>(entity).unwrap() = coat(lambert(0.4), 0.0);
    scene.flatten();
    scene.buffers().validate().unwrap();
    let found: Vec<f32> = albedos(&scene);
    assert_eq!((found, scene.buffers().materials.coated.len()), (vec![0.4, 0.2, 0.3], 2));
}

#[test]
fn coats_that_are_none_are_named() {
    let coats = |ior, alpha, thickness| {
        let base = Box::new(lambert(0.5));
        Material::Coated { base, ior, alpha, absorption: Vec3::ONE, thickness }
    };
    for (material, expected) in [
        (coat(Material::Emissive { radiance: Color::WHITE, two_sided: true }, 0.0), "a coat lies over"),
        (coat(coat(lambert(0.5), 0.0), 0.0), "a coat lies over"),
        (coat(lambert(f32::NAN), 0.0), "a color must be finite"),
        (coat(lambert(0.5), -1.0), "absorption and thickness"),
        (coats(0.9, 0.0, 0.0), "an index of refraction"),
        (coats(1.5, 2.0, 0.0), "a GGX width"),
        (coats(1.5, 0.0, f32::INFINITY), "absorption and thickness"),
    ] {
        let mut scene = Scene::new();
        scene.spawn((BALL, material));
        let report = scene.flatten();
        let found: Vec<String> = report.invalid.iter().map(|invalid| invalid.to_string()).collect();
        assert!(found.len() == 1 && found[0].contains(expected), "{expected}: {found:?}");
    }
}
