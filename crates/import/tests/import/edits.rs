//! Applying a scene to a world that holds an earlier state of it: the world comes out as a fresh one would, and change
//! detection sees what the author changed and nothing else.

use bevy_ecs::change_detection::DetectChanges;
use bevy_ecs::entity::Entity;
use bevy_ecs::hierarchy::ChildOf;
use bevy_ecs::name::Name;
use bevy_ecs::world::{EntityRef, World};
use brewster_import::{Importer, LoadOptions};
use brewster_random::Random;
use brewster_world::components::{
    Background, Camera, Light, Material, SceneKey, Settings, Shape, Transform, UsesMaterial, UsesShape,
};

/// Everything an importer writes, entities in the order of their keys and named by them.
fn described(world: &mut World) -> Vec<String> {
    fn key(world: &World, entity: Entity) -> u64 {
        world.get::<SceneKey>(entity).expect("every imported entity has a key").0
    }
    fn describe(world: &World, entity: EntityRef) -> String {
        format!(
            "{:?} {:?} in {:?} {:?} {:?} of {:?} {:?} of {:?} {:?} {:?}",
            entity.get::<SceneKey>(),
            entity.get::<Name>(),
            entity.get::<ChildOf>().map(|of| key(world, of.parent())),
            entity.get::<Transform>(),
            entity.get::<Shape>(),
            entity.get::<UsesShape>().map(|of| key(world, of.0)),
            entity.get::<Material>(),
            entity.get::<UsesMaterial>().map(|of| key(world, of.0)),
            entity.get::<Light>(),
            entity.get::<Camera>(),
        )
    }
    let mut query = world.query::<(Entity, &SceneKey)>();
    let mut rows: Vec<(u64, Entity)> = query.iter(world).map(|(entity, key)| (key.0, entity)).collect();
    rows.sort();
    let entities = rows.into_iter().map(|(_, entity)| describe(world, world.entity(entity)));
    let entities: Vec<String> = entities.collect();
    let resources = format!("{:?} {:?}", world.resource::<Settings>(), world.resource::<Background>());
    entities.into_iter().chain([resources]).collect()
}

fn apply(importer: &mut Importer, text: &str, world: &mut World) -> brewster_import::Applied {
    let loaded = importer.load_text("scene.ron".as_ref(), text).unwrap_or_else(|failure| panic!("{failure}"));
    loaded.scene.apply(world)
}

const SCENE: &str = r#"Scene(
    camera: Perspective(eye: (0, 1, 6)),
    background: 0.5,
    materials: { "red": Lambert(albedo: (0.6, 0.1, 0.1)), "gold": Metal(of: "Au") },
    shapes: { "bead": Sphere(radius: 0.05) },
    entities: [
        (shape: Plane(), material: "red"),
        (name: "ball", shape: Sphere(), material: "gold", at: (0, 1, 0)),
        (name: "table", at: (2, 0, 0), children: [
            (name: "cup", shape: Cylinder(radius: 0.1), material: "red"),
        ]),
        (name: "lamp", light: Point(intensity: 40), at: (0, 2, 0), parent: "table"),
        (name: "beads", shape: "bead", material: Metal(of: "Cu"), instances: Grid(count: (4, 1, 4))),
    ],
)"#;

/// What an edit turns into what, and how many entities it touches: spawned, changed, despawned.
const EDITS: &[(&str, &str, [usize; 3])] = &[
    ("", "", [0, 0, 0]),
    ("at: (0, 1, 0)", "at: (0, 2, 0)", [0, 1, 0]),
    ("intensity: 40", "intensity: 50", [0, 1, 0]),
    ("(0.6, 0.1, 0.1)", "(0.5, 0.1, 0.1)", [0, 1, 0]),
    ("radius: 0.05", "radius: 0.07", [0, 1, 0]),
    ("background: 0.5", "background: 0.6", [0, 0, 0]),
    ("material: Metal(of: \"Cu\")", "material: Metal(of: \"Ag\")", [0, 1, 0]),
    // Only the entity's own components and its child's place in the tree are touched.
    ("(name: \"table\", at: (2, 0, 0)", "(name: \"table\", at: (3, 0, 0)", [0, 1, 0]),
    (", parent: \"table\"", "", [0, 1, 0]),
    // Sixteen beads become twenty: none of the sixteen keeps its place in a centered grid.
    ("count: (4, 1, 4)", "count: (4, 1, 5)", [4, 16, 0]),
    ("count: (4, 1, 4)", "count: (2, 1, 4)", [0, 8, 8]),
    ("\"gold\": Metal(of: \"Au\")", "\"blue\": Lambert(), \"gold\": Metal(of: \"Au\")", [1, 0, 0]),
    // A named entity keeps its key where others come and go before it.
    ("        (name: \"ball\", shape: Sphere(), material: \"gold\", at: (0, 1, 0)),\n", "", [0, 0, 1]),
    ("        (name: \"ball\"", "        (name: \"new\", light: Ambient()),\n        (name: \"ball\"", [1, 0, 0]),
    ("shape: Sphere(), material: \"gold\"", "shape: \"bead\", material: \"gold\"", [0, 1, 0]),
    ("shape: Sphere(), material: \"gold\"", "light: Directional()", [0, 1, 0]),
    ("(name: \"cup\"", "(name: \"mug\"", [0, 1, 0]),
];

#[test]
fn an_edited_world_equals_a_fresh_one() {
    for (from, to, [spawned, changed, despawned]) in EDITS {
        let edited = if from.is_empty() { SCENE.to_string() } else { SCENE.replacen(from, to, 1) };
        let mut importer = Importer::new(LoadOptions::default());
        let mut world = World::new();
        apply(&mut importer, SCENE, &mut world);
        let applied = apply(&mut importer, &edited, &mut world);
        assert_eq!(
            [applied.spawned, applied.changed, applied.despawned],
            [*spawned, *changed, *despawned],
            "{from} → {to}"
        );

        let mut fresh = World::new();
        apply(&mut Importer::new(LoadOptions::default()), &edited, &mut fresh);
        assert_eq!(described(&mut world), described(&mut fresh), "{from} → {to}");

        apply(&mut importer, SCENE, &mut world);
        let mut original = World::new();
        apply(&mut Importer::new(LoadOptions::default()), SCENE, &mut original);
        assert_eq!(described(&mut world), described(&mut original), "{to} → {from}");
    }
}

/// A scene of a few entities out of many, in any order, with numbers out of a few.
fn random_scene(random: &mut Random) -> String {
    let mut entities = Vec::new();
    for name in ["a", "b", "c", "d", "e", "f"] {
        let number = random.below(4);
        let parent = ["a", "b", "c"][random.below(3)];
        let what = match random.below(9) {
            0 => continue,
            1 => format!("shape: Sphere(radius: {}), material: \"red\"", number + 1),
            2 => format!("shape: \"bead\", material: Lambert(albedo: 0.{number})"),
            3 => format!("shape: Plane(normal: (0, {}, 1)), material: \"blue\"", number),
            4 => format!("light: Point(intensity: {number}), shape: Plane(normal: (0, 0, 1)), material: \"red\""),
            5 => format!("instances: Grid(count: ({}, 1, 2)), shape: Box(), material: Lambert()", number + 1),
            6 => format!("children: [(light: Point(), at: (0, {number}, 0)), (shape: \"bead\", material: \"red\")]"),
            7 => "instances: [(at: (1, 0, 0)), ()], children: [(light: Ambient()), (children: [(light: Point())])]"
                .into(),
            _ => format!("at: (0, {number}, 0)"),
        };
        let parent = match name {
            "d" | "e" | "f" if entities.iter().any(|(other, _)| *other == parent) => format!(", parent: {parent:?}"),
            _ => String::new(),
        };
        let name_field = if random.below(4) == 0 && name > "c" { String::new() } else { format!("name: {name:?}, ") };
        entities.insert(random.below(entities.len() + 1), (name, format!("({name_field}{what}{parent})")));
    }
    let entities: Vec<String> = entities.into_iter().map(|(_, entity)| entity).collect();
    let cameras = ["", "camera: Perspective(),", "cameras: {\"a\": Perspective(), \"b\": Perspective(vfov: 30)},"];
    let lamp = ["", ", \"lamp\": Emissive()"][random.below(2)];
    let blue = random.below(3);
    let materials = format!("materials: {{\"red\": Lambert(), \"blue\": Metal(r0: 0.{blue}){lamp}}}");
    let shapes = format!("shapes: {{\"bead\": Sphere(radius: 0.{})}}", random.below(3) + 1);
    let (cameras, entities) = (cameras[random.below(3)], entities.join(", "));
    format!("Scene({cameras} background: 0.{}, {materials}, {shapes}, entities: [{entities}])", random.below(3))
}

#[test]
fn after_any_series_of_edits_the_world_equals_a_fresh_one() {
    let mut random = Random::new(7);
    for _ in 0..20 {
        let mut importer = Importer::new(LoadOptions::default());
        let mut world = World::new();
        for _ in 0..20 {
            let text = random_scene(&mut random);
            apply(&mut importer, &text, &mut world);
            let mut fresh = World::new();
            apply(&mut Importer::new(LoadOptions::default()), &text, &mut fresh);
            assert_eq!(described(&mut world), described(&mut fresh), "{text}");
            let again = apply(&mut importer, &text, &mut world);
            assert_eq!(again, Default::default(), "{text}");
        }
    }
}

#[test]
fn change_detection_sees_the_edit_alone() {
    let mut importer = Importer::new(LoadOptions::default());
    let mut world = World::new();
    apply(&mut importer, SCENE, &mut world);
    world.increment_change_tick();
    let before = world.change_tick();
    world.increment_change_tick();
    apply(&mut importer, &SCENE.replace("at: (0, 1, 0)", "at: (0, 2, 0)"), &mut world);
    let now = world.change_tick();
    let mut transforms = world.query::<(&Name, bevy_ecs::world::Ref<Transform>)>();
    let changed: Vec<String> = transforms
        .iter(&world)
        .filter(|(_, transform)| transform.last_changed().is_newer_than(before, now))
        .map(|(name, _)| name.to_string())
        .collect();
    assert_eq!(changed, ["ball"]);
    let mut others = world.query::<(bevy_ecs::world::Ref<SceneKey>, Option<bevy_ecs::world::Ref<Material>>)>();
    for (key, material) in others.iter(&world) {
        assert!(!key.last_changed().is_newer_than(before, now));
        assert!(!material.is_some_and(|material| material.last_changed().is_newer_than(before, now)));
    }
}

#[test]
fn what_was_not_imported_is_left_alone() {
    let mut importer = Importer::new(LoadOptions::default());
    let mut world = World::new();
    let own = world.spawn((SceneKey(7), Light::Ambient { radiance: glam::Vec3::ONE })).id();
    apply(&mut importer, SCENE, &mut world);
    apply(&mut importer, "Scene()", &mut world);
    assert!(world.get::<Light>(own).is_some());
    assert_eq!(world.query::<&SceneKey>().iter(&world).count(), 1);
}
