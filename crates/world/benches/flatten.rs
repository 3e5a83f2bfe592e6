//! What flattening 100,000 entities costs, and 100,000 that shine: `cargo bench -p brewster-world`.
//!
//! Prints milliseconds, best and median, for a new scene and for single edits of it. After every kind of edit the columns are
//! compared with those of a new scene with the same entities, and so are the hits of 10,000 rays.

use std::time::Instant;

use bevy_ecs::entity::Entity;
use brewster_buffers::SceneBuffers;
use brewster_geometry::{Hit, HitColumns, Rays, closest_hits};
use brewster_lanes::Level;
use brewster_random::Random;
use brewster_world::components::*;
use brewster_world::{FlattenReport, Scene};
use glam::{Affine3A, Vec3};

const ENTITIES: usize = 100_000;

/// What an entity of the field is made of.
#[derive(Clone, Copy)]
struct Bead {
    place: Vec3,
    radius: f32,
    material: usize,
}

/// The field as data, from which a scene can be spawned at any time.
#[derive(Clone)]
struct Field {
    beads: Vec<(u64, Bead)>,
    albedos: [f32; 10],
    /// A material of each of them.
    material: fn(f32) -> Material,
}

/// A scene of a field, and its entities in the same order.
struct Spawned {
    scene: Scene,
    beads: Vec<Entity>,
    materials: Vec<Entity>,
}

impl Field {
    fn new(material: fn(f32) -> Material, random: &mut Random) -> Field {
        let bead = |key| {
            let (place, radius, material) = (random.cube() * 100.0, 0.1 + 0.4 * random.unit(), random.below(10));
            (100 + 2 * key, Bead { place, radius, material })
        };
        let albedos = std::array::from_fn(|i| 0.1 * i as f32);
        Field { beads: (0..ENTITIES as u64).map(bead).collect(), albedos, material }
    }

    fn spawn(&self) -> Spawned {
        let mut scene = Scene::new();
        let materials: Vec<Entity> = (0..)
            .zip(self.albedos)
            .map(|(key, albedo)| scene.spawn((SceneKey(key), (self.material)(albedo))).id())
            .collect();
        let beads = self.beads.iter().map(|&(key, bead)| spawn_bead(&mut scene, &materials, key, bead)).collect();
        Spawned { scene, beads, materials }
    }
}

fn spawn_bead(scene: &mut Scene, materials: &[Entity], key: u64, bead: Bead) -> Entity {
    let place = Transform(Affine3A::from_translation(bead.place));
    let shape = Shape::Sphere { radius: bead.radius };
    scene.spawn((SceneKey(key), place, shape, UsesMaterial(materials[bead.material]))).id()
}

/// An edit, done to a scene and to the field that it was spawned from.
type Edit = fn(&mut Spawned, &mut Field, &mut Random);

const EDITS: [(&str, Edit); 8] = [
    ("nothing", |_, _, _| ()),
    ("one moved", |spawned, field, random| {
        let (i, place) = (random.below(ENTITIES), random.cube() * 100.0);
        field.beads[i].1.place = place;
        spawned.scene.world_mut().get_mut::<Transform>(spawned.beads[i]).unwrap().0 = Affine3A::from_translation(place);
    }),
    ("one material", |spawned, field, random| {
        let (i, albedo) = (random.below(10), random.unit());
        field.albedos[i] = albedo;
        let material = (field.material)(albedo);
        *spawned.scene.world_mut().get_mut::<Material>(spawned.materials[i]).unwrap() = material;
    }),
    ("one radius", |spawned, field, random| {
        let (i, radius) = (random.below(ENTITIES), 0.1 + 0.4 * random.unit());
        field.beads[i].1.radius = radius;
        *spawned.scene.world_mut().get_mut::<Shape>(spawned.beads[i]).unwrap() = Shape::Sphere { radius };
    }),
    ("one repainted", |spawned, field, random| {
        let (i, material) = (random.below(ENTITIES), random.below(10));
        field.beads[i].1.material = material;
        let uses = UsesMaterial(spawned.materials[material]);
        spawned.scene.world_mut().entity_mut(spawned.beads[i]).insert(uses);
    }),
    ("one despawned", |spawned, field, random| {
        let i = random.below(field.beads.len());
        field.beads.remove(i);
        spawned.scene.world_mut().despawn(spawned.beads.remove(i));
    }),
    ("one spawned", |spawned, field, random| {
        let i = random.below(field.beads.len() - 1);
        let (key, bead) = (field.beads[i].0 + 1, Bead { place: random.cube() * 100.0, radius: 0.3, material: 3 });
        if field.beads[i + 1].0 != key {
            field.beads.insert(i + 1, (key, bead));
            spawned.beads.insert(i + 1, spawn_bead(&mut spawned.scene, &spawned.materials, key, bead));
        }
    }),
    ("all moved a little", |spawned, field, random| {
        for ((_, bead), &entity) in field.beads.iter_mut().zip(&spawned.beads) {
            bead.place += random.cube() * 0.1;
            let mut transform = spawned.scene.world_mut().get_mut::<Transform>(entity).unwrap();
            transform.0 = Affine3A::from_translation(bead.place);
        }
    }),
];

/// Flattens and says how many milliseconds that took from outside.
fn flatten(scene: &mut Scene) -> (f64, FlattenReport) {
    let start = Instant::now();
    let report = scene.flatten();
    (1e3 * start.elapsed().as_secs_f64(), report)
}

fn print(name: &str, mut times: Vec<f64>, report: &FlattenReport) {
    times.sort_by(f64::total_cmp);
    let (best, median) = (times[0], times[times.len() / 2]);
    println!(
        "{name:<20} {best:>8.3} {median:>8.3}   {} rows written, top tree {:?}",
        report.rows_written(),
        report.top_tree
    );
    if std::env::args().any(|argument| argument == "--systems") {
        for (system, time) in &report.times {
            println!("    {system:<30} {:>8.3}", 1e3 * time.as_secs_f64());
        }
    }
}

fn assert_same(edited: &SceneBuffers, fresh: &SceneBuffers, after: &str) {
    assert!(edited.instances == fresh.instances, "instances after {after}");
    assert!(edited.shapes == fresh.shapes, "shapes after {after}");
    assert!(edited.materials == fresh.materials, "materials after {after}");
    assert!(edited.emitters == fresh.emitters, "emitters after {after}");
    let mut random = Random::new(11);
    let columns: [Vec<f32>; 6] = {
        let rays: Vec<[f32; 6]> = (0..10_000)
            .map(|_| {
                let (origin, direction) = (random.cube() * 100.0, random.direction());
                [origin.x, origin.y, origin.z, direction.x, direction.y, direction.z]
            })
            .collect();
        std::array::from_fn(|column| rays.iter().map(|ray| ray[column]).collect())
    };
    let [ox, oy, oz, dx, dy, dz] = &columns;
    let hits = [edited, fresh].map(|buffers| {
        let mut hits = HitColumns::new();
        hits.resize(ox.len(), Hit::miss());
        let rays = Rays { origin: [ox, oy, oz], direction: [dx, dy, dz], time: &[] };
        closest_hits(&buffers.geometry(), Level::detect(), rays, hits.view_mut());
        hits
    });
    assert!(hits[0] == hits[1], "hits after {after}");
}

fn main() {
    println!("flatten of {ENTITIES} entities     best   median   milliseconds");
    measure(|albedo| Material::Lambert { albedo: Color::gray(albedo) }, &EDITS);
    println!("the same, and they shine");
    measure(|part| Material::Emissive { radiance: Color::gray(0.1 + part), two_sided: false }, &EDITS[..2]);
}

/// Times a new field of a material, and edits of it.
fn measure(material: fn(f32) -> Material, edits: &[(&str, Edit)]) {
    let mut random = Random::new(7);
    let mut field = Field::new(material, &mut random);
    let mut times = Vec::new();
    let (mut spawned, report) = loop {
        let mut spawned = field.spawn();
        let (time, report) = flatten(&mut spawned.scene);
        times.push(time);
        if times.len() == 5 {
            break (spawned, report);
        }
    };
    print("all new", times, &report);
    for &(name, edit) in edits {
        let mut last = FlattenReport::default();
        let times = (0..15)
            .map(|_| {
                edit(&mut spawned, &mut field, &mut random);
                let (time, report) = flatten(&mut spawned.scene);
                last = report;
                time
            })
            .collect();
        print(name, times, &last);
        let mut fresh = field.spawn();
        fresh.scene.flatten();
        assert_same(spawned.scene.buffers(), fresh.scene.buffers(), name);
    }
    spawned.scene.buffers().validate().unwrap();
}
