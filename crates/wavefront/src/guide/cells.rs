//! Cells of photons that lie near each other, and the directions that these came from.

use std::f32::consts::{PI, TAU};

use brewster_geometry::Aabb;
use brewster_lanes::math;
use brewster_optics::basis::Basis;
use glam::{Vec2, Vec3};

use crate::stages::{LANES, Vectors};

/// Light that came to a surface that scatters, by way of what is smooth.
#[derive(Clone, Copy, Debug)]
pub(super) struct Photon {
    /// Where.
    pub(super) position: Vec3,
    /// The unit direction that it came from.
    pub(super) toward: Vec3,
    /// Its power times the number of photons that were sent, in lumens.
    pub(super) power: f32,
    /// Its radiance.
    pub(super) radiance: f32,
    /// An estimate of the irradiance of the place by light that other scattered rays find.
    pub(super) others: f32,
}

/// Photons by place: a binary tree with cells for leaves.
#[derive(Clone, Debug)]
pub(crate) struct Cells {
    nodes: Vec<Node>,
    /// Steps from the root to the leaf that lies deepest.
    depth: u32,
    cells: Vec<Cell>,
    directions: Vec<Directions>,
}

/// Points whose coordinate on the axis is less than `split` are in the first child, others in the second. A leaf is its own children.
#[derive(Clone, Copy, Debug)]
struct Node {
    split: f32,
    axis: u32,
    children: [u32; 2],
    cell: u32,
}

/// A place where rays are directed.
#[derive(Clone, Debug)]
pub(crate) struct Cell {
    /// Around its photons, and a little more.
    bounds: Aabb,
    /// Its rows of directions.
    first: u32,
    photons: u32,
    /// How wide rays are spread around the directions of photons: half of them at less than this, as 1 - cosθ.
    width: f32,
    /// The part of the rays that is directed; 0 where none is.
    pub(crate) share: f32,
}

/// The unit directions of some photons of a cell. Where there are fewer, the others are zero.
#[derive(Clone, Copy, Debug)]
struct Directions {
    xyz: [[f32; LANES]; 3],
    there: [f32; LANES],
}

/// Photons of a cell at most.
const MOST: usize = 2 * LANES;

/// Fewer photons than this make no guide.
const LEAST: usize = 4 * MOST;

/// The part of a cell's rays that is directed at most.
const MOST_SHARE: f32 = 0.9;

/// The second moment of what directed rays find of a caustic, as a multiple of its square: directions miss it, and lie more densely here than there.
const MISSES: f32 = 4.0;

/// Around a photon's direction rays are spread so far that half of them lie nearer than this part of the cell's photons; not less than 2.6°.
const NEAR: usize = 8;
const LEAST_WIDTH: f32 = 1e-3;

impl Cells {
    /// Cells of photons, of which `sent` were sent. None if there are too few.
    pub(super) fn new(photons: &[Photon], sent: u64) -> Option<Cells> {
        let (mut photons, power) = evened(photons);
        if photons.len() < LEAST {
            return None;
        }
        let mut cells = Cells { nodes: Vec::new(), depth: 0, cells: Vec::new(), directions: Vec::new() };
        cells.grow(&mut photons, 0, power / sent as f32);
        cells.cells.iter().any(|cell| cell.share > 0.0).then_some(cells)
    }

    pub(super) fn kept(&self) -> usize {
        self.cells.iter().map(|cell| cell.photons as usize).sum()
    }

    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.nodes) + size_of_val(&*self.cells) + size_of_val(&*self.directions)
    }

    /// Adds the tree of photons of some power each.
    fn grow(&mut self, photons: &mut [Photon], depth: u32, power: f32) {
        let bounds = Aabb::around(photons.iter().map(|photon| photon.position));
        let size = bounds.max - bounds.min;
        let at = self.nodes.len();
        self.nodes.push(Node { split: 0.0, axis: 0, children: [at as u32; 2], cell: self.cells.len() as u32 });
        if photons.len() <= MOST || size == Vec3::ZERO {
            self.depth = self.depth.max(depth);
            return self.add(photons, bounds, power);
        }
        let axis = size.max_position();
        photons.sort_unstable_by(|a, b| a.position[axis].total_cmp(&b.position[axis]));
        // Of all that lie in a plane, as on a floor, none is parted from the others.
        let middle = photons[photons.len() / 2].position[axis];
        let before = photons.partition_point(|photon| photon.position[axis] < middle);
        let behind = photons.partition_point(|photon| photon.position[axis] <= middle);
        let (before, behind) = photons.split_at_mut(if before > 0 { before } else { behind });
        let split = behind[0].position[axis];
        let first = self.nodes.len() as u32;
        self.grow(before, depth + 1, power);
        let second = self.nodes.len() as u32;
        self.grow(behind, depth + 1, power);
        self.nodes[at] = Node { split, axis: axis as u32, children: [first, second], cell: 0 };
    }

    fn add(&mut self, photons: &[Photon], bounds: Aabb, power: f32) {
        let count = photons.len() as f32;
        let mut sides = (bounds.max - bounds.min).to_array();
        sides.sort_unstable_by(|a, b| b.total_cmp(a));
        let [long, across, _] = sides;
        let area = (long * across.max(0.1 * long)).max(f32::MIN_POSITIVE);
        // About as much lies between the photons of neighboring cells.
        let gap = 1.5 * long / count.sqrt();
        let (first, photon_count) = (self.directions.len() as u32, photons.len() as u32);
        let cell = Cell {
            bounds: bounds.padded(gap),
            first,
            photons: photon_count,
            width: width(photons),
            share: share(photons, power * count / area),
        };
        self.cells.push(cell);
        for run in photons.chunks(LANES) {
            let mut directions = Directions { xyz: [[0.0; LANES]; 3], there: [0.0; LANES] };
            for (lane, photon) in run.iter().enumerate() {
                directions.there[lane] = 1.0;
                for axis in 0..3 {
                    directions.xyz[axis][lane] = photon.toward[axis];
                }
            }
            self.directions.push(directions);
        }
    }

    /// The cells of points. None where no photon came near.
    #[inline(always)]
    pub(crate) fn find<const N: usize>(&self, points: &Vectors<N>) -> [Option<&Cell>; N] {
        let mut at = [0u32; N];
        for _ in 0..self.depth {
            for (row, at) in at.iter_mut().enumerate() {
                let node = &self.nodes[*at as usize];
                let is_beyond = points.0[node.axis as usize][row] >= node.split;
                *at = node.children[usize::from(is_beyond)];
            }
        }
        let mut found = [None; N];
        for row in 0..N {
            let cell = &self.cells[self.nodes[at[row] as usize].cell as usize];
            let (point, Aabb { min, max }) = (points.get(row), cell.bounds);
            if point.cmpge(min).all() & point.cmple(max).all() & (cell.share > 0.0) {
                found[row] = Some(cell);
            }
        }
        found
    }

    /// The density per solid angle of [`Cells::sample`]: the mean over the photons of `w(w + 2)/(4π (w + x)²)`, where x is 1 - cosθ to the
    /// direction of the photon and w the cell's width.
    #[inline(always)]
    pub(crate) fn pdf(&self, cell: &Cell, direction: Vec3) -> f32 {
        let mut sums = [0.0; LANES];
        let rows = (cell.photons as usize).div_ceil(LANES);
        for directions in &self.directions[cell.first as usize..][..rows] {
            let [x, y, z] = &directions.xyz;
            for lane in 0..LANES {
                let cosine = x[lane] * direction.x + y[lane] * direction.y + z[lane] * direction.z;
                let apart = cell.width + (1.0 - cosine);
                sums[lane] += directions.there[lane] / (apart * apart);
            }
        }
        let mut half = LANES / 2;
        while half > 0 {
            for lane in 0..half {
                sums[lane] += sums[lane + half];
            }
            half /= 2;
        }
        sums[0] * (cell.width * (cell.width + 2.0) / (2.0 * TAU)) / cell.photons as f32
    }

    /// A unit direction near to that of some photon of a cell, by three numbers 0 ≤ u < 1.
    #[inline(always)]
    pub(crate) fn sample(&self, cell: &Cell, choice: f32, u: Vec2) -> Vec3 {
        let photon = ((choice * cell.photons as f32) as usize).min(cell.photons as usize - 1);
        let Directions { xyz: [x, y, z], .. } = &self.directions[cell.first as usize + photon / LANES];
        let lane = photon % LANES;
        let versine = 2.0 * u.x * cell.width / (cell.width + 2.0 - 2.0 * u.x);
        let radius = (versine * (2.0 - versine)).max(0.0).sqrt();
        let (sin, cos) = math::sin_cos(TAU * u.y);
        Basis::around(Vec3::new(x[lane], y[lane], z[lane])).to_world(Vec3::new(
            radius * cos,
            radius * sin,
            1.0 - versine,
        ))
    }
}

/// The part of a cell's rays that makes for the least noise, where the caustic's irradiance is known.
///
/// Of scattered rays alone the caustic, of radiance L and irradiance E, makes a second moment of πLE, and all else one of M. With a share s
/// of directed rays it is `MISSES E²/s + M/(1 - s)`, the least of which is `(√MISSES E + √M)²`. Where that is more than before, none is directed.
fn share(photons: &[Photon], caustic: f32) -> f32 {
    let mean = |of: &dyn Fn(&Photon) -> f32| photons.iter().map(of).sum::<f32>() / photons.len() as f32;
    let radiance = mean(&|photon| photon.radiance);
    let [directed, others] = [MISSES.sqrt() * caustic, mean(&|photon| photon.others * photon.others).sqrt()];
    let pays = directed * directed + 2.0 * directed * others < PI * radiance * caustic;
    if pays { (directed / (directed + others)).min(MOST_SHARE) } else { 0.0 }
}

/// Photons of one power, which is told, in place of some of many powers: as many as these are worth.
fn evened(photons: &[Photon]) -> (Vec<Photon>, f32) {
    let (sum, squares) = photons.iter().fold((0.0, 0.0), |(sum, squares), photon| {
        let power = f64::from(photon.power);
        (sum + power, squares + power * power)
    });
    let step = squares / sum;
    let (mut even, mut next, mut passed) = (Vec::with_capacity(photons.len() + 1), 0.5 * step, 0.0);
    for photon in photons {
        passed += f64::from(photon.power);
        while next < passed {
            even.push(*photon);
            next += step;
        }
    }
    (even, step as f32)
}

/// The width of a cell: what lies between a photon's direction and that of its neighbors, for the photon in the middle.
fn width(photons: &[Photon]) -> f32 {
    let near = (photons.len() / NEAR).max(2).min(photons.len() - 1);
    let mut widths: Vec<f32> = photons
        .iter()
        .map(|photon| {
            let mut apart: Vec<f32> = photons.iter().map(|other| 1.0 - photon.toward.dot(other.toward)).collect();
            *apart.select_nth_unstable_by(near, f32::total_cmp).1
        })
        .collect();
    let middle = widths.len() / 2;
    widths.select_nth_unstable_by(middle, f32::total_cmp).1.clamp(LEAST_WIDTH, 1.0)
}

#[cfg(test)]
mod tests {
    use brewster_optics::warp;

    use super::*;

    /// Photons on a floor and a ceiling, from directions about one for each that is as far from the others as `apart` says.
    fn photons(count: usize, apart: f32) -> Vec<Photon> {
        // Additive recurrences fill squares evenly (M. Roberts 2018).
        let even = |index: usize, step: f32| (0.5 + index as f32 * step).fract();
        (0..count)
            .map(|index| {
                let [x, z, u, v] = [0.755, 0.57, 0.819, 0.671].map(|step| even(index, step));
                let above = index % 3 == 0;
                let toward = warp::cone(Vec2::new(u, v), apart);
                let toward = if above { -toward } else { toward };
                let position = Vec3::new(x, if above { 2.0 } else { -1.0 }, z);
                Photon {
                    position,
                    toward: Vec3::new(toward.x, toward.z, toward.y),
                    power: 1.0,
                    radiance: 1e6,
                    others: 1.0,
                }
            })
            .collect()
    }

    fn found(cells: &Cells, point: Vec3) -> &Cell {
        let [cell] = cells.find(&Vectors::<1>::splat(point));
        cell.unwrap_or_else(|| panic!("{point} has no cell"))
    }

    /// Every photon lies in a cell whose photons came from its side of the room.
    #[test]
    fn floor_and_ceiling_have_cells_of_their_own() {
        let photons = photons(3000, 0.1);
        let cells = Cells::new(&photons, 3000).expect("photons enough");
        assert_eq!(cells.kept(), 3000);
        for photon in &photons {
            let cell = found(&cells, photon.position);
            let density = [photon.toward, -photon.toward].map(|direction| cells.pdf(cell, direction));
            assert!(density[0] > 100.0 * density[1], "{photon:?}: {density:?}");
        }
        let [outside] = cells.find(&Vectors::<1>::splat(Vec3::new(0.5, 0.5, 0.5)));
        assert!(outside.is_none());
    }

    /// The density adds up to one over the sphere, and a band around an axis gets as many samples as it says.
    #[test]
    fn samples_follow_the_density() {
        for apart in [1e-4, 0.02, 0.5] {
            let photons = photons(400, apart);
            let cells = Cells::new(&photons, 400).expect("photons enough");
            let cell = found(&cells, photons[1].position);
            const BANDS: usize = 12;
            const STEPS: usize = 400;
            // The integral over bands of equal steps in the root of 1 + cosθ, which are narrow where the photons came from.
            let band = |y: f32| (BANDS as f32 * (1.0 - (0.5 - 0.5 * y).max(0.0).powf(0.25))) as usize;
            let mut expected = [0.0f64; BANDS];
            for i in 0..STEPS {
                let edge = |i: usize| 1.0 - 2.0 * (i as f64 / STEPS as f64).powi(4);
                let (y, height) = (0.5 * (edge(i) + edge(i + 1)), edge(i) - edge(i + 1));
                for j in 0..STEPS {
                    let (sin, cos) = ((j as f64 + 0.5) / STEPS as f64 * std::f64::consts::TAU).sin_cos();
                    let radius = (1.0 - y * y).sqrt();
                    let direction = Vec3::new((radius * cos) as f32, y as f32, (radius * sin) as f32);
                    let area = height * std::f64::consts::TAU / STEPS as f64;
                    expected[band(y as f32).min(BANDS - 1)] += f64::from(cells.pdf(cell, direction)) * area;
                }
            }
            let sum: f64 = expected.iter().sum();
            assert!((sum - 1.0).abs() < 0.01, "{apart}: {sum}");
            const SAMPLES: u32 = 1 << 16;
            let mut counts = [0u32; BANDS];
            for i in 0..SAMPLES {
                let even = |step: f64| (0.5 + f64::from(i) * step).fract() as f32;
                let u = Vec2::new(even(0.671_043_606_703_789_2), even(0.549_700_477_901_970_3));
                let direction = cells.sample(cell, even(0.819_172_513_396_164_5), u);
                assert!((direction.length() - 1.0).abs() < 1e-5, "{direction}");
                counts[band(direction.y).min(BANDS - 1)] += 1;
            }
            for (count, expected) in counts.into_iter().zip(expected) {
                let part = f64::from(count) / f64::from(SAMPLES);
                assert!((part - expected).abs() < 0.01, "{apart}: {part} of the samples, not {expected}");
            }
        }
    }

    /// What has three times the power becomes three photons of the power of the others.
    #[test]
    fn photons_are_made_even() {
        let mut uneven = photons(600, 0.1);
        uneven.iter_mut().filter(|photon| photon.position.y > 0.0).for_each(|photon| photon.power = 3.0);
        let (even, power) = evened(&uneven);
        let sum = |photons: &[Photon]| photons.iter().map(|photon| f64::from(photon.power)).sum::<f64>();
        let above = even.iter().filter(|photon| photon.position.y > 0.0).count();
        assert!((even.len() as f64 * f64::from(power) / sum(&uneven) - 1.0).abs() < 0.01, "{power}");
        assert!((above as f64 / even.len() as f64 - 0.6).abs() < 0.01, "{above} of {}", even.len());
    }
}
