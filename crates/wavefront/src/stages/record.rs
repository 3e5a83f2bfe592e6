//! Writes down what camera rays hit first.

use brewster_film::{FilmTile, FirstHit};

use crate::context::Context;
use crate::queues::{PathRaysView, SamplesView, SurfaceHitsView};

/// Adds depth along the view axis, normal and ids of first hits to the film.
///
/// Reads: rays of depth 0, their samples and hits. Writes: the film's layers.
pub fn record(
    context: &Context<'_>,
    rays: PathRaysView<'_>,
    hits: SurfaceHitsView<'_>,
    samples: SamplesView<'_>,
    tile: &mut FilmTile<'_>,
) {
    let materials = context.scene.instances.view().material;
    for row in 0..hits.len() {
        let hit = hits.get(row);
        let first = FirstHit {
            depth: (hit.point.position - context.camera.position).dot(context.camera.forward).max(0.0),
            normal: hit.point.shading_normal.to_array(),
            material: materials[hit.instance as usize].0,
            entity: hit.instance,
        };
        let sample = rays.sample[hit.ray as usize] as usize;
        tile.add_first_hit(samples.pixel[sample], samples.number[sample], first);
    }
}
