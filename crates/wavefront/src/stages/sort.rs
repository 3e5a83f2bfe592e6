//! Parts hits by kind of material, and those that escaped.

use brewster_buffers::{DetailId, MaterialKind};
use brewster_geometry::{HitsView, offset_origin, surface};

use crate::context::Context;
use crate::media::{MediaStacks, Medium};
use crate::queues::{
    CoatedHits, Crossing, CrossingQueue, DielectricHits, EmissiveHits, Escaped, EscapedQueue, LambertHits, MetalHits,
    PathRaysView, PhongHits, PrincipledHits, RoughDiffuseHits, SurfaceHit, SurfaceHitColumns, SurfaceHitsView,
};
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

/// Parts rays into escaped ones, crossings and hits by kind of material, in the rays' order, and finds the points of the
/// surfaces, with the normals to shade them.
///
/// Reads: rays, hits, instances, materials, and the textures that bend normals. Writes: the sorted hits, which are emptied first, and the media stacks.
pub fn sort(
    context: &Context<'_>,
    rays: PathRaysView<'_>,
    hits: HitsView<'_>,
    stacks: &mut MediaStacks,
    sorted: &mut SortedHits,
    counts: &mut Counts,
) {
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
        let material = materials.get(instances.material[hit.instance as usize].0 as usize);
        let mut point = surface(&context.geometry, &ray.ray(), &hit);
        if material.detail != DetailId::NONE {
            let place = point.place(hit.instance, hit.primitive);
            point.shading_normal = scene.bent_normal(material.detail, &place, &point, ray.ray().direction);
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
        }
    }
    counts.escaped += sorted.escaped.len() as u64;
    counts.crossings += sorted.crossings.len() as u64;
    counts.hits += sorted.hits() as u64;
}
