//! How much a surface sends on, estimated by directions that its own sampler has no part in: what a ledger holds that sampler
//! against where no [table](crate::albedo) is known.
//!
//! A direction is drawn from a few [bundles](Bundle) that lie about where the surface is bright, and the surface's value there over
//! the density of the drawing is an unbiased estimate of what it sends on in all. However badly the bundles fit, the mean is right;
//! the better they do, the less it scatters. What it costs in time stands with the ledger that uses it. What is sent into single directions has no value and is added exactly.
//!
//! A bundle is a spherical Cauchy distribution (S. Kato and P. McCullagh, *Some properties of a Cauchy family on the sphere derived
//! from the Möbius transformations*, Bernoulli 26, 2020), `((1-ρ²)/(1+ρ²-2ρ cosθ))²/4π`. Around the mirror image along the normal it
//! is what GGX facets of half its width make of light, and its tails fall as theirs do; ρ = 0 is the whole sphere.

use core::f32::consts::FRAC_1_PI;

use brewster_lanes::math;
use glam::{Vec2, Vec3};

use crate::basis::Basis;
use crate::microfacet::Ggx;

/// Directions around an axis, the nearer the likelier.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bundle {
    axis: Vec3,
    /// 1-ρ.
    spread: f32,
}

/// At most this many bundles, in any order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bundles {
    bundles: [Bundle; Bundles::CAPACITY],
    count: usize,
}

impl Bundle {
    /// The upper hemisphere, and a little of the lower one.
    const ABOVE: Bundle = Bundle { axis: Vec3::Z, spread: 0.6 };

    /// A bundle whose density has fallen to a quarter at about `width` radians from the axis.
    #[inline]
    fn new(axis: Vec3, width: f32) -> Bundle {
        // (1-ρ)/√ρ = width.
        let root = 0.5 * ((width * width + 4.0).sqrt() - width);
        Bundle { axis, spread: (1.0 - root * root).max(1e-4) }
    }

    /// The direction that two numbers stand for, each 0 ≤ u < 1.
    #[inline]
    fn draw(&self, u: Vec2) -> Vec3 {
        let rho = 1.0 - self.spread;
        let versine = (2.0 * u.x * self.spread * self.spread)
            / ((1.0 + rho) * (1.0 + rho) - 4.0 * rho * u.x).max(f32::MIN_POSITIVE);
        let versine = versine.min(2.0);
        let (sine, cosine) = math::sin_cos(u.y * core::f32::consts::TAU);
        let radius = (versine * (2.0 - versine)).sqrt();
        Basis::around(self.axis).to_world(Vec3::new(radius * cosine, radius * sine, 1.0 - versine))
    }

    /// The density of a direction per solid angle.
    #[inline]
    fn pdf(&self, direction: Vec3) -> f32 {
        // By the chord: a cosine near 1 has too few digits.
        let versine = 0.5 * (direction - self.axis).length_squared();
        let ratio =
            self.spread * (2.0 - self.spread) / (self.spread * self.spread + 2.0 * (1.0 - self.spread) * versine);
        ratio * ratio * (0.25 * FRAC_1_PI)
    }
}

impl Bundles {
    /// Room for what a principled surface has: both sides, a highlight, a clearcoat's, and what glass bends.
    const CAPACITY: usize = 5;

    /// Those of a surface that scatters to its upper side.
    pub const ABOVE: Bundles = Bundles { bundles: [Bundle::ABOVE; Bundles::CAPACITY], count: 1 };

    /// Those and one around a direction, `width` radians wide.
    #[inline]
    #[must_use]
    pub fn and(mut self, axis: Vec3, width: f32) -> Bundles {
        self.bundles[self.count] = Bundle::new(axis, width);
        self.count += 1;
        self
    }

    /// Those and one where facets reflect the light from `view`; none where they are a mirror, whose image has no value.
    #[inline]
    #[must_use]
    pub fn and_highlight(self, view: Vec3, facets: &Ggx) -> Bundles {
        if facets.is_smooth() {
            return self;
        }
        let [x, y] = facets.alphas();
        self.and(Vec3::new(-view.x, -view.y, view.z), 2.0 * x.max(y))
    }

    /// Those and all of the lower side.
    #[inline]
    #[must_use]
    pub fn and_below(mut self) -> Bundles {
        self.bundles[self.count] = Bundle { axis: Vec3::NEG_Z, ..Bundle::ABOVE };
        self.count += 1;
        self
    }

    /// An estimate of the sum of a value over all directions by one of them, for which three numbers stand, each 0 ≤ u < 1.
    #[inline]
    pub fn estimate(&self, choice: f32, u: Vec2, value: impl FnOnce(Vec3) -> Vec3) -> Vec3 {
        let bundles = &self.bundles[..self.count];
        let count = self.count as f32;
        let direction = bundles[((choice * count) as usize).min(self.count - 1)].draw(u);
        let pdf = bundles.iter().map(|bundle| bundle.pdf(direction)).sum::<f32>() / count;
        value(direction) / pdf
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::albedo::rough_mirror;
    use crate::lambert;
    use crate::statistics::{Focus, Random, SphereTest};
    use glam::DVec3;

    #[test]
    fn bundles_follow_their_density() {
        let axis = Vec3::new(0.48, -0.6, 0.64);
        for width in [0.0, 1e-3, 0.1, 1.0, 8.0] {
            let bundle = Bundle::new(axis, width);
            let test = SphereTest { focus: Focus::new(axis, width.clamp(1e-3, 1.0)), family: 6 };
            test.check(&format!("{bundle:?}"), |u, _| Some(bundle.draw(u)), |direction| bundle.pdf(direction));
        }
        let test = SphereTest { focus: Focus::SPHERE, family: 6 };
        test.check("above", |u, _| Some(Bundle::ABOVE.draw(u)), |direction| Bundle::ABOVE.pdf(direction));
    }

    /// The mean of estimates, and its standard error.
    fn mean(bundles: &Bundles, value: impl Fn(Vec3) -> Vec3) -> (f64, f64) {
        let (mut random, count) = (Random::new(17), 100_000);
        let (mut sum, mut squares) = (0.0, 0.0);
        for _ in 0..count {
            let estimate = bundles.estimate(random.unit(), random.square(), &value).x as f64;
            (sum, squares) = (sum + estimate, squares + estimate * estimate);
        }
        let mean = sum / count as f64;
        (mean, ((squares / count as f64 - mean * mean) / count as f64).sqrt())
    }

    /// Of what is known: a white diffuse surface sends on all, rough mirrors what a quadrature says, however badly the bundle fits.
    #[test]
    fn estimates_are_right_in_mean() {
        let diffuse = |light: Vec3| if light.z > 0.0 { lambert::brdf(Vec3::ONE) * light.z } else { Vec3::ZERO };
        let mut cases = vec![
            ("diffuse", 2.0, mean(&Bundles::ABOVE, diffuse), 1.0),
            ("both sides", 2.0, mean(&Bundles::ABOVE.and_below(), |light| diffuse(light) + diffuse(-light)), 2.0),
        ];
        for alpha in [[0.002; 2], [0.1; 2], [0.6; 2], [0.3, 0.05]] {
            for cosine in [1.0, 0.6, 0.1] {
                let view = crate::albedo::at_cosine(cosine);
                let facets = Ggx::anisotropic(alpha[0], alpha[1]);
                let image = view.as_vec3() * Vec3::new(-1.0, -1.0, 1.0);
                let theory = rough_mirror(view, alpha.map(f64::from), |_| DVec3::ONE).x;
                let value = |light| facets.reflection(view.as_vec3(), light, |_| Vec3::ONE).f_cos;
                for fit in [0.5, 2.0, 5.0] {
                    cases.push(("mirror", fit, mean(&Bundles::ABOVE.and(image, fit * alpha[0]), value), theory));
                }
            }
        }
        for (name, fit, (mean, error), theory) in cases {
            // Forty means; the quadrature is good to 2e-4.
            assert!((mean - theory).abs() < 4.5 * error + 2e-4, "{name}: {mean} ± {error}, not {theory}");
            assert!(fit != 2.0 || error < 0.02, "{name}: {mean} ± {error}");
        }
    }
}
