//! The steps that all kinds of material take where rays arrive, over a block of rows at a time.
//!
//! Each step is a loop over the block's columns that calls a routine of one row, so that where the routine has no branches it becomes
//! vector code; what goes on is gathered behind each step, without branches, too.

#![expect(clippy::needless_range_loop, reason = "what belongs to a row stands in many columns")]

use std::num::Wrapping;

use brewster_buffers::LightSample;
use brewster_optics::lobe::{DELTA, LobeSplit, LobeValue, power_heuristic};
use glam::{Vec2, Vec3};

use super::block::{Chosen, Guidance, Lights, Loads, Places, Rows};
use super::{Scatter, Surface, roulette};
use crate::context::Context;
use crate::ledger::{Ledger, units};
use crate::media::{MediaId, MediaStacks};
use crate::queues::{Contribution, End, Event, PathRaysView, ShadowRaysView};
use crate::stages::vectors::{Vectors, count};
use crate::stages::{Numbers, Outlet};
use crate::stats::Counts;

/// A block of rays where they arrive.
struct Arrivals<'a, 'b, S, R, const N: usize> {
    context: &'b Context<'a>,
    rows: &'b R,
    counted: [bool; N],
    places: &'b Places<N>,
    loads: &'b Loads<N>,
    surfaces: &'b [S; N],
    guidance: &'b Guidance<'b, N>,
}

/// What kinds of material do where a block of rays arrives.
#[inline(always)]
pub(crate) fn scatter_block<Kind: Scatter, R: Rows, const N: usize>(
    context: &Context<'_>,
    rows: &R,
    outlet: &mut impl Outlet,
    stacks: &mut MediaStacks,
    counts: &mut Counts,
) {
    let places = Places::<N>::new(rows);
    let mut loads = Loads::<N>::NONE;
    let mut counted = [true; N];
    let mut surfaces = [loads.take::<Kind>(context, rows, 0, &places, stacks); N];
    for row in 1..N {
        surfaces[row] = loads.take::<Kind>(context, rows, row, &places, stacks);
        counted[row] = row < rows.len();
    }
    let (places, loads, surfaces) = (&places, &loads, &surfaces);
    let guidance = &Guidance::new(context, surfaces, places);
    let arrivals = Arrivals { context, rows, counted, places, loads, surfaces, guidance };
    arrivals.toward_lights(stacks, outlet);
    let sent = arrivals.onward(outlet, counts);
    if context.albedos.is_some() {
        arrivals.book(&sent, &mut counts.ledger);
    }
}

impl<S: Surface, R: Rows, const N: usize> Arrivals<'_, '_, S, R, N> {
    /// Samples a light and the background.
    #[inline(always)]
    fn toward_lights(&self, stacks: &MediaStacks, outlet: &mut impl Outlet) {
        let scene = self.context.scene;
        if !scene.emitters.is_empty() {
            self.toward::<false>(stacks, outlet);
        }
        if scene.background.drawn().is_some() {
            self.toward::<true>(stacks, outlet);
        }
    }

    /// The light that was drawn for a row: of a source, or of the sky.
    #[inline(always)]
    fn light<const SKY: bool>(&self, row: usize) -> Option<LightSample> {
        let (scene, numbers) = (self.context.scene, self.rows.numbers(row));
        if SKY {
            return numbers.sky(scene.background.drawn()?);
        }
        let hit = self.rows.hit(row);
        numbers.light(scene, hit.point.position, hit.time)
    }

    /// Sends shadow rays toward lights, but where the surfaces do not scatter from there.
    #[inline(always)]
    fn toward<const SKY: bool>(&self, stacks: &MediaStacks, outlet: &mut impl Outlet) {
        let Arrivals { context, surfaces, places, loads, .. } = *self;
        let mut lights = Lights::<N>::NONE;
        for row in 0..N {
            if self.counted[row]
                && !surfaces[row].is_smooth()
                && let Some(light) = self.light::<SKY>(row)
            {
                lights.set(row, &light);
            }
        }
        let (mut open, mut values, mut scattered) = ([false; N], Vectors::<N>::ZERO, [0.0; N]);
        for row in 0..N {
            let direction = lights.directions.get(row);
            let toward = places.frame(row).to_local(direction);
            open[row] = lights.there[row] & self.is_open(row, direction, toward);
            let value =
                if open[row] { surfaces[row].evaluate(places.views.get(row), toward) } else { LobeValue::BLACK };
            scattered[row] = if self.splits() { value.pdf } else { value.chosen_pdf() };
            values.set(row, value.f_cos);
        }
        self.guidance.mix(&open, &lights.directions, &mut scattered);
        let (mut goes, mut contributions) = ([false; N], Vectors::<N>::ZERO);
        for row in 0..N {
            let light = lights.get(row);
            let share = if light.is_delta { 1.0 } else { power_heuristic(light.pdf, scattered[row]) };
            let contribution = loads.weights.get(row) * values.get(row) * light.radiance * (share / light.pdf);
            contributions.set(row, contribution);
            goes[row] = open[row] & (contribution != Vec3::ZERO);
        }
        if count(&goes) == 0 {
            return;
        }
        let (mut origins, mut directions, mut distances) = (Vectors::<N>::ZERO, Vectors::<N>::ZERO, [0.0; N]);
        let (mut media, mut contribution) = ([MediaId::VACUUM; N], [Vec3::ZERO; N]);
        for row in 0..N {
            let light = lights.get(row);
            let origin = places.origin(context, row, light.direction);
            let (direction, distance) = light.ray_from(origin);
            origins.set(row, origin);
            directions.set(row, direction);
            distances[row] = distance;
        }
        for row in 0..N {
            media[row] = self.media_of(row, lights.directions.get(row));
            let scale = context.radiance_scale(stacks, media[row], loads.wavelengths[row]);
            contribution[row] = contributions.get(row) * scale;
        }
        let ([origin_x, origin_y, origin_z], [direction_x, direction_y, direction_z]) = (&origins.0, &directions.0);
        let rays = ShadowRaysView {
            origin_x,
            origin_y,
            origin_z,
            direction_x,
            direction_y,
            direction_z,
            distance: &distances,
            contribution: &contribution,
            sample: &loads.samples,
            trail: &loads.trails,
            instance: &loads.instances,
            media: &media,
            passes_sheets: &lights.is_delta,
        };
        outlet.shadow_marked(rays, &goes);
    }

    /// Sends the paths on; tells the weights of what was scattered, before roulette.
    #[inline(always)]
    fn onward(&self, outlet: &mut impl Outlet, counts: &mut Counts) -> [Vectors<N>; 2] {
        let Arrivals { surfaces, places, loads, .. } = *self;
        let ([mut xs, mut ys, mut lobes], mut directed) = ([[0.0; N]; 3], [false; N]);
        for row in 0..N {
            let numbers = self.rows.numbers(row);
            (xs[row], ys[row]) = numbers.direction().into();
            (directed[row], lobes[row]) = self.guidance.part(row, numbers.lobe());
        }
        let numbers = (&directed, &lobes, [&xs, &ys]);
        let mut first = Chosen::<N> { asked: self.counted, ..Chosen::NOTHING };
        if !self.splits() {
            for row in 0..N {
                let (view, u) = (places.views.get(row), Vec2::new(xs[row], ys[row]));
                first.set(row, surfaces[row].choose(view, u, lobes[row]), loads.branches[row]);
            }
            self.guidance.direct((surfaces, places), numbers, &mut first);
            return [self.send(&first, outlet, counts), Vectors::<N>::ZERO];
        }
        let mut second = Chosen::<N>::NOTHING;
        for row in 0..N {
            let (view, u) = (places.views.get(row), Vec2::new(xs[row], ys[row]));
            let LobeSplit { reflection, transmission, reflectance } = surfaces[row].split(view, u, lobes[row]);
            let (branch, branches) = (loads.branches[row], reflectance != 1.0);
            let reflected = if branches { branch.wrapping_mul(2) } else { branch };
            first.set(row, reflection, reflected);
            second.set(row, transmission, reflected.wrapping_add(1));
            second.asked[row] = branches & self.counted[row];
        }
        counts.branched += count(&second.asked);
        self.guidance.direct((surfaces, places), numbers, &mut first);
        [self.send(&first, outlet, counts), self.send(&second, outlet, counts)]
    }

    /// Puts rays into their queues, but those that are absorbed or given up; tells the weights of what was scattered.
    #[inline(always)]
    fn send(&self, chosen: &Chosen<N>, outlet: &mut impl Outlet, counts: &mut Counts) -> Vectors<N> {
        let Arrivals { context, places, loads, .. } = *self;
        let (mut scattered, mut directions) = (Vectors::<N>::ZERO, Vectors::<N>::ZERO);
        let (mut broken, mut below, mut open, mut light) = ([false; N], [false; N], [false; N], [false; N]);
        let asked = self.asked_by_roulette(chosen);
        for row in 0..N {
            let weight = if chosen.there[row] { loads.weights.get(row) * chosen.weights.get(row) } else { Vec3::ZERO };
            let finite = weight.is_finite();
            let goes = chosen.asked[row] & finite & (weight.max_element() > 0.0);
            let local = chosen.directions.get(row);
            let direction = places.frame(row).to_world(local);
            let is_open = self.is_open(row, direction, local);
            broken[row] = chosen.asked[row] & !finite;
            below[row] = goes & !is_open;
            open[row] = goes & is_open;
            light[row] = open[row] & asked[row] & roulette::is_asked(weight * chosen.densities[row]);
            scattered.set(row, if goes { weight } else { Vec3::ZERO });
            directions.set(row, direction);
        }
        self.tell_broken(&broken, chosen, outlet);
        let mut luck = [0.0; N];
        for row in 0..N {
            if light[row] {
                luck[row] = self.rows.numbers(row).roulette();
            }
        }
        let (mut weights, mut gone, mut onward) = (scattered, [false; N], [false; N]);
        for row in 0..N {
            let weight = scattered.get(row);
            let spared =
                if light[row] { roulette::spared(weight, chosen.densities[row], luck[row]) } else { Some(weight) };
            weights.set(row, spared.unwrap_or(Vec3::ZERO));
            gone[row] = spared.is_none();
            onward[row] = open[row] & !gone[row];
        }
        let [reflections, transmissions] = self.depart(chosen, [&weights, &directions], &onward, outlet);
        let given_up = count(&gone);
        counts.reflections += reflections;
        counts.transmissions += transmissions;
        counts.given_up += given_up;
        counts.absorbed += count(&chosen.asked) - given_up - reflections - transmissions;
        if context.albedos.is_some() {
            enter_sent([&scattered, &weights], [&below, &gone, &onward], &mut counts.ledger);
        }
        scattered
    }

    /// Which rows roulette may end: none, or all but those that were directed to where they now go on, for the light that they look for
    /// makes up for their little weight.
    #[inline(always)]
    fn asked_by_roulette(&self, chosen: &Chosen<N>) -> [bool; N] {
        let mut asked = [self.context.scene.settings.roulette; N];
        if self.context.guide.is_some() {
            for row in 0..N {
                asked[row] &= !(chosen.pdfs[row] == DELTA && self.loads.trails[row].is_guided());
            }
        }
        asked
    }

    /// Puts those rays into their queues that are marked; tells how many went into each.
    #[inline(always)]
    fn depart(
        &self,
        chosen: &Chosen<N>,
        [weights, directions]: [&Vectors<N>; 2],
        onward: &[bool; N],
        outlet: &mut impl Outlet,
    ) -> [u64; 2] {
        let Arrivals { context, places, loads, .. } = *self;
        let (mut origins, mut reflects, mut transmits) = (Vectors::<N>::ZERO, [false; N], [false; N]);
        for row in 0..N {
            origins.set(row, places.origin(context, row, directions.get(row)));
            let through = chosen.directions.0[2][row] < 0.0;
            (reflects[row], transmits[row]) = (onward[row] & !through, onward[row] & through);
        }
        let (mut weight, mut media, mut trail) = ([Vec3::ZERO; N], [MediaId::VACUUM; N], loads.trails);
        for row in 0..N {
            let event = match (transmits[row], chosen.pdfs[row] == DELTA) {
                (false, true) => Event::Mirrored,
                (true, true) => Event::Refracted,
                (false, false) if self.guidance.directs(row) => Event::Guided,
                (false, false) => Event::Spread,
                (true, false) => Event::SpreadThrough,
            };
            trail[row] = loads.trails[row].then(event);
            weight[row] = weights.get(row);
            media[row] = self.media_of(row, directions.get(row));
        }
        let ([origin_x, origin_y, origin_z], [direction_x, direction_y, direction_z]) = (&origins.0, &directions.0);
        let sent = PathRaysView {
            origin_x,
            origin_y,
            origin_z,
            direction_x,
            direction_y,
            direction_z,
            weight: &weight,
            pdf: &chosen.pdfs,
            sample: &loads.samples,
            trail: &trail,
            instance: &loads.instances,
            media: &media,
            wavelength: &loads.wavelengths,
            branch: &chosen.branches,
        };
        let (reflections, transmissions) = (count(&reflects), count(&transmits));
        if reflections > 0 {
            outlet.reflect_marked(sent, &reflects);
        }
        if transmissions > 0 {
            outlet.transmit_marked(sent, &transmits);
        }
        [reflections, transmissions]
    }

    /// Turns what is no number into contributions, which are told to be none.
    #[inline(always)]
    fn tell_broken(&self, broken: &[bool; N], chosen: &Chosen<N>, outlet: &mut impl Outlet) {
        for row in (0..N).filter(|&row| broken[row]) {
            let loads = self.loads;
            let (sample, trail, instance) = (loads.samples[row], loads.trails[row], loads.instances[row]);
            let radiance = loads.weights.get(row) * chosen.weights.get(row);
            outlet.light(Contribution { radiance, sample, trail: trail.end(End::Surface), instance });
        }
    }

    /// Enters into the ledger what arrived, what is expected of it and what became of it. Where nothing is expected, what the sampler
    /// sent is believed.
    #[inline(always)]
    fn book(&self, sent: &[Vectors<N>; 2], ledger: &mut Ledger) {
        let Loads { arrived, weights, albedos, known, .. } = self.loads;
        for channel in 0..3 {
            let [mut scattered, mut recolored, mut absorbed, mut residual, mut squares] = [Wrapping(0); 5];
            for row in 0..N {
                let counted = |value: f32| units(if self.counted[row] { value } else { 0.0 });
                let (before, weight) = (arrived.0[channel][row], weights.0[channel][row]);
                let (first, second) = (sent[0].0[channel][row], sent[1].0[channel][row]);
                let expected = if known[row] { weight * albedos.0[channel][row] } else { first + second };
                let off = expected - first - second;
                scattered += counted(before);
                recolored += counted(weight) - counted(before);
                absorbed += counted(weight) - counted(expected);
                residual += counted(expected) - counted(first) - counted(second);
                squares += counted(off * off);
            }
            ledger.scattered.add_units(channel, scattered);
            ledger.recolored.add_units(channel, recolored);
            ledger.absorbed.add_units(channel, absorbed);
            ledger.residual.add_units(channel, residual);
            ledger.residual_squares.add_units(channel, squares);
        }
    }

    /// Whether the paths send a ray into each queue here.
    #[inline(always)]
    fn splits(&self) -> bool {
        self.rows.depth() < self.context.scene.settings.split_depth
    }

    /// The media around a ray that leaves a surface.
    #[inline(always)]
    fn media_of(&self, row: usize, direction: Vec3) -> MediaId {
        self.loads.media[row][usize::from(direction.dot(self.places.geometric.get(row)) < 0.0)]
    }

    /// Whether light may go this way: what shading normals send below an opaque surface is dropped. Through others it goes
    /// on, on the side where it is.
    #[inline(always)]
    fn is_open(&self, row: usize, direction: Vec3, local: Vec3) -> bool {
        self.loads.transmits[row] | ((direction.dot(self.places.geometric.get(row)) > 0.0) == (local.z > 0.0))
    }
}

/// Enters into the ledger what became of what was scattered: of the rows whose paths stay below the surface, that are gone by roulette,
/// and that go on.
#[inline(always)]
fn enter_sent<const N: usize>(
    [scattered, weights]: [&Vectors<N>; 2],
    [below, gone, onward]: [&[bool; N]; 3],
    ledger: &mut Ledger,
) {
    for channel in 0..3 {
        let [mut lost, mut removed, mut before, mut after] = [Wrapping(0); 4];
        for row in 0..N {
            let (scattered, weight) = (scattered.0[channel][row], weights.0[channel][row]);
            let of = |value: f32, mark: bool| units(if mark { value } else { 0.0 });
            lost += of(scattered, below[row]);
            removed += of(scattered, gone[row]);
            before += of(scattered, onward[row]);
            after += of(weight, onward[row]);
        }
        ledger.below_surface.add_units(channel, lost);
        ledger.roulette_removed.add_units(channel, removed);
        ledger.roulette_added.add_units(channel, after - before);
        ledger.onward.add_units(channel, after);
    }
}
