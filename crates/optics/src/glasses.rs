//! Named dielectrics: glasses, crystals, plastics and liquids, by their measured dispersion.
//!
//! The index that a tracer of three channels uses is the one at the helium d line, as in a glass catalog. Indices are
//! against air, as catalogs give them (water's against vacuum, as its source does); its own index is 1.0003.

use crate::spectrum;

/// The helium d line, in nanometers: where a catalog's `n_d` is measured.
pub const D_LINE: f32 = 587.561_8;
/// The hydrogen F line, in nanometers.
pub const F_LINE: f32 = 486.132_7;
/// The hydrogen C line, in nanometers.
pub const C_LINE: f32 = 656.272_5;

/// A transparent material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Glass {
    /// The usual name first, then others.
    pub names: &'static [&'static str],
    /// Where the numbers were published.
    pub source: &'static str,
    /// How the index depends on the wavelength.
    pub dispersion: Dispersion,
}

/// How an index of refraction depends on the wavelength λ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Dispersion {
    /// Sellmeier's equation `n² = 1 + Σ B λ²/(λ² - C)`, as pairs of B and C in µm².
    Sellmeier(&'static [(f32, f32)]),
    /// Samples of the wavelength in nanometers, growing, and the index.
    Table(&'static [f32], &'static [f32]),
}

/// The glass of that name, in any case: `BK7`, `diamond`, `water`.
pub fn glass(name: &str) -> Option<&'static Glass> {
    GLASSES.iter().find(|glass| glass.names.iter().any(|known| known.eq_ignore_ascii_case(name)))
}

/// Every name that [`glass`] knows.
pub fn glass_names() -> impl Iterator<Item = &'static str> {
    GLASSES.iter().flat_map(|glass| glass.names.iter().copied())
}

impl Glass {
    /// The index at the d line, `n_d`.
    pub fn ior(&self) -> f32 {
        self.ior_at(D_LINE)
    }

    /// The index at a wavelength in nanometers, over the visible range.
    pub fn ior_at(&self, wavelength: f32) -> f32 {
        match self.dispersion {
            Dispersion::Sellmeier(terms) => {
                let square = 1e-6 * wavelength * wavelength;
                (1.0 + terms.iter().map(|(b, c)| b * square / (square - c)).sum::<f32>()).sqrt()
            }
            Dispersion::Table(wavelengths, iors) => spectrum::interpolate(wavelengths, iors, wavelength),
        }
    }

    /// Abbe's number `(n_d - 1)/(n_F - n_C)`: the smaller, the more colors fan out.
    pub fn abbe_number(&self) -> f32 {
        (self.ior() - 1.0) / (self.ior_at(F_LINE) - self.ior_at(C_LINE))
    }
}

/// The square of a resonance's wavelength, for sources that give the wavelength itself.
const fn squared(micrometers: f32) -> f32 {
    micrometers * micrometers
}

const SCHOTT: &str = "SCHOTT optical glass data sheets, 2017-01-20";
const POLYMERS: &str = "N. Sultanova, S. Kasarova and I. Nikolov, Acta Phys. Pol. A 116, 585 (2009)";

/// Every named dielectric. (The numbers are as compiled in the public-domain refractiveindex.info database.)
#[rustfmt::skip]
#[allow(clippy::excessive_precision, reason = "the coefficients stand as published")]
pub const GLASSES: &[Glass] = &[
    Glass {
        names: &["BK7", "N-BK7", "crown glass"],
        source: SCHOTT,
        dispersion: Dispersion::Sellmeier(&[
            (1.039_612_12, 0.006_000_698_67), (0.231_792_344, 0.020_017_914_4), (1.010_469_45, 103.560_653),
        ]),
    },
    Glass {
        names: &["K5", "N-K5"],
        source: SCHOTT,
        dispersion: Dispersion::Sellmeier(&[
            (1.085_118_33, 0.006_610_995_03), (0.199_562_005, 0.024_110_866), (0.930_511_663, 111.982_777),
        ]),
    },
    Glass {
        names: &["F2", "flint glass"],
        source: SCHOTT,
        dispersion: Dispersion::Sellmeier(&[
            (1.345_333_59, 0.009_977_438_71), (0.209_073_176, 0.047_045_076_7), (0.937_357_162, 111.886_764),
        ]),
    },
    Glass {
        names: &["SF10"],
        source: SCHOTT,
        dispersion: Dispersion::Sellmeier(&[
            (1.616_259_77, 0.012_753_455_9), (0.259_229_334, 0.058_198_395_4), (1.077_623_17, 116.607_68),
        ]),
    },
    Glass {
        names: &["SF11", "dense flint"],
        source: SCHOTT,
        dispersion: Dispersion::Sellmeier(&[
            (1.738_484_03, 0.013_606_860_4), (0.311_168_974, 0.061_596_046_3), (1.174_908_71, 121.922_711),
        ]),
    },
    Glass {
        names: &["LaSF9", "N-LASF9"],
        source: SCHOTT,
        dispersion: Dispersion::Sellmeier(&[
            (2.000_295_47, 0.012_142_601_7), (0.298_926_886, 0.053_873_623_6), (1.806_918_43, 156.530_829),
        ]),
    },
    Glass {
        names: &["fused silica", "silica", "SiO2"],
        source: "I. H. Malitson, J. Opt. Soc. Am. 55, 1205 (1965)",
        dispersion: Dispersion::Sellmeier(&[
            (0.696_166_3, squared(0.068_404_3)), (0.407_942_6, squared(0.116_241_4)), (0.897_479_4, squared(9.896_161)),
        ]),
    },
    Glass {
        names: &["fluorite", "CaF2"],
        source: "I. H. Malitson, Appl. Opt. 2, 1103 (1963)",
        dispersion: Dispersion::Sellmeier(&[
            (0.567_588_8, squared(0.050_263_605)), (0.471_091_4, squared(0.100_390_9)),
            (3.848_472_3, squared(34.649_04)),
        ]),
    },
    Glass {
        names: &["sapphire", "Al2O3", "corundum"],
        source: "I. H. Malitson and M. J. Dodge, J. Opt. Soc. Am. 62, 1405 (1972): the ordinary ray",
        dispersion: Dispersion::Sellmeier(&[
            (1.431_349_3, squared(0.072_663_1)), (0.650_547_13, squared(0.119_324_2)),
            (5.341_402_1, squared(18.028_251)),
        ]),
    },
    Glass {
        names: &["diamond"],
        source: "F. Peter, Z. Phys. 15, 358 (1923)",
        dispersion: Dispersion::Sellmeier(&[(0.330_6, squared(0.175)), (4.335_6, squared(0.106))]),
    },
    Glass {
        names: &["water", "H2O"],
        source: "M. Daimon and A. Masumura, Appl. Opt. 46, 3811 (2007): distilled, at 20 °C",
        dispersion: Dispersion::Sellmeier(&[
            (0.568_402_756_5, 0.005_101_829_712), (0.172_617_739_1, 0.018_211_539_36),
            (0.020_861_895_78, 0.026_207_222_93), (0.113_074_868_8, 10.697_927_21),
        ]),
    },
    Glass {
        names: &["ice"],
        source: "S. G. Warren and R. E. Brandt, J. Geophys. Res. 113, D14220 (2008): at -7 °C",
        dispersion: Dispersion::Table(
            &[
                350.0, 390.0, 400.0, 420.0, 440.0, 460.0, 480.0, 500.0, 520.0, 540.0, 560.0, 580.0, 600.0, 640.0, 680.0,
                720.0, 760.0, 800.0,
            ],
            &[
                1.3249, 1.3203, 1.3194, 1.3177, 1.3163, 1.3151, 1.314, 1.313, 1.3121, 1.3114, 1.3106, 1.31, 1.3094,
                1.3083, 1.3073, 1.3065, 1.3057, 1.3049,
            ],
        ),
    },
    Glass {
        names: &["acrylic", "PMMA", "plexiglass"],
        source: POLYMERS,
        dispersion: Dispersion::Sellmeier(&[(1.181_9, 0.011_313)]),
    },
    Glass {
        names: &["polycarbonate", "PC"],
        source: POLYMERS,
        dispersion: Dispersion::Sellmeier(&[(1.418_2, 0.021_304)]),
    },
];

#[cfg(test)]
mod tests {
    use super::*;

    /// The catalogs' `n_d` and `V_d`; for the others handbook values at the sodium or helium d line. (The sources of
    /// ice and of the plastics fix no Abbe number: few digits there, a fit of one term here.)
    #[test]
    fn indices_are_the_catalogs() {
        let catalog = [
            ("BK7", 1.5168, Some(64.17)),
            ("K5", 1.52249, Some(59.48)),
            ("F2", 1.62004, Some(36.37)),
            ("SF10", 1.72825, Some(28.41)),
            ("SF11", 1.78472, Some(25.76)),
            ("LaSF9", 1.85025, Some(32.17)),
            ("fused silica", 1.45846, Some(67.82)),
            ("fluorite", 1.43385, Some(95.0)),
            ("sapphire", 1.76823, Some(72.2)),
            ("diamond", 2.4175, Some(55.3)),
            ("water", 1.33336, Some(55.74)),
            ("ice", 1.3098, None),
            ("acrylic", 1.4906, None),
            ("polycarbonate", 1.5848, None),
        ];
        for (name, ior, abbe) in catalog {
            let glass = glass(name).expect("a named glass");
            assert!((glass.ior() - ior).abs() < 1e-4, "{name}: {}", glass.ior());
            if let Some(abbe) = abbe {
                assert!((glass.abbe_number() / abbe - 1.0).abs() < 0.005, "{name}: {}", glass.abbe_number());
            }
        }
        assert_eq!(catalog.len(), GLASSES.len());
    }

    #[test]
    fn blue_is_bent_more_than_red() {
        for glass in GLASSES {
            let iors: Vec<f32> = (380..=780).step_by(20).map(|wavelength| glass.ior_at(wavelength as f32)).collect();
            assert!(iors.is_sorted_by(|a, b| a > b), "{:?}: {iors:?}", glass.names);
            assert!(iors.iter().all(|ior| (1.3..2.5).contains(ior)), "{:?}: {iors:?}", glass.names);
        }
    }

    #[test]
    fn names_are_found_in_any_case() {
        assert_eq!(glass("bk7"), glass("N-BK7"));
        assert_eq!(glass("Fused Silica").map(|glass| glass.names[0]), Some("fused silica"));
        assert_eq!(glass("BK-7"), None);
        let mut names: Vec<_> = glass_names().map(str::to_lowercase).collect();
        assert!(names.iter().all(|name| glass(name).is_some()));
        let count = names.len();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), count, "a name stands for one glass");
    }
}
