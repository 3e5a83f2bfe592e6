//! Dispersion: an index for every wavelength, and the one wavelength that a path of three channels follows.
//!
//! A path that meets its first dispersive boundary draws a [`Wavelength`] and keeps it: from there on every index is that
//! of the wavelength, and the path's color is multiplied once by the sample's weight. Nothing else changes, so what does
//! not disperse keeps its color in the mean.
//!
//! **What a wavelength is worth.** A scene's colors are triples relative to a white of (1, 1, 1), not spectra, so each
//! channel's light has to be laid out over the wavelengths: a *band*, non-negative and of integral 1, and a channel
//! converges to the average over its band of what each wavelength sees. Equal energy at every wavelength is (1, 1, 1).
//! The bands are the matching functions of the Rec.709 primaries (CIE 1931 2° observer), cut off below 0, scaled each to 1.
//!
//! - The uncut functions are negative where a spectral color lies outside of Rec.709. With them single samples would be
//!   negative, the noise larger, and a rainbow would end in negative pixels that a display cuts off anyway. Cut here,
//!   once and linearly, the purest colors become a little paler and the limit is the same for every exposure.
//! - The white is that of equal energy and not of D65: with each channel scaled to 1, D65 would only tilt the bands within
//!   a channel, and nothing says that a scene's lamps have its spectrum.
//!
//! **How it is drawn.** By the mean of the three bands, so that the weight in channel c is `3 b_c/(b_r + b_g + b_b)`: at
//! least 0, three channels adding up to 3, and of mean (1, 1, 1). The bands are straight lines between the observer's
//! rows, and their integral is inverted exactly: the mean is no approximation. One wavelength and not several at a time:
//! behind the first dispersive boundary they part.

use glam::Vec3;

use crate::glasses::{C_LINE, D_LINE, F_LINE, Glass};
use crate::spectrum::{self, BAND_ROWS, BAND_STEP, BANDS};

/// How an index of refraction depends on the wavelength.
///
/// Every index is at least 1: formulas far outside the range that they were fitted to give anything.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DispersiveIndex {
    /// A formula of three numbers, or of an Abbe number.
    Cauchy(Cauchy),
    /// A formula of three resonances.
    Sellmeier(Sellmeier),
    /// A measured glass.
    Glass(&'static Glass),
}

/// Cauchy's equation `n = a + b/λ² + c/λ⁴`, λ in micrometers: transparent matter over the visible range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cauchy {
    /// The index far in the infrared.
    pub a: f32,
    /// In µm².
    pub b: f32,
    /// In µm⁴.
    pub c: f32,
}

/// Sellmeier's equation `n² = 1 + Σ B λ²/(λ² - C)`, λ in micrometers: what glass catalogs give.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sellmeier {
    /// The strengths of three resonances.
    pub b: Vec3,
    /// The squares of their wavelengths, in µm².
    pub c: Vec3,
}

/// A wavelength that a path goes on with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wavelength {
    /// In nanometers, from 380 to 780.
    pub nanometers: f32,
    /// What the path's color is multiplied by: at least 0, with a sum of 3 and a mean of (1, 1, 1).
    pub weight: Vec3,
}

impl DispersiveIndex {
    /// The index at a wavelength in nanometers.
    #[inline]
    pub fn ior_at(&self, nanometers: f32) -> f32 {
        match self {
            DispersiveIndex::Cauchy(cauchy) => cauchy.ior_at(nanometers),
            DispersiveIndex::Sellmeier(sellmeier) => sellmeier.ior_at(nanometers),
            DispersiveIndex::Glass(glass) => glass.ior_at(nanometers),
        }
    }

    /// The index at the d line, `n_d`: what stands for all wavelengths where none was drawn.
    #[inline]
    pub fn ior(&self) -> f32 {
        self.ior_at(D_LINE)
    }

    /// Whether its numbers are finite and no resonance lies among the visible wavelengths.
    pub fn is_sound(&self) -> bool {
        let square = |nanometers: f32| 1e-6 * nanometers * nanometers;
        let visible = square(*spectrum::VISIBLE.start())..=square(*spectrum::VISIBLE.end());
        match self {
            DispersiveIndex::Cauchy(Cauchy { a, b, c }) => [a, b, c].into_iter().all(|number| number.is_finite()),
            DispersiveIndex::Sellmeier(Sellmeier { b, c }) => {
                b.is_finite() && c.is_finite() && !c.to_array().iter().any(|c| visible.contains(c))
            }
            DispersiveIndex::Glass(_) => true,
        }
    }

    /// Abbe's number `(n_d - 1)/(n_F - n_C)`; infinite without dispersion.
    pub fn abbe_number(&self) -> f32 {
        (self.ior() - 1.0) / (self.ior_at(F_LINE) - self.ior_at(C_LINE))
    }
}

impl Cauchy {
    /// The medium of index `ior` at the d line and Abbe number `abbe`, with `c = 0`; an Abbe number that is not positive
    /// and finite stands for no dispersion.
    ///
    /// glTF's dispersion (KHR_materials_dispersion) is 20 over the Abbe number, and its equation is this one.
    #[inline]
    pub fn from_abbe(ior: f32, abbe: f32) -> Cauchy {
        if !(abbe > 0.0 && abbe < f32::INFINITY) {
            return Cauchy { a: ior, b: 0.0, c: 0.0 };
        }
        let b = (ior - 1.0) / (abbe * (inverse_square(F_LINE) - inverse_square(C_LINE)));
        Cauchy { a: ior - b * inverse_square(D_LINE), b, c: 0.0 }
    }

    /// The index at a wavelength in nanometers.
    #[inline(always)]
    pub fn ior_at(&self, nanometers: f32) -> f32 {
        let x = inverse_square(nanometers);
        (self.a + (self.b + self.c * x) * x).max(1.0)
    }
}

impl Sellmeier {
    /// The index at a wavelength in nanometers.
    #[inline(always)]
    pub fn ior_at(&self, nanometers: f32) -> f32 {
        let square = 1e-6 * nanometers * nanometers;
        let term = |i: usize| self.b[i] * square / (square - self.c[i]);
        (1.0 + (term(0) + term(1) + term(2))).max(1.0).sqrt()
    }
}

/// `1/λ²` in µm⁻².
#[inline(always)]
fn inverse_square(nanometers: f32) -> f32 {
    1e6 / (nanometers * nanometers)
}

/// The bands in f32: what is drawn and what is weighed are the same numbers.
static BAND: [Vec3; BAND_ROWS] = {
    let mut band = [Vec3::ZERO; BAND_ROWS];
    let mut row = 0;
    while row < BAND_ROWS {
        let [r, g, b] = BANDS[row];
        band[row] = Vec3::new(r as f32, g as f32, b as f32);
        row += 1;
    }
    band
};

/// The probability of a wavelength below each row.
static BELOW: [f32; BAND_ROWS] = {
    let mut below = [0.0; BAND_ROWS];
    let (mut row, mut sum) = (1, 0.0);
    while row < BAND_ROWS {
        let ([r0, g0, b0], [r1, g1, b1]) = (BANDS[row - 1], BANDS[row]);
        sum += 0.5 * BAND_STEP * (r0 + g0 + b0 + r1 + g1 + b1) / 3.0;
        below[row] = sum as f32;
        row += 1;
    }
    below
};

impl Wavelength {
    /// The wavelength of a random number in [0, 1), growing with it.
    #[inline]
    pub fn sample(u: f32) -> Wavelength {
        let row = BELOW[1..BAND_ROWS - 1].partition_point(|below| *below <= u);
        let (low, high) = (density(BAND[row]), density(BAND[row + 1]));
        // With t the place between both rows, low t + (high - low) t²/2 = rest, solved without a difference.
        let rest = (u - BELOW[row]) * (1.0 / BAND_STEP as f32);
        let root = (low * low + 2.0 * (high - low) * rest).max(0.0).sqrt();
        let part = (2.0 * rest / (low + root)).clamp(0.0, 1.0);
        let band = between(row, part);
        Wavelength {
            nanometers: spectrum::VISIBLE.start() + BAND_STEP as f32 * (row as f32 + part),
            weight: band / density(band),
        }
    }

    /// The density of [`Wavelength::sample`] per nanometer.
    #[inline]
    pub fn pdf(nanometers: f32) -> f32 {
        if !spectrum::VISIBLE.contains(&nanometers) {
            return 0.0;
        }
        let place = (nanometers - spectrum::VISIBLE.start()) * (1.0 / BAND_STEP as f32);
        let row = (place as usize).min(BAND_ROWS - 2);
        density(between(row, place - row as f32))
    }
}

/// The wavelength that a path follows, or none yet: small, so that every ray in flight can carry it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PathWavelength(u16);

impl PathWavelength {
    /// The path has not met a boundary that disperses: it carries all wavelengths.
    pub const NONE: PathWavelength = PathWavelength(0);

    /// The wavelength of a random number in [0, 1), to a 65,535th of it.
    #[inline]
    pub fn draw(u: f32) -> PathWavelength {
        PathWavelength(1 + (u * f32::from(u16::MAX)) as u16)
    }

    /// As a number: 0 for none.
    pub const fn bits(self) -> u16 {
        self.0
    }

    /// What has these [`bits`](PathWavelength::bits).
    pub const fn from_bits(bits: u16) -> PathWavelength {
        PathWavelength(bits)
    }

    /// The wavelength that was drawn.
    #[inline]
    pub fn get(self) -> Option<Wavelength> {
        (self != PathWavelength::NONE).then(|| Wavelength::sample((f32::from(self.0) - 0.5) / f32::from(u16::MAX)))
    }
}

#[inline(always)]
fn between(row: usize, part: f32) -> Vec3 {
    BAND[row] + (BAND[row + 1] - BAND[row]) * part
}

/// The mean of the three bands.
#[inline(always)]
fn density(band: Vec3) -> f32 {
    band.element_sum() * (1.0 / 3.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::glasses::glass;
    use crate::statistics::{Random, chi_squared};
    use glam::DVec3;

    /// Indices at the d, F and C lines and Abbe numbers of SCHOTT's data sheets (the last: Malitson, 1965).
    const CATALOG: [(&str, [f32; 3], f32); 4] = [
        ("BK7", [1.5168, 1.522_38, 1.514_32], 64.17),
        ("F2", [1.620_04, 1.632_08, 1.615_03], 36.37),
        ("SF11", [1.784_72, 1.806_45, 1.775_99], 25.76),
        ("fused silica", [1.458_46, 1.463_13, 1.456_37], 67.82),
    ];

    /// Every wavelength that a path can carry is as likely as any other: white stays white.
    #[test]
    fn paths_stay_white() {
        assert_eq!(PathWavelength::NONE.get(), None);
        let drawn = |i: u32| PathWavelength::draw(i as f32 / 65_535.0 + 1e-6);
        let weights = (0..65_535).map(|i| drawn(i).get().expect("it was drawn").weight.as_dvec3());
        let mean = weights.sum::<glam::DVec3>() / 65_535.0;
        assert!((mean - 1.0).abs().max_element() < 1e-5, "{mean}");
        let codes = (0..65_535).map(|i| drawn(i).0);
        assert!(codes.eq(1..=u16::MAX), "all codes, each once");
    }

    #[test]
    fn indices_are_the_catalogs() {
        for (name, [d, f, c], abbe) in CATALOG {
            let measured = DispersiveIndex::Glass(glass(name).expect("a named glass"));
            for (line, ior) in [(D_LINE, d), (F_LINE, f), (C_LINE, c)] {
                assert!((measured.ior_at(line) - ior).abs() < 1e-5, "{name} {line}: {}", measured.ior_at(line));
            }
            // An Abbe number fixes n_d and n_F - n_C, and Cauchy's two terms how n_d divides it.
            let cauchy = DispersiveIndex::Cauchy(Cauchy::from_abbe(d, abbe));
            assert!((cauchy.ior() - d).abs() < 2e-7, "{name}: {}", cauchy.ior());
            assert!((cauchy.abbe_number() / abbe - 1.0).abs() < 1e-4, "{name}: {}", cauchy.abbe_number());
            for (line, ior) in [(F_LINE, f), (C_LINE, c)] {
                assert!((cauchy.ior_at(line) - ior).abs() < 1e-3, "{name} {line}: {}", cauchy.ior_at(line));
            }
        }
    }

    /// BK7's coefficients as an author would type them (SCHOTT), against the catalog's lines.
    #[test]
    fn resonances_of_an_author() {
        let bk7 = DispersiveIndex::Sellmeier(Sellmeier {
            b: Vec3::new(1.039_612, 0.231_792_34, 1.010_469_4),
            c: Vec3::new(0.006_000_698_7, 0.020_017_914, 103.560_65),
        });
        let (_, [d, f, c], abbe) = CATALOG[0];
        for (line, ior) in [(D_LINE, d), (F_LINE, f), (C_LINE, c)] {
            assert!((bk7.ior_at(line) - ior).abs() < 1e-5, "{line}: {}", bk7.ior_at(line));
        }
        assert!((bk7.abbe_number() / abbe - 1.0).abs() < 1e-3);
        let wrong = Sellmeier { b: Vec3::splat(-5.0), c: Vec3::splat(0.2) };
        assert_eq!((wrong.ior_at(550.0), Sellmeier { b: Vec3::NAN, ..wrong }.ior_at(550.0)), (1.0, 1.0));
    }

    #[test]
    fn abbe_numbers_as_in_gltf() {
        // KHR_materials_dispersion, with its own constants.
        let gltf = |nanometers: f32| 1.5 + 0.5 / 30.0 * (523_655.0 / (nanometers * nanometers) - 1.516_8);
        for nanometers in [400.0, 550.0, 700.0] {
            let ours = Cauchy::from_abbe(1.5, 30.0).ior_at(nanometers);
            assert!((ours - gltf(nanometers)).abs() < 1e-5, "{nanometers}: {ours} {}", gltf(nanometers));
        }
        for none in [0.0, -1.0, f32::INFINITY, f32::NAN] {
            assert_eq!(Cauchy::from_abbe(1.5, none), Cauchy { a: 1.5, b: 0.0, c: 0.0 });
        }
        // By hand at 500 nm: 1.5 + 0.005/0.25 + 0.0001/0.0625.
        assert!((Cauchy { a: 1.5, b: 0.005, c: 0.0001 }.ior_at(500.0) - 1.5216).abs() < 1e-6);
        assert_eq!(Cauchy { a: 0.9, b: 0.0, c: 0.0 }.ior_at(500.0), 1.0);
    }

    /// The mean of weight times spectrum over evenly spread numbers is the integral of band times spectrum: for white,
    /// for a bell curve and for a step. The integral is taken over steps of 0.1 nm of the tabulated bands in f64.
    #[test]
    fn the_mean_over_wavelengths_is_the_color() {
        const COUNT: u32 = 1 << 17;
        let bell = |nanometers: f32| (-((nanometers - 530.0) / 40.0).powi(2)).exp();
        let step = |nanometers: f32| if nanometers < 500.0 { 1.0 } else { 0.0 };
        let spectra: [&dyn Fn(f32) -> f32; 3] = [&|_| 1.0, &bell, &step];
        for (spectrum, tolerance) in spectra.into_iter().zip([1e-6, 1e-6, 3e-5]) {
            let value = |i: u32| {
                let Wavelength { nanometers, weight } = Wavelength::sample((i as f32 + 0.5) / COUNT as f32);
                weight.as_dvec3() * spectrum(nanometers) as f64
            };
            let mean = (0..COUNT).map(value).sum::<DVec3>() / COUNT as f64;
            let part = |i: usize| {
                let (row, t) = (i / 100, (i % 100) as f64 / 100.0 + 0.005);
                let band = |channel: usize| BANDS[row][channel] * (1.0 - t) + BANDS[row + 1][channel] * t;
                DVec3::new(band(0), band(1), band(2)) * 0.1 * spectrum(380.0 + (i as f32 + 0.5) * 0.1) as f64
            };
            let color = (0..4000).map(part).sum::<DVec3>();
            assert!((mean - color).abs().max_element() < tolerance, "{mean} {color}");
        }
    }

    /// Counts of drawn wavelengths against the density's integral over every 4 nm, and that against 1.
    #[test]
    fn wavelengths_follow_their_density() {
        let mut random = Random::new(23);
        let mut counts = [0.0; 100];
        for _ in 0..200_000 {
            let Wavelength { nanometers, weight } = Wavelength::sample(random.unit());
            assert!(weight.min_element() >= 0.0 && (weight.element_sum() - 3.0).abs() < 1e-5, "{weight}");
            counts[(((nanometers - 380.0) / 4.0) as usize).min(99)] += 1.0;
        }
        let expected = |cell: usize| {
            let at = |part: f64| Wavelength::pdf((380.0 + 4.0 * (cell as f64 + part)) as f32) as f64;
            200_000.0 * 4.0 * (0..100).map(|i| at((i as f64 + 0.5) / 100.0)).sum::<f64>() / 100.0
        };
        let expected: [f64; 100] = core::array::from_fn(expected);
        assert!((expected.iter().sum::<f64>() / 200_000.0 - 1.0).abs() < 1e-6);
        chi_squared("wavelengths", &counts, &expected, 1e-3);
    }

    #[test]
    fn every_number_gives_a_wavelength() {
        let numbers = (0..10_000).map(|i| i as f32 / 10_000.0).chain([1f32.next_down()]);
        let samples: Vec<Wavelength> = numbers.map(Wavelength::sample).collect();
        assert!(samples.is_sorted_by(|a, b| a.nanometers <= b.nanometers));
        assert_eq!(samples[0].nanometers, 380.0);
        for sample in samples {
            assert!(spectrum::VISIBLE.contains(&sample.nanometers) && sample.weight.is_finite(), "{sample:?}");
        }
        assert_eq!((Wavelength::pdf(379.0), Wavelength::pdf(781.0), Wavelength::pdf(f32::NAN)), (0.0, 0.0, 0.0));
    }

    /// The names of the colors: blue below 480 nm, green around 530 nm, red above 600 nm, and violet has some red.
    #[test]
    fn colors_of_the_rainbow() {
        for i in 0..1000 {
            let Wavelength { nanometers, weight } = Wavelength::sample((i as f32 + 0.5) / 1000.0);
            match nanometers {
                ..480.0 => assert_eq!(weight.max_position(), 2, "{nanometers}: {weight}"),
                505.0..555.0 => assert_eq!(weight.max_position(), 1, "{nanometers}: {weight}"),
                600.0.. => assert_eq!(weight.max_position(), 0, "{nanometers}: {weight}"),
                _ => {}
            }
            assert!(nanometers > 440.0 || weight.x > weight.y, "{nanometers}: {weight}");
        }
    }
}
