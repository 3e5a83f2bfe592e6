//! Which instances and lights shine, how much, and where to.

use std::collections::BTreeMap;
use std::f32::consts::FRAC_PI_2;
use std::sync::Arc;

use brewster_geometry::{Aabb, Affine, ShapeKind, TriangleMesh, area_scale};
use brewster_lanes::math;
use brewster_optics::color::luminance;
use glam::{DVec3, Vec3};

use super::choice::{LightChoice, Source};
use super::cone::Cone;
use super::rectangle::SeenRectangle;
use super::tree::LightBounds;
use super::{Emitter, Emitters, Placing};
use crate::{ColorSource, Distribution, Emissive, Instance, Light, LightKind, MaterialKind, SceneBuffers, TextureId};

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
        let earlier = self.meshes.into_iter().map(|emitter| (Arc::as_ptr(&emitter.mesh), emitter)).collect();
        let emitters = Emitters::default();
        let mut gathered = Gathered { scene, earlier, tables: BTreeMap::new(), means: BTreeMap::new(), emitters };
        let mut sources: Vec<Source> = Vec::new();
        for instance in 0..scene.instances.len() {
            sources.extend(gathered.gather(instance).map(Source::Near));
        }
        let mut emitters = gathered.emitters;
        for row in 0..scene.lights.len() {
            let light = scene.lights.get(row);
            if luminance(light.intensity) > 0.0 {
                emitters.lights.push(row as u32);
                sources.push(source_of_light(&light));
            }
        }
        let is_built = self.choice.sources() != sources;
        emitters.choice = if is_built { LightChoice::new(sources) } else { self.choice };
        (emitters, is_built)
    }
}

/// The emitters so far, and what instances share.
struct Gathered<'a> {
    scene: &'a SceneBuffers,
    /// Meshes that were looked at for an earlier state of the scene.
    earlier: BTreeMap<*const TriangleMesh, Arc<MeshEmitter>>,
    /// By the row of a mesh, its row among emissive ones; none if no triangle has an area.
    tables: BTreeMap<u32, Option<u32>>,
    /// Mean luminances of textures.
    means: BTreeMap<TextureId, f64>,
    emitters: Emitters,
}

/// How large a surface is, and where its normals point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Extent {
    area: f64,
    normals: Cone,
}

/// What all instances of an emissive mesh share.
#[derive(Clone, Debug)]
pub(super) struct MeshEmitter {
    mesh: Arc<TriangleMesh>,
    /// By area in object space.
    pub(super) triangles: Distribution,
    /// In object space.
    extent: Extent,
}

/// Meshes are equal if they are one in memory, and then so is what follows from them.
impl PartialEq for MeshEmitter {
    fn eq(&self, other: &MeshEmitter) -> bool {
        Arc::ptr_eq(&self.mesh, &other.mesh)
    }
}

impl MeshEmitter {
    fn new(mesh: &Arc<TriangleMesh>) -> Option<MeshEmitter> {
        let areas: Vec<f64> = (0..mesh.triangles.len()).map(|triangle| mesh.area(triangle)).collect();
        let (triangles, extent) = (Distribution::new(&areas)?, extent_of_mesh(mesh, &Affine::IDENTITY));
        Some(MeshEmitter { mesh: mesh.clone(), triangles, extent })
    }
}

impl Gathered<'_> {
    /// Adds the row of an instance if it shines.
    fn gather(&mut self, row: usize) -> Option<LightBounds> {
        let scene = self.scene;
        let instance = scene.instances.get(row);
        let material = scene.materials.rows.get(instance.material.0 as usize);
        if material.kind != MaterialKind::Emissive {
            return None;
        }
        let emissive = scene.materials.emissive.get(material.row as usize);
        let mean = self.mean_luminance(emissive.radiance);
        if mean.partial_cmp(&0.0) != Some(std::cmp::Ordering::Greater) {
            return None;
        }
        let (placing, Extent { area, normals }) = self.place(&instance)?;
        let bounds = scene.geometry().instances().bounds(row as u32).ok()?;
        // Of what is curved a quarter of the area is seen, on average over all directions (Cauchy); of what is flat, half.
        let is_flat = normals.angle < 1.0;
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

    /// The row of a mesh among emissive ones.
    fn row_of_mesh(&mut self, row: u32) -> Option<u32> {
        let mesh = &self.scene.shapes.meshes[row as usize];
        let (earlier, meshes) = (&self.earlier, &mut self.emitters.meshes);
        *self.tables.entry(row).or_insert_with(|| {
            let earlier = earlier.get(&Arc::as_ptr(mesh)).cloned();
            meshes.push(earlier.or_else(|| MeshEmitter::new(mesh).map(Arc::new))?);
            Some(meshes.len() as u32 - 1)
        })
    }

    /// How places on an instance are drawn, and its extent in world space.
    fn place(&mut self, instance: &Instance) -> Option<(Placing, Extent)> {
        let (shape, to_world) = (instance.shape, &instance.object_to_world);
        let scale = to_world.uniform_scale();
        if shape.kind == ShapeKind::Mesh {
            let mesh = self.row_of_mesh(shape.row)?;
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
            (ShapeKind::Sphere, Some(scale)) => {
                Placing::Cone { radius: scale * f64::from(self.scene.shapes.spheres[shape.row as usize].radius) }
            }
            (ShapeKind::Quad, _) if SeenRectangle::is_one(&self.scene.shapes.quads[shape.row as usize], to_world) => {
                Placing::Rectangle { area }
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

/// The extent of a mapped mesh. A map that mirrors turns triangles over, but not their normals.
fn extent_of_mesh(mesh: &TriangleMesh, map: &Affine) -> Extent {
    let side = if map.mirrors() { -0.5 } else { 0.5 };
    let area = |triangle: usize| {
        let [a, b, c] = mesh.corners(triangle);
        let (ab, ac) = (map.vector(b - a).as_dvec3(), map.vector(c - a).as_dvec3());
        ab.cross(ac) * side
    };
    let areas = || (0..mesh.triangles.len()).map(area);
    let (sum, total) = areas().fold((DVec3::ZERO, 0.0), |(sum, total), area| (sum + area, total + area.length()));
    let Some(axis) = sum.try_normalize() else { return Extent { area: total, normals: Cone::SPHERE } };
    let cosine = areas().filter_map(DVec3::try_normalize).map(|normal| normal.dot(axis)).fold(1.0, f64::min);
    let angle = math::acos((cosine as f32).clamp(-1.0, 1.0));
    // Rounding turns normals of slivers; nothing wider than this is worth telling from a ball.
    let normals = if angle < 3.0 { Cone { axis: axis.as_vec3(), angle: angle + 1e-3 } } else { Cone::SPHERE };
    Extent { area: total, normals }
}

/// What a light without extent is chosen by.
fn source_of_light(light: &Light) -> Source {
    let intensity = f64::from(luminance(light.intensity));
    if light.kind != LightKind::Point {
        return Source::Everywhere(intensity);
    }
    let bounds = Aabb { min: light.position, max: light.position };
    let (normals, emission) = if light.cone_scale > 0.0 {
        // The angle at which the ramp is 0.
        let cosine = (-light.cone_offset / light.cone_scale).clamp(-1.0, 1.0);
        (Cone::along(light.direction), math::acos(cosine) + 1e-3)
    } else {
        (Cone::SPHERE, FRAC_PI_2)
    };
    Source::Near(LightBounds { bounds, normals, emission, intensity })
}
