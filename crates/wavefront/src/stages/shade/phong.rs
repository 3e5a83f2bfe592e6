//! Shades hits on Phong materials: ambient + diffuse + specular, the lecture's ordinary surface.

#![expect(clippy::needless_range_loop, reason = "what belongs to a row stands in many columns")]

use brewster_lanes::dispatch;
use brewster_optics::lambert;
use brewster_optics::phong::highlight as phong_highlight;
use brewster_optics::refraction::mirror;

use super::arrivals::Arrivals;
use crate::context::Context;
use crate::queues::{Contribution, End, HitsOf, OnPhong, PathRaysView, SurfaceHitsView};
use crate::stages::Outlet;
use crate::stages::vectors::{LANES, Vectors};

/// For each hit: the ambient term as a contribution, and for each light on the viewer's side a shadow ray with
/// (albedo/π · N·L + ks · max(0, L·R)^exponent) · irradiance.
///
/// Reads: rays, hits, Phong materials, textures, lights. Writes: shadow rays and contributions.
pub fn shade_phong(
    context: &Context<'_>,
    rays: PathRaysView<'_>,
    hits: &HitsOf<'_, OnPhong>,
    outlet: &mut impl Outlet,
) {
    light_blocks(context.policy.level, context, rays, hits.columns(), outlet);
}

dispatch! {
    fn light_blocks<O: Outlet>(context: &Context<'_>, rays: PathRaysView<'_>, hits: SurfaceHitsView<'_>, outlet: &mut O) {
        for start in (0..hits.len()).step_by(LANES) {
            light_phong::<LANES>(context, rays, hits.run(start, LANES), outlet);
        }
    }
}

/// A block of hits.
#[inline(always)]
pub(crate) fn light_phong<const N: usize>(
    context: &Context<'_>,
    rays: PathRaysView<'_>,
    hits: SurfaceHitsView<'_>,
    outlet: &mut impl Outlet,
) {
    let scene = context.scene;
    let materials = scene.materials.phong.view();
    let arrivals = Arrivals::<N>::new(context, rays, hits);
    let (mut diffuse, mut specular, mut exponents) = (Vectors::<N>::ZERO, Vectors::<N>::ZERO, [0.0; N]);
    for row in 0..N {
        let material = arrivals.hit(row).material as usize;
        diffuse.set(row, lambert::brdf(arrivals.color(row, materials.diffuse[material])));
        specular.set(row, arrivals.color(row, materials.specular[material]));
        exponents[row] = materials.exponent[material];
        if arrivals.counted[row] {
            let ambient = arrivals.color(row, materials.ambient[material]);
            outlet.light(Contribution {
                radiance: arrivals.weights.get(row) * ambient * scene.ambient,
                sample: arrivals.samples[row],
                trail: arrivals.trails[row].end(End::Surface),
                instance: arrivals.instances[row],
            });
        }
    }
    for index in 0..scene.lights.len() {
        let lamp = arrivals.lamp(index);
        let (mut contributions, mut lit) = (Vectors::<N>::ZERO, [false; N]);
        for row in 0..N {
            let (toward, normal) = (lamp.directions.get(row), arrivals.normals.get(row));
            let mirror = mirror(arrivals.directions.get(row), normal);
            let highlight = specular.get(row) * phong_highlight(toward, mirror, exponents[row]);
            let reflected = arrivals.weights.get(row) * (diffuse.get(row) * toward.dot(normal) + highlight);
            contributions.set(row, reflected * lamp.irradiances.get(row));
            lit[row] = arrivals.is_outside(row, toward);
        }
        arrivals.toward(&lamp, &contributions, &lit, &arrivals.media, outlet);
    }
}
