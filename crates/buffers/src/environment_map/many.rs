//! Lookups of many directions at once, so that they wait for memory together.

use brewster_lanes::{Level, dispatch, prefetch};
use glam::Vec3;

use super::{Drawn, EnvironmentMap, Place};
use crate::LightSample;
use crate::distribution::Cell;

/// Directions that are looked up together.
pub const SKY_RUN: usize = 16;

impl EnvironmentMap {
    /// [`EnvironmentMap::radiance`] of some directions.
    pub(crate) fn radiance_all(&self, level: Level, directions: &[Vec3; SKY_RUN], radiance: &mut [Vec3; SKY_RUN]) {
        let places = self.places(level, directions);
        for lane in 0..SKY_RUN {
            radiance[lane] = self.radiance_at(places[lane]);
        }
    }

    /// [`EnvironmentMap::pdf`] of some directions.
    pub(crate) fn pdf_all(&self, level: Level, directions: &[Vec3; SKY_RUN], pdfs: &mut [f32; SKY_RUN]) {
        let Some(cells) = &self.cells else { return pdfs.fill(0.0) };
        let places = self.places(level, directions);
        for Place { column, band, .. } in places {
            cells.expect(column, band);
        }
        for lane in 0..SKY_RUN {
            pdfs[lane] = self.pdf_at(cells, places[lane], directions[lane]);
        }
    }

    /// [`EnvironmentMap::sample`] for many.
    pub fn sample_all(&self, level: Level, u: [&[f32]; 2], samples: &mut [Option<LightSample>]) {
        let Some(cells) = &self.cells else { return samples.fill(None) };
        for (run, samples) in samples.chunks_mut(SKY_RUN).enumerate() {
            let mut chosen = [Cell::default(); SKY_RUN];
            let u = u.map(|u| &u[run * SKY_RUN..][..samples.len()]);
            cells.choose_all(u, &mut chosen[..samples.len()]);
            chosen.iter().for_each(|cell| self.expect(cell.x, cell.y));
            let mut drawn = DrawnCells([[0.0; SKY_RUN]; 11]);
            for (lane, cell) in chosen.iter().enumerate() {
                drawn.put(lane, self.drawn(*cell));
            }
            let (mut directions, mut pdfs) = ([Vec3::Y; SKY_RUN], [0.0; SKY_RUN]);
            find_directions(level, self, &drawn, &mut directions, &mut pdfs);
            let mut radiance = [Vec3::ZERO; SKY_RUN];
            self.radiance_all(level, &directions, &mut radiance);
            for (lane, sample) in samples.iter_mut().enumerate() {
                *sample = Some(LightSample::distant(directions[lane], radiance[lane], pdfs[lane]));
            }
        }
    }

    /// The places of directions, whose pixels the cache is asked for.
    #[inline(always)]
    fn places(&self, level: Level, directions: &[Vec3; SKY_RUN]) -> [Place; SKY_RUN] {
        let mut places = [Place::default(); SKY_RUN];
        find_places(level, self, directions, &mut places);
        for Place { column, band, .. } in places {
            self.expect(column, band);
        }
        places
    }

    /// Asks the cache for the pixels at the corners of a cell.
    #[inline(always)]
    fn expect(&self, column: u32, band: u32) {
        let pixels = self.image.floats().as_ptr();
        let (upper, lower) = self.rows_around(band);
        prefetch(pixels.wrapping_add(self.pixel(column, upper)));
        prefetch(pixels.wrapping_add(self.pixel(column, lower)));
    }
}

/// The numbers of [`Drawn`] in columns.
struct DrawnCells([[f32; SKY_RUN]; 11]);

impl DrawnCells {
    #[inline(always)]
    fn put(&mut self, lane: usize, cell: Drawn) {
        let Drawn { column, rest: [r, s], weights: [a, b, c, d], near, far, side, probability } = cell;
        for (numbers, number) in self.0.iter_mut().zip([column, r, s, a, b, c, d, near, far, side, probability]) {
            numbers[lane] = number;
        }
    }

    #[inline(always)]
    fn get(&self, lane: usize) -> Drawn {
        let [column, r, s, a, b, c, d, near, far, side, probability] = &self.0;
        Drawn {
            column: column[lane],
            rest: [r[lane], s[lane]],
            weights: [a[lane], b[lane], c[lane], d[lane]],
            near: near[lane],
            far: far[lane],
            side: side[lane],
            probability: probability[lane],
        }
    }
}

dispatch! {
    fn find_directions<'a>(
        map: &'a EnvironmentMap,
        cells: &'a DrawnCells,
        directions: &'a mut [Vec3; SKY_RUN],
        pdfs: &'a mut [f32; SKY_RUN],
    ) {
        let [mut x, mut y, mut z] = [[0.0; SKY_RUN]; 3];
        for lane in 0..SKY_RUN {
            let (direction, pdf) = map.direction_in(&cells.get(lane));
            (x[lane], y[lane], z[lane], pdfs[lane]) = (direction.x, direction.y, direction.z, pdf);
        }
        for lane in 0..SKY_RUN {
            directions[lane] = Vec3::new(x[lane], y[lane], z[lane]);
        }
    }
}

dispatch! {
    fn find_places<'a>(map: &'a EnvironmentMap, directions: &'a [Vec3; SKY_RUN], places: &'a mut [Place; SKY_RUN]) {
        for lane in 0..SKY_RUN {
            places[lane] = map.place(directions[lane]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{EVERY, map, noise};
    use super::*;
    use crate::MapRows;
    use crate::statistics::Random;

    #[test]
    fn many_are_drawn_as_each_by_itself() {
        for (rows, rotation) in EVERY {
            let map = map([37, 19], rows, rotation, noise);
            let mut random = Random::new(5);
            let [u, v] = [(); 2].map(|()| (0..77).map(|_| random.unit()).collect::<Vec<f32>>());
            let mut samples = vec![None; 77];
            map.sample_all(Level::detect(), [&u, &v], &mut samples);
            for (sample, u) in samples.iter().zip(u.iter().zip(&v).map(|(&u, &v)| [u, v])) {
                assert_eq!(*sample, map.sample(u), "{rows:?}, {rotation}, {u:?}");
                assert!(sample.is_some());
            }
        }
        let black = map([3, 3], MapRows::Poles, 0.0, |_, _| Vec3::ZERO);
        let mut samples = [EnvironmentMap::sample(&map([3, 3], MapRows::Poles, 0.0, noise), [0.5; 2])];
        black.sample_all(Level::detect(), [&[0.5], &[0.5]], &mut samples);
        assert_eq!(samples, [None]);
    }

    #[test]
    fn many_are_looked_up_as_each_by_itself() {
        let mut random = Random::new(7);
        for (rows, rotation) in EVERY {
            let map = map([37, 19], rows, rotation, noise);
            let mut directions = [(); SKY_RUN].map(|()| random.direction());
            directions[..3].copy_from_slice(&[Vec3::Y, Vec3::NEG_Y, Vec3::NEG_X]);
            let (mut radiance, mut pdfs) = ([Vec3::ZERO; SKY_RUN], [0.0; SKY_RUN]);
            map.radiance_all(Level::detect(), &directions, &mut radiance);
            map.pdf_all(Level::detect(), &directions, &mut pdfs);
            assert_eq!(radiance, directions.map(|direction| map.radiance(direction)), "{rows:?}, {rotation}");
            assert_eq!(pdfs, directions.map(|direction| map.pdf(direction)), "{rows:?}, {rotation}");
        }
    }
}
