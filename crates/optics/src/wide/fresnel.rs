//! [`fresnel`] over columns.

use brewster_lanes::dispatch;

use crate::fresnel::{self, FresnelModel};

dispatch! {
    /// [`FresnelModel::dielectric`] for each row; total internal reflection has the reflectance 1 and the `cos_t` 0.
    pub fn dielectric(
        model: FresnelModel,
        cos_i: &[f32],
        eta_i: &[f32],
        eta_t: &[f32],
        reflectance: &mut [f32],
        cos_t: &mut [f32],
    ) {
        // One loop for each model, as the choice inside the loop would keep it from vectorizing.
        match model {
            FresnelModel::Exact => split_rows(FresnelModel::Exact, cos_i, [eta_i, eta_t], reflectance, cos_t),
            FresnelModel::Schlick => split_rows(FresnelModel::Schlick, cos_i, [eta_i, eta_t], reflectance, cos_t),
            FresnelModel::SchlickThetaM => {
                split_rows(FresnelModel::SchlickThetaM, cos_i, [eta_i, eta_t], reflectance, cos_t);
            }
        }
    }

    /// The unpolarized [`fresnel::conductor`] for each row of one color channel.
    pub fn conductor(cos_i: &[f32], eta_i: &[f32], eta: &[f32], k: &[f32], reflectance: &mut [f32]) {
        let rows = reflectance.len();
        let (cos_i, eta_i, eta, k) = (&cos_i[..rows], &eta_i[..rows], &eta[..rows], &k[..rows]);
        for row in 0..rows {
            reflectance[row] = fresnel::conductor(cos_i[row], eta_i[row], eta[row], k[row]).unpolarized();
        }
    }

    /// [`fresnel::schlick`] for each row of one color channel.
    pub fn schlick(cos: &[f32], r0: &[f32], reflectance: &mut [f32]) {
        let rows = reflectance.len();
        let (cos, r0) = (&cos[..rows], &r0[..rows]);
        for row in 0..rows {
            reflectance[row] = fresnel::schlick(cos[row], r0[row]);
        }
    }
}

#[inline(always)]
fn split_rows(model: FresnelModel, cos_i: &[f32], etas: [&[f32]; 2], reflectance: &mut [f32], cos_t: &mut [f32]) {
    let rows = reflectance.len();
    let (cos_i, [eta_i, eta_t], cos_t) = (&cos_i[..rows], etas.map(|column| &column[..rows]), &mut cos_t[..rows]);
    for row in 0..rows {
        let split = model.dielectric(cos_i[row], eta_i[row], eta_t[row]);
        (reflectance[row], cos_t[row]) = (split.reflectance, split.cos_t);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::strategies::grid;
    use brewster_lanes::Level;

    /// Indices from vacuum to the largest, equal ones, and a metal's.
    const INDICES: [f32; 8] = [1.0, 1.000_3, 1.333, 1.5, 2.42, 4.0, 44.0, 0.05];

    fn same(result: &[f32], expected: &[f32], what: &str) {
        for (row, (result, expected)) in result.iter().zip(expected).enumerate() {
            assert_eq!(result.to_bits(), expected.to_bits(), "{what}, row {row}: {result} {expected}");
        }
    }

    #[test]
    fn dielectrics_are_the_scalar_ones_to_the_bit() {
        let [cos_i, eta_i, eta_t] = grid(1001, &INDICES);
        for model in FresnelModel::ALL {
            let scalar = |row: usize| model.dielectric(cos_i[row], eta_i[row], eta_t[row]);
            let expected: Vec<_> = (0..cos_i.len()).map(scalar).collect();
            for level in Level::available() {
                let mut reflectance = vec![f32::NAN; cos_i.len()];
                let mut cos_t = reflectance.clone();
                dielectric(level, model, &cos_i, &eta_i, &eta_t, &mut reflectance, &mut cos_t);
                let what = format!("{model:?} at {level:?}");
                same(&reflectance, &expected.iter().map(|split| split.reflectance).collect::<Vec<_>>(), &what);
                same(&cos_t, &expected.iter().map(|split| split.cos_t).collect::<Vec<_>>(), &what);
            }
        }
    }

    #[test]
    fn conductors_are_the_scalar_ones_to_the_bit() {
        let [cos_i, eta, k] = grid(1001, &INDICES);
        let eta_i = vec![1.333; cos_i.len()];
        let scalar = |row: usize| fresnel::conductor(cos_i[row], eta_i[row], eta[row], k[row]).unpolarized();
        let expected: Vec<_> = (0..cos_i.len()).map(scalar).collect();
        for level in Level::available() {
            let mut reflectance = vec![f32::NAN; cos_i.len()];
            conductor(level, &cos_i, &eta_i, &eta, &k, &mut reflectance);
            same(&reflectance, &expected, level.name());
        }
    }

    #[test]
    fn schlick_is_the_scalar_one_to_the_bit() {
        let [cos, r0, _] = grid(1001, &[0.0, 0.04, 0.5, 0.97, 1.0]);
        let expected: Vec<_> = cos.iter().zip(&r0).map(|(&cos, &r0)| fresnel::schlick(cos, r0)).collect();
        for level in Level::available() {
            let mut reflectance = vec![f32::NAN; cos.len()];
            schlick(level, &cos, &r0, &mut reflectance);
            same(&reflectance, &expected, level.name());
        }
    }

    /// Nothing, one row, and lengths that no vector divides.
    #[test]
    fn every_length_is_done_to_its_end() {
        let [cos_i, eta_i, eta_t] = grid(2, &INDICES);
        for rows in [0, 1, 7, 17, 33] {
            for level in Level::available() {
                let (mut reflectance, mut cos_t) = (vec![f32::NAN; rows], vec![f32::NAN; rows]);
                dielectric(level, FresnelModel::Exact, &cos_i, &eta_i, &eta_t, &mut reflectance, &mut cos_t);
                assert!(reflectance.iter().chain(&cos_t).all(|value| value.is_finite()), "{rows} rows at {level:?}");
            }
        }
    }
}
