//! How entities move while the shutter is open.

use std::sync::Arc;

use bevy_ecs::component::Component;
use glam::Affine3A;

use super::Transform;

/// How an entity moves while the shutter is open, in its own space: its [`Transform`] times these, after each of as many equal
/// steps of the shutter's time. When it opens the entity is where its transform says. What is below it goes along.
///
/// Between two steps the *matrix* is interpolated: every point goes straight on.
#[derive(Component, Clone, Debug, PartialEq)]
#[require(Transform)]
#[component(summary_tick)]
pub struct Motion(Arc<[Affine3A]>);

impl Motion {
    /// Steps that a motion has at most.
    pub const MOST_STEPS: usize = 1024;

    /// A motion by steps; none if there are no steps, or more than [`MOST_STEPS`](Motion::MOST_STEPS).
    pub fn through(steps: impl Into<Arc<[Affine3A]>>) -> Option<Motion> {
        let steps = steps.into();
        (1..=Motion::MOST_STEPS).contains(&steps.len()).then_some(Motion(steps))
    }

    /// A motion that is known at every moment 0 < s ≤ 1 and turns by an angle in all, in [as many steps](Motion::steps_of) as that takes.
    pub fn turning(angle: f32, mut at: impl FnMut(f32) -> Affine3A) -> Motion {
        let steps = Motion::steps_of(angle);
        Motion((1..=steps).map(|step| at(step as f32 / steps as f32)).collect())
    }

    /// The steps that what turns by an angle (radians) needs to look round: a power of two, one where nothing turns. The chord of a
    /// step lies within a thousandth of the radius of its arc.
    pub fn steps_of(angle: f32) -> usize {
        // 1 - cos(φ/2) < 10⁻³.
        const WIDEST: f32 = 0.0894;
        ((angle.abs() / WIDEST).ceil() as usize).clamp(1, Motion::MOST_STEPS).next_power_of_two()
    }

    /// Where the entity's space is after each of the steps, seen from where it is when the shutter opens.
    pub fn steps(&self) -> &[Affine3A] {
        &self.0
    }
}
