//! Tori.

use std::cmp::Ordering;
use std::f64::consts::TAU;

use brewster_lanes::math;
use glam::{DVec2, DVec3, Vec2, Vec3};

use crate::aabb::Aabb;
use crate::chord::recentered;
use crate::sampling::Spread;
use crate::shape::{Analytic, Crossing, LocalSurface, ShapeError, check_length};
use crate::sphere::{around, turn, turn_gradient};

/// A torus around the origin and the y axis.
///
/// Texture: u = atan2(z, x)/2π + ½ around the axis, v = atan2(y, √(x²+z²) - major)/2π + ½ around the tube.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Torus {
    /// The radius of the circle in the middle of the tube.
    pub major_radius: f32,
    /// The radius of the tube, less than `major_radius`.
    pub minor_radius: f32,
}

impl Analytic for Torus {
    fn validate(&self) -> Result<(), ShapeError> {
        check_length("major_radius", self.major_radius)?;
        check_length("minor_radius", self.minor_radius)?;
        if self.minor_radius < self.major_radius {
            return Ok(());
        }
        Err(ShapeError { parameter: "minor_radius", value: self.minor_radius, expected: "less than major_radius" })
    }

    fn bounds(&self) -> Aabb {
        let outer = self.major_radius + self.minor_radius;
        Aabb::centered(Vec3::new(outer, self.minor_radius, outer))
    }

    fn is_closed(&self) -> bool {
        true
    }

    /// Lengths are in units of the outer radius, and the line starts at its point nearest to the center: the quartic has no
    /// cubic term and its coefficients are of order one.
    fn crossing(&self, origin: DVec3, direction: DVec3) -> Option<Crossing> {
        let outer = self.major_radius as f64 + self.minor_radius as f64;
        let (major, minor) = (self.major_radius as f64 / outer, self.minor_radius as f64 / outer);
        let speed = direction.length() / outer;
        recentered(origin, direction, |nearest, after| {
            let (p, d) = (nearest / outer, direction / (outer * speed));
            // The ball around the torus, a little larger so that both ends lie outside the tube.
            let end = (1.0 + 1e-9 - p.length_squared()).max(0.0).sqrt();
            let (at, along) = (DVec2::new(p.x, p.z), DVec2::new(d.x, d.z));
            // (|p + t·d|² + major² - minor²)² = 4·major²·(x² + z²)
            let k = p.length_squared() + major * major - minor * minor;
            let m = 4.0 * major * major;
            let quartic = DepressedQuartic([
                k * k - m * at.length_squared(),
                -2.0 * m * at.dot(along),
                2.0 * k - m * along.length_squared(),
            ]);
            let t = quartic.first_root((after * speed).max(-end), end)?;
            Some(Crossing { t: t / speed, face: 0 })
        })
    }

    fn surface(&self, point: DVec3, _face: u32, _margin: DVec3) -> LocalSurface {
        let (major, minor) = (self.major_radius as f64, self.minor_radius as f64);
        let around = DVec2::new(point.x, point.z);
        let outward = around.normalize_or(DVec2::X);
        let across = around.dot(outward) - major;
        let normal = DVec2::new(across, point.y).normalize_or(DVec2::X);
        let normal = DVec3::new(outward.x * normal.x, normal.y, outward.y * normal.x);
        LocalSurface {
            point: DVec3::new(outward.x, 0.0, outward.y) * major + normal * minor,
            normal,
            uv: Vec2::new(turn(around.x, around.y), turn(across, point.y)),
        }
    }

    fn uv_gradients(&self, point: DVec3, _face: u32) -> [DVec3; 2] {
        let (major, minor) = (self.major_radius as f64, self.minor_radius as f64);
        let outward = DVec2::new(point.x, point.z).normalize_or(DVec2::X);
        let across = DVec2::new(point.x, point.z).dot(outward) - major;
        let around_tube = DVec3::Y * across - DVec3::new(outward.x, 0.0, outward.y) * point.y;
        [turn_gradient(point), around_tube / (TAU * minor * minor)]
    }
}

impl Spread for Torus {
    /// Pappus: the tube's circumference times the way of its center.
    fn area(&self) -> f64 {
        TAU * self.minor_radius as f64 * TAU * self.major_radius as f64
    }

    /// Around the tube area goes as 1 + k·cosθ, where k = minor/major. On the inner half of the tube is missing what opposite, on
    /// the outer half, is too much: θ is drawn evenly from the outer half, and is moved to the opposite side with probability
    /// (1 - k·cosθ)/2. The second number decides that, and what is left of it goes around the axis. So nothing has to be
    /// inverted, and nothing is lost.
    fn spread(&self, [u, v]: [f32; 2]) -> (DVec3, u32) {
        let (major, minor) = (self.major_radius as f64, self.minor_radius as f64);
        let (sine, cosine) = math::sin_cos(std::f32::consts::PI * (u - 0.5));
        let (cosine, v) = (cosine.max(0.0) as f64, v as f64);
        let outer = 0.5 + 0.5 * cosine * minor / major;
        let (side, turn) = if v < outer { (1.0, v / outer) } else { (-1.0, (v - outer) / (1.0 - outer)) };
        let across = around(turn as f32) * (major + side * minor * cosine);
        (DVec3::new(across.x, side * minor * sine as f64, across.y), 0)
    }
}

/// t⁴ + c₂t² + c₁t + c₀.
struct DepressedQuartic([f64; 3]);

impl DepressedQuartic {
    fn value(&self, t: f64) -> f64 {
        let [c0, c1, c2] = self.0;
        ((t * t + c2) * t + c1) * t + c0
    }

    fn slope(&self, t: f64) -> f64 {
        let [_, c1, c2] = self.0;
        (4.0 * t * t + 2.0 * c2) * t + c1
    }

    fn curvature(&self, t: f64) -> f64 {
        12.0 * t * t + 2.0 * self.0[2]
    }

    /// The first place beyond `from` where the value changes its sign.
    ///
    /// The slope's extremes cut the line where the slope is monotone, the slope's roots cut it where the value is: in each
    /// piece a root is bracketed, so none is lost and none is invented, however close two of them lie.
    fn first_root(&self, from: f64, to: f64) -> Option<f64> {
        if from.partial_cmp(&to) != Some(Ordering::Less) {
            return None;
        }
        let bend = (-self.0[2] / 6.0).max(0.0).sqrt();
        let (mut start, mut value) = (from, self.value(from));
        let mut low = from;
        for high in [-bend, bend, to] {
            let high = high.clamp(low, to);
            let turning = bracketed_root(low, high, |t| (self.slope(t), self.curvature(t)));
            for end in [turning, (high == to).then_some(to)].into_iter().flatten() {
                let next = self.value(end);
                if (value < 0.0) != (next < 0.0) {
                    return bracketed_root(start, end, |t| (self.value(t), self.slope(t)));
                }
                (start, value) = (end, next);
            }
            low = high;
        }
        None
    }
}

/// The root of a function that is monotone between a and b, if it changes its sign there: Newton's steps, and halving where
/// they leave the bracket or close in too slowly.
fn bracketed_root(mut a: f64, mut b: f64, f: impl Fn(f64) -> (f64, f64)) -> Option<f64> {
    let negative = f(a).0 < 0.0;
    if negative == (f(b).0 < 0.0) {
        return None;
    }
    let mut t = 0.5 * (a + b);
    let mut last = b - a;
    // 128 halvings exhaust any bracket of order one; Newton needs about six steps.
    for _ in 0..128 {
        let (value, slope) = f(t);
        if (value < 0.0) == negative {
            a = t
        } else {
            b = t
        }
        let newton = t - value / slope;
        let closing = (newton - t).abs() < 0.5 * last && newton > a && newton < b;
        let next = if closing { newton } else { 0.5 * (a + b) };
        last = (next - t).abs();
        if next == t || last <= f64::EPSILON * 0.125 {
            break;
        }
        t = next;
    }
    Some(t)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ray::Ray;

    /// Distances by hand.
    #[test]
    fn is_crossed_four_times_through_the_middle() {
        let torus = Torus { major_radius: 2.0, minor_radius: 0.5 };
        for (x, expected) in [(-5.0, 2.5), (-2.0, 0.5), (-1.0, 2.5), (2.0, 0.5)] {
            let hit = torus.intersect(&Ray { origin: Vec3::new(x, 0.0, 0.0), direction: Vec3::X, time: 0.0 });
            assert!((hit.unwrap().t - expected).abs() < 1e-6, "{x}: {hit:?}");
        }
        assert_eq!(torus.intersect(&Ray { origin: Vec3::new(2.6, 0.0, 0.0), direction: Vec3::X, time: 0.0 }), None);
        // Through the hole, and along the axis of the tube's top.
        assert_eq!(torus.intersect(&Ray { origin: Vec3::new(1.0, 9.0, 1.0), direction: Vec3::NEG_Y, time: 0.0 }), None);
        let top =
            torus.intersect(&Ray { origin: Vec3::new(2.0, 9.0, 0.0), direction: Vec3::NEG_Y, time: 0.0 }).unwrap();
        assert!((top.t - 8.5).abs() < 1e-5);
    }

    /// (t+2)(t+1)(t-0.5)(t-2.5) and, with a double root, (t+1)²(t-1)² moved down by a hair.
    #[test]
    fn roots_of_known_quartics() {
        let quartic = DepressedQuartic([2.5, -2.25, -5.75]);
        for (from, expected) in [(-5.0, -2.0), (-1.5, -1.0), (-0.5, 0.5), (1.0, 2.5)] {
            assert!((quartic.first_root(from, 5.0).unwrap() - expected).abs() < 1e-14);
        }
        assert_eq!(quartic.first_root(2.6, 5.0), None);
        let kissing = DepressedQuartic([1.0 - 1e-10, 0.0, -2.0]);
        let root = kissing.first_root(-1.0, 3.0).unwrap();
        assert!((root - (-1.0 + 0.5e-5)).abs() < 1e-9, "{root}");
    }
}
