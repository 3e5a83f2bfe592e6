//! Where the samples of a pixel lie: one fixed pattern for all pixels.

use brewster_film::FilterSampler;
use glam::Vec2;

/// Fractions of the plastic number's inverse and of its square, times 2^64: the R2 sequence (Roberts 2018, "The
/// unreasonable effectiveness of quasirandom sequences") in exact integer steps.
const STEP: [u64; 2] = [0xc13f_a9a9_02a6_328f, 0x91e1_0da5_c79e_7b1c];

/// Offsets from the pixel's center, in pixels, of the first `samples` samples: the R2 sequence, which begins in the middle for
/// seed 0 and at a place of its own for every other seed, by way of the pixel filter.
///
/// A longer pattern begins with the shorter one.
pub(crate) fn pattern(samples: u32, seed: u64, filter: &FilterSampler) -> Vec<Vec2> {
    let start = match seed {
        0 => [1 << 63; 2],
        _ => [mix(seed), mix(mix(seed))],
    };
    let unit = |bits: u64| (bits >> 40) as f32 / (1u32 << 24) as f32;
    (0..u64::from(samples))
        .map(|n| {
            let point = [0, 1].map(|axis| unit(start[axis].wrapping_add(n.wrapping_mul(STEP[axis]))));
            Vec2::from_array(filter.sample(point))
        })
        .collect()
}

/// Spreads the bits of a number over all 64 (Steele, Lea and Flood 2014, SplitMix64's finalizer).
fn mix(seed: u64) -> u64 {
    let mut z = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ z >> 31
}

#[cfg(test)]
mod tests {
    use brewster_film::Filter;

    use super::*;

    fn box_pattern(samples: u32, seed: u64) -> Vec<Vec2> {
        pattern(samples, seed, &FilterSampler::new(Filter::BOX).unwrap())
    }

    #[test]
    fn one_sample_lies_in_the_middle_and_more_begin_with_it() {
        assert_eq!(box_pattern(1, 0), [Vec2::ZERO]);
        assert_eq!(box_pattern(64, 3)[..16], box_pattern(16, 3));
        assert_ne!(box_pattern(4, 3), box_pattern(4, 4));
    }

    #[test]
    fn samples_spread_evenly_over_the_pixel() {
        // R2 in floating point, from its definition: fractions of 0.5 + n/φ2 and 0.5 + n/φ2².
        let plastic = 1.324_717_957_244_746_f64;
        for (n, place) in box_pattern(256, 0).iter().enumerate() {
            for (axis, value) in place.to_array().into_iter().enumerate() {
                let expected = (0.5 + n as f64 / plastic.powi(axis as i32 + 1)).fract() - 0.5;
                assert!((f64::from(value) - expected).abs() < 1e-6, "sample {n}, axis {axis}: {value}, {expected}");
            }
        }
        // Of 256 samples, each of 16 cells holds 16, give or take 3.
        let mut cells = [0; 16];
        for place in box_pattern(256, 9) {
            cells[((place.x + 0.5) * 4.0) as usize + 4 * ((place.y + 0.5) * 4.0) as usize] += 1;
        }
        assert!(cells.iter().all(|&count: &i32| (count - 16).abs() <= 3), "{cells:?}");
    }
}
