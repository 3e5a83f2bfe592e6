//! Rectangles, drawn evenly over the solid angle in which they are seen.
//!
//! After C. Ureña, M. Fajardo and A. King, "An Area-Preserving Parametrization for Spherical Rectangles" (2013). Angles come in
//! f32, so a rectangle that looks small, and for which area serves as well, is left to that.

use std::f64::consts::TAU;

use brewster_geometry::{Affine, Quad};
use brewster_lanes::math;
use glam::{DVec2, DVec3, Vec3};

/// A rectangle in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Rectangle {
    /// Directions of the edges, and the normal.
    axes: [DVec3; 3],
    center: DVec3,
    /// Half of the edges' lengths, and 0.
    half: DVec3,
    /// Its area in object space.
    pub(super) area: f64,
}

impl Rectangle {
    /// A mapped quad, if its edges still are at right angles. `area` is that in object space.
    pub(super) fn new(quad: &Quad, to_world: &Affine, area: f64) -> Option<Rectangle> {
        let edge = |axis: usize, half: f32| {
            let edge = DVec3::from_array(to_world.rows.map(|row| f64::from(row[axis]))) * f64::from(2.0 * half);
            let length = edge.length();
            (edge / length, length)
        };
        let [(x, width), (y, height)] = [edge(0, quad.half.x), edge(1, quad.half.y)];
        let center = DVec3::from_array(to_world.rows.map(|row| f64::from(row[3])));
        let half = DVec3::new(0.5 * width, 0.5 * height, 0.0);
        (x.dot(y).abs() <= 2e-6).then_some(Rectangle { axes: [x, y, x.cross(y)], center, half, area })
    }
}

/// A rectangle as a point sees it: the point is the origin, the rectangle lies across z at z < 0, along x and y.
pub(super) struct SeenRectangle {
    low: DVec3,
    high: DVec3,
    /// The z components of the unit normals of the planes through the point and the lower and the upper edge along x.
    planes: [f64; 2],
    /// The angle from which the place along x is told.
    start: f64,
    solid_angle: f64,
}

/// A rectangle of less than this looks small: rounding of its angles would be more than some parts in 10⁵.
const SMALL: f64 = 0.05;

impl SeenRectangle {
    /// A rectangle as a point sees it; none if it looks small.
    #[inline]
    pub(super) fn new(rectangle: &Rectangle, point: Vec3) -> Option<SeenRectangle> {
        let center = rectangle.center - point.as_dvec3();
        let [x, y, z] = rectangle.axes.map(|axis| axis.dot(center));
        let middle = DVec3::new(x, y, -z.abs());
        let (low, high) = (middle - rectangle.half, middle + rectangle.half);
        let squared_z = low.z * low.z;
        // The planes through the point and the edges: below, at the right, above, at the left. The z component of a normal, and
        // the square of the other one.
        let plane = |across: f64| {
            let squared = across * across + squared_z;
            (across / squared.sqrt(), squared_z / squared)
        };
        let planes = [plane(-low.y), plane(high.x), plane(high.y), plane(-low.x)];
        // Cosine and sine of the angle at the corner of two of them; near a right line its cosine says little.
        let angle = |i: usize| {
            let ((a, rest_a), (b, rest_b)) = (planes[i], planes[(i + 1) % 4]);
            DVec2::new(-a * b, (rest_a + rest_b - rest_a * rest_b).sqrt())
        };
        // Two angles of no less than a right one each are told by one arc tangent.
        let both = |a: DVec2, b: DVec2| {
            let sum = a.rotate(b);
            let angle = f64::from(math::atan2(sum.y as f32, sum.x as f32));
            if angle < 0.0 { angle + TAU } else { angle }
        };
        let start = TAU - both(angle(2), angle(3));
        let solid_angle = both(angle(0), angle(1)) - start;
        let planes = [planes[0].0, planes[2].0];
        (solid_angle > SMALL).then_some(SeenRectangle { low, high, planes, start, solid_angle })
    }

    /// The place of the rectangle, 0 to 1 along both edges, that two numbers 0 ≤ u < 1 draw.
    #[inline]
    pub(super) fn sample(&self, [u, v]: [f32; 2]) -> [f32; 2] {
        let (low, high, z) = (self.low, self.high, self.low.z);
        // Left of x lies the part u of the solid angle.
        let (sine, cosine) = math::sin_cos((f64::from(u) * self.solid_angle + self.start) as f32);
        let slope = (f64::from(cosine) * self.planes[0] - self.planes[1]) / f64::from(sine);
        let along = 1f64.copysign(slope) / (slope * slope + self.planes[0] * self.planes[0]).sqrt();
        let x = (-along * z / (1.0 - along * along).max(0.0).sqrt()).clamp(low.x, high.x);
        // Along a line across the rectangle solid angle goes as the sine of the elevation.
        let distance = (x * x + z * z).sqrt();
        let sine = |y: f64| y / (distance * distance + y * y).sqrt();
        let sine = sine(low.y) + f64::from(v) * (sine(high.y) - sine(low.y));
        let y = (sine * distance / (1.0 - sine * sine).max(0.0).sqrt()).clamp(low.y, high.y);
        let part = |at: f64, low: f64, high: f64| (((at - low) / (high - low)) as f32).clamp(0.0, 1.0);
        [part(x, low.x, high.x), part(y, low.y, high.y)]
    }

    /// The density of [`SeenRectangle::sample`] per solid angle.
    #[inline(always)]
    pub(super) fn pdf(&self) -> f64 {
        1.0 / self.solid_angle
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec2;

    use super::*;
    use crate::statistics::{Random, chi_squared};

    /// The solid angle of the part of a quad from its lower left corner to a place, by two triangles (A. van Oosterom and J.
    /// Strackee, "The Solid Angle of a Plane Triangle", 1983).
    fn solid_angle(quad: &Quad, [u, v]: [f64; 2], point: DVec3) -> f64 {
        let half = quad.half.as_dvec2();
        let corner =
            |x: f64, y: f64| (DVec3::new((2.0 * x - 1.0) * half.x, (2.0 * y - 1.0) * half.y, 0.0) - point).normalize();
        let triangle =
            |a: DVec3, b: DVec3, c: DVec3| 2.0 * a.dot(b.cross(c)).abs().atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a));
        let [a, b, c, d] = [corner(0.0, 0.0), corner(u, 0.0), corner(u, v), corner(0.0, v)];
        triangle(a, b, c) + triangle(a, c, d)
    }

    #[test]
    fn places_are_even_over_solid_angle() {
        let quad = Quad { half: Vec2::new(1.0, 0.6) };
        let points = [
            Vec3::new(0.0, 0.0, 1.0),
            Vec3::new(0.3, -0.2, -0.01),
            Vec3::new(1.5, 0.1, 0.4),
            Vec3::new(2.0, 1.5, -0.7),
            Vec3::new(0.0, 0.7, 0.02),
            Vec3::new(-1.0, -0.6, 0.5),
        ];
        let mut random = Random::new(9);
        for point in points {
            let rectangle = Rectangle::new(&quad, &Affine::IDENTITY, 2.4).expect("it is one");
            let seen = SeenRectangle::new(&rectangle, point).expect("it looks large");
            let whole = solid_angle(&quad, [1.0, 1.0], point.as_dvec3());
            assert!((1.0 / seen.pdf() / whole - 1.0).abs() < 3e-5, "{point}: {}, not {whole}", 1.0 / seen.pdf());
            let mut counts = [0.0; 64];
            for _ in 0..50_000 {
                let [x, y] = seen.sample(random.square().into()).map(|x| ((x * 8.0) as usize).min(7));
                counts[x * 8 + y] += 1.0;
            }
            let below = |x: usize, y: usize| solid_angle(&quad, [x as f64 / 8.0, y as f64 / 8.0], point.as_dvec3());
            let share = |x, y| (below(x + 1, y + 1) + below(x, y) - below(x, y + 1) - below(x + 1, y)) / whole;
            let expected: Vec<f64> = (0..64).map(|i| 50_000.0 * share(i / 8, i % 8)).collect();
            chi_squared(&format!("from {point}"), &counts, &expected);
        }
    }

    #[test]
    fn sheared_and_small_rectangles_are_left_to_others() {
        let quad = Quad { half: Vec2::ONE };
        let mut map = Affine::IDENTITY;
        let rectangle = Rectangle::new(&quad, &map, 4.0).expect("it is one");
        assert!(SeenRectangle::new(&rectangle, Vec3::new(0.0, 0.0, 30.0)).is_none());
        assert!(SeenRectangle::new(&rectangle, Vec3::new(3.0, 0.0, 0.0)).is_none());
        map.rows[0][1] = 0.2;
        assert!(Rectangle::new(&quad, &map, 4.0).is_none());
    }
}
