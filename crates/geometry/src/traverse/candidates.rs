//! Triangles of a patch that sixteen rays may hit, and what f64 decides of them.
#![expect(unsafe_code, reason = "columns are read by pointers to their lanes")]

use std::arch::x86_64::*;

use super::beam::{Beam, WIDTH};
use crate::tree::node::Patch;

/// For each ray the triangle of a patch that it may hit.
pub(super) struct Candidates {
    corners: [[__m512; 3]; 3],
    pub(super) triangle: __m512i,
    /// Which rays have one.
    pub(super) lanes: u16,
}

impl Candidates {
    #[target_feature(enable = "avx512f,avx512vl,avx512dq")]
    #[inline]
    pub(super) fn none() -> Candidates {
        Candidates { corners: [[_mm512_setzero_ps(); 3]; 3], triangle: _mm512_setzero_si512(), lanes: 0 }
    }

    /// Adds rays that may hit a triangle; they had none.
    #[target_feature(enable = "avx512f,avx512vl,avx512dq")]
    #[inline]
    pub(super) fn take(&mut self, lanes: u16, triangle: usize, corners: [&[__m512; 3]; 3]) {
        for (columns, corner) in self.corners.iter_mut().zip(corners) {
            for (column, &number) in columns.iter_mut().zip(corner) {
                *column = _mm512_mask_mov_ps(*column, lanes, number);
            }
        }
        self.triangle = _mm512_mask_set1_epi32(self.triangle, lanes, triangle as i32);
        self.lanes |= lanes;
    }

    /// The triangle of one of the rays.
    pub(super) fn triangle_of(&self, lane: usize) -> usize {
        // SAFETY: sixteen numbers are what the column is.
        unsafe { (&raw const self.triangle).cast::<[u32; WIDTH]>().read()[lane] as usize }
    }
}

/// At most eight rays against their triangles, decided in f64; columns mean nothing for the others.
pub(super) struct Decided {
    lanes: u16,
    pub(super) t: __m512,
    /// Which rays hit their triangles; without meaning where these are slim.
    pub(super) found: u16,
    /// For which rays the weights are uncertain.
    pub(super) slim: u16,
    /// Two weights and the sum of all.
    v: __m512d,
    w: __m512d,
    determinant: __m512d,
}

impl Decided {
    /// `depth` are the rays' directions along their largest axis, `lanes` those that are decided.
    #[target_feature(enable = "avx512f,avx512vl,avx512dq")]
    #[inline]
    pub(super) fn new(candidates: &Candidates, depth: __m512, lanes: u16) -> Decided {
        let corners = &candidates.corners;
        // Arrays are taken apart by hand: a closure for `map` would not be compiled for the instruction set.
        let [a, b, c] = [corner(&corners[0], lanes), corner(&corners[1], lanes), corner(&corners[2], lanes)];
        let u = _mm512_sub_pd(_mm512_mul_pd(c[0], b[1]), _mm512_mul_pd(c[1], b[0]));
        let v = _mm512_sub_pd(_mm512_mul_pd(a[0], c[1]), _mm512_mul_pd(a[1], c[0]));
        let w = _mm512_sub_pd(_mm512_mul_pd(b[0], a[1]), _mm512_mul_pd(b[1], a[0]));
        let zero = _mm512_setzero_pd();
        let (least, most) = (_mm512_min_pd(_mm512_min_pd(u, v), w), _mm512_max_pd(_mm512_max_pd(u, v), w));
        let outside = _mm512_cmp_pd_mask::<_CMP_LT_OQ>(least, zero) & _mm512_cmp_pd_mask::<_CMP_GT_OQ>(most, zero);
        let determinant = _mm512_add_pd(_mm512_add_pd(u, v), w);
        let sum = _mm512_add_pd(_mm512_mul_pd(u, a[2]), _mm512_mul_pd(v, b[2]));
        let sum = _mm512_add_pd(sum, _mm512_mul_pd(w, c[2]));
        let t = _mm512_cvtpd_ps(_mm512_div_pd(sum, _mm512_mul_pd(determinant, taken(depth, lanes))));
        let extent = _mm512_max_pd(_mm512_max_pd(farther(a), farther(b)), farther(c));
        let bound = _mm512_mul_pd(_mm512_mul_pd(extent, extent), _mm512_set1_pd(1.0 / (1u32 << 25) as f64));
        let not_zero = _mm512_cmp_pd_mask::<_CMP_NEQ_UQ>(determinant, zero);
        let slim = _mm512_cmp_pd_mask::<_CMP_LT_OQ>(_mm512_abs_pd(determinant), bound) & not_zero & !outside;
        let ahead = _mm256_cmp_ps_mask::<_CMP_GT_OQ>(t, _mm256_setzero_ps())
            & _mm256_cmp_ps_mask::<_CMP_LT_OQ>(t, _mm256_set1_ps(f32::INFINITY));
        let (found, slim) = (spread_bits(ahead & not_zero & !outside, lanes), spread_bits(slim, lanes));
        Decided { lanes, t: spread(t, lanes), found, slim, v, w, determinant }
    }

    /// The hit's first weight.
    #[target_feature(enable = "avx512f,avx512vl,avx512dq")]
    #[inline]
    pub(super) fn u(&self) -> __m512 {
        spread(_mm512_cvtpd_ps(_mm512_div_pd(self.v, self.determinant)), self.lanes)
    }

    /// The hit's second weight.
    #[target_feature(enable = "avx512f,avx512vl,avx512dq")]
    #[inline]
    pub(super) fn v(&self) -> __m512 {
        spread(_mm512_cvtpd_ps(_mm512_div_pd(self.w, self.determinant)), self.lanes)
    }
}

/// The corners of a triangle for sixteen rays.
#[inline(always)]
pub(super) fn corners<'s>(sheared: &'s [[__m512; 3]; 8], patch: &Patch, triangle: usize) -> [&'s [__m512; 3]; 3] {
    let corner = |side: usize| &sheared[patch.corners[side][triangle & 7] as usize & 7];
    [corner(0), corner(1), corner(2)]
}

/// Corners of at most eight rays, in f64.
#[target_feature(enable = "avx512f,avx512vl,avx512dq")]
#[inline]
fn corner(corner: &[__m512; 3], lanes: u16) -> [__m512d; 3] {
    [taken(corner[0], lanes), taken(corner[1], lanes), taken(corner[2], lanes)]
}

/// The greater of |x| and |y|.
#[target_feature(enable = "avx512f,avx512vl,avx512dq")]
#[inline]
fn farther(corner: [__m512d; 3]) -> __m512d {
    _mm512_max_pd(_mm512_abs_pd(corner[0]), _mm512_abs_pd(corner[1]))
}

/// The numbers of at most eight lanes in f64.
#[target_feature(enable = "avx512f,avx512vl,avx512dq")]
#[inline]
fn taken(column: __m512, lanes: u16) -> __m512d {
    _mm512_cvtps_pd(_mm512_castps512_ps256(_mm512_maskz_compress_ps(lanes, column)))
}

/// Numbers of what was taken of `lanes`, each where its lane is.
#[target_feature(enable = "avx512f,avx512vl,avx512dq")]
#[inline]
fn spread(numbers: __m256, lanes: u16) -> __m512 {
    _mm512_maskz_expand_ps(lanes, _mm512_castps256_ps512(numbers))
}

/// The same of bits.
#[target_feature(enable = "avx512f,avx512vl,avx512dq")]
#[inline]
fn spread_bits(bits: u8, lanes: u16) -> u16 {
    _mm512_movepi32_mask(_mm512_maskz_expand_epi32(lanes, _mm512_movm_epi32(u16::from(bits))))
}

/// What shearing needs of sixteen rays, as [`Shear`](crate::triangle::Shear) has it of one.
#[derive(Clone, Copy)]
pub(super) struct Columns {
    /// The axes in turn, the one of the largest direction last.
    pub(super) axes: [usize; 3],
    /// Origins in the order of the axes.
    pub(super) origin: [__m512; 3],
    pub(super) slope: [__m512; 2],
    /// Directions along the last axis.
    pub(super) depth: __m512,
}

impl Columns {
    #[target_feature(enable = "avx512f,avx512vl,avx512dq")]
    #[inline]
    pub(super) fn new(beam: &Beam, axis: usize) -> Columns {
        let axes = [[1, 2, 0], [2, 0, 1], [0, 1, 2]][axis];
        let [x, y, depth] = axes.map(|axis: usize| beam.direction[axis]);
        let slope = [_mm512_div_ps(x, depth), _mm512_div_ps(y, depth)];
        Columns { axes, origin: axes.map(|axis| beam.origin[axis]), slope, depth }
    }
}
