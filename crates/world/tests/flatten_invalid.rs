//! What cannot be flattened is left out and named, at every flatten until it is mended; nothing panics.

use std::sync::Arc;

use bevy_ecs::entity::Entity;
use bevy_ecs::hierarchy::ChildOf;
use bevy_ecs::name::Name;
use brewster_geometry::TriangleMesh;
use brewster_optics::dispersion::{Cauchy, DispersiveIndex};
use brewster_optics::fresnel::FresnelModel;
use brewster_optics::thin_film::Film;
use brewster_world::Scene;
use brewster_world::components::parts::Texture;
use brewster_world::components::*;
use glam::{Affine3A, Vec3};

const GRAY: Material = Material::Lambert { albedo: Color::gray(0.5) };
const BALL: Shape = Shape::Sphere { radius: 1.0 };

/// Spawns one sound instance, then what is given; the report names that entity with a problem that contains `expected`.
fn check(expected: &str, spoil: impl FnOnce(&mut Scene) -> Entity) -> (Scene, Entity) {
    let mut scene = Scene::new();
    scene.spawn((BALL, GRAY));
    let entity = spoil(&mut scene);
    scene.world_mut().entity_mut(entity).insert(Name::new("the odd one"));
    for flatten in ["first", "second"] {
        let report = scene.flatten();
        let found: Vec<String> = report.invalid.iter().map(|invalid| invalid.to_string()).collect();
        let named = format!("\"the odd one\" (entity {entity}): ");
        assert!(
            found.len() == 1 && found[0].starts_with(&named) && found[0].contains(expected),
            "{expected}, {flatten} flatten: {found:#?}"
        );
        let buffers = scene.buffers();
        assert_eq!((buffers.instances.len(), buffers.lights.len(), buffers.cameras.len()), (1, 0, 0), "{expected}");
        buffers.validate().unwrap();
    }
    (scene, entity)
}

fn scaled(x: f32, y: f32, z: f32) -> Transform {
    Transform(Affine3A::from_scale(Vec3::new(x, y, z)))
}

#[test]
fn places_that_are_none_are_left_out() {
    for (place, expected) in [
        (scaled(1.0, 0.0, 1.0), "flattens space"),
        (scaled(f32::NAN, 1.0, 1.0), "no place"),
        (scaled(f32::INFINITY, 1.0, 1.0), "no place"),
        (scaled(1e20, 1e20, 1e20), "1e15 m"),
        (Transform(Affine3A::from_translation(Vec3::X * 1e17)), "1e15 m"),
    ] {
        let (mut scene, entity) = check(expected, |scene| scene.spawn((BALL, GRAY, place)).id());
        *scene.world_mut().get_mut::<Transform>(entity).unwrap() = Transform::default();
        let report = scene.flatten();
        assert_eq!((report.instances.added, report.invalid.len()), (1, 0), "mended: {report}");
        *scene.world_mut().get_mut::<Transform>(entity).unwrap() = place;
        let report = scene.flatten();
        assert_eq!((report.instances.removed, report.invalid.len()), (1, 1), "spoiled again: {report}");
    }
    // A shape that grows out of range in its place.
    let (mut scene, _) = check("1e15 m", |scene| {
        let entity = scene.spawn((BALL, GRAY, scaled(1e6, 1e6, 1e6))).id();
        assert_eq!(scene.flatten().invalid.len(), 0);
        *scene.world_mut().get_mut::<Shape>(entity).unwrap() = Shape::Sphere { radius: 1e12 };
        entity
    });
    assert_eq!(scene.flatten().rows_written(), 0);
}

#[test]
fn parents_in_a_cycle_have_no_place() {
    let (mut scene, entity) = check("parents form a cycle", |scene| {
        let first = scene.spawn(Transform::default()).id();
        let second = scene.spawn(ChildOf(first)).id();
        let hand = scene.spawn((BALL, GRAY, ChildOf(second))).id();
        scene.flatten();
        scene.world_mut().entity_mut(first).insert(ChildOf(second));
        hand
    });
    let parent = scene.world().get::<ChildOf>(entity).unwrap().parent();
    scene.world_mut().entity_mut(parent).remove::<ChildOf>();
    assert_eq!(scene.flatten().invalid.len(), 0);
}

#[test]
fn shapes_that_are_none_are_left_out() {
    let mesh = |triangles: Vec<[u32; 3]>| {
        let positions = vec![Vec3::ZERO, Vec3::X, Vec3::Y];
        Shape::Mesh(Arc::new(TriangleMesh { positions, triangles, ..Default::default() }))
    };
    for (shape, expected) in [
        (Shape::Sphere { radius: -1.0 }, "radius is -1"),
        (Shape::Sphere { radius: f32::NAN }, "radius is NaN"),
        (Shape::Disk { radius: 1.0, inner_radius: 2.0 }, "inner_radius is 2"),
        (Shape::Cuboid { size: Vec3::new(1.0, 0.0, 1.0) }, "half.y is 0"),
        (Shape::Torus { major_radius: 1.0, minor_radius: 1.5 }, "minor_radius is 1.5"),
        (mesh(vec![]), "no triangles"),
        (mesh(vec![[0, 1, 3]]), "names vertex 3"),
    ] {
        let (mut scene, entity) = check(expected, |scene| scene.spawn((shape, GRAY)).id());
        *scene.world_mut().get_mut::<Shape>(entity).unwrap() = BALL;
        let report = scene.flatten();
        assert_eq!((report.instances.added, report.invalid.len()), (1, 0), "mended: {report}");
    }
}

/// It wears its own shape and its own material before another's, even where they are none.
#[test]
fn a_bad_shape_or_material_takes_the_place_of_a_good_one_of_another() {
    check("radius is -1", |scene| {
        let ball = scene.spawn(BALL).id();
        let entity = scene.spawn((UsesShape(ball), GRAY)).id();
        assert_eq!((scene.flatten().instances.added, scene.buffers().instances.len()), (2, 2));
        scene.world_mut().entity_mut(entity).insert(Shape::Sphere { radius: -1.0 });
        entity
    });
    check("a color must be finite", |scene| {
        let gray = scene.spawn(GRAY).id();
        let entity = scene.spawn((BALL, UsesMaterial(gray))).id();
        assert_eq!((scene.flatten().instances.added, scene.buffers().instances.len()), (2, 2));
        scene.world_mut().entity_mut(entity).insert(Material::Lambert { albedo: Color::gray(-1.0) });
        entity
    });
}

fn dielectric(ior: f32, absorption: f32, alpha: f32, dispersion: Option<DispersiveIndex>, thin: bool) -> Material {
    Material::Dielectric {
        ior,
        dispersion,
        fresnel: FresnelModel::Exact,
        specular: Color::WHITE,
        exponent: 1.0,
        absorption: Vec3::splat(absorption),
        scattering: Scattering::NONE,
        bare: false,
        priority: 0,
        alpha,
        film: None,
        thin,
    }
}

#[test]
fn materials_that_are_none_are_left_out() {
    let metal = |reflectance, fresnel| Material::Metal {
        reflectance,
        fresnel,
        specular: Color::WHITE,
        exponent: 1.0,
        alpha: 0.0,
        film: None,
        compensated: false,
    };
    let rough_metal = |alpha| Material::Metal {
        reflectance: Reflectance::Normal { r0: Color::WHITE, r90: Vec3::ONE, f82: Vec3::ONE },
        fresnel: FresnelModel::Schlick,
        specular: Color::WHITE,
        exponent: 1.0,
        alpha,
        film: None,
        compensated: false,
    };
    let filmed = |fresnel, ior, thickness| Material::Metal {
        reflectance: Reflectance::Index { eta: Vec3::ONE, k: Vec3::ONE },
        fresnel,
        specular: Color::WHITE,
        exponent: 1.0,
        alpha: 0.0,
        film: Some(Film { ior, thickness }),
        compensated: false,
    };
    let normal = |r0| Reflectance::Normal { r0: Color::gray(r0), r90: Vec3::ONE, f82: Vec3::ONE };
    let edge = |r0, tint| Reflectance::EdgeTint { r0: Vec3::splat(r0), edge_tint: Vec3::splat(tint) };
    let index = |eta, k| Reflectance::Index { eta: Vec3::splat(eta), k: Vec3::splat(k) };
    let glass = |ior, absorption, alpha| dielectric(ior, absorption, alpha, None, false);
    let medium = |coefficient, anisotropy, film| {
        let mut medium = glass(1.0, 0.0, 0.0);
        let Material::Dielectric { scattering, bare, film: on, .. } = &mut medium else { unreachable!() };
        *scattering = Scattering { coefficient: Vec3::splat(coefficient), anisotropy };
        (*bare, *on) = (true, film);
        medium
    };
    let dispersive = |b, thin| {
        let index = DispersiveIndex::Cauchy(Cauchy { a: 1.5, b, c: 0.0 });
        dielectric(1.5, 0.0, 0.0, Some(index), thin)
    };
    for (material, expected) in [
        (Material::Lambert { albedo: Color::gray(f32::NAN) }, "a color must be finite"),
        (Material::Emissive { radiance: Color::gray(-1.0), two_sided: true }, "a color must be finite"),
        (metal(normal(1.5), FresnelModel::Schlick), "colors must be 0 to 1"),
        (metal(normal(0.5), FresnelModel::Exact), "with an index Exact"),
        (metal(index(0.5, 1.0), FresnelModel::SchlickThetaM), "must be Schlick"),
        (metal(index(0.0, 1.0), FresnelModel::Exact), "eta above 0"),
        (metal(index(1.0, -1.0), FresnelModel::Exact), "k at least 0"),
        (glass(0.9, 0.0, 0.0), "index of refraction must be at least 1"),
        (glass(1.5, -1.0, 0.0), "absorption must be at least 0"),
        (glass(1.5, 0.0, 1.5), "alpha must be 0 to 1"),
        (dispersive(f32::NAN, false), "dispersion must be finite"),
        (dispersive(0.004, true), "not that of a thin sheet"),
        (rough_metal(-0.5), "alpha must be 0 to 1"),
        (rough_metal(f32::NAN), "alpha must be 0 to 1"),
        (metal(edge(1.5, 0.0), FresnelModel::Exact), "colors must be 0 to 1"),
        (metal(edge(0.5, -0.5), FresnelModel::Exact), "colors must be 0 to 1"),
        (filmed(FresnelModel::Schlick, 1.3, 400.0), "a film must"),
        (filmed(FresnelModel::Exact, 0.9, 400.0), "a film must"),
        (filmed(FresnelModel::Exact, 1.3, -1.0), "a film must"),
        (filmed(FresnelModel::Exact, 1.3, f32::NAN), "a film must"),
        (medium(-1.0, 0.0, None), "scattering must be at least 0"),
        (medium(1.0, 1.0, None), "between -1 and 1"),
        (medium(1.0, f32::NAN, None), "between -1 and 1"),
        (medium(1.0, 0.5, Some(Film { ior: 1.3, thickness: 100.0 })), "what has no surface has no film"),
        (Material::RoughDiffuse { albedo: Color::WHITE, roughness: 1.5 }, "a roughness must be 0 to 1"),
    ] {
        let (mut scene, entity) = check(expected, |scene| scene.spawn((BALL, material)).id());
        *scene.world_mut().get_mut::<Material>(entity).unwrap() = GRAY;
        let report = scene.flatten();
        assert_eq!((report.instances.added, report.invalid.len()), (1, 0), "mended: {report}");
    }
}

#[test]
fn lights_and_cameras_that_are_none_are_left_out() {
    let spot = |inner_angle, outer_angle| Light::Spot {
        intensity: Vec3::ONE,
        inner_angle,
        outer_angle,
        falloff: Falloff::None,
    };
    let sun = Light::Directional { irradiance: Vec3::ONE };
    check("finite and at least 0", |scene| scene.spawn(Light::Ambient { radiance: Vec3::NAN }).id());
    check("angles", |scene| scene.spawn(spot(0.5, 0.4)).id());
    check("a direction", |scene| scene.spawn((sun, scaled(1.0, 1.0, 0.0))).id());
    check("finite place", |scene| {
        scene.spawn((Light::Point { intensity: Vec3::ONE, falloff: Falloff::None }, scaled(f32::NAN, 1.0, 1.0))).id()
    });
    let camera = |vfov| Camera { projection: Projection::Perspective { vfov }, lens: None };
    check("angle of view", |scene| scene.spawn(camera(4.0)).id());
    check("flatten its view", |scene| scene.spawn((camera(1.0), scaled(1.0, 0.0, 1.0))).id());
    for (lens, expected) in [
        (Lens { aperture_radius: -1.0, focus_distance: 1.0, blades: 0 }, "radius of at least 0"),
        (Lens { aperture_radius: 1.0, focus_distance: 0.0, blades: 0 }, "focus distance above 0"),
        (Lens { aperture_radius: 1.0, focus_distance: 1.0, blades: 2 }, "3 blades or more"),
    ] {
        check(expected, |scene| scene.spawn(Camera { lens: Some(lens), ..camera(1.0) }).id());
    }
}

#[test]
fn references_to_nothing_are_named_and_tried_again() {
    let (mut scene, entity) = check("wears the shape", |scene| {
        let holder = scene.spawn(BALL).id();
        let wearer = scene.spawn((UsesShape(holder), GRAY)).id();
        assert_eq!(scene.flatten().invalid.len(), 0);
        scene.world_mut().entity_mut(holder).remove::<Shape>();
        wearer
    });
    let holder = scene.world().get::<UsesShape>(entity).unwrap().0;
    scene.world_mut().entity_mut(holder).insert(BALL);
    let report = scene.flatten();
    assert_eq!((report.instances.added, report.invalid.len()), (1, 0), "mended: {report}");

    check("wears the material", |scene| {
        let holder = scene.spawn(GRAY).id();
        let wearer = scene.spawn((BALL, UsesMaterial(holder))).id();
        scene.world_mut().despawn(holder);
        wearer
    });
}

/// The entity that was there first keeps its row.
#[test]
fn keys_are_unique() {
    let mut scene = Scene::new();
    let first = scene.spawn((BALL, GRAY, SceneKey(7))).id();
    let second = scene.spawn((BALL, GRAY, SceneKey(7))).id();
    for _ in 0..2 {
        let report = scene.flatten();
        assert!(!report.invalid.is_empty());
        for invalid in &report.invalid {
            assert_eq!(invalid.entity, second);
            assert_eq!(invalid.to_string(), format!("entity {second}: another entity has its scene key 7"));
        }
        assert_eq!(scene.buffers().instances.len(), 1);
        scene.buffers().validate().unwrap();
    }
    *scene.world_mut().get_mut::<SceneKey>(first).unwrap() = SceneKey(8);
    let report = scene.flatten();
    assert_eq!((report.invalid.len(), scene.buffers().instances.view().key), (0, &[7, 8][..]));
}

#[test]
fn keys_can_run_out() {
    let mut scene = Scene::new();
    scene.spawn((BALL, GRAY, SceneKey(u64::MAX - 1)));
    let late = scene.spawn((BALL, GRAY)).id();
    let report = scene.flatten();
    assert!(report.invalid.iter().all(|invalid| invalid.entity == late), "{report}");
    assert_eq!((report.invalid.is_empty(), scene.buffers().instances.len()), (false, 1));
}

#[test]
fn mixes_and_details_that_are_none_are_left_out() {
    let mix = |a: &Material, b: &Material, by| Material::Mix {
        a: Box::new(a.clone()),
        b: Box::new(b.clone()),
        by: Scalar::constant(by),
    };
    let glass = dielectric(1.5, 0.0, 0.0, None, false);
    let deep = (0..9).fold(GRAY, |inner, _| mix(&inner, &GRAY, 0.5));
    for (material, expected) in [
        (mix(&GRAY, &GRAY, 1.5), "a mix must be by 0 to 1"),
        (mix(&GRAY, &glass, 0.5), "what has no inside"),
        (mix(&GRAY, &Material::Lambert { albedo: Color::gray(-1.0) }, 0.5), "a color must be finite"),
        (deep, "at most 8 deep"),
    ] {
        let (mut scene, entity) = check(expected, |scene| scene.spawn((BALL, material)).id());
        *scene.world_mut().get_mut::<Material>(entity).unwrap() = mix(&mix(&GRAY, &GRAY, 0.0), &GRAY, 1.0);
        let report = scene.flatten();
        assert_eq!((report.instances.added, report.invalid.len()), (1, 0), "mended: {report}");
    }
    let veil = |factor| Opacity::Blend { alpha: Scalar::constant(factor) };
    let checker = |size| Texture::Checker { a: Vec3::ZERO, b: Vec3::ONE, size };
    for (detail, expected) in [
        (Detail { opacity: veil(f32::NAN), ..Detail::default() }, "an opacity must be finite"),
        (Detail { bump: Some(Scalar::constant(f32::INFINITY)), ..Detail::default() }, "a height"),
        (Detail { normal: Some(NormalMap { texture: checker(0.0), scale: 1.0 }), ..Detail::default() }, "a texture"),
        (
            Detail { normal: Some(NormalMap { texture: checker(1.0), scale: f32::NAN }), ..Detail::default() },
            "the scale",
        ),
    ] {
        let (mut scene, entity) = check(expected, |scene| scene.spawn((BALL, GRAY, detail)).id());
        *scene.world_mut().get_mut::<Detail>(entity).unwrap() = Detail { opacity: veil(0.5), ..Detail::default() };
        let report = scene.flatten();
        assert_eq!((report.instances.added, report.invalid.len()), (1, 0), "mended: {report}");
        scene.world_mut().entity_mut(entity).remove::<Detail>();
        scene.flatten();
        assert!(scene.buffers().materials.details.is_empty());
    }
}
