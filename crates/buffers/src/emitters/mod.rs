//! Sampling of light sources: surfaces that shine, and lights without extent.
//!
//! [`SceneBuffers::sample_light`] chooses a source as a point sees it, and a direction toward it;
//! [`SceneBuffers::light_pdf`] tells the density of that for a direction that met a source by chance. Both look at where the
//! point is and at nothing else of it, so that a ray that has left its surface long ago can still be told.
//!
//! | source | its place |
//! | --- | --- |
//! | sphere, not stretched, that does not turn | in its cone of directions; from inside, any direction |
//! | rectangle that looks large, not sheared, that does not move | evenly over its solid angle |
//! | other shapes | evenly over the area |
//! | mesh | a triangle by its area and what its texture shows there, evenly over it |
//! | light without extent | where it is |

mod build;
mod bundles;
mod choice;
mod cone;
mod growth;
mod mesh;
mod node;
mod rectangle;
mod sphere;
mod tree;

use std::sync::Arc;

use brewster_geometry::{
    Affine, AreaSample, Place, ShapeKind, Sight, Sights, Spread, SurfacePoint, offset_origin, per_solid_angle, sight,
};
use brewster_lanes::{Level, columns};
use glam::Vec3;

use crate::{ColorSource, LightSample, SceneBuffers};

use self::choice::LightChoice;
use self::mesh::MeshEmitter;
use self::rectangle::{Rectangle, SeenRectangle};
use self::sphere::PlacedSphere;

columns! {
    /// An instance that sends out light and can be sampled.
    pub struct Emitter => EmitterColumns, EmittersView, EmittersViewMut {
        /// Row of the instance; rows are in its order.
        pub instance: u32,
        /// Its radiance.
        pub radiance: ColorSource,
        /// Whether it shines from both sides.
        pub two_sided: bool,
        /// How places on it are drawn.
        pub placing: Placing,
    }
}

/// How places on an emitter are drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Placing {
    /// By direction: a sphere of this radius in world space.
    Cone {
        /// The radius in meters.
        radius: f64,
    },
    /// By direction where it looks large, otherwise by area: a rectangle.
    Rectangle {
        /// Its row among emissive rectangles.
        row: u32,
    },
    /// Evenly over an analytic shape of this area in object space.
    Area {
        /// The area.
        area: f64,
    },
    /// Over the triangles of a mesh.
    Triangles {
        /// Its row among emissive meshes.
        mesh: u32,
    },
}

/// What sends out light, and how it is chosen from. Written whole by [`Emitters::new`], stale when instances, shapes, emissive
/// materials, their textures or lights have changed; [`Emitters::update`] spares what did not change.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Emitters {
    rows: EmitterColumns,
    /// Meshes that are emissive somewhere.
    meshes: Vec<Arc<MeshEmitter>>,
    /// Emissive rectangles in world space.
    rectangles: Vec<Rectangle>,
    /// Rows of lights that shine: what a choice beyond the emitters means.
    lights: Vec<u32>,
    choice: LightChoice,
}

impl Emitters {
    /// The emissive instances, in their order.
    pub fn rows(&self) -> EmittersView<'_> {
        self.rows.view()
    }

    /// The number of sources: emissive instances and lights that shine.
    pub fn len(&self) -> usize {
        self.rows.len() + self.lights.len()
    }

    /// Whether nothing but the background shines.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

impl LightSample {
    /// Where a ray from `origin` toward the light goes, and how far without meeting the light itself: for origins next to the
    /// point that the sample was drawn for.
    #[inline(always)]
    pub fn ray_from(&self, origin: Vec3) -> (Vec3, f32) {
        if self.distance == f32::INFINITY {
            return (self.direction, f32::INFINITY);
        }
        let to = self.target - origin;
        let length = to.length();
        // A ray's end is off by less than this, which is not much beside the target's own distance from the light.
        if length > 0.0 { (to / length, length * (1.0 - f32::EPSILON)) } else { (self.direction, 0.0) }
    }
}

impl SceneBuffers {
    /// Draws a source of light and a direction toward it, as `point` sees it at a moment of the shutter, with a number for the choice and two for the
    /// place, all 0 ≤ u < 1. The background is not among them. `None` is a sample without light: nothing shines, or what was
    /// drawn faces away.
    #[inline]
    pub fn sample_light(&self, point: Vec3, time: f32, choice: f32, place: [f32; 2]) -> Option<LightSample> {
        match self.draw_source((point, time), choice, place)? {
            Source::Emitter(drawn, sample) => {
                let mut moved = None;
                let (to_world, to_object) = self.place_of(&drawn, time, &mut moved);
                self.light_seen(&drawn, time, &sight(point, to_world, to_object, &sample))
            }
            Source::Light(sample) => Some(sample),
        }
    }

    /// [`SceneBuffers::sample_light`] for many points, and times where something moves.
    ///
    /// Reads: points, times, numbers, emitters, lights. Writes: `lights`, a row for each point.
    pub fn sample_lights(
        &self,
        level: Level,
        (points, times): (&[SurfacePoint], &[f32]),
        choice: &[f32],
        place: [&[f32]; 2],
        lights: &mut [Option<LightSample>],
    ) {
        let mut sights = Sights::default();
        let mut waiting = [(0, Drawn::default()); Sights::CAPACITY];
        for (row, point) in points.iter().enumerate() {
            let (viewer, time) = (point.position, times.get(row).copied().unwrap_or(0.0));
            lights[row] = match self.draw_source((viewer, time), choice[row], [place[0][row], place[1][row]]) {
                Some(Source::Emitter(drawn, sample)) => {
                    let mut moved = None;
                    let (to_world, to_object) = self.place_of(&drawn, time, &mut moved);
                    waiting[sights.len()] = (row, drawn);
                    sights.push(viewer, to_world, to_object, &sample);
                    None
                }
                Some(Source::Light(sample)) => Some(sample),
                None => None,
            };
            if sights.len() == Sights::CAPACITY || row + 1 == points.len() {
                sights.look(level, |lane, sight| {
                    let (row, drawn) = &waiting[lane];
                    let time = times.get(*row).copied().unwrap_or(0.0);
                    lights[*row] = self.light_seen(drawn, time, sight);
                });
            }
        }
    }

    /// How the instance of an emitter is placed at a moment, and back.
    #[inline(always)]
    fn place_of<'p>(&'p self, drawn: &Drawn, time: f32, moved: &'p mut Option<Place>) -> (&'p Affine, &'p Affine) {
        self.place_at(self.emitters.rows.view().instance[drawn.row as usize], time, moved)
    }

    /// Draws a source and a place on it.
    #[inline]
    fn draw_source(&self, (point, time): (Vec3, f32), choice: f32, place: [f32; 2]) -> Option<Source> {
        let emitters = &self.emitters;
        let (source, probability) = emitters.choice.choose(point, choice)?;
        let count = emitters.rows.len();
        if (source as usize) < count {
            let (sample, density) = self.draw_place(source as usize, (point, time), place)?;
            let drawn = Drawn { row: source, primitive: sample.primitive, density, probability };
            return Some(Source::Emitter(drawn, sample));
        }
        let light = self.light_at(emitters.lights[source as usize - count] as usize, time);
        let seen = light.illuminate(point);
        let is_lit = seen.irradiance != Vec3::ZERO;
        is_lit.then_some(Source::Light(LightSample {
            direction: seen.direction,
            distance: seen.distance,
            target: light.position,
            radiance: seen.irradiance,
            pdf: probability,
            is_delta: true,
        }))
    }

    /// The density per solid angle, at a moment of the shutter, with which [`SceneBuffers::sample_light`] at `origin` gives the direction to a point of an
    /// emissive instance; 0 for what it never gives.
    #[inline]
    pub fn light_pdf(&self, origin: Vec3, time: f32, (instance, primitive): (u32, u32), hit: &SurfacePoint) -> f32 {
        let emitters = &self.emitters;
        let rows = emitters.rows.view();
        let Ok(row) = rows.instance.binary_search(&instance) else { return 0.0 };
        let to = hit.position - origin;
        let squared = to.length_squared();
        let cosine = -to.dot(hit.geometric_normal) / squared.sqrt();
        if !(squared > 0.0 && (cosine > 0.0 || rows.two_sided[row] && cosine < 0.0)) {
            return 0.0;
        }
        let mut moved = None;
        let (to_world, _) = self.place_at(instance, time, &mut moved);
        let density = match rows.placing[row] {
            Placing::Cone { radius } => PlacedSphere::new(to_world, radius).pdf(origin, rows.two_sided[row]),
            Placing::Rectangle { row } => {
                let rectangle = &emitters.rectangles[row as usize];
                SeenRectangle::new(rectangle, origin).map_or_else(
                    || per_solid_angle(to_world, hit.geometric_normal, squared, cosine) / rectangle.area,
                    |seen| seen.pdf(),
                )
            }
            Placing::Area { area } => per_solid_angle(to_world, hit.geometric_normal, squared, cosine) / area,
            Placing::Triangles { mesh } => {
                let mesh = &emitters.meshes[mesh as usize];
                let probability = f64::from(mesh.triangles.probability(primitive));
                // A triangle without area is never drawn, and no ray meets it.
                if probability == 0.0 {
                    return 0.0;
                }
                probability / mesh.faces[primitive as usize].area
                    * per_solid_angle(to_world, hit.geometric_normal, squared, cosine)
            }
        };
        sound(density as f32 * emitters.choice.probability(origin, row as u32)).unwrap_or(0.0)
    }

    /// Draws a place of an emitter.
    #[inline]
    fn draw_place(&self, row: usize, (point, time): (Vec3, f32), place: [f32; 2]) -> Option<(AreaSample, Density)> {
        let rows = self.emitters.rows.view();
        let (instances, instance) = (self.instances.view(), rows.instance[row] as usize);
        let mut moved = None;
        let (to_world, to_object) = self.place_at(instance as u32, time, &mut moved);
        let (shape, two_sided) = (instances.shape[instance], rows.two_sided[row]);
        Some(match rows.placing[row] {
            Placing::Cone { radius } => {
                debug_assert_eq!(shape.kind, ShapeKind::Sphere);
                let sphere = PlacedSphere::new(to_world, radius);
                let (direction, normal, density) = sphere.sample(point, two_sided, place)?;
                let sphere = &self.shapes.spheres[shape.row as usize];
                let sample = AreaSample::on(sphere, (to_object.vector(normal).as_dvec3(), 0));
                (sample, Density::Along(direction, density))
            }
            Placing::Rectangle { row } => {
                let rectangle = &self.emitters.rectangles[row as usize];
                let seen = SeenRectangle::new(rectangle, point);
                let place = seen.as_ref().map_or(place, |seen| seen.sample(place));
                let quad = &self.shapes.quads[shape.row as usize];
                let even = Density::PerArea { area: rectangle.area, probability: 1.0 };
                let density = seen.map_or(even, |seen| Density::PerSolidAngle(seen.pdf()));
                (AreaSample::on(quad, quad.spread(place)), density)
            }
            Placing::Area { area } => {
                (self.shapes.sample_area(shape, place)?, Density::PerArea { area, probability: 1.0 })
            }
            Placing::Triangles { mesh } => {
                let emitter = &self.emitters.meshes[mesh as usize];
                let triangle = emitter.triangles.choose(place[0]);
                let face = &emitter.faces[triangle.index as usize];
                let sample = emitter.mesh.sample_area(triangle.index as usize, face, [triangle.rest, place[1]]);
                (sample, Density::PerArea { area: face.area, probability: f64::from(triangle.probability) })
            }
        })
    }

    /// The light of a drawn place that is seen.
    #[inline]
    fn light_seen(&self, drawn: &Drawn, time: f32, sight: &Sight) -> Option<LightSample> {
        let rows = self.emitters.rows.view();
        let (row, Sight { surface, squared, cosine, per_area, .. }) = (drawn.row as usize, sight);
        let shines = *squared > 0.0 && (*cosine > 0.0 || rows.two_sided[row] && *cosine < 0.0);
        let (direction, density) = match drawn.density {
            Density::Along(direction, density) => (direction, density),
            _ if !shines => return None,
            Density::PerSolidAngle(density) => (sight.direction, density),
            Density::PerArea { area, probability } => (sight.direction, per_area / area * probability),
        };
        let place = surface.place(rows.instance[row], drawn.primitive, time).into();
        let coverage = self.coverage(self.instances.view().material[rows.instance[row] as usize], &place);
        let radiance = self.color(rows.radiance[row], &place) * coverage;
        let target = offset_origin(surface, -direction);
        // So far that the ray's end is off the surface by twice its error.
        let slope = (direction.dot(surface.geometric_normal).abs()).max(f32::EPSILON);
        let distance = (squared.sqrt() * (1.0 - f32::EPSILON) - 2.0 * surface.error / slope).max(0.0);
        let pdf = sound(density as f32)? * drawn.probability;
        let is_lit = radiance != Vec3::ZERO;
        is_lit.then_some(LightSample { direction, distance, target, radiance, pdf, is_delta: false })
    }
}

/// A source of light that was drawn.
enum Source {
    /// An emitter, and the place on it.
    Emitter(Drawn, AreaSample),
    /// A light without extent.
    Light(LightSample),
}

/// A place of an emitter that was drawn.
#[derive(Clone, Copy, Default)]
struct Drawn {
    row: u32,
    primitive: u32,
    density: Density,
    /// How likely the emitter was.
    probability: f32,
}

/// With which density a place was drawn.
#[derive(Clone, Copy)]
enum Density {
    /// In a direction, per solid angle.
    Along(Vec3, f64),
    /// In its own direction, per solid angle.
    PerSolidAngle(f64),
    /// Evenly over an area in object space that was chosen with a probability.
    PerArea { area: f64, probability: f64 },
}

impl Default for Density {
    fn default() -> Density {
        Density::PerSolidAngle(0.0)
    }
}

/// A density that can be divided by.
#[inline(always)]
fn sound(density: f32) -> Option<f32> {
    (density > 0.0 && density < f32::INFINITY).then_some(density)
}
