//! Sixteen rays as columns, and the interval that they are for boxes.
#![expect(unsafe_code, reason = "columns and nodes are read by pointers to their lanes")]

use std::arch::x86_64::*;

use glam::Vec3;

use super::eight::{keys, store_ordered};
use super::slabs::PAD;
use crate::Affine;
use crate::ray::{Ray, Rays};
use crate::tree::node::Node;

/// Rays in a packet.
pub(super) const WIDTH: usize = 16;

/// Sixteen rays by columns.
#[derive(Clone, Copy)]
pub(super) struct Beam {
    pub(super) origin: [__m512; 3],
    pub(super) direction: [__m512; 3],
}

impl Beam {
    /// Sixteen rays from `first` on.
    #[target_feature(enable = "avx512f,avx512vl,avx512dq")]
    #[inline]
    pub(super) fn new(rays: Rays<'_>, first: usize) -> Beam {
        let column = |columns: [&[f32]; 3], axis: usize| {
            let column = &columns[axis][first..first + WIDTH];
            // SAFETY: the column has sixteen lanes.
            unsafe { _mm512_loadu_ps(column.as_ptr()) }
        };
        Beam {
            origin: std::array::from_fn(|axis| column(rays.origin, axis)),
            direction: std::array::from_fn(|axis| column(rays.direction, axis)),
        }
    }

    /// One of the rays, and when it looks.
    #[inline(always)]
    pub(super) fn ray(&self, lane: usize, time: f32) -> Ray {
        let at = |columns: &[__m512; 3]| Vec3::from_array(columns.each_ref().map(|column| floats(column)[lane]));
        Ray { origin: at(&self.origin), direction: at(&self.direction), time }
    }

    /// All rays, mapped as [`Affine::ray`] maps one: the same products and sums in the same order.
    #[target_feature(enable = "avx512f,avx512vl,avx512dq")]
    #[inline]
    pub(super) fn mapped(&self, map: &Affine) -> Beam {
        let mut mapped = *self;
        for axis in 0..3 {
            let [x, y, z, w] = map.rows[axis].map(|number| _mm512_set1_pd(f64::from(number)));
            let apply = |columns: &[__m512; 3], is_point: bool| {
                let half = |upper: bool| {
                    let [a, b, c] = columns.each_ref().map(|column| widened(*column, upper));
                    let sum = _mm512_add_pd(_mm512_mul_pd(x, a), _mm512_mul_pd(y, b));
                    let sum = _mm512_add_pd(sum, _mm512_mul_pd(z, c));
                    _mm512_cvtpd_ps(if is_point { _mm512_add_pd(sum, w) } else { sum })
                };
                joined([half(false), half(true)])
            };
            mapped.origin[axis] = apply(&self.origin, true);
            mapped.direction[axis] = apply(&self.direction, false);
        }
        mapped
    }

    /// Whether the rays start close to the first of them, for a scene of that reach, and go about the same way: the ways of others
    /// part soon, and the bounds of all of them meet far more boxes than the rays.
    #[target_feature(enable = "avx512f,avx512vl,avx512dq")]
    #[inline]
    pub(super) fn is_narrow(&self, reach: f32) -> bool {
        let mut near = u16::MAX;
        for axis in 0..3 {
            for (column, most) in [(self.origin[axis], NARROW * reach), (self.direction[axis], NARROW)] {
                let first = _mm512_broadcastss_ps(_mm512_castps512_ps128(column));
                let away = _mm512_abs_ps(_mm512_sub_ps(column, first));
                near &= _mm512_cmp_ps_mask::<_CMP_LE_OQ>(away, _mm512_set1_ps(most));
            }
        }
        near == u16::MAX
    }

    /// The largest axis of all directions, if they agree in it and in their signs.
    #[target_feature(enable = "avx512f,avx512vl,avx512dq")]
    #[inline]
    pub(super) fn axis(&self) -> Option<usize> {
        let signs = self.direction.map(|column| _mm512_movepi32_mask(_mm512_castps_si512(column)));
        let [x, y, z] = self.direction.map(|column| _mm512_abs_ps(column));
        // As `Shear::new` chooses.
        let along_z = _mm512_cmp_ps_mask::<_CMP_GE_OQ>(z, x) & _mm512_cmp_ps_mask::<_CMP_GE_OQ>(z, y);
        let along_y = _mm512_cmp_ps_mask::<_CMP_GT_OQ>(y, x) & !along_z;
        let along = [!(along_y | along_z), along_y, along_z];
        let same_signs = signs.into_iter().all(|signs| signs == 0 || signs == u16::MAX);
        if same_signs { along.into_iter().position(|lanes| lanes == u16::MAX) } else { None }
    }

    /// The greatest absolute coordinate of an origin.
    #[target_feature(enable = "avx512f,avx512vl,avx512dq")]
    #[inline]
    pub(super) fn greatest_coordinate(&self) -> f32 {
        let [x, y, z] = self.origin.map(|column| _mm512_abs_ps(column));
        _mm512_reduce_max_ps(_mm512_max_ps(_mm512_max_ps(x, y), z))
    }
}

/// How far rays that go together are from each other: in their directions, and in their origins over the reach of the scene.
const NARROW: f32 = 1.0 / 32.0;

/// Sixteen numbers in memory.
#[inline(always)]
pub(super) fn floats(column: &__m512) -> &[f32; WIDTH] {
    // SAFETY: sixteen floats are what it is.
    unsafe { &*(&raw const *column).cast() }
}

/// The lower or the upper eight numbers in f64.
#[target_feature(enable = "avx512f,avx512vl,avx512dq")]
#[inline]
fn widened(column: __m512, upper: bool) -> __m512d {
    _mm512_cvtps_pd(if upper { _mm512_extractf32x8_ps::<1>(column) } else { _mm512_castps512_ps256(column) })
}

/// Both halves of a column.
#[target_feature(enable = "avx512f,avx512vl,avx512dq")]
#[inline]
fn joined([lower, upper]: [__m256; 2]) -> __m512 {
    _mm512_insertf32x8::<1>(_mm512_castps256_ps512(lower), upper)
}

/// A packet for the boxes of one tree: bounds of all its rays.
pub(super) struct Interval {
    /// For each axis the least and the greatest inverse direction, which near planes are multiplied with, and their negatives for far
    /// planes: eight lanes each, in the order of a node's planes.
    factors: [[__m512; 2]; 3],
    /// The origins, with their pads, that bring near planes nearest and far planes farthest, in the same order.
    origins: [__m512; 3],
    /// Brings near planes to the lower half.
    near_first: [__m512i; 3],
    /// The inverse directions.
    pub(super) inverses: [__m512; 3],
    /// By how much boxes are grown.
    pub(super) pad: f32,
}

impl Interval {
    /// The bounds in `slabs` hold for every ray; the difference to a plane is taken before it is multiplied, which saves one of
    /// its units. `None` if a ray may not be usable. The directions agree in their signs.
    #[target_feature(enable = "avx512f,avx512vl,avx512dq")]
    #[inline]
    pub(super) fn new(beam: &Beam, reach: f32, slack: f32) -> Option<Interval> {
        let [x, y, z] = beam.direction.map(|column| _mm512_abs_ps(column));
        let least = _mm512_mul_ps(_mm512_max_ps(_mm512_max_ps(x, y), z), _mm512_set1_ps(1.0 / (1u64 << 40) as f32));
        let pad = beam.greatest_coordinate() * PAD + (reach * PAD + slack);
        let zero = _mm512_setzero_ps();
        let mut interval = Interval {
            factors: [[zero; 2]; 3],
            origins: [zero; 3],
            near_first: [_mm512_setzero_si512(); 3],
            inverses: [zero; 3],
            pad,
        };
        let mut usable = !0;
        for axis in 0..3 {
            let (origin, direction) = (beam.origin[axis], beam.direction[axis]);
            let is_negative = _mm512_movepi32_mask(_mm512_castps_si512(direction)) != 0;
            let is_small = _mm512_cmp_ps_mask::<_CMP_LT_OQ>(_mm512_abs_ps(direction), least);
            let smallest = if is_negative { _mm512_sub_ps(zero, least) } else { least };
            let inverse = _mm512_div_ps(_mm512_set1_ps(1.0), _mm512_mask_mov_ps(direction, is_small, smallest));
            // No test sees greater numbers than this one.
            let greatest = _mm512_add_ps(_mm512_abs_ps(origin), _mm512_set1_ps(1.0 + 2.0 * pad));
            let greatest = _mm512_mul_ps(_mm512_abs_ps(inverse), _mm512_mul_ps(greatest, _mm512_set1_ps(16.0)));
            usable &= _mm512_cmp_ps_mask::<_CMP_LT_OQ>(greatest, _mm512_set1_ps(f32::INFINITY));
            usable &= _mm512_cmp_ps_mask::<_CMP_NEQ_OQ>(inverse, zero);
            interval.inverses[axis] = inverse;
            // Lower planes are near where directions are positive: what is near or far is so in halves of a register.
            let (far, order) = if is_negative { (0x00ff, 8) } else { (0xff00, 0) };
            let bounds = [_mm512_reduce_min_ps(inverse), _mm512_reduce_max_ps(inverse)];
            for (factor, bound) in interval.factors[axis].iter_mut().zip(bounds) {
                let bound = _mm512_set1_ps(bound);
                *factor = _mm512_mask_sub_ps(bound, far, zero, bound);
            }
            let lower = _mm512_set1_ps(_mm512_reduce_max_ps(origin) + pad);
            let upper = _mm512_set1_ps(_mm512_reduce_min_ps(origin) - pad);
            interval.origins[axis] = _mm512_mask_mov_ps(lower, 0xff00, upper);
            let lanes = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
            interval.near_first[axis] = _mm512_xor_si512(lanes, _mm512_set1_epi32(order));
        }
        (usable == u16::MAX).then_some(interval)
    }

    /// Pushes the children of a node that any of the rays may meet before `limit`, and returns their number.
    ///
    /// # Safety
    /// Both stacks have room for eight entries.
    #[target_feature(enable = "avx512f,avx512vl,avx512dq")]
    #[inline]
    pub(super) unsafe fn push(&self, node: &Node, limit: f32, distances: *mut f32, references: *mut u32) -> u32 {
        // SAFETY: as stated; nodes are aligned, and have eight lower and eight upper planes one after the other for each axis.
        unsafe {
            // Where the rays enter the boxes, and the negative of where they leave them.
            let mut crossed = _mm512_mask_mov_ps(_mm512_setzero_ps(), 0xff00, _mm512_set1_ps(-limit));
            for axis in 0..3 {
                let planes = _mm512_load_ps(node.planes.as_ptr().add(2 * axis).cast());
                let away = _mm512_sub_ps(planes, self.origins[axis]);
                let [least, most] = self.factors[axis];
                let met = _mm512_min_ps(_mm512_mul_ps(away, least), _mm512_mul_ps(away, most));
                crossed = _mm512_max_ps(_mm512_permutexvar_ps(self.near_first[axis], met), crossed);
            }
            let enter = _mm512_castps512_ps256(crossed);
            let leave = _mm256_xor_ps(_mm512_extractf32x8_ps::<1>(crossed), _mm256_set1_ps(-0.0));
            let met = _mm256_cmp_ps_mask::<_CMP_LE_OQ>(enter, leave);
            let keys = _mm256_mask_compress_epi32(_mm256_set1_epi32(-1), met, keys(enter));
            let children = _mm256_load_si256(node.children.as_ptr().cast());
            store_ordered(keys, met.count_ones(), children, distances, references);
            met.count_ones()
        }
    }
}
