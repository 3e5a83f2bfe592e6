//! Packets and single rays for AVX-512 VL; single rays on registers of eight lanes.
#![expect(unsafe_code, reason = "intrinsics need an instruction set, which the level proves")]

use std::arch::x86_64::*;

use super::eight::{Sheared, boxes, keys, store_ordered};
use super::one::{self, Stack};
use super::packet;
use super::slabs::Slabs;
use super::task::Task;
use super::wave::Kernel;
use crate::hit::Hit;
use crate::ray::{Ray, Rays};
use crate::scene::SceneGeometry;
use crate::tree::node::{Node, Patch};
use crate::triangle::Shear;

struct Avx512;

/// Sends coherent rays through the scene in packets, and lists the others.
///
/// # Safety
/// The machine has AVX-512 F, VL, DQ, BW and CD, AVX2, FMA and BMI.
#[target_feature(enable = "avx512f,avx512vl,avx512dq,avx512bw,avx512cd,avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub(super) unsafe fn packets<T: Task>(
    scene: &SceneGeometry<'_>,
    rays: Rays<'_>,
    task: &mut T,
    memory: &mut packet::Memory,
    rest: &mut Vec<u32>,
) {
    packet::trace(scene, rays, task, memory, rest);
}

/// Sends one ray through the scene.
///
/// # Safety
/// The machine has AVX-512 F, VL, DQ, BW and CD, AVX2, FMA and BMI; the stack has room for the scene's deepest trees and eight entries more.
#[target_feature(enable = "avx512f,avx512vl,avx512dq,avx512bw,avx512cd,avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub(super) unsafe fn one<const ANY: bool>(
    scene: &SceneGeometry<'_>,
    only_instance: Option<u32>,
    ray: &Ray,
    limit: f32,
    stack: Stack,
) -> Hit {
    // SAFETY: as stated.
    unsafe { one::one::<Avx512, ANY>(scene, only_instance, ray, limit, stack) }
}

impl Kernel for Avx512 {
    #[inline(always)]
    unsafe fn meet(slabs: &Slabs, node: &Node, limit: f32, enter: &mut [f32; 8]) -> u32 {
        // SAFETY: the caller has the instruction set.
        unsafe {
            let (entered, leave) = boxes(slabs, node, limit);
            _mm256_storeu_ps(enter.as_mut_ptr(), entered);
            _mm256_cmp_ps_mask::<_CMP_LE_OQ>(entered, leave) as u32
        }
    }

    #[inline(always)]
    unsafe fn push<const ORDERED: bool>(
        slabs: &Slabs,
        node: &Node,
        limit: f32,
        distances: *mut f32,
        references: *mut u32,
    ) -> u32 {
        // SAFETY: the caller has the instruction set and room for eight entries.
        unsafe {
            let (enter, leave) = boxes(slabs, node, limit);
            let met = _mm256_cmp_ps_mask::<_CMP_LE_OQ>(enter, leave);
            let children = _mm256_load_si256(node.children.as_ptr().cast());
            if ORDERED {
                // Lanes that are not met become -1, less than any distance.
                let keys = _mm256_mask_compress_epi32(_mm256_set1_epi32(-1), met, keys(enter));
                store_ordered(keys, met.count_ones(), children, distances, references);
            } else {
                _mm256_storeu_ps(distances, _mm256_maskz_compress_ps(met, enter));
                _mm256_storeu_si256(references.cast(), _mm256_maskz_compress_epi32(met, children));
            }
            met.count_ones()
        }
    }

    #[inline(always)]
    unsafe fn filter(shear: &Shear, patch: &Patch, limit: f32, sheared: &mut [[f32; 8]; 3]) -> u32 {
        // SAFETY: the caller has the instruction set.
        unsafe {
            let found = Sheared::new(shear, patch);
            let zero = _mm256_setzero_ps();
            let inside = _mm256_cmp_ps_mask::<_CMP_GE_OQ>(found.least, zero)
                | _mm256_cmp_ps_mask::<_CMP_LE_OQ>(found.most, zero);
            let inside = inside as u32;
            let mut mask = inside & ((1 << patch.triangles) - 1);
            if mask != 0 {
                mask &= found.in_reach(shear, limit);
                found.store(sheared);
            }
            mask
        }
    }
}
