//! Blocks of rows, held as columns: loops over them become vector code.

use glam::Vec3;

/// Rows of a block: as many f32 as the widest vector has.
pub(crate) const LANES: usize = 16;

/// Vectors of a block's rows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Vectors<const N: usize>(pub(crate) [[f32; N]; 3]);

impl<const N: usize> Vectors<N> {
    pub(crate) const ZERO: Vectors<N> = Vectors([[0.0; N]; 3]);

    /// The same in all rows.
    #[inline(always)]
    pub(crate) fn splat(vector: Vec3) -> Vectors<N> {
        Vectors([[vector.x; N], [vector.y; N], [vector.z; N]])
    }

    #[inline(always)]
    pub(crate) fn get(&self, row: usize) -> Vec3 {
        Vec3::new(self.0[0][row], self.0[1][row], self.0[2][row])
    }

    #[inline(always)]
    pub(crate) fn set(&mut self, row: usize, vector: Vec3) {
        (self.0[0][row], self.0[1][row], self.0[2][row]) = vector.into();
    }
}

/// How many of a block's rows are marked.
#[inline(always)]
pub(crate) fn count<const N: usize>(marks: &[bool; N]) -> u64 {
    marks.iter().map(|&mark| u64::from(mark)).sum()
}
