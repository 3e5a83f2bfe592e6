//! glTF files become the entities that the specification says; broken ones are refused with the place in their JSON.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use bevy_ecs::entity::Entity;
use bevy_ecs::hierarchy::{ChildOf, Children};
use bevy_ecs::name::Name;
use bevy_ecs::query::{With, Without};
use bevy_ecs::world::World;
use brewster_import::{Code, Diagnostic, GltfChoices, Importer, Limits, LoadOptions, Loaded, Severity, load_scene};
use brewster_world::components::parts::TriangleMesh;
use brewster_world::components::{Camera, Motion, Projection, SceneKey, Shape, Transform};
use glam::{Affine3A, Vec3};

use super::loaded::place;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/gltf")
}

fn model(name: &str) -> PathBuf {
    folder().join("models").join(name)
}

fn load(name: &str, gltf: GltfChoices) -> Loaded {
    load_scene(&model(name), &LoadOptions { gltf, ..LoadOptions::default() })
        .unwrap_or_else(|failure| panic!("{name}: {failure}"))
}

/// The meshes of a file with their places in the world, in the order of their keys.
fn meshes(loaded: &Loaded) -> Vec<(Affine3A, Arc<TriangleMesh>)> {
    let mut world = World::new();
    loaded.scene.apply(&mut world);
    let mut found = Vec::new();
    let mut query = world.query::<(Entity, &Shape, &SceneKey)>();
    for (entity, shape, key) in query.iter(&world) {
        let Shape::Mesh(mesh) = shape else { continue };
        found.push((key.0, place(&world, entity), Arc::clone(mesh)));
    }
    found.sort_by_key(|row| row.0);
    found.into_iter().map(|(_, place, mesh)| (place, mesh)).collect()
}

fn close(found: &[Vec3], expected: &[Vec3]) -> bool {
    found.len() == expected.len() && found.iter().zip(expected).all(|(a, b)| a.distance(*b) < 1e-4)
}

/// The corners of all triangles, in their order.
fn corners(mesh: &TriangleMesh) -> Vec<Vec3> {
    mesh.triangles.as_flattened().iter().map(|&corner| mesh.positions[corner as usize]).collect()
}

#[test]
fn a_box_is_a_box_however_it_is_stored() {
    // The file's node turns what is modeled with Z up: 12 triangles, 24 vertices of a cube of side 1.
    for name in ["Box/glTF-Binary/Box.glb", "BoxInterleaved/glTF-Binary/BoxInterleaved.glb", "Box/glTF-Draco/Box.gltf"]
    {
        let found = meshes(&load(name, GltfChoices::default()));
        let [(_, mesh)] = &found[..] else { panic!("{name}: {} meshes", found.len()) };
        assert_eq!((mesh.triangles.len(), mesh.positions.len(), mesh.normals.len()), (12, 24, 24), "{name}");
        assert!(mesh.positions.iter().all(|p| p.abs().distance(Vec3::splat(0.5)) < 1e-3), "{name}");
        for (triangle, corners) in mesh.triangles.iter().enumerate() {
            let [a, b, c] = mesh.corners(triangle);
            let facing = (b - a).cross(c - a).dot(mesh.normals[corners[0] as usize]);
            assert!(facing > 0.0, "{name}: triangle {triangle} faces in");
        }
    }
    let spaced = load("Box With Spaces/glTF/Box With Spaces.gltf", GltfChoices::default());
    assert_eq!(meshes(&spaced)[0].1.triangles.len(), 12);
    assert!(spaced.dependencies.iter().any(|path| path.ends_with("Normal Map.png")), "{:?}", spaced.dependencies);
}

#[test]
fn every_mode_with_area_gives_the_same_square() {
    let loaded = load("MeshPrimitiveModes/glTF/MeshPrimitiveModes.gltf", GltfChoices::default());
    let found = meshes(&loaded);
    let warned: Vec<_> = loaded.diagnostics.iter().filter(|found| found.severity == Severity::Warning).collect();
    assert_eq!(warned.len(), 2, "points and lines: {warned:?}");
    assert!(!found.is_empty());
    for (_, mesh) in found {
        // A square, seen from +Z.
        let area = (0..mesh.triangles.len()).map(|triangle| {
            let [a, b, c] = mesh.corners(triangle);
            0.5 * (b - a).cross(c - a).z
        });
        let areas: Vec<f32> = area.collect();
        assert!(areas.iter().all(|&area| area > 0.0), "all face one way: {areas:?}");
    }
}

#[test]
fn shared_meshes_and_instances_are_one_in_memory() {
    let found = meshes(&load("SimpleInstancing/glTF-Binary/SimpleInstancing.glb", GltfChoices::default()));
    assert_eq!(found.len(), 125, "five times five times five");
    assert!(found.iter().all(|(_, mesh)| Arc::ptr_eq(mesh, &found[0].1)));
}

#[test]
fn scenes_are_chosen_by_number_and_the_default_is_the_files() {
    let of = |scene: Option<&str>| {
        let choices = GltfChoices { scene: scene.map(str::to_owned), ..GltfChoices::default() };
        meshes(&load("MultipleScenes/glTF/MultipleScenes.gltf", choices))[0].1.triangles.len()
    };
    assert_eq!((of(Some("0")), of(Some("1")), of(None)), (1, 2, 2));
    let options =
        LoadOptions { gltf: GltfChoices { scene: Some("7".into()), ..Default::default() }, ..Default::default() };
    let failure = load_scene(&model("MultipleScenes/glTF/MultipleScenes.gltf"), &options).expect_err("there are two");
    assert!(failure.to_string().contains("a name, or a number from 0 to 1"), "{failure}");
}

#[test]
fn cameras_have_their_lenses_and_show_their_frames_whole() {
    let loaded = load("Cameras/glTF/Cameras.gltf", GltfChoices::default());
    let mut world = World::new();
    loaded.scene.apply(&mut world);
    let cameras: Vec<Projection> = world.query::<&Camera>().iter(&world).map(|camera| camera.projection).collect();
    // The file: yfov 0.7, aspect 1; xmag = ymag = 1.
    assert!(cameras.contains(&Projection::Perspective { vfov: 0.7 }), "{cameras:?}");
    assert!(cameras.contains(&Projection::Orthographic { height: 2.0 }), "{cameras:?}");
}

#[test]
fn sparse_accessors_move_their_vertices() {
    let found = meshes(&load("SimpleSparseAccessor/glTF/SimpleSparseAccessor.gltf", GltfChoices::default()));
    // The file's base is two rows of seven points; 8, 10 and 12 are lifted to y = 2, 3 and 4.
    let raised: Vec<f32> = [8, 10, 12].map(|vertex| found[0].1.positions[vertex].y).to_vec();
    assert_eq!(raised, [2.0, 3.0, 4.0]);
}

#[test]
fn morph_targets_and_skins_follow_the_animation() {
    let at = |name: &str, time| load(name, GltfChoices { time, ..GltfChoices::default() });
    // SimpleMorph: a triangle; targets lift its top by (-1, 1, 0) and (1, 1, 0). At one second the weights are (0, 1)
    // in a linear animation over (0,0), (0,1), (1,1), (1,0), (0,0), one key a second.
    let triangle = |time| meshes(&at("SimpleMorph/glTF/SimpleMorph.gltf", time))[0].1.positions.clone();
    let base = [Vec3::ZERO, Vec3::X, Vec3::new(0.5, 0.5, 0.0)];
    let rest = triangle(Some(0.0));
    assert!(close(&rest, &base), "{rest:?}");
    let (first, second) = (triangle(Some(1.0)), triangle(Some(3.0)));
    assert!(first[2].distance(base[2] + Vec3::new(1.0, 1.0, 0.0)) < 1e-4, "{first:?}");
    assert!(second[2].distance(base[2] + Vec3::new(-1.0, 1.0, 0.0)) < 1e-4, "{second:?}");
    // SimpleSkin: a strip of width 1 from y = 0 to 2, bent at y = 1 by 90 degrees at its first second... and straight at rest.
    let strip = |time| meshes(&at("SimpleSkin/glTF/SimpleSkin.gltf", time))[0].1.positions.clone();
    let straight = strip(None);
    let bent = strip(Some(1.0));
    assert!(close(&bent[..2], &straight[..2]), "the foot stands");
    assert!(bent[9].distance(straight[9]) > 0.5, "the end moves: {} to {}", straight[9], bent[9]);
    assert!((bent[9].distance(bent[8]) - straight[9].distance(straight[8])).abs() < 1e-4, "turns keep lengths");
}

/// While the shutter is open nodes go through the places that they have when the file is read at later moments.
#[test]
fn nodes_move_through_their_places_at_later_moments() {
    let read = |time, shutter| {
        let choices =
            GltfChoices { time: Some(time), shutter, animation: Some("all".into()), ..GltfChoices::default() };
        let loaded = load("SuzanneAnimationPointer/SuzanneAnimationPointer.glb", choices);
        let mut world = World::new();
        loaded.scene.apply(&mut world);
        // But for the camera that frames what there is to see.
        type Nodes<'a> = (&'a SceneKey, &'a Transform, Option<&'a Motion>);
        let mut query = world.query_filtered::<Nodes<'_>, Without<Camera>>();
        let rows = query.iter(&world).map(|(key, place, motion)| (key.0, (place.0, motion.cloned())));
        rows.collect::<std::collections::BTreeMap<_, _>>()
    };
    let open = read(0.2, Some(0.4));
    let mut moving = 0;
    for (step, time) in [(8, 0.4), (16, 0.6)] {
        for (key, (expected, motion)) in read(time, None) {
            assert_eq!(motion, None);
            let (place, motion) = &open[&key];
            moving += usize::from(motion.is_some());
            let found = motion.as_ref().map_or(*place, |motion| *place * motion.steps()[step - 1]);
            assert!(found.abs_diff_eq(expected, 1e-4), "entity {key} at {time}: {found} instead of {expected}");
        }
    }
    assert!(moving > 0, "nothing moves");
}

/// A corner of a triangle in the world: its place, and its normal, tangent and texture coordinates where it has them.
type Corner = (Vec3, [Option<Vec3>; 3]);

fn world_corners(name: &str, gltf: GltfChoices) -> Vec<Corner> {
    let found = meshes(&load(name, gltf));
    let [(place, mesh)] = &found[..] else { panic!("{name}: {} meshes", found.len()) };
    let corner = |&corner: &u32| {
        let row = corner as usize;
        let direction = |along: Vec3| place.transform_vector3(along).normalize();
        let normal = mesh.normals.get(row).map(|&normal| direction(normal));
        let tangent = mesh.tangents.get(row).map(|tangent| direction(tangent.truncate()));
        let uv = mesh.uvs.get(row).map(|uv| uv.extend(0.0));
        (place.transform_point3(mesh.positions[row]), [normal, tangent, uv])
    };
    mesh.triangles.as_flattened().iter().map(corner).collect()
}

/// Every corner of either has one of the other's as near as the encoder's steps are, whose bits stand at the right: those of
/// places over the model's extent, normals and tangents from -1 to 1, coordinates from 0 to 1. Half a step of both coordinates on
/// an octahedron turns a normal by up to √3 √6 halves, and a decoder that rounds its components by √3 more.
#[test]
fn a_model_that_is_stored_in_another_way_is_the_same_model() {
    let walk = GltfChoices { time: Some(0.5), animation: Some("Walk".into()), ..GltfChoices::default() };
    let still = GltfChoices::default();
    let (fox, avocado) = ("Fox/glTF-Binary/Fox.glb", "AvocadoSmall/Avocado.glb");
    for (plain, twin, (extent, bits), directions, uvs) in [
        (avocado, "AvocadoSmall/Avocado-draco.glb", (0.063, 14), 10, Some(12)),
        (avocado, "AvocadoSmall/Avocado-meshopt.glb", (0.063, 14), 8, Some(12)),
        (avocado, "AvocadoSmall/Avocado-quantized.glb", (0.063, 14), 10, Some(12)),
        (fox, "FoxDraco/Fox-draco.glb", (155.0, 14), 0, Some(12)),
        // A step of its weights, of 8 bits, moves a vertex by less than an eighth of the fox. Its coordinates go through its
        // material's transform.
        (fox, "FoxMeshopt/Fox-meshopt-cc.glb", (155.0, 11), 0, None),
    ] {
        let choices = if plain == fox { &walk } else { &still };
        let (plain, twin_corners) = (world_corners(plain, choices.clone()), world_corners(twin, choices.clone()));
        assert_eq!(plain.len(), twin_corners.len(), "{twin}");
        let step = |bits: i32| 2.0_f32.powi(-bits);
        let (position, direction) = (extent * step(bits), 6.0 * step(directions));
        let far = |a: Option<Vec3>, b: Option<Vec3>| match (a, b) {
            (Some(a), Some(b)) => a.distance(b),
            (None, None) => 0.0,
            _ => f32::INFINITY,
        };
        let mut worst = [0.0_f32; 3];
        for (from, to) in [(&plain, &twin_corners), (&twin_corners, &plain)] {
            for (place, [normal, tangent, uv]) in from {
                let apart = to.iter().map(|(other, [other_normal, other_tangent, other_uv])| {
                    let apart = [
                        place.distance(*other) / position,
                        far(*normal, *other_normal).max(far(*tangent, *other_tangent)) / direction,
                        uvs.map_or(0.0, |bits| far(*uv, *other_uv) / step(bits)),
                    ];
                    (apart.into_iter().fold(0.0, f32::max), apart)
                });
                let nearest = apart.min_by(|a, b| a.0.total_cmp(&b.0)).expect("a corner").1;
                worst = std::array::from_fn(|i| worst[i].max(nearest[i]));
            }
        }
        assert!(worst.iter().all(|&steps| steps <= 1.0), "{twin}: {worst:?} steps");
    }
}

/// The two extensions of that name have the same streams: the name of one is put in the place of the other's.
#[test]
fn both_names_of_meshopt_are_read() {
    let path = model("FoxMeshopt/Fox-meshopt-cc.glb");
    let bytes = std::fs::read(&path).expect("the model");
    let (old, new) = (b"EXT_meshopt_compression", b"KHR_meshopt_compression");
    let mut renamed = bytes.clone();
    let places: Vec<usize> = (0..bytes.len() - old.len()).filter(|&at| bytes[at..].starts_with(old)).collect();
    assert!(places.len() > 2, "in the lists of extensions and in views");
    for at in places {
        renamed[at..at + new.len()].copy_from_slice(new);
    }
    let read = |bytes: &[u8]| {
        let loaded = Importer::default().load_gltf(&path, bytes).unwrap_or_else(|failure| panic!("{failure}"));
        meshes(&loaded).iter().map(|(_, mesh)| corners(mesh)).collect::<Vec<_>>()
    };
    assert_eq!(read(&renamed), read(&bytes));
}

#[test]
fn hidden_nodes_hide_what_is_below_them() {
    let loaded = load("SuzanneNodeVisibility/SuzanneNodeVisibility.glb", GltfChoices::default());
    assert_eq!(meshes(&loaded).len(), 1, "only the middle head");
}

#[test]
fn names_of_nodes_are_names_of_entities() {
    let loaded = load("Fox/glTF-Binary/Fox.glb", GltfChoices::default());
    let mut world = World::new();
    loaded.scene.apply(&mut world);
    assert!(world.query::<&Name>().iter(&world).any(|name| name.as_str() == "fox"));
}

/// What the manifest expects of every broken file; and under every value no panic, no hang.
#[test]
fn broken_files_are_refused_with_their_place_or_load_with_a_warning() {
    let root = folder().join("broken");
    let manifest = std::fs::read_to_string(root.join("manifest.json")).expect("the manifest");
    let manifest: serde_json::Value = serde_json::from_str(&manifest).expect("it is JSON");
    let files = manifest.as_object().expect("an object");
    assert_eq!(files.len(), 16);
    for (name, about) in files {
        let begin = Instant::now();
        let result = load_scene(&root.join(name), &LoadOptions::default());
        assert!(begin.elapsed() < Duration::from_secs(10), "{name} hangs");
        match result {
            Ok(loaded) => {
                let warned = loaded.diagnostics.iter().any(|found| found.severity == Severity::Warning);
                assert!(about["expect"] != "error" || warned, "{name} is taken for whole");
            }
            Err(failure) => {
                assert_ne!(about["expect"], "load", "{name}: {failure}");
                let said = failure.diagnostics.iter().find(|found| found.severity == Severity::Error);
                assert!(said.is_some_and(|said| !said.message.is_empty()), "{name} says nothing");
            }
        }
    }
}

#[test]
fn errors_name_the_place_in_the_json() {
    let broken = |name: &str| load_scene(&folder().join("broken").join(name), &LoadOptions::default()).expect_err(name);
    for (name, path, part) in [
        ("handmade/node_self_child.gltf", Some("nodes[0].children[0]"), "above itself"),
        ("handmade/unknown_required_ext.gltf", Some("extensionsRequired[0]"), "is not known"),
        ("handmade/cut_in_json.glb", None, "bytes"),
    ] {
        let failure = broken(name);
        let said = &failure.diagnostics.iter().find(|said| said.severity == Severity::Error).expect("an error");
        assert_eq!(said.path.as_deref(), path, "{name}: {failure}");
        assert!(said.message.contains(part), "{name}: {failure}");
    }
}

/// A folder's only other file is no buffer; an empty scene shows nothing; the default material stands nowhere in its file.
#[test]
fn what_is_told_helps() {
    let load = |name: &str| load_scene(&folder().join("broken").join(name), &LoadOptions::default());
    let failure = load("assimp/test/models/glTF2/MissingBin/BoxTextured.gltf").expect_err("it has no buffer");
    assert!(failure.diagnostics.iter().all(|said| said.help.is_none()), "{failure}");
    let empty = load("sharpgltf/tests/Assets/SpecialCases/Invalid_EmptyArray.gltf").expect("it can be used");
    let told = |said: &Diagnostic| said.severity == Severity::Warning && said.message.contains("nothing to see");
    assert!(empty.diagnostics.iter().any(told), "{:?}", empty.diagnostics);
    let plain = load("gltf-rs/gltf-json/tests/minimal_accessor_invalid.gltf").expect("it can be used");
    assert!(plain.diagnostics.iter().all(|said| said.path.is_none()), "{:?}", plain.diagnostics);
}

#[test]
fn a_file_reads_nothing_outside_its_folder() {
    let guard = tempfile::tempdir().expect("a folder");
    let inner = guard.path().join("inner");
    std::fs::create_dir(&inner).expect("a folder");
    std::fs::write(guard.path().join("secret.bin"), [0; 64]).expect("a file");
    for uri in ["../secret.bin", "%2e%2e/secret.bin", "/etc/passwd", "http://localhost/a.bin", "file:///etc/passwd"] {
        let text = format!(r#"{{"asset":{{"version":"2.0"}},"buffers":[{{"byteLength":4,"uri":"{uri}"}}]}}"#);
        let path = inner.join("a.gltf");
        std::fs::write(&path, text).expect("a file");
        let failure = load_scene(&path, &LoadOptions::default()).expect_err(uri);
        assert_eq!(failure.diagnostics[0].path.as_deref(), Some("buffers[0].uri"), "{failure}");
    }
}

/// A file with a triangle at the end of a chain of nodes. The first turns +X to -Z, every other is a meter along its parent's x.
fn chain(nodes: usize) -> String {
    let node = |index: usize| {
        let place = match index {
            0 => r#""matrix":[0,0,-1,0, 0,1,0,0, 1,0,0,0, 0,0,0,1]"#,
            _ => r#""translation":[1,0,0]"#,
        };
        match index + 1 {
            next if next < nodes => format!(r#"{{{place},"children":[{next}]}}"#),
            _ => format!(r#"{{{place},"mesh":0}}"#),
        }
    };
    format!(
        r#"{{"asset":{{"version":"2.0"}},"accessors":[{{"componentType":5126,"count":3,"type":"VEC3"}}],
            "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],"nodes":[{}]}}"#,
        (0..nodes).map(node).collect::<Vec<_>>().join(",")
    )
}

/// Threads have 2 MiB of stack where nobody asks for more.
#[test]
fn nodes_stand_below_each_other_as_deep_as_the_limit_says() {
    const DEEPEST: usize = Limits::DEFAULT.hierarchy as usize;
    let check = || {
        let load = |nodes| Importer::default().load_gltf("a.gltf".as_ref(), chain(nodes).as_bytes());
        let place = |scene: &mut brewster_world::Scene| {
            scene.flatten();
            scene.buffers().instances.get(0).object_to_world.point(Vec3::ZERO)
        };
        let deep = load(DEEPEST).unwrap_or_else(|failure| panic!("{failure}")).scene;
        let mut scene = brewster_world::Scene::new();
        deep.apply(scene.world_mut());
        assert_eq!(place(&mut scene), Vec3::NEG_Z * (DEEPEST - 1) as f32);
        let applied = load(1).expect("it is whole").scene.apply(scene.world_mut());
        assert_eq!((applied.despawned, place(&mut scene)), (DEEPEST - 1, Vec3::ZERO));
        deep.apply(scene.world_mut());
        let mut roots = scene.world_mut().query_filtered::<(Entity, &SceneKey), (With<Children>, Without<ChildOf>)>();
        let root = roots.iter(scene.world()).next().expect("the first node").0;
        scene.world_mut().despawn(root);
        assert_eq!(scene.world_mut().query::<&ChildOf>().iter(scene.world()).count(), 0);
        assert!(deep.export("a").text.contains("(-1.0, 0.0, 0.0, -4095.0)"), "the place of the last one in the world");

        let failure = load(DEEPEST + 1).expect_err("it is too deep");
        let said = &failure.diagnostics[0];
        assert_eq!((said.path.as_deref(), said.code), (Some("nodes[4096]"), Code::Limit));
        assert_eq!(said.message, "too many parents of parents: limit `hierarchy` is 4096");

        // In another scene an entity stands above it.
        let folder = tempfile::tempdir().expect("a folder");
        let placed = |nodes| {
            std::fs::write(folder.path().join("a.gltf"), chain(nodes)).expect("a file");
            let text = "Scene(settings: (integrator: Path), background: 1, entities: [(shape: Gltf(file: \"a.gltf\"), at: (0, 1, 0))])";
            Importer::default().load_text(&folder.path().join("a.ron"), text)
        };
        let mut scene = brewster_world::Scene::new();
        placed(DEEPEST - 1).unwrap_or_else(|failure| panic!("{failure}")).scene.apply(scene.world_mut());
        assert_eq!(place(&mut scene), Vec3::new(0.0, 1.0, -((DEEPEST - 2) as f32)));
        let failure = placed(DEEPEST).expect_err("it is too deep").to_string();
        assert!(failure.contains("limit `hierarchy` is 4096") && failure.contains("a.ron:1:"), "{failure}");
    };
    let thread = std::thread::Builder::new().stack_size(2 << 20).spawn(check);
    thread.expect("a thread").join().expect("all of it holds");
}

/// 1e30 times 1e30 is beyond the largest number, 3.4e38.
#[test]
fn too_strong_an_emission_is_told_where_it_stands() {
    let json = r#"{"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
        "accessors": [{"componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [0, 0, 0]}],
        "extensionsUsed": ["KHR_materials_emissive_strength"], "materials": [{"emissiveFactor": [1, 0, 1e30],
            "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": STRENGTH}}}]}"#;
    let load =
        |strength| Importer::default().load_gltf("a.gltf".as_ref(), json.replace("STRENGTH", strength).as_bytes());
    assert!(load("1e8").is_ok());
    let failure = load("1e30").expect_err("the emission is infinite").to_string();
    assert!(
        failure.contains("a.gltf: materials[0].extensions.KHR_materials_emissive_strength.emissiveStrength"),
        "{failure}"
    );
}
