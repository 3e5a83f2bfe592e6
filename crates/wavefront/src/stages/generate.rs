//! Makes camera rays.

#![expect(clippy::needless_range_loop, reason = "what belongs to a row stands in many columns")]

use std::ops::Range;

use brewster_buffers::{CameraFrame, Integrator};
use brewster_film::{FilmTile, Light};
use brewster_geometry::Ray;
use brewster_lanes::dispatch;
use brewster_optics::dispersion::PathWavelength;
use brewster_optics::lobe::DELTA;
use glam::{Vec2, Vec3};

use super::vectors::{LANES, Vectors};
use crate::context::Context;
use crate::media::MediaId;
use crate::queues::{NO_INSTANCE, PathRay, PathRaysView, PrimaryQueue, SampleColumns, SamplesView, Trail};
use crate::random::{Decision, PixelKey};

/// Makes the rays of some samples of every pixel of a tile; those of one pixel are neighbors.
///
/// Reads: the camera, and the sample pattern or random numbers. Writes: the primary queue and the samples.
pub fn generate(
    context: &Context<'_>,
    numbers: Range<u32>,
    media: MediaId,
    tile: &FilmTile<'_>,
    samples: &mut SampleColumns,
    primary: &mut PrimaryQueue,
) {
    samples.clear();
    samples.reserve(tile.len() * numbers.len());
    primary.reserve_total(tile.len() * numbers.len());
    generate_blocks(context.policy.level, context, numbers, media, tile, samples, primary);
}

dispatch! {
    fn generate_blocks(
        context: &Context<'_>,
        numbers: Range<u32>,
        media: MediaId,
        tile: &FilmTile<'_>,
        samples: &mut SampleColumns,
        primary: &mut PrimaryQueue,
    ) {
        let mut block = Block::<LANES>::new(context);
        for pixel in 0..tile.len() as u32 {
            let (x, y) = tile.pixel(pixel);
            let key = PixelKey::new(x, y);
            for number in numbers.clone() {
                let lane = block.len;
                (block.xs[lane], block.ys[lane]) = (x as f32, y as f32);
                (block.pixels[lane], block.keys[lane], block.numbers[lane]) = (pixel, key, number);
                block.len += 1;
                if block.len == LANES {
                    block.generate(context, media, samples, primary);
                }
            }
        }
        block.generate(context, media, samples, primary);
    }
}

/// Samples that wait for their rays, as columns; what lies beyond `len` does not count.
struct Block<const N: usize> {
    len: usize,
    xs: [f32; N],
    ys: [f32; N],
    pixels: [u32; N],
    keys: [PixelKey; N],
    numbers: [u32; N],
    /// The camera's position, right, up and forward when the samples look.
    frame: [Vectors<N>; 4],
}

impl<const N: usize> Block<N> {
    #[inline(always)]
    fn new(context: &Context<'_>) -> Block<N> {
        let CameraFrame { position, right, up, forward } = context.camera.frame(0.0);
        Block {
            len: 0,
            xs: [0.0; N],
            ys: [0.0; N],
            pixels: [0; N],
            keys: [PixelKey::ORIGIN; N],
            numbers: [0; N],
            frame: [position, right, up, forward].map(Vectors::splat),
        }
    }

    /// Makes the rays.
    #[inline(always)]
    fn generate(
        &mut self,
        context: &Context<'_>,
        media: MediaId,
        samples: &mut SampleColumns,
        primary: &mut PrimaryQueue,
    ) {
        let [mut offset_x, mut offset_y, mut lens_x, mut lens_y, mut times] = [[0.0; N]; 5];
        for lane in 0..N {
            let (offset, lens) = place(context, self.keys[lane], self.numbers[lane]);
            (offset_x[lane], offset_y[lane]) = offset.into();
            (lens_x[lane], lens_y[lane]) = lens.into();
            times[lane] = context.time(self.keys[lane], self.numbers[lane]);
        }
        if !context.camera.motion.is_empty() {
            for lane in 0..N {
                let CameraFrame { position, right, up, forward } = context.camera.frame(times[lane]);
                for (column, vector) in self.frame.iter_mut().zip([position, right, up, forward]) {
                    column.set(lane, vector);
                }
            }
        }
        let (mut origins, mut directions, mut rows) = (Vectors::<N>::ZERO, Vectors::<N>::ZERO, [0; N]);
        for lane in 0..N {
            let place = Vec2::new(self.xs[lane], self.ys[lane]) + 0.5 + Vec2::new(offset_x[lane], offset_y[lane]);
            let [position, right, up, forward] = &self.frame;
            let (position, right) = (position.get(lane), right.get(lane));
            let frame = CameraFrame { position, right, up: up.get(lane), forward: forward.get(lane) };
            let ray = ray(context, frame, place, Vec2::new(lens_x[lane], lens_y[lane]), times[lane]);
            origins.set(lane, ray.origin);
            directions.set(lane, ray.direction);
            rows[lane] = (samples.len() + lane) as u32;
        }
        let ([origin_x, origin_y, origin_z], [direction_x, direction_y, direction_z]) = (&origins.0, &directions.0);
        let rays = PathRaysView {
            origin_x,
            origin_y,
            origin_z,
            direction_x,
            direction_y,
            direction_z,
            weight: &[Vec3::ONE; N],
            pdf: &[DELTA; N],
            sample: &rows,
            trail: &[Trail::CAMERA; N],
            instance: &[NO_INSTANCE; N],
            media: &[media; N],
            wavelength: &[PathWavelength::NONE; N],
            branch: &[1; N],
        };
        let of = SamplesView {
            pixel: &self.pixels,
            key: &self.keys,
            number: &self.numbers,
            light: &[Light::NONE; N],
            rays: &[0; N],
            rejected: &[0; N],
        };
        let all = &[true; N][..self.len];
        primary.extend_marked(rays.slice(0..self.len), all);
        samples.extend_marked(of.slice(0..self.len), all);
        self.len = 0;
    }
}

/// The ray of a sample of the pixel at (x, y).
#[inline(always)]
pub(crate) fn camera_ray(context: &Context<'_>, (x, y): (u32, u32), number: u32, media: MediaId) -> PathRay {
    let key = PixelKey::new(x, y);
    let (offset, lens) = place(context, key, number);
    let time = context.time(key, number);
    let place = Vec2::new(x as f32, y as f32) + 0.5 + offset;
    let Ray { origin, direction, .. } = ray(context, context.camera.frame(time), place, lens, time);
    PathRay { media, ..PathRay::START }.along(origin, direction)
}

/// The ray through a place in the picture, in pixels, and one on the lens, of radius 1.
#[inline(always)]
fn ray(context: &Context<'_>, frame: CameraFrame, place: Vec2, lens: Vec2, time: f32) -> Ray {
    let resolution = context.scene.settings.resolution.as_vec2();
    context.camera.ray_from(frame, place / resolution, resolution.x / resolution.y, lens, time)
}

/// Where a sample lies around the pixel's center, in pixels, and on the lens, of radius 1.
#[inline(always)]
fn place(context: &Context<'_>, pixel: PixelKey, sample: u32) -> (Vec2, Vec2) {
    if context.scene.settings.integrator == Integrator::Whitted {
        return (context.pattern[sample as usize], Vec2::ZERO);
    }
    let stream = context.sampler.stream(pixel, sample, 1);
    let camera = Decision::Camera.at(0);
    if context.camera.aperture_radius == 0.0 {
        return (Vec2::from_array(context.filter.sample(context.sampler.pair(stream, camera))), Vec2::ZERO);
    }
    let [x, y, u, v] = context.sampler.four(stream, camera);
    (Vec2::from_array(context.filter.sample([x, y])), context.camera.aperture(Vec2::new(u, v)))
}
