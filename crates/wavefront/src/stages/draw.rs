//! Draws the random numbers of hits, and lights by them.

use brewster_buffers::{EnvironmentMap, LightSample, SceneBuffers};
use brewster_geometry::SurfacePoint;
use brewster_lanes::columns;
use glam::{Vec2, Vec3};

use crate::context::Context;
use crate::queues::{PathRaysView, SamplesView};
use crate::random::{Decision, Sampler, Stream, StreamColumns, ones, pairs};

columns! {
    /// The random numbers of a hit, each 0 ≤ u < 1.
    pub struct Draw => DrawColumns, DrawRowsView, DrawRowsViewMut {
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
    /// The light that numbers choose for a point at a moment.
    fn light(&self, scene: &SceneBuffers, point: Vec3, time: f32) -> Option<LightSample>;
    /// The light of the sky that numbers choose.
    fn sky(&self, map: &EnvironmentMap) -> Option<LightSample>;
    /// Which direction within the lobe.
    fn direction(&self) -> Vec2;
    /// Which lobe.
    fn lobe(&self) -> f32;
    /// Whether the path goes on.
    fn roulette(&self) -> f32;
}

/// What was drawn for a hit.
#[derive(Clone, Copy, Debug)]
pub struct Drawn<'a> {
    numbers: Draw,
    light: Option<&'a Option<LightSample>>,
    sky: Option<&'a Option<LightSample>>,
}

impl Numbers for Drawn<'_> {
    #[inline(always)]
    fn light(&self, scene: &SceneBuffers, point: Vec3, time: f32) -> Option<LightSample> {
        let Draw { light, light_x, light_y, .. } = self.numbers;
        match self.light {
            Some(light) => *light,
            None => scene.sample_light(point, time, light, [light_x, light_y]),
        }
    }

    #[inline(always)]
    fn sky(&self, map: &EnvironmentMap) -> Option<LightSample> {
        match self.sky {
            Some(sky) => *sky,
            None => map.sample([self.numbers.sky_x, self.numbers.sky_y]),
        }
    }

    #[inline(always)]
    fn direction(&self) -> Vec2 {
        Vec2::new(self.numbers.direction_x, self.numbers.direction_y)
    }

    #[inline(always)]
    fn lobe(&self) -> f32 {
        self.numbers.lobe
    }

    #[inline(always)]
    fn roulette(&self) -> f32 {
        self.numbers.roulette
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
    fn light(&self, scene: &SceneBuffers, point: Vec3, time: f32) -> Option<LightSample> {
        let choice = self.sampler.one(self.stream, Decision::Light.at(self.depth));
        scene.sample_light(point, time, choice, self.sampler.pair(self.stream, Decision::LightPoint.at(self.depth)))
    }

    #[inline(always)]
    fn sky(&self, map: &EnvironmentMap) -> Option<LightSample> {
        map.sample(self.sampler.pair(self.stream, Decision::LightPoint.at(self.depth).repeat(1)))
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

/// Memory for the random numbers of hits, and for lights.
#[derive(Debug, Default)]
pub struct Draws {
    streams: StreamColumns,
    numbers: DrawColumns,
    lights: Vec<Option<LightSample>>,
    skies: Vec<Option<LightSample>>,
}

/// A shared view of what was drawn, in the hits' order.
#[derive(Clone, Copy, Debug)]
pub struct DrawsView<'a> {
    numbers: DrawRowsView<'a>,
    lights: &'a [Option<LightSample>],
    skies: &'a [Option<LightSample>],
}

impl<'a> DrawsView<'a> {
    /// What was drawn for a hit.
    #[inline(always)]
    pub fn get(&self, row: usize) -> Drawn<'a> {
        Drawn { numbers: self.numbers.get(row), light: self.lights.get(row), sky: self.skies.get(row) }
    }
}

impl Draws {
    /// Bytes that a hit takes.
    pub const BYTES_PER_ROW: usize =
        StreamColumns::BYTES_PER_ROW + DrawColumns::BYTES_PER_ROW + 2 * size_of::<Option<LightSample>>();

    /// What was drawn, in the hits' order.
    pub fn view(&self) -> DrawsView<'_> {
        DrawsView { numbers: self.numbers.view(), lights: &self.lights, skies: &self.skies }
    }

    /// Bytes of memory taken.
    pub fn bytes(&self) -> usize {
        self.streams.capacity() * StreamColumns::BYTES_PER_ROW
            + self.numbers.capacity() * DrawColumns::BYTES_PER_ROW
            + (self.lights.capacity() + self.skies.capacity()) * size_of::<Option<LightSample>>()
    }
}

/// The points of hits, and when they were hit, if something moves.
pub type Points<'a> = (&'a [SurfacePoint], &'a [f32]);

/// Draws all numbers that hits of one depth may ask for, of which the rays' rows are given; those for lights only where there are any.
/// Of hits whose points are given, with the times if something moves, lights and directions of the sky are drawn, too.
///
/// Reads: rays, points, samples, lights and background. Writes: one row of numbers a hit, and its light and sky.
pub fn draw(
    context: &Context<'_>,
    rays: PathRaysView<'_>,
    (hits, points): (&[u32], Option<Points<'_>>),
    samples: SamplesView<'_>,
    depth: u32,
    draws: &mut Draws,
) {
    let (level, sampler) = (context.policy.level, &context.sampler);
    let Draws { streams, numbers, lights, skies } = draws;
    streams.clear();
    for &ray in hits {
        let ray = ray as usize;
        streams.push(samples.stream(sampler, rays.sample[ray], rays.branch[ray]));
    }
    numbers.resize(hits.len(), NONE);
    lights.clear();
    skies.clear();
    let (streams, out) = (streams.view(), numbers.view_mut());
    let place = Decision::LightPoint.at(depth);
    if !context.scene.emitters.is_empty() {
        ones(level, sampler, streams, Decision::Light.at(depth), out.light);
        pairs(level, sampler, streams, place, out.light_x, out.light_y);
        if let Some(points) = points {
            lights.resize(hits.len(), None);
            context.scene.sample_lights(level, points, out.light, [out.light_x, out.light_y], lights);
        }
    }
    if let Some(map) = context.scene.background.drawn() {
        pairs(level, sampler, streams, place.repeat(1), out.sky_x, out.sky_y);
        if points.is_some() {
            skies.resize(hits.len(), None);
            map.sample_all(level, [out.sky_x, out.sky_y], skies);
        }
    }
    pairs(level, sampler, streams, Decision::Direction.at(depth), out.direction_x, out.direction_y);
    ones(level, sampler, streams, Decision::Lobe.at(depth), out.lobe);
    ones(level, sampler, streams, Decision::Roulette.at(depth), out.roulette);
}
