//! Random numbers for tests: splitmix64.

use glam::Vec3;

/// The state.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    /// Any number.
    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut x = self.0;
        x = (x ^ x >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        x ^ x >> 31
    }

    /// A number below a limit.
    pub(crate) fn below(&mut self, limit: usize) -> usize {
        (self.next() % limit as u64) as usize
    }

    /// A number from 0 to 1.
    pub(crate) fn unit(&mut self) -> f32 {
        (self.next() >> 40) as f32 / (1 << 24) as f32
    }

    /// A vector with coordinates up to a size.
    pub(crate) fn vector(&mut self, size: f32) -> Vec3 {
        size * (2.0 * Vec3::new(self.unit(), self.unit(), self.unit()) - 1.0)
    }

    /// A unit vector.
    pub(crate) fn direction(&mut self) -> Vec3 {
        self.vector(1.0).try_normalize().unwrap_or(Vec3::X)
    }
}
