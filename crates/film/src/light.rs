//! Light in fixed point: what contributions become before they are added.

use crate::SCALE;

/// Light that adds up in any order to the same bits: linear Rec.709 radiance x weight in units of 1 / [`SCALE`] nit; never
/// negative.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Light(pub [i64; 3]);

impl Light {
    /// No light.
    pub const NONE: Light = Light([0; 3]);

    /// The nearest step of each component, halfway cases away from zero, by exact arithmetic; none if a component is NaN,
    /// infinite or negative. What is too bright saturates.
    #[inline(always)]
    pub fn new(color: [f32; 3]) -> Option<Light> {
        color.iter().all(|&value| in_range(value)).then(|| Light(color.map(|value| to_fixed(value, SCALE))))
    }

    /// Adds more light; saturates.
    #[inline(always)]
    pub fn add(&mut self, more: Light) {
        for (sum, value) in self.0.iter_mut().zip(more.0) {
            *sum = sum.saturating_add(value);
        }
    }
}

/// Whether a value is finite and not negative; -0 counts as 0.
#[inline(always)]
pub(crate) fn in_range(value: f32) -> bool {
    (0.0..=f32::MAX).contains(&value)
}

/// The nearest multiple of 1 / `scale` (a power of two), halfway cases away from zero; saturates.
///
/// Every step is exact: an f32 times a power of two is an f64, and where adding a half would have to round, the product
/// is an even integer already, to which the sum rounds back.
#[inline(always)]
pub(crate) fn to_fixed(value: f32, scale: f64) -> i64 {
    let scaled = f64::from(value) * scale;
    (scaled + 0.5f64.copysign(scaled)) as i64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::DEPTH_SCALE;

    /// Rounds to steps of 2^-`bits` by shifting the significand, as one would by hand.
    fn rounded_by_shifting(value: f32, bits: i32) -> i64 {
        let significand = i128::from(value.to_bits() & 0x7f_ffff);
        let exponent = (value.to_bits() >> 23 & 0xff) as i32;
        let (significand, exponent) = if exponent == 0 { (significand, 1) } else { (significand | 1 << 23, exponent) };
        let shift = exponent - 150 + bits;
        let magnitude = match shift {
            64.. => i128::MAX,
            0.. => significand << shift,
            -64..0 => (significand + (1 << (-shift - 1))) >> -shift,
            _ => 0,
        };
        let limit = if value < 0.0 { -i128::from(i64::MIN) } else { i128::from(i64::MAX) };
        let magnitude = magnitude.min(limit);
        (if value < 0.0 { -magnitude } else { magnitude }) as i64
    }

    #[test]
    fn contributions_are_rounded_once_to_the_nearest_step() {
        let step = 1.0 / SCALE as f32;
        let cases = [
            (0.0, 0),
            (1.0, 1 << 32),
            (-1.0, -1 << 32),
            (0.5 * step, 1),
            (-0.5 * step, -1),
            (0.499 * step, 0),
            (2.5 * step, 3),
            (f32::MIN_POSITIVE, 0),
            (2_147_483_520.0, 2_147_483_520 << 32),
            (2_147_483_648.0, i64::MAX),
            (f32::MAX, i64::MAX),
            (f32::MIN, i64::MIN),
        ];
        for (value, expected) in cases {
            assert_eq!(to_fixed(value, SCALE), expected, "{value:e}");
        }
        for i in 0..1 << 16 {
            let value = f32::from_bits((i as u32) << 16 | (i as u32).wrapping_mul(0x9e37) & 0xffff);
            if value.is_finite() {
                assert_eq!(to_fixed(value, SCALE), rounded_by_shifting(value, 32), "{value:e}");
                assert_eq!(to_fixed(value, DEPTH_SCALE), rounded_by_shifting(value, 24), "{value:e}");
            }
        }
    }

    #[test]
    fn what_is_no_light_is_refused() {
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0] {
            assert_eq!(Light::new([1.0, bad, 1.0]), None, "{bad}");
        }
        assert_eq!(Light::new([1.0, -0.0, 0.25]), Some(Light([1 << 32, 0, 1 << 30])));
    }
}
