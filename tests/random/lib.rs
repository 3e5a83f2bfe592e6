//! Random numbers for tests and benches, the same in every run.

use glam::{Quat, Vec2, Vec3};

/// Independent numbers: SplitMix64 (G. Steele, D. Lea and C. Flood 2014).
pub struct Random(u64);

impl Random {
    /// The numbers of a seed; those of seeds next to each other have nothing in common.
    pub fn new(seed: u64) -> Random {
        Random(seed.wrapping_mul(0xd134_2543_de82_ef95))
    }

    /// 64 bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A whole number below a bound, or 0 where that is 0.
    pub fn below(&mut self, bound: usize) -> usize {
        (self.bits() % bound.max(1) as u64) as usize
    }

    /// Evenly spread over the multiples of 2⁻²⁴ in 0 ≤ x < 1.
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1 << 24) as f32
    }

    /// Evenly from -1 to 1.
    pub fn signed(&mut self) -> f32 {
        2.0 * self.unit() - 1.0
    }

    /// Evenly in the square from 0 to 1.
    pub fn square(&mut self) -> Vec2 {
        Vec2::new(self.unit(), self.unit())
    }

    /// Evenly in the cube from -1 to 1.
    pub fn cube(&mut self) -> Vec3 {
        Vec3::new(self.signed(), self.signed(), self.signed())
    }

    /// A unit vector, evenly.
    pub fn direction(&mut self) -> Vec3 {
        loop {
            let vector = self.cube();
            if (1e-4..=1.0).contains(&vector.length_squared()) {
                return vector.normalize();
            }
        }
    }

    /// About a random axis by up to 3.
    pub fn rotation(&mut self) -> Quat {
        Quat::from_axis_angle(self.direction(), self.signed() * 3.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first outputs of the generator in state 1234567, as published with its reference implementation.
    #[test]
    fn numbers_are_the_published_ones() {
        let mut random = Random(1_234_567);
        let found = [random.bits(), random.bits(), random.bits()];
        assert_eq!(found, [6_457_827_717_110_365_317, 3_203_168_211_198_807_973, 9_817_491_932_198_370_423]);
    }
}
