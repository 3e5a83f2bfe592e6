//! How the tests judge samplers of directions: Pearson's chi-squared test on the sphere.

use std::f64::consts::TAU;

pub(crate) use brewster_random::Random;
use glam::{DVec3, Vec3};

use crate::LightSample;

/// Cells along each side; in height and turn about y, so that all have the same solid angle.
const CELLS: usize = 24;

/// The direction at a place of the square over height and turn.
pub(crate) fn direction_at(height: f64, turn: f64) -> Vec3 {
    let y = 1.0 - 2.0 * height;
    let radius = (1.0 - y * y).max(0.0).sqrt();
    DVec3::new(radius * (TAU * turn).cos(), y, radius * (TAU * turn).sin()).as_vec3()
}

/// The mean of a function over a part of that square, by many midpoints.
pub(crate) fn mean_over(f: &impl Fn(Vec3) -> f64, [h0, h1, t0, t1]: [f64; 4], steps: usize) -> f64 {
    let at = |from: f64, to: f64, i: usize| from + (to - from) * (i as f64 + 0.5) / steps as f64;
    let sum = (0..steps * steps).map(|i| f(direction_at(at(h0, h1, i / steps), at(t0, t1, i % steps)))).sum::<f64>();
    sum / (steps * steps) as f64
}

/// Compares samples with the density that they claim, and asks that it integrates to 1 less what `None` loses.
#[track_caller]
pub(crate) fn check_sphere(name: &str, sample: impl Fn([f32; 2]) -> Option<LightSample>, pdf: impl Fn(Vec3) -> f32) {
    let samples = 100_000;
    let mut random = Random::new(name.len() as u64);
    let mut counts = vec![0.0; CELLS * CELLS + 1];
    for _ in 0..samples {
        let cell = match sample(random.square().into()) {
            Some(LightSample { direction, pdf: claimed, .. }) => {
                assert!((direction.as_dvec3().length() - 1.0).abs() < 1e-6, "{name}: {direction}");
                let density = pdf(direction);
                assert!((density / claimed - 1.0).abs() < 0.02, "{name} {direction}: {density}, {claimed} claimed");
                let turn = f64::from(direction.z).atan2(f64::from(direction.x)) / TAU;
                let index = |x: f64| ((x * CELLS as f64) as usize).min(CELLS - 1);
                index(0.5 - 0.5 * f64::from(direction.y)) * CELLS + index(turn.rem_euclid(1.0))
            }
            None => CELLS * CELLS,
        };
        counts[cell] += 1.0;
    }
    let edge = |i: usize| i as f64 / CELLS as f64;
    let expected: Vec<f64> = (0..CELLS * CELLS)
        .map(|i| {
            let (row, column) = (i / CELLS, i % CELLS);
            let cell = [edge(row), edge(row + 1), edge(column), edge(column + 1)];
            2.0 * TAU * mean_over(&|direction| f64::from(pdf(direction)), cell, 24) / (CELLS * CELLS) as f64
        })
        .collect();
    let total: f64 = expected.iter().sum();
    let lost = counts.pop().expect("the last cell") / f64::from(samples);
    assert!((total + lost - 1.0).abs() < 2e-3, "{name}: the density integrates to {total}, {lost} are lost");
    chi_squared(name, &counts, &expected.iter().map(|p| p * f64::from(samples)).collect::<Vec<_>>());
}

/// Fails where counts differ from the expected ones by more than chance does once in ten thousand times. Cells that expect
/// fewer than five are pooled.
#[track_caller]
pub(crate) fn chi_squared(name: &str, counts: &[f64], expected: &[f64]) {
    let (mut statistic, mut used, mut pool) = (0.0, 0, (0.0, 0.0));
    for (&count, &expected) in counts.iter().zip(expected) {
        if expected < 5.0 {
            pool = (pool.0 + count, pool.1 + expected);
        } else {
            statistic += (count - expected).powi(2) / expected;
            used += 1;
        }
    }
    assert!(used >= 4, "{name}: only {used} cells are populated");
    assert!((pool.0 - pool.1).abs() < 6.0 * pool.1.sqrt() + 12.0, "{name}: {pool:?} in thin cells");
    // Wilson and Hilferty 1931: the cube root is nearly normal; 3.72 standard deviations.
    let degrees = f64::from(used - 1);
    let spread = 2.0 / (9.0 * degrees);
    let deviation = ((statistic / degrees).cbrt() - (1.0 - spread)) / spread.sqrt();
    assert!(deviation < 3.72, "{name}: chi squared {statistic} with {degrees} degrees of freedom");
}
