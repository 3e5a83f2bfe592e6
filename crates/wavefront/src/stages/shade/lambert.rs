//! Shades hits on Lambert materials: ideal diffuse reflection.

#![expect(clippy::needless_range_loop, reason = "what belongs to a row stands in many columns")]

use brewster_lanes::dispatch;
use brewster_optics::lambert;

use super::arrivals::Arrivals;
use crate::context::Context;
use crate::queues::{HitsOf, OnLambert, PathRaysView, SurfaceHitsView};
use crate::stages::Outlet;
use crate::stages::vectors::{LANES, Vectors};

/// For each hit and each light on the viewer's side a shadow ray with albedo/π · N·L · irradiance.
///
/// Reads: rays, hits, Lambert materials, textures, lights. Writes: shadow rays.
pub fn shade_lambert(
    context: &Context<'_>,
    rays: PathRaysView<'_>,
    hits: &HitsOf<'_, OnLambert>,
    outlet: &mut impl Outlet,
) {
    light_blocks(context.policy.level, context, rays, hits.columns(), outlet);
}

dispatch! {
    fn light_blocks<O: Outlet>(context: &Context<'_>, rays: PathRaysView<'_>, hits: SurfaceHitsView<'_>, outlet: &mut O) {
        for start in (0..hits.len()).step_by(LANES) {
            light_lambert::<LANES>(context, rays, hits.run(start, LANES), outlet);
        }
    }
}

/// A block of hits.
#[inline(always)]
pub(crate) fn light_lambert<const N: usize>(
    context: &Context<'_>,
    rays: PathRaysView<'_>,
    hits: SurfaceHitsView<'_>,
    outlet: &mut impl Outlet,
) {
    let scene = context.scene;
    let arrivals = Arrivals::<N>::new(context, rays, hits);
    let albedo = scene.materials.lambert.view().albedo;
    let mut diffuse = Vectors::<N>::ZERO;
    for row in 0..N {
        diffuse.set(row, lambert::brdf(arrivals.color(row, albedo[arrivals.hit(row).material as usize])));
    }
    for index in 0..scene.lights.len() {
        let lamp = arrivals.lamp(index);
        let (mut contributions, mut lit) = (Vectors::<N>::ZERO, [false; N]);
        for row in 0..N {
            let toward = lamp.directions.get(row);
            let reflected = arrivals.weights.get(row) * diffuse.get(row) * toward.dot(arrivals.normals.get(row));
            contributions.set(row, reflected * lamp.irradiances.get(row));
            lit[row] = arrivals.is_outside(row, toward);
        }
        arrivals.toward(&lamp, &contributions, &lit, &arrivals.media, outlet);
    }
}
