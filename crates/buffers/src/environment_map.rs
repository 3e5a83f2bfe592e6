//! Pictures of the whole sky: looked up between pixels, and drawn from in proportion to what they show.
//!
//! A direction d lies at u = atan2(d.z, d.x)/2π + ½ and v = acos(d.y)/π, as glTF's viewers have it: v = 0 at the top, u = ½
//! toward +X and ¼ toward -Z. Columns stand at (i+½)/width and wrap around. Rows are as [`MapRows`] says. A rotation turns the
//! picture about +Y, counterclockwise seen from above. Mitsuba's pictures, for which u = atan2(d.x, -d.z)/2π, are those with a
//! rotation of -90° and rows at the poles.
//!
//! Drawn is what is brighter than the mean: the rest is as good as even, and the directions in which surfaces scatter find it with
//! less noise (Karlík et al., "MIS compensation", 2019). A picture that is even is not drawn from at all.
//!
//! The picture is cut into cells, each between four neighboring pixels, so that in a cell one bilinear function counts. A cell is
//! drawn by the mean of what its corners have above the picture's mean luminance, times its solid angle; the place in it, by the
//! bilinear function of its corners over longitude and height, where equal areas are equal solid angles. What is looked up is
//! bilinear over longitude and angle: at most twice as much in the band beside a polar one, and hardly more elsewhere. In a polar
//! band the corners at the pole count at least half of those below: without that, places near a dark pole would be rarer than their
//! light, without bound; with it there is at most 1.21 times as much light above the mean as the density makes of it.

mod many;

use std::f32::consts::{FRAC_1_PI, PI, TAU};
use std::fmt;
use std::sync::Arc;

use brewster_lanes::math;
use brewster_optics::color::luminance;
use glam::Vec3;

use crate::distribution::Cell;
use crate::{Distribution2d, Image, LightSample};

pub use self::many::SKY_RUN;

/// Where the rows of a map lie.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MapRows {
    /// At v = (r+½)/height; the first and the last reach to the poles.
    #[default]
    Centers,
    /// At v = r/(height-1): the first and the last are the poles.
    Poles,
}

/// Why a picture is no map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MapError {
    /// It has no pixels, another number of them than its size says, or more than 2²⁸.
    Size,
    /// It has one row, which cannot be at both poles.
    OneRow,
    /// A pixel is negative, not finite, or above 10³⁰.
    Pixel {
        /// Its column.
        x: u32,
        /// Its row.
        y: u32,
    },
    /// The rotation is not finite, or more than a million.
    Rotation,
}

impl fmt::Display for MapError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            MapError::Size => write!(f, "the picture is empty, too large, or not as large as it says"),
            MapError::OneRow => write!(f, "a picture with rows at the poles needs two rows"),
            MapError::Pixel { x, y } => write!(f, "pixel ({x}, {y}) is negative, not finite or above 1e30"),
            MapError::Rotation => write!(f, "the rotation is not finite, or too large"),
        }
    }
}

impl std::error::Error for MapError {}

/// The brightest radiance of a pixel: sums of some keep below f32's limit.
const BRIGHTEST: f32 = 1e30;

/// A picture of the whole sky, prepared to be drawn from: 5 bytes a pixel beside the picture, and once a pass over it.
#[derive(Clone, Debug, PartialEq)]
pub struct EnvironmentMap {
    image: Arc<Image>,
    rows: MapRows,
    rotation: f32,
    /// 1 - cosθ at the upper edge of each band of cells, and at the south pole; symmetric about the equator.
    edges: Vec<f32>,
    /// None if the picture is even.
    cells: Option<Distribution2d>,
    /// The mean luminance over all directions, and what rounding may have taken from it; what is above is drawn.
    even: f32,
}

/// A place in the picture.
#[derive(Clone, Copy, Default)]
struct Place {
    column: u32,
    band: u32,
    /// How far toward the next column.
    across: f32,
    /// How far down the band, by angle.
    down: f32,
}

/// A cell that was drawn, and what a direction in it follows from.
struct Drawn {
    column: f32,
    rest: [f32; 2],
    /// What places are drawn by at its corners.
    weights: [f32; 4],
    /// 1 - |cosθ| at its edges, first at the one nearer to a pole.
    near: f32,
    far: f32,
    /// 1 above the equator, -1 below.
    side: f32,
    probability: f32,
}

impl EnvironmentMap {
    /// The map of a picture whose pixels are radiance in nit, decoded from sRGB if they are not linear already, turned by `rotation` radians about +Y.
    pub fn new(image: Arc<Image>, rows: MapRows, rotation: f32) -> Result<EnvironmentMap, MapError> {
        let (width, height) = (image.width, image.height);
        if !image.is_sound() || image.texels.len() + width as usize > 1 << 28 {
            return Err(MapError::Size);
        }
        let image = image.to_floats();
        if rows == MapRows::Poles && height < 2 {
            return Err(MapError::OneRow);
        }
        if !rotation.is_finite() || rotation.abs() > 1e6 {
            return Err(MapError::Rotation);
        }
        let is_bad = |pixel: &[f32; 3]| pixel.iter().any(|channel| !(0.0..=BRIGHTEST).contains(channel));
        if let Some(index) = image.floats().iter().position(is_bad) {
            let index = index as u32;
            return Err(MapError::Pixel { x: index % width, y: index / width });
        }
        let bands = bands(height, rows);
        let edges = (0..=bands).map(|edge| versine(edge_angle(edge, height, rows))).collect();
        let mut map = EnvironmentMap { image, rows, rotation, edges, cells: None, even: 0.0 };
        map.even = map.mean_luminance() * (1.0 + 1e-5);
        map.cells = Distribution2d::new(width, bands, |column, band| {
            map.corner_weights(column, band).iter().map(|&weight| f64::from(weight)).sum::<f64>()
                * f64::from(map.band_height(band))
        });
        Ok(map)
    }

    /// The picture.
    pub fn image(&self) -> &Arc<Image> {
        &self.image
    }

    /// Where its rows lie.
    pub fn rows(&self) -> MapRows {
        self.rows
    }

    /// By how much it is turned about +Y, in radians.
    pub fn rotation(&self) -> f32 {
        self.rotation
    }

    /// Whether no light comes from anywhere.
    pub fn is_black(&self) -> bool {
        self.image.floats().iter().all(|&pixel| pixel == [0.0; 3])
    }

    /// Whether directions are drawn from it.
    #[inline(always)]
    pub fn is_drawn(&self) -> bool {
        self.cells.is_some()
    }

    /// The radiance from a unit direction.
    #[inline]
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        self.radiance_at(self.place(direction))
    }

    #[inline(always)]
    fn radiance_at(&self, Place { column, band, across, down }: Place) -> Vec3 {
        bilinear(self.corners(column, band), across, down)
    }

    /// Draws a direction with two numbers 0 ≤ u < 1; none if the map is not drawn from.
    #[inline]
    pub fn sample(&self, u: [f32; 2]) -> Option<LightSample> {
        let (direction, pdf) = self.direction_in(&self.drawn(self.cells.as_ref()?.choose(u)));
        Some(LightSample::distant(direction, self.radiance(direction), pdf))
    }

    /// What a direction in a cell follows from.
    #[inline(always)]
    fn drawn(&self, cell: Cell) -> Drawn {
        let (near, far) = self.folded_edges(cell.y);
        Drawn {
            column: cell.x as f32,
            rest: cell.rest,
            weights: self.corner_weights(cell.x, cell.y),
            near,
            far,
            side: if self.is_upper(cell.y) { 1.0 } else { -1.0 },
            probability: cell.probability,
        }
    }

    /// A direction in a cell that was drawn, and its density.
    #[inline(always)]
    fn direction_in(&self, cell: &Drawn) -> (Vec3, f32) {
        let Drawn { rest, weights, near, far, .. } = *cell;
        let [a, b, c, d] = weights;
        let down = linear(rest[1], a + b, c + d);
        let across = linear(rest[0], a + (c - a) * down, b + (d - b) * down);
        let drop = near + (far - near) * if cell.side > 0.0 { down } else { 1.0 - down };
        let radius = (drop * (2.0 - drop)).max(0.0).sqrt();
        let u = (cell.column + 0.5 + across) / self.image.width as f32;
        let (sine, cosine) = math::sin_cos(TAU * (u - 0.5) - self.rotation);
        let direction = Vec3::new(radius * cosine, cell.side * (1.0 - drop), radius * sine);
        (direction, self.density(cell.probability, weights, far - near, [across, down]))
    }

    /// The density of [`EnvironmentMap::sample`] per solid angle.
    #[inline]
    pub fn pdf(&self, direction: Vec3) -> f32 {
        self.cells.as_ref().map_or(0.0, |cells| self.pdf_at(cells, self.place(direction), direction))
    }

    /// The density of a direction that lies in a place.
    #[inline(always)]
    fn pdf_at(&self, cells: &Distribution2d, Place { column, band, across, .. }: Place, direction: Vec3) -> f32 {
        let probability = cells.probability(column, band);
        if probability == 0.0 {
            return 0.0;
        }
        let is_upper = self.is_upper(band);
        let (near, far) = self.folded_edges(band);
        let toward_pole = if is_upper { direction.y } else { -direction.y };
        let square = direction.x * direction.x + direction.z * direction.z;
        let drop = if toward_pole > 0.0 { square / (1.0 + toward_pole) } else { 1.0 - toward_pole };
        let from_pole = ((drop - near) / (far - near)).clamp(0.0, 1.0);
        let down = if is_upper { from_pole } else { 1.0 - from_pole };
        self.density(probability, self.corner_weights(column, band), far - near, [across, down])
    }

    /// The density per solid angle at a place of a cell, of some height, that is drawn with some probability; down by height, too.
    #[inline(always)]
    fn density(&self, probability: f32, weights: [f32; 4], height: f32, [across, down]: [f32; 2]) -> f32 {
        let [a, b, c, d] = weights;
        let solid_angle = height * (TAU / self.image.width as f32);
        probability * bilinear(weights, across, down) / (0.25 * (a + b + c + d)) / solid_angle
    }

    #[inline(always)]
    fn place(&self, direction: Vec3) -> Place {
        let (width, height) = (self.image.width, self.image.height);
        let turn = (math::atan2(direction.z, direction.x) + self.rotation) * (0.5 * FRAC_1_PI) + 0.5;
        let x = (turn - turn.floor()) * width as f32 - 0.5;
        let x = if x < 0.0 { x + width as f32 } else { x };
        let column = (x as u32).min(width - 1);
        // The arctangent and not the arccosine, which knows little about angles near the poles.
        let radius = (direction.x * direction.x + direction.z * direction.z).sqrt();
        let v = math::atan2(radius, direction.y) * FRAC_1_PI;
        let y = match self.rows {
            MapRows::Centers => v * height as f32 + 0.5,
            MapRows::Poles => v * (height - 1) as f32,
        };
        let band = (y as u32).min(bands(height, self.rows) - 1);
        let part = |x: f32, whole: u32| (x - whole as f32).clamp(0.0, 1.0);
        Place { column, band, across: part(x, column), down: part(y, band) }
    }

    /// The pixels at the corners of a cell: upper left, upper right, lower left, lower right.
    #[inline(always)]
    fn corners(&self, column: u32, band: u32) -> [Vec3; 4] {
        let (upper, lower) = self.rows_around(band);
        let next = if column + 1 == self.image.width { 0 } else { column + 1 };
        let pixel = |x: u32, y: u32| Vec3::from_array(self.image.floats()[self.pixel(x, y)]);
        [pixel(column, upper), pixel(next, upper), pixel(column, lower), pixel(next, lower)]
    }

    /// The rows of pixels above and below a band.
    #[inline(always)]
    fn rows_around(&self, band: u32) -> (u32, u32) {
        match self.rows {
            MapRows::Centers => (band.saturating_sub(1), band.min(self.image.height - 1)),
            MapRows::Poles => (band, band + 1),
        }
    }

    #[inline(always)]
    fn pixel(&self, x: u32, y: u32) -> usize {
        y as usize * self.image.width as usize + x as usize
    }

    /// What places are drawn by at the corners of a cell.
    #[inline(always)]
    fn corner_weights(&self, column: u32, band: u32) -> [f32; 4] {
        let [a, b, c, d] = self.corners(column, band).map(|corner| (luminance(corner) - self.even).max(0.0));
        let (top, bottom) = (band == 0, band + 1 == bands(self.image.height, self.rows));
        let at_pole = |is_pole: bool, pole: f32, other: f32| if is_pole { pole.max(0.5 * other) } else { pole };
        [at_pole(top, a, c), at_pole(top, b, d), at_pole(bottom, c, a), at_pole(bottom, d, b)]
    }

    /// Whether a band lies in the upper half; that on the equator does.
    #[inline(always)]
    fn is_upper(&self, band: u32) -> bool {
        2 * (band as usize + 1) <= self.edges.len()
    }

    /// 1 - |cosθ| at the edges of a band, first at the one nearer to its pole. So the heights of bands around the south pole
    /// are as precise as those around the north pole.
    #[inline(always)]
    fn folded_edges(&self, band: u32) -> (f32, f32) {
        let band = band as usize;
        let near = if self.is_upper(band as u32) { band } else { self.edges.len() - 2 - band };
        (self.edges[near], self.edges[near + 1])
    }

    #[inline(always)]
    fn band_height(&self, band: u32) -> f32 {
        let (near, far) = self.folded_edges(band);
        far - near
    }

    /// The mean luminance over all directions, with corners of cells for what lies between.
    fn mean_luminance(&self) -> f32 {
        let mut sum = 0.0;
        for band in 0..self.edges.len() as u32 - 1 {
            let luminance = |corner: &Vec3| f64::from(luminance(*corner));
            let row = |column| self.corners(column, band).iter().map(luminance).sum::<f64>();
            sum += (0..self.image.width).map(row).sum::<f64>() * f64::from(self.band_height(band));
        }
        // Four corners each; the heights add up to 2.
        (sum / (8.0 * f64::from(self.image.width))) as f32
    }
}

/// Bands of cells between the poles.
#[inline(always)]
fn bands(height: u32, rows: MapRows) -> u32 {
    match rows {
        MapRows::Centers => height + 1,
        MapRows::Poles => height - 1,
    }
}

/// The angle from the north pole at which a band begins.
fn edge_angle(edge: u32, height: u32, rows: MapRows) -> f32 {
    let v = match rows {
        MapRows::Centers => (edge as f32 - 0.5) / height as f32,
        MapRows::Poles => edge as f32 / (height - 1) as f32,
    };
    PI * v.clamp(0.0, 1.0)
}

/// 1 - cos of an angle, precise for small ones.
fn versine(angle: f32) -> f32 {
    let sine = math::sin(0.5 * angle);
    2.0 * sine * sine
}

/// Between four corners: upper left, upper right, lower left, lower right.
#[inline(always)]
fn bilinear<T>([a, b, c, d]: [T; 4], across: f32, down: f32) -> T
where
    T: Copy + std::ops::Add<Output = T> + std::ops::Mul<f32, Output = T>,
{
    let between = |left: T, right: T| left * (1.0 - across) + right * across;
    between(a, b) * (1.0 - down) + between(c, d) * down
}

/// Draws 0..1 by a density that goes in a line from `a` to `b`, not both zero, with 0 < u < 1.
#[inline(always)]
fn linear(u: f32, a: f32, b: f32) -> f32 {
    let (u, a, b) = (f64::from(u), f64::from(a), f64::from(b));
    (u * (a + b) / (a + (a * a + (b * b - a * a) * u).max(0.0).sqrt())) as f32
}

#[cfg(test)]
mod tests {
    use std::f64::consts;

    use brewster_optics::warp;
    use glam::DVec3;

    use super::*;
    use crate::Texels;
    use crate::statistics::{Random, check_sphere};

    pub(super) fn map(
        size: [u32; 2],
        rows: MapRows,
        rotation: f32,
        pixel: impl Fn(u32, u32) -> Vec3,
    ) -> EnvironmentMap {
        let [width, height] = size;
        let pixels = (0..width * height).map(|i| pixel(i % width, i / width).to_array()).collect();
        EnvironmentMap::new(Arc::new(Image { width, height, texels: Texels::Floats(pixels) }), rows, rotation)
            .expect("a sound picture")
    }

    /// Colors that have nothing to do with each other.
    pub(super) fn noise(x: u32, y: u32) -> Vec3 {
        let mut random = Random::new(u64::from(x * 1000 + y) + 1);
        Vec3::from_array([0; 3].map(|_| random.unit().powi(3)))
    }

    pub(super) const EVERY: [(MapRows, f32); 4] =
        [(MapRows::Centers, 0.0), (MapRows::Poles, 0.0), (MapRows::Centers, 1.1), (MapRows::Poles, -4.0)];

    /// The convention in f64 from the words at the head, by the standard library's functions.
    fn reference(map: &EnvironmentMap, direction: Vec3) -> DVec3 {
        let Image { width, height, .. } = &**map.image();
        let pixels = map.image().floats();
        let d = direction.as_dvec3().normalize();
        // The map's own direction: turned back about +Y.
        let back = glam::DQuat::from_rotation_y(-f64::from(map.rotation));
        let d = back * d;
        let u = d.z.atan2(d.x) / consts::TAU + 0.5;
        let v = d.x.hypot(d.z).atan2(d.y) / consts::PI;
        let x = u * f64::from(*width) - 0.5;
        let y = match map.rows {
            MapRows::Centers => v * f64::from(*height) - 0.5,
            MapRows::Poles => v * f64::from(height - 1),
        };
        let pixel = |x: f64, y: f64| {
            let (x, y) = ((x as i64).rem_euclid(i64::from(*width)), (y as i64).clamp(0, i64::from(height - 1)));
            let [r, g, b] = pixels[(y * i64::from(*width) + x) as usize];
            DVec3::new(f64::from(r), f64::from(g), f64::from(b))
        };
        let (x0, y0) = (x.floor(), y.floor());
        let (s, t) = (x - x0, y - y0);
        let upper = pixel(x0, y0) * (1.0 - s) + pixel(x0 + 1.0, y0) * s;
        let lower = pixel(x0, y0 + 1.0) * (1.0 - s) + pixel(x0 + 1.0, y0 + 1.0) * s;
        upper * (1.0 - t) + lower * t
    }

    /// Worked out by hand from u = atan2(z, x)/2π + ½ and v = acos(y)/π on four columns and two rows: their centers lie at
    /// u = 1/8, 3/8, 5/8, 7/8 and at v = 1/4 and 3/4.
    #[test]
    fn the_picture_is_turned_as_it_should() {
        let pixel = |x: u32, y: u32| Vec3::splat((x + 4 * y) as f32);
        let sky = map([4, 2], MapRows::Centers, 0.0, pixel);
        let half = 0.5f32.sqrt();
        // Angles about y of -135°, -45°, 45° and 135° from +X toward +Z, 45° up, then down.
        for (i, [x, z]) in [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].into_iter().enumerate() {
            for (row, y) in [(0, half), (1, -half)] {
                let found = sky.radiance(Vec3::new(0.5 * x, y, 0.5 * z));
                assert!((found.x - (i + 4 * row) as f32).abs() < 1e-5, "column {i}, row {row}: {found}");
            }
        }
        // +X lies between columns 1 and 2, -Z between 0 and 1, and -X between the last and the first; halfway between rows.
        for (direction, expected) in [(Vec3::X, 3.5), (Vec3::NEG_Z, 2.5), (Vec3::Z, 4.5), (Vec3::NEG_X, 3.5)] {
            assert!((sky.radiance(direction).x - expected).abs() < 1e-5, "{direction}");
        }
        // A quarter turn counterclockwise, seen from above, takes what was at +X to -Z.
        let turned = map([4, 2], MapRows::Centers, 0.5 * PI, pixel);
        let at_z = turned.radiance(Vec3::new(0.5, half, -0.5));
        assert!((at_z - sky.radiance(Vec3::new(0.5, half, 0.5))).length() < 1e-5, "{at_z}");
    }

    /// Mitsuba: u = atan2(d.x, -d.z)/2π wrapped into 0..1, v = acos(d.y)/π, columns at (c+½)/width, rows at r/(height-1).
    #[test]
    fn mitsubas_pictures_are_a_quarter_turn_away() {
        let sky = map([16, 9], MapRows::Poles, -0.5 * PI, noise);
        let (width, height) = (16.0, 9.0);
        for column in 0..16u32 {
            for row in 0..9u32 {
                let u = (f64::from(column) + 0.5) / width * consts::TAU;
                let v = f64::from(row) / (height - 1.0) * consts::PI;
                let direction = DVec3::new(v.sin() * u.sin(), v.cos(), -v.sin() * u.cos()).as_vec3();
                // At a pole all columns meet.
                if row % 8 > 0 {
                    let found = sky.radiance(direction);
                    assert!((found - noise(column, row)).length() < 1e-4, "{column} {row}: {found}");
                }
            }
        }
    }

    #[test]
    fn lookups_follow_the_convention_everywhere() {
        let mut random = Random::new(5);
        for (rows, rotation) in EVERY {
            for size in [[1, 2], [2, 2], [5, 3], [64, 33]] {
                let sky = map(size, rows, rotation, noise);
                for i in 0..2000 {
                    let direction = if i % 4 == 0 {
                        (random.cube() * 0.02 + Vec3::Y * if i % 8 == 0 { 1.0 } else { -1.0 }).normalize()
                    } else {
                        random.direction()
                    };
                    let (found, expected) = (sky.radiance(direction), reference(&sky, direction));
                    let off = (found.as_dvec3() - expected).length();
                    assert!(off < 2e-3, "{size:?} {rows:?} {rotation} {direction}: {found} {expected}");
                }
                // Across the seam, and at the poles, where nothing but the height counts.
                for direction in [Vec3::NEG_X, Vec3::new(-1.0, 0.0, -1e-8), Vec3::new(-1.0, 0.0, 1e-8)] {
                    let off = (sky.radiance(direction).as_dvec3() - reference(&sky, direction)).length();
                    assert!(off < 1e-4, "{size:?} {rows:?} {rotation} {direction}");
                }
                for pole in [Vec3::Y, Vec3::NEG_Y] {
                    assert!(sky.radiance(pole).is_finite() && sky.pdf(pole).is_finite());
                }
            }
        }
    }

    #[test]
    fn directions_follow_their_densities() {
        for (rows, rotation) in EVERY {
            for size in [[1, 2], [4, 2], [9, 5], [16, 8]] {
                let sky = map(size, rows, rotation, noise);
                let name = format!("{size:?} {rows:?} {rotation}");
                check_sphere(&name, |u| sky.sample(u), |direction| sky.pdf(direction));
            }
        }
    }

    /// The integral of a function over the sphere, by midpoints in angles.
    fn integral(f: impl Fn(Vec3) -> f64) -> f64 {
        let (rows, columns) = (240, 480);
        let part = consts::PI / f64::from(rows) * consts::TAU / f64::from(columns);
        let at = |i: i32| {
            let theta = consts::PI * (f64::from(i / columns) + 0.5) / f64::from(rows);
            let phi = consts::TAU * (f64::from(i % columns) + 0.5) / f64::from(columns);
            let direction = DVec3::new(theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin());
            f(direction.as_vec3()) * theta.sin() * part
        };
        (0..rows * columns).map(at).sum()
    }

    /// The light that directions drawn from the map and even ones find together, weighted by the balance heuristic, is in the mean the
    /// integral of the light, by midpoints of the reference; and its variance is small.
    fn check_estimates(name: &str, sky: &EnvironmentMap, spread: f64) {
        let exact = integral(|direction| luminance(reference(sky, direction).as_vec3()).into());
        let mut random = Random::new(11);
        let (count, mut sum, mut squares) = (40_000, 0.0, 0.0);
        let found = |direction: Vec3| {
            let found = f64::from(luminance(sky.radiance(direction)) / (sky.pdf(direction) + warp::SPHERE_PDF));
            // Twice, and the density's own integral is larger by at most an eighth.
            assert!(found < 2.25 * exact, "{name} {direction:?}: {found} {exact}");
            found
        };
        for _ in 0..count {
            let sample = sky.sample(random.square().into()).expect("the map is not even");
            assert_eq!((sample.radiance, sample.distance), (sky.radiance(sample.direction), f32::INFINITY));
            assert!((sample.pdf / sky.pdf(sample.direction) - 1.0).abs() < 1e-3, "{name} {sample:?}");
            let pair = found(sample.direction) + found(random.direction());
            sum += pair / f64::from(count);
            squares += pair * pair / f64::from(count);
        }
        let deviation = (squares - sum * sum).max(0.0).sqrt();
        let error = deviation / f64::from(count).sqrt() + 2e-4 * exact;
        assert!((sum - exact).abs() < 4.0 * error, "{name}: {sum}, not {exact}");
        assert!(deviation < spread * exact, "{name}: deviation {deviation} of {exact}");
    }

    #[test]
    fn no_light_is_lost_and_none_is_rare() {
        for (rows, rotation) in EVERY {
            let name = format!("{rows:?} {rotation}");
            let size = [32, 16];
            check_estimates(&name, &map(size, rows, rotation, noise), 0.2);
            // All light in one pixel, at the equator, beside a pole, and at one, among dark and among dim ones.
            for (x, y) in [(7, 8), (31, 1), (0, 0), (12, 15)] {
                for dim in [0.0, 1e-6] {
                    let sun = |at, row| if (at, row) == (x, y) { Vec3::splat(1e6) } else { Vec3::splat(dim) };
                    check_estimates(&format!("{name} sun {x} {y}"), &map(size, rows, rotation, sun), 0.4);
                }
            }
            // A dark pole below light, and light in the pole's row alone.
            for bright in [0, 1] {
                let cap = |_, y| if y == bright { Vec3::ONE } else { Vec3::ZERO };
                check_estimates(&format!("{name} row {bright}"), &map([8, 6], rows, rotation, cap), 0.5);
            }
        }
    }

    #[test]
    fn an_even_map_is_not_drawn_from() {
        for (rows, rotation) in EVERY {
            let sky = map([24, 12], rows, rotation, |_, _| Vec3::new(0.1, 0.7, 0.3));
            assert!(!sky.is_drawn() && !sky.is_black());
            assert!(sky.sample([0.5; 2]).is_none() && sky.pdf(Vec3::X) == 0.0);
        }
    }

    #[test]
    fn pictures_that_are_no_maps_are_refused() {
        let image =
            |width, height, pixels: Vec<[f32; 3]>| Arc::new(Image { width, height, texels: Texels::Floats(pixels) });
        let check = |image, rows, rotation, expected| {
            assert_eq!(EnvironmentMap::new(image, rows, rotation).err(), expected);
        };
        check(image(0, 0, vec![]), MapRows::Centers, 0.0, Some(MapError::Size));
        check(image(2, 2, vec![[0.0; 3]; 3]), MapRows::Centers, 0.0, Some(MapError::Size));
        check(image(u32::MAX, u32::MAX, vec![]), MapRows::Centers, 0.0, Some(MapError::Size));
        check(image(1, 1, vec![[0.0; 3]]), MapRows::Poles, 0.0, Some(MapError::OneRow));
        check(image(1, 1, vec![[0.0; 3]]), MapRows::Centers, f32::NAN, Some(MapError::Rotation));
        for bad in [-1.0, f32::NAN, f32::INFINITY] {
            let pixels = vec![[0.0; 3], [0.0; 3], [0.0, bad, 0.0], [0.0; 3]];
            check(image(2, 2, pixels), MapRows::Centers, 0.0, Some(MapError::Pixel { x: 0, y: 1 }));
        }
        let black =
            EnvironmentMap::new(image(2, 2, vec![[0.0; 3]; 4]), MapRows::Centers, 0.0).expect("a sound picture");
        assert!(black.is_black() && black.sample([0.5; 2]).is_none() && black.pdf(Vec3::X) == 0.0);
    }
}
