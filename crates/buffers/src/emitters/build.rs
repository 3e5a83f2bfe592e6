//! Which instances and lights shine, how much, and where to.

use std::collections::BTreeMap;
use std::f32::consts::FRAC_PI_2;

use brewster_geometry::{Aabb, Affine, ShapeKind, TriangleMesh, area_scale};
use brewster_lanes::math;
use brewster_optics::color::luminance;
use glam::{DVec3, Vec3};

use super::choice::{LightChoice, Source};
use super::cone::Cone;
use super::tree::LightBounds;
use super::{Emitter, Emitters, Placing};
use crate::{Distribution, Emissive, Instance, Light, LightKind, MaterialKind, SceneBuffers};

impl Emitters {
    /// Gathers what shines in a scene. Looks at every instance, at every pixel of the textures of emissive materials, and at
    /// every triangle of emissive meshes.
    ///
    /// Planes without end and black surfaces are no emitters.
    pub fn new(scene: &SceneBuffers) -> Emitters {
        let mut gathered = Gathered { scene, tables: BTreeMap::new(), emitters: Emitters::default() };
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
        emitters.choice = LightChoice::new(&sources);
        emitters
    }
}

/// The emitters so far, and what instances of one mesh share.
struct Gathered<'a> {
    scene: &'a SceneBuffers,
    /// By the row of a mesh, the row of its table of triangles and its extent in object space; none if no triangle has an area.
    tables: BTreeMap<u32, Option<(u32, Extent)>>,
    emitters: Emitters,
}

/// How large a surface is, and where its normals point.
#[derive(Clone, Copy)]
struct Extent {
    area: f64,
    normals: Cone,
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
        let mean = f64::from(luminance(scene.textures.mean(emissive.radiance)));
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

    /// How places on an instance are drawn, and its extent in world space.
    fn place(&mut self, instance: &Instance) -> Option<(Placing, Extent)> {
        let (shape, to_world) = (instance.shape, &instance.object_to_world);
        let scale = to_world.uniform_scale();
        if shape.kind == ShapeKind::Mesh {
            let mesh = &self.scene.shapes.meshes[shape.row as usize];
            let triangles = &mut self.emitters.triangles;
            let shared = self.tables.entry(shape.row).or_insert_with(|| {
                let areas: Vec<f64> = (0..mesh.triangles.len()).map(|triangle| mesh.area(triangle)).collect();
                triangles.push(Distribution::new(&areas)?);
                Some((triangles.len() as u32 - 1, extent_of_mesh(mesh, &Affine::IDENTITY)))
            });
            let (table, extent) = (*shared)?;
            let extent = match scale {
                Some(scale) => {
                    let axis = instance.world_to_object.normal_to_source(extent.normals.axis);
                    Extent { area: extent.area * scale * scale, normals: Cone { axis, ..extent.normals } }
                }
                None => extent_of_mesh(mesh, to_world),
            };
            return Some((Placing::Triangles { table }, extent));
        }
        let area = self.scene.shapes.area(shape)?;
        let placing = match (shape.kind, scale) {
            (ShapeKind::Sphere, Some(scale)) => {
                Placing::Cone { radius: scale * f64::from(self.scene.shapes.spheres[shape.row as usize].radius) }
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
