//! From the unit square to the places that directions and points are drawn from, each with its density and way back.
//!
//! The maps are continuous and keep areas in proportion, so that well-spread numbers give well-spread samples. Densities
//! are per solid angle, or per unit of the area that the doc names.

use core::f32::consts::{FRAC_1_PI, FRAC_PI_2, FRAC_PI_4, PI, TAU};

use brewster_lanes::math;
use glam::{Vec2, Vec3};

/// The density of [`sphere`].
pub const SPHERE_PDF: f32 = 0.25 * FRAC_1_PI;

/// The density of [`disk`] per unit of area.
pub const DISK_PDF: f32 = FRAC_1_PI;

/// What is left between [`cosine_hemisphere`] and its horizon: half of the last step of a random number.
const RIM: f32 = 1.0 / (1 << 25) as f32;

/// A point of the unit disk; squares around the center become circles.
///
/// P. Shirley and K. Chiu, *A Low Distortion Map Between Disk and Square*, JGT 2(3), 1997.
#[inline(always)]
pub fn disk(square: Vec2) -> Vec2 {
    disk_in_polar(square).0
}

/// The point of the square that [`disk`] maps to `point`.
#[inline(always)]
pub fn disk_inverse(point: Vec2) -> Vec2 {
    let radius = point.length();
    // The angle from -π/4, so that each quarter of the turn is one side of the square.
    let angle = math::atan2(point.y, point.x);
    let angle = if angle < -FRAC_PI_4 { angle + TAU } else { angle };
    let offset = if angle < FRAC_PI_4 {
        Vec2::new(radius, angle * radius / FRAC_PI_4)
    } else if angle < 3.0 * FRAC_PI_4 {
        Vec2::new(-(angle - FRAC_PI_2) * radius / FRAC_PI_4, radius)
    } else if angle < 5.0 * FRAC_PI_4 {
        Vec2::new(-radius, (angle - PI) * radius / -FRAC_PI_4)
    } else {
        Vec2::new((angle - 3.0 * FRAC_PI_2) * radius / FRAC_PI_4, -radius)
    };
    (0.5 + 0.5 * offset).clamp(Vec2::ZERO, Vec2::ONE)
}

/// A direction around +z with density `cosθ/π`; never quite at the horizon, where the density would be 0.
#[inline(always)]
pub fn cosine_hemisphere(square: Vec2) -> Vec3 {
    let (point, radius) = disk_in_polar(square);
    let z = ((1.0 - radius).max(RIM) * (1.0 + radius)).sqrt();
    point.extend(z)
}

/// The density of [`cosine_hemisphere`].
#[inline(always)]
pub fn cosine_hemisphere_pdf(direction: Vec3) -> f32 {
    direction.z.max(0.0) * FRAC_1_PI
}

/// The point of the square that [`cosine_hemisphere`] maps to `direction`.
#[inline(always)]
pub fn cosine_hemisphere_inverse(direction: Vec3) -> Vec2 {
    disk_inverse(direction.truncate())
}

/// A direction spread evenly over the whole sphere.
#[inline(always)]
pub fn sphere(square: Vec2) -> Vec3 {
    let radius = 2.0 * (square.x * (1.0 - square.x)).sqrt();
    around_z(1.0 - 2.0 * square.x, radius, square.y)
}

/// The point of the square that [`sphere`] maps to `direction`.
#[inline(always)]
pub fn sphere_inverse(direction: Vec3) -> Vec2 {
    Vec2::new((0.5 - 0.5 * direction.z).clamp(0.0, 1.0), turn(direction))
}

/// A direction spread evenly over the cone of half-angle θ around +z, where `versine` is 1 - cosθ, from 0 to 2.
///
/// The versine and not the cosine: from afar a lamp's cone is so thin that f32 could not tell its cosine from 1.
#[inline(always)]
pub fn cone(square: Vec2, versine: f32) -> Vec3 {
    let drop = square.x * versine;
    around_z(1.0 - drop, (drop * (2.0 - drop)).max(0.0).sqrt(), square.y)
}

/// The density of [`cone`] inside it.
#[inline(always)]
pub fn cone_pdf(versine: f32) -> f32 {
    1.0 / (TAU * versine)
}

/// The point of the square that [`cone`] maps to a direction inside it.
#[inline(always)]
pub fn cone_inverse(direction: Vec3, versine: f32) -> Vec2 {
    // 1 - z, from the other coordinates where those are the more precise.
    let square = direction.truncate().length_squared();
    let drop = if direction.z > 0.0 { square / (1.0 + direction.z) } else { 1.0 - direction.z };
    Vec2::new((drop / versine).clamp(0.0, 1.0), turn(direction))
}

/// Barycentric weights of a triangle's second and third corner, spread evenly: the density is 1 over its area.
///
/// E. Heitz, *A Low-Distortion Map Between Triangle and Square*, 2019. It needs no root and bends a square less than the
/// usual one.
#[inline(always)]
pub fn triangle(square: Vec2) -> Vec2 {
    let half = 0.5 * square;
    let across = half.y - half.x;
    if across > 0.0 { Vec2::new(half.x, half.y + across) } else { Vec2::new(half.x - across, half.y) }
}

/// The point of the square that [`triangle`] maps to `weights`.
#[inline(always)]
pub fn triangle_inverse(weights: Vec2) -> Vec2 {
    if weights.y > weights.x {
        Vec2::new(2.0 * weights.x, weights.y + weights.x)
    } else {
        Vec2::new(weights.x + weights.y, 2.0 * weights.y)
    }
}

/// [`disk`], and the distance from its center, which the square knows more precisely than the point.
#[inline(always)]
fn disk_in_polar(square: Vec2) -> (Vec2, f32) {
    let offset = 2.0 * square - Vec2::ONE;
    let wide = offset.x.abs() > offset.y.abs();
    let (radius, other) = if wide { (offset.x, offset.y) } else { (offset.y, offset.x) };
    let angle = if radius == 0.0 { 0.0 } else { FRAC_PI_4 * (other / radius) };
    let angle = if wide { angle } else { FRAC_PI_2 - angle };
    let (sine, cosine) = math::sin_cos(angle);
    (radius * Vec2::new(cosine, sine), radius.abs())
}

/// The direction at height `z` and distance `radius` from the z axis, `turn` of the way around it.
#[inline(always)]
fn around_z(z: f32, radius: f32, turn: f32) -> Vec3 {
    let (sine, cosine) = math::sin_cos(TAU * turn);
    Vec3::new(radius * cosine, radius * sine, z)
}

/// How far around the z axis a direction lies, from 0 to 1.
#[inline(always)]
fn turn(direction: Vec3) -> f32 {
    let turn = math::atan2(direction.y, direction.x) / TAU;
    if turn < 0.0 { (turn + 1.0).min(1.0) } else { turn }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::{Focus, SphereTest, chi_squared};
    use crate::strategies::real;
    use proptest::prelude::*;

    fn check(name: &str, sample: impl Fn(Vec2) -> Vec3, pdf: impl Fn(Vec3) -> f32) {
        let test = SphereTest { focus: Focus::SPHERE, family: 5 };
        test.check(name, |u, _| Some(sample(u)), pdf);
    }

    #[test]
    fn directions_follow_their_densities() {
        check("sphere", sphere, |_| SPHERE_PDF);
        check("cosine hemisphere", cosine_hemisphere, cosine_hemisphere_pdf);
        for versine in [0.3f32, 1.0, 2.0] {
            let inside = |direction: Vec3| if 1.0 - direction.z <= versine { cone_pdf(versine) } else { 0.0 };
            check(&format!("cone {versine}"), |u| cone(u, versine), inside);
        }
    }

    /// The sun's cone, half a degree wide: every ring of equal area has its share, and so has every sector.
    #[test]
    fn thin_cones_are_even() {
        let versine = 2.0 * (0.25f64.to_radians() / 2.0).sin().powi(2);
        let mut random = crate::statistics::Random::new(7);
        let mut counts = [0u32; 64];
        for _ in 0..100_000 {
            let direction = cone(random.square(), versine as f32).as_dvec3();
            let sine = direction.truncate().length();
            let ring = 2.0 * (sine.asin() / 2.0).sin().powi(2) / versine;
            let sector = direction.y.atan2(direction.x) / core::f64::consts::TAU + 0.5;
            counts[((ring * 8.0) as usize).min(7) * 8 + ((sector * 8.0) as usize).min(7)] += 1;
        }
        let expected = [100_000.0 / 64.0; 64];
        chi_squared("thin cone", &counts.map(f64::from), &expected, 1e-3);
    }

    /// Cells of the square become parts of equal area: counted in rings and sectors, and in bands along two edges.
    #[test]
    fn areas_are_kept() {
        let mut random = crate::statistics::Random::new(11);
        let (mut rings, mut bands) = ([0u32; 64], [0u32; 36]);
        for _ in 0..100_000 {
            let point = disk(random.square()).as_dvec2();
            let sector = point.y.atan2(point.x) / core::f64::consts::TAU + 0.5;
            rings[((point.length_squared() * 8.0) as usize).min(7) * 8 + ((sector * 8.0) as usize).min(7)] += 1;
            let weights = triangle(random.square()).as_dvec2();
            assert!(weights.min_element() >= 0.0 && weights.x + weights.y <= 1.0, "{weights}");
            // 1 - x is the root of an evenly spread number, and y is evenly spread below it.
            let (across, up) = ((1.0 - weights.x).powi(2), weights.y / (1.0 - weights.x).max(1e-9));
            bands[((across * 6.0) as usize).min(5) * 6 + ((up * 6.0) as usize).min(5)] += 1;
        }
        chi_squared("disk", &rings.map(f64::from), &[100_000.0 / 64.0; 64], 1e-3);
        chi_squared("triangle", &bands.map(f64::from), &[100_000.0 / 36.0; 36], 1e-3);
    }

    fn square() -> impl Strategy<Value = Vec2> {
        let number = || prop_oneof![6 => real(0.0, 1.0), 1 => Just(0.0), 1 => Just(1f32.next_down()), 1 => Just(0.5)];
        (number(), number()).prop_map(|(x, y)| Vec2::new(x, y.min(1f32.next_down())))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4096))]

        #[test]
        fn directions_are_unit_and_densities_positive(u in square(), versine in real(1e-7, 2.0)) {
            for direction in [sphere(u), cosine_hemisphere(u), cone(u, versine)] {
                prop_assert!((direction.as_dvec3().length() - 1.0).abs() < 3e-7, "{direction}");
            }
            prop_assert!(cosine_hemisphere_pdf(cosine_hemisphere(u)) > 0.0);
            prop_assert!(disk(u).length() <= 1.000_000_2);
        }

        /// The ways back lead back, as far as f32 carries: around a pole the angle is lost.
        #[test]
        fn there_and_back(u in square(), versine in real(1e-6, 2.0)) {
            prop_assert!(disk_inverse(disk(u)).abs_diff_eq(u, 1e-6), "disk {}", disk_inverse(disk(u)));
            prop_assert!(cosine_hemisphere_inverse(cosine_hemisphere(u)).abs_diff_eq(u, 1e-6));
            prop_assert!(triangle_inverse(triangle(u)).abs_diff_eq(u, 1e-6));
            let off = |back: Vec2, radius: f32| {
                let turn = (back.y - u.y + 0.5).rem_euclid(1.0) - 0.5;
                (back.x - u.x).abs().max(turn.abs() * radius)
            };
            prop_assert!(off(cone_inverse(cone(u, versine), versine), u.x.sqrt()) < 2e-6);
            prop_assert!(off(sphere_inverse(sphere(u)), sphere(u).truncate().length()) < 2e-6);
        }
    }
}
