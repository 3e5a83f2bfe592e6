//! Scattering: what the path integrator does where a ray meets a material, one stage a kind.
//!
//! All kinds take the same steps, [`scatter`]; a kind says by its [`Surface`] how a surface of it scatters light.

mod arrivals;
mod block;
mod coated;
mod dielectric;
mod lambert;
mod medium;
mod metal;
mod principled;
mod rough_diffuse;
mod roulette;

pub(crate) use arrivals::scatter_block;
pub(crate) use block::Rows;
pub(crate) use metal::Conductor;

use brewster_buffers::{DetailId, Integrator, MaterialKind};
use brewster_geometry::{Hit, SurfacePoint};
use brewster_lanes::dispatch;
use brewster_optics::basis::Basis;
use brewster_optics::dispersion::PathWavelength;
use brewster_optics::lobe::{LobeSample, LobeSplit, LobeValue};
use glam::{Vec2, Vec3};

pub(crate) use self::medium::scatter_in_medium;
pub use self::medium::scatter_medium;
use super::shade::facing_normals;
use super::vectors::LANES;
use super::{Drawn, DrawsView, Points, Queues};
use crate::albedo::Albedos;
use crate::context::Context;
use crate::media::{MediaId, MediaStacks, Medium};
use crate::queues::{
    HitsOf, OnDielectric, OnPrincipled, PathRay, PathRaysView, SamplesView, ShadowRay, SurfaceHit, SurfaceHitsView,
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
pub trait Surface: Copy {
    /// Whether it scatters into single directions only, which no light can be sampled in.
    fn is_smooth(&self) -> bool;

    /// What comes from one direction and goes to another. Not asked where the surface is smooth.
    fn evaluate(&self, view: Vec3, light: Vec3) -> LobeValue;

    /// Whether light may come through.
    fn transmits(&self) -> bool;

    /// Whether the guide may direct rays here: it knows light that comes from outside, and helps where light is spread widely.
    #[inline(always)]
    fn is_guided(&self) -> bool {
        false
    }

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

/// Below the maximum depth, for each hit: a shadow ray toward a light and one toward the background, and a ray on, into one
/// queue by chance or, above the split depth, into both.
///
/// Light that two techniques can find is shared between them by the power heuristic. Of rays whose weight has become small
/// some are given up and the others weigh more.
///
/// Reads: rays, hits, random numbers, samples, the kind's materials, textures, lights, background, the guide. Writes: shadow rays, the next depth's reflection
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
    if onward.queues.next.is_none() {
        return hits.columns().rays().iter().for_each(|&ray| cut(context, rays.weight[ray as usize], counts));
    }
    scatter_blocks(context.policy.level, context, rays, hits, draws, samples, onward, counts);
}

dispatch! {
    fn scatter_blocks<Kind: Scatter>(
        context: &Context<'_>,
        rays: PathRaysView<'_>,
        hits: &HitsOf<'_, Kind>,
        draws: DrawsView<'_>,
        samples: SamplesView<'_>,
        onward: &mut Onward<'_>,
        counts: &mut Counts,
    ) {
        let (hits, depth) = (hits.columns(), onward.depth);
        for start in (0..hits.len()).step_by(LANES) {
            let queued = Queued { context, rays, hits, draws, samples, start, depth };
            scatter_block::<Kind, _, LANES>(context, &queued, &mut onward.queues, onward.stacks, counts);
        }
    }
}

/// A block of the rows of queues.
struct Queued<'q, 'a> {
    context: &'q Context<'a>,
    rays: PathRaysView<'q>,
    hits: SurfaceHitsView<'q>,
    draws: DrawsView<'q>,
    samples: SamplesView<'q>,
    start: usize,
    depth: u32,
}

impl Queued<'_, '_> {
    #[inline(always)]
    fn row(&self, lane: usize) -> usize {
        (self.start + lane).min(self.hits.len() - 1)
    }
}

impl<'q> Rows for Queued<'q, '_> {
    type Numbers = Drawn<'q>;

    #[inline(always)]
    fn len(&self) -> usize {
        LANES.min(self.hits.len() - self.start)
    }

    #[inline(always)]
    fn depth(&self) -> u32 {
        self.depth
    }

    #[inline(always)]
    fn ray(&self, lane: usize) -> PathRay {
        self.rays.get(self.hits.rays()[self.row(lane)] as usize)
    }

    #[inline(always)]
    fn direction(&self, lane: usize) -> Vec3 {
        let (rays, ray) = (&self.rays, self.hits.rays()[self.row(lane)] as usize);
        Vec3::new(rays.direction_x[ray], rays.direction_y[ray], rays.direction_z[ray])
    }

    #[inline(always)]
    fn hit(&self, lane: usize) -> SurfaceHit {
        self.hits.get(self.row(lane))
    }

    #[inline(always)]
    fn point(&self, lane: usize) -> SurfacePoint {
        self.hits.points().0[self.row(lane)]
    }

    #[inline(always)]
    fn numbers(&self, lane: usize) -> Drawn<'q> {
        self.draws.get(self.row(lane))
    }

    #[inline(always)]
    fn stream(&self, ray: &PathRay, branch: u32) -> Stream {
        self.samples.stream(&self.context.sampler, ray.sample, branch)
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
        disperse(contexts[0], &mut ray, sides.filling, |_| first());
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
fn disperse(context: &Context<'_>, ray: &mut PathRay, filling: [Medium; 2], first: impl FnOnce(&PathRay) -> Stream) {
    let dielectrics = context.scene.materials.dielectric.view();
    if ray.wavelength != PathWavelength::NONE || !filling.iter().any(|medium| medium.disperses(&dielectrics)) {
        return;
    }
    ray.wavelength = PathWavelength::draw(context.sampler.one(first(ray), Decision::Wavelength.at(0)));
    ray.weight *= ray.wavelength.get().map_or(Vec3::ONE, |wavelength| wavelength.weight);
}

/// Shadow rays that a hit sends at most: toward a light and toward the background.
pub const SHADOW_RAYS: usize = 2;

/// Of so many hits without a tabulated albedo one is estimated for the ledger.
const ASKED: f32 = 4.0;

#[cfg(test)]
mod tests;
