//! What queues look like: how long they are, how alike the rays are that stand side by side, what rays meet on their way.
//!
//! A survey is kept where the [policy](crate::Policy::survey) asks for it, outside the times of stages. It depends on how a picture
//! is cut into batches, but on no thread.

use brewster_geometry::{HitsView, Visits, visits, visits_until_blocked};

use crate::context::Context;
use crate::queues::{NO_INSTANCE, PathRaysView, RaySource, SamplesView, ShadowQueue};
use crate::stages::octant;
use crate::stats::Stage;

/// Lanes that occupancy is told of: those of the widest registers.
pub const LANES: usize = 16;

/// How a stage was called.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Calls {
    /// How often.
    pub calls: u64,
    /// Registers of [`LANES`] lanes that the rays of every call fill, the last one of a call in part.
    pub registers: u64,
}

/// What the queue of a depth looked like whenever it was traced.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct QueueSurvey {
    /// How often.
    pub taken: u64,
    /// Rays.
    pub rays: u64,
    /// How often there were 1, 2 to 3, 4 to 7 rays, and so on.
    pub lengths: [u64; 32],
    /// Runs of rays side by side whose directions lie in one octant.
    pub octant_runs: u64,
    /// Runs of rays side by side that met one material, or nothing.
    pub material_runs: u64,
    /// What rays looked at, each alone: nodes, instances, and shapes and triangles.
    pub visits: [u64; 3],
    /// Rays that hits sent toward lights.
    pub shadow_rays: u64,
    /// What these looked at, each alone, up to what stopped them first: where they may go on behind that, more is to come.
    pub shadow_visits: [u64; 3],
    /// The calls of every stage, in the order of [`Stage::ALL`].
    pub stages: [Calls; Stage::ALL.len()],
}

impl Default for QueueSurvey {
    fn default() -> Self {
        QueueSurvey {
            taken: 0,
            rays: 0,
            lengths: [0; 32],
            octant_runs: 0,
            material_runs: 0,
            visits: [0; 3],
            shadow_rays: 0,
            shadow_visits: [0; 3],
            stages: [Calls::default(); Stage::ALL.len()],
        }
    }
}

impl QueueSurvey {
    /// Adds what another part of the render saw.
    pub fn add(&mut self, other: &QueueSurvey) {
        self.taken += other.taken;
        self.rays += other.rays;
        self.octant_runs += other.octant_runs;
        self.material_runs += other.material_runs;
        self.shadow_rays += other.shadow_rays;
        let sums = self.lengths.iter_mut().chain(&mut self.visits).chain(&mut self.shadow_visits);
        let others = other.lengths.iter().chain(&other.visits).chain(&other.shadow_visits);
        sums.zip(others).for_each(|(sum, number)| *sum += number);
        for (sum, other) in self.stages.iter_mut().zip(other.stages) {
            sum.calls += other.calls;
            sum.registers += other.registers;
        }
    }
}

/// What the queues of a render, or of a part of one, looked like.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Survey {
    /// One a depth, from 0 to the maximum, by queue in the order of [`RaySource::ALL`].
    pub depths: Vec<[QueueSurvey; RaySource::ALL.len()]>,
}

impl Survey {
    /// Nothing yet, for depths up to a maximum.
    pub fn new(max_depth: u32) -> Survey {
        Survey { depths: vec![Default::default(); max_depth as usize + 1] }
    }

    /// Adds what another part of the render saw.
    pub fn add(&mut self, other: &Survey) {
        for (sum, other) in self.depths.iter_mut().flatten().zip(other.depths.iter().flatten()) {
            sum.add(other);
        }
    }

    /// Notes a call of a stage.
    pub fn call(&mut self, (stage, depth, source): (Stage, u32, RaySource), rays: usize) {
        let calls = &mut self.depths[depth as usize][source as usize].stages[stage as usize];
        calls.calls += 1;
        calls.registers += rays.div_ceil(LANES) as u64;
    }

    /// Looks at rays and what they met.
    pub fn look(
        &mut self,
        context: &Context<'_>,
        (depth, source): (u32, RaySource),
        (rays, samples): (PathRaysView<'_>, SamplesView<'_>),
        hits: HitsView<'_>,
    ) {
        let at = &mut self.depths[depth as usize][source as usize];
        at.taken += 1;
        at.rays += rays.len() as u64;
        at.lengths[rays.len().max(1).ilog2() as usize] += 1;
        at.octant_runs += runs((0..rays.len()).map(|row| octant(&rays.get(row))));
        let materials = context.scene.instances.view().material;
        at.material_runs += runs(hits.instance.iter().map(|&instance| match instance {
            NO_INSTANCE => u32::MAX,
            instance => materials[instance as usize].0,
        }));
        for row in 0..rays.len() {
            let ray = rays.get(row).ray(samples.time(context, rays.sample[row]));
            add(&mut at.visits, visits(&context.geometry, &ray));
        }
    }

    /// Looks at rays toward lights, which hits of rays of a depth and queue have sent.
    pub fn look_toward_lights(
        &mut self,
        context: &Context<'_>,
        (depth, source): (u32, RaySource),
        (queue, samples): (&ShadowQueue, SamplesView<'_>),
    ) {
        let at = &mut self.depths[depth as usize][source as usize];
        let rays = queue.view();
        at.shadow_rays += rays.len() as u64;
        for row in 0..rays.len() {
            let ray = rays.get(row);
            let visits =
                visits_until_blocked(&context.geometry, &ray.ray(samples.time(context, ray.sample)), ray.distance);
            add(&mut at.shadow_visits, visits);
        }
    }
}

/// Adds what one ray looked at.
fn add(sums: &mut [u64; 3], Visits { nodes, instances, primitives }: Visits) {
    sums.iter_mut().zip([nodes, instances, primitives]).for_each(|(sum, number)| *sum += u64::from(number));
}

/// How often a value differs from the one before it; the first one does.
fn runs<T: PartialEq>(values: impl Iterator<Item = T>) -> u64 {
    let (mut last, mut runs) = (None, 0);
    for value in values {
        let value = Some(value);
        runs += u64::from(value != last);
        last = value;
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_begin_where_a_value_changes() {
        for (values, expected) in [(&[][..], 0), (&[3], 1), (&[3, 3, 3], 1), (&[1, 2, 2, 1], 3), (&[1, 2, 3], 3)] {
            assert_eq!(runs(values.iter()), expected, "{values:?}");
        }
    }

    /// By hand: 40 rays fill two registers and half of a third one.
    #[test]
    fn a_call_fills_registers() {
        let mut survey = Survey::new(1);
        let at = (Stage::Trace, 1, RaySource::Reflection);
        survey.call(at, 40);
        survey.call(at, 16);
        let mut twice = survey.clone();
        twice.add(&survey);
        let calls = twice.depths[1][RaySource::Reflection as usize].stages[Stage::Trace as usize];
        assert_eq!(calls, Calls { calls: 4, registers: 8 });
    }
}
