//! Pixel filters by importance sampling: a filter says where around its pixel a sample lies, and every sample weighs 1.

use brewster_lanes::math;

use crate::FilmError;

/// The shape of a pixel's footprint: a product of one bell in x and one in y, nonnegative, zero beyond `radius` pixels from
/// the pixel's center.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Filter {
    /// Even.
    Box {
        /// Half the width in pixels; above 0 and at most [`Filter::MAX_RADIUS`], as for the others.
        radius: f32,
    },
    /// Falls linearly to zero at the radius.
    Tent {
        /// Half the width in pixels.
        radius: f32,
    },
    /// exp(-x²/2σ²), lowered so that it reaches zero at the radius.
    Gaussian {
        /// Half the width in pixels.
        radius: f32,
        /// σ in pixels; at least a hundredth of the radius.
        deviation: f32,
    },
    /// The 4-term Blackman-Harris window (F. J. Harris, "On the use of windows for harmonic analysis", 1978).
    BlackmanHarris {
        /// Half the width in pixels.
        radius: f32,
    },
}

impl Filter {
    /// The largest radius in pixels.
    pub const MAX_RADIUS: f32 = 16.0;
    /// The pixel itself.
    pub const BOX: Filter = Filter::Box { radius: 0.5 };
    /// A pyramid two pixels wide.
    pub const TENT: Filter = Filter::Tent { radius: 1.0 };
    /// A Gaussian of σ = ½ pixel, three pixels wide.
    pub const GAUSSIAN: Filter = Filter::Gaussian { radius: 1.5, deviation: 0.5 };
    /// A Blackman-Harris window four pixels wide.
    pub const BLACKMAN_HARRIS: Filter = Filter::BlackmanHarris { radius: 2.0 };

    /// Half the width in pixels.
    pub fn radius(&self) -> f32 {
        match *self {
            Filter::Box { radius }
            | Filter::Tent { radius }
            | Filter::Gaussian { radius, .. }
            | Filter::BlackmanHarris { radius } => radius,
        }
    }

    /// The unnormalized bell at x = `part` radii from the center, `part` in 0..=1.
    fn density(&self, part: f32) -> f32 {
        match *self {
            Filter::Box { .. } => 1.0,
            Filter::Tent { .. } => 1.0 - part,
            Filter::Gaussian { radius, deviation } => {
                let at = |x: f32| math::exp(-0.5 * x * x / (deviation * deviation));
                at(part * radius) - at(radius)
            }
            Filter::BlackmanHarris { .. } => {
                let wave = |n: f32| math::cos(n * core::f32::consts::PI * part);
                (0.35875 + 0.48829 * wave(1.0) + 0.14128 * wave(2.0) + 0.01168 * wave(3.0)).max(0.0)
            }
        }
    }

    fn check(&self) -> Result<(), FilmError> {
        let radius = self.radius();
        if !(radius > 0.0 && radius <= Filter::MAX_RADIUS) {
            let expected = "a number above 0 and at most 16";
            return Err(FilmError::Setting { name: "the filter's radius", value: radius, expected });
        }
        if let Filter::Gaussian { deviation, .. } = *self
            && !(deviation >= 0.01 * radius && deviation <= 100.0 * radius)
        {
            let expected = "a number from a hundredth of the radius to a hundred times it";
            return Err(FilmError::Setting { name: "the filter's deviation", value: deviation, expected });
        }
        Ok(())
    }
}

/// Steps of the table: each stands for a thousandth of the probability on one side of the center.
const STEPS: usize = 1024;

/// Draws offsets from a [`Filter`].
///
/// The inverse of the cumulative distribution on one side of the center is tabulated in 1,024 steps of equal
/// probability, with linear interpolation between them, by plain arithmetic: the same bits on every platform. Building
/// costs a fraction of a millisecond; the table takes 4 KiB and never changes, so any number of threads may share it.
#[derive(Clone, Debug)]
pub struct FilterSampler {
    distances: Vec<f32>,
}

impl FilterSampler {
    /// The sampler of a filter.
    ///
    /// # Errors
    ///
    /// The radius or deviation is out of range.
    pub fn new(filter: Filter) -> Result<FilterSampler, FilmError> {
        filter.check()?;
        const SLICES: usize = 16 * STEPS;
        let width = 1.0 / SLICES as f64;
        let masses: Vec<f64> =
            (0..SLICES).map(|i| f64::from(filter.density(((i as f64 + 0.5) * width) as f32))).collect();
        let total: f64 = masses.iter().sum();

        let radius = f64::from(filter.radius());
        let mut distances = Vec::with_capacity(STEPS + 1);
        let (mut slice, mut before) = (0, 0.0);
        for step in 0..STEPS {
            let target = total * step as f64 / STEPS as f64;
            while before + masses[slice] <= target {
                before += masses[slice];
                slice += 1;
            }
            let part = (target - before) / masses[slice];
            distances.push(((slice as f64 + part) * width * radius) as f32);
        }
        distances.push(filter.radius());
        Ok(FilterSampler { distances })
    }

    /// The offset in pixels from the pixel's center of the sample at `u`, evenly distributed in [0, 1)². Each component
    /// grows with its own part of `u` and reaches from -radius to radius.
    #[inline]
    pub fn sample(&self, u: [f32; 2]) -> [f32; 2] {
        u.map(|u| self.distance(u))
    }

    #[inline]
    fn distance(&self, u: f32) -> f32 {
        let signed = 2.0 * u - 1.0;
        let place = signed.abs() * STEPS as f32;
        let step = (place as usize).min(STEPS - 1);
        let (near, far) = (self.distances[step], self.distances[step + 1]);
        (near + (far - near) * (place - step as f32)).copysign(signed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The mass of a bell between two places by Simpson's rule, in f64 and with the standard library's functions.
    fn mass(bell: &dyn Fn(f64) -> f64, from: f64, to: f64) -> f64 {
        let n = 200;
        let h = (to - from) / f64::from(n);
        let weight = |i| if i == 0 || i == n { 1.0 } else { 2.0 + 2.0 * f64::from(i % 2) };
        (0..=n).map(|i| weight(i) * bell(from + f64::from(i) * h)).sum::<f64>() * h / 3.0
    }

    fn check(filter: Filter, bell: &dyn Fn(f64) -> f64) {
        let radius = f64::from(filter.radius());
        let sampler = FilterSampler::new(filter).unwrap();
        let (bins, count) = (24, 200_000);
        let mut histogram = vec![0u32; bins];
        let mut last = f32::NEG_INFINITY;
        for i in 0..count {
            let [x, y] = sampler.sample([(i as f32 + 0.5) / count as f32, 0.25]);
            assert!(x >= last && f64::from(x.abs()) <= radius, "{filter:?}: {x} after {last}");
            assert_eq!(y, sampler.sample([0.9, 0.25])[1]);
            last = x;
            let bin = (f64::from(x) + radius) / (2.0 * radius) * bins as f64;
            histogram[(bin as usize).min(bins - 1)] += 1;
        }
        let total = mass(bell, -radius, 0.0) + mass(bell, 0.0, radius);
        for (bin, &found) in histogram.iter().enumerate() {
            let edge = |i: usize| radius * (2.0 * i as f64 / bins as f64 - 1.0);
            let expected = mass(bell, edge(bin), edge(bin + 1)) / total;
            let found = f64::from(found) / f64::from(count);
            assert!((found - expected).abs() < 3e-4, "{filter:?} bin {bin}: {found} for {expected}");
        }
    }

    #[test]
    fn samples_follow_the_bell() {
        check(Filter::BOX, &|_| 1.0);
        check(Filter::Box { radius: 1.25 }, &|_| 1.0);
        check(Filter::TENT, &|x| 1.0 - x.abs());
        check(Filter::GAUSSIAN, &|x| (-2.0 * x * x).exp() - (-2.0f64 * 1.5 * 1.5).exp());
        check(Filter::Gaussian { radius: 1.0, deviation: 50.0 }, &|x| 1.0 - x * x);
        check(Filter::BLACKMAN_HARRIS, &|x| {
            let t = core::f64::consts::PI * (x / 2.0 + 1.0);
            0.35875 - 0.48829 * t.cos() + 0.14128 * (2.0 * t).cos() - 0.01168 * (3.0 * t).cos()
        });
    }

    #[test]
    fn closed_forms_are_met() {
        let pixel = FilterSampler::new(Filter::BOX).unwrap();
        let tent = FilterSampler::new(Filter::TENT).unwrap();
        for (u, straight, triangular) in
            [(0.0, -0.5, -1.0), (0.125, -0.375, -0.5), (0.5, 0.0, 0.0), (0.875, 0.375, 0.5), (1.0, 0.5, 1.0)]
        {
            assert!((pixel.sample([u, 0.0])[0] - straight).abs() < 1e-6, "{u}");
            assert!((tent.sample([0.0, u])[1] - triangular).abs() < 1e-5, "{u}");
        }
    }

    #[test]
    fn bad_filters_are_errors() {
        for radius in [0.0, -1.0, 16.5, f32::NAN, f32::INFINITY] {
            let error = FilterSampler::new(Filter::Tent { radius }).unwrap_err().to_string();
            assert_eq!(error, format!("the filter's radius is {radius}, expected a number above 0 and at most 16"));
        }
        for deviation in [0.0, -0.5, 0.001, f32::NAN, f32::INFINITY] {
            assert!(FilterSampler::new(Filter::Gaussian { radius: 1.0, deviation }).is_err(), "{deviation}");
        }
    }
}
