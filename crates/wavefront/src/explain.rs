//! Explaining: the tree of rays that one sample's path is, with all that is known of every ray.
//!
//! The ordinary stages run on one ray at a time: the levels hold a single ray, and after each step what it sent is taken out of
//! the queues and waits here, with its parent's number. So nothing is told that does not happen in a picture. The light of all
//! contributions adds up to the pixel's, to the last unit.

use std::time::Instant;

use brewster_buffers::{MaterialKind, SceneBuffers};
use brewster_film::{Film, FilmError, Light, PixelOrder, Window};
use brewster_geometry::{Hit, Ray, RayByRay, RayMemory, surface};
use brewster_optics::basis::Basis;
use brewster_optics::dispersion::PathWavelength;
use brewster_optics::fresnel::{FresnelModel, Reflectance, dielectric_cosine_form};
use brewster_optics::microfacet::{Ggx, RoughDielectric};
use brewster_optics::principled::{CLEARCOAT_IOR, Principled};
use brewster_optics::refraction;
use glam::Vec3;

use crate::attribution::{Attribution, Journal};
use crate::batch::Batch;
use crate::context::Context;
use crate::integrator::{begin, end, step};
use crate::media::Medium;
use crate::policy::Policy;
use crate::queues::{
    Contribution, ContributionQueue, End, OnCoated, OnDielectric, OnMetal, OnPrincipled, PathRay, PathRayColumns,
    RaySource, ShadowQueue, ShadowRay, SurfaceHit,
};
use crate::render::{Unsupported, check_integrator};
use crate::stages::scatter::{Conductor, Scatter, sides};
use crate::stages::shade::facing_normals;
use crate::stages::{Arrival, ShadowScratch, arrive, settle, shadow};
use crate::stats::{Counts, Recorder};

/// Rays of a tree that are followed at most.
pub const MOST_RAYS: usize = 1 << 16;

/// Explains samples of a scene's picture, one after the other.
#[derive(Debug)]
pub struct Explainer<'a> {
    context: Context<'a>,
    batch: Batch,
}

/// The path of one sample: a tree of rays, every ray behind the one that sent it.
#[derive(Clone, Debug)]
pub struct SampleTree {
    /// The number of the sample.
    pub number: u32,
    /// What the film got: the sum of all contributions.
    pub light: Light,
    /// Contributions that were no light.
    pub rejected: u32,
    /// The rays; the first is the camera's.
    pub rays: Vec<ExplainedRay>,
}

/// A ray, and what became of it.
#[derive(Clone, Debug)]
pub struct ExplainedRay {
    /// The number of the ray that sent it.
    pub parent: Option<usize>,
    /// Its depth.
    pub depth: u32,
    /// The queue that it waited in.
    pub source: RaySource,
    /// The ray as it set out.
    pub ray: PathRay,
    /// The medium that it runs through.
    pub medium: Filled,
    /// How far it comes, in meters; infinite if it meets nothing.
    pub distance: f32,
    /// What the medium leaves of light on the way: the Beer-Lambert factor. Where media scatter, by what the weight is multiplied:
    /// also over the odds of having come so far.
    pub transmittance: Vec3,
    /// What it meets.
    pub met: Met,
    /// Surfaces that it went through because they were not there.
    pub passed: u64,
    /// What became of rays that were not sent on.
    pub ends: Ends,
    /// The light that it brought, by itself.
    pub lights: Vec<Found>,
    /// The rays that its hit sent toward lights.
    pub shadows: Vec<Toward>,
}

/// What fills a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Filled {
    /// The medium.
    pub medium: Medium,
    /// Its index of refraction, at the path's wavelength if it has one.
    pub ior: f32,
}

/// What a ray meets.
#[derive(Clone, Debug)]
pub enum Met {
    /// Nothing: the background.
    Nothing,
    /// A boundary that is none, since a medium of higher priority fills the place.
    NoBoundary {
        /// The instance.
        instance: u32,
        /// Where, in world space.
        position: Vec3,
    },
    /// Nothing but the medium, which scattered it.
    Medium {
        /// Where, in world space.
        position: Vec3,
    },
    /// A surface.
    Surface(Surface),
}

/// A hit on a surface.
#[derive(Clone, Debug)]
pub struct Surface {
    /// The instance.
    pub instance: u32,
    /// The kind of material: of a mix the one that chance chose.
    pub kind: MaterialKind,
    /// Where, in world space.
    pub position: Vec3,
    /// Cosine of the angle between the ray, turned back, and the shading normal.
    pub cosine: f32,
    /// What is in front of the surface and behind it, on the sides of the geometric normal; nothing where no light goes through.
    pub media: Option<[Filled; 2]>,
    /// How a smooth surface of this kind splits light there; of rough ones for the mean plane. Nothing for surfaces that are no single
    /// boundary.
    pub fresnel: Option<Fresnel>,
    /// The same of each boundary, by its name, of surfaces that are several or other things beside: those of principled and coated
    /// materials, the outermost first.
    pub layers: Vec<(&'static str, Fresnel)>,
}

/// How a boundary splits light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fresnel {
    /// The model that the author chose.
    pub model: FresnelModel,
    /// GGX width; 0 where the surface is smooth.
    pub alpha: f32,
    /// The index on the side of the ray.
    pub eta_i: f32,
    /// The index on the other side, by channel; nothing for a metal given by its color.
    pub eta_t: Option<Vec3>,
    /// The imaginary part of a metal's index.
    pub k: Option<Vec3>,
    /// R_s by channel, by the Fresnel equations; nothing where there is no index.
    pub r_s: Option<Vec3>,
    /// R_p by channel.
    pub r_p: Option<Vec3>,
    /// What is reflected, by the author's model, with films and both faces of a sheet.
    pub f_r: Vec3,
    /// What is transmitted; 0 for a metal, which turns the rest to heat.
    pub f_t: Vec3,
    /// Whether everything is reflected because there is no angle of refraction.
    pub is_total: bool,
}

impl Fresnel {
    /// A boundary between two dielectrics that reflects `f_r`, by whatever model.
    pub(crate) fn of_boundary(model: FresnelModel, boundary: RoughDielectric, cos_i: f32, f_r: Vec3) -> Fresnel {
        let RoughDielectric { facets, eta_i, eta_t } = boundary;
        let cos_t = refraction::cos_t(cos_i, eta_i, eta_t);
        let exact = cos_t.map(|cos_t| dielectric_cosine_form(cos_i, cos_t, eta_i, eta_t));
        let Reflectance { s, p } = exact.unwrap_or(Reflectance { s: 1.0, p: 1.0 });
        Fresnel {
            model,
            alpha: if facets.is_smooth() { 0.0 } else { facets.alphas()[0] },
            eta_i,
            eta_t: Some(Vec3::splat(eta_t)),
            k: None,
            r_s: Some(Vec3::splat(s)),
            r_p: Some(Vec3::splat(p)),
            f_r,
            f_t: 1.0 - f_r,
            is_total: cos_t.is_none(),
        }
    }
}

/// What became of reflections and transmissions that were not sent on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Ends {
    /// Hits that reflect everything.
    pub totally_reflected: u64,
    /// Beyond the maximum depth.
    pub cut_by_depth: u64,
    /// Lighter than the threshold.
    pub below_threshold: u64,
    /// Ended by roulette.
    pub given_up: u64,
    /// Absorbed by the surface.
    pub absorbed: u64,
}

/// Light that was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    /// Where the light was.
    pub end: Option<End>,
    /// Radiance times weight before any clamp.
    pub radiance: Vec3,
    /// What the film got; nothing if it was no light.
    pub light: Option<Light>,
}

/// A ray toward a light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Toward {
    /// What it was sent to.
    pub source: LightSource,
    /// How far it goes.
    pub distance: f32,
    /// What it would bring, nothing in between.
    pub sent: Vec3,
    /// What it brought; nothing if something stands in between.
    pub found: Option<Found>,
}

/// What a shadow ray was sent to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightSource {
    /// A row of the lights without extent.
    Light(u32),
    /// An instance that shines.
    Emitter(u32),
    /// The background.
    Background,
}

/// Why a sample cannot be explained.
#[derive(Debug)]
pub enum ExplainError {
    /// The scene cannot be rendered.
    Unsupported(Unsupported),
    /// The pixel is not in the picture, whose width and height these are.
    Outside([u32; 2]),
    /// The sample is none of so many.
    NoSuchSample(u32),
    /// The tree has more than [`MOST_RAYS`] rays.
    TooManyRays,
    /// The picture is too large.
    Film(FilmError),
}

impl std::fmt::Display for ExplainError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            ExplainError::Unsupported(error) => error.fmt(f),
            ExplainError::Outside([width, height]) => {
                write!(f, "the picture is {width} x {height}: columns are 0 to {}, rows 0 to {}", width - 1, height - 1)
            }
            ExplainError::NoSuchSample(samples) => {
                write!(f, "a pixel has {samples} samples, numbered from 0 to {}", samples - 1)
            }
            ExplainError::TooManyRays => {
                write!(f, "the sample's tree has more than {MOST_RAYS} rays: a lower maximum depth makes it smaller")
            }
            ExplainError::Film(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for ExplainError {}

/// A ray that waits to be followed.
struct Waiting {
    parent: Option<usize>,
    depth: u32,
    source: RaySource,
    ray: PathRay,
}

impl<'a> Explainer<'a> {
    /// Makes ready to explain the picture of a camera, by its number.
    ///
    /// # Errors
    ///
    /// The scene cannot be rendered.
    pub fn new(scene: &'a SceneBuffers, camera: usize) -> Result<Explainer<'a>, ExplainError> {
        let found = scene.cameras.get(camera).ok_or(Unsupported::Camera(scene.cameras.len()));
        let camera = found.map_err(ExplainError::Unsupported)?;
        check_integrator(scene, camera).map_err(ExplainError::Unsupported)?;
        let context = Context::new(scene, camera, Policy { batch: 1, capacity: 1, ..Policy::default() });
        let depth = scene.settings.max_depth;
        let mut batch = Batch::new(depth, 1, Recorder::new(depth, 0, Instant::now(), false));
        batch.attribution.journal = Some(Box::default());
        Ok(Explainer { context, batch })
    }

    /// The tree of a pixel's sample.
    ///
    /// # Errors
    ///
    /// There is no such pixel or sample.
    pub fn sample(&mut self, [x, y]: [u32; 2], number: u32) -> Result<SampleTree, ExplainError> {
        let settings = &self.context.scene.settings;
        let [width, height] = settings.resolution.to_array();
        if x >= width || y >= height {
            return Err(ExplainError::Outside([width, height]));
        }
        if number >= settings.samples {
            return Err(ExplainError::NoSuchSample(settings.samples));
        }
        let window = Window { x, y, width: 1, height: 1 };
        let mut film = Film::new(PixelOrder::new(width, height, Some(window)).map_err(ExplainError::Film)?);
        let rays = self.follow(number, &mut film).ok_or(ExplainError::TooManyRays)?;
        let pixel = film.pixels().get(0);
        Ok(SampleTree { number, light: pixel.color, rejected: pixel.rejected, rays })
    }

    fn follow(&mut self, number: u32, film: &mut Film) -> Option<Vec<ExplainedRay>> {
        let Explainer { context, batch } = self;
        let mut tile = film.tile_mut();
        begin(context, number..number + 1, batch, &tile);
        let mut taken = PathRayColumns::new();
        batch.levels.primary.take(1, &mut taken);
        let (ray, mut rays) = (taken.get(0), Vec::new());
        let mut waiting = vec![Waiting { parent: None, depth: 0, source: RaySource::Primary, ray }];
        while let Some(next) = waiting.pop() {
            if rays.len() == MOST_RAYS {
                return None;
            }
            let before = counts(batch, &next);
            journal(batch).clear();
            let (here, _) = batch.levels.at(next.depth);
            match next.source {
                RaySource::Primary => batch.levels.primary.push(next.ray),
                RaySource::Reflection => here.reflection.push(next.ray),
                RaySource::Transmission => here.transmission.push(next.ray),
                RaySource::Merged => unreachable!("queues wait apart"),
            }
            step(context, batch, &mut tile).expect("a ray waits");
            let (parent, depth) = (Some(rays.len()), next.depth);
            let (here, onward) = batch.levels.at(depth);
            let mut take = |queue: &mut dyn FnMut(&mut PathRayColumns), depth, source| {
                queue(&mut taken);
                waiting.extend((0..taken.len()).map(|row| Waiting { parent, depth, source, ray: taken.get(row) }));
            };
            take(&mut |taken| here.transmission.take(1, taken), depth, RaySource::Transmission);
            if let Some(onward) = onward {
                take(&mut |taken| onward.transmission.take(1, taken), depth + 1, RaySource::Transmission);
                take(&mut |taken| onward.reflection.take(1, taken), depth + 1, RaySource::Reflection);
            }
            let wavelength = (waiting.iter().rev().find(|child| child.parent == parent))
                .map_or(next.ray.wavelength, |child| child.ray.wavelength);
            let counted = (before, counts(batch, &next));
            rays.push(explained(context, batch, next, counted, wavelength));
        }
        end(batch, &mut tile);
        Some(rays)
    }
}

fn counts(batch: &Batch, waiting: &Waiting) -> Counts {
    batch.recorder.stats.depths[waiting.depth as usize].counts[waiting.source as usize]
}

fn journal(batch: &mut Batch) -> &mut Journal {
    batch.attribution.journal.as_mut().expect("an explainer keeps a journal")
}

/// What the last step did with its one ray.
fn explained(
    context: &Context<'_>,
    batch: &mut Batch,
    waiting: Waiting,
    (before, after): (Counts, Counts),
    wavelength: PathWavelength,
) -> ExplainedRay {
    let Waiting { parent, depth, source, ray } = waiting;
    let journal = std::mem::take(journal(batch));
    let dielectrics = context.scene.materials.dielectric.view();
    let (hit, medium) = (batch.hits.get(0), batch.stacks.filling(ray.media));
    let there = batch.rays.get(0);
    let transmittance = if context.has_fog {
        Vec3::select(ray.weight.cmpgt(Vec3::ZERO), there.weight / ray.weight, Vec3::ONE)
    } else {
        medium.transmittance(hit.t, &dielectrics)
    };
    let shadows = journal.shadows.iter().map(|shadow| toward(context, batch, shadow, depth)).collect();
    let by_itself = journal.lights.iter().filter(|(found, _)| found.trail.ended() != Some(End::Light));
    ExplainedRay {
        parent,
        depth,
        source,
        ray,
        medium: Filled { medium, ior: medium.ior_at(ray.wavelength, &dielectrics) },
        distance: hit.t,
        transmittance,
        met: met(context, batch, (&PathRay { wavelength, media: there.media, ..ray }, &hit), depth),
        passed: after.passed - before.passed,
        ends: Ends {
            totally_reflected: after.totally_reflected - before.totally_reflected,
            cut_by_depth: after.cut_by_depth - before.cut_by_depth,
            below_threshold: after.below_threshold - before.below_threshold,
            given_up: after.given_up - before.given_up,
            absorbed: after.absorbed - before.absorbed,
        },
        lights: by_itself.map(|(found, light)| Found::new(found, *light)).collect(),
        shadows,
    }
}

impl Found {
    fn new(contribution: &Contribution, light: Option<Light>) -> Found {
        Found { end: contribution.trail.ended(), radiance: contribution.radiance, light }
    }
}

/// What a ray of a depth met, and how that splits light.
fn met(context: &Context<'_>, batch: &mut Batch, (ray, hit): (&PathRay, &Hit), depth: u32) -> Met {
    let Batch { samples, stacks, .. } = batch;
    let stream = || samples.view().stream(&context.sampler, ray.sample, ray.branch);
    let time = samples.view().time(context, ray.sample);
    let found = (hit, |ray: &_| surface(&context.geometry, ray, hit));
    let (kind, hit) = match arrive(context, (ray, 0, time), found, depth, stream, stacks) {
        Arrival::Nothing => return Met::Nothing,
        Arrival::NoBoundary(_) => {
            let position = surface(&context.geometry, &ray.ray(time), hit).position;
            return Met::NoBoundary { instance: hit.instance, position };
        }
        Arrival::Medium(scattering) => return Met::Medium { position: scattering.position },
        Arrival::Surface(kind, hit) => (kind, hit),
    };
    let direction = ray.direction();
    let (_, normal) = facing_normals(&hit, direction);
    let cosine = (-direction.dot(normal)).clamp(0.0, 1.0);
    let dielectrics = context.scene.materials.dielectric.view();
    let filled = |medium: Medium| Filled { medium, ior: medium.ior_at(ray.wavelength, &dielectrics) };
    let mut layers = Vec::new();
    let (media, fresnel) = match kind {
        MaterialKind::Dielectric => {
            let sides = sides::<OnDielectric>(context, ray, &hit, normal, stacks);
            let surface = OnDielectric::surface(context, &hit, &sides);
            let fresnel = surface.fresnel_at(cosine);
            (Some(sides.media.map(|media| filled(stacks.filling(media)))), Some(fresnel))
        }
        MaterialKind::Metal => {
            let sides = sides::<OnMetal>(context, ray, &hit, normal, stacks);
            (None, Some(OnMetal::surface(context, &hit, &sides).fresnel_at(cosine)))
        }
        MaterialKind::Principled => {
            let sides = sides::<OnPrincipled>(context, ray, &hit, normal, stacks);
            let view = Basis::around(normal).to_local(-direction);
            layers = principled_layers(&OnPrincipled::surface(context, &hit, &sides), view, cosine);
            (Some(sides.media.map(|media| filled(stacks.filling(media)))), None)
        }
        MaterialKind::Coated => {
            let eta_i =
                sides::<OnCoated>(context, ray, &hit, normal, stacks).filling[0].ior_at(ray.wavelength, &dielectrics);
            layers = coated_layers(context, &hit, eta_i, cosine);
            (None, None)
        }
        _ => (None, None),
    };
    Met::Surface(Surface { instance: hit.instance, kind, position: hit.point.position, cosine, media, fresnel, layers })
}

/// The clearcoat of a principled surface, and the boundary that light comes through. The clearcoat's index is against vacuum,
/// as glTF has it; `F_r` has its weight, and its cosine is that to its own normal.
fn principled_layers(surface: &Principled, view: Vec3, cosine: f32) -> Vec<(&'static str, Fresnel)> {
    let coat = surface.clearcoat(view).map(|(facets, cosine, reflected)| {
        let boundary = RoughDielectric { facets, eta_i: 1.0, eta_t: CLEARCOAT_IOR };
        ("clearcoat", Fresnel::of_boundary(FresnelModel::Schlick, boundary, cosine, Vec3::splat(reflected)))
    });
    let glass = surface.boundary(cosine).map(|(boundary, reflected)| {
        ("transmission", Fresnel::of_boundary(FresnelModel::Exact, boundary, cosine, reflected))
    });
    coat.into_iter().chain(glass).collect()
}

/// A coat, and the metal below it as it is seen from within.
fn coated_layers(context: &Context<'_>, hit: &SurfaceHit, eta_i: f32, cosine: f32) -> Vec<(&'static str, Fresnel)> {
    let coated = context.scene.materials.coated.get(hit.material as usize);
    // A coat is no thinner than what lies above it.
    let eta_t = coated.ior.max(eta_i);
    let boundary = RoughDielectric { facets: Ggx::isotropic(coated.alpha), eta_i, eta_t };
    let reflected = FresnelModel::Exact.dielectric(cosine, eta_i, eta_t).reflectance;
    let coat = Fresnel::of_boundary(FresnelModel::Exact, boundary, cosine, Vec3::splat(reflected));
    let metal = (coated.base == MaterialKind::Metal).then(|| {
        let below = refraction::cos_t(cosine, eta_i, eta_t).unwrap_or(0.0);
        ("metal below", Conductor::new(context, coated.base_row as usize, hit, coated.ior).fresnel_at(below))
    });
    [("coat", coat)].into_iter().chain(metal).collect()
}

/// Sends a shadow ray once more, by itself, and tells what it was sent to.
fn toward(context: &Context<'_>, batch: &mut Batch, ray: &ShadowRay, depth: u32) -> Toward {
    let (mut queue, mut lights) = (ShadowQueue::new(), ContributionQueue::new());
    queue.push(*ray);
    let mut samples = batch.samples.clone();
    let (mut scratch, mut counts) = (ShadowScratch::default(), Counts::default());
    shadow(context, &mut queue, &mut batch.stacks, &mut scratch, &mut lights, samples.view_mut(), &mut counts);
    let found = (0..lights.len()).next().map(|row| {
        let contribution = lights.get(row);
        let sample = || samples.get(contribution.sample as usize);
        let mut attribution = Attribution::default();
        let light = settle(context, depth, &contribution, sample, &mut attribution, &mut counts);
        Found::new(&contribution, light)
    });
    Toward {
        source: source_of(context, ray, samples.view().time(context, ray.sample)),
        distance: ray.distance,
        sent: ray.contribution,
        found,
    }
}

/// What a shadow ray was sent to: the light in its direction, or the surface at its end, or the background.
fn source_of(context: &Context<'_>, shadow: &ShadowRay, time: f32) -> LightSource {
    let (scene, ray) = (context.scene, shadow.ray(time));
    let is_toward = |row: &usize| {
        let seen = scene.light_at(*row, time).illuminate(ray.origin);
        let far = shadow.distance == f32::INFINITY;
        let ends_there = far == (seen.distance == f32::INFINITY) && (far || seen.distance < 1.001 * shadow.distance);
        ends_there && seen.direction.distance(ray.direction) < 1e-5
    };
    if let Some(row) = (0..scene.lights.len()).find(is_toward) {
        return LightSource::Light(row as u32);
    }
    if shadow.distance == f32::INFINITY {
        return LightSource::Background;
    }
    let mut memory = RayMemory::default();
    let beyond = Ray { origin: ray.at(shadow.distance), direction: ray.direction, time };
    let hit = RayByRay::new(context.geometry, context.policy.level, &mut memory).closest_hit(&beyond);
    if hit.is_miss() { LightSource::Background } else { LightSource::Emitter(hit.instance) }
}
