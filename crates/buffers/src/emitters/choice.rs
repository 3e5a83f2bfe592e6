//! Which source of light is asked.

use glam::Vec3;

use crate::Distribution;

/// What a choice is made by.
pub(super) struct Source {
    /// Flux in lumen.
    pub(super) power: f64,
}

/// Chooses a source.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct LightChoice {
    by_power: Option<Distribution>,
}

impl LightChoice {
    pub(super) fn new(sources: &[Source]) -> LightChoice {
        let powers: Vec<f64> = sources.iter().map(|source| source.power).collect();
        LightChoice { by_power: Distribution::new(&powers) }
    }

    /// A source as a point sees it, and the probability of that.
    #[inline]
    pub(super) fn choose(&self, _point: Vec3, u: f32) -> Option<(u32, f32)> {
        let choice = self.by_power.as_ref()?.choose(u);
        Some((choice.index, choice.probability))
    }

    /// The probability of choosing a source.
    #[inline]
    pub(super) fn probability(&self, _point: Vec3, source: u32) -> f32 {
        self.by_power.as_ref().map_or(0.0, |distribution| distribution.probability(source))
    }
}
