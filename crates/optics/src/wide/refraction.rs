//! [`refraction`] over columns: directions are three columns, x, y and z.

use brewster_lanes::dispatch;
use glam::Vec3;

use crate::refraction;

dispatch! {
    /// [`refraction::mirror`] for each row: normals are on the ray's side.
    pub fn mirror(direction: [&[f32]; 3], normal: [&[f32]; 3], mirrored: [&mut [f32]; 3]) {
        let rows = mirrored[0].len();
        let (direction, normal) = (direction.map(|column| &column[..rows]), normal.map(|column| &column[..rows]));
        let [x, y, z] = mirrored.map(|column| &mut column[..rows]);
        for row in 0..rows {
            let result = refraction::mirror(vector(direction, row), vector(normal, row));
            (x[row], y[row], z[row]) = (result.x, result.y, result.z);
        }
    }

    /// [`refraction::refract_with_cosine`] for each row; `ratio` is `eta_i / eta_t`.
    ///
    /// No row may be in total internal reflection: it has no refracted direction, which the assertion catches.
    pub fn refract_with_cosine(
        direction: [&[f32]; 3],
        normal: [&[f32]; 3],
        cos_t: &[f32],
        ratio: &[f32],
        refracted: [&mut [f32]; 3],
    ) {
        let rows = refracted[0].len();
        let (direction, normal) = (direction.map(|column| &column[..rows]), normal.map(|column| &column[..rows]));
        let (cos_t, ratio) = (&cos_t[..rows], &ratio[..rows]);
        let [x, y, z] = refracted.map(|column| &mut column[..rows]);
        for row in 0..rows {
            let (direction, normal) = (vector(direction, row), vector(normal, row));
            let result = refraction::refract_with_cosine(direction, normal, cos_t[row], ratio[row]);
            (x[row], y[row], z[row]) = (result.x, result.y, result.z);
        }
    }
}

#[inline(always)]
fn vector(columns: [&[f32]; 3], row: usize) -> Vec3 {
    Vec3::new(columns[0][row], columns[1][row], columns[2][row])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::refraction::{cos_t, flip_towards_viewer};
    use crate::strategies::grid;
    use brewster_lanes::Level;

    /// Unit vectors all over the sphere, in columns, and as many normals on their sides.
    fn incidences() -> (Vec<Vec3>, Vec<Vec3>) {
        let heights: Vec<f32> = (0..13).map(|step| step as f32 / 6.0 - 1.0).collect();
        let [turn, z_direction, z_normal] = grid(29, &heights);
        let unit = |turn: f32, z: f32| {
            let (sin, cos) = (core::f32::consts::TAU * turn).sin_cos();
            Vec3::new(cos, sin, 0.0) * (1.0 - z * z).max(0.0).sqrt() + Vec3::Z * z
        };
        let directions: Vec<_> = turn.iter().zip(&z_direction).map(|(&turn, &z)| unit(turn, z)).collect();
        let normals = z_normal.iter().zip(&directions).map(|(&z, &v)| flip_towards_viewer(unit(0.3, z), v)).collect();
        (directions, normals)
    }

    fn columns(vectors: &[Vec3]) -> [Vec<f32>; 3] {
        [0, 1, 2].map(|axis| vectors.iter().map(|vector| vector[axis]).collect())
    }

    fn views(columns: &[Vec<f32>; 3]) -> [&[f32]; 3] {
        columns.each_ref().map(Vec::as_slice)
    }

    fn bits(vectors: &[Vec<f32>; 3]) -> [Vec<u32>; 3] {
        vectors.each_ref().map(|column| column.iter().map(|value| value.to_bits()).collect())
    }

    #[test]
    fn mirrors_are_the_scalar_ones_to_the_bit() {
        let (directions, normals) = incidences();
        let expected: Vec<_> = directions.iter().zip(&normals).map(|(&v, &n)| refraction::mirror(v, n)).collect();
        for level in Level::available() {
            let mut result = [0, 1, 2].map(|_| vec![f32::NAN; directions.len()]);
            let out = result.each_mut().map(Vec::as_mut_slice);
            mirror(level, views(&columns(&directions)), views(&columns(&normals)), out);
            assert_eq!(bits(&result), bits(&columns(&expected)), "{level:?}");
        }
    }

    #[test]
    fn refractions_are_the_scalar_ones_to_the_bit() {
        let (directions, normals) = incidences();
        for (eta_i, eta_t) in [(1.0, 1.5), (1.0, 1.0), (1.333, 2.42), (1.0, 44.0)] {
            let cosine = |row: usize| cos_t(-normals[row].dot(directions[row]), eta_i, eta_t).expect("not total");
            let cosines: Vec<_> = (0..directions.len()).map(cosine).collect();
            let ratio = vec![eta_i / eta_t; cosines.len()];
            let scalar = |row| refraction::refract(directions[row], normals[row], eta_i, eta_t).expect("not total");
            let expected: Vec<_> = (0..directions.len()).map(scalar).collect();
            for level in Level::available() {
                let mut result = [0, 1, 2].map(|_| vec![f32::NAN; directions.len()]);
                let out = result.each_mut().map(Vec::as_mut_slice);
                let (directions, normals) = (columns(&directions), columns(&normals));
                refract_with_cosine(level, views(&directions), views(&normals), &cosines, &ratio, out);
                assert_eq!(bits(&result), bits(&columns(&expected)), "{eta_i} {eta_t} at {level:?}");
            }
        }
    }
}
