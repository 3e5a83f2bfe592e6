//! Scattering: what the path integrator does where a ray meets a material, one stage a kind.
//!
//! All kinds take the same steps, [`scatter`]; a kind says by its [`Surface`] how a surface of it scatters light.

mod coated;
mod dielectric;
mod lambert;
mod medium;
mod metal;
mod principled;
mod rough_diffuse;

pub(crate) use metal::Conductor;

use brewster_buffers::{DetailId, Integrator, LightSample, MaterialKind};
use brewster_geometry::{Hit, SurfacePoint, offset_origin};
use brewster_optics::basis::Basis;
use brewster_optics::dispersion::PathWavelength;
use brewster_optics::lobe::{DELTA, LobeSample, LobeSplit, LobeValue, power_heuristic};
use glam::{Vec2, Vec3};

pub(crate) use self::medium::scatter_in_medium;
pub use self::medium::scatter_medium;
use super::shade::facing_normals;
use super::{DrawsView, Numbers, Outlet, Points, Queues};
use crate::albedo::Albedos;
use crate::context::Context;
use crate::ledger::Ledger;
use crate::media::{MediaId, MediaStacks, Medium};
use crate::queues::{
    Contribution, End, Event, HitsOf, OnDielectric, OnPrincipled, PathRay, PathRaysView, SamplesView, ShadowRay,
    SurfaceHit, SurfaceHitsView,
};
use crate::random::{Decision, Stream};
use crate::stats::Counts;

/// A kind of material, as the path integrator sees it.
pub trait Scatter {
    /// A surface of this kind at one hit.
    type Surface: Surface;

    /// Whether surfaces of this kind may let light through, so that there may be media behind them.
    const TRANSMITS: bool;

    /// Whether some of the hits on surfaces of this kind, as likely as not, are asked what they scatter from lights: those on surfaces
    /// that are not smooth are.
    #[inline(always)]
    fn asks_lights(_: &Context<'_>, _: SurfaceHitsView<'_>) -> bool {
        true
    }

    /// The medium inside of a surface of a row of this kind.
    #[inline(always)]
    fn medium(_: &Context<'_>, _row: usize) -> Option<Medium> {
        None
    }

    /// The surface at a hit.
    fn surface(context: &Context<'_>, hit: &SurfaceHit, sides: &Sides) -> Self::Surface;

    /// The part of the energy that the surface is expected to send on, by theory; the rest is absorbed. `cosine` is that of
    /// the view. None where theory does not know: there the surface is [asked](Surface::estimate).
    fn albedo(albedos: &Albedos, surface: &Self::Surface, hit: &SurfaceHit, sides: &Sides, cosine: f32)
    -> Option<Vec3>;
}

/// How one point of a surface scatters light, in the frame of [`lobe`](brewster_optics::lobe).
pub trait Surface {
    /// Whether it scatters into single directions only, which no light can be sampled in.
    fn is_smooth(&self) -> bool;

    /// What comes from one direction and goes to another. Not asked where the surface is smooth.
    fn evaluate(&self, view: Vec3, light: Vec3) -> LobeValue;

    /// Whether light may come through.
    fn transmits(&self) -> bool;

    /// What is left of light that goes straight on, as through a smooth sheet.
    #[inline(always)]
    fn straight(&self, _view: Vec3) -> Vec3 {
        Vec3::ZERO
    }

    /// An unbiased estimate of the part of the energy that it sends on, by its values and three numbers that its sampler does not see.
    /// None where [`Scatter::albedo`] always knows.
    #[inline(always)]
    fn estimate(&self, _view: Vec3, _choice: f32, _u: Vec2) -> Option<Vec3> {
        None
    }

    /// Both ways on, by two numbers for the direction and one for the lobe.
    fn split(&self, view: Vec3, u: Vec2, lobe: f32) -> LobeSplit;

    /// One way on, by the same numbers.
    #[inline(always)]
    fn choose(&self, view: Vec3, u: Vec2, lobe: f32) -> Option<LobeSample> {
        self.split(view, u, lobe).choose(lobe)
    }
}

/// The media in front of a surface and behind it.
#[derive(Clone, Copy, Debug)]
pub struct Sides {
    /// The sets of media, on the sides of the geometric normal.
    pub media: [MediaId; 2],
    /// What fills them, on the sides of the shading normal: that of the viewer and the other.
    pub filling: [Medium; 2],
    /// The path's wavelength.
    pub wavelength: PathWavelength,
    /// The shading normal on the viewer's side, around which the frame stands.
    pub normal: Vec3,
}

/// Where what scatters goes: the queues of a step, and the step's place in the path.
#[derive(Debug)]
pub struct Onward<'a> {
    /// The rays' depth.
    pub depth: u32,
    /// The queues. What is no number becomes a contribution, and is told to be none.
    pub queues: Queues<'a>,
    /// The sets of media.
    pub stacks: &'a mut MediaStacks,
}

/// A ray's arrival at a surface: what does not depend on the kind.
struct Arrival<'a, N> {
    context: &'a Context<'a>,
    /// The ray, its wavelength drawn if the surface disperses.
    ray: PathRay,
    /// Its weight before.
    arrived: Vec3,
    hit: SurfaceHit,
    depth: u32,
    numbers: N,
    frame: Basis,
    /// The geometric normal on the side that the ray came from.
    geometric: Vec3,
    media: [MediaId; 2],
    view: Vec3,
    /// Whether the surface lets light through.
    transmits: bool,
}

/// Below the maximum depth, for each hit: a shadow ray toward a light and one toward the background, and a ray on, into one
/// queue by chance or, above the split depth, into both.
///
/// Light that two techniques can find is shared between them by the power heuristic. Of rays whose weight has become small
/// some are given up and the others weigh more.
///
/// Reads: rays, hits, random numbers, samples, the kind's materials, textures, lights, background. Writes: shadow rays, the next depth's reflection
/// and transmission queues, the media stacks, and contributions of what is no number.
pub fn scatter<Kind: Scatter>(
    context: &Context<'_>,
    rays: PathRaysView<'_>,
    hits: &HitsOf<'_, Kind>,
    draws: DrawsView<'_>,
    samples: SamplesView<'_>,
    onward: &mut Onward<'_>,
    counts: &mut Counts,
) {
    let hits = hits.columns();
    if onward.queues.next.is_none() {
        return hits.rays().iter().for_each(|&ray| cut(context, rays.weight[ray as usize], counts));
    }
    for row in 0..hits.len() {
        let hit = hits.get(row);
        let ray = rays.get(hit.ray as usize);
        let stream = |branch| samples.stream(&context.sampler, ray.sample, branch);
        let arrived = (ray, hit, onward.depth);
        scatter_at::<Kind>(context, arrived, draws.get(row), stream, &mut onward.queues, onward.stacks, counts);
    }
}

/// The points of hits that lights are drawn for beforehand.
pub(crate) fn lit<'a, Kind: Scatter>(context: &Context<'_>, hits: &HitsOf<'a, Kind>) -> Option<Points<'a>> {
    Kind::asks_lights(context, hits.columns()).then(|| hits.columns().points())
}

/// Notes a ray that ends at the maximum depth.
#[inline(always)]
pub(crate) fn cut(context: &Context<'_>, weight: Vec3, counts: &mut Counts) {
    counts.cut_by_depth += 1;
    if context.albedos.is_some() {
        counts.ledger.cut.add(weight);
    }
}

/// One hit of a ray of a depth; `stream` has the numbers of the path's branches.
#[inline(always)]
pub(crate) fn scatter_at<Kind: Scatter>(
    context: &Context<'_>,
    (mut ray, hit, depth): (PathRay, SurfaceHit, u32),
    numbers: impl Numbers,
    stream: impl Fn(u32) -> Stream,
    outlet: &mut impl Outlet,
    stacks: &mut MediaStacks,
    counts: &mut Counts,
) {
    let direction = ray.direction();
    let (geometric, normal) = facing_normals(&hit, direction);
    let mut sides = sides::<Kind>(context, &ray, &hit, normal, stacks);
    let arrived = ray.weight;
    if Kind::TRANSMITS {
        disperse(context, &mut ray, sides.filling, || stream(1));
    }
    sides.wavelength = ray.wavelength;
    let surface = Kind::surface(context, &hit, &sides);
    let frame = Basis::around(normal);
    let view = frame.to_local(-direction);
    let arrival = Arrival {
        context,
        ray,
        arrived,
        hit,
        depth,
        numbers,
        frame,
        geometric,
        media: sides.media,
        view,
        transmits: surface.transmits(),
    };
    if !surface.is_smooth() {
        arrival.toward_lights(&surface, stacks, outlet);
    }
    let sent = arrival.onward(&surface, outlet, counts);
    if let Some(albedos) = &context.albedos {
        let albedo = Kind::albedo(albedos, &surface, &hit, &sides, view.z)
            .or_else(|| asked(context, &surface, view, stream(ray.branch), depth));
        arrival.book(albedo, sent, &mut counts.ledger);
    }
}

/// What one of [`ASKED`] hits is estimated to send on. None for the others.
#[inline(always)]
fn asked(context: &Context<'_>, surface: &impl Surface, view: Vec3, stream: Stream, depth: u32) -> Option<Vec3> {
    let [ask, choice, x, y] = context.sampler.strewn(stream, Decision::Audit.at(depth));
    if ask < 1.0 / ASKED { surface.estimate(view, choice, Vec2::new(x, y)) } else { None }
}

/// What is left of a ray toward a light behind a surface that it meets: of a smooth sheet what goes straight on, of all others
/// nothing.
pub(crate) fn straight(
    context: &Context<'_>,
    ray: &ShadowRay,
    found: (&Hit, SurfacePoint, f32),
    filling: Medium,
) -> Vec3 {
    let (&Hit { instance, primitive, .. }, mut point, time) = found;
    let scene = context.scene;
    let material = scene.materials.rows.get(scene.instances.view().material[instance as usize].0 as usize);
    let direction = ray.direction();
    if material.detail != DetailId::NONE {
        let place = context.seen(point.place(instance, primitive, time));
        point.shading_normal = scene.bent_normal(material.detail, &place, &point, direction);
    }
    let hit = SurfaceHit { ray: 0, instance, primitive, material: material.row, point, time };
    let (_, normal) = facing_normals(&hit, direction);
    let sides = Sides { media: [ray.media; 2], filling: [filling; 2], wavelength: PathWavelength::NONE, normal };
    let view = Basis::around(normal).to_local(-direction);
    match material.kind {
        _ if scene.materials.medium(material).is_some() => Vec3::ZERO,
        MaterialKind::Principled => OnPrincipled::surface(context, &hit, &sides).straight(view),
        MaterialKind::Dielectric => OnDielectric::surface(context, &hit, &sides).straight(view),
        _ => Vec3::ZERO,
    }
}

/// By which factors the light differs that surfaces of two contexts send from one direction to another; `first` has the numbers of the
/// path's first branch.
pub(crate) fn ratio<Kind: Scatter>(
    contexts: [&Context<'_>; 2],
    (mut ray, hit): (PathRay, &SurfaceHit),
    toward: Vec3,
    first: impl FnOnce() -> Stream,
    stacks: &mut MediaStacks,
) -> Vec3 {
    let direction = ray.direction();
    let (_, normal) = facing_normals(hit, direction);
    let mut sides = sides::<Kind>(contexts[0], &ray, hit, normal, stacks);
    if Kind::TRANSMITS && contexts[0].scene.settings.integrator == Integrator::Path {
        disperse(contexts[0], &mut ray, sides.filling, first);
    }
    sides.wavelength = ray.wavelength;
    let frame = Basis::around(normal);
    let (view, toward) = (frame.to_local(-direction), frame.to_local(toward));
    let [first, second] = contexts.map(|context| {
        let surface = Kind::surface(context, hit, &sides);
        if !surface.is_smooth() {
            return surface.evaluate(view, toward).f_cos;
        }
        let LobeSplit { reflection, transmission, .. } = surface.split(view, Vec2::ZERO, 0.0);
        let way = if toward.z < 0.0 { transmission } else { reflection };
        way.map_or(Vec3::ZERO, |way| way.weight)
    });
    Vec3::select(first.cmpgt(Vec3::ZERO), second / first, Vec3::ONE)
}

/// The media at a hit.
pub(crate) fn sides<Kind: Scatter>(
    context: &Context<'_>,
    ray: &PathRay,
    hit: &SurfaceHit,
    normal: Vec3,
    stacks: &mut MediaStacks,
) -> Sides {
    let before = stacks.filling(ray.media);
    let Some(medium) = Kind::medium(context, hit.material as usize) else {
        return Sides { media: [ray.media; 2], filling: [before; 2], wavelength: ray.wavelength, normal };
    };
    let dielectrics = context.scene.materials.dielectric.view();
    let direction = ray.direction();
    let inward = |normal: Vec3| direction.dot(normal) < 0.0;
    let geometric = inward(hit.point.geometric_normal);
    let boundary = stacks.boundary(ray.media, medium, geometric, &dielectrics);
    let mut filling = [boundary.filling_before, boundary.filling_behind];
    if inward(hit.point.shading_normal) != geometric {
        filling.reverse();
    }
    Sides { media: [ray.media, boundary.behind], filling, wavelength: ray.wavelength, normal }
}

/// Draws the path's wavelength where it first meets a medium whose index depends on it; all branches of a path have the same.
#[inline(always)]
fn disperse(context: &Context<'_>, ray: &mut PathRay, filling: [Medium; 2], first: impl FnOnce() -> Stream) {
    let dielectrics = context.scene.materials.dielectric.view();
    if ray.wavelength != PathWavelength::NONE || !filling.iter().any(|medium| medium.disperses(&dielectrics)) {
        return;
    }
    ray.wavelength = PathWavelength::draw(context.sampler.one(first(), Decision::Wavelength.at(0)));
    ray.weight *= ray.wavelength.get().map_or(Vec3::ONE, |wavelength| wavelength.weight);
}

impl<N: Numbers> Arrival<'_, N> {
    /// Samples a light and the background.
    #[inline(always)]
    fn toward_lights(&self, surface: &impl Surface, stacks: &MediaStacks, outlet: &mut impl Outlet) {
        let scene = self.context.scene;
        if !scene.emitters.is_empty() {
            self.toward(self.numbers.light(scene, self.hit.point.position, self.hit.time), surface, stacks, outlet);
        }
        if let Some(map) = scene.background.drawn() {
            self.toward(self.numbers.sky(map), surface, stacks, outlet);
        }
    }

    /// Sends a shadow ray toward a light, unless the surface does not scatter from there.
    #[inline(always)]
    fn toward(
        &self,
        light: Option<LightSample>,
        surface: &impl Surface,
        stacks: &MediaStacks,
        outlet: &mut impl Outlet,
    ) {
        let Some(light) = light else { return };
        let toward = self.frame.to_local(light.direction);
        if !self.is_open(light.direction, toward) {
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
        let origin = self.origin(light.direction);
        let (direction, distance) = light.ray_from(origin);
        outlet.shadow(ShadowRay {
            origin_x: origin.x,
            origin_y: origin.y,
            origin_z: origin.z,
            direction_x: direction.x,
            direction_y: direction.y,
            direction_z: direction.z,
            distance,
            contribution: contribution * self.context.radiance_scale(stacks, media, self.ray.wavelength),
            sample: self.ray.sample,
            trail: self.ray.trail,
            instance: self.hit.instance,
            media,
            passes_sheets: light.is_delta,
        });
    }

    /// Sends the path on; tells the weight of what was scattered, before roulette.
    #[inline(always)]
    fn onward(&self, surface: &impl Surface, outlet: &mut impl Outlet, counts: &mut Counts) -> [Vec3; 2] {
        let (u, lobe) = (self.numbers.direction(), self.numbers.lobe());
        if !self.splits() {
            let chosen = surface.choose(self.view, u, lobe);
            return [self.send(chosen, self.ray.branch, outlet, counts), Vec3::ZERO];
        }
        let LobeSplit { reflection, transmission, reflectance } = surface.split(self.view, u, lobe);
        if reflectance == 1.0 {
            return [self.send(reflection, self.ray.branch, outlet, counts), Vec3::ZERO];
        }
        counts.branched += 1;
        let branch = self.ray.branch.wrapping_mul(2);
        let reflected = self.send(reflection, branch, outlet, counts);
        [reflected, self.send(transmission, branch.wrapping_add(1), outlet, counts)]
    }

    /// Puts a ray into its queue, unless it is absorbed or given up; tells the weight of what was scattered.
    #[inline(always)]
    fn send(&self, sample: Option<LobeSample>, branch: u32, outlet: &mut impl Outlet, counts: &mut Counts) -> Vec3 {
        let scattered = sample.map_or(Vec3::ZERO, |sample| self.ray.weight * sample.weight);
        let largest = scattered.max_element();
        if !scattered.is_finite() {
            counts.absorbed += 1;
            let PathRay { sample, trail, .. } = self.ray;
            let (trail, instance) = (trail.end(End::Surface), self.hit.instance);
            outlet.light(Contribution { radiance: scattered, sample, trail, instance });
            return Vec3::ZERO;
        }
        let Some(sample) = sample.filter(|_| largest > 0.0) else {
            counts.absorbed += 1;
            return Vec3::ZERO;
        };
        let ledger = self.context.albedos.is_some();
        let direction = self.frame.to_world(sample.direction);
        if !self.is_open(direction, sample.direction) {
            counts.absorbed += 1;
            if ledger {
                counts.ledger.below_surface.add(scattered);
            }
            return scattered;
        }
        let Some(weight) = survive(self.context, scattered, &self.numbers, counts) else { return scattered };
        let origin = self.origin(direction);
        let ray = self.ray.along(origin, direction);
        let event = match (sample.is_transmission(), sample.pdf == DELTA) {
            (false, true) => Event::Mirrored,
            (true, true) => Event::Refracted,
            (false, false) => Event::Spread,
            (true, false) => Event::SpreadThrough,
        };
        let trail = ray.trail.then(event);
        let ray = PathRay {
            weight,
            pdf: sample.pdf,
            instance: self.hit.instance,
            media: self.media_of(direction),
            branch,
            trail,
            ..ray
        };
        if sample.is_transmission() {
            counts.transmissions += 1;
            outlet.transmit(ray);
        } else {
            counts.reflections += 1;
            outlet.reflect(ray);
        }
        scattered
    }

    /// Enters into the ledger what arrived, what is expected of it and what became of it. Where nothing is expected, what the sampler
    /// sent is believed.
    #[inline(always)]
    fn book(&self, albedo: Option<Vec3>, sent: [Vec3; 2], ledger: &mut Ledger) {
        let arrived = self.ray.weight;
        let expected = albedo.map_or(sent[0] + sent[1], |albedo| arrived * albedo);
        ledger.scattered.add(self.arrived);
        ledger.recolored.add(arrived);
        ledger.recolored.take(self.arrived);
        ledger.absorbed.add(arrived);
        ledger.absorbed.take(expected);
        ledger.residual.add(expected);
        sent.into_iter().for_each(|sent| ledger.residual.take(sent));
        let residual = expected - sent[0] - sent[1];
        ledger.residual_squares.add(residual * residual);
    }

    /// Where a ray starts that leaves in a direction.
    #[inline(always)]
    fn origin(&self, direction: Vec3) -> Vec3 {
        let origin = offset_origin(&self.hit.point, direction);
        match self.context.scene.settings.ray_offset {
            0.0 => origin,
            offset => {
                let further = offset * (1.0 + self.hit.point.position.abs().max_element());
                origin + self.geometric * further.copysign(direction.dot(self.geometric))
            }
        }
    }

    /// Whether the path sends a ray into each queue here.
    #[inline(always)]
    fn splits(&self) -> bool {
        self.depth < self.context.scene.settings.split_depth
    }

    /// Whether light may go this way: what shading normals send below an opaque surface is dropped. Through others it goes
    /// on, on the side where it is.
    #[inline(always)]
    fn is_open(&self, direction: Vec3, local: Vec3) -> bool {
        self.transmits || (direction.dot(self.geometric) > 0.0) == (local.z > 0.0)
    }

    /// The media around a ray that leaves the surface.
    #[inline(always)]
    fn media_of(&self, direction: Vec3) -> MediaId {
        self.media[usize::from(direction.dot(self.geometric) < 0.0)]
    }
}

/// What a path weighs that goes on; of those whose weight has become small some are given up, and the others weigh more.
#[inline(always)]
fn survive(context: &Context<'_>, scattered: Vec3, numbers: &impl Numbers, counts: &mut Counts) -> Option<Vec3> {
    let (mut weight, largest, ledger) = (scattered, scattered.max_element(), context.albedos.is_some());
    if largest < ROULETTE_WEIGHT && context.scene.settings.roulette {
        let survival = largest / ROULETTE_WEIGHT;
        if numbers.roulette() >= survival {
            counts.given_up += 1;
            if ledger {
                counts.ledger.roulette_removed.add(scattered);
            }
            return None;
        }
        weight /= survival;
    }
    if ledger {
        counts.ledger.onward.add(weight);
        counts.ledger.roulette_added.add(weight);
        counts.ledger.roulette_added.take(scattered);
    }
    Some(weight)
}

/// Shadow rays that a hit sends at most: toward a light and toward the background.
pub const SHADOW_RAYS: usize = 2;

/// Rays whose largest weight is at least this are all followed; of lighter ones as many as keep their sum, each with this
/// weight.
const ROULETTE_WEIGHT: f32 = 0.25;

/// Of so many hits without a tabulated albedo one is estimated for the ledger.
const ASKED: f32 = 4.0;

#[cfg(test)]
mod tests;
