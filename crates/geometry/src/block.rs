//! Blocks of rows, gathered number by number, so that a loop over a routine of one row becomes vector code.

use glam::{DVec3, Vec2, Vec3};

use crate::transform::Affine;

/// Rows of a block.
pub(crate) const LANES: usize = 16;

/// The numbers of a block's rows, those of one kind side by side.
#[derive(Debug)]
pub(crate) struct Numbers<T, const COUNT: usize>(pub(crate) [[T; LANES]; COUNT]);

impl<T: Copy + Default, const COUNT: usize> Default for Numbers<T, COUNT> {
    fn default() -> Self {
        Numbers([[T::default(); LANES]; COUNT])
    }
}

impl<T: Copy + Default, const COUNT: usize> Numbers<T, COUNT> {
    /// Sets numbers of a row from one kind on.
    #[inline(always)]
    pub(crate) fn put<const N: usize>(&mut self, first: usize, lane: usize, values: [T; N]) {
        for (i, value) in values.iter().enumerate() {
            self.0[first + i][lane] = *value;
        }
    }

    /// Numbers of a row from one kind on.
    #[inline(always)]
    pub(crate) fn take<const N: usize>(&self, first: usize, lane: usize) -> [T; N] {
        let mut values = [T::default(); N];
        for (i, value) in values.iter_mut().enumerate() {
            *value = self.0[first + i][lane];
        }
        values
    }
}

impl<const COUNT: usize> Numbers<f32, COUNT> {
    #[inline(always)]
    pub(crate) fn vector(&self, first: usize, lane: usize) -> Vec3 {
        Vec3::from_array(self.take(first, lane))
    }

    #[inline(always)]
    pub(crate) fn pair(&self, first: usize, lane: usize) -> Vec2 {
        Vec2::from_array(self.take(first, lane))
    }

    #[inline(always)]
    pub(crate) fn map(&self, first: usize, lane: usize) -> Affine {
        Affine { rows: [self.take(first, lane), self.take(first + 4, lane), self.take(first + 8, lane)] }
    }

    #[inline(always)]
    pub(crate) fn put_map(&mut self, first: usize, lane: usize, map: &Affine) {
        for i in 0..3 {
            self.put(first + 4 * i, lane, map.rows[i]);
        }
    }
}

impl<const COUNT: usize> Numbers<f64, COUNT> {
    #[inline(always)]
    pub(crate) fn vector(&self, first: usize, lane: usize) -> DVec3 {
        DVec3::from_array(self.take(first, lane))
    }
}
