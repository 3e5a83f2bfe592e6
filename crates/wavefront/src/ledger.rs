//! The energy ledger: where the weight of all rays went, per depth and queue.
//!
//! A camera ray sets out with weight 1 in each channel; what a weight loses, and what happens to the ray that carries it, is
//! written down where it happens. Sums are integers, so they do not depend on threads or batches, and two equations hold to
//! the last digit:
//!
//! - `entered = volume + strayed + escaped + crossed + emitters + cut + scattered`: what a traced ray comes to;
//! - `scattered + recolored = absorbed + residual + below_surface + roulette_removed - roulette_added + onward`: what a surface, or a medium, makes of it.
//!
//! What a surface absorbs is not what its sampler happens to lose: `absorbed` is what the theory expects, from the
//! material's [tabulated albedo](crate::albedo). The sampler's deviation from it is `residual`, whose mean is zero if sampler
//! and theory agree: [`Ledger::z`] says how far it is off, in standard errors. A sampler that loses energy shows there.
//! Where no albedo is tabulated (principled surfaces, coats over metal, coats that absorb) one of four hits is asked for it: an
//! [estimate](brewster_optics::audit) by what the surface sends in one direction that its sampler had no part in, unbiased, but with
//! noise of its own, which z takes into account. Of the others the sampler is believed: they are absorbed as it says, have no residual
//! and do not count for z. So it takes more hits until a loss shows beyond four standard errors: for one of a fifth 60,000 on any of
//! the surfaces of the tests, where a table finds one of three parts in a hundred among 40,000. It costs a scene of principled surfaces
//! 5 to 6 % of the processor's time, where the ledger of one whose albedos are tabulated costs 0 to 3, and noise is 1
//! (`cargo bench -p brewster-tests --bench ledger -- scenes/principled.ron tests/references/metals-rough.ron`: 1.057 and 1.072 in two runs,
//! and 1.005 and 1.033).
//!
//! So it is with media that scatter: `volume` is what they absorb of all light that enters them, by their coefficients, and `strayed`
//! what the distance that was drawn takes beyond that, zero in mean ([`Ledger::stray_z`]).
//!
//! The squared ratio of indices, by which radiance changes at a boundary, is no energy and is not in weights.

use std::num::Wrapping;

use glam::Vec3;

/// Units of energy in a weight of 1.
const SCALE: f32 = (1 << 24) as f32;

/// A value of a weight in units of the ledger's sums, rounded; what is no number is 0, and none is beyond ±2²⁶.
#[inline(always)]
pub(crate) fn units(value: f32) -> Wrapping<i64> {
    /// Adding it to an f64 below 2⁵¹ in size leaves the nearest integer in the low bits.
    const ROUND: f64 = 6_755_399_441_055_744.0;
    const LIMIT: f32 = (1u64 << 50) as f32;
    let units = value * SCALE;
    let units = if units < LIMIT { units } else { LIMIT };
    let units = if units > -LIMIT { units } else { -LIMIT };
    let units = if value.is_nan() { 0.0 } else { units };
    Wrapping(((f64::from(units) + ROUND).to_bits() as i64) - ROUND.to_bits() as i64)
}

/// A sum of weights by channel, in units of 2⁻²⁴.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Energy(pub [i64; 3]);

impl Energy {
    /// Adds a weight.
    #[inline(always)]
    pub fn add(&mut self, weight: Vec3) {
        for (channel, value) in weight.to_array().into_iter().enumerate() {
            self.add_units(channel, units(value));
        }
    }

    /// Adds to a channel.
    #[inline(always)]
    pub(crate) fn add_units(&mut self, channel: usize, sum: Wrapping<i64>) {
        self.0[channel] = self.0[channel].wrapping_add(sum.0);
    }

    /// Takes a weight away.
    #[inline(always)]
    pub fn take(&mut self, weight: Vec3) {
        self.add(-weight);
    }

    /// Adds another sum.
    #[inline(always)]
    pub fn merge(&mut self, other: Energy) {
        for (sum, value) in self.0.iter_mut().zip(other.0) {
            *sum = sum.wrapping_add(value);
        }
    }

    /// The sum in camera rays' weights.
    pub fn value(&self) -> [f64; 3] {
        self.0.map(|sum| sum as f64 / f64::from(SCALE))
    }
}

macro_rules! ledger {
    ($($(#[$doc:meta])* $field:ident,)*) => {
        /// Where the weight of the rays of one depth and queue went.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
        pub struct Ledger {
            $($(#[$doc])* pub $field: Energy,)*
        }

        impl Ledger {
            /// Adds what other rays did.
            pub fn merge(&mut self, other: &Ledger) {
                $(self.$field.merge(other.$field);)*
            }

            /// All entries, by name.
            pub fn entries(&self) -> impl Iterator<Item = (&'static str, Energy)> {
                [$((stringify!($field), self.$field),)*].into_iter()
            }
        }
    };
}

ledger! {
    /// Of the rays that were traced.
    entered,
    /// Absorbed by media on the way, by theory.
    volume,
    /// What free flights lost beyond theory; below zero what they gave too much. Zero in mean.
    strayed,
    /// Sum of the squares of each flight's part of that.
    strayed_squares,
    /// Gone to the background.
    escaped,
    /// Gone on through boundaries that are none; it enters again at the same depth.
    crossed,
    /// Arrived at emitters, which reflect nothing.
    emitters,
    /// Cut off: arrived at a surface at the maximum depth.
    cut,
    /// Arrived at surfaces that scatter, or scattered by media.
    scattered,
    /// Given to paths that have drawn a wavelength, below zero where it was taken: zero in mean.
    recolored,
    /// Of what is scattered, absorbed by theory.
    absorbed,
    /// What the sampler lost beyond theory; below zero what it gave too much. Zero in mean.
    residual,
    /// Sum of the squares of each hit's residual.
    residual_squares,
    /// Scattered below the surface, where shading normals differ from it, and dropped.
    below_surface,
    /// Of the rays that roulette ended.
    roulette_removed,
    /// Given to those that it spared; equal to `roulette_removed` in mean.
    roulette_added,
    /// Sent on to the next depth.
    onward,
}

impl Ledger {
    /// The residual in its standard errors, by channel; 0 where no hit has any.
    pub fn z(&self) -> [f64; 3] {
        in_errors(self.residual, self.residual_squares)
    }

    /// What free flights lost beyond theory in its standard errors, by channel; 0 where nothing scatters.
    pub fn stray_z(&self) -> [f64; 3] {
        in_errors(self.strayed, self.strayed_squares)
    }
}

/// A sum whose mean is zero over the root of its squares.
fn in_errors(sum: Energy, squares: Energy) -> [f64; 3] {
    let (sum, squares) = (sum.value(), squares.value());
    std::array::from_fn(|c| if squares[c] > 0.0 { sum[c] / squares[c].sqrt() } else { 0.0 })
}

#[cfg(test)]
mod tests {
    use super::units;

    /// Products with 2²⁴ that f64 has exactly, rounded by the standard library, ties to even; and the ends.
    #[test]
    fn weights_are_rounded_to_units() {
        let steps = (0..2000).map(|i| (i as f32 - 1000.0) * 1.234_567e-8);
        for value in steps.chain([0.0, -0.0, 1.0, 0.73, 1e3, -6.5e7, 1.5 / (1 << 24) as f32, 2.5 / (1 << 24) as f32]) {
            let exact = (f64::from(value) * f64::from(1 << 24)).round_ties_even();
            assert_eq!(units(value).0, exact as i64, "{value}");
        }
        for (value, expected) in [(f32::NAN, 0), (f32::INFINITY, 1 << 50), (f32::MIN, -(1 << 50)), (1e30, 1 << 50)] {
            assert_eq!(units(value).0, expected, "{value}");
        }
    }
}
