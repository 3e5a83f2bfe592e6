//! Orders rays before they are traced.

use glam::Vec3;

use crate::context::Context;
use crate::policy::SortKey;
use crate::queues::{NO_INSTANCE, PathRay, PathRayColumns};

/// Memory that [`order`] reuses.
#[derive(Debug, Default)]
pub struct OrderScratch {
    rays: PathRayColumns,
    /// Keys above rows.
    keys: Vec<u64>,
    spare: Vec<u64>,
}

impl OrderScratch {
    /// Memory for `capacity` rays.
    pub fn with_capacity(capacity: usize) -> OrderScratch {
        OrderScratch { rays: PathRayColumns::with_capacity(capacity), ..Default::default() }
    }

    /// Bytes of memory taken.
    pub fn bytes(&self) -> usize {
        self.rays.capacity() * PathRayColumns::BYTES_PER_ROW
            + (self.keys.capacity() + self.spare.capacity()) * size_of::<u64>()
    }
}

/// Orders rays by the policy's key, stably: rays of one key keep their order.
///
/// Reads and writes: the rays, by way of `scratch`.
pub fn order(context: &Context<'_>, rays: &mut PathRayColumns, scratch: &mut OrderScratch) {
    let bounds = context.geometry.top.bounds();
    let cell = |ray: &PathRay| {
        let origin = Vec3::new(ray.origin_x, ray.origin_y, ray.origin_z);
        morton((origin - bounds.min) / (bounds.max - bounds.min))
    };
    match context.policy.sort {
        SortKey::None => {}
        SortKey::Material => {
            let materials = context.scene.instances.view().material;
            let number = |ray: &PathRay| match ray.instance {
                NO_INSTANCE => 0,
                instance => u64::from(materials[instance as usize].0) + 1,
            };
            let bits = usize::BITS - context.scene.materials.rows.len().leading_zeros();
            sort(bits, number, rays, scratch);
        }
        SortKey::Octant => sort(3, octant, rays, scratch),
        SortKey::Morton => sort(30, cell, rays, scratch),
        SortKey::OctantMorton => sort(33, |ray| octant(ray) << 30 | cell(ray), rays, scratch),
    }
}

/// Bits of a key that one pass looks at.
const DIGIT: u32 = 11;

/// Bits of a row's number; the key stands above them.
const ROW: u32 = 31;

/// Sorts by a key of so many bits, the lowest digits first: each pass counts its digits, and then takes every ray to its digit's
/// next place.
#[inline(always)]
fn sort(bits: u32, key: impl Fn(&PathRay) -> u64, rays: &mut PathRayColumns, scratch: &mut OrderScratch) {
    let OrderScratch { rays: sorted, keys, spare } = scratch;
    keys.clear();
    keys.reserve(rays.capacity());
    keys.extend((0..rays.len()).map(|row| key(&rays.get(row)) << ROW | row as u64));
    spare.reserve(rays.capacity());
    spare.resize(keys.len(), 0);
    for low in (0..bits).step_by(DIGIT as usize) {
        let digit = |key: u64| (key >> (ROW + low)) as usize & ((1 << DIGIT) - 1);
        let mut next = [0u32; (1 << DIGIT) + 1];
        for &key in keys.iter() {
            next[digit(key) + 1] += 1;
        }
        for digit in 1..next.len() {
            next[digit] += next[digit - 1];
        }
        for &key in keys.iter() {
            let place = &mut next[digit(key)];
            spare[*place as usize] = key;
            *place += 1;
        }
        std::mem::swap(keys, spare);
    }
    sorted.clear();
    for &key in keys.iter() {
        sorted.push(rays.get((key & ((1 << ROW) - 1)) as usize));
    }
    std::mem::swap(rays, sorted);
}

/// The signs of x, y and z in bits 0, 1 and 2.
#[inline(always)]
pub(crate) fn octant(ray: &PathRay) -> u64 {
    let sign = |value: f32| u64::from(value.to_bits() >> 31);
    sign(ray.direction_x) | sign(ray.direction_y) << 1 | sign(ray.direction_z) << 2
}

/// The place on a Morton curve of a point in the unit cube, of 1,024 cells along each axis: bits of x, y and z in turn, x lowest. Points
/// outside count to the nearest cell.
#[inline(always)]
fn morton(point: Vec3) -> u64 {
    // What is no number comes from bounds without extent and becomes 0.
    let cells = (point * 1024.0).to_array().map(|cell| (cell as u32).min(1023));
    let spread = |cell: u32| (0..10).fold(0, |bits, bit| bits | u64::from(cell >> bit & 1) << (3 * bit));
    spread(cells[0]) | spread(cells[1]) << 1 | spread(cells[2]) << 2
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand: the signs of x, y and z are bits 0, 1 and 2 of the octant.
    #[test]
    fn octants_come_in_order_and_rays_of_one_stay_in_theirs() {
        let directions = [[1, 1, -1], [1, 1, 1], [-1, -1, -1], [1, -1, 1], [1, 1, 1], [-1, -1, -1], [1, 1, 1]];
        let ray = |(sample, [x, y, z]): (u32, [i32; 3])| PathRay {
            sample,
            direction_x: x as f32,
            direction_y: y as f32,
            direction_z: z as f32,
            ..PathRay::START
        };
        let mut rays: PathRayColumns = (0..).zip(directions).map(ray).collect();
        sort(3, octant, &mut rays, &mut OrderScratch::default());
        assert_eq!(rays.view().sample, [1, 4, 6, 3, 0, 2, 5]);
        assert!(
            rays.view()
                .direction_x
                .iter()
                .zip(rays.view().sample)
                .all(|(&x, &p)| x == directions[p as usize][0] as f32)
        );
    }

    /// Against the standard library's stable sort, with keys longer than a digit.
    #[test]
    fn long_keys_sort_as_the_standard_library_sorts_them() {
        let key = |ray: &PathRay| u64::from(ray.branch.wrapping_mul(0x9e37_79b9)) >> 4;
        let mut expected: Vec<PathRay> =
            (0..3000).map(|n| PathRay { branch: n % 700, sample: n, ..PathRay::START }).collect();
        let mut rays: PathRayColumns = expected.iter().copied().collect();
        expected.sort_by_key(key);
        sort(28, key, &mut rays, &mut OrderScratch::default());
        let expected: Vec<u32> = expected.iter().map(|ray| ray.sample).collect();
        assert_eq!(rays.view().sample, expected);
    }

    /// By hand: x = 1 is bit 0, y = 1 bit 1, z = 1 bit 2, x = 2 bit 3; the last cell has all bits.
    #[test]
    fn the_curve_takes_bits_in_turn() {
        for ([x, y, z], expected) in [
            ([0.0, 0.0, 0.0], 0),
            ([1.0, 0.0, 0.0], 1),
            ([0.0, 1.0, 0.0], 2),
            ([0.0, 0.0, 1.0], 4),
            ([2.0, 0.0, 0.0], 8),
            ([3.0, 1.0, 0.0], 11),
            ([-5.0, 0.0, 0.0], 0),
            ([f32::NAN, 0.0, 0.0], 0),
            ([1023.0, 1023.0, 5000.0], (1 << 30) - 1),
        ] {
            assert_eq!(morton(Vec3::new(x, y, z) / 1024.0), expected, "{x} {y} {z}");
        }
    }
}
