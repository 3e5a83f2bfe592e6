//! Makes camera rays.

use std::ops::Range;

use brewster_buffers::Integrator;
use brewster_film::{FilmTile, Light};
use brewster_optics::dispersion::PathWavelength;
use brewster_optics::lobe::DELTA;
use glam::{Vec2, Vec3};

use crate::context::Context;
use crate::media::MediaId;
use crate::queues::{NO_INSTANCE, PathRay, PrimaryQueue, Sample, SampleColumns, Trail};
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
    for pixel in 0..tile.len() as u32 {
        let (x, y) = tile.pixel(pixel);
        let key = PixelKey::new(x, y);
        for number in numbers.clone() {
            let sample = samples.len() as u32;
            primary.push(PathRay { sample, ..camera_ray(context, (x, y), number, media) });
            samples.push(Sample { pixel, key, number, light: Light::NONE, rays: 0, rejected: 0 });
        }
    }
}

/// The ray of a sample of the pixel at (x, y).
#[inline(always)]
pub(crate) fn camera_ray(context: &Context<'_>, (x, y): (u32, u32), number: u32, media: MediaId) -> PathRay {
    let resolution = context.scene.settings.resolution.as_vec2();
    let center = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
    let (offset, lens) = match context.scene.settings.integrator {
        Integrator::Whitted => (context.pattern[number as usize], Vec2::ZERO),
        Integrator::Path => random_place(context, PixelKey::new(x, y), number),
    };
    let time = context.time(PixelKey::new(x, y), number);
    let ray = context.camera.ray((center + offset) / resolution, resolution.x / resolution.y, lens, time);
    PathRay {
        origin_x: ray.origin.x,
        origin_y: ray.origin.y,
        origin_z: ray.origin.z,
        direction_x: ray.direction.x,
        direction_y: ray.direction.y,
        direction_z: ray.direction.z,
        weight: Vec3::ONE,
        pdf: DELTA,
        sample: 0,
        trail: Trail::CAMERA,
        instance: NO_INSTANCE,
        media,
        wavelength: PathWavelength::NONE,
        branch: 1,
    }
}

/// Where a sample lies around the pixel's center, in pixels, and on the lens, of radius 1.
#[inline(always)]
fn random_place(context: &Context<'_>, pixel: PixelKey, sample: u32) -> (Vec2, Vec2) {
    let stream = context.sampler.stream(pixel, sample, 1);
    let camera = Decision::Camera.at(0);
    if context.camera.aperture_radius == 0.0 {
        return (Vec2::from_array(context.filter.sample(context.sampler.pair(stream, camera))), Vec2::ZERO);
    }
    let [x, y, u, v] = context.sampler.four(stream, camera);
    (Vec2::from_array(context.filter.sample([x, y])), context.camera.aperture(Vec2::new(u, v)))
}
