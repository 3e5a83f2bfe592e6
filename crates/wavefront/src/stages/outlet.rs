//! Where what a surface sends goes: into queues, or to whoever follows it at once.

use crate::queues::{
    Contribution, ContributionQueue, DepthQueues, PathRay, PathRaysView, ShadowQueue, ShadowRay, ShadowRaysView,
};

/// Takes what hits send. Shading is written for any outlet, so that there is one of it however rays are scheduled.
pub trait Outlet {
    /// Takes a reflection of the next depth.
    fn reflect(&mut self, ray: PathRay);
    /// Takes a transmission of the next depth.
    fn transmit(&mut self, ray: PathRay);
    /// Takes a ray toward a light.
    fn shadow(&mut self, ray: ShadowRay);
    /// Takes light.
    fn light(&mut self, contribution: Contribution);

    /// Takes those reflections that are marked.
    #[inline(always)]
    fn reflect_marked(&mut self, rays: PathRaysView<'_>, marks: &[bool]) {
        marked(marks).for_each(|row| self.reflect(rays.get(row)));
    }

    /// Takes those transmissions that are marked.
    #[inline(always)]
    fn transmit_marked(&mut self, rays: PathRaysView<'_>, marks: &[bool]) {
        marked(marks).for_each(|row| self.transmit(rays.get(row)));
    }

    /// Takes those rays toward lights that are marked.
    #[inline(always)]
    fn shadow_marked(&mut self, rays: ShadowRaysView<'_>, marks: &[bool]) {
        marked(marks).for_each(|row| self.shadow(rays.get(row)));
    }
}

#[inline(always)]
fn marked(marks: &[bool]) -> impl Iterator<Item = usize> {
    marks.iter().enumerate().filter(|&(_, &mark)| mark).map(|(row, _)| row)
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
    fn reflect_marked(&mut self, rays: PathRaysView<'_>, marks: &[bool]) {
        if let Some(next) = &mut self.next {
            next.reflection.extend_marked(rays, marks);
        }
    }

    #[inline(always)]
    fn transmit_marked(&mut self, rays: PathRaysView<'_>, marks: &[bool]) {
        if let Some(next) = &mut self.next {
            next.transmission.extend_marked(rays, marks);
        }
    }

    #[inline(always)]
    fn shadow_marked(&mut self, rays: ShadowRaysView<'_>, marks: &[bool]) {
        self.shadows.extend_marked(rays, marks);
    }

    #[inline(always)]
    fn light(&mut self, contribution: Contribution) {
        self.contributions.push(contribution);
    }
}
