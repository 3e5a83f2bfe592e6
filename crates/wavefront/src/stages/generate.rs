//! Makes camera rays.

use std::ops::Range;

use brewster_film::FilmTile;
use glam::{Vec2, Vec3};

use crate::context::Context;
use crate::media::MediaId;
use crate::queues::{PathRay, PrimaryQueue};

/// Makes the rays of some samples of every pixel of a tile; those of one pixel are neighbors.
///
/// Reads: the camera and the sample pattern. Writes: the primary queue and the film's number of samples.
pub fn generate(
    context: &Context<'_>,
    samples: Range<u32>,
    media: MediaId,
    tile: &mut FilmTile<'_>,
    primary: &mut PrimaryQueue,
) {
    let resolution = context.scene.settings.resolution.as_vec2();
    let aspect = resolution.x / resolution.y;
    primary.reserve_total(tile.len() * samples.len());
    for pixel in 0..tile.len() as u32 {
        let (x, y) = tile.pixel(pixel);
        let center = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
        for sample in samples.clone() {
            let place = (center + context.pattern[sample as usize]) / resolution;
            let ray = context.camera.ray(place, aspect);
            tile.add_sample(pixel);
            primary.push(PathRay {
                origin_x: ray.origin.x,
                origin_y: ray.origin.y,
                origin_z: ray.origin.z,
                direction_x: ray.direction.x,
                direction_y: ray.direction.y,
                direction_z: ray.direction.z,
                weight: Vec3::ONE,
                pixel,
                sample,
                media,
                branch: 1,
            });
        }
    }
}
