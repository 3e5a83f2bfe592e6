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
            // A counting sort: where each octant begins, and then every ray to its octant's next place.
            let view = rays.view();
            let octant = |row: usize| octant_of(view.direction_x[row], view.direction_y[row], view.direction_z[row]);
            let mut next = [0; 9];
            for row in 0..view.len() {
                next[octant(row) + 1] += 1;
            }
            for octant in 1..9 {
                next[octant] += next[octant - 1];
            }
            scratch.clear();
            scratch.extend_from_view(view);
            for row in 0..view.len() {
                let place = &mut next[octant(row)];
                scratch.set(*place, view.get(row));
                *place += 1;
            }
            std::mem::swap(rays, scratch);
        }
    }
}

fn octant_of(x: f32, y: f32, z: f32) -> usize {
    (x.to_bits() >> 31 | (y.to_bits() >> 31) << 1 | (z.to_bits() >> 31) << 2) as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::queues::PathRay;

    /// By hand: the signs of x, y and z are bits 0, 1 and 2 of the octant.
    #[test]
    fn octants_come_in_order_and_rays_of_one_stay_in_theirs() {
        let directions = [[1, 1, -1], [1, 1, 1], [-1, -1, -1], [1, -1, 1], [1, 1, 1], [-1, -1, -1], [1, 1, 1]];
        let ray = |(sample, [x, y, z]): (u32, [i32; 3])| PathRay {
            sample,
            direction_x: x as f32,
            direction_y: y as f32,
            direction_z: z as f32,
            ..PathRay::FOR_TESTS
        };
        let mut rays: PathRayColumns = (0..).zip(directions).map(ray).collect();
        order(SortKey::Octant, &mut rays, &mut PathRayColumns::new());
        assert_eq!(rays.view().sample, [1, 4, 6, 3, 0, 2, 5]);
        assert!(
            rays.view()
                .direction_x
                .iter()
                .zip(rays.view().sample)
                .all(|(&x, &p)| x == directions[p as usize][0] as f32)
        );
    }
}
