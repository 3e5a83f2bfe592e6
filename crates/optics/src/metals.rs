//! Measured metals: complex indices of refraction over the visible spectrum, and per channel.
//!
//! Each table holds published samples `n + ik` of clean metal at room temperature; [`METALS`] is the list. What the
//! tracer uses is one complex index for each Rec.709 channel: `eta` and `k` are each averaged over the channel's
//! matching function under D65, as RGB renderers do, with [`spectrum::rec709_average`]. A flat spectrum keeps its
//! value, and the color at normal incidence stays within 0.02 of the one computed wavelength by wavelength. The exception
//! is gold, whose red, 1.04, lies beyond Rec.709 and beyond what any passive surface can have in one channel: it gets 0.98.

use glam::Vec3;

use crate::{fresnel, spectrum};

/// A metal by its complex index of refraction `eta + i k` for each Rec.709 channel, relative to vacuum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Metal {
    /// The real part, the refractive index.
    pub eta: Vec3,
    /// The imaginary part, the extinction coefficient.
    pub k: Vec3,
}

/// The published samples of a metal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MetalTable {
    /// The chemical symbol, or the name of an alloy, then the English names.
    pub names: &'static [&'static str],
    /// Where the numbers were published.
    pub source: &'static str,
    /// In nanometers, growing, over the visible range.
    pub wavelengths: &'static [f32],
    /// The real part of the index at each wavelength.
    pub eta: &'static [f32],
    /// The imaginary part of the index at each wavelength.
    pub k: &'static [f32],
}

/// The metal of that name: a symbol such as `Au` or a word such as `gold`, in any case.
pub fn metal(name: &str) -> Option<Metal> {
    METALS.iter().find(|table| table.names.iter().any(|known| known.eq_ignore_ascii_case(name))).map(MetalTable::metal)
}

/// Every name that [`metal`] knows.
pub fn metal_names() -> impl Iterator<Item = &'static str> {
    METALS.iter().flat_map(|table| table.names.iter().copied())
}

impl Metal {
    /// The color reflected at normal incidence in vacuum.
    pub fn f0(&self) -> Vec3 {
        let channel = |i| fresnel::f0_conductor(1.0, self.eta[i], self.k[i]);
        Vec3::new(channel(0), channel(1), channel(2))
    }
}

impl MetalTable {
    /// `(eta, k)` at a wavelength in nanometers, by straight lines between the samples.
    pub fn index_at(&self, wavelength: f32) -> (f32, f32) {
        let at = |values| spectrum::interpolate(self.wavelengths, values, wavelength);
        (at(self.eta), at(self.k))
    }

    /// The index for each channel. Costs an integral over the spectrum: look a metal up once, not for every ray.
    pub fn metal(&self) -> Metal {
        Metal {
            eta: spectrum::rec709_average(|wavelength| self.index_at(wavelength).0),
            k: spectrum::rec709_average(|wavelength| self.index_at(wavelength).1),
        }
    }
}

const NOBLE: &str = "P. B. Johnson and R. W. Christy, Phys. Rev. B 6, 4370 (1972)";
const TRANSITION: &str = "P. B. Johnson and R. W. Christy, Phys. Rev. B 9, 5056 (1974)";
const FITTED: &str = "A. D. Rakić et al., Appl. Opt. 37, 5271 (1998), Brendel-Bormann model of measured data";

/// Johnson and Christy measured at photon energies from 3.25 eV down to 1.64 eV.
#[rustfmt::skip]
const ENERGIES: [f32; 14] = [
    381.5, 397.4, 413.3, 430.5, 450.9, 471.4, 495.9, 520.9, 548.6, 582.1, 616.8, 659.5, 704.5, 756.0,
];

/// The wavelengths taken from the model of Rakić and others.
#[rustfmt::skip]
const MODELED: [f32; 13] = [
    382.14, 413.4, 438.52, 465.15, 493.41, 513.2, 533.78, 555.18, 577.44, 612.52, 649.73, 702.89, 760.39,
];

/// Every measured metal. (The numbers are as compiled in the public-domain refractiveindex.info database.)
#[rustfmt::skip]
#[allow(clippy::approx_constant, reason = "an index of 3.14 is a measured one")]
pub const METALS: &[MetalTable] = &[
    MetalTable {
        names: &["Au", "gold"],
        source: NOBLE,
        wavelengths: &ENERGIES,
        eta: &[1.46, 1.47, 1.46, 1.45, 1.38, 1.31, 1.04, 0.62, 0.43, 0.29, 0.21, 0.14, 0.13, 0.14],
        k: &[1.933, 1.952, 1.958, 1.948, 1.914, 1.849, 1.833, 2.081, 2.455, 2.863, 3.272, 3.697, 4.103, 4.542],
    },
    MetalTable {
        names: &["Ag", "silver"],
        source: NOBLE,
        wavelengths: &ENERGIES,
        eta: &[0.05, 0.05, 0.05, 0.04, 0.04, 0.05, 0.05, 0.05, 0.06, 0.05, 0.06, 0.05, 0.04, 0.03],
        k: &[1.864, 2.07, 2.275, 2.462, 2.657, 2.869, 3.093, 3.324, 3.586, 3.858, 4.152, 4.483, 4.838, 5.242],
    },
    MetalTable {
        names: &["Cu", "copper"],
        source: NOBLE,
        wavelengths: &ENERGIES,
        eta: &[1.33, 1.32, 1.28, 1.25, 1.24, 1.25, 1.22, 1.18, 1.02, 0.7, 0.3, 0.22, 0.21, 0.24],
        k: &[2.045, 2.116, 2.207, 2.305, 2.397, 2.483, 2.564, 2.608, 2.577, 2.704, 3.205, 3.747, 4.205, 4.665],
    },
    MetalTable {
        names: &["Al", "aluminum", "aluminium"],
        source: "A. D. Rakić, Appl. Opt. 34, 4755 (1995)",
        wavelengths: &[364.66, 413.28, 442.8, 476.87, 516.6, 563.57, 619.93, 652.25, 688.81, 729.32, 774.91, 794.78],
        eta: &[0.39877, 0.52135, 0.6079, 0.7278, 0.8734, 1.0728, 1.366, 1.5724, 1.8301, 2.1606, 2.6154, 2.7675],
        k: &[4.3957, 5.0008, 5.3676, 5.7781, 6.2418, 6.7839, 7.4052, 7.7354, 8.0601, 8.3565, 8.4914, 8.3866],
    },
    MetalTable {
        names: &["Cr", "chromium", "chrome"],
        source: TRANSITION,
        wavelengths: &ENERGIES,
        eta: &[1.92, 2.0, 2.08, 2.19, 2.33, 2.51, 2.75, 2.94, 3.18, 3.22, 3.17, 3.09, 3.05, 3.08],
        k: &[2.74, 2.83, 2.93, 3.04, 3.14, 3.24, 3.3, 3.33, 3.33, 3.3, 3.3, 3.34, 3.39, 3.42],
    },
    MetalTable {
        names: &["Fe", "iron"],
        source: TRANSITION,
        wavelengths: &ENERGIES,
        eta: &[2.12, 2.24, 2.35, 2.48, 2.59, 2.67, 2.74, 2.86, 2.95, 2.94, 2.88, 2.92, 2.86, 2.87],
        k: &[2.5, 2.58, 2.65, 2.71, 2.77, 2.82, 2.88, 2.91, 2.93, 2.99, 3.05, 3.1, 3.19, 3.28],
    },
    MetalTable {
        names: &["Ni", "nickel"],
        source: TRANSITION,
        wavelengths: &ENERGIES,
        eta: &[1.72, 1.72, 1.7, 1.71, 1.73, 1.78, 1.82, 1.85, 1.92, 1.96, 1.99, 1.99, 2.06, 2.13],
        k: &[2.48, 2.57, 2.69, 2.82, 2.95, 3.09, 3.25, 3.42, 3.61, 3.8, 4.02, 4.26, 4.5, 4.73],
    },
    MetalTable {
        names: &["Ti", "titanium"],
        source: TRANSITION,
        wavelengths: &ENERGIES,
        eta: &[1.99, 2.08, 2.14, 2.21, 2.27, 2.32, 2.36, 2.44, 2.54, 2.6, 2.67, 2.76, 2.86, 3.0],
        k: &[2.93, 2.95, 2.98, 3.01, 3.04, 3.1, 3.19, 3.3, 3.43, 3.58, 3.72, 3.84, 3.96, 4.01],
    },
    MetalTable {
        names: &["Pd", "palladium"],
        source: TRANSITION,
        wavelengths: &ENERGIES,
        eta: &[1.26, 1.3, 1.33, 1.37, 1.41, 1.46, 1.52, 1.57, 1.64, 1.68, 1.75, 1.8, 1.86, 1.95],
        k: &[2.83, 2.93, 3.03, 3.14, 3.26, 3.39, 3.54, 3.68, 3.84, 4.02, 4.21, 4.42, 4.65, 4.89],
    },
    MetalTable {
        names: &["Co", "cobalt"],
        source: TRANSITION,
        wavelengths: &ENERGIES,
        eta: &[1.53, 1.57, 1.61, 1.67, 1.74, 1.81, 1.88, 1.97, 2.05, 2.13, 2.19, 2.25, 2.31, 2.4],
        k: &[2.82, 2.93, 3.05, 3.17, 3.28, 3.41, 3.55, 3.68, 3.82, 3.96, 4.11, 4.27, 4.45, 4.64],
    },
    MetalTable {
        names: &["Pt", "platinum"],
        source: FITTED,
        wavelengths: &MODELED,
        eta: &[
            1.6838, 1.7611, 1.8193, 1.8796, 1.9445, 1.9916, 2.0427, 2.0984, 2.1592, 2.2607, 2.3748, 2.5449, 2.7317,
        ],
        k: &[2.7414, 2.9253, 3.0702, 3.224, 3.3878, 3.5027, 3.6219, 3.7451, 3.8715, 4.0661, 4.2641, 4.5297, 4.7932],
    },
    MetalTable {
        names: &["W", "tungsten"],
        source: FITTED,
        wavelengths: &MODELED,
        eta: &[3.2153, 3.26, 3.2955, 3.3377, 3.3897, 3.4297, 3.4728, 3.517, 3.5599, 3.6154, 3.6517, 3.6563, 3.5989],
        k: &[2.5259, 2.5517, 2.5864, 2.6311, 2.6804, 2.7121, 2.7405, 2.7637, 2.7806, 2.794, 2.7955, 2.7904, 2.7977],
    },
    MetalTable {
        names: &["CuZn", "brass"],
        source: "M. R. Querry, Contractor Report CRDC-CR-85034 (1985): 70 % copper, 30 % zinc",
        wavelengths: &[
            380.0, 400.0, 420.0, 440.0, 460.0, 480.0, 500.0, 520.0, 540.0, 560.0, 580.0, 600.0, 640.0, 680.0, 720.0,
            760.0,
        ],
        eta: &[
            1.487, 1.445, 1.35, 1.191, 0.994, 0.816, 0.686, 0.602, 0.549, 0.505, 0.468, 0.45, 0.444, 0.444, 0.45, 0.458,
        ],
        k: &[
            1.818, 1.805, 1.786, 1.797, 1.883, 2.046, 2.25, 2.464, 2.668, 2.86, 3.059, 3.253, 3.609, 3.943, 4.266,
            4.579,
        ],
    },
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fresnel::{conductor, f0_conductor};

    fn table(symbol: &str) -> &'static MetalTable {
        METALS.iter().find(|table| table.names[0] == symbol).expect("a listed metal")
    }

    #[test]
    fn names_are_found_in_any_case() {
        for name in ["Au", "au", "GOLD", "gold"] {
            assert_eq!(metal(name), metal("Au"), "{name}");
        }
        assert_eq!(metal("aluminium"), metal("Al"));
        for name in ["", "Aux", "unobtainium", "gold "] {
            assert_eq!(metal(name), None, "{name}");
        }
        let mut names: Vec<_> = metal_names().map(str::to_lowercase).collect();
        assert!(names.iter().all(|name| metal(name).is_some()));
        let count = names.len();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), count, "a name stands for one metal");
    }

    #[test]
    fn tables_are_whole() {
        for table in METALS {
            let rows = table.wavelengths.len();
            assert!(table.eta.len() == rows && table.k.len() == rows, "{:?}", table.names);
            assert!(table.wavelengths.is_sorted_by(|a, b| a < b), "{:?}", table.names);
            assert!(table.wavelengths[0] < 383.0 && table.wavelengths[rows - 1] > 755.0, "{:?}", table.names);
            assert!(table.eta.iter().chain(table.k).all(|x| (0.02..10.0).contains(x)), "{:?}", table.names);
        }
    }

    /// Read from the papers' tables, between neighboring photon energies, and the reflectances worked out by hand.
    #[test]
    fn johnson_and_christys_gold() {
        let gold = table("Au");
        for (wavelength, eta, k, f0) in
            [(450.0, 1.383, 1.915, 0.4082), (550.0, 0.424, 2.472, 0.7916), (650.0, 0.156, 3.602, 0.9565)]
        {
            let index = gold.index_at(wavelength);
            assert!((index.0 - eta).abs() < 2e-3 && (index.1 - k).abs() < 2e-3, "{wavelength}: {index:?}");
            assert!(
                (f0_conductor(1.0, index.0, index.1) - f0).abs() < 1e-3,
                "{wavelength}: {}",
                f0_conductor(1.0, index.0, index.1)
            );
        }
    }

    /// Linear colors at normal incidence as S. Lagarde published them from measured spectra (*Feeding a physically
    /// based shading model*, 2011), for the metals where both go back to agreeing measurements.
    #[test]
    fn colors_are_the_published_ones() {
        let published = [
            ("Au", [1.0, 0.766, 0.336]),
            ("Al", [0.913, 0.921, 0.925]),
            ("Cu", [0.955, 0.637, 0.538]),
            ("Cr", [0.550, 0.556, 0.554]),
            ("Ni", [0.660, 0.609, 0.526]),
            ("Co", [0.662, 0.655, 0.634]),
            ("Pt", [0.673, 0.637, 0.585]),
        ];
        for (symbol, color) in published {
            let f0 = metal(symbol).expect("a listed metal").f0();
            assert!(f0.abs_diff_eq(Vec3::from_array(color), 0.045), "{symbol}: {f0}, published {color:?}");
        }
    }

    /// Wavelength by wavelength, at normal incidence and at 80°, each channel's reflectance is what the tracer gets
    /// from the channel's index.
    #[test]
    fn channels_reflect_what_spectra_do() {
        for table in METALS {
            let metal = table.metal();
            assert!(metal.eta.min_element() > 0.02 && metal.k.min_element() > 1.0, "{:?}: {metal:?}", table.names);
            for cos_i in [1.0, 0.173_648_2] {
                let spectral = spectrum::rec709_average(|wavelength| {
                    let (eta, k) = table.index_at(wavelength);
                    conductor(cos_i, 1.0, eta, k).unpolarized()
                });
                let color = fresnel::conductor_color(cos_i, 1.0, metal.eta, metal.k);
                let tolerance = if table.names[0] == "Au" { 0.06 } else { 0.02 };
                assert!(color.abs_diff_eq(spectral, tolerance), "{:?} {cos_i}: {color}, {spectral}", table.names);
            }
        }
    }
}
