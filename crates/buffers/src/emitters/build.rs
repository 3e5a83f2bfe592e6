//! Which instances and lights shine, how much, and where to.

use std::collections::BTreeMap;
use std::f32::consts::FRAC_PI_2;
use std::sync::Arc;

use brewster_geometry::{Aabb, Affine, ShapeKind, TriangleMesh, area_scale};
use brewster_lanes::math;
use brewster_optics::color::luminance;
use glam::Vec3;

use super::choice::{LightChoice, Source};
use super::cone::Cone;
use super::mesh::{Extent, MeshEmitter, extent_of_mesh};
use super::node::LightBounds;
use super::rectangle::Rectangle;
use super::{Emitter, Emitters, Placing};
use crate::{ColorSource, Emissive, Instance, LightKind, SceneBuffers, TextureId};

impl Emitters {
    /// Gathers what shines in a scene. Looks at every instance, at every pixel of the textures of emissive materials, and at
    /// every triangle of emissive meshes.
    ///
    /// Planes without end and black surfaces are no emitters.
    pub fn new(scene: &SceneBuffers) -> Emitters {
        Emitters::default().update(scene).0
    }

    /// The emitters after edits of a scene: equal to new ones. Meshes that were there are not looked at again, and if all sources
    /// are where they were and as they were the tree is kept. Tells whether it was built.
    pub fn update(self, scene: &SceneBuffers) -> (Emitters, bool) {
        let mut gathered = Gathered::new(scene, self.meshes);
        let mut sources: Vec<Source> = Vec::new();
        for instance in 0..scene.instances.len() {
            sources.extend(gathered.gather(instance).map(Source::Near));
        }
        let mut emitters = gathered.emitters;
        for row in 0..scene.lights.len() {
            let light = scene.lights.get(row);
            if luminance(light.intensity) > 0.0 {
                emitters.lights.push(row as u32);
                sources.push(source_of_light(scene, row));
            }
        }
        let is_built = !self.choice.is_of(&sources);
        emitters.choice = if is_built { LightChoice::new(&sources) } else { self.choice };
        (emitters, is_built)
    }

    /// The emitters after instances of some rows were moved, and nothing else was edited: equal to new ones, too. Where that leaves
    /// their number and kinds as they were no other instance is looked at.
    pub fn follow(mut self, scene: &SceneBuffers, moved: &[u32]) -> (Emitters, bool) {
        let Some(sources) = self.moved(scene, moved) else { return self.update(scene) };
        let is_changed = self.choice.follow(sources);
        (self, is_changed)
    }

    /// Places rows anew. None where the rows of others would be others then.
    fn moved(&mut self, scene: &SceneBuffers, moved: &[u32]) -> Option<Vec<(u32, LightBounds)>> {
        let mut gathered = Gathered::new(scene, self.meshes.clone());
        let mut sources = Vec::new();
        for &row in moved {
            gathered.emitters.rows.clear();
            gathered.emitters.rectangles.clear();
            let bounds = gathered.gather(row as usize);
            let (number, bounds) = match (self.rows.view().instance.binary_search(&row), bounds) {
                (Ok(number), Some(bounds)) => (number, bounds),
                (Err(_), None) => continue,
                _ => return None,
            };
            let mut emitter = gathered.emitters.rows.get(0);
            let placing = self.rows.view().placing[number];
            match (placing, emitter.placing) {
                (Placing::Cone { .. }, Placing::Cone { .. }) | (Placing::Area { .. }, Placing::Area { .. }) => (),
                (Placing::Triangles { .. }, Placing::Triangles { .. }) => emitter.placing = placing,
                (Placing::Rectangle { row }, Placing::Rectangle { .. }) => {
                    self.rectangles[row as usize] = gathered.emitters.rectangles.remove(0);
                    emitter.placing = placing;
                }
                _ => return None,
            }
            self.rows.set(number, emitter);
            sources.push((number as u32, bounds));
        }
        Some(sources)
    }
}

/// The emitters so far, and what instances share.
struct Gathered<'a> {
    scene: &'a SceneBuffers,
    /// Meshes that were looked at for an earlier state of the scene.
    earlier: BTreeMap<*const TriangleMesh, Vec<Arc<MeshEmitter>>>,
    /// By the row of a mesh and its texture, the row among emissive ones; none if no triangle has an area.
    tables: BTreeMap<(u32, TextureId), Option<u32>>,
    /// Mean luminances of textures.
    means: BTreeMap<TextureId, f64>,
    emitters: Emitters,
}

impl<'a> Gathered<'a> {
    fn new(scene: &'a SceneBuffers, meshes: Vec<Arc<MeshEmitter>>) -> Gathered<'a> {
        let mut earlier: BTreeMap<_, Vec<_>> = BTreeMap::new();
        for emitter in meshes {
            earlier.entry(Arc::as_ptr(&emitter.mesh)).or_default().push(emitter);
        }
        let emitters = Emitters::default();
        Gathered { scene, earlier, tables: BTreeMap::new(), means: BTreeMap::new(), emitters }
    }

    /// Adds the row of an instance if it shines.
    fn gather(&mut self, row: usize) -> Option<LightBounds> {
        let scene = self.scene;
        let instance = scene.instances.get(row);
        let material = scene.materials.rows.get(instance.material.0 as usize);
        let emissive = scene.materials.emission(material)?;
        let mean = self.mean_luminance(emissive.radiance);
        if mean.partial_cmp(&0.0) != Some(std::cmp::Ordering::Greater) {
            return None;
        }
        let (placing, Extent { area, normals }) = self.place(row as u32, &instance, emissive.radiance, mean)?;
        let mean = match placing {
            Placing::Triangles { mesh } if emissive.radiance.texture != TextureId::NONE => {
                self.emitters.meshes[mesh as usize].luminance
            }
            _ => mean,
        };
        let bounds = scene.geometry().instances().bounds(row as u32).ok()?;
        // Of what is curved a quarter of the area is seen, on average over all directions (Cauchy); of what is flat, half.
        let is_flat = normals.angle < 1.0;
        let normals = if scene.motions.keys(row as u32).is_some_and(turns) { Cone::SPHERE } else { normals };
        let (normals, seen) = match (is_flat, emissive.two_sided) {
            (true, false) => (normals, 1.0),
            (true, true) => (Cone::SPHERE, 0.5),
            (false, false) => (normals, 0.25),
            (false, true) => (Cone::SPHERE, 0.25),
        };
        let Emissive { radiance, two_sided } = emissive;
        self.emitters.rows.push(Emitter { instance: row as u32, radiance, two_sided, placing });
        Some(LightBounds { bounds, normals, emission: FRAC_PI_2, intensity: mean * area * seen })
    }

    fn mean_luminance(&mut self, color: ColorSource) -> f64 {
        let mean = || f64::from(luminance(self.scene.textures.mean(color)));
        if color.texture == TextureId::NONE { mean() } else { *self.means.entry(color.texture).or_insert_with(mean) }
    }

    /// The row among emissive meshes of a mesh that shines in a color of some mean luminance.
    fn row_of_mesh(&mut self, row: u32, color: ColorSource, mean: f64) -> Option<u32> {
        let scene = self.scene;
        let mesh = &scene.shapes.meshes[row as usize];
        let has_texture = color.texture != TextureId::NONE;
        let texture = has_texture.then(|| (&scene.textures.rows[color.texture.0 as usize], color.factor));
        let (earlier, meshes) = (&self.earlier, &mut self.emitters.meshes);
        *self.tables.entry((row, color.texture)).or_insert_with(|| {
            let mut earlier = earlier.get(&Arc::as_ptr(mesh)).into_iter().flatten();
            let known = earlier.find(|emitter| emitter.is_of(mesh, texture)).cloned();
            // Triangles of one color are chosen by area, whatever the color.
            let mean = if has_texture { mean } else { 1.0 };
            meshes.push(known.or_else(|| MeshEmitter::new(mesh, texture, mean).map(Arc::new))?);
            Some(meshes.len() as u32 - 1)
        })
    }

    /// How places on an instance are drawn, and its extent in world space.
    fn place(&mut self, row: u32, instance: &Instance, color: ColorSource, mean: f64) -> Option<(Placing, Extent)> {
        let (shape, to_world) = (instance.shape, &instance.object_to_world);
        let scale = to_world.uniform_scale();
        let motion = self.scene.motions.keys(row);
        if shape.kind == ShapeKind::Mesh {
            let mesh = self.row_of_mesh(shape.row, color, mean)?;
            let emitter = &self.emitters.meshes[mesh as usize];
            let extent = match scale {
                Some(scale) => {
                    let Extent { area, normals } = emitter.extent;
                    let axis = instance.world_to_object.normal_to_source(normals.axis);
                    Extent { area: area * scale * scale, normals: Cone { axis, ..normals } }
                }
                None => extent_of_mesh(&emitter.mesh, to_world),
            };
            return Some((Placing::Triangles { mesh }, extent));
        }
        let area = self.scene.shapes.area(shape)?;
        let placing = match (shape.kind, scale) {
            (ShapeKind::Sphere, Some(scale)) if !motion.is_some_and(turns) => {
                Placing::Cone { radius: scale * f64::from(self.scene.shapes.spheres[shape.row as usize].radius) }
            }
            (ShapeKind::Quad, _) if motion.is_none() => {
                match Rectangle::new(&self.scene.shapes.quads[shape.row as usize], to_world, area) {
                    Some(rectangle) => {
                        let rectangles = &mut self.emitters.rectangles;
                        rectangles.push(rectangle);
                        Placing::Rectangle { row: rectangles.len() as u32 - 1 }
                    }
                    None => Placing::Area { area },
                }
            }
            _ => Placing::Area { area },
        };
        let area = scale.map_or_else(|| self.area_in_world(instance, area), |scale| area * scale * scale);
        let normals = match shape.kind {
            ShapeKind::Quad | ShapeKind::Disk => Cone::along(instance.world_to_object.normal_to_source(Vec3::Z)),
            _ => Cone::SPHERE,
        };
        Some((placing, Extent { area, normals }))
    }

    /// The area of an analytic shape that is stretched: what a lattice of places makes of it, exact where all normals are one.
    fn area_in_world(&self, instance: &Instance, area: f64) -> f64 {
        const STEPS: u32 = 16;
        let at = |i: u32| (i as f32 + 0.5) / STEPS as f32;
        let places = (0..STEPS * STEPS).filter_map(|i| {
            let sample = self.scene.shapes.sample_area(instance.shape, [at(i / STEPS), at(i % STEPS)])?;
            let normal = instance.world_to_object.normal_to_source(sample.local.normal.as_vec3());
            Some(area_scale(&instance.object_to_world, normal))
        });
        places.sum::<f64>() / f64::from(STEPS * STEPS) * area
    }
}

/// Whether a motion does more than shift a shape.
fn turns(keys: &[Affine]) -> bool {
    let linear = |key: &Affine| key.rows.map(|[x, y, z, _]| [x, y, z]);
    keys.windows(2).any(|pair| linear(&pair[0]) != linear(&pair[1]))
}

/// What a light without extent is chosen by.
fn source_of_light(scene: &SceneBuffers, row: usize) -> Source {
    let light = scene.lights.get(row);
    let intensity = f64::from(luminance(light.intensity));
    if light.kind != LightKind::Point {
        return Source::Everywhere(intensity);
    }
    let still = [[light.position, light.direction]];
    let motion = scene.light_motions.iter().find(|motion| motion.light == row as u32);
    let keys = motion.map_or(&still[..], |motion| &motion.keys);
    let bounds = Aabb::around(keys.iter().map(|[position, _]| *position));
    let turns = keys.iter().any(|[_, direction]| *direction != light.direction);
    let (normals, emission) = if light.cone_scale > 0.0 && !turns {
        // The angle at which the ramp is 0.
        let cosine = (-light.cone_offset / light.cone_scale).clamp(-1.0, 1.0);
        (Cone::along(light.direction), math::acos(cosine) + 1e-3)
    } else {
        (Cone::SPHERE, FRAC_PI_2)
    };
    Source::Near(LightBounds { bounds, normals, emission, intensity })
}
