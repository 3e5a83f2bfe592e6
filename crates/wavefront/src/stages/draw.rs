//! Draws the random numbers of hits.

use brewster_lanes::columns;
use glam::Vec2;

use crate::context::Context;
use crate::queues::{PathRaysView, SamplesView, SurfaceHitsView};
use crate::random::{Decision, Sampler, Stream, StreamColumns, ones, pairs};

columns! {
    /// The random numbers of a hit, each 0 ≤ u < 1.
    pub struct Draw => DrawColumns, DrawsView, DrawsViewMut {
        /// Which light.
        pub light: f32,
        /// Where on it.
        pub light_x: f32,
        /// Where on it.
        pub light_y: f32,
        /// Which direction of the sky.
        pub sky_x: f32,
        /// Which direction of the sky.
        pub sky_y: f32,
        /// Which direction within the lobe.
        pub direction_x: f32,
        /// Which direction within the lobe.
        pub direction_y: f32,
        /// Which lobe.
        pub lobe: f32,
        /// Whether the path goes on.
        pub roulette: f32,
    }
}

/// The random numbers of one hit, drawn already or when they are asked for.
pub trait Numbers {
    /// Which light, and where on it.
    fn light(&self) -> (f32, [f32; 2]);
    /// Which direction of the sky.
    fn sky(&self) -> [f32; 2];
    /// Which direction within the lobe.
    fn direction(&self) -> Vec2;
    /// Which lobe.
    fn lobe(&self) -> f32;
    /// Whether the path goes on.
    fn roulette(&self) -> f32;
}

impl Numbers for Draw {
    #[inline(always)]
    fn light(&self) -> (f32, [f32; 2]) {
        (self.light, [self.light_x, self.light_y])
    }

    #[inline(always)]
    fn sky(&self) -> [f32; 2] {
        [self.sky_x, self.sky_y]
    }

    #[inline(always)]
    fn direction(&self) -> Vec2 {
        Vec2::new(self.direction_x, self.direction_y)
    }

    #[inline(always)]
    fn lobe(&self) -> f32 {
        self.lobe
    }

    #[inline(always)]
    fn roulette(&self) -> f32 {
        self.roulette
    }
}

/// Draws the numbers of one hit when they are asked for.
#[derive(Debug)]
pub struct DrawOnDemand<'a> {
    /// Where they come from.
    pub sampler: &'a Sampler,
    /// The hit's ray's branch.
    pub stream: Stream,
    /// The depth.
    pub depth: u32,
}

impl Numbers for DrawOnDemand<'_> {
    #[inline(always)]
    fn light(&self) -> (f32, [f32; 2]) {
        let light = self.sampler.one(self.stream, Decision::Light.at(self.depth));
        (light, self.sampler.pair(self.stream, Decision::LightPoint.at(self.depth)))
    }

    #[inline(always)]
    fn sky(&self) -> [f32; 2] {
        self.sampler.pair(self.stream, Decision::LightPoint.at(self.depth).repeat(1))
    }

    #[inline(always)]
    fn direction(&self) -> Vec2 {
        Vec2::from_array(self.sampler.pair(self.stream, Decision::Direction.at(self.depth)))
    }

    #[inline(always)]
    fn lobe(&self) -> f32 {
        self.sampler.one(self.stream, Decision::Lobe.at(self.depth))
    }

    #[inline(always)]
    fn roulette(&self) -> f32 {
        self.sampler.one(self.stream, Decision::Roulette.at(self.depth))
    }
}

const NONE: Draw = Draw {
    light: 0.0,
    light_x: 0.0,
    light_y: 0.0,
    sky_x: 0.0,
    sky_y: 0.0,
    direction_x: 0.0,
    direction_y: 0.0,
    lobe: 0.0,
    roulette: 0.0,
};

/// Memory for the random numbers of hits.
#[derive(Debug, Default)]
pub struct Draws {
    streams: StreamColumns,
    numbers: DrawColumns,
}

impl Draws {
    /// Bytes that a hit takes.
    pub const BYTES_PER_ROW: usize = StreamColumns::BYTES_PER_ROW + DrawColumns::BYTES_PER_ROW;

    /// The numbers that were drawn, in the hits' order.
    pub fn view(&self) -> DrawsView<'_> {
        self.numbers.view()
    }

    /// Bytes of memory taken.
    pub fn bytes(&self) -> usize {
        self.streams.capacity() * StreamColumns::BYTES_PER_ROW + self.numbers.capacity() * DrawColumns::BYTES_PER_ROW
    }
}

/// Draws all numbers that hits of one depth may ask for; those for lights only where there are any.
///
/// Reads: rays, hits and samples. Writes: one row of numbers a hit.
pub fn draw(
    context: &Context<'_>,
    rays: PathRaysView<'_>,
    hits: SurfaceHitsView<'_>,
    samples: SamplesView<'_>,
    depth: u32,
    draws: &mut Draws,
) {
    let (level, sampler) = (context.policy.level, &context.sampler);
    draws.streams.clear();
    for &ray in hits.ray {
        let ray = ray as usize;
        draws.streams.push(samples.stream(sampler, rays.sample[ray], rays.branch[ray]));
    }
    draws.numbers.resize(hits.len(), NONE);
    let (streams, out) = (draws.streams.view(), draws.numbers.view_mut());
    let place = Decision::LightPoint.at(depth);
    if !context.scene.emitters.is_empty() {
        ones(level, sampler, streams, Decision::Light.at(depth), out.light);
        pairs(level, sampler, streams, place, out.light_x, out.light_y);
    }
    if !context.scene.background.is_black() {
        pairs(level, sampler, streams, place.repeat(1), out.sky_x, out.sky_y);
    }
    pairs(level, sampler, streams, Decision::Direction.at(depth), out.direction_x, out.direction_y);
    ones(level, sampler, streams, Decision::Lobe.at(depth), out.lobe);
    ones(level, sampler, streams, Decision::Roulette.at(depth), out.roulette);
}
