//! The wave's steps for AVX2.
#![expect(unsafe_code, reason = "intrinsics need an instruction set, which the level proves")]

use std::arch::x86_64::*;

use super::eight::{Sheared, boxes, keys, store_ordered};
use super::one::{self, Stack};
use super::slabs::Slabs;
use super::task::Task;
use super::wave::{Kernel, Memory, wave};
use crate::hit::Hit;
use crate::ray::{Ray, Rays};
use crate::scene::SceneGeometry;
use crate::tree::node::{Node, Patch};
use crate::triangle::Shear;

struct Avx2;

/// Sends rays through the scene in waves: all, or those listed in `order`. On AVX-512 as well: the same code compiled for that, or with its
/// compressing stores, takes 1.1 to 1.2 times as long for bounces and shadow rays, and as long for rays one at a time.
///
/// # Safety
/// The machine has AVX2, FMA and BMI.
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub(super) unsafe fn run<T: Task>(
    scene: &SceneGeometry<'_>,
    rays: Rays<'_>,
    order: Option<&[u32]>,
    task: T,
    memory: &mut Memory,
) {
    // SAFETY: as stated.
    unsafe { wave::<Avx2, T>(scene, rays, order, task, memory) }
}

/// Sends one ray through the scene.
///
/// # Safety
/// The machine has AVX2, FMA and BMI; the stack has room for the scene's deepest trees and eight entries more.
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub(super) unsafe fn one<const ANY: bool>(
    scene: &SceneGeometry<'_>,
    only_instance: Option<u32>,
    ray: &Ray,
    limit: f32,
    stack: Stack,
) -> Hit {
    // SAFETY: as stated.
    unsafe { one::one::<Avx2, ANY>(scene, only_instance, ray, limit, stack) }
}

impl Kernel for Avx2 {
    #[inline(always)]
    unsafe fn meet(slabs: &Slabs, node: &Node, limit: f32, enter: &mut [f32; 8]) -> u32 {
        // SAFETY: the caller has the instruction set.
        unsafe {
            let (entered, leave) = boxes(slabs, node, limit);
            _mm256_storeu_ps(enter.as_mut_ptr(), entered);
            _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(entered, leave)) as u32
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
            let compare = _mm256_cmp_ps::<_CMP_LE_OQ>(enter, leave);
            let met = _mm256_movemask_ps(compare) as u32;
            let front = _mm256_cvtepu8_epi32(_mm_loadl_epi64(TO_FRONT[met as usize].as_ptr().cast()));
            let children = _mm256_load_si256(node.children.as_ptr().cast());
            if ORDERED {
                // Lanes that are not met become -1, less than any distance.
                let missed = _mm256_xor_si256(_mm256_castps_si256(compare), _mm256_set1_epi32(-1));
                let keys = _mm256_permutevar8x32_epi32(_mm256_or_si256(keys(enter), missed), front);
                store_ordered(keys, met.count_ones(), children, distances, references);
            } else {
                _mm256_storeu_ps(distances, _mm256_permutevar8x32_ps(enter, front));
                _mm256_storeu_si256(references.cast(), _mm256_permutevar8x32_epi32(children, front));
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
            let inside = _mm256_or_ps(
                _mm256_cmp_ps::<_CMP_GE_OQ>(found.least, zero),
                _mm256_cmp_ps::<_CMP_LE_OQ>(found.most, zero),
            );
            let inside = _mm256_movemask_ps(inside) as u32;
            let mut mask = inside & ((1 << patch.triangles) - 1);
            if mask != 0 {
                mask &= found.in_reach(shear, limit);
                found.store(sheared);
            }
            mask
        }
    }
}

/// For every mask of lanes: those lanes, then the others.
static TO_FRONT: [[u8; 8]; 256] = {
    let mut table = [[0; 8]; 256];
    let mut mask = 0;
    while mask < 256 {
        let (mut place, mut lane) = (0, 0);
        while lane < 16 {
            // First round the lanes of the mask, second round the others.
            if (mask >> (lane & 7) & 1 == 1) == (lane < 8) {
                table[mask][place] = lane as u8 & 7;
                place += 1;
            }
            lane += 1;
        }
        mask += 1;
    }
    table
};
