//! Russian roulette: of paths whose weight has become small some are given up, and the others weigh more.

use glam::Vec3;

/// Rays whose largest weight is at least this are all followed; of lighter ones as many as keep their sum, each with this
/// weight.
const LIGHTEST: f32 = 0.25;

/// Whether a path of this weight goes on by chance.
#[inline(always)]
pub(super) fn is_asked(weight: Vec3) -> bool {
    weight.max_element() < LIGHTEST
}

/// What a path weighs if it goes on, by a number 0 ≤ u < 1, of which some multiple of its weight [was asked](is_asked).
#[inline(always)]
pub(super) fn spared(weight: Vec3, multiple: f32, u: f32) -> Option<Vec3> {
    let survival = (weight * multiple).max_element() / LIGHTEST;
    (u < survival).then(|| weight / survival)
}
