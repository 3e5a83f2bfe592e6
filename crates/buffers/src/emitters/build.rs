//! Which instances and lights shine, and how much.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use brewster_geometry::{Affine, ShapeKind, TriangleMesh, area_scale};
use brewster_optics::color::luminance;

use super::choice::{LightChoice, Source};
use super::{Emitter, Emitters, Placing};
use crate::{Distribution, Instance, Light, LightKind, MaterialKind, SceneBuffers};

impl Emitters {
    /// Gathers what shines in a scene. Looks at every instance, at every pixel of the textures of emissive materials, and at
    /// every triangle of emissive meshes.
    ///
    /// Planes without end and black surfaces are no emitters.
    pub fn new(scene: &SceneBuffers) -> Emitters {
        let mut gathered = Gathered { scene, tables: BTreeMap::new(), emitters: Emitters::default() };
        let mut sources = Vec::new();
        for instance in 0..scene.instances.len() {
            sources.extend(gathered.gather(instance));
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
    /// By the row of a mesh, the row of its table of triangles, and its area; none if no triangle has any.
    tables: BTreeMap<u32, Option<(u32, f64)>>,
    emitters: Emitters,
}

impl Gathered<'_> {
    /// Adds the row of an instance if it shines.
    fn gather(&mut self, row: usize) -> Option<Source> {
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
        let (placing, area) = self.place(&instance)?;
        let sides = if emissive.two_sided { 2.0 } else { 1.0 };
        let power = mean * PI * area * sides;
        let emitter = Emitter {
            instance: row as u32,
            radiance: emissive.radiance,
            two_sided: emissive.two_sided,
            placing,
            power,
        };
        self.emitters.rows.push(emitter);
        Some(Source { power })
    }

    /// How places on an instance are drawn, and its area in world space.
    fn place(&mut self, instance: &Instance) -> Option<(Placing, f64)> {
        let (shape, to_world) = (instance.shape, &instance.object_to_world);
        let scale = to_world.uniform_scale();
        if shape.kind == ShapeKind::Mesh {
            let mesh = &self.scene.shapes.meshes[shape.row as usize];
            let triangles = &mut self.emitters.triangles;
            let shared = self.tables.entry(shape.row).or_insert_with(|| {
                let areas: Vec<f64> = (0..mesh.triangles.len()).map(|triangle| mesh.area(triangle)).collect();
                triangles.push(Distribution::new(&areas)?);
                Some((triangles.len() as u32 - 1, areas.iter().sum()))
            });
            let (table, area) = (*shared)?;
            let area = scale.map_or_else(|| area_of_mesh(mesh, to_world), |scale| area * scale * scale);
            return Some((Placing::Triangles { table }, area));
        }
        let area = self.scene.shapes.area(shape)?;
        let placing = match (shape.kind, scale) {
            (ShapeKind::Sphere, Some(scale)) => {
                Placing::Cone { radius: scale * f64::from(self.scene.shapes.spheres[shape.row as usize].radius) }
            }
            _ => Placing::Area { area },
        };
        let area = scale.map_or_else(|| self.area_in_world(instance, area), |scale| area * scale * scale);
        Some((placing, area))
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

/// The area of a mesh in world space.
fn area_of_mesh(mesh: &TriangleMesh, to_world: &Affine) -> f64 {
    let area = |triangle| {
        let [a, b, c] = mesh.corners(triangle);
        let (ab, ac) = (to_world.vector(b - a).as_dvec3(), to_world.vector(c - a).as_dvec3());
        0.5 * ab.cross(ac).length()
    };
    (0..mesh.triangles.len()).map(area).sum()
}

fn source_of_light(light: &Light) -> Source {
    let intensity = luminance(light.intensity);
    let solid_angle = if light.cone_scale > 0.0 {
        // The cone of half strength: the ramp's square is a quarter there.
        let cosine = ((0.5 - light.cone_offset) / light.cone_scale).clamp(-1.0, 1.0);
        2.0 * (1.0 - cosine)
    } else {
        4.0
    };
    let solid_angle = if light.kind == LightKind::Directional { 4.0 } else { solid_angle };
    Source { power: f64::from(intensity * solid_angle) * PI }
}
