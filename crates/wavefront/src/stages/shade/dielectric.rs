//! Shades hits on dielectrics: every one splits into both queues, with F_r and F_t.

use brewster_lanes::dispatch;
use brewster_optics::fresnel::FresnelModel;
use brewster_optics::phong::highlight as phong_highlight;
use brewster_optics::refraction::{mirror, refract_with_cosine};
use glam::Vec3;

use super::Continuation;
use super::arrivals::{Arrivals, Onward};
use crate::context::Context;
use crate::media::{Boundary, MediaId, MediaStacks, Medium};
use crate::queues::{Event, HitsOf, OnDielectric, PathRaysView, SurfaceHitsView};
use crate::stages::Outlet;
use crate::stages::vectors::{LANES, Vectors, count};
use crate::stats::Counts;

/// For each hit: for each light a shadow ray with the Phong highlight about the mirror direction times F_r, or about the
/// refracted direction times F_t for lights behind the boundary, and, below the maximum depth, a reflection with weight
/// F_r and a transmission with weight F_t.
///
/// Reads: rays, hits, dielectrics, textures, lights. Writes: shadow rays, the next depth's reflection and transmission queues,
/// and the media stacks.
pub fn shade_dielectric(
    context: &Context<'_>,
    rays: PathRaysView<'_>,
    hits: &HitsOf<'_, OnDielectric>,
    stacks: &mut MediaStacks,
    continuation: Continuation,
    outlet: &mut impl Outlet,
    counts: &mut Counts,
) {
    split_blocks(context.policy.level, context, rays, hits.columns(), stacks, continuation, outlet, counts);
}

dispatch! {
    fn split_blocks<O: Outlet>(
        context: &Context<'_>,
        rays: PathRaysView<'_>,
        hits: SurfaceHitsView<'_>,
        stacks: &mut MediaStacks,
        continuation: Continuation,
        outlet: &mut O,
        counts: &mut Counts,
    ) {
        for start in (0..hits.len()).step_by(LANES) {
            let hits = hits.run(start, LANES);
            split_at_dielectric::<LANES>(context, (rays, hits), stacks, continuation, outlet, counts);
        }
    }
}

/// A block of hits.
#[inline(always)]
pub(crate) fn split_at_dielectric<const N: usize>(
    context: &Context<'_>,
    (rays, hits): (PathRaysView<'_>, SurfaceHitsView<'_>),
    stacks: &mut MediaStacks,
    continuation: Continuation,
    outlet: &mut impl Outlet,
    counts: &mut Counts,
) {
    let arrivals = Arrivals::<N>::new(context, rays, hits);
    let boundaries = Boundaries::new(&arrivals, stacks);
    let split = Split::new(&arrivals, &boundaries);
    highlight(&arrivals, &boundaries, &split, outlet);
    let (mut reflected, mut transmitted) = (Vectors::<N>::ZERO, Vectors::<N>::ZERO);
    let (mut in_front, mut behind) = ([MediaId::VACUUM; N], [MediaId::VACUUM; N]);
    for row in 0..N {
        let (weight, reflectance) = (arrivals.weights.get(row), split.reflectances[row]);
        reflected.set(row, weight * reflectance);
        transmitted.set(row, weight * (1.0 - reflectance));
        in_front[row] = media_of(&arrivals, &boundaries, row, split.reflected.get(row));
        behind[row] = media_of(&arrivals, &boundaries, row, split.transmitted.get(row));
    }
    let reflections = Onward { sent: [true; N], directions: split.reflected, weights: reflected, media: in_front };
    arrivals.send(&reflections, Event::Mirrored, continuation, outlet, counts);
    counts.totally_reflected += hits.len() as u64 - count(&split.transmits);
    let transmissions =
        Onward { sent: split.transmits, directions: split.transmitted, weights: transmitted, media: behind };
    arrivals.send(&transmissions, Event::Refracted, continuation, outlet, counts);
}

/// The media around a ray of a row that leaves the boundary: the geometric normal decides on which side it runs.
#[inline(always)]
fn media_of<const N: usize>(
    arrivals: &Arrivals<'_, N>,
    boundaries: &Boundaries<N>,
    row: usize,
    direction: Vec3,
) -> MediaId {
    if direction.dot(arrivals.geometric.get(row)) < 0.0 { boundaries.behind[row] } else { arrivals.media[row] }
}

/// The boundaries that a block's rays hit.
struct Boundaries<const N: usize> {
    /// The media behind them.
    behind: [MediaId; N],
    /// The indices for the Fresnel equations, and how these are computed.
    eta_i: [f32; N],
    eta_t: [f32; N],
    models: [FresnelModel; N],
    specular: Vectors<N>,
    exponents: [f32; N],
}

impl<const N: usize> Boundaries<N> {
    #[inline(always)]
    fn new(arrivals: &Arrivals<'_, N>, stacks: &mut MediaStacks) -> Boundaries<N> {
        let dielectrics = arrivals.context.scene.materials.dielectric.view();
        let mut boundaries = Boundaries {
            behind: [MediaId::VACUUM; N],
            eta_i: [1.0; N],
            eta_t: [1.0; N],
            models: [FresnelModel::Exact; N],
            specular: Vectors::ZERO,
            exponents: [0.0; N],
        };
        // Neighbors mostly meet the same boundary.
        let mut last: Option<((MediaId, u32, bool), Boundary)> = None;
        for row in 0..N {
            let (hit, direction) = (arrivals.hit(row), arrivals.directions.get(row));
            let meets = (arrivals.media[row], hit.material, direction.dot(hit.point.geometric_normal) < 0.0);
            let boundary = match last {
                Some((same, boundary)) if same == meets => boundary,
                _ => stacks.boundary(meets.0, Medium(meets.1), meets.2, &dielectrics),
            };
            last = Some((meets, boundary));
            let material = hit.material as usize;
            boundaries.behind[row] = boundary.behind;
            [boundaries.eta_i[row], boundaries.eta_t[row]] = boundary.indices(direction, &hit.point, &dielectrics);
            boundaries.models[row] = dielectrics.fresnel[material];
            boundaries.specular.set(row, arrivals.color(row, dielectrics.specular[material]));
            boundaries.exponents[row] = dielectrics.exponent[material];
        }
        boundaries
    }
}

/// Where light goes at the boundaries.
struct Split<const N: usize> {
    /// The parts that are reflected, F_r; the rest is transmitted.
    reflectances: [f32; N],
    /// Unit mirror directions.
    reflected: Vectors<N>,
    /// Unit refracted directions of the rows that transmit something.
    transmitted: Vectors<N>,
    transmits: [bool; N],
}

impl<const N: usize> Split<N> {
    #[inline(always)]
    fn new(arrivals: &Arrivals<'_, N>, boundaries: &Boundaries<N>) -> Split<N> {
        let (mut reflected, mut transmitted) = (Vectors::<N>::ZERO, Vectors::<N>::ZERO);
        let (mut reflectances, mut cosines, mut transmits) = ([0.0; N], [0.0; N], [false; N]);
        for row in 0..N {
            let (eta_i, eta_t) = (boundaries.eta_i[row], boundaries.eta_t[row]);
            let fresnel = boundaries.models[row].dielectric(arrivals.cos_i(row), eta_i, eta_t);
            (reflectances[row], cosines[row]) = (fresnel.reflectance, fresnel.cos_t);
            transmits[row] = arrivals.counted[row] & !fresnel.is_total();
        }
        for row in 0..N {
            let (direction, normal) = (arrivals.directions.get(row), arrivals.normals.get(row));
            let ratio = boundaries.eta_i[row] / boundaries.eta_t[row];
            reflected.set(row, mirror(direction, normal));
            let refracted = || refract_with_cosine(direction, normal, cosines[row], ratio);
            transmitted.set(row, if transmits[row] { refracted() } else { Vec3::ZERO });
        }
        Split { reflectances, reflected, transmitted, transmits }
    }
}

/// The lights' images in the surfaces: a Phong lobe stands for each.
#[inline(always)]
fn highlight<const N: usize>(
    arrivals: &Arrivals<'_, N>,
    boundaries: &Boundaries<N>,
    split: &Split<N>,
    outlet: &mut impl Outlet,
) {
    for index in 0..arrivals.context.scene.lights.len() {
        let lamp = arrivals.lamp(index);
        let (mut contributions, mut lit, mut media) = (Vectors::<N>::ZERO, [false; N], arrivals.media);
        for row in 0..N {
            let toward = lamp.directions.get(row);
            let outside = arrivals.is_outside(row, toward);
            let reflectance = split.reflectances[row];
            let (part, lobe) = if outside {
                (reflectance, split.reflected.get(row))
            } else {
                (1.0 - reflectance, split.transmitted.get(row))
            };
            let factor = part * phong_highlight(toward, lobe, boundaries.exponents[row]);
            let seen_through = arrivals.weights.get(row) * boundaries.specular.get(row) * factor;
            contributions.set(row, seen_through * lamp.irradiances.get(row));
            lit[row] = outside | (split.transmits[row] & arrivals.is_inside(row, toward));
            media[row] = media_of(arrivals, boundaries, row, toward);
        }
        arrivals.toward(&lamp, &contributions, &lit, &media, outlet);
    }
}
