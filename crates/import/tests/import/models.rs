//! glTF files within scenes: the file or a part of it, with its materials or others, placed as entities; errors point to the scene.

use std::path::{Path, PathBuf};

use bevy_ecs::world::World;
use brewster_import::{Diagnostic, Failure, Importer, LoadOptions, Loaded, Severity};
use brewster_world::components::{Color, Light, Material, SceneKey, Shape, UsesMaterial};
use glam::{Affine3A, Vec3};

use super::loaded::place;

/// A scene that would stand beside the models.
fn scene() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/gltf/models/scene.ron")
}

fn load(entities: &str) -> Result<Loaded, Failure> {
    let text = format!("Scene(settings: (integrator: Path), background: 1, entities: [{entities}])");
    Importer::new(LoadOptions::default()).load_text(&scene(), &text)
}

fn loaded(entities: &str) -> World {
    let loaded = load(entities).unwrap_or_else(|failure| panic!("{entities}: {failure}"));
    let mut world = World::new();
    loaded.scene.apply(&mut world);
    world
}

/// The places and the base colors of all meshes, in the order of their keys.
fn meshes(world: &mut World) -> Vec<(Affine3A, Option<Vec3>)> {
    let mut query = world.query::<(bevy_ecs::entity::Entity, &Shape, &SceneKey, &UsesMaterial)>();
    let mut found: Vec<_> = query
        .iter(world)
        .filter(|row| matches!(row.1, Shape::Mesh(_)))
        .map(|(entity, _, key, of)| {
            let color = match world.get::<Material>(of.0) {
                Some(Material::Principled(principled)) => Some(principled.base_color.factor()),
                Some(Material::Lambert { albedo: Color::Constant(albedo) }) => Some(*albedo),
                _ => None,
            };
            (key.0, (place(world, entity), color))
        })
        .collect();
    found.sort_by_key(|row| row.0);
    found.into_iter().map(|row| row.1).collect()
}

const BOX: &str = "Gltf(file: \"Box/glTF-Binary/Box.glb\"";
const SUZANNES: &str = "Gltf(file: \"SuzanneNodeVisibility/SuzanneNodeVisibility.glb\"";

#[test]
fn a_file_stands_where_its_entity_does_and_wears_its_own_materials() {
    let found = meshes(&mut loaded(&format!("(shape: {BOX}), at: (1, 2, 3), scale: 2)")));
    let [(place, color)] = found[..] else { panic!("{} meshes", found.len()) };
    // The file turns Z up into Y up, and is red: 0.8, 0, 0.
    assert!(place.transform_point3(Vec3::ZERO).distance(Vec3::new(1.0, 2.0, 3.0)) < 1e-6, "{place}");
    assert!(place.transform_vector3(Vec3::Z).distance(Vec3::Y * 2.0) < 1e-6, "{place}");
    assert!(color.is_some_and(|color| color.distance(Vec3::new(0.8, 0.0, 0.0)) < 1e-6), "{color:?}");
}

#[test]
fn all_of_it_wears_one_material_or_some_wears_others() {
    let one = meshes(&mut loaded(&format!("(shape: {BOX}), material: Lambert(albedo: 0.25))")));
    assert_eq!(one[0].1, Some(Vec3::splat(0.25)));
    let by_name = format!("(shape: {BOX}, materials: {{\"Red\": Lambert(albedo: (0, 0.5, 0))}}))");
    assert_eq!(meshes(&mut loaded(&by_name))[0].1, Some(Vec3::new(0.0, 0.5, 0.0)));
}

#[test]
fn instances_share_what_is_in_the_file() {
    let mut world = loaded(&format!("(shape: {BOX}), instances: [(at: (0, 0, 0)), (at: (3, 0, 0))]), (shape: {BOX}))"));
    let mut query = world.query::<&Shape>();
    let shapes: Vec<_> =
        query.iter(&world).filter_map(|shape| if let Shape::Mesh(mesh) = shape { Some(mesh) } else { None }).collect();
    assert_eq!(shapes.len(), 3);
    assert!(shapes.iter().all(|mesh| std::sync::Arc::ptr_eq(mesh, shapes[0])));
    assert_eq!(world.query::<&Material>().iter(&world).count(), 1);
}

#[test]
fn a_part_stands_where_it_stands_in_the_file() {
    let names = "SuzanneAnimationPointer/SuzanneAnimationPointer.glb";
    let whole = meshes(&mut loaded(&format!("(shape: Gltf(file: {names:?}))")));
    let part = meshes(&mut loaded(&format!("(shape: Gltf(file: {names:?}, node: \"Suzanne2\"))")));
    assert_eq!(part.len(), 1);
    assert!(whole.contains(&part[0]), "{part:?} in {whole:?}");
    let lights = |entities: &str| {
        let mut world = loaded(entities);
        world.query::<&Light>().iter(&world).count()
    };
    assert!(lights(&format!("(shape: Gltf(file: {names:?}))")) > 0, "lights come with their file");
    assert_eq!(lights(&format!("(shape: Gltf(file: {names:?}, node: \"Suzanne2\"))")), 0);
}

#[test]
fn what_is_wrong_is_said_where_the_scene_says_it() {
    for (entities, place, message, help) in [
        ("(shape: Gltf(file: \"Fox/glTF-Binary/Fix.glb\"))", "Fix.glb\"", "there is no such file", Some("Fox.glb")),
        ("(shape: Gltf(file: \"../../../Cargo.toml\"))", "\"../", "is no glTF file", None),
        ("(shape: Gltf(file: \"../../../../../a.glb\"))", "\"../", "outside the folder", None),
        (
            "(shape: Gltf(file: \"Fox/glTF-Binary/Fox.glb\", node: \"fax\"))",
            "\"fax\"",
            "no node \"fax\"",
            Some("\"fox\""),
        ),
        (
            "(shape: Gltf(file: \"Box/glTF-Binary/Box.glb\", materials: {\"Rad\": Lambert()}))",
            "\"Rad\"",
            "no material \"Rad\"",
            Some("\"Red\""),
        ),
        (
            "(shape: Gltf(file: \"Box/glTF-Binary/Box.glb\", materials: {\"Red\": \"x\"}))",
            "\"x\"",
            "no material \"x\"",
            None,
        ),
        (
            "(shape: Gltf(file: \"Fox/glTF-Binary/Fox.glb\", animation: \"Swim\", time: 1))",
            "",
            "no animation \"Swim\"",
            None,
        ),
    ] {
        let failure = load(entities).expect_err(entities);
        let is_error = |said: &&Diagnostic| said.severity == Severity::Error;
        let said = failure.diagnostics.iter().find(is_error).expect("an error");
        assert!(said.message.contains(message), "{entities}: {failure}");
        assert!(help.is_none_or(|help| said.help.as_ref().is_some_and(|said| said.contains(help))), "{failure}");
        let text = &said.excerpt.text;
        assert!(place.is_empty() || text.contains(place), "{entities}: {failure}");
        assert!(!place.is_empty() || failure.to_string().contains("scene.ron:1:"), "{failure}");
    }
    let text = format!("Scene(entities: [(shape: {BOX}))])");
    let failure = Importer::default().load_text(&scene(), &text).expect_err("the lectures have no such material");
    assert!(failure.to_string().contains("principled"), "{failure}");
    let text = format!("Scene(entities: [(shape: {SUZANNES}), material: Lambert())])");
    Importer::default().load_text(&scene(), &text).expect("what it wears can be rendered");
    let text = format!("Scene(shapes: {{\"a\": {BOX})}}, entities: [])");
    let failure = Importer::default().load_text(&scene(), &text).expect_err("it is no shape");
    assert!(failure.to_string().contains("it stands in an entity"), "{failure}");
}

/// What is edited in the scene leaves the meshes of the file where they are in memory.
#[test]
fn an_edit_of_the_scene_does_not_read_the_file_again() {
    let mut importer = Importer::default();
    let mut world = World::new();
    let mut place = |at: &str| {
        let text = format!("Scene(settings: (integrator: Path), background: 1, entities: [(shape: {BOX}), at: {at})])");
        importer.load_text(&scene(), &text).expect("it is right").scene.apply(&mut world).changed
    };
    place("(0, 0, 0)");
    assert_eq!(place("(0, 1, 0)"), 1);
}
