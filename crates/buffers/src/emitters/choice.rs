//! Which source of light is asked: one of a tree, or one that shines alike everywhere.

use glam::Vec3;

use super::node::LightBounds;
use super::tree::LightTree;
use crate::Distribution;

/// What a choice is made by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Source {
    /// A source in a place, weakened by the squared distance.
    Near(LightBounds),
    /// A source that is not weakened: its irradiance in lux.
    Everywhere(f64),
}

/// Chooses a source. What is not weakened by distance has no place in a tree: it stands beside it and is chosen half of the
/// time, by irradiance.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct LightChoice {
    tree: LightTree,
    /// The sources of the tree.
    near: Vec<u32>,
    by_irradiance: Option<Distribution>,
    /// The sources beside it, with their irradiances.
    everywhere: Vec<(u32, f64)>,
}

impl LightChoice {
    /// A choice of sources in the order of their numbers. What can be met by a ray comes first, so that its number is the same
    /// in the tree.
    pub(super) fn new(sources: &[Source]) -> LightChoice {
        let mut choice = LightChoice::default();
        let mut bounds = Vec::new();
        for (number, source) in (0..).zip(sources) {
            match *source {
                Source::Near(source) => {
                    choice.near.push(number);
                    bounds.push(source);
                }
                Source::Everywhere(irradiance) => choice.everywhere.push((number, irradiance)),
            }
        }
        choice.tree = LightTree::new(bounds);
        let irradiances: Vec<f64> = choice.everywhere.iter().map(|(_, irradiance)| *irradiance).collect();
        choice.by_irradiance = Distribution::new(&irradiances);
        choice
    }

    /// Whether it was made of these.
    pub(super) fn is_of(&self, sources: &[Source]) -> bool {
        let (mut near, mut everywhere) = (self.tree.sources().iter(), self.everywhere.iter());
        sources.len() == self.near.len() + self.everywhere.len()
            && sources.iter().zip(0..).all(|(source, number)| match source {
                Source::Near(source) => near.next() == Some(source),
                Source::Everywhere(irradiance) => everywhere.next() == Some(&(number, *irradiance)),
            })
    }

    /// Has it follow changed sources that a ray can meet, by their numbers: afterwards it equals a new one. Tells whether any of
    /// them is another than before.
    pub(super) fn follow(&mut self, mut changed: Vec<(u32, LightBounds)>) -> bool {
        changed.retain(|(number, source)| self.tree.sources()[*number as usize] != *source);
        if !changed.is_empty() {
            self.tree.follow(&changed);
        }
        !changed.is_empty()
    }

    /// The probability of asking the tree.
    #[inline(always)]
    fn chance_of_tree(&self) -> f32 {
        match (self.near.is_empty(), &self.by_irradiance) {
            (true, _) => 0.0,
            (false, Some(_)) => 0.5,
            (false, None) => 1.0,
        }
    }

    /// A source as a point sees it, drawn with 0 ≤ u < 1, and the probability of that. None where no source may shine.
    #[inline]
    pub(super) fn choose(&self, point: Vec3, u: f32) -> Option<(u32, f32)> {
        let chance = self.chance_of_tree();
        if u < chance {
            let (source, probability) = self.tree.choose(point, u / chance)?;
            return Some((self.near[source as usize], chance * probability));
        }
        let choice = self.by_irradiance.as_ref()?.choose((u - chance) / (1.0 - chance));
        Some((self.everywhere[choice.index as usize].0, (1.0 - chance) * choice.probability))
    }

    /// The probability of choosing a source that a ray can meet.
    #[inline]
    pub(super) fn probability(&self, point: Vec3, source: u32) -> f32 {
        self.chance_of_tree() * self.tree.probability(point, source)
    }
}
