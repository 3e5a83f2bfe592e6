//! Integer hashing for what must be the same everywhere and always: scene keys, scattered places, and the fingerprint of a
//! scene's inputs. Not for secrets.

/// SplitMix64's finalizer: every bit of the input changes half the bits of the output.
pub(crate) const fn mix(x: u64) -> u64 {
    let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

/// Folds any number of byte strings into 64 bits. Where one ends and the next begins counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Digest(u64);

impl Digest {
    pub(crate) fn update(&mut self, bytes: &[u8]) {
        self.word(bytes.len() as u64);
        let (words, rest) = bytes.as_chunks::<8>();
        for &word in words {
            self.word(u64::from_le_bytes(word));
        }
        let mut last = [0; 8];
        last[..rest.len()].copy_from_slice(rest);
        self.word(u64::from_le_bytes(last));
    }

    pub(crate) fn finish(self) -> u64 {
        mix(self.0)
    }

    fn word(&mut self, word: u64) {
        self.0 = mix(self.0.wrapping_add(0x9e37_79b9_7f4a_7c15) ^ word);
    }
}

/// The hash of one byte string.
pub(crate) fn of(bytes: &[u8]) -> u64 {
    let mut digest = Digest::default();
    digest.update(bytes);
    digest.finish()
}

/// A number in 0..1 from a seed and what is counted.
pub(crate) fn unit(seed: u64, index: u64, dimension: u64) -> f32 {
    let bits = mix(mix(mix(seed.wrapping_add(0x9e37_79b9_7f4a_7c15)) ^ index) ^ dimension);
    (bits >> 40) as f32 * (1.0 / (1u64 << 24) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mix_is_splitmix64() {
        // The first outputs of SplitMix64 with seed 1234567, as its reference implementation prints them.
        let gamma = 0x9e37_79b9_7f4a_7c15u64;
        let state = |n: u64| 1_234_567u64.wrapping_add(gamma.wrapping_mul(n));
        assert_eq!(mix(state(1)), 6_457_827_717_110_365_317);
        assert_eq!(mix(state(2)), 3_203_168_211_198_807_973);
    }

    #[test]
    fn borders_and_lengths_count() {
        let digest = |parts: &[&str]| {
            let mut digest = Digest::default();
            parts.iter().for_each(|part| digest.update(part.as_bytes()));
            digest.finish()
        };
        let all =
            [digest(&["ab", "c"]), digest(&["a", "bc"]), digest(&["abc"]), digest(&["abc", ""]), digest(&["abc\0"])];
        for (i, a) in all.iter().enumerate() {
            assert!(all[i + 1..].iter().all(|b| a != b), "{all:?}");
        }
    }

    #[test]
    fn unit_numbers_fill_the_interval_evenly() {
        let mut counts = [0; 10];
        for index in 0..10_000 {
            let x = unit(7, index, 2);
            assert!((0.0..1.0).contains(&x));
            counts[(x * 10.0) as usize] += 1;
        }
        // 1000 expected in each tenth; the standard deviation is 30.
        assert!(counts.iter().all(|count| (850..1150).contains(count)), "{counts:?}");
    }
}
