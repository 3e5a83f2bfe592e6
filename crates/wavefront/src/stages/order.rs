//! Orders rays before they are traced.

use crate::policy::SortKey;
use crate::queues::PathRayColumns;

/// Orders rays by a key, stably: rays of one key keep their order.
///
/// Reads and writes: the rays, by way of `scratch`.
pub fn order(key: SortKey, rays: &mut PathRayColumns, scratch: &mut PathRayColumns) {
    match key {
        SortKey::None => {}
        SortKey::Octant => {
            scratch.clear();
            for octant in 0..8 {
                for row in 0..rays.len() {
                    let ray = rays.get(row);
                    if octant_of(ray.direction_x, ray.direction_y, ray.direction_z) == octant {
                        scratch.push(ray);
                    }
                }
            }
            std::mem::swap(rays, scratch);
        }
    }
}

fn octant_of(x: f32, y: f32, z: f32) -> u32 {
    x.to_bits() >> 31 | (y.to_bits() >> 31) << 1 | (z.to_bits() >> 31) << 2
}
