//! What is known of a block of arriving rays, in columns.

#![expect(clippy::needless_range_loop, reason = "what belongs to a row stands in many columns")]

use brewster_buffers::LightSample;
use brewster_geometry::{SurfacePoint, offset_origin};
use brewster_optics::basis::Basis;
use brewster_optics::dispersion::PathWavelength;
use brewster_optics::lobe::LobeSample;
use glam::{Vec2, Vec3};

use super::{Scatter, Surface, asked, disperse, sides};
use crate::context::Context;
use crate::guide::{Cell, Guide};
use crate::media::{MediaId, MediaStacks};
use crate::queues::{PathRay, SurfaceHit, Trail};
use crate::random::Stream;
use crate::stages::Numbers;
use crate::stages::shade::facing;
use crate::stages::vectors::Vectors;

/// Rays that arrive, and what each meets: at most as many as a block has lanes. What lies beyond is some row's copy.
pub(crate) trait Rows {
    /// The random numbers of a row.
    type Numbers: Numbers;

    /// Rows that count.
    fn len(&self) -> usize;
    /// The rays' depth.
    fn depth(&self) -> u32;
    /// A ray.
    fn ray(&self, lane: usize) -> PathRay;
    /// Where it goes.
    fn direction(&self, lane: usize) -> Vec3;
    /// Its hit.
    fn hit(&self, lane: usize) -> SurfaceHit;
    /// The surface there.
    fn point(&self, lane: usize) -> SurfacePoint;
    /// Its random numbers.
    fn numbers(&self, lane: usize) -> Self::Numbers;
    /// The numbers of a branch of a ray's path.
    fn stream(&self, ray: &PathRay, branch: u32) -> Stream;
}

/// What rays bring.
pub(super) struct Loads<const N: usize> {
    /// Their weights before their wavelengths were drawn, and since then.
    pub(super) arrived: Vectors<N>,
    pub(super) weights: Vectors<N>,
    pub(super) wavelengths: [PathWavelength; N],
    pub(super) samples: [u32; N],
    pub(super) trails: [Trail; N],
    pub(super) branches: [u32; N],
    pub(super) instances: [u32; N],
    /// The media on the sides of the geometric normal.
    pub(super) media: [[MediaId; 2]; N],
    /// Whether the surfaces let light through.
    pub(super) transmits: [bool; N],
    /// What the ledger expects that they scatter, where it does.
    pub(super) albedos: Vectors<N>,
    pub(super) known: [bool; N],
}

impl<const N: usize> Loads<N> {
    pub(super) const NONE: Loads<N> = Loads {
        arrived: Vectors::<N>::ZERO,
        weights: Vectors::<N>::ZERO,
        wavelengths: [PathWavelength::NONE; N],
        samples: [0; N],
        trails: [Trail::CAMERA; N],
        branches: [0; N],
        instances: [0; N],
        media: [[MediaId::VACUUM; 2]; N],
        transmits: [false; N],
        albedos: Vectors::<N>::ZERO,
        known: [false; N],
    };

    /// Takes what a ray brings, and tells the surface that it meets.
    #[inline(always)]
    pub(super) fn take<Kind: Scatter>(
        &mut self,
        context: &Context<'_>,
        rows: &impl Rows,
        row: usize,
        places: &Places<N>,
        stacks: &mut MediaStacks,
    ) -> Kind::Surface {
        let (mut ray, hit, view) = (rows.ray(row), rows.hit(row), places.views.get(row));
        let mut sides = sides::<Kind>(context, &ray, &hit, places.normals.get(row), stacks);
        self.arrived.set(row, ray.weight);
        if Kind::TRANSMITS {
            disperse(context, &mut ray, sides.filling, |ray| rows.stream(ray, 1));
        }
        sides.wavelength = ray.wavelength;
        let surface = Kind::surface(context, &hit, &sides);
        self.weights.set(row, ray.weight);
        (self.wavelengths[row], self.samples[row]) = (ray.wavelength, ray.sample);
        (self.trails[row], self.branches[row]) = (ray.trail, ray.branch);
        (self.instances[row], self.media[row]) = (hit.instance, sides.media);
        self.transmits[row] = surface.transmits();
        if let Some(tables) = &context.albedos {
            let albedo = Kind::albedo(tables, &surface, &hit, &sides, view.z)
                .or_else(|| asked(context, &surface, view, rows.stream(&ray, ray.branch), rows.depth()));
            self.known[row] = albedo.is_some();
            self.albedos.set(row, albedo.unwrap_or(Vec3::ZERO));
        }
        surface
    }
}

/// Where the rays arrive.
pub(super) struct Places<const N: usize> {
    pub(super) positions: Vectors<N>,
    /// The geometric normals as they are, and on the sides that the rays came from.
    pub(super) outward: Vectors<N>,
    pub(super) geometric: Vectors<N>,
    pub(super) errors: [f32; N],
    pub(super) tangents: Vectors<N>,
    pub(super) bitangents: Vectors<N>,
    pub(super) normals: Vectors<N>,
    pub(super) views: Vectors<N>,
}

impl<const N: usize> Places<N> {
    #[inline(always)]
    pub(super) fn new(rows: &impl Rows) -> Places<N> {
        let [mut positions, mut outward, mut geometric, mut normals, mut views] = [Vectors::<N>::ZERO; 5];
        let [mut tangents, mut bitangents] = [Vectors::<N>::ZERO; 2];
        let mut errors = [0.0; N];
        for row in 0..N {
            let SurfacePoint { position, geometric_normal, shading_normal, error, .. } = rows.point(row);
            positions.set(row, position);
            outward.set(row, geometric_normal);
            normals.set(row, shading_normal);
            views.set(row, -rows.direction(row));
            errors[row] = error;
        }
        for row in 0..N {
            let back = views.get(row);
            let frame = Basis::around(facing(normals.get(row), -back));
            geometric.set(row, facing(outward.get(row), -back));
            tangents.set(row, frame.tangent);
            bitangents.set(row, frame.bitangent);
            normals.set(row, frame.normal);
            views.set(row, frame.to_local(back));
        }
        Places { positions, outward, geometric, errors, tangents, bitangents, normals, views }
    }

    #[inline(always)]
    pub(super) fn frame(&self, row: usize) -> Basis {
        let (tangent, bitangent, normal) = (self.tangents.get(row), self.bitangents.get(row), self.normals.get(row));
        Basis { tangent, bitangent, normal }
    }

    /// Where a ray starts that leaves in a direction.
    #[inline(always)]
    pub(super) fn origin(&self, context: &Context<'_>, row: usize, direction: Vec3) -> Vec3 {
        let point = SurfacePoint {
            position: self.positions.get(row),
            geometric_normal: self.outward.get(row),
            shading_normal: Vec3::ZERO,
            uv: Vec2::ZERO,
            error: self.errors[row],
        };
        let origin = offset_origin(&point, direction);
        let offset = context.scene.settings.ray_offset;
        if offset == 0.0 {
            return origin;
        }
        let geometric = self.geometric.get(row);
        let further = offset * (1.0 + point.position.abs().max_element());
        origin + geometric * further.copysign(direction.dot(geometric))
    }
}

/// What the guide knows of the places.
pub(super) struct Guidance<'g, const N: usize> {
    guide: Option<&'g Guide>,
    cells: [Option<&'g Cell>; N],
}

impl<'g, const N: usize> Guidance<'g, N> {
    #[inline(always)]
    pub(super) fn new<S: Surface>(context: &'g Context<'_>, surfaces: &[S; N], places: &Places<N>) -> Guidance<'g, N> {
        let guide = context.guide.as_ref();
        let mut cells = [None; N];
        if let Some(guide) = guide {
            let found = guide.cells.find(&places.positions);
            for row in 0..N {
                if surfaces[row].is_guided() {
                    cells[row] = found[row];
                }
            }
        }
        Guidance { guide, cells }
    }

    /// Whether rays are directed in a row.
    #[inline(always)]
    pub(super) fn directs(&self, row: usize) -> bool {
        self.cells[row].is_some()
    }

    /// Parts a row's number into whether its ray is directed, and what is left of it for the one who chooses.
    #[inline(always)]
    pub(super) fn part(&self, row: usize, number: f32) -> (bool, f32) {
        let share = if let Some(cell) = self.cells[row] { cell.share } else { 0.0 };
        let directed = number < share;
        let rest = if directed { number / share } else { (number - share) / (1.0 - share) };
        (directed, rest.min(1.0f32.next_down()))
    }

    /// Directs rays by the marks and numbers of their rows, and weighs all of the rows that have a cell by the densities of both ways to choose.
    #[inline(always)]
    pub(super) fn direct<S: Surface>(
        &self,
        (surfaces, places): (&[S; N], &Places<N>),
        (marks, choices, [xs, ys]): (&[bool; N], &[f32; N], [&[f32; N]; 2]),
        chosen: &mut Chosen<N>,
    ) {
        let Some(Guide { cells, .. }) = self.guide else { return };
        for row in 0..N {
            let Some(cell) = self.cells[row] else { continue };
            let frame = places.frame(row);
            if marks[row] {
                let direction = cells.sample(cell, choices[row], Vec2::new(xs[row], ys[row]));
                chosen.there[row] = true;
                chosen.directions.set(row, frame.to_local(direction));
            }
            let local = chosen.directions.get(row);
            let value = surfaces[row].evaluate(places.views.get(row), local);
            let own = value.chosen_pdf();
            let pdf = mixed(cell.share, own, cells.pdf(cell, frame.to_world(local)));
            chosen.there[row] &= own > 0.0;
            chosen.weights.set(row, value.f_cos / pdf);
            chosen.pdfs[row] = pdf;
            chosen.densities[row] = pdf / own;
        }
    }

    /// Makes the densities with which surfaces choose directions, of those rows that are marked, the densities of both ways to choose.
    #[inline(always)]
    pub(super) fn mix(&self, marks: &[bool; N], directions: &Vectors<N>, densities: &mut [f32; N]) {
        let Some(Guide { cells, .. }) = self.guide else { return };
        for row in 0..N {
            if let Some(cell) = self.cells[row]
                && marks[row]
            {
                densities[row] = mixed(cell.share, densities[row], cells.pdf(cell, directions.get(row)));
            }
        }
    }
}

/// The density of what the guide chooses with a share of all chances, and otherwise the surface.
#[inline(always)]
fn mixed(share: f32, own: f32, guided: f32) -> f32 {
    (1.0 - share) * own + share * guided
}

/// Lights that were drawn for the rows.
pub(super) struct Lights<const N: usize> {
    pub(super) there: [bool; N],
    pub(super) directions: Vectors<N>,
    pub(super) distances: [f32; N],
    pub(super) targets: Vectors<N>,
    pub(super) radiances: Vectors<N>,
    pub(super) pdfs: [f32; N],
    pub(super) is_delta: [bool; N],
}

impl<const N: usize> Lights<N> {
    pub(super) const NONE: Lights<N> = Lights {
        there: [false; N],
        directions: Vectors::<N>::ZERO,
        distances: [f32::INFINITY; N],
        targets: Vectors::<N>::ZERO,
        radiances: Vectors::<N>::ZERO,
        pdfs: [1.0; N],
        is_delta: [false; N],
    };

    #[inline(always)]
    pub(super) fn get(&self, row: usize) -> LightSample {
        LightSample {
            direction: self.directions.get(row),
            distance: self.distances[row],
            target: self.targets.get(row),
            radiance: self.radiances.get(row),
            pdf: self.pdfs[row],
            is_delta: self.is_delta[row],
        }
    }

    #[inline(always)]
    pub(super) fn set(&mut self, row: usize, light: &LightSample) {
        self.there[row] = true;
        self.directions.set(row, light.direction);
        self.distances[row] = light.distance;
        self.targets.set(row, light.target);
        self.radiances.set(row, light.radiance);
        self.pdfs[row] = light.pdf;
        self.is_delta[row] = light.is_delta;
    }
}

/// What surfaces chose to send on.
pub(super) struct Chosen<const N: usize> {
    /// Rows that were asked.
    pub(super) asked: [bool; N],
    pub(super) there: [bool; N],
    pub(super) directions: Vectors<N>,
    pub(super) weights: Vectors<N>,
    pub(super) pdfs: [f32; N],
    /// The densities, as parts of those with which the surfaces alone choose the directions.
    pub(super) densities: [f32; N],
    pub(super) branches: [u32; N],
}

impl<const N: usize> Chosen<N> {
    pub(super) const NOTHING: Chosen<N> = Chosen {
        asked: [false; N],
        there: [false; N],
        directions: Vectors::<N>::ZERO,
        weights: Vectors::<N>::ZERO,
        pdfs: [0.0; N],
        densities: [1.0; N],
        branches: [0; N],
    };

    #[inline(always)]
    pub(super) fn set(&mut self, row: usize, sample: Option<LobeSample>, branch: u32) {
        const NONE: LobeSample =
            LobeSample { direction: Vec3::ZERO, weight: Vec3::ZERO, pdf: 0.0, radiance_scale: 1.0 };
        self.there[row] = sample.is_some();
        let sample = sample.unwrap_or(NONE);
        self.directions.set(row, sample.direction);
        self.weights.set(row, sample.weight);
        self.pdfs[row] = sample.pdf;
        self.branches[row] = branch;
    }
}
