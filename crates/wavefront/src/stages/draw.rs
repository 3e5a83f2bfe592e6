//! Draws the random numbers of hits.

use brewster_lanes::columns;

use crate::context::Context;
use crate::queues::{PathRaysView, SamplesView, SurfaceHitsView};
use crate::random::{Decision, StreamColumns, ones, pairs};

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
