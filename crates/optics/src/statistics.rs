//! How the tests judge samplers: Pearson's chi-squared test on the sphere, and the integrals it compares with.
//!
//! The sphere is mapped to a square around the lobe's center so that a needle fills as many cells as a broad lobe. The
//! expected count of a cell is the density's integral over it, by an adaptive Gauss-Legendre rule in f64; samples that
//! the lobe lost have a cell of their own. The false-alarm rate of a whole family of tests is 1 %, shared evenly
//! (Bonferroni), and decided before a sample is drawn.

use core::f64::consts::{PI, TAU};

pub(crate) use brewster_random::Random;
use glam::{DVec3, Vec2, Vec3};

/// The false-alarm rate of a family of tests.
const FALSE_ALARMS: f64 = 0.01;

/// Cells per side of the square.
const CELLS: usize = 24;

/// Samples of a test.
const SAMPLES: usize = 200_000;

/// A map of the whole sphere to the unit square that spreads the surroundings of an axis.
///
/// With θ the angle from the axis, `tan(θ/2) = scale u/(1-u)`: half of the square shows the cone of half-angle
/// `2 atan(scale)`, and the long tails of GGX stay smooth functions of `u`.
#[derive(Clone, Copy)]
pub(crate) struct Focus {
    axis: DVec3,
    scale: f64,
}

impl Focus {
    /// The whole sphere evenly, the northern hemisphere in one half of the cells.
    pub(crate) const SPHERE: Focus = Focus { axis: DVec3::Z, scale: 1.0 };

    pub(crate) fn new(axis: Vec3, scale: f32) -> Focus {
        Focus { axis: axis.as_dvec3().normalize(), scale: scale as f64 }
    }

    fn frame(&self) -> (DVec3, DVec3) {
        // The second axis of the square starts in the plane of the axis and z, as lobes are symmetric about it.
        let side = DVec3::Z.cross(self.axis);
        let side = if side.length() > 1e-6 { side.normalize() } else { DVec3::Y };
        (side.cross(self.axis), side)
    }

    fn place_of(self, direction: Vec3) -> (f64, f64) {
        let direction = direction.as_dvec3().normalize();
        let (tangent, side) = self.frame();
        let across = direction - self.axis * self.axis.dot(direction);
        let cosine = self.axis.dot(direction);
        let square = across.length_squared();
        // tan²(θ/2) in whichever form does not cancel.
        let half = if cosine > 0.0 { square / (1.0 + cosine).powi(2) } else { (1.0 - cosine).powi(2) / square };
        let ratio = half.sqrt() / self.scale;
        let turn = direction.dot(side).atan2(direction.dot(tangent)) / TAU;
        (if ratio.is_finite() { ratio / (1.0 + ratio) } else { 1.0 }, turn.rem_euclid(1.0))
    }

    /// The direction of a point, and how much solid angle a unit of the square stands for.
    fn direction_at(self, u: f64, v: f64) -> (DVec3, f64) {
        let (near, far) = (1.0 - u, self.scale * u);
        let total = near * near + far * far;
        let cosine = (near * near - far * far) / total;
        let sine = 2.0 * near * far / total;
        let (tangent, side) = self.frame();
        let (y, x) = (TAU * v).sin_cos();
        (self.axis * cosine + (tangent * x + side * y) * sine, 4.0 * TAU * self.scale * far * near / (total * total))
    }

    /// The integral of a function of direction over a part of the square.
    fn integral(self, f: &impl Fn(Vec3) -> f64, [u0, u1, v0, v1]: [f64; 4]) -> f64 {
        let inner = |u: f64, v: f64| {
            let (direction, solid_angle) = self.direction_at(u, v);
            f(direction.as_vec3()) * solid_angle
        };
        integrate(&inner, [u0, u1, v0, v1], 1e-7)
    }

    /// The integral over the sphere.
    pub(crate) fn total(self, f: impl Fn(Vec3) -> f64) -> f64 {
        cells().map(|cell| self.integral(&f, cell)).sum()
    }
}

fn cells() -> impl Iterator<Item = [f64; 4]> {
    let edge = |i: usize| i as f64 / CELLS as f64;
    (0..CELLS * CELLS).map(move |i| {
        let (row, column) = (i / CELLS, i % CELLS);
        [edge(row), edge(row + 1), edge(column), edge(column + 1)]
    })
}

/// A chi-squared test of a sampler of directions.
pub(crate) struct SphereTest {
    /// Where the lobe is, and how wide.
    pub(crate) focus: Focus,
    /// How many tests share the false-alarm rate.
    pub(crate) family: usize,
}

impl SphereTest {
    /// Compares directions drawn with two numbers for the place and one for a choice with the density that they claim.
    #[track_caller]
    pub(crate) fn check(&self, name: &str, sample: impl Fn(Vec2, f32) -> Option<Vec3>, pdf: impl Fn(Vec3) -> f32) {
        let mut counts = vec![0.0; CELLS * CELLS + 1];
        let mut random = Random::new(name.bytes().fold(1, |seed, byte| (seed * 31 + byte as u64) & 0xffff_ffff));
        for _ in 0..SAMPLES {
            let cell = match sample(random.square(), random.unit()) {
                Some(direction) => {
                    let (u, v) = self.focus.place_of(direction);
                    let index = |x: f64| ((x * CELLS as f64) as usize).min(CELLS - 1);
                    index(u) * CELLS + index(v)
                }
                None => CELLS * CELLS,
            };
            counts[cell] += 1.0;
        }
        let density = |direction: Vec3| pdf(direction) as f64;
        let mut expected: Vec<f64> = cells().map(|cell| self.focus.integral(&density, cell)).collect();
        let total: f64 = expected.iter().sum();
        assert!(total < 1.0 + 2e-4, "{name}: the density integrates to {total}");
        // What the quadrature is off by must not pass for lost samples.
        expected.push(if counts[CELLS * CELLS] == 0.0 { 0.0 } else { (1.0 - total).max(0.0) });
        if counts[CELLS * CELLS] == 0.0 {
            assert!(total > 1.0 - 2e-4, "{name}: the density integrates to {total}, and no sample was lost");
        }
        expected.iter_mut().for_each(|count| *count *= SAMPLES as f64);
        chi_squared(name, &counts, &expected, FALSE_ALARMS / self.family as f64);
    }
}

/// Fails where counts differ from the expected ones by more than chance does at the given false-alarm rate.
///
/// Cells that expect fewer than five are pooled.
#[track_caller]
pub(crate) fn chi_squared(name: &str, counts: &[f64], expected: &[f64], false_alarms: f64) {
    let (mut statistic, mut used) = (0.0, 0usize);
    let mut pool = (0.0, 0.0);
    let mut add = |count: f64, expected: f64| {
        statistic += (count - expected) * (count - expected) / expected;
        used += 1;
    };
    for (&count, &expected) in counts.iter().zip(expected) {
        if expected < 5.0 {
            pool = (pool.0 + count, pool.1 + expected);
        } else {
            add(count, expected);
        }
    }
    if pool.1 >= 5.0 {
        add(pool.0, pool.1);
    } else {
        // Too few to compare: a Poisson count this far above its mean has a probability below 10⁻⁹.
        assert!(pool.0 <= pool.1 + 40.0, "{name}: {} samples where {} were expected", pool.0, pool.1);
    }
    assert!(used >= 8, "{name}: only {used} cells are populated");
    let chance = chi_squared_tail(statistic, (used - 1) as f64);
    assert!(
        chance > false_alarms,
        "{name}: chi-squared {statistic:.1} in {used} cells has a chance of {chance:e}, bound {false_alarms:e}"
    );
}

/// The probability that a chi-squared variable exceeds `x`: the upper incomplete gamma function Q(k/2, x/2).
fn chi_squared_tail(x: f64, degrees: f64) -> f64 {
    let (a, x) = (0.5 * degrees, 0.5 * x);
    if x <= 0.0 {
        return 1.0;
    }
    let front = (a * x.ln() - x - ln_gamma(a)).exp();
    if x < a + 1.0 {
        // The series of the lower function.
        let (mut term, mut sum, mut n) = (1.0 / a, 1.0 / a, a);
        while term > sum * 1e-16 {
            n += 1.0;
            term *= x / n;
            sum += term;
        }
        1.0 - front * sum
    } else {
        // The continued fraction of the upper one, by Lentz's method.
        let mut b = x + 1.0 - a;
        let (mut c, mut d) = (1e300, 1.0 / b);
        let mut h = d;
        for i in 1..10_000 {
            let an = -(i as f64) * (i as f64 - a);
            b += 2.0;
            d = 1.0 / (an * d + b);
            c = b + an / c;
            h *= d * c;
            if (d * c - 1.0).abs() < 1e-15 {
                break;
            }
        }
        front * h
    }
}

/// The logarithm of Γ(x) for x > 0: Stirling's series, shifted to where it converges.
fn ln_gamma(x: f64) -> f64 {
    if x < 10.0 {
        return ln_gamma(x + 1.0) - x.ln();
    }
    let square = x * x;
    let series = (1.0 / 12.0 - (1.0 / 360.0 - 1.0 / (1260.0 * square)) / square) / x;
    (x - 0.5) * x.ln() - x + 0.5 * TAU.ln() + series
}

/// The integral over a rectangle: five nodes a side, halved where the halves do not agree.
pub(crate) fn integrate(f: &impl Fn(f64, f64) -> f64, cell: [f64; 4], tolerance: f64) -> f64 {
    refine(f, cell, gauss(f, cell), tolerance, 7)
}

fn refine(f: &impl Fn(f64, f64) -> f64, [x0, x1, y0, y1]: [f64; 4], whole: f64, tolerance: f64, depth: u32) -> f64 {
    let (x, y) = (0.5 * (x0 + x1), 0.5 * (y0 + y1));
    let quarters = [[x0, x, y0, y], [x, x1, y0, y], [x0, x, y, y1], [x, x1, y, y1]];
    let parts = quarters.map(|quarter| gauss(f, quarter));
    let sum: f64 = parts.iter().sum();
    if depth == 0 || (sum - whole).abs() <= tolerance {
        return sum;
    }
    let tolerance = 0.5 * tolerance;
    quarters.into_iter().zip(parts).map(|(quarter, part)| refine(f, quarter, part, tolerance, depth - 1)).sum()
}

/// The Gauss-Legendre rule of five nodes a side (Abramowitz and Stegun, table 25.4).
fn gauss(f: &impl Fn(f64, f64) -> f64, [x0, x1, y0, y1]: [f64; 4]) -> f64 {
    const NODES: [(f64, f64); 5] = [
        (-0.906_179_845_938_664, 0.236_926_885_056_189),
        (-0.538_469_310_105_683, 0.478_628_670_499_366),
        (0.0, 0.568_888_888_888_889),
        (0.538_469_310_105_683, 0.478_628_670_499_366),
        (0.906_179_845_938_664, 0.236_926_885_056_189),
    ];
    let (x, y) = (0.5 * (x0 + x1), 0.5 * (y0 + y1));
    let (half_x, half_y) = (0.5 * (x1 - x0), 0.5 * (y1 - y0));
    let line = |u: f64| NODES.iter().map(|&(v, weight)| weight * f(x + half_x * u, y + half_y * v)).sum::<f64>();
    NODES.iter().map(|&(u, weight)| weight * line(u)).sum::<f64>() * half_x * half_y
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Critical values from the tables (NIST handbook 1.3.6.7.4).
    #[test]
    fn the_tail_agrees_with_the_tables() {
        let table = [(3.841, 1.0, 0.05), (18.307, 10.0, 0.05), (124.342, 100.0, 0.05), (149.449, 100.0, 0.001)];
        for (x, degrees, chance) in table {
            let tail = chi_squared_tail(x, degrees);
            assert!((tail / chance - 1.0).abs() < 2e-3, "{x} {degrees}: {tail} {chance}");
        }
        assert!((ln_gamma(0.5) - 0.5 * PI.ln()).abs() < 1e-9 && (ln_gamma(11.0) - 3_628_800f64.ln()).abs() < 1e-10);
    }

    #[test]
    fn the_square_covers_the_sphere() {
        for (axis, scale) in [(Vec3::Z, 1.0), (Vec3::new(0.6, 0.0, 0.8), 0.2), (Vec3::new(-0.6, 0.8, 0.0), 0.01)] {
            let focus = Focus::new(axis, scale);
            let total = focus.total(|_| 1.0);
            assert!((total / (2.0 * TAU) - 1.0).abs() < 1e-5, "{axis} {scale}: {total}");
            for (u, v) in [(0.1, 0.2), (0.5, 0.9), (0.9, 0.6)] {
                let (back_u, back_v) = focus.place_of(focus.direction_at(u, v).0.as_vec3());
                assert!((back_u - u).abs() + (back_v - v).abs() < 1e-4, "{u} {v}: {back_u} {back_v}");
            }
        }
    }

    /// A density that is off by a twentieth in one half is noticed, and so is a sampler that loses one in a hundred.
    #[test]
    fn a_wrong_density_is_noticed() {
        let test = SphereTest { focus: Focus::SPHERE, family: 100 };
        let even = |u: Vec2, _| Some(crate::warp::sphere(u));
        let fails = |run: &dyn Fn()| std::panic::catch_unwind(std::panic::AssertUnwindSafe(run)).is_err();
        let pdf = (0.5 / TAU) as f32;
        assert!(!fails(&|| test.check("even", even, |_| pdf)));
        assert!(fails(&|| test.check("tilted", even, |d| pdf * if d.x > 0.0 { 1.05 } else { 0.95 })));
        assert!(fails(&|| test.check("lossy", |u, c| (c > 0.01).then_some(crate::warp::sphere(u)), |_| pdf)));
        assert!(fails(&|| test.check("too dense", even, |_| pdf * 1.01)));
    }
}
