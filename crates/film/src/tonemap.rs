//! Radiance to display values: exposure, tone mapping and the sRGB curve, in plain arithmetic.

use brewster_lanes::math;

/// How radiance becomes what a display shows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Display {
    /// Exposure in stops: radiance is multiplied by 2^exposure first.
    pub exposure: f32,
    /// The curve that follows.
    pub tone_map: ToneMap,
}

impl Display {
    /// The display values of a linear Rec.709 color, encoded for sRGB, each in 0..=1.
    ///
    /// Negative components and NaN show as 0, infinite ones as the curve's end.
    pub fn encode(&self, color: [f32; 3]) -> [f32; 3] {
        // Finite, so that black stays black.
        let gain = math::exp2(self.exposure).min(f32::MAX);
        self.tone_map.encode(color.map(|value| value.max(0.0) * gain))
    }
}

/// A tone mapping: takes exposed linear Rec.709 radiance, >= 0, to sRGB display values in 0..=1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ToneMap {
    /// Cut at 1 and nothing else: linear light, for programs that ask for it.
    None,
    /// Cut at 1, then the sRGB curve (IEC 61966-2-1). What is 1 or less shows as it is.
    #[default]
    Srgb,
    /// John Hable's curve of Uncharted 2 ("Filmic tonemapping operators", filmicworlds.com, 2010) with exposure bias 2 and
    /// white point 11.2: radiance 5.6 is white. Channel by channel.
    Filmic,
    /// Stephen Hill's fit of the ACES reference rendering and sRGB output transforms (BakingLab, 2016).
    Aces,
    /// Troy Sobotka's AgX without a look, in Benjamin Wrensch's polynomial fit ("Minimal AgX implementation",
    /// iolite-engine.com, 2023). Its result is display values already: the sRGB curve does not follow.
    Agx,
    /// Khronos PBR Neutral (KhronosGroup/ToneMapping, 2024): keeps base colors up to 0.8, less a reflectance of 0.04.
    PbrNeutral,
}

impl ToneMap {
    /// Every tone mapping.
    pub const ALL: [ToneMap; 6] =
        [ToneMap::None, ToneMap::Srgb, ToneMap::Filmic, ToneMap::Aces, ToneMap::Agx, ToneMap::PbrNeutral];

    /// `none`, `srgb`, `filmic`, `aces`, `agx` or `pbr-neutral`.
    pub fn name(self) -> &'static str {
        match self {
            ToneMap::None => "none",
            ToneMap::Srgb => "srgb",
            ToneMap::Filmic => "filmic",
            ToneMap::Aces => "aces",
            ToneMap::Agx => "agx",
            ToneMap::PbrNeutral => "pbr-neutral",
        }
    }

    /// The display values of a linear Rec.709 color with components >= 0.
    pub fn encode(self, color: [f32; 3]) -> [f32; 3] {
        // Where an infinite component would end, this largest one has ended long before.
        let color = color.map(|value| value.min(1e6));
        match self {
            ToneMap::None => color.map(cut),
            ToneMap::Srgb => color.map(srgb_encode),
            ToneMap::Filmic => color.map(|value| srgb_encode(hable(2.0 * value) / hable(11.2))),
            ToneMap::Aces => aces(color).map(srgb_encode),
            ToneMap::Agx => agx(color),
            ToneMap::PbrNeutral => pbr_neutral(color).map(srgb_encode),
        }
    }
}

/// The sRGB curve (IEC 61966-2-1): linear light, cut to 0..=1 (NaN to 0), to display values.
#[inline]
pub fn srgb_encode(linear: f32) -> f32 {
    let linear = cut(linear);
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * math::pow(linear, 1.0 / 2.4) - 0.055 }
}

/// The sRGB curve backwards: display values, cut to 0..=1 (NaN to 0), to linear light.
#[inline]
pub fn srgb_decode(encoded: f32) -> f32 {
    let encoded = cut(encoded);
    if encoded <= 0.040_45 { encoded / 12.92 } else { math::pow((encoded + 0.055) / 1.055, 2.4) }
}

/// Cuts to 0..=1; NaN is 0.
#[inline]
fn cut(value: f32) -> f32 {
    if value > 0.0 { value.min(1.0) } else { 0.0 }
}

/// Hable's curve; his names: A shoulder strength, B linear strength, C linear angle, D toe strength, E / F toe angle.
fn hable(x: f32) -> f32 {
    const A: f32 = 0.15;
    const B: f32 = 0.50;
    const C: f32 = 0.10;
    const D: f32 = 0.20;
    const E: f32 = 0.02;
    const F: f32 = 0.30;
    (x * (A * x + C * B) + D * E) / (x * (A * x + B) + D * F) - E / F
}

/// Rec.709 to the rendering space, a rational curve, and back.
fn aces(color: [f32; 3]) -> [f32; 3] {
    let color =
        multiply([[0.59719, 0.35458, 0.04823], [0.07600, 0.90834, 0.01566], [0.02840, 0.13383, 0.83777]], color);
    let color = color.map(|x| (x * (x + 0.024_578_6) - 0.000_090_537) / (x * (0.983_729 * x + 0.432_951) + 0.238_081));
    multiply([[1.60475, -0.53108, -0.07367], [-0.10208, 1.10813, -0.00605], [-0.00327, -0.07276, 1.07602]], color)
}

/// Rec.709 into a narrower gamut, logarithm over 16.5 stops, a sigmoid as a polynomial, and out of the gamut.
fn agx(color: [f32; 3]) -> [f32; 3] {
    const INSET: [[f32; 3]; 3] = [
        [0.842_479_06, 0.078_433_6, 0.079_223_745],
        [0.042_328_242, 0.878_468_64, 0.079_166_13],
        [0.042_375_655, 0.078_433_6, 0.879_143],
    ];
    const OUTSET: [[f32; 3]; 3] = [
        [1.196_879, -0.098_020_88, -0.099_029_74],
        [-0.052_896_853, 1.151_903_1, -0.098_961_174],
        [-0.052_971_635, -0.098_043_45, 1.151_073_7],
    ];
    const LOWEST: f32 = -12.473_93;
    const HIGHEST: f32 = 4.026_069;
    const SIGMOID: [f32; 7] = [15.5, -40.14, 31.96, -6.868, 0.4298, 0.1191, -0.002_32];
    let color = multiply(INSET, color).map(|value| {
        let x = (math::log2(value).clamp(LOWEST, HIGHEST) - LOWEST) / (HIGHEST - LOWEST);
        SIGMOID.into_iter().fold(0.0, |sum, coefficient| sum * x + coefficient)
    });
    multiply(OUTSET, color).map(|value| value.clamp(0.0, 1.0))
}

/// Takes the reflectance of a dielectric off, then compresses and whitens what peaks above 0.76.
fn pbr_neutral(color: [f32; 3]) -> [f32; 3] {
    const START: f32 = 0.8 - 0.04;
    const DESATURATION: f32 = 0.15;
    let [r, g, b] = color;
    let least = r.min(g).min(b);
    let offset = if least < 0.08 { least - 6.25 * least * least } else { 0.04 };
    let color = color.map(|value| value - offset);
    let peak = r.max(g).max(b) - offset;
    if peak < START {
        return color;
    }
    let range = 1.0 - START;
    let new_peak = 1.0 - range * range / (peak + range - START);
    let whiteness = 1.0 - 1.0 / (DESATURATION * (peak - new_peak) + 1.0);
    color.map(|value| {
        let scaled = value * (new_peak / peak);
        scaled + (new_peak - scaled) * whiteness
    })
}

fn multiply(rows: [[f32; 3]; 3], [x, y, z]: [f32; 3]) -> [f32; 3] {
    rows.map(|[a, b, c]| a * x + b * y + c * z)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(found: [f32; 3], expected: [f32; 3], tolerance: f32) {
        let close = found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() <= tolerance);
        assert!(close, "{found:?} for {expected:?}");
    }

    #[test]
    fn the_srgb_curve_has_its_known_values() {
        // IEC 61966-2-1: the curve's pieces meet at (0.0031308, 0.04045); 128/255 is 0.2158605 in linear light.
        let known = [(0.0, 0.0), (0.003_130_8, 0.040_45), (0.215_860_5, 128.0 / 255.0), (0.5, 0.735_357), (1.0, 1.0)];
        for (linear, encoded) in known {
            assert!((srgb_encode(linear) - encoded).abs() < 2e-6, "{linear}");
            assert!((srgb_decode(encoded) - linear).abs() < 2e-6, "{encoded}");
        }
        for (bad, like) in [(-1.0, 0.0), (2.0, 1.0), (f32::NAN, 0.0), (f32::INFINITY, 1.0)] {
            assert_eq!((srgb_encode(bad), srgb_decode(bad)), (srgb_encode(like), srgb_decode(like)), "{bad}");
        }
    }

    #[test]
    fn the_srgb_curve_inverts_every_byte() {
        for byte in 0..=255u8 {
            let linear = srgb_decode(f32::from(byte) / 255.0);
            assert!((255.0 * srgb_encode(linear) - f32::from(byte)).abs() < 1e-4, "{byte}");
            let exact = f64::from(byte) / 255.0;
            let exact = if exact <= 0.04045 { exact / 12.92 } else { ((exact + 0.055) / 1.055).powf(2.4) };
            assert!((f64::from(linear) - exact).abs() < 3e-7, "{byte}");
        }
    }

    /// The values follow from the published formulas by hand.
    #[test]
    fn curves_meet_values_worked_out_by_hand() {
        // Hable at 2 * 0.5 = 1: (0.204 / 0.71 - 1/15) / (19.38 / 24.476 - 1/15); at half the white point: 1.
        check([hable(1.0) / hable(11.2); 3], [0.304_3; 3], 1e-5);
        check(ToneMap::Filmic.encode([0.0, 0.5, 5.6]), [0.0, srgb_encode(0.304_3), 1.0], 1e-5);
        // Hill at gray 0.18, which both matrices keep: 0.036733611 / 0.347885.
        check(aces([0.18; 3]), [0.105_591; 3], 1e-5);
        // AgX's sigmoid has its pivot, middle gray, at (20/33, 1/2); the fit is off by 0.0033 there.
        check(agx([0.18; 3]), [0.496_7; 3], 2e-4);
        // PBR Neutral: 0.08 to 0.8 come out less 0.04; gray 1.04 peaks at 1 - 0.24²/0.48; the last case by the steps.
        check(pbr_neutral([0.08, 0.3, 0.79]), [0.04, 0.26, 0.75], 1e-6);
        check(pbr_neutral([1.04; 3]), [0.88; 3], 1e-6);
        check(pbr_neutral([2.04, 0.54, 0.04]), [0.961_342, 0.341_433, 0.134_797], 1e-5);
    }

    #[test]
    fn curves_rise_from_black_to_white_and_survive_anything() {
        for tone_map in ToneMap::ALL {
            assert!(tone_map.encode([0.0; 3])[0] < 2e-3, "{tone_map:?}");
            let mut last = -1.0;
            for step in -160..160 {
                let gray = tone_map.encode([math::exp2(step as f32 / 8.0); 3]);
                assert!(gray[0] >= last && gray[0] <= 1.0, "{tone_map:?}: {gray:?} after {last}");
                last = gray[0];
            }
            assert!(last > 0.99, "{tone_map:?}: {last}");
            for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, -1.0] {
                for (exposure, color) in [(3.0, [bad; 3]), (-3.0, [bad, 0.5, 0.0]), (1e9, [0.0, 0.5, bad])] {
                    let encoded = Display { exposure, tone_map }.encode(color);
                    assert!(
                        encoded.iter().all(|value| (0.0..=1.0).contains(value)),
                        "{tone_map:?} {color:?} {encoded:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn black_stays_black() {
        assert_eq!(Display { exposure: 1e9, tone_map: ToneMap::Srgb }.encode([0.0, f32::NAN, -1.0]), [0.0; 3]);
    }

    #[test]
    fn a_stop_doubles() {
        let display = |exposure| Display { exposure, tone_map: ToneMap::Filmic };
        assert_eq!(display(1.0).encode([0.1, 0.2, 0.3]), display(0.0).encode([0.2, 0.4, 0.6]));
        assert_eq!(display(-2.0).encode([0.1, 0.2, 0.3]), display(0.0).encode([0.025, 0.05, 0.3 / 4.0]));
    }
}
