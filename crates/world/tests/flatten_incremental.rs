//! After any series of edits the columns are those of a fresh world with the same entities and keys, rays hit the same, and
//! the report counts what was written.
//!
//! The expected columns come from the same systems run once over a new world, in which entities are spawned in another order: what
//! is tested is that the way there does not matter.

use std::sync::Arc;

use bevy_ecs::entity::{Entity, EntityHashMap};
use bevy_ecs::hierarchy::ChildOf;
use bevy_ecs::name::Name;
use bevy_ecs::world::World;
use brewster_buffers::{Axis, Channel, Image, ImageTexture, SceneBuffers, Texels, Texture, UvTransform};
use brewster_geometry::{Hit, HitColumns, Rays, TriangleMesh, closest_hits};
use brewster_lanes::Level;
use brewster_optics::fresnel::FresnelModel;
use brewster_optics::thin_film::Film;
use brewster_random::Random;
use brewster_world::Scene;
use brewster_world::components::*;
use glam::{Affine3A, Quat, Vec2, Vec3};

/// A new scene with the entities of another one, spawned from the last to the first.
fn fresh(scene: &Scene) -> Scene {
    let old = scene.world();
    let mut fresh = Scene::new();
    fresh.world_mut().insert_resource(old.resource::<Settings>().clone());
    fresh.world_mut().insert_resource(old.resource::<Background>().clone());
    let mut entities: Vec<Entity> = all_entities(scene);
    entities.reverse();
    let twins: EntityHashMap<Entity> =
        entities.iter().map(|&entity| (entity, fresh.world_mut().spawn_empty().id())).collect();
    let gone = fresh.world_mut().spawn_empty().id();
    fresh.world_mut().despawn(gone);
    let twin = |entity: Entity| twins.get(&entity).copied().unwrap_or(gone);
    for &entity in &entities {
        let mut new = fresh.world_mut().entity_mut(twins[&entity]);
        macro_rules! copy {
            ($($component:ty),*) => {$(
                if let Some(component) = old.get::<$component>(entity) {
                    new.insert(component.clone());
                }
            )*};
        }
        copy!(SceneKey, Transform, Shape, Material, Detail, Light, Camera, Motion, Name);
        if let Some(uses) = old.get::<UsesShape>(entity) {
            new.insert(UsesShape(twin(uses.0)));
        }
        if let Some(uses) = old.get::<UsesMaterial>(entity) {
            new.insert(UsesMaterial(twin(uses.0)));
        }
        if let Some(parent) = old.get::<ChildOf>(entity) {
            new.insert(ChildOf(twin(parent.parent())));
        }
    }
    fresh
}

/// Everything that a test spawned, in the order of ids.
fn all_entities(scene: &Scene) -> Vec<Entity> {
    let mut entities: Vec<Entity> = scene
        .world()
        .archetypes()
        .iter()
        .flat_map(|archetype| archetype.entities())
        .map(|entity| entity.id())
        .collect();
    entities.retain(|&entity| {
        scene.world().get::<Transform>(entity).is_some() || scene.world().get::<SceneKey>(entity).is_some()
    });
    entities.sort();
    entities
}

/// All columns, to the sign of a zero; the top tree may differ.
fn columns(buffers: &SceneBuffers) -> Vec<(&'static str, String)> {
    let SceneBuffers {
        instances,
        motions,
        shapes,
        trees,
        materials,
        textures,
        lights,
        light_motions,
        emitters,
        ambient,
        cameras,
        background,
        settings,
    } = buffers;
    vec![
        ("instances", format!("{instances:?}")),
        ("motions", format!("{motions:?} {light_motions:?}")),
        ("shapes", format!("{shapes:?}")),
        ("mesh trees", format!("{:?}", trees.meshes)),
        ("planes", format!("{:?}", trees.planes)),
        ("materials", format!("{materials:?}")),
        ("textures", format!("{textures:?}")),
        ("lights", format!("{lights:?} {ambient:?}")),
        ("emitters", format!("{emitters:?}")),
        ("cameras", format!("{cameras:?}")),
        ("environment", format!("{background:?} {settings:?}")),
    ]
}

/// The nearest hits of random rays.
fn hits(buffers: &SceneBuffers, rays: usize, random: &mut Random) -> HitColumns {
    let mut columns: [Vec<f32>; 7] = Default::default();
    for _ in 0..rays {
        let (origin, direction) = (random.cube() * 8.0, random.direction());
        for axis in 0..3 {
            columns[axis].push(origin[axis]);
            columns[3 + axis].push(direction[axis]);
        }
        columns[6].push(random.unit());
    }
    let [ox, oy, oz, dx, dy, dz, time] = &columns;
    let mut hits = HitColumns::new();
    hits.resize(rays, Hit::miss());
    closest_hits(
        &buffers.geometry(),
        Level::detect(),
        Rays { origin: [ox, oy, oz], direction: [dx, dy, dz], time },
        hits.view_mut(),
    );
    hits
}

/// Flattens a scene and a fresh one, and compares all that can be compared.
fn check(scene: &mut Scene, seed: u64) {
    let report = scene.flatten();
    let mut fresh = fresh(scene);
    let fresh_report = fresh.flatten();
    for ((table, edited), (_, expected)) in columns(scene.buffers()).into_iter().zip(columns(fresh.buffers())) {
        assert_eq!(edited, expected, "{table} after edits");
    }
    scene.buffers().validate().unwrap();
    let problems = |scene: &Scene, report: &brewster_world::FlattenReport| {
        let key = |entity| scene.world().get::<SceneKey>(entity).map(|key| key.0);
        let mut keys: Vec<_> = report.invalid.iter().map(|invalid| key(invalid.entity)).collect();
        keys.sort();
        keys
    };
    assert_eq!(problems(scene, &report), problems(&fresh, &fresh_report), "{report}\n{fresh_report}");
    let hits = [&*scene, &fresh].map(|scene| hits(scene.buffers(), 64, &mut Random::new(seed)));
    let bits = |hits: &HitColumns| format!("{hits:?}");
    assert_eq!(bits(&hits[0]), bits(&hits[1]));
    assert!(scene.flatten().rows_written() == 0, "nothing was edited");
}

/// A scene under random edits.
struct Editor {
    scene: Scene,
    random: Random,
    meshes: [Arc<TriangleMesh>; 3],
    image: Arc<Image>,
    entities: Vec<Entity>,
}

impl Editor {
    fn new(seed: u64) -> Editor {
        let image = Image { width: 2, height: 1, texels: Texels::Floats(vec![[0.1, 0.2, 0.3], [0.4, 0.5, 0.6]]) };
        let mesh = |size: f32| {
            let positions = vec![Vec3::ZERO, Vec3::X * size, Vec3::Y * size, Vec3::Z * size];
            let triangles = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
            Arc::new(TriangleMesh { positions, triangles, ..Default::default() })
        };
        let flat = TriangleMesh { positions: vec![Vec3::ONE; 3], triangles: vec![[0, 1, 2]], ..Default::default() };
        Editor {
            scene: Scene::new(),
            random: Random::new(seed),
            meshes: [mesh(0.5), mesh(1.5), Arc::new(flat)],
            image: Arc::new(image),
            entities: Vec::new(),
        }
    }

    fn world(&mut self) -> &mut World {
        self.scene.world_mut()
    }

    fn any(&mut self) -> Option<Entity> {
        self.entities.retain(|&entity| self.scene.world().get_entity(entity).is_ok());
        if self.entities.is_empty() { None } else { Some(self.entities[self.random.below(self.entities.len())]) }
    }

    fn place(&mut self) -> Transform {
        let random = &mut self.random;
        if random.below(40) == 0 {
            let odd = [Vec3::new(1.0, 0.0, 1.0), Vec3::NAN, Vec3::splat(1e-30), Vec3::splat(1e20)];
            return Transform(Affine3A::from_scale(odd[random.below(4)]));
        }
        let turn = Quat::from_axis_angle(random.direction(), 3.0 * random.unit());
        let scale = Vec3::splat(0.3) + random.cube().abs() * 0.5;
        Transform(Affine3A::from_scale_rotation_translation(scale, turn, random.cube() * 4.0))
    }

    fn shape(&mut self) -> Shape {
        let length = if self.random.below(30) == 0 { -1.0 } else { 0.2 + self.random.unit() };
        match self.random.below(10) {
            0 | 1 => Shape::Sphere { radius: length },
            2 => Shape::Plane,
            3 => Shape::Quad { size: Vec2::new(length, 1.0) },
            4 => Shape::Disk { radius: length, inner_radius: 0.1 },
            5 => Shape::Cuboid { size: Vec3::new(1.0, length, 0.5) },
            6 => Shape::Cylinder { radius: length, height: 1.0 },
            7 => Shape::Cone { radius: 0.5, height: length },
            8 => Shape::Torus { major_radius: 1.0, minor_radius: 0.5 * length },
            _ => Shape::Mesh(self.meshes[self.random.below(3)].clone()),
        }
    }

    fn color(&mut self) -> Color {
        let (a, b) = (self.random.cube().abs(), self.random.cube().abs());
        match self.random.below(8) {
            0 => Color::Texture(Texture::Checker { a, b, size: 0.5 }),
            1 => Color::Texture(Texture::Gradient { from: a, to: b, axis: Axis::V }),
            2 => {
                let transform = UvTransform::scale(1.0 + a.x, 1.0);
                let image = ImageTexture { transform, ..ImageTexture::new(self.image.clone()) };
                Color::Tinted { factor: b, texture: Texture::Image(image) }
            }
            _ => Color::Constant(a),
        }
    }

    fn detail(&mut self) -> Detail {
        let texture = |color: Color| color.texture().cloned();
        let normal = texture(self.color()).map(|texture| NormalMap { texture, scale: 0.5 });
        let bump = texture(self.color()).map(|map| Scalar { factor: 0.1, texture: Some((map, Channel::G)) });
        let factor = if self.random.below(10) == 0 { f32::NAN } else { self.random.unit() };
        let alpha = Scalar { factor, texture: texture(self.color()).map(|map| (map, Channel::A)) };
        let opacity = match self.random.below(3) {
            0 => Opacity::Opaque,
            1 => Opacity::Mask { alpha, cutoff: 0.5 },
            _ => Opacity::Blend { alpha },
        };
        Detail { normal, bump, opacity, front_only: self.random.below(2) == 0 }
    }

    fn film(&mut self) -> Option<Film> {
        (self.random.below(2) == 0)
            .then(|| Film { ior: 1.0 + self.random.unit(), thickness: 900.0 * self.random.unit() })
    }

    fn material(&mut self) -> Material {
        let exponent = if self.random.below(30) == 0 { f32::NAN } else { 10.0 * self.random.unit() };
        let fresnel = FresnelModel::Schlick;
        match self.random.below(12) {
            11 => {
                let (a, b) = (self.material(), self.material());
                let texture = self.color().texture().cloned().map(|map| (map, Channel::G));
                Material::Mix { a: Box::new(a), b: Box::new(b), by: Scalar { factor: 0.5, texture } }
            }
            0 => Material::Phong { ambient: self.color(), diffuse: self.color(), specular: self.color(), exponent },
            1 => Material::Lambert { albedo: self.color() },
            2 => Material::Metal {
                reflectance: Reflectance::Normal { r0: self.color(), r90: Vec3::ONE, f82: Vec3::ONE },
                fresnel,
                specular: self.color(),
                exponent,
                alpha: self.random.unit(),
                film: None,
                compensated: false,
            },
            3 => {
                let reflectance = Reflectance::Index { eta: Vec3::splat(0.2), k: self.random.cube().abs() * 3.0 };
                Material::Metal {
                    reflectance,
                    fresnel: FresnelModel::Exact,
                    specular: self.color(),
                    exponent,
                    alpha: 0.0,
                    film: self.film(),
                    compensated: false,
                }
            }
            4 => {
                let ior = 1.0 + self.random.unit();
                Material::Dielectric {
                    dispersion: None,
                    ior,
                    fresnel,
                    specular: self.color(),
                    exponent,
                    absorption: Vec3::ONE,
                    scattering: Scattering { coefficient: Vec3::ZERO, anisotropy: self.random.unit() },
                    bare: false,
                    priority: 0,
                    alpha: self.random.unit(),
                    film: None,
                    thin: self.random.below(2) == 0,
                }
            }
            5 => Material::RoughDiffuse { albedo: self.color(), roughness: self.random.unit() },
            6 => {
                let (r0, edge_tint) = (Vec3::splat(self.random.unit()), Vec3::splat(self.random.unit()));
                let reflectance = Reflectance::EdgeTint { r0, edge_tint };
                Material::Metal {
                    reflectance,
                    fresnel: FresnelModel::Exact,
                    specular: self.color(),
                    exponent,
                    alpha: 0.0,
                    film: None,
                    compensated: false,
                }
            }
            7 => Material::Emissive { radiance: self.color(), two_sided: self.random.below(2) == 0 },
            8 => Material::Coated {
                base: Box::new(self.base()),
                ior: 1.5,
                alpha: self.random.unit(),
                absorption: Vec3::ONE,
                thickness: 0.1,
            },
            _ => Material::Principled(Box::new(self.principled())),
        }
    }

    fn base(&mut self) -> Material {
        if self.random.below(2) == 0 {
            return Material::Lambert { albedo: self.color() };
        }
        Material::Metal {
            reflectance: Reflectance::Index { eta: Vec3::ONE, k: Vec3::ONE },
            fresnel: FresnelModel::Exact,
            specular: self.color(),
            exponent: 1.0,
            alpha: 0.1,
            film: None,
            compensated: false,
        }
    }

    fn scalar(&mut self) -> Scalar {
        let texture = match self.color() {
            Color::Texture(texture) => Some((texture, Channel::G)),
            _ => None,
        };
        Scalar { factor: self.random.unit(), texture }
    }

    fn principled(&mut self) -> Principled {
        let transmission = if self.random.below(2) == 0 { Scalar::constant(0.0) } else { self.scalar() };
        let volume = Volume { attenuation_distance: 1.0 + self.random.unit(), ..Volume::default() };
        Principled {
            base_color: self.color(),
            metallic: self.scalar(),
            clearcoat_normal: self.scalar().texture.map(|(texture, _)| NormalMap { texture, scale: 0.5 }),
            sheen_color: self.color(),
            anisotropy: Anisotropy { strength: 0.5, rotation: 1.0, texture: self.scalar().texture.map(|map| map.0) },
            transmission,
            volume: (self.random.below(2) == 0).then_some(volume),
            iridescence: Iridescence { thickness_texture: self.scalar().texture, ..Principled::default().iridescence },
            dispersion: self.random.unit(),
            emission: if self.random.below(2) == 0 { Color::BLACK } else { self.color() },
            unlit: self.random.below(8) == 0,
            ..Principled::default()
        }
    }

    fn light(&mut self) -> Light {
        let intensity = self.random.cube().abs() * 9.0;
        match self.random.below(5) {
            0 => Light::Point { intensity, falloff: Falloff::InverseSquare },
            1 => Light::Point { intensity, falloff: Falloff::None },
            2 => Light::Directional { irradiance: intensity },
            3 => Light::Spot {
                intensity,
                inner_angle: 0.2,
                outer_angle: 0.4 * self.random.unit(),
                falloff: Falloff::None,
            },
            _ => Light::Ambient { radiance: intensity },
        }
    }

    /// Shifts, turns of one, four or sixteen steps, and now and then one that cannot be.
    fn motion(&mut self) -> Motion {
        let random = &mut self.random;
        if random.below(20) == 0 {
            return Motion::through([Affine3A::from_rotation_z(std::f32::consts::PI)]).unwrap();
        }
        let (by, axis, angle) = (random.cube(), random.direction(), [0.0, 0.3, 1.4][random.below(3)]);
        Motion::turning(angle, |s| Affine3A::from_rotation_translation(Quat::from_axis_angle(axis, angle * s), by * s))
    }

    fn camera(&mut self) -> Camera {
        Camera { projection: Projection::Perspective { vfov: 0.1 + self.random.unit() }, lens: None }
    }

    fn spawn(&mut self) {
        let place = self.place();
        let entity = self.world().spawn(place).id();
        for _ in 0..2 {
            self.insert(entity);
        }
        if self.random.below(3) == 0 {
            let key = SceneKey(self.random.bits() >> 8);
            self.world().entity_mut(entity).insert(key);
        }
        self.entities.push(entity);
    }

    /// Gives an entity one more component, or another one of a kind that it has.
    fn insert(&mut self, entity: Entity) {
        let other = self.any().unwrap_or(entity);
        match self.random.below(12) {
            0 | 1 => {
                let shape = self.shape();
                self.world().entity_mut(entity).insert(shape);
            }
            2 => {
                self.world().entity_mut(entity).insert(UsesShape(other));
            }
            3 | 4 => {
                let material = self.material();
                self.world().entity_mut(entity).insert(material);
            }
            5 | 6 => {
                self.world().entity_mut(entity).insert(UsesMaterial(other));
            }
            10 | 11 => {
                let motion = self.motion();
                self.world().entity_mut(entity).insert(motion);
            }
            8 => {
                let detail = self.detail();
                self.world().entity_mut(entity).insert(detail);
            }
            7 => {
                let light = self.light();
                self.world().entity_mut(entity).insert(light);
            }
            _ => {
                let (camera, name) = (self.camera(), Name::new(format!("{other}")));
                self.world().entity_mut(entity).insert((camera, name));
            }
        }
    }

    fn remove(&mut self, entity: Entity) {
        let kind = self.random.below(10);
        let mut entity = self.world().entity_mut(entity);
        match kind {
            0 => entity.remove::<Shape>(),
            1 => entity.remove::<UsesShape>(),
            2 => entity.remove::<Material>(),
            3 => entity.remove::<UsesMaterial>(),
            4 => entity.remove::<Light>(),
            5 => entity.remove::<Camera>(),
            6 => entity.remove::<Name>(),
            7 => entity.remove::<Detail>(),
            8 => entity.remove::<Motion>(),
            _ => entity.remove::<ChildOf>(),
        };
    }

    /// Changes a number of a component that the entity has.
    fn tune(&mut self, entity: Entity) {
        let amount = 0.2 + self.random.unit();
        let color = self.color();
        if let Some(mut shape) = self.world().get_mut::<Shape>(entity)
            && let Shape::Sphere { radius } | Shape::Cylinder { radius, .. } | Shape::Cone { radius, .. } = &mut *shape
        {
            *radius = amount;
        }
        if let Some(mut material) = self.world().get_mut::<Material>(entity)
            && let Material::Lambert { albedo: old }
            | Material::Emissive { radiance: old, .. }
            | Material::Phong { diffuse: old, .. } = &mut *material
        {
            *old = color;
        }
    }

    /// Puts an entity below another one that is not below it.
    fn reparent(&mut self, entity: Entity, parent: Entity) {
        let mut above = Some(parent);
        while let Some(at) = above {
            if at == entity {
                return;
            }
            above = self.world().get::<ChildOf>(at).map(ChildOf::parent);
        }
        self.world().entity_mut(entity).insert(ChildOf(parent));
    }

    fn edit(&mut self) {
        let Some(entity) = self.any() else { return self.spawn() };
        match self.random.below(20) {
            0..4 => self.spawn(),
            4 => {
                self.world().despawn(entity);
            }
            5..9 => {
                let place = self.place();
                self.world().entity_mut(entity).insert(place);
            }
            9..11 => {
                let parent = self.any().expect("there is one");
                self.reparent(entity, parent);
            }
            11..14 => self.insert(entity),
            14..17 => self.tune(entity),
            17 => self.remove(entity),
            18 => {
                let key = SceneKey(self.random.bits() >> 8);
                self.world().entity_mut(entity).insert(key);
            }
            _ => {
                let color = self.random.cube().abs();
                self.world().resource_mut::<Background>().0 = brewster_buffers::Background::Constant(color);
                self.world().resource_mut::<Settings>().0.max_depth += 1;
            }
        }
    }
}

#[test]
fn edited_columns_equal_those_of_a_fresh_world() {
    for seed in 0..24 {
        let mut editor = Editor::new(seed);
        for _ in 0..editor.random.below(60) {
            editor.spawn();
        }
        for round in 0..25 {
            check(&mut editor.scene, seed ^ round);
            let edits = if editor.random.below(4) == 0 { 30 } else { 1 + editor.random.below(3) };
            (0..edits).for_each(|_| editor.edit());
        }
        check(&mut editor.scene, seed);
    }
}
