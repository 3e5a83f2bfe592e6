//! Parts hits by kind of material, and those that escaped.

use brewster_buffers::{DetailId, MaterialKind, Mix};
use brewster_geometry::{HitsView, SurfacePlace, offset_origin, surface};

use crate::context::Context;
use crate::media::{MediaStacks, Medium};
use crate::queues::{
    CoatedHits, Crossing, CrossingQueue, DielectricHits, EmissiveHits, Escaped, EscapedQueue, LambertHits, MetalHits,
    PathRaysView, PhongHits, PrincipledHits, RoughDiffuseHits, SamplesView, SurfaceHit, SurfaceHitColumns,
    SurfaceHitsView,
};
use crate::random::Decision;
use crate::stats::Counts;

/// What became of the rays of one trace.
#[derive(Debug, Default)]
pub struct SortedHits {
    /// Rays that met nothing.
    pub escaped: EscapedQueue,
    /// Rays that met a boundary that is none.
    pub crossings: CrossingQueue,
    /// Hits on Phong materials.
    pub phong: PhongHits,
    /// Hits on Lambert materials.
    pub lambert: LambertHits,
    /// Hits on rough diffuse materials.
    pub rough_diffuse: RoughDiffuseHits,
    /// Hits on metals.
    pub metal: MetalHits,
    /// Hits on dielectrics.
    pub dielectric: DielectricHits,
    /// Hits on emissive surfaces.
    pub emissive: EmissiveHits,
    /// Hits on principled materials.
    pub principled: PrincipledHits,
    /// Hits on coated materials.
    pub coated: CoatedHits,
}

impl SortedHits {
    /// Drops all rows; keeps the memory.
    pub fn clear(&mut self) {
        self.escaped.clear();
        self.crossings.clear();
        self.phong.clear();
        self.lambert.clear();
        self.rough_diffuse.clear();
        self.metal.clear();
        self.dielectric.clear();
        self.emissive.clear();
        self.principled.clear();
        self.coated.clear();
    }

    /// Runs over the hits of every kind.
    pub fn each(&self, mut run: impl FnMut(SurfaceHitsView<'_>)) {
        run(self.phong.view().columns());
        run(self.lambert.view().columns());
        run(self.rough_diffuse.view().columns());
        run(self.metal.view().columns());
        run(self.dielectric.view().columns());
        run(self.emissive.view().columns());
        run(self.principled.view().columns());
        run(self.coated.view().columns());
    }

    /// Bytes of memory taken.
    pub fn bytes(&self) -> usize {
        let kinds = self.phong.capacity()
            + self.lambert.capacity()
            + self.rough_diffuse.capacity()
            + self.metal.capacity()
            + self.dielectric.capacity()
            + self.emissive.capacity()
            + self.principled.capacity()
            + self.coated.capacity();
        kinds * SurfaceHitColumns::BYTES_PER_ROW
            + self.escaped.capacity() * EscapedQueue::BYTES_PER_ROW
            + self.crossings.capacity() * CrossingQueue::BYTES_PER_ROW
    }

    /// Hits on surfaces.
    pub fn hits(&self) -> usize {
        self.phong.len()
            + self.lambert.len()
            + self.rough_diffuse.len()
            + self.metal.len()
            + self.dielectric.len()
            + self.emissive.len()
            + self.principled.len()
            + self.coated.len()
    }
}

/// The rays of one depth and what they met.
#[derive(Clone, Copy, Debug)]
pub struct Arrivals<'a> {
    /// The rays.
    pub rays: PathRaysView<'a>,
    /// Their hits.
    pub hits: HitsView<'a>,
    /// The samples that they belong to.
    pub samples: SamplesView<'a>,
    /// Their depth.
    pub depth: u32,
}

/// Parts rays into escaped ones, crossings and hits by kind of material, in the rays' order, and finds the points of the
/// surfaces, with the normals to shade them.
///
/// Reads: rays, hits, instances, materials, the textures that bend normals and mix, and random numbers for mixes. Writes: the sorted hits, which are emptied first, and the media stacks.
pub fn sort(
    context: &Context<'_>,
    arrivals: Arrivals<'_>,
    stacks: &mut MediaStacks,
    sorted: &mut SortedHits,
    counts: &mut Counts,
) {
    let Arrivals { rays, hits, .. } = arrivals;
    let scene = context.scene;
    let instances = scene.instances.view();
    let materials = scene.materials.rows.view();
    let dielectrics = scene.materials.dielectric.view();
    sorted.clear();
    for row in 0..rays.len() {
        let hit = hits.get(row);
        let ray = rays.get(row);
        if hit.is_miss() {
            sorted.escaped.push(Escaped { ray: row as u32 });
            continue;
        }
        let mut material = materials.get(instances.material[hit.instance as usize].0 as usize);
        let mut point = surface(&context.geometry, &ray.ray(), &hit);
        if material.detail != DetailId::NONE {
            let place = point.place(hit.instance, hit.primitive);
            point.shading_normal = scene.bent_normal(material.detail, &place, &point, ray.ray().direction);
        }
        if material.kind == MaterialKind::Mix {
            let place = point.place(hit.instance, hit.primitive);
            (material.kind, material.row) = resolve(context, &arrivals, row, material.row, &place);
        }
        if let Some(medium) = scene.materials.medium(material) {
            let direction = ray.ray().direction;
            let inward = direction.dot(point.geometric_normal) < 0.0;
            let boundary = stacks.boundary(ray.media, Medium(medium), inward, &dielectrics);
            if boundary.filling_before == boundary.filling_behind {
                sorted.crossings.push(Crossing {
                    ray: row as u32,
                    media: boundary.behind,
                    origin: offset_origin(&point, direction),
                });
                continue;
            }
        }
        let hit = SurfaceHit {
            ray: row as u32,
            instance: hit.instance,
            primitive: hit.primitive,
            material: material.row,
            point,
        };
        match material.kind {
            MaterialKind::Phong => sorted.phong.push(hit),
            MaterialKind::Lambert => sorted.lambert.push(hit),
            MaterialKind::RoughDiffuse => sorted.rough_diffuse.push(hit),
            MaterialKind::Metal => sorted.metal.push(hit),
            MaterialKind::Dielectric => sorted.dielectric.push(hit),
            MaterialKind::Emissive => sorted.emissive.push(hit),
            MaterialKind::Principled => sorted.principled.push(hit),
            MaterialKind::Coated => sorted.coated.push(hit),
            MaterialKind::Mix => unreachable!("a hit is of one of the two"),
        }
    }
    counts.escaped += sorted.escaped.len() as u64;
    counts.crossings += sorted.crossings.len() as u64;
    counts.hits += sorted.hits() as u64;
}

/// The material of a mix that a ray meets, its kind and row: one of both by a number, at every level of mixes in mixes by another.
fn resolve(
    context: &Context<'_>,
    arrivals: &Arrivals<'_>,
    row: usize,
    mix: u32,
    place: &SurfacePlace,
) -> (MaterialKind, u32) {
    let sample = arrivals.rays.sample[row];
    let stream = arrivals.samples.stream(&context.sampler, sample, arrivals.rays.branch[row]);
    let (mut met, mut level) = ((MaterialKind::Mix, mix), 0);
    while met.0 == MaterialKind::Mix {
        let Mix { a, b, by } = context.scene.materials.mix.get(met.1 as usize);
        level += 1;
        let number = context.sampler.one(stream, Decision::Crossing.at(arrivals.depth).repeat(level));
        met = if number < context.scene.number(by, place) { b } else { a };
    }
    met
}
