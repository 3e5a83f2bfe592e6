//! What the tests draw from: the whole domain, with its ends and its bad neighborhoods.

use core::f64::consts::TAU;

use glam::Vec3;
use proptest::prelude::*;

use crate::refraction::flip_towards_viewer;

/// Real numbers from `low` to `high`. (proptest's own ranges of floats now and then fail an assertion of their own.)
pub(crate) fn real(low: f32, high: f32) -> impl Strategy<Value = f32> {
    (0u32..=1 << 24).prop_map(move |step| low + (high - low) * (step as f32 / (1 << 24) as f32))
}

/// Cosines of incidence, both ends and their neighborhoods included.
pub(crate) fn cosine() -> impl Strategy<Value = f32> {
    prop_oneof![4 => real(0.0, 1.0), 1 => real(0.0, 1e-3), 1 => real(0.999, 1.0), 1 => Just(0.0), 1 => Just(1.0)]
}

/// Pairs of indices: every kind of boundary, from none to the largest.
pub(crate) fn indices() -> impl Strategy<Value = (f32, f32)> {
    let index = || prop_oneof![4 => real(1.0, 1.01), 4 => real(1.0, 3.0), 4 => real(1.0, 44.0), 1 => Just(1.0)];
    (index(), index())
}

/// The same, the thinner side first: from there nothing is totally reflected.
pub(crate) fn thin_to_dense() -> impl Strategy<Value = (f32, f32)> {
    indices().prop_map(|(a, b)| (a.min(b), a.max(b)))
}

/// Directions spread evenly over the sphere.
pub(crate) fn unit_vector() -> impl Strategy<Value = Vec3> {
    (real(-1.0, 1.0), real(0.0, 1.0)).prop_map(|(z, turn)| {
        let (z, phi) = (z as f64, TAU * turn as f64);
        let rho = (1.0 - z * z).sqrt();
        Vec3::new((rho * phi.cos()) as f32, (rho * phi.sin()) as f32, z as f32)
    })
}

/// A direction and a normal on its side, both spread evenly over the sphere.
pub(crate) fn incidence() -> impl Strategy<Value = (Vec3, Vec3)> {
    (unit_vector(), unit_vector()).prop_map(|(direction, normal)| (direction, flip_towards_viewer(normal, direction)))
}

/// Columns of every combination of `steps` numbers spread over 0..1, ends included, with two of the `values`.
pub(crate) fn grid(steps: usize, values: &[f32]) -> [Vec<f32>; 3] {
    let mut columns = [const { Vec::new() }; 3];
    for step in 0..steps {
        let part = step as f32 / (steps - 1) as f32;
        for &first in values {
            for &second in values {
                for (column, value) in columns.iter_mut().zip([part, first, second]) {
                    column.push(value);
                }
            }
        }
    }
    columns
}
