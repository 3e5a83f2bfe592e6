//! Transcendental functions in plain arithmetic: the same bits on every platform and at every [`Level`](crate::Level).
//!
//! A platform's libm may differ in the last bit from its neighbor's, and a call to it keeps a loop from vectorizing.
//! What reaches a picture therefore calls these functions only. They are free of branches and fuse nothing, so a loop
//! over columns inside [`dispatch!`](crate::dispatch) becomes vector code as it stands. Exponentials and logarithms
//! pass through f64, where a short polynomial is good to the last bit of f32.
//!
//! Errors are in units in the last place of the exact result, measured over the whole stated domain by the tests. The
//! polynomials are minimax fits in relative error, made with the Remez exchange at 40 digits.

use core::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI};
use core::f64::consts::{FRAC_2_PI, LN_2, LOG2_E};

/// Adding it to an f64 below 2³¹ in size leaves the nearest integer in the low bits.
const ROUND: f64 = 6_755_399_441_055_744.0;

/// π/2 cut after 33 bits, so that its product with an integer below 2²⁰ is exact; and the rest.
const HALF_PI_HIGH: f64 = f64::from_bits(0x3ff9_21fb_5440_0000);
const HALF_PI_LOW: f64 = 6.077_100_506_506_192e-11;

/// The tangent of π/8, below which the arctangent's polynomial is used directly.
const TAN_EIGHTH_PI: f32 = 0.414_213_57;

/// 2ˣ for every x; error 0.51 ulp.
#[inline(always)]
pub fn exp2(x: f32) -> f32 {
    exp2_of_f64(x as f64)
}

/// eˣ for every x; error 0.51 ulp.
#[inline(always)]
pub fn exp(x: f32) -> f32 {
    exp2_of_f64(x as f64 * LOG2_E)
}

/// The logarithm to base 2 for x > 0; −∞ at 0, NaN below; error 0.51 ulp.
#[inline(always)]
pub fn log2(x: f32) -> f32 {
    log2_in_f64(x) as f32
}

/// The natural logarithm for x > 0; −∞ at 0, NaN below; error 0.51 ulp.
#[inline(always)]
pub fn ln(x: f32) -> f32 {
    (log2_in_f64(x) * LN_2) as f32
}

/// xʸ for x ≥ 0; error 0.51 ulp.
///
/// `pow(x, 0)` is 1 for every x, and `pow(0, y)` is 0 for y > 0 and ∞ for y < 0. A negative x gives NaN even for a whole
/// y.
#[inline(always)]
pub fn pow(x: f32, y: f32) -> f32 {
    let product = y as f64 * log2_in_f64(x);
    exp2_of_f64(if y == 0.0 { 0.0 } else { product })
}

/// The cube root for every x; error 0.51 ulp.
#[inline(always)]
pub fn cbrt(x: f32) -> f32 {
    exp2_of_f64(log2_in_f64(x.abs()) / 3.0).copysign(x)
}

/// x⁵ as (x²)²·x; error 3 ulp.
#[inline(always)]
pub fn pow5(x: f32) -> f32 {
    let square = x * x;
    square * square * x
}

/// Sine and cosine of x radians; error 1.6 ulp for |x| ≤ 10⁶.
///
/// Beyond, the angle loses bits, and from 10⁹ on only the range −1..1 is promised. Infinite angles give NaN.
#[inline(always)]
pub fn sin_cos(x: f32) -> (f32, f32) {
    let x = x as f64;
    let shifted = x * FRAC_2_PI + ROUND;
    let turns = shifted - ROUND;
    let quadrant = shifted.to_bits() as u32;
    let rest = (x - turns * HALF_PI_HIGH) - turns * HALF_PI_LOW;
    let rest = rest as f32;
    let rest = if rest > FRAC_PI_4 { FRAC_PI_4 } else { rest };
    let rest = if rest < -FRAC_PI_4 { -FRAC_PI_4 } else { rest };

    let square = rest * rest;
    let sine = -1.666_666_6e-1 + square * (8.333_329e-3 + square * (-1.983_931_3e-4 + square * 2.718_121_6e-6));
    let sine = rest + rest * square * sine;
    let cosine = 4.166_664_6e-2 + square * (-1.388_731_6e-3 + square * 2.443_315_7e-5);
    let cosine = 1.0 - (0.5 * square - square * square * cosine);

    let (sine, cosine) = if quadrant & 1 == 0 { (sine, cosine) } else { (cosine, sine) };
    let sine = if quadrant & 2 == 0 { sine } else { -sine };
    let cosine = if quadrant.wrapping_add(1) & 2 == 0 { cosine } else { -cosine };
    (sine, cosine)
}

/// The sine of x radians; as [`sin_cos`].
#[inline(always)]
pub fn sin(x: f32) -> f32 {
    sin_cos(x).0
}

/// The cosine of x radians; as [`sin_cos`].
#[inline(always)]
pub fn cos(x: f32) -> f32 {
    sin_cos(x).1
}

/// The tangent of x radians; error 3.5 ulp for |x| ≤ 10⁶, then as [`sin_cos`].
#[inline(always)]
pub fn tan(x: f32) -> f32 {
    let (sine, cosine) = sin_cos(x);
    sine / cosine
}

/// The angle in −π/2..π/2 whose sine is x, for |x| ≤ 1, otherwise NaN; error 2.5 ulp.
#[inline(always)]
pub fn asin(x: f32) -> f32 {
    let (angle, folded) = folded_asin(x.abs());
    (if folded { FRAC_PI_2 - 2.0 * angle } else { angle }).copysign(x)
}

/// The angle in 0..π whose cosine is x, for |x| ≤ 1, otherwise NaN; error 2.5 ulp.
#[inline(always)]
pub fn acos(x: f32) -> f32 {
    let (angle, folded) = folded_asin(x.abs());
    let near_pole = if x < 0.0 { PI - 2.0 * angle } else { 2.0 * angle };
    if folded { near_pole } else { FRAC_PI_2 - angle.copysign(x) }
}

/// The angle in −π/2..π/2 whose tangent is x, for every x; error 3 ulp.
#[inline(always)]
pub fn atan(x: f32) -> f32 {
    atan2(x, 1.0)
}

/// The angle in −π..π of the point (x, y), for coordinates of at most 10³⁸; error 3 ulp.
///
/// Zeros follow the standard library: the angle of (0, 0) is 0, that of (−0, 0) is π, and y gives the sign.
#[inline(always)]
pub fn atan2(y: f32, x: f32) -> f32 {
    let (width, height) = (x.abs(), y.abs());
    let steep = height > width;
    let (short, long) = if steep { (width, height) } else { (height, width) };

    // tan(a − π/4) = (tan a − 1)/(tan a + 1) brings the upper half of the octant into the polynomial's range.
    let upper = short > TAN_EIGHTH_PI * long;
    let (numerator, denominator) = if upper { (short - long, short + long) } else { (short, long) };
    let tangent = if denominator == 0.0 { 0.0 } else { numerator / denominator };
    let square = tangent * tangent;
    let angle = 1.059_381_4e-1 + square * -6.078_222_4e-2;
    let angle = -3.333_331_6e-1 + square * (1.999_847_1e-1 + square * (-1.424_353_3e-1 + square * angle));
    let angle = tangent + tangent * square * angle;

    let angle = if upper { FRAC_PI_4 + angle } else { angle };
    let angle = if steep { FRAC_PI_2 - angle } else { angle };
    let angle = if x.is_sign_negative() { PI - angle } else { angle };
    angle.copysign(y)
}

/// The arcsine of x in 0..½, or of √((1−x)/2) above, which is half the arccosine of x; and whether it was above.
#[inline(always)]
fn folded_asin(x: f32) -> (f32, bool) {
    let folded = x > 0.5;
    let square = if folded { 0.5 * (1.0 - x) } else { x * x };
    let sine = if folded { square.sqrt() } else { x };
    let angle = 4.547_037_6e-2 + square * (2.417_951_8e-2 + square * 4.216_630_4e-2);
    let angle = 1.666_675_2e-1 + square * (7.495_297_5e-2 + square * angle);
    (sine + sine * square * angle, folded)
}

/// 2ᵗ rounded to f32: the power of the nearest integer times a polynomial of the rest.
#[inline(always)]
fn exp2_of_f64(t: f64) -> f32 {
    let t = if t > 160.0 { 160.0 } else { t };
    let t = if t < -160.0 { -160.0 } else { t };
    let shifted = t + ROUND;
    let power_of_two = f64::from_bits((shifted.to_bits() << 52).wrapping_add(1.0f64.to_bits()));
    let rest = t - (shifted - ROUND);
    let series = 1.334_195_096_355_705_6e-3 + rest * (1.546_136_771_130_201e-4 + rest * 1.335_984_100_256_925_7e-5);
    let series = 5.550_400_375_360_249_6e-2 + rest * (9.618_056_919_142_864e-3 + rest * series);
    let series = 6.931_471_838_168_569e-1 + rest * (2.402_265_092_078_440_2e-1 + rest * series);
    ((1.0 + rest * series) * power_of_two) as f32
}

/// The logarithm to base 2 as f64: x = 2ᵉ·m with m between √½ and √2, and log m = 2 artanh((m−1)/(m+1)).
#[inline(always)]
fn log2_in_f64(x: f32) -> f64 {
    /// The bits of √½.
    const START: u32 = 0x3f35_04f3;
    let subnormal = x < f32::MIN_POSITIVE;
    let normal = if subnormal { x * 16_777_216.0 } else { x };
    let above = normal.to_bits().wrapping_sub(START);
    let exponent = (above as i32 >> 23) - if subnormal { 24 } else { 0 };
    let mantissa = f32::from_bits((above & 0x007f_ffff) + START) as f64;
    let s = (mantissa - 1.0) / (mantissa + 1.0);
    let square = s * s;
    let series = 0.412_208_385_161_439_3 + square * (0.319_935_470_119_350_9 + square * 0.282_529_637_955_989_45);
    let series = 0.961_796_694_057_290_2 + square * (0.577_077_953_350_558_4 + square * series);
    let log = exponent as f64 + (2.0 * LOG2_E * s + s * square * series);
    let log = if x == f32::INFINITY { f64::INFINITY } else { log };
    let log = if x == 0.0 { f64::NEG_INFINITY } else { log };
    if x >= 0.0 { log } else { f64::NAN }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Level, dispatch};

    /// Every 1009th f32 between two bounds of one sign, and the bounds.
    fn sweep(from: f32, to: f32) -> impl Iterator<Item = f32> {
        let (first, last) = (from.to_bits().min(to.to_bits()), from.to_bits().max(to.to_bits()));
        (first..=last).step_by(1009).chain([last]).map(f32::from_bits)
    }

    /// Every 1009th finite f32, and the ends.
    fn every_finite() -> impl Iterator<Item = f32> {
        sweep(0.0, f32::MAX).chain(sweep(-0.0, f32::MIN))
    }

    /// The distance of a result from the exact value in units in the last place of f32.
    fn ulps(result: f32, exact: f64) -> f64 {
        let rounded = exact as f32;
        if !rounded.is_finite() || !result.is_finite() {
            return if result == rounded || (result.is_nan() && rounded.is_nan()) { 0.0 } else { f64::INFINITY };
        }
        let above = f32::from_bits(rounded.abs().to_bits() + 1) as f64;
        (result as f64 - exact).abs() / (above - rounded.abs() as f64)
    }

    /// Compares with the standard library's f64 function over a domain.
    fn check(name: &str, limit: f64, domain: impl Iterator<Item = f32>, ours: fn(f32) -> f32, exact: fn(f64) -> f64) {
        let mut worst = (0.0, 0.0);
        for x in domain {
            let error = ulps(ours(x), exact(x as f64));
            if error > worst.0 {
                worst = (error, x);
            }
        }
        println!("{name}: at most {:.3} ulp, at {:e}", worst.0, worst.1);
        let x = worst.1;
        assert!(worst.0 <= limit, "{name}({x:e}): {:e} against {:e}, {} ulp", ours(x), exact(x as f64), worst.0);
    }

    #[test]
    fn exponentials_are_within_their_error() {
        check("exp2", 0.51, every_finite(), exp2, f64::exp2);
        check("exp", 0.51, every_finite(), exp, f64::exp);
        check("cbrt", 0.51, every_finite(), cbrt, f64::cbrt);
        check("pow5", 3.0, sweep(1e-7, 1e7), pow5, |x| x.powi(5));
    }

    #[test]
    fn logarithms_are_within_their_error() {
        check("log2", 0.51, sweep(0.0, f32::INFINITY), log2, f64::log2);
        check("ln", 0.51, sweep(0.0, f32::INFINITY), ln, f64::ln);
    }

    #[test]
    fn powers_are_within_their_error() {
        let exponents = [-1000.0f32, -2.4, -1.0, -1e-3, 1e-30, 1e-3, 0.5, 1.0, 2.4, 5.0, 40.0, 300.0, 1e4, 1e6, 1e30];
        for y in exponents {
            for x in sweep(0.0, f32::INFINITY).step_by(7).chain(sweep(0.9, 1.1)) {
                let exact = (x as f64).powf(y as f64);
                let error = ulps(pow(x, y), exact);
                assert!(error <= 0.51, "pow({x:e}, {y:e}): {:e} against {exact:e}, {error} ulp", pow(x, y));
            }
        }
    }

    #[test]
    fn circular_functions_are_within_their_error() {
        let angles = || sweep(0.0, 1e6).chain(sweep(-0.0, -1e6));
        check("sin", 1.6, angles(), sin, f64::sin);
        check("cos", 1.6, angles(), cos, f64::cos);
        check("tan", 3.5, angles(), tan, f64::tan);
        // Near the multiples of π/2 an angle that is only rounded loses its leading bits.
        for turns in -10_000..=10_000 {
            let near = (turns as f64 * core::f64::consts::FRAC_PI_2) as f32;
            for x in [near.next_down(), near, near.next_up()] {
                let (sine, cosine) = sin_cos(x);
                assert!(ulps(sine, (x as f64).sin()) <= 1.6 && ulps(cosine, (x as f64).cos()) <= 1.6, "{x:e}");
            }
        }
        for x in every_finite() {
            let (sine, cosine) = sin_cos(x);
            assert!(sine.abs() <= 1.0 && cosine.abs() <= 1.0, "{x:e}: {sine} {cosine}");
        }
    }

    #[test]
    fn arc_functions_are_within_their_error() {
        let unit = || sweep(0.0, 1.0).chain(sweep(-0.0, -1.0));
        check("asin", 2.5, unit(), asin, f64::asin);
        check("acos", 2.5, unit(), acos, f64::acos);
        check("atan", 3.0, every_finite(), atan, f64::atan);
        for long in [1e-38f32, 1e-3, 1.0, 7.0, 1e38] {
            for short in sweep(0.0, 1.0).step_by(11).map(|x| x * long) {
                for (y, x) in [(short, long), (long, short), (-short, long), (short, -long), (-long, -short)] {
                    let exact = (y as f64).atan2(x as f64);
                    assert!(ulps(atan2(y, x), exact) <= 3.0, "atan2({y:e}, {x:e}): {:e} {exact:e}", atan2(y, x));
                }
            }
        }
    }

    /// The values are the definitions' limits, as IEEE 754-2019 lists them in 9.2.1 (`pow` at a negative base aside).
    #[test]
    fn edges_are_exact() {
        let inf = f32::INFINITY;
        let cases = [
            ("exp2(0)", exp2(0.0), 1.0),
            ("exp2(10)", exp2(10.0), 1024.0),
            ("exp2(-149)", exp2(-149.0), f32::from_bits(1)),
            ("exp2(-151)", exp2(-151.0), 0.0),
            ("exp2(128)", exp2(128.0), inf),
            ("exp(0)", exp(-0.0), 1.0),
            ("exp(-inf)", exp(-inf), 0.0),
            ("exp(inf)", exp(inf), inf),
            ("log2(1)", log2(1.0), 0.0),
            ("log2(2^-149)", log2(f32::from_bits(1)), -149.0),
            ("ln(1)", ln(1.0), 0.0),
            ("ln(0)", ln(0.0), -inf),
            ("ln(-0)", ln(-0.0), -inf),
            ("ln(inf)", ln(inf), inf),
            ("ln(-1)", ln(-1.0), f32::NAN),
            ("pow(0, 0)", pow(0.0, 0.0), 1.0),
            ("pow(0, 1e-30)", pow(0.0, 1e-30), 0.0),
            ("pow(0, -1)", pow(0.0, -1.0), inf),
            ("pow(inf, 0)", pow(inf, 0.0), 1.0),
            ("pow(inf, -1)", pow(inf, -1.0), 0.0),
            ("pow(NaN, 0)", pow(f32::NAN, 0.0), 1.0),
            ("pow(1, 1e30)", pow(1.0, 1e30), 1.0),
            ("pow(-2, 2)", pow(-2.0, 2.0), f32::NAN),
            ("cbrt(-27)", cbrt(-27.0), -3.0),
            ("cbrt(-0)", cbrt(-0.0), -0.0),
            ("cos(0)", cos(0.0), 1.0),
            ("sin(inf)", sin(inf), f32::NAN),
            ("asin(-1)", asin(-1.0), -FRAC_PI_2),
            ("acos(1)", acos(1.0), 0.0),
            ("acos(-1)", acos(-1.0), PI),
            ("acos(1 + ulp)", acos(1.0f32.next_up()), f32::NAN),
            ("atan(inf)", atan(inf), FRAC_PI_2),
            ("atan2(0, 0)", atan2(0.0, 0.0), 0.0),
            ("atan2(-0, 1)", atan2(-0.0, 1.0), -0.0),
            ("atan2(0, -0)", atan2(0.0, -0.0), PI),
            ("atan2(-0, -1)", atan2(-0.0, -1.0), -PI),
            ("atan2(1, 0)", atan2(1.0, 0.0), FRAC_PI_2),
        ];
        for (name, result, expected) in cases {
            let same = result.to_bits() == expected.to_bits() || (result.is_nan() && expected.is_nan());
            assert!(same, "{name}: {result:e}, expected {expected:e}");
        }
        for not_a_number in [exp2, exp, log2, ln, cbrt, pow5, sin, cos, tan, asin, acos, atan].map(|f| f(f32::NAN)) {
            assert!(not_a_number.is_nan());
        }
        assert!(pow(f32::NAN, 1.0).is_nan() && atan2(f32::NAN, 1.0).is_nan() && atan2(1.0, f32::NAN).is_nan());
    }

    dispatch! {
        /// Folds the bits of every function at `x` into a number.
        fn fingerprint(x: &[f32], out: &mut [u32]) {
            for (&x, out) in x.iter().zip(out) {
                let (sine, cosine) = sin_cos(x);
                let whole_line = [exp2(x), exp(x), log2(x.abs()), ln(x.abs()), pow(x.abs(), 2.4), cbrt(x), pow5(x)];
                let circle = [sine, cosine, tan(x), asin(sine), acos(cosine), atan(x), atan2(sine, x)];
                let mut bits = 0u32;
                for value in whole_line.into_iter().chain(circle) {
                    let value = if value.is_nan() { 0 } else { value.to_bits() };
                    bits = (bits ^ value).wrapping_mul(0x0100_0193);
                }
                *out = bits;
            }
        }
    }

    /// The number below was computed once on x86-64; it holds on every platform and at every level.
    #[test]
    fn bits_are_the_same_everywhere() {
        let x: Vec<f32> = every_finite().step_by(101).collect();
        for level in Level::available() {
            let mut bits = vec![0; x.len()];
            fingerprint(level, &x, &mut bits);
            let all = bits.iter().fold(0u32, |all, bits| (all ^ bits).wrapping_mul(0x0100_0193));
            assert_eq!(all, 2_161_112_719, "{level:?}");
        }
    }
}
