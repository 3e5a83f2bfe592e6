//! The report says what an edit cost: rows written in each table, trees built and refitted. Expected numbers are counted by hand.

use std::sync::Arc;

use bevy_ecs::entity::Entity;
use bevy_ecs::hierarchy::ChildOf;
use brewster_buffers::{MaterialKind, Texture};
use brewster_geometry::TriangleMesh;
use brewster_world::components::*;
use brewster_world::{EmittersEdit, FlattenReport, RowEdits, Scene, TopTreeEdit};
use glam::{Affine3A, Vec3};

const GRAY: Material = Material::Lambert { albedo: Color::gray(0.5) };

fn at(x: f32) -> Transform {
    Transform(Affine3A::from_translation(Vec3::X * x))
}

fn ball(radius: f32) -> Shape {
    Shape::Sphere { radius }
}

fn tetrahedron() -> Arc<TriangleMesh> {
    let positions = vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
    let triangles = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
    Arc::new(TriangleMesh { positions, triangles, ..Default::default() })
}

fn rewritten(rows: usize) -> RowEdits {
    RowEdits { rewritten: rows, ..RowEdits::default() }
}

fn added(rows: usize) -> RowEdits {
    RowEdits { added: rows, ..RowEdits::default() }
}

fn removed(rows: usize) -> RowEdits {
    RowEdits { removed: rows, ..RowEdits::default() }
}

/// Applies an edit and flattens; the columns stay sound.
fn after(scene: &mut Scene, edit: impl FnOnce(&mut Scene)) -> FlattenReport {
    edit(scene);
    let report = scene.flatten();
    scene.buffers().validate().unwrap();
    report
}

#[test]
fn one_of_a_hundred_thousand_costs_one_row() {
    const COUNT: usize = 100_000;
    let mut scene = Scene::new();
    let gray = scene.spawn(GRAY).id();
    let balls: Vec<Entity> =
        (0..COUNT).map(|i| scene.spawn((ball(0.3), at(i as f32), UsesMaterial(gray))).id()).collect();
    let report = scene.flatten();
    assert_eq!((report.instances, report.shapes, report.materials), (added(COUNT), added(COUNT), added(1)));
    assert_eq!(report.top_tree, TopTreeEdit::Rebuilt(COUNT));

    *scene.world_mut().get_mut::<Transform>(balls[777]).unwrap() = at(0.25);
    let report = scene.flatten();
    assert_eq!((report.instances, report.rows_written()), (rewritten(1), 1));
    assert_eq!(report.top_tree, TopTreeEdit::Refitted(1));
    assert_eq!(scene.buffers().instances.get(777).object_to_world.point(Vec3::ZERO), Vec3::X * 0.25);

    *scene.world_mut().get_mut::<Material>(gray).unwrap() = Material::Lambert { albedo: Color::WHITE };
    let report = scene.flatten();
    assert_eq!((report.materials, report.rows_written()), (rewritten(1), 1));
    assert_eq!(report.top_tree, TopTreeEdit::Kept);

    *scene.world_mut().get_mut::<Shape>(balls[9]).unwrap() = ball(0.4);
    let report = scene.flatten();
    assert_eq!((report.shapes, report.rows_written()), (rewritten(1), 1));
    assert_eq!(report.top_tree, TopTreeEdit::Refitted(1));

    let report = scene.flatten();
    assert_eq!((report.rows_written(), report.top_tree), (0, TopTreeEdit::Kept));
    scene.buffers().validate().unwrap();
}

#[test]
fn instances_are_inserted_and_removed_where_they_belong() {
    let mut scene = Scene::new();
    let gray = scene.spawn((SceneKey(0), GRAY)).id();
    let shape = scene.spawn((SceneKey(1), ball(1.0))).id();
    let bead = |key: u64| (SceneKey(key), UsesShape(shape), UsesMaterial(gray), at(key as f32));
    let beads: Vec<Entity> = (0..5).map(|i| scene.spawn(bead(10 + 10 * i)).id()).collect();
    scene.flatten();
    let keys = |scene: &Scene| scene.buffers().instances.view().key.to_vec();
    assert_eq!(keys(&scene), [10, 20, 30, 40, 50]);

    let report = after(&mut scene, |scene| {
        scene.world_mut().despawn(beads[1]);
        scene.world_mut().despawn(beads[4]);
        scene.spawn(bead(5));
        scene.spawn(bead(35));
        scene.spawn(bead(99));
    });
    assert_eq!(keys(&scene), [5, 10, 30, 35, 40, 99]);
    assert_eq!(report.instances, RowEdits { added: 3, removed: 2, rewritten: 0 });
    assert_eq!(report.rows_written(), 3);
    assert_eq!(report.top_tree, TopTreeEdit::Rebuilt(6));

    // Another key is another place: out and in.
    let report = after(&mut scene, |scene| *scene.world_mut().get_mut::<SceneKey>(beads[0]).unwrap() = SceneKey(60));
    assert_eq!(keys(&scene), [5, 30, 35, 40, 60, 99]);
    assert_eq!(report.instances, RowEdits { added: 1, removed: 1, rewritten: 0 });

    // Without a material the holder of a shape is no instance, and with one it is.
    let report = after(&mut scene, |scene| {
        scene.world_mut().entity_mut(shape).insert(UsesMaterial(gray));
    });
    assert_eq!((keys(&scene)[0], report.instances), (1, added(1)));
    let report = after(&mut scene, |scene| {
        scene.world_mut().entity_mut(shape).remove::<UsesMaterial>();
    });
    assert_eq!((keys(&scene)[0], report.instances), (5, removed(1)));
}

#[test]
fn a_parent_takes_what_is_below_it_along_and_nothing_else() {
    let mut scene = Scene::new();
    let gray = scene.spawn(GRAY).id();
    let group = scene.spawn(at(1.0)).id();
    let arm = scene.spawn((at(10.0), ChildOf(group))).id();
    let hands: Vec<Entity> =
        (0..7).map(|i| scene.spawn((ball(0.1), at(100.0 * i as f32), UsesMaterial(gray), ChildOf(arm))).id()).collect();
    scene.spawn((ball(0.1), at(5.0), UsesMaterial(gray)));
    scene.flatten();
    let report = after(&mut scene, |scene| *scene.world_mut().get_mut::<Transform>(group).unwrap() = at(2.0));
    assert_eq!((report.instances, report.rows_written()), (rewritten(7), 7));
    let place = |scene: &Scene, row: usize| scene.buffers().instances.get(row).object_to_world.point(Vec3::ZERO).x;
    assert_eq!(place(&scene, 3), 312.0);

    // Moved and moved back: nothing is written.
    let report = after(&mut scene, |scene| {
        scene.world_mut().get_mut::<Transform>(group).unwrap().0.translation.x += 1.0;
        scene.world_mut().get_mut::<Transform>(group).unwrap().0.translation.x -= 1.0;
    });
    assert_eq!(report.rows_written(), 0);

    let report = after(&mut scene, |scene| {
        scene.world_mut().entity_mut(hands[3]).remove::<ChildOf>();
    });
    assert_eq!((report.rows_written(), place(&scene, 3)), (1, 300.0));
    let report = after(&mut scene, |scene| {
        scene.world_mut().entity_mut(hands[3]).insert(ChildOf(group));
    });
    assert_eq!((report.rows_written(), place(&scene, 3)), (1, 302.0));

    // The children go with their parent.
    let report = after(&mut scene, |scene| {
        scene.world_mut().despawn(arm);
    });
    assert_eq!((report.instances.removed, scene.buffers().instances.len()), (6, 2));
}

#[test]
fn a_tree_is_built_once_for_each_mesh_and_dropped_with_it() {
    let mut scene = Scene::new();
    let (first, second) = (tetrahedron(), tetrahedron());
    let gray = scene.spawn(GRAY).id();
    let a = scene.spawn((Shape::Mesh(first.clone()), UsesMaterial(gray))).id();
    let b = scene.spawn((Shape::Mesh(first.clone()), UsesMaterial(gray), at(2.0))).id();
    let c = scene.spawn((Shape::Mesh(second.clone()), UsesMaterial(gray), at(4.0))).id();
    let report = scene.flatten();
    assert_eq!((report.mesh_trees.built, report.mesh_trees.triangles), (2, 8));
    assert_eq!(report.shapes, added(2));
    assert_eq!(scene.buffers().trees.meshes.len(), 2);

    let quiet = |report: &FlattenReport| report.mesh_trees.built + report.mesh_trees.dropped == 0;
    let report = after(&mut scene, |scene| *scene.world_mut().get_mut::<Transform>(b).unwrap() = at(3.0));
    assert!(quiet(&report) && report.rows_written() == 1, "{report}");
    let report = after(&mut scene, |scene| *scene.world_mut().get_mut::<Material>(gray).unwrap() = GRAY);
    assert!(quiet(&report) && report.rows_written() == 0, "{report}");
    // The first holder goes: the mesh has another one.
    let report = after(&mut scene, |scene| {
        scene.world_mut().despawn(a);
    });
    assert!(quiet(&report) && report.instances.removed == 1, "{report}");
    let report = after(&mut scene, |scene| {
        scene.world_mut().despawn(b);
    });
    assert_eq!((report.mesh_trees.built, report.mesh_trees.dropped, report.shapes.removed), (0, 1, 1));
    let report = after(&mut scene, |scene| {
        scene.world_mut().entity_mut(c).insert(Shape::Mesh(first.clone()));
    });
    assert_eq!((report.mesh_trees.built, report.mesh_trees.dropped, report.shapes), (1, 1, rewritten(1)));
    assert_eq!(report.instances, RowEdits::default(), "the row refers to the first mesh, whichever that is");
    assert_eq!(report.top_tree, TopTreeEdit::Rebuilt(1));
}

#[test]
fn a_material_of_another_kind_is_mapped_anew() {
    let mut scene = Scene::new();
    let checker = |size| Color::Texture(Texture::Checker { a: Vec3::ZERO, b: Vec3::ONE, size });
    let emissive = Material::Emissive { radiance: checker(2.0), two_sided: true };
    let materials: Vec<Entity> = [Material::Lambert { albedo: checker(1.0) }, GRAY, emissive.clone()]
        .into_iter()
        .map(|material| scene.spawn(material).id())
        .collect();
    for &material in &materials {
        scene.spawn((ball(1.0), UsesMaterial(material)));
    }
    let report = scene.flatten();
    assert_eq!((report.materials, report.textures), (added(3), added(2)));

    // The same kind, another texture: one material, one texture.
    let report = after(&mut scene, |scene| {
        *scene.world_mut().get_mut::<Material>(materials[0]).unwrap() = Material::Lambert { albedo: checker(3.0) };
    });
    assert_eq!((report.materials, report.textures, report.rows_written()), (rewritten(1), rewritten(1), 2));

    // The second becomes emissive: it takes the first emissive row, and the third material the second one.
    let report = after(&mut scene, |scene| {
        let new = Material::Emissive { radiance: Color::WHITE, two_sided: true };
        *scene.world_mut().get_mut::<Material>(materials[1]).unwrap() = new;
    });
    assert_eq!((report.materials, report.instances), (rewritten(2), RowEdits::default()));
    let rows = scene.buffers().materials.rows.view();
    assert_eq!(rows.kind, [MaterialKind::Lambert, MaterialKind::Emissive, MaterialKind::Emissive]);
    assert_eq!(rows.row, [0, 0, 1]);

    // The first goes: its instance is left out, the others follow their materials.
    let report = after(&mut scene, |scene| {
        scene.world_mut().despawn(materials[0]);
    });
    assert_eq!((report.instances, report.invalid.len()), (RowEdits { added: 0, removed: 1, rewritten: 2 }, 1));
    assert_eq!(report.textures.removed, 1);
}

#[test]
fn lights_cameras_and_surroundings_are_written_when_they_change() {
    let mut scene = Scene::new();
    let point = |x: f32| Light::Point { intensity: Vec3::X * x, falloff: Falloff::InverseSquare };
    let lamps: Vec<Entity> = (0..3).map(|i| scene.spawn((point(1.0), at(i as f32))).id()).collect();
    scene.spawn(Light::Ambient { radiance: Vec3::Y });
    scene.spawn(Light::Ambient { radiance: Vec3::Z });
    let projection = Projection::Orthographic { height: 2.0 };
    let camera = scene.spawn((Camera { projection, lens: None }, at(1.0))).id();
    let report = scene.flatten();
    assert_eq!((report.lights, report.cameras), (added(3), added(1)));
    assert_eq!(scene.buffers().ambient, Vec3::new(0.0, 1.0, 1.0));

    let report = after(&mut scene, |scene| *scene.world_mut().get_mut::<Transform>(lamps[2]).unwrap() = at(9.0));
    assert_eq!((report.lights, report.rows_written()), (rewritten(1), 1));
    let report = after(&mut scene, |scene| *scene.world_mut().get_mut::<Light>(lamps[0]).unwrap() = point(2.0));
    assert_eq!((report.lights, report.rows_written()), (rewritten(1), 1));
    let report = after(&mut scene, |scene| *scene.world_mut().get_mut::<Transform>(camera).unwrap() = at(2.0));
    assert_eq!((report.cameras, report.rows_written()), (rewritten(1), 1));
    assert_eq!(scene.buffers().cameras[0].position, Vec3::X * 2.0);

    let night = brewster_buffers::Background::Constant(Vec3::splat(0.1));
    scene.world_mut().insert_resource(Background(night.clone()));
    scene.world_mut().resource_mut::<Settings>().0.max_depth = 7;
    scene.flatten();
    assert_eq!((&scene.buffers().background, scene.buffers().settings.max_depth), (&night, 7));
}

/// Many far moves make a refitted tree slow, and it is built anew; one move does not.
#[test]
fn a_worn_tree_is_built_anew() {
    let mut scene = Scene::new();
    let gray = scene.spawn(GRAY).id();
    let balls: Vec<Entity> =
        (0..3000).map(|i| scene.spawn((ball(0.3), at(i as f32), UsesMaterial(gray))).id()).collect();
    scene.flatten();
    let report = after(&mut scene, |scene| *scene.world_mut().get_mut::<Transform>(balls[0]).unwrap() = at(2999.0));
    assert_eq!(report.top_tree, TopTreeEdit::Refitted(1));
    let report = after(&mut scene, |scene| {
        for (i, &ball) in balls.iter().enumerate() {
            *scene.world_mut().get_mut::<Transform>(ball).unwrap() = at((i * 7 % 3000) as f32);
        }
    });
    assert_eq!(report.top_tree, TopTreeEdit::Rebuilt(3000));
}

#[test]
fn emitters_are_gathered_when_something_shines_anew() {
    let mut scene = Scene::new();
    let glow = |gray| Material::Emissive { radiance: Color::gray(gray), two_sided: false };
    let gray = scene.spawn((SceneKey(10), GRAY)).id();
    let other = scene.spawn((SceneKey(20), ball(1.0), UsesMaterial(gray))).id();
    let lamp = scene.spawn((SceneKey(30), ball(0.2), glow(5.0), at(3.0))).id();
    let point = Light::Point { intensity: Vec3::ONE, falloff: Falloff::InverseSquare };
    let light = scene.spawn((SceneKey(40), point, at(-3.0))).id();
    let gathered = |sources, tree_built| EmittersEdit::Gathered { sources, tree_built };
    assert_eq!(scene.flatten().emitters, gathered(2, true));
    assert_eq!(scene.flatten().emitters, EmittersEdit::Kept);

    let mut check = |expected: EmittersEdit, edit: &mut dyn FnMut(&mut Scene)| {
        let report = after(&mut scene, edit);
        assert_eq!(report.emitters, expected, "{report}");
    };
    let set = |scene: &mut Scene, entity, place| *scene.world_mut().get_mut::<Transform>(entity).unwrap() = place;
    check(EmittersEdit::Kept, &mut |scene| set(scene, other, at(1.0)));
    check(gathered(2, true), &mut |scene| set(scene, lamp, at(4.0)));
    check(gathered(2, true), &mut |scene| set(scene, light, at(-4.0)));
    check(EmittersEdit::Kept, &mut |scene| {
        let lens = Camera { projection: Projection::Orthographic { height: 2.0 }, lens: None };
        scene.world_mut().entity_mut(other).insert(lens);
    });
    // A new row before that of the lamp, then another color of what does not shine: the tree knows nothing of either.
    check(gathered(2, false), &mut |scene| {
        scene.spawn((SceneKey(15), ball(0.5), UsesMaterial(gray)));
    });
    check(gathered(2, false), &mut |scene| {
        *scene.world_mut().get_mut::<Material>(gray).unwrap() = Material::Lambert { albedo: Color::WHITE };
    });
    check(gathered(2, true), &mut |scene| *scene.world_mut().get_mut::<Shape>(lamp).unwrap() = ball(0.3));
    check(gathered(2, true), &mut |scene| *scene.world_mut().get_mut::<Material>(lamp).unwrap() = glow(7.0));
    check(gathered(3, true), &mut |scene| {
        scene.world_mut().entity_mut(other).insert(UsesMaterial(lamp));
    });
    check(gathered(2, true), &mut |scene| {
        scene.world_mut().entity_mut(other).insert(UsesMaterial(gray));
    });
    check(gathered(1, true), &mut |scene| *scene.world_mut().get_mut::<Material>(lamp).unwrap() = glow(0.0));
    check(gathered(0, true), &mut |scene| {
        scene.world_mut().despawn(light);
    });
}
