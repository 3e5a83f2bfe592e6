//! Gives escaped rays the background.

use crate::context::Context;
use crate::queues::{Contribution, ContributionQueue, EscapedView};

/// Gives each escaped ray the background's radiance.
///
/// Reads: escaped rays and the background. Writes: contributions.
pub fn escape(context: &Context<'_>, escaped: EscapedView<'_>, contributions: &mut ContributionQueue) {
    let background = &context.scene.background;
    for row in 0..escaped.len() {
        let ray = escaped.get(row);
        contributions
            .push(Contribution { radiance: ray.weight * background.radiance(ray.direction), pixel: ray.pixel });
    }
}
