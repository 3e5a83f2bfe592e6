//! What many rays found, at once: [`surface`] for every hit of a batch.
//!
//! Hits on meshes wait until a block of them is full. What their points follow from is gathered number by number, so that the
//! routine of a single hit, run over the block in a loop, becomes vector code.

use brewster_lanes::{dispatch, prefetch};

use crate::block::{LANES, Numbers};
use crate::hit::HitsView;
use crate::ray::{Ray, Rays};
use crate::scene::SceneGeometry;
use crate::shape::{ShapeKind, with_shape};
use crate::surface::{MeshHit, SurfacePoint, surface};

/// Where the numbers of a [`MeshHit`] stand in a block.
const TO_WORLD: usize = 0;
const TO_OBJECT: usize = TO_WORLD + 12;
const ORIGIN: usize = TO_OBJECT + 12;
const DIRECTION: usize = ORIGIN + 3;
const CORNERS: usize = DIRECTION + 3;
const NORMALS: usize = CORNERS + 9;
const UVS: usize = NORMALS + 9;
const WEIGHTS: usize = UVS + 6;
const T: usize = WEIGHTS + 2;
const HAS_NORMALS: usize = T + 1;
const NUMBERS: usize = HAS_NORMALS + 1;

/// Numbers of a [`SurfacePoint`].
const FOUND: usize = 12;

dispatch! {
    /// The surface at every hit of [`closest_hits`](crate::closest_hits). Rows of `points` whose ray met nothing stay as they are.
    ///
    /// Reads: the scene, rays, hits. Writes: `points`, a row for each ray.
    pub fn surfaces<'a, 'b, 'c, 'd>(
        scene: &SceneGeometry<'a>,
        rays: Rays<'b>,
        hits: HitsView<'c>,
        points: &'d mut [SurfacePoint],
    ) {
        let mut block = Block { rows: [0; LANES], numbers: Numbers::default(), found: Numbers::default(), len: 0 };
        for row in 0..rays.len() {
            expect(scene, hits, row);
            let hit = hits.get(row);
            if hit.is_miss() {
                continue;
            }
            with_shape!(scene.table, scene.shapes[hit.instance as usize],
                _analytic => points[row] = surface(scene, &rays.get(row), &hit),
                mesh => {
                    let mut moved = None;
                    let (to_world, to_object) = scene.place_at(hit.instance, rays.time_of(row), &mut moved);
                    let mesh = &scene.table.meshes[mesh];
                    block.gather(row, &MeshHit::new(mesh, to_world, to_object, &rays.get(row), &hit));
                    if block.len == LANES {
                        block.find(points);
                    }
                }
            );
        }
        block.find(points);
    }
}

/// Asks the cache for what later rows will read of a mesh.
///
/// Triangles and vertices lie all over a mesh: on one too large for the cache, half of the time went by waiting for them.
#[inline(always)]
fn expect(scene: &SceneGeometry<'_>, hits: HitsView<'_>, row: usize) {
    const AHEAD: usize = 8;
    let mesh = |row: usize| {
        let instance = *hits.instance.get(row)?;
        let shape = scene.shapes.get(instance as usize).filter(|shape| shape.kind == ShapeKind::Mesh)?;
        Some((&scene.table.meshes[shape.row as usize], hits.primitive[row] as usize))
    };
    if let Some((mesh, triangle)) = mesh(row + 2 * AHEAD) {
        prefetch(mesh.triangles.as_ptr().wrapping_add(triangle));
    }
    if let Some((mesh, triangle)) = mesh(row + AHEAD) {
        for vertex in mesh.triangles[triangle] {
            prefetch(mesh.positions.as_ptr().wrapping_add(vertex as usize));
            prefetch(mesh.normals.as_ptr().wrapping_add(vertex as usize));
        }
    }
}

/// Hits on meshes that wait for each other.
struct Block {
    rows: [usize; LANES],
    numbers: Numbers<f32, NUMBERS>,
    found: Numbers<f32, FOUND>,
    len: usize,
}

impl Block {
    #[inline(always)]
    fn gather(&mut self, row: usize, hit: &MeshHit) {
        let (lane, numbers) = (self.len, &mut self.numbers);
        self.rows[lane] = row;
        self.len += 1;
        numbers.put_map(TO_WORLD, lane, &hit.to_world);
        numbers.put_map(TO_OBJECT, lane, &hit.to_object);
        for i in 0..3 {
            numbers.put(CORNERS + 3 * i, lane, hit.corners[i].to_array());
            numbers.put(NORMALS + 3 * i, lane, hit.normals[i].to_array());
            numbers.put(UVS + 2 * i, lane, hit.uvs[i].to_array());
        }
        numbers.put(ORIGIN, lane, hit.ray.origin.to_array());
        numbers.put(DIRECTION, lane, hit.ray.direction.to_array());
        numbers.put(WEIGHTS, lane, hit.weights);
        numbers.put(T, lane, [hit.t, f32::from(u8::from(hit.has_normals))]);
    }

    /// Finds the points of the hits that wait.
    #[inline(always)]
    fn find(&mut self, points: &mut [SurfacePoint]) {
        find_all(&self.numbers, &mut self.found);
        for lane in 0..self.len {
            let found = &self.found;
            points[self.rows[lane]] = SurfacePoint {
                position: found.vector(0, lane),
                geometric_normal: found.vector(3, lane),
                shading_normal: found.vector(6, lane),
                uv: found.pair(9, lane),
                error: found.0[11][lane],
            };
        }
        self.len = 0;
    }
}

#[inline(always)]
fn find_all(numbers: &Numbers<f32, NUMBERS>, found: &mut Numbers<f32, FOUND>) {
    for lane in 0..LANES {
        let vector = |first: usize| numbers.vector(first, lane);
        let hit = MeshHit {
            to_world: numbers.map(TO_WORLD, lane),
            to_object: numbers.map(TO_OBJECT, lane),
            ray: Ray { origin: vector(ORIGIN), direction: vector(DIRECTION), time: 0.0 },
            t: numbers.0[T][lane],
            weights: numbers.take(WEIGHTS, lane),
            corners: [vector(CORNERS), vector(CORNERS + 3), vector(CORNERS + 6)],
            normals: [vector(NORMALS), vector(NORMALS + 3), vector(NORMALS + 6)],
            has_normals: numbers.0[HAS_NORMALS][lane] != 0.0,
            uvs: [numbers.pair(UVS, lane), numbers.pair(UVS + 2, lane), numbers.pair(UVS + 4, lane)],
        };
        let point = hit.point();
        found.put(0, lane, point.position.to_array());
        found.put(3, lane, point.geometric_normal.to_array());
        found.put(6, lane, point.shading_normal.to_array());
        found.put(9, lane, point.uv.to_array());
        found.0[11][lane] = point.error;
    }
}
