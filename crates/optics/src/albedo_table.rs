//! Tables of [`albedo`](crate::albedo): how much a rough mirror, a rough dielectric or a sheen sends on, single scattering.
//!
//! They are numbers in a file and the look-up is plain arithmetic, so a picture may depend on them. The axes are chosen
//! for straight lines between few rows: roughness `√alpha`; the angle as `μ (1+alpha)/(μ+alpha)`, since what facets hide
//! depends on μ/alpha; and the index as `√((η-1)/(η+1))`. What a dielectric reflects is kept as a part of the Fresnel
//! value times the whole, and is exact for a smooth one; the part of a mirror's light that Schlick's `(1-cosθ)⁵` leaves,
//! like the sheen, has `√μ` for its axis. A look-up is off by 0.0007 in the mean and 0.003 at most for a mirror (0.006 for its
//! grazing part beyond 89°); for a dielectric by 0.001 and 0.01, and 0.015 where the indices lie within a tenth of each
//! other; for a sheen by 0.01 and a twenty-fifth of it.
//!
//! The file is written by
//! `cargo test -p brewster-optics --lib -- --ignored the_file_is_written_here`: unsigned 16-bit numbers, little
//! end first, 32,000 for 1, the tables in the order of the fields of `Tables`.

use crate::fresnel::FresnelModel;

/// Rows of roughness and columns of angle in the mirror's table.
const MIRROR: usize = 24;

/// Rows of roughness and columns of angle in a dielectric's tables.
const BOUNDARY: usize = 16;

/// Rows of index in a dielectric's tables.
const INDICES: usize = 12;

/// The range of relative indices.
const ETA: (f32, f32) = (1.02, 3.0);

/// What stands for 1: ratios of reflectances reach 2.
const ONE: f32 = 32_000.0;

/// Everything in the file.
struct Tables {
    /// E(alpha, μ) of a perfect mirror.
    mirror: [[u16; MIRROR]; MIRROR],
    /// Its average over even light.
    mirror_average: [u16; MIRROR],
    /// Reflected and transmitted energy of a boundary, (η, alpha, μ), seen from the thinner side.
    outside: [[[u16; BOUNDARY]; BOUNDARY]; INDICES],
    /// The same seen from the denser side.
    inside: [[[u16; BOUNDARY]; BOUNDARY]; INDICES],
    /// From the thinner side, the reflected part of it over the Fresnel reflectance at the angle of incidence.
    share: [[[u16; BOUNDARY]; BOUNDARY]; INDICES],
    /// The average over even light of what is reflected, (η, alpha), from the thinner side.
    reflected_average: [[u16; BOUNDARY]; INDICES],
    /// What is left of a mirror's light, (alpha, √μ), where each facet reflects `(1-cosθ)⁵`.
    grazing: [[u16; MIRROR]; MIRROR],
    /// The average over even light of what that makes.
    grazing_average: [u16; MIRROR],
    /// Half of what the sheen reflects, (alpha, √μ).
    sheen: [[u16; MIRROR]; MIRROR],
}

static TABLES: Tables = Tables::read(include_bytes!("albedo_table.bin"));

/// What a rough perfect mirror of width `alpha` reflects of the light at a cosine, E(μ).
#[inline(always)]
pub fn mirror(cosine: f32, alpha: f32) -> f32 {
    between(rough_row(alpha, MIRROR), |row| at_angle(&TABLES.mirror[row], cosine, alpha))
}

/// The average of [`mirror`] over even light, `2 ∫ E(μ) μ dμ`.
#[inline(always)]
pub fn mirror_average(alpha: f32) -> f32 {
    between(rough_row(alpha, MIRROR), |row| number(TABLES.mirror_average[row]))
}

/// What a rough mirror reflects whose facets reflect `(1-cosθ)⁵`, the grazing part of Schlick's equation.
///
/// With it a surface of Schlick's Fresnel value reflects `f0 (mirror - grazing) + f90 grazing`.
#[inline(always)]
pub fn grazing(cosine: f32, alpha: f32) -> f32 {
    mirror(cosine, alpha) * between(rough_row(alpha, MIRROR), |row| at_root(&TABLES.grazing[row], cosine))
}

/// The average of [`grazing`] over even light.
#[inline(always)]
pub fn grazing_average(alpha: f32) -> f32 {
    between(rough_row(alpha, MIRROR), |row| number(TABLES.grazing_average[row]))
}

/// What a [`sheen`](crate::sheen) of color 1 reflects; more than all light at grazing incidence on fine fibers.
#[inline(always)]
pub fn sheen(cosine: f32, alpha: f32) -> f32 {
    2.0 * between(rough_row(alpha, MIRROR), |row| at_root(&TABLES.sheen[row], cosine))
}

/// What a rough boundary reflects and transmits in all, of the light that comes from the side of `eta_i`.
///
/// Indices nearer to each other than a fiftieth count as a fiftieth apart, and ratios above 3 as 3.
#[inline(always)]
pub fn boundary(cosine: f32, alpha: f32, eta_i: f32, eta_t: f32) -> f32 {
    let (table, eta) = if eta_t >= eta_i { (&TABLES.outside, eta_t / eta_i) } else { (&TABLES.inside, eta_i / eta_t) };
    at_index(table, cosine, alpha, eta)
}

/// The part of it that a boundary to a denser medium, of relative index `eta` in 1..3, reflects.
#[inline(always)]
pub fn reflected(cosine: f32, alpha: f32, eta: f32) -> f32 {
    let smooth = FresnelModel::Exact.dielectric(cosine, 1.0, eta).reflectance;
    let part = at_index(&TABLES.share, cosine, alpha, eta);
    (smooth * at_index(&TABLES.outside, cosine, alpha, eta) * part).min(1.0)
}

/// The average of [`reflected`] over even light; 0 where there is no boundary.
#[inline(always)]
pub fn reflected_average(alpha: f32, eta: f32) -> f32 {
    let table = between(index_row(eta), |plane| {
        between(rough_row(alpha, BOUNDARY), |row| number(TABLES.reflected_average[plane][row]))
    });
    // Below the first row it falls to nothing.
    table * ((eta - 1.0) / (ETA.0 - 1.0)).clamp(0.0, 1.0)
}

/// A place between rows: the lower one, and how far it is to the next.
type Place = (usize, f32);

#[inline(always)]
fn place(part: f32, rows: usize) -> Place {
    let at = part.clamp(0.0, 1.0) * (rows - 1) as f32;
    let row = (at as usize).min(rows - 2);
    (row, at - row as f32)
}

#[inline(always)]
fn rough_row(alpha: f32, rows: usize) -> Place {
    place(alpha.sqrt(), rows)
}

#[inline(always)]
fn index_row(eta: f32) -> Place {
    let axis = |eta: f32| ((eta - 1.0) / (eta + 1.0)).max(0.0).sqrt();
    let (first, last) = (axis(ETA.0), axis(ETA.1));
    place((axis(eta) - first) / (last - first), INDICES)
}

#[inline(always)]
fn between((row, part): Place, value: impl Fn(usize) -> f32) -> f32 {
    let (low, high) = (value(row), value(row + 1));
    low + (high - low) * part
}

#[inline(always)]
fn at_angle<const N: usize>(columns: &[u16; N], cosine: f32, alpha: f32) -> f32 {
    let part = cosine * (1.0 + alpha) / (cosine + alpha).max(f32::MIN_POSITIVE);
    between(place(part, N), |column| number(columns[column]))
}

#[inline(always)]
fn at_root<const N: usize>(columns: &[u16; N], cosine: f32) -> f32 {
    between(place(cosine.max(0.0).sqrt(), N), |column| number(columns[column]))
}

#[inline(always)]
fn at_index(table: &[[[u16; BOUNDARY]; BOUNDARY]; INDICES], cosine: f32, alpha: f32, eta: f32) -> f32 {
    between(index_row(eta), |plane| {
        between(rough_row(alpha, BOUNDARY), |row| at_angle(&table[plane][row], cosine, alpha))
    })
}

#[inline(always)]
fn number(entry: u16) -> f32 {
    entry as f32 * (1.0 / ONE)
}

impl Tables {
    const fn read(file: &[u8; size_of::<Tables>()]) -> Tables {
        let mut at = 0;
        let mirror = rows(file, &mut at);
        let mirror_average = row(file, &mut at);
        let outside = planes(file, &mut at);
        let inside = planes(file, &mut at);
        let share = planes(file, &mut at);
        let reflected_average = rows(file, &mut at);
        let grazing = rows(file, &mut at);
        let grazing_average = row(file, &mut at);
        let sheen = rows(file, &mut at);
        Tables { mirror, mirror_average, outside, inside, share, reflected_average, grazing, grazing_average, sheen }
    }
}

const fn planes<const N: usize, const M: usize, const L: usize>(file: &[u8], at: &mut usize) -> [[[u16; N]; M]; L] {
    let mut table = [[[0; N]; M]; L];
    let mut plane = 0;
    while plane < L {
        table[plane] = rows(file, at);
        plane += 1;
    }
    table
}

const fn rows<const N: usize, const M: usize>(file: &[u8], at: &mut usize) -> [[u16; N]; M] {
    let mut table = [[0; N]; M];
    let mut line = 0;
    while line < M {
        table[line] = row(file, at);
        line += 1;
    }
    table
}

const fn row<const N: usize>(file: &[u8], at: &mut usize) -> [u16; N] {
    let mut numbers = [0; N];
    let mut column = 0;
    while column < N {
        numbers[column] = u16::from_le_bytes([file[*at], file[*at + 1]]);
        *at += 2;
        column += 1;
    }
    numbers
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::albedo::{self, Albedo, at_cosine, average, rough_dielectric, rough_mirror};
    use crate::sheen;
    use core::f64::consts::LN_2;
    use glam::DVec3;

    fn mirror_in_f64(cosine: f64, alpha: f64) -> f64 {
        rough_mirror(at_cosine(cosine), [alpha; 2], |_| DVec3::ONE).x
    }

    fn grazing_in_f64(cosine: f64, alpha: f64) -> f64 {
        rough_mirror(at_cosine(cosine), [alpha; 2], |cos_i| DVec3::splat((1.0 - cos_i).powi(5))).x
    }

    fn boundary_in_f64(cosine: f64, alpha: f64, eta_i: f64, eta_t: f64) -> Albedo {
        rough_dielectric(at_cosine(cosine), [alpha; 2], eta_i, eta_t)
    }

    fn total(albedo: Albedo) -> f64 {
        albedo.reflected + albedo.transmitted
    }

    /// The width, and the cosine, of a place in a table; never quite 0.
    fn axes(row: usize, column: usize, rows: usize) -> (f64, f64) {
        let part = |i: usize| i as f64 / (rows - 1) as f64;
        let alpha = part(row).powi(2).max(1e-4);
        (alpha, (part(column) * alpha / (1.0 + alpha - part(column))).max(1e-3 * alpha))
    }

    /// The cosine of a column where the axis is its root; never quite 0.
    fn root_axis(column: usize) -> f64 {
        (column as f64 / (MIRROR - 1) as f64).powi(2).max(1e-5)
    }

    fn eta(plane: usize) -> f64 {
        let axis = |eta: f32| ((eta as f64 - 1.0) / (eta as f64 + 1.0)).sqrt();
        let part = plane as f64 / (INDICES - 1) as f64;
        let square = (axis(ETA.0) + (axis(ETA.1) - axis(ETA.0)) * part).powi(2);
        (1.0 + square) / (1.0 - square)
    }

    #[test]
    #[ignore = "writes the file of tables anew, in some minutes"]
    fn the_file_is_written_here() {
        let mut file: Vec<u8> = Vec::new();
        let mut push = |value: f64| {
            let entry = (value * ONE as f64).round();
            assert!((0.0..=u16::MAX as f64).contains(&entry), "{value}");
            file.extend((entry as u16).to_le_bytes());
        };
        let mut averages = Vec::new();
        for row in 0..MIRROR {
            let values: [f64; MIRROR] = core::array::from_fn(|column| {
                let (alpha, cosine) = axes(row, column, MIRROR);
                mirror_in_f64(cosine, alpha)
            });
            values.into_iter().for_each(&mut push);
            // The average of the lines between the columns, so that what multiple scattering adds is what is missing.
            let columns = values.map(|value| (value * ONE as f64).round() as u16);
            let alpha = axes(row, 0, MIRROR).0 as f32;
            averages.push(average(|cosine| at_angle(&columns, cosine as f32, alpha) as f64));
        }
        averages.into_iter().for_each(&mut push);

        let cells = || {
            (0..INDICES).flat_map(|plane| {
                let square = (0..BOUNDARY * BOUNDARY).map(|i| axes(i / BOUNDARY, i % BOUNDARY, BOUNDARY));
                square.map(move |(alpha, cosine)| (eta(plane), alpha, cosine))
            })
        };
        let outside: Vec<Albedo> =
            cells().map(|(eta, alpha, cosine)| boundary_in_f64(cosine, alpha, 1.0, eta)).collect();
        outside.iter().for_each(|&albedo| push(total(albedo)));
        cells().for_each(|(eta, alpha, cosine)| push(total(boundary_in_f64(cosine, alpha, eta, 1.0))));
        for (albedo, (eta, _, cosine)) in outside.iter().zip(cells()) {
            let smooth = FresnelModel::Exact.dielectric(cosine as f32, 1.0, eta as f32).reflectance as f64;
            push(albedo.reflected / total(*albedo) / smooth);
        }
        for plane in 0..INDICES {
            for row in 0..BOUNDARY {
                let alpha = axes(row, 0, BOUNDARY).0;
                let reflected = |cosine| boundary_in_f64(cosine, alpha, 1.0, eta(plane)).reflected;
                push(average(reflected));
            }
        }
        let mut averages = Vec::new();
        for row in 0..MIRROR {
            let values: [f64; MIRROR] = core::array::from_fn(|column| {
                let ((alpha, _), cosine) = (axes(row, 0, MIRROR), root_axis(column));
                grazing_in_f64(cosine, alpha) / mirror_in_f64(cosine, alpha)
            });
            values.into_iter().for_each(&mut push);
            let columns = values.map(|value| (value * ONE as f64).round() as u16);
            let alpha = axes(row, 0, MIRROR).0 as f32;
            averages.push(average(|cosine| (at_root(&columns, cosine as f32) * mirror(cosine as f32, alpha)) as f64));
        }
        averages.into_iter().for_each(&mut push);
        for row in 0..MIRROR {
            // The row below the least width is there for the straight line.
            let alpha = axes(row, 0, MIRROR).0.max(0.5 * sheen::MIN_ALPHA as f64);
            (0..MIRROR).for_each(|column| push(0.5 * albedo::sheen(root_axis(column), alpha)));
        }
        assert_eq!(file.len(), size_of::<Tables>());
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/src/albedo_table.bin");
        std::fs::write(path, file).expect("the file can be written");
    }

    const COSINES: [f32; 7] = [0.004, 0.03, 0.1, 0.25, 0.5, 0.8, 1.0];
    const ALPHAS: [f32; 6] = [0.002, 0.02, 0.1, 0.3, 0.6, 1.0];

    /// Between the rows, against the quadrature.
    #[test]
    fn mirrors_are_those_of_the_theory() {
        let (mut worst, mut sum) = (0f64, 0.0);
        for alpha in ALPHAS {
            for cosine in COSINES {
                let off = (mirror(cosine, alpha) as f64 - mirror_in_f64(cosine as f64, alpha as f64)).abs();
                (worst, sum) = (worst.max(off), sum + off);
            }
            let exact = average(|cosine| mirror_in_f64(cosine, alpha as f64));
            let off = (mirror_average(alpha) as f64 - exact).abs();
            assert!(off < 2e-3, "{alpha}: average {} {exact}", mirror_average(alpha));
        }
        let mean = sum / (ALPHAS.len() * COSINES.len()) as f64;
        assert!(worst < 3e-3 && mean < 7e-4, "{worst} {mean}");
    }

    #[test]
    fn grazing_light_and_sheen_are_those_of_the_theory() {
        for alpha in ALPHAS {
            for cosine in COSINES {
                let exact = grazing_in_f64(cosine as f64, alpha as f64);
                let off = (grazing(cosine, alpha) as f64 - exact).abs();
                let limit = if cosine < 0.01 { 6e-3 } else { 3e-3 };
                assert!(off < limit, "{alpha} {cosine}: {} {exact}", grazing(cosine, alpha));
                let alpha = alpha.max(sheen::MIN_ALPHA);
                let exact = albedo::sheen(cosine as f64, alpha as f64);
                let off = (super::sheen(cosine, alpha) as f64 - exact).abs();
                assert!(off < 1e-2 + 0.04 * exact, "sheen {alpha} {cosine}: {} {exact}", super::sheen(cosine, alpha));
            }
            let exact = average(|cosine| grazing_in_f64(cosine, alpha as f64));
            let off = (grazing_average(alpha) as f64 - exact).abs();
            assert!(off < 2e-3, "{alpha}: average {} {exact}", grazing_average(alpha));
        }
        // Smooth: (1-μ)⁵ itself, whose average is 1/21.
        assert!((grazing(0.3, 0.0) - 0.168_07).abs() < 3e-3, "{}", grazing(0.3, 0.0));
        assert!((grazing_average(0.0) - 1.0 / 21.0).abs() < 2e-3, "{}", grazing_average(0.0));
    }

    #[test]
    fn boundaries_are_those_of_the_theory() {
        let mut sum = 0.0;
        for eta in [1.06f32, 1.2, 1.5, 2.4] {
            let limit = if eta < 1.1 { 0.015 } else { 0.01 };
            for alpha in ALPHAS {
                for cosine in COSINES {
                    let exact = |eta_i, eta_t| boundary_in_f64(cosine as f64, alpha as f64, eta_i, eta_t);
                    let (out, into) = (exact(1.0, eta as f64), exact(eta as f64, 1.0));
                    let pairs = [
                        (boundary(cosine, alpha, 1.0, eta), total(out)),
                        (boundary(cosine, alpha, eta, 1.0), total(into)),
                        (reflected(cosine, alpha, eta), out.reflected),
                    ];
                    for (table, exact) in pairs {
                        let off = (table as f64 - exact).abs();
                        assert!(off < limit, "{eta} {alpha} {cosine}: {table} {exact}");
                        sum += off;
                    }
                }
            }
        }
        let mean = sum / (3 * 4 * ALPHAS.len() * COSINES.len()) as f64;
        assert!(mean < 1e-3, "{mean}");
    }

    /// The closed form for a perfect mirror of width 1 from straight above is 1 - ln 2; and 9.18 % is what glass of 1.5
    /// reflects of even light (R. Duntley, 1942).
    #[test]
    fn values_in_closed_form() {
        assert!((mirror(1.0, 1.0) as f64 - (1.0 - LN_2)).abs() < 1e-4, "{}", mirror(1.0, 1.0));
        assert!((reflected_average(0.0, 1.5) - 0.0918).abs() < 5e-4, "{}", reflected_average(0.0, 1.5));
        assert!((mirror(0.7, 0.0) - 1.0).abs() < 2e-4 && (mirror_average(0.0) - 1.0).abs() < 2e-4);
        for (cosine, alpha, eta) in [(0.0, 0.0, 1.0), (1.0, 1.0, 9.0), (0.0, 1.0, 1.0), (1.0, 0.0, 3.0)] {
            for value in [mirror(cosine, alpha), boundary(cosine, alpha, eta, 1.0), reflected(cosine, alpha, eta)] {
                assert!((0.0..=1.001).contains(&value), "{cosine} {alpha} {eta}: {value}");
            }
        }
    }
}
