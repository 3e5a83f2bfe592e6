//! Colors: the sRGB transfer curve, luminance, and hexadecimal notation.
//!
//! Inside the engine a color is a triple of linear Rec.709 values. sRGB (IEC 61966-2-1) shares its primaries and white
//! point, so only the curve lies between them.

use core::fmt;

use brewster_lanes::math;
use glam::Vec3;

/// The weights of the Rec.709 channels in luminance (ITU-R BT.709-6, item 3.2).
pub const LUMINANCE_WEIGHTS: Vec3 = Vec3::new(0.2126, 0.7152, 0.0722);

/// Why a text is no color in hexadecimal notation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InvalidHex {
    /// It does not begin with `#`.
    NoHash,
    /// It has neither three digits nor six.
    Length(usize),
    /// A character is no hexadecimal digit.
    Digit(char),
}

/// The luminance of a linear color: a weighted sum that keeps white at 1.
#[inline(always)]
pub fn luminance(color: Vec3) -> f32 {
    color.x * LUMINANCE_WEIGHTS.x + color.y * LUMINANCE_WEIGHTS.y + color.z * LUMINANCE_WEIGHTS.z
}

/// The linear value of an sRGB-encoded one; 0..1 to 0..1, and beyond 1 the curve goes on.
#[inline(always)]
pub fn linear_from_srgb(encoded: f32) -> f32 {
    if encoded <= 0.040_45 { encoded / 12.92 } else { math::pow((encoded + 0.055) / 1.055, 2.4) }
}

/// The sRGB encoding of a linear value; 0..1 to 0..1, and beyond 1 the curve goes on.
#[inline(always)]
pub fn srgb_from_linear(linear: f32) -> f32 {
    if linear <= 0.003_130_8 { linear * 12.92 } else { 1.055 * math::pow(linear, 1.0 / 2.4) - 0.055 }
}

/// The linear value of an 8-bit sRGB one.
#[inline(always)]
pub fn linear_from_srgb8(encoded: u8) -> f32 {
    linear_from_srgb(encoded as f32 / 255.0)
}

/// The nearest 8-bit sRGB value; what lies outside 0..1 is clamped, and NaN is 0. Undoes [`linear_from_srgb8`] exactly.
#[inline(always)]
pub fn srgb8_from_linear(linear: f32) -> u8 {
    (srgb_from_linear(linear) * 255.0 + 0.5) as u8
}

/// The linear value of a 16-bit sRGB one.
#[inline(always)]
pub fn linear_from_srgb16(encoded: u16) -> f32 {
    linear_from_srgb(encoded as f32 / 65535.0)
}

/// The nearest 16-bit sRGB value; as [`srgb8_from_linear`].
#[inline(always)]
pub fn srgb16_from_linear(linear: f32) -> u16 {
    (srgb_from_linear(linear) * 65535.0 + 0.5) as u16
}

/// The linear color of an sRGB triple of bytes.
#[inline(always)]
pub fn linear_from_srgb_bytes(bytes: [u8; 3]) -> Vec3 {
    Vec3::from_array(bytes.map(linear_from_srgb8))
}

/// The linear color that `#rrggbb` or `#rgb` writes in sRGB; `#rgb` doubles its digits.
pub fn linear_from_hex(text: &str) -> Result<Vec3, InvalidHex> {
    let digits = text.strip_prefix('#').ok_or(InvalidHex::NoHash)?;
    let mut nibbles = [0; 6];
    let count = digits.chars().count();
    if count != 3 && count != 6 {
        return Err(InvalidHex::Length(count));
    }
    for (nibble, digit) in nibbles.iter_mut().zip(digits.chars()) {
        *nibble = digit.to_digit(16).ok_or(InvalidHex::Digit(digit))? as u8;
    }
    let [a, b, c, d, e, f] = nibbles;
    let bytes = if count == 3 { [a * 17, b * 17, c * 17] } else { [a * 16 + b, c * 16 + d, e * 16 + f] };
    Ok(linear_from_srgb_bytes(bytes))
}

impl fmt::Display for InvalidHex {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            InvalidHex::NoHash => write!(f, "a color in hexadecimal notation begins with `#`"),
            InvalidHex::Length(count) => write!(f, "a color has 3 or 6 hexadecimal digits, not {count}"),
            InvalidHex::Digit(digit) => write!(f, "{digit:?} is no hexadecimal digit"),
        }
    }
}

impl core::error::Error for InvalidHex {}

#[cfg(test)]
mod tests {
    use super::*;

    /// The curve in f64, from IEC 61966-2-1.
    fn linear_in_f64(encoded: f64) -> f64 {
        if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
    }

    #[test]
    fn the_curve_is_the_standards() {
        for encoded in 0..=u16::MAX {
            let exact = linear_in_f64(encoded as f64 / 65535.0);
            let linear = linear_from_srgb16(encoded);
            assert!((linear as f64 - exact).abs() <= 5e-7 * exact, "{encoded}: {linear} {exact}");
        }
        // Well known: the middle gray of screens, 0x80, is 21.6 % linear; 18 % gray is 0x76.
        assert!((linear_from_srgb8(0x80) - 0.215_861).abs() < 1e-6);
        assert_eq!(srgb8_from_linear(0.18), 0x76);
    }

    #[test]
    fn integers_come_back_exactly() {
        for byte in 0..=u8::MAX {
            assert_eq!(srgb8_from_linear(linear_from_srgb8(byte)), byte);
        }
        for word in 0..=u16::MAX {
            assert_eq!(srgb16_from_linear(linear_from_srgb16(word)), word);
        }
        assert_eq!((linear_from_srgb8(0), linear_from_srgb8(255)), (0.0, 1.0));
    }

    #[test]
    fn what_is_no_light_is_clamped() {
        for (linear, byte) in [(-1.0, 0), (f32::NAN, 0), (f32::NEG_INFINITY, 0), (2.0, 255), (f32::INFINITY, 255)] {
            assert_eq!(srgb8_from_linear(linear), byte, "{linear}");
            assert_eq!(srgb16_from_linear(linear), byte as u16 * 257, "{linear}");
        }
    }

    #[test]
    fn white_has_luminance_one() {
        assert_eq!(luminance(Vec3::ONE), 1.0);
        assert_eq!(luminance(Vec3::Y), 0.7152);
    }

    #[test]
    fn hexadecimal_notation() {
        let cases = [
            ("#000000", [0, 0, 0]),
            ("#ffffff", [255, 255, 255]),
            ("#FF8000", [255, 128, 0]),
            ("#1a2B3c", [0x1a, 0x2b, 0x3c]),
            ("#f80", [255, 0x88, 0]),
        ];
        for (text, bytes) in cases {
            assert_eq!(linear_from_hex(text), Ok(linear_from_srgb_bytes(bytes)), "{text}");
        }
        let errors = [
            ("ffffff", InvalidHex::NoHash),
            ("", InvalidHex::NoHash),
            ("#", InvalidHex::Length(0)),
            ("#ffff", InvalidHex::Length(4)),
            ("#fffffff", InvalidHex::Length(7)),
            ("#ggg", InvalidHex::Digit('g')),
            ("#12345ß", InvalidHex::Digit('ß')),
            ("#+1+1+1", InvalidHex::Digit('+')),
        ];
        for (text, error) in errors {
            assert_eq!(linear_from_hex(text), Err(error), "{text}");
        }
    }
}
