//! Steps on registers of eight lanes: those of waves, and what packets share with them.
#![expect(unsafe_code, reason = "intrinsics need an instruction set, which the kernels' callers prove")]

use std::arch::x86_64::*;

use super::slabs::Slabs;
use crate::tree::node::{Node, Patch};
use crate::triangle::Shear;

/// Where a ray enters the eight boxes of a node, and where it leaves them or ends.
///
/// # Safety
/// The machine has AVX2 and FMA.
#[inline(always)]
pub(super) unsafe fn boxes(slabs: &Slabs, node: &Node, limit: f32) -> (__m256, __m256) {
    // SAFETY: as stated; nodes are aligned and have eight lanes, columns of planes are below six.
    unsafe {
        let (mut enter, mut leave) = (_mm256_setzero_ps(), _mm256_set1_ps(limit));
        for axis in 0..3 {
            let column = slabs.near_plane[axis] as usize;
            let near = _mm256_load_ps(node.planes.get_unchecked(column).as_ptr());
            let far = _mm256_load_ps(node.planes.get_unchecked(column ^ 1).as_ptr());
            let inverse = _mm256_set1_ps(slabs.inverse[axis]);
            enter = _mm256_max_ps(_mm256_fmsub_ps(near, inverse, _mm256_set1_ps(slabs.near[axis])), enter);
            leave = _mm256_min_ps(_mm256_fmsub_ps(far, inverse, _mm256_set1_ps(slabs.far[axis])), leave);
        }
        (enter, leave)
    }
}

/// Keys that sort like distances: their bits, with the lane in the last three.
///
/// # Safety
/// The machine has AVX2.
#[inline(always)]
pub(super) unsafe fn keys(enter: __m256) -> __m256i {
    // SAFETY: as stated.
    unsafe {
        let lanes = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
        _mm256_or_si256(_mm256_andnot_si256(_mm256_set1_epi32(7), _mm256_castps_si256(enter)), lanes)
    }
}

/// A patch in the sheared space of a ray.
pub(super) struct Sheared {
    x: __m256,
    y: __m256,
    z: __m256,
    /// Which vertices are the triangles' corners.
    corners: [__m256i; 3],
    /// The three products of each triangle.
    products: [__m256; 3],
    /// The least and the greatest of them.
    pub(super) least: __m256,
    pub(super) most: __m256,
}

impl Sheared {
    /// # Safety
    /// The machine has AVX2.
    #[inline(always)]
    pub(super) unsafe fn new(shear: &Shear, patch: &Patch) -> Sheared {
        // SAFETY: as stated; patches are aligned and have eight lanes, axes are below three.
        unsafe {
            // Macros, since closures would not be compiled for the instruction set.
            macro_rules! relative {
                ($side:literal) => {{
                    let axis = shear.axes[$side] as usize;
                    let vertices = _mm256_load_ps(patch.vertices.get_unchecked(axis).as_ptr());
                    _mm256_sub_ps(vertices, _mm256_set1_ps(*shear.origin.get_unchecked(axis)))
                }};
            }
            macro_rules! corner {
                ($side:literal) => {
                    _mm256_cvtepu8_epi32(_mm_loadl_epi64(patch.corners[$side].as_ptr().cast()))
                };
            }
            let z = relative!(2);
            let x = _mm256_sub_ps(relative!(0), _mm256_mul_ps(_mm256_set1_ps(shear.slope[0]), z));
            let y = _mm256_sub_ps(relative!(1), _mm256_mul_ps(_mm256_set1_ps(shear.slope[1]), z));
            let (a, b, c) = (corner!(0), corner!(1), corner!(2));
            let (ax, ay) = (_mm256_permutevar8x32_ps(x, a), _mm256_permutevar8x32_ps(y, a));
            let (bx, by) = (_mm256_permutevar8x32_ps(x, b), _mm256_permutevar8x32_ps(y, b));
            let (cx, cy) = (_mm256_permutevar8x32_ps(x, c), _mm256_permutevar8x32_ps(y, c));
            let u = _mm256_sub_ps(_mm256_mul_ps(cx, by), _mm256_mul_ps(cy, bx));
            let v = _mm256_sub_ps(_mm256_mul_ps(ax, cy), _mm256_mul_ps(ay, cx));
            let w = _mm256_sub_ps(_mm256_mul_ps(bx, ay), _mm256_mul_ps(by, ax));
            let least = _mm256_min_ps(_mm256_min_ps(u, v), w);
            let most = _mm256_max_ps(_mm256_max_ps(u, v), w);
            Sheared { x, y, z, corners: [a, b, c], products: [u, v, w], least, most }
        }
    }

    /// A bit for every triangle whose plane the ray may meet after its start and before `limit`: all but those that f64 would refuse,
    /// most of all the triangle that the ray starts from.
    ///
    /// In units of ε = 2⁻²⁴, with M the largest of a triangle's sheared |x| and |y| and Z its largest |z|: a product is off by at most
    /// 4 εM², their sum by 22 εM², and their sum weighted by z by 28 εM²Z. With 64 for all of them the roundings of the
    /// comparisons and of t itself are covered, too. Where the sum may be zero, nothing is told of the triangle.
    ///
    /// # Safety
    /// The machine has AVX2 and FMA.
    #[inline(always)]
    pub(super) unsafe fn in_reach(&self, shear: &Shear, limit: f32) -> u32 {
        // SAFETY: as stated; axes are below three.
        unsafe {
            let sign = _mm256_set1_ps(-0.0);
            let (mut largest, mut deepest) = (_mm256_setzero_ps(), _mm256_setzero_ps());
            let (mut sum, mut weighted) = (_mm256_setzero_ps(), _mm256_setzero_ps());
            for side in 0..3 {
                let (corner, product) = (self.corners[side], self.products[side]);
                let (x, y) = (_mm256_permutevar8x32_ps(self.x, corner), _mm256_permutevar8x32_ps(self.y, corner));
                let z = _mm256_permutevar8x32_ps(self.z, corner);
                let larger = _mm256_max_ps(_mm256_andnot_ps(sign, x), _mm256_andnot_ps(sign, y));
                largest = _mm256_max_ps(largest, larger);
                deepest = _mm256_max_ps(deepest, _mm256_andnot_ps(sign, z));
                sum = _mm256_add_ps(sum, product);
                weighted = _mm256_fmadd_ps(product, z, weighted);
            }
            let step = *shear.direction.get_unchecked(shear.axes[2] as usize);
            let turn = _mm256_and_ps(sign, _mm256_xor_ps(sum, _mm256_set1_ps(step)));
            // t times the length that it is multiplied with.
            let ahead = _mm256_xor_ps(weighted, turn);
            let length = _mm256_andnot_ps(sign, sum);
            let error = _mm256_mul_ps(_mm256_mul_ps(largest, largest), _mm256_set1_ps(64.0 / (1 << 24) as f32));
            let depth_error = _mm256_mul_ps(error, deepest);
            let farthest = _mm256_mul_ps(_mm256_add_ps(length, error), _mm256_set1_ps(limit * step.abs()));
            let behind = _mm256_cmp_ps::<_CMP_LT_OQ>(ahead, _mm256_xor_ps(depth_error, sign));
            let beyond = _mm256_cmp_ps::<_CMP_GT_OQ>(ahead, _mm256_add_ps(farthest, depth_error));
            let certain = _mm256_cmp_ps::<_CMP_GT_OQ>(length, error);
            !(_mm256_movemask_ps(_mm256_and_ps(_mm256_or_ps(behind, beyond), certain)) as u32)
        }
    }

    /// # Safety
    /// The machine has AVX2.
    #[inline(always)]
    pub(super) unsafe fn store(&self, to: &mut [[f32; 8]; 3]) {
        // SAFETY: as stated; there are eight lanes in each row.
        unsafe {
            _mm256_storeu_ps(to[0].as_mut_ptr(), self.x);
            _mm256_storeu_ps(to[1].as_mut_ptr(), self.y);
            _mm256_storeu_ps(to[2].as_mut_ptr(), self.z);
        }
    }
}

/// Stores keys that are compressed to the front, the greatest first. At most four are the rule: those are sorted in one small
/// network.
///
/// # Safety
/// The machine has AVX2, and both stacks have room for eight entries.
#[inline(always)]
pub(super) unsafe fn store_ordered(
    keys: __m256i,
    count: u32,
    children: __m256i,
    distances: *mut f32,
    references: *mut u32,
) {
    macro_rules! stage {
        ($keys:expr, $other:expr, $greater:literal) => {{
            let (a, b) = ($keys, $other);
            _mm_blend_epi32::<$greater>(_mm_min_epi32(a, b), _mm_max_epi32(a, b))
        }};
    }
    // SAFETY: the caller has room for eight entries, and the instruction set.
    unsafe {
        let four = _mm256_castsi256_si128(keys);
        let four = stage!(four, _mm_shuffle_epi32::<0b10_11_00_01>(four), 0b0101);
        let four = stage!(four, _mm_shuffle_epi32::<0b00_01_10_11>(four), 0b0011);
        let four = stage!(four, _mm_shuffle_epi32::<0b10_11_00_01>(four), 0b0101);
        let order = _mm256_castsi128_si256(four);
        let sorted = _mm256_castsi256_si128(_mm256_permutevar8x32_epi32(children, order));
        _mm_storeu_si128(references.cast(), sorted);
        _mm_storeu_si128(distances.cast(), _mm_andnot_si128(_mm_set1_epi32(7), four));
        if count > 4 {
            let eight = sort_eight(keys);
            _mm256_storeu_si256(references.cast(), _mm256_permutevar8x32_epi32(children, eight));
            _mm256_storeu_si256(distances.cast(), _mm256_andnot_si256(_mm256_set1_epi32(7), eight));
        }
    }
}

/// Eight keys, the greatest first: Batcher's bitonic network.
///
/// # Safety
/// The machine has AVX2.
#[inline(always)]
unsafe fn sort_eight(keys: __m256i) -> __m256i {
    macro_rules! stage {
        ($keys:expr, $other:expr, $greater:literal) => {{
            let (a, b) = ($keys, $other);
            _mm256_blend_epi32::<$greater>(_mm256_min_epi32(a, b), _mm256_max_epi32(a, b))
        }};
    }
    // SAFETY: the caller has the instruction set.
    unsafe {
        let keys = stage!(keys, _mm256_shuffle_epi32::<0b10_11_00_01>(keys), 0b0101_0101);
        let keys = stage!(keys, _mm256_shuffle_epi32::<0b00_01_10_11>(keys), 0b0011_0011);
        let keys = stage!(keys, _mm256_shuffle_epi32::<0b10_11_00_01>(keys), 0b0101_0101);
        let reversed = _mm256_permutevar8x32_epi32(keys, _mm256_setr_epi32(7, 6, 5, 4, 3, 2, 1, 0));
        let keys = stage!(keys, reversed, 0b0000_1111);
        let keys = stage!(keys, _mm256_shuffle_epi32::<0b01_00_11_10>(keys), 0b0011_0011);
        stage!(keys, _mm256_shuffle_epi32::<0b10_11_00_01>(keys), 0b0101_0101)
    }
}

#[cfg(test)]
mod tests {
    use brewster_lanes::Level;
    use glam::Vec3;

    use super::*;
    use crate::intersect_triangle;
    use crate::ray::Ray;

    /// Numbers in -1..1 that have nothing to do with each other: Weyl's sequence, its bits mixed.
    fn numbers() -> impl FnMut() -> f32 {
        let mut state = 0u64;
        move || {
            state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mixed = (state ^ state >> 29).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            (mixed >> 40) as f32 / (1 << 23) as f32 - 1.0
        }
    }

    /// Rays from everywhere and from the triangles themselves, on triangles of all sizes and as thin as needles, with limits at the very
    /// hit: whatever the exact routine takes is in reach, and most of what it refuses for its t alone is not.
    #[test]
    fn no_triangle_that_is_hit_is_out_of_reach() {
        if !Level::detect().has_avx2() {
            return println!("this machine never runs the code: it has no AVX2");
        }
        let mut number = numbers();
        let (mut taken, mut refused, mut kept) = (0, 0, 0);
        for round in 0..60_000 {
            let mut vector = || Vec3::new(number(), number(), number());
            let (center, size) = (vector() * 3.0, 10f32.powi(-(round % 5)));
            let [a, side, other] = [center + vector() * size, vector() * size, vector() * size];
            let thin = if round % 3 == 0 { 1e-6 } else { 1.0 };
            let corners = [a, a + side, a + side * 0.4 + other * thin];
            let weights = vector().abs();
            let inside =
                (corners[0] * weights.x + corners[1] * weights.y + corners[2] * weights.z) / weights.element_sum();
            let normal = side.cross(other).normalize_or(Vec3::Y);
            let (direction, away) = (vector().normalize_or(Vec3::X), vector());
            let origin = match round % 4 {
                0 => inside - direction * (1.0 + away.x.abs()),
                1 => inside + direction * (1.0 + away.x.abs()),
                2 => inside + normal * away.x * 1e-6,
                _ => inside + normal * away.x * 1e-3 * size,
            };
            let ray = Ray { origin, direction, time: 0.0 };
            let shear = Shear::new(&ray);
            let patch = Patch::pack([corners].into_iter()).expect("one triangle");
            let is_in_reach = |limit: f32| {
                // SAFETY: a `Level` has AVX2 only where there is FMA, too.
                unsafe { Sheared::new(&shear, &patch).in_reach(&shear, limit) & 1 == 1 }
            };
            if let Some(hit) = intersect_triangle(&ray, corners) {
                taken += 1;
                for limit in [f32::INFINITY, hit.t.next_up(), hit.t] {
                    assert!(is_in_reach(limit), "{ray:?} {corners:?} {hit:?} {limit}");
                }
                refused += u32::from(!is_in_reach(hit.t * 0.99));
            } else {
                // Behind the origin, where the line meets the triangle.
                let back = Ray { direction: -direction, ..ray };
                if intersect_triangle(&back, corners).is_some_and(|hit| hit.t > 1e-4 * size) {
                    refused += u32::from(!is_in_reach(f32::INFINITY));
                    kept += u32::from(is_in_reach(f32::INFINITY));
                }
            }
        }
        assert!(taken > 15_000 && refused > 20_000 && kept < refused / 4, "{taken} {refused} {kept}");
    }
}
