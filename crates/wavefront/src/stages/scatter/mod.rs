//! Scattering: what the path integrator does where a ray meets a material, one stage a kind.
//!
//! All kinds take the same steps, [`scatter`]; a kind says by its [`Surface`] how a surface of it scatters light.

mod dielectric;
mod lambert;
mod metal;
mod rough_diffuse;

use brewster_buffers::{LightSample, SceneBuffers};
use brewster_film::FilmTile;
use brewster_geometry::{Ray, offset_origin};
use brewster_optics::basis::Basis;
use brewster_optics::lobe::{LobeSample, LobeSplit, LobeValue, power_heuristic};
use glam::{Vec2, Vec3};

use super::shade::facing_normals;
use crate::context::Context;
use crate::media::{MediaId, MediaStacks, Medium};
use crate::queues::{DepthQueues, HitsOf, PathRay, PathRaysView, ShadowQueue, ShadowRay, SurfaceHit};
use crate::random::{Decision, PixelKey, Stream};
use crate::stats::Counts;

/// A kind of material, as the path integrator sees it.
pub trait Scatter {
    /// A surface of this kind at one hit.
    type Surface: Surface;

    /// Whether surfaces of this kind let light through, so that there are media behind them.
    const TRANSMITS: bool;

    /// The surface at a hit.
    fn surface(context: &Context<'_>, hit: &SurfaceHit, sides: &Sides) -> Self::Surface;
}

/// How one point of a surface scatters light, in the frame of [`lobe`](brewster_optics::lobe).
pub trait Surface {
    /// Whether it scatters into single directions only, which no light can be sampled in.
    fn is_smooth(&self) -> bool;

    /// What comes from one direction and goes to another. Not asked where the surface is smooth.
    fn evaluate(&self, view: Vec3, light: Vec3) -> LobeValue;

    /// Where the path goes on.
    fn sample(&self, view: Vec3, u: Vec2) -> LobeSplit;
}

/// The media in front of a surface and behind it.
#[derive(Clone, Copy, Debug)]
pub struct Sides {
    /// The sets of media, on the sides of the geometric normal.
    pub media: [MediaId; 2],
    /// What fills them, on the sides of the shading normal: that of the viewer and the other.
    pub filling: [Medium; 2],
}

/// Where what scatters goes: the queues of a step, and the step's place in the path.
#[derive(Debug)]
pub struct Onward<'a> {
    /// The rays' depth.
    pub depth: u32,
    /// The queues of the next depth; none at the maximum depth.
    pub next: Option<&'a mut DepthQueues>,
    /// Rays toward lights.
    pub shadows: &'a mut ShadowQueue,
    /// The sets of media.
    pub stacks: &'a mut MediaStacks,
}

/// A ray's arrival at a surface: what does not depend on the kind.
struct Arrival<'a> {
    context: &'a Context<'a>,
    ray: PathRay,
    hit: SurfaceHit,
    depth: u32,
    stream: Stream,
    frame: Basis,
    /// The geometric normal on the side that the ray came from.
    geometric: Vec3,
    media: [MediaId; 2],
    view: Vec3,
}

/// Below the maximum depth, for each hit: a shadow ray toward a light and one toward the background, and a ray on, into one
/// queue by chance or, above the split depth, into both.
///
/// Light that two techniques can find is shared between them by the power heuristic. Of rays whose weight has become small
/// some are given up and the others weigh more.
///
/// Reads: rays, hits, the kind's materials, textures, lights, background. Writes: shadow rays, the next depth's reflection
/// and transmission queues, and the media stacks.
pub fn scatter<Kind: Scatter>(
    context: &Context<'_>,
    rays: PathRaysView<'_>,
    hits: &HitsOf<'_, Kind>,
    tile: &FilmTile<'_>,
    onward: &mut Onward<'_>,
    counts: &mut Counts,
) {
    let hits = hits.columns();
    let Some(next) = onward.next.as_deref_mut() else {
        counts.cut_by_depth += hits.len() as u64;
        return;
    };
    for row in 0..hits.len() {
        let hit = hits.get(row);
        let ray = rays.get(hit.ray as usize);
        let direction = ray.ray().direction;
        let (geometric, normal) = facing_normals(&hit, direction);
        let sides = sides::<Kind>(context, &ray, &hit, onward.stacks);
        let surface = Kind::surface(context, &hit, &sides);
        let frame = Basis::around(normal);
        let (x, y) = tile.pixel(ray.pixel);
        let stream = context.sampler.stream(PixelKey::new(x, y), ray.sample, ray.branch);
        let view = frame.to_local(-direction);
        let arrival =
            Arrival { context, ray, hit, depth: onward.depth, stream, frame, geometric, media: sides.media, view };
        if !surface.is_smooth() {
            arrival.toward_lights(&surface, onward.stacks, onward.shadows);
        }
        arrival.onward(&surface, next, counts);
    }
}

/// The media at a hit.
fn sides<Kind: Scatter>(context: &Context<'_>, ray: &PathRay, hit: &SurfaceHit, stacks: &mut MediaStacks) -> Sides {
    let before = stacks.filling(ray.media);
    if !Kind::TRANSMITS {
        return Sides { media: [ray.media; 2], filling: [before; 2] };
    }
    let dielectrics = context.scene.materials.dielectric.view();
    let direction = ray.ray().direction;
    let inward = |normal: Vec3| direction.dot(normal) < 0.0;
    let geometric = inward(hit.point.geometric_normal);
    if dielectrics.thin[hit.material as usize] {
        return Sides { media: [ray.media; 2], filling: [before; 2] };
    }
    let boundary = stacks.boundary(ray.media, Medium(hit.material), geometric, &dielectrics);
    let mut filling = [boundary.filling_before, boundary.filling_behind];
    if inward(hit.point.shading_normal) != geometric {
        filling.reverse();
    }
    Sides { media: [ray.media, boundary.behind], filling }
}

impl Arrival<'_> {
    /// Samples a light and the background.
    #[inline(always)]
    fn toward_lights(&self, surface: &impl Surface, stacks: &MediaStacks, shadows: &mut ShadowQueue) {
        let Arrival { context, depth, stream, .. } = *self;
        let (scene, sampler) = (context.scene, &context.sampler);
        let place = Decision::LightPoint.at(depth);
        if !scene.lights.is_empty() {
            let light = sample_light(scene, self.hit.point.position, sampler.one(stream, Decision::Light.at(depth)));
            self.toward(Some(light), surface, stacks, shadows);
        }
        if !scene.background.is_black() {
            let light = scene.background.sample(sampler.pair(stream, place.repeat(1)));
            self.toward(light, surface, stacks, shadows);
        }
    }

    /// Sends a shadow ray toward a light, unless the surface does not scatter from there.
    #[inline(always)]
    fn toward(
        &self,
        light: Option<LightSample>,
        surface: &impl Surface,
        stacks: &MediaStacks,
        shadows: &mut ShadowQueue,
    ) {
        let Some(light) = light else { return };
        let toward = self.frame.to_local(light.direction);
        if !self.is_on_its_side(light.direction, toward) {
            return;
        }
        let value = surface.evaluate(self.view, toward);
        let scattered = if self.splits() { value.pdf } else { value.chosen_pdf() };
        let share = if light.is_delta { 1.0 } else { power_heuristic(light.pdf, scattered) };
        let contribution = self.ray.weight * value.f_cos * light.radiance * (share / light.pdf);
        if contribution == Vec3::ZERO {
            return;
        }
        let media = self.media_of(light.direction);
        let origin = offset_origin(&self.hit.point, light.direction);
        shadows.push(ShadowRay {
            origin_x: origin.x,
            origin_y: origin.y,
            origin_z: origin.z,
            direction_x: light.direction.x,
            direction_y: light.direction.y,
            direction_z: light.direction.z,
            distance: light.distance,
            contribution: contribution * self.context.radiance_scale(stacks, media),
            pixel: self.ray.pixel,
            media,
        });
    }

    /// Sends the path on.
    #[inline(always)]
    fn onward(&self, surface: &impl Surface, next: &mut DepthQueues, counts: &mut Counts) {
        let Arrival { context, depth, stream, .. } = *self;
        let split =
            surface.sample(self.view, Vec2::from_array(context.sampler.pair(stream, Decision::Direction.at(depth))));
        if self.splits() && split.transmission.is_some() {
            let branch = self.ray.branch.wrapping_mul(2);
            self.send(split.reflection, branch, next, counts);
            self.send(split.transmission, branch.wrapping_add(1), next, counts);
        } else {
            // Where nothing can be transmitted, chance has no say.
            let choice =
                if split.reflectance < 1.0 { context.sampler.one(stream, Decision::Lobe.at(depth)) } else { 0.0 };
            self.send(split.choose(choice), self.ray.branch, next, counts);
        }
    }

    /// Puts a ray into its queue, unless it is absorbed or given up.
    #[inline(always)]
    fn send(&self, sample: Option<LobeSample>, branch: u32, next: &mut DepthQueues, counts: &mut Counts) {
        let Some(sample) = sample else { return };
        let direction = self.frame.to_world(sample.direction);
        if !self.is_on_its_side(direction, sample.direction) {
            return;
        }
        let mut weight = self.ray.weight * sample.weight;
        let largest = weight.max_element();
        if largest <= 0.0 {
            return;
        }
        if largest < ROULETTE_WEIGHT && self.context.scene.settings.roulette {
            let survival = largest / ROULETTE_WEIGHT;
            let dimension = Decision::Roulette.at(self.depth).repeat(u32::from(sample.is_transmission()));
            if self.context.sampler.one(self.stream, dimension) >= survival {
                counts.given_up += 1;
                return;
            }
            weight /= survival;
        }
        let origin = offset_origin(&self.hit.point, direction);
        let ray = self.ray.along(Ray { origin, direction });
        let ray = PathRay { weight, pdf: sample.pdf, media: self.media_of(direction), branch, ..ray };
        if sample.is_transmission() {
            counts.transmissions += 1;
            next.transmission.push(ray);
        } else {
            counts.reflections += 1;
            next.reflection.push(ray);
        }
    }

    /// Whether the path sends a ray into each queue here.
    #[inline(always)]
    fn splits(&self) -> bool {
        self.depth < self.context.scene.settings.split_depth
    }

    /// Whether the geometric normal and the shading normal agree on which side of the surface a direction points to.
    #[inline(always)]
    fn is_on_its_side(&self, direction: Vec3, local: Vec3) -> bool {
        (direction.dot(self.geometric) > 0.0) == (local.z > 0.0)
    }

    /// The media around a ray that leaves the surface.
    #[inline(always)]
    fn media_of(&self, direction: Vec3) -> MediaId {
        self.media[usize::from(direction.dot(self.geometric) < 0.0)]
    }
}

/// Shadow rays that a hit sends at most: toward a light and toward the background.
pub const SHADOW_RAYS: usize = 2;

/// Rays whose largest weight is at least this are all followed; of lighter ones as many as keep their sum, each with this
/// weight.
const ROULETTE_WEIGHT: f32 = 0.25;

/// One of the lights without extent, all with the same probability.
#[inline(always)]
fn sample_light(scene: &SceneBuffers, point: Vec3, choice: f32) -> LightSample {
    let count = scene.lights.len();
    let light = scene.lights.get(((choice * count as f32) as usize).min(count - 1));
    let seen = light.illuminate(point);
    LightSample {
        direction: seen.direction,
        distance: seen.distance,
        target: light.position,
        radiance: seen.irradiance,
        pdf: 1.0 / count as f32,
        is_delta: true,
    }
}
