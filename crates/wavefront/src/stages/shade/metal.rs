//! Shades hits on metals: the lecture's Phong highlight times R_0, and the mirror image times the Fresnel reflectance.

#![expect(clippy::needless_range_loop, reason = "what belongs to a row stands in many columns")]

use brewster_lanes::dispatch;
use brewster_optics::conductor::F82Tint;
use brewster_optics::fresnel::FresnelModel;
use brewster_optics::fresnel::conductor_color;
use brewster_optics::phong::highlight as phong_highlight;
use brewster_optics::refraction::mirror;

use super::Continuation;
use super::arrivals::{Arrivals, Onward};
use crate::context::Context;
use crate::media::MediaStacks;
use crate::queues::{Event, HitsOf, OnMetal, PathRaysView, SurfaceHitsView};
use crate::stages::Outlet;
use crate::stages::vectors::{LANES, Vectors};
use crate::stats::Counts;

/// For each hit: for each light on the viewer's side a shadow ray with ks · R_0 · max(0, L·R)^exponent · irradiance, and, below
/// the maximum depth, a reflection with weight F_r. What is not reflected is absorbed as heat. A complex index counts relative
/// to the medium in front of the metal; R_0 is what the author says, in any medium.
///
/// Reads: rays, hits, metals, textures, lights, the media stacks. Writes: shadow rays and the next depth's reflection queue.
pub fn shade_metal(
    context: &Context<'_>,
    rays: PathRaysView<'_>,
    hits: &HitsOf<'_, OnMetal>,
    stacks: &MediaStacks,
    continuation: Continuation,
    outlet: &mut impl Outlet,
    counts: &mut Counts,
) {
    mirror_blocks(context.policy.level, context, rays, hits.columns(), stacks, continuation, outlet, counts);
}

dispatch! {
    fn mirror_blocks<O: Outlet>(
        context: &Context<'_>,
        rays: PathRaysView<'_>,
        hits: SurfaceHitsView<'_>,
        stacks: &MediaStacks,
        continuation: Continuation,
        outlet: &mut O,
        counts: &mut Counts,
    ) {
        for start in (0..hits.len()).step_by(LANES) {
            let hits = hits.run(start, LANES);
            mirror_at_metal::<LANES>(context, (rays, hits), stacks, continuation, outlet, counts);
        }
    }
}

/// A block of hits.
#[inline(always)]
pub(crate) fn mirror_at_metal<const N: usize>(
    context: &Context<'_>,
    (rays, hits): (PathRaysView<'_>, SurfaceHitsView<'_>),
    stacks: &MediaStacks,
    continuation: Continuation,
    outlet: &mut impl Outlet,
    counts: &mut Counts,
) {
    let scene = context.scene;
    let arrivals = Arrivals::<N>::new(context, rays, hits);
    let metals = Metals::new(&arrivals, stacks);
    let mut mirrors = Vectors::<N>::ZERO;
    for row in 0..N {
        mirrors.set(row, mirror(arrivals.directions.get(row), arrivals.normals.get(row)));
    }
    for index in 0..scene.lights.len() {
        let lamp = arrivals.lamp(index);
        let (mut contributions, mut lit) = (Vectors::<N>::ZERO, [false; N]);
        for row in 0..N {
            let toward = lamp.directions.get(row);
            let highlight = metals.specular.get(row)
                * metals.r0.get(row)
                * phong_highlight(toward, mirrors.get(row), metals.exponents[row]);
            contributions.set(row, arrivals.weights.get(row) * highlight * lamp.irradiances.get(row));
            lit[row] = arrivals.is_outside(row, toward);
        }
        arrivals.toward(&lamp, &contributions, &lit, &arrivals.media, outlet);
    }
    let reflectances = metals.reflectances(&arrivals);
    let mut weights = Vectors::<N>::ZERO;
    for row in 0..N {
        weights.set(row, arrivals.weights.get(row) * reflectances.get(row));
    }
    let reflections = Onward { sent: [true; N], directions: mirrors, weights, media: arrivals.media };
    arrivals.send(&reflections, Event::Mirrored, continuation, outlet, counts);
}

/// The metals of a block's hits.
struct Metals<const N: usize> {
    r0: Vectors<N>,
    specular: Vectors<N>,
    exponents: [f32; N],
    /// Whether F_r follows from the index: relative to `eta_i`, `first` is its real part and `second` its imaginary part. For others
    /// these are the reflectance at grazing incidence and the tint.
    exact: [bool; N],
    first: Vectors<N>,
    second: Vectors<N>,
    eta_i: [f32; N],
}

impl<const N: usize> Metals<N> {
    #[inline(always)]
    fn new(arrivals: &Arrivals<'_, N>, stacks: &MediaStacks) -> Metals<N> {
        let materials = &arrivals.context.scene.materials;
        let (metals, dielectrics) = (materials.metal.view(), materials.dielectric.view());
        let [mut r0, mut specular, mut first, mut second] = [Vectors::<N>::ZERO; 4];
        let (mut exponents, mut exact, mut eta_i) = ([0.0; N], [false; N], [1.0; N]);
        for row in 0..N {
            let material = arrivals.hit(row).material as usize;
            r0.set(row, arrivals.color(row, metals.r0[material]));
            specular.set(row, arrivals.color(row, metals.specular[material]));
            exponents[row] = metals.exponent[material];
            exact[row] = metals.fresnel[material] == FresnelModel::Exact;
            if exact[row] {
                first.set(row, metals.eta[material]);
                second.set(row, metals.k[material]);
                eta_i[row] = stacks.filling(arrivals.media[row]).ior(&dielectrics);
            } else {
                first.set(row, metals.r90[material]);
                second.set(row, metals.f82[material]);
            }
        }
        Metals { r0, specular, exponents, exact, first, second, eta_i }
    }

    /// F_r of the rows.
    #[inline(always)]
    fn reflectances(&self, arrivals: &Arrivals<'_, N>) -> Vectors<N> {
        let mut reflectances = Vectors::<N>::ZERO;
        for row in 0..N {
            let tint = F82Tint::new(self.r0.get(row), self.first.get(row), self.second.get(row));
            reflectances.set(row, tint.reflectance(arrivals.cos_i(row)));
        }
        if self.exact.contains(&true) {
            for row in 0..N {
                let (eta, k) = (self.first.get(row), self.second.get(row));
                let exact = conductor_color(arrivals.cos_i(row), self.eta_i[row], eta, k);
                reflectances.set(row, if self.exact[row] { exact } else { reflectances.get(row) });
            }
        }
        reflectances
    }
}
