//! Where what a surface sends goes: into queues, or to whoever follows it at once.

use crate::queues::{Contribution, ContributionQueue, DepthQueues, PathRay, ShadowQueue, ShadowRay};

/// Takes what one hit sends. Shading is written for any outlet, so that there is one of it however rays are scheduled.
pub trait Outlet {
    /// Takes a reflection of the next depth.
    fn reflect(&mut self, ray: PathRay);
    /// Takes a transmission of the next depth.
    fn transmit(&mut self, ray: PathRay);
    /// Takes a ray toward a light.
    fn shadow(&mut self, ray: ShadowRay);
    /// Takes light.
    fn light(&mut self, contribution: Contribution);
}

/// The queues of a batch.
#[derive(Debug)]
pub struct Queues<'a> {
    /// Those of the next depth; none at the maximum depth, where nothing is sent on.
    pub next: Option<&'a mut DepthQueues>,
    /// Rays toward lights.
    pub shadows: &'a mut ShadowQueue,
    /// Light on its way to the samples.
    pub contributions: &'a mut ContributionQueue,
}

impl Outlet for Queues<'_> {
    #[inline(always)]
    fn reflect(&mut self, ray: PathRay) {
        if let Some(next) = &mut self.next {
            next.reflection.push(ray);
        }
    }

    #[inline(always)]
    fn transmit(&mut self, ray: PathRay) {
        if let Some(next) = &mut self.next {
            next.transmission.push(ray);
        }
    }

    #[inline(always)]
    fn shadow(&mut self, ray: ShadowRay) {
        self.shadows.push(ray);
    }

    #[inline(always)]
    fn light(&mut self, contribution: Contribution) {
        self.contributions.push(contribution);
    }
}
