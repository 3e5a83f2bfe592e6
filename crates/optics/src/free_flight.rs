//! Free flights: how far light comes in a medium that scatters, before it is scattered.
//!
//! A medium takes from a ray what it absorbs and what it scatters; the rest, `exp(-(σ_a + σ_s) · distance)`, goes straight on. A
//! path draws where it is scattered. Each channel has a density of its own for that, so a channel is drawn first, and
//! the path then weighs as if each channel had drawn the distance as often as it does (the balance heuristic of E. Veach and
//! L. Guibas 1995 with one sample, as in P. Kutz et al. 2017, "Spectral and decomposition tracking"): in the mean nothing is lost,
//! and a path never weighs more than the bound at [`Flight::factor`].

use brewster_lanes::math;
use glam::Vec3;

use crate::absorption::transmittance;

/// What became of light on its way through a medium.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flight {
    /// Where it is scattered, in meters; none if it comes all the way.
    pub scattered_at: Option<f32>,
    /// What its weight is multiplied by; the weight is then at most twice the sum of the channels that set out.
    pub factor: Vec3,
}

/// The part of what a medium takes from a ray that it scatters: its single-scattering albedo. 0 where it takes nothing.
#[inline(always)]
pub fn albedo(absorption: Vec3, scattering: Vec3) -> Vec3 {
    let extinction = absorption + scattering;
    Vec3::select(extinction.cmpgt(Vec3::ZERO), scattering / extinction, Vec3::ZERO)
}

/// Draws how far light of some weight comes on a way of `reach` meters, which may be infinite, with a number for the channel and
/// one for the distance, 0 ≤ u < 1. Both coefficients are per meter and at least 0.
#[inline]
pub fn flight(absorption: Vec3, scattering: Vec3, weight: Vec3, [channel, u]: [f32; 2], reach: f32) -> Flight {
    let extinction = absorption + scattering;
    // A channel counts by its light, and half of that by what scattering leaves of it: those that are absorbed soon are not
    // followed as often, and none is left out that may come all the way.
    let parts = weight * (0.5 + 0.5 * albedo(absorption, scattering));
    let sum = parts.x + parts.y + parts.z;
    if !(sum > 0.0 && sum < f32::INFINITY) {
        return Flight { scattered_at: None, factor: transmittance(extinction, reach) };
    }
    let place = channel * sum;
    let drawn = if place < parts.x {
        extinction.x
    } else if place < parts.x + parts.y {
        extinction.y
    } else {
        extinction.z
    };
    let distance = if drawn > 0.0 { (0.0 - math::ln(1.0 - u)) / drawn } else { f32::INFINITY };
    if distance < reach {
        let left = transmittance(extinction, distance);
        let density = parts.dot(extinction * left) / sum;
        return Flight { scattered_at: Some(distance), factor: scattering * left / density };
    }
    let left = transmittance(extinction, reach);
    Flight { scattered_at: None, factor: left * (sum / parts.dot(left)) }
}

/// The single-scattering albedo of a dense medium that looks as if each of many scatterings left `color`, 0 to 1, by the fit of
/// C. Kulla and A. Conty, *Revisiting Physically Based Shading at Imageworks*, 2017, that KHR_materials_volume_scatter prescribes.
pub fn albedo_of_color(color: Vec3) -> Vec3 {
    let root = (9.592_17 + 41.680_8 * color + 17.712_6 * color * color).to_array().map(f32::sqrt);
    let s = 4.097_12 + 4.208_63 * color - Vec3::from_array(root);
    (1.0 - s * s).clamp(Vec3::ZERO, Vec3::ONE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::{Random, chi_squared};

    /// Some media: gray, colored, one that scatters in one channel and absorbs in another, one that is clear in a channel.
    fn media() -> [(Vec3, Vec3); 5] {
        [
            (Vec3::ZERO, Vec3::splat(2.0)),
            (Vec3::new(0.1, 1.0, 5.0), Vec3::new(3.0, 1.0, 0.5)),
            (Vec3::new(0.0, 4.0, 0.0), Vec3::new(4.0, 0.0, 0.2)),
            (Vec3::ZERO, Vec3::new(30.0, 1.0, 0.0)),
            (Vec3::splat(2.0), Vec3::ZERO),
        ]
    }

    /// What comes through is Beer's and Lambert's, what is scattered the albedo's part of the rest, in the mean over flights.
    #[test]
    fn nothing_is_lost_in_mean() {
        let mut random = Random::new(11);
        for (absorption, scattering) in media() {
            for weight in [Vec3::ONE, Vec3::new(0.2, 1.0, 0.01), Vec3::new(1.0, 0.0, 0.0)] {
                for reach in [0.05, 0.7, 20.0, f32::INFINITY] {
                    let count = 20_000;
                    let mut sums = [[0f64; 2]; 6];
                    for _ in 0..count {
                        let u = random.square().to_array();
                        let Flight { scattered_at, factor } = flight(absorption, scattering, weight, u, reach);
                        let left = (weight * factor).to_array();
                        let most = 2.0 * (weight.x + weight.y + weight.z);
                        assert!(left.iter().all(|&left| left <= most * 1.0001), "{absorption} {scattering}: {left:?}");
                        let start = if scattered_at.is_some() { 3 } else { 0 };
                        for (sum, left) in sums[start..].iter_mut().zip(left) {
                            *sum = [sum[0] + f64::from(left), sum[1] + f64::from(left).powi(2)];
                        }
                    }
                    for (place, [sum, squares]) in sums.into_iter().enumerate() {
                        let channel = place % 3;
                        let [a, s, weight] = [absorption, scattering, weight].map(|color| f64::from(color[channel]));
                        let through = if a + s > 0.0 { (-(a + s) * f64::from(reach)).exp() } else { 1.0 };
                        let part = if a + s > 0.0 { s / (a + s) } else { 0.0 };
                        let expected = weight * if place < 3 { through } else { part * (1.0 - through) };
                        let (mean, count) = (sum / f64::from(count), f64::from(count));
                        let error = ((squares / count - mean * mean).max(0.0) / count).sqrt();
                        assert!(
                            (mean - expected).abs() < 5.0 * error + 1e-5,
                            "{absorption} {scattering} {weight} {reach} place {place}: {mean} ± {error}, {expected}"
                        );
                    }
                }
            }
        }
    }

    /// In a gray medium distances are exponential, and a flight weighs the albedo.
    #[test]
    fn distances_are_exponential() {
        let mut random = Random::new(3);
        let (mut counts, cells, total) = (vec![0.0; 21], 20, 200_000);
        for _ in 0..total {
            let u = random.square().to_array();
            let found = flight(Vec3::splat(0.5), Vec3::splat(1.5), Vec3::ONE, u, 2.0);
            let cell = found.scattered_at.map_or(cells, |distance| ((distance * 10.0) as usize).min(cells - 1));
            let expected = if found.scattered_at.is_some() { 0.75 } else { 1.0 };
            assert!((found.factor - expected).abs().max_element() < 1e-5, "{found:?}");
            counts[cell] += 1.0;
        }
        let beyond = |cell: usize| (-2.0 * cell as f64 / 10.0).exp();
        let mut expected: Vec<f64> = (0..cells).map(|cell| beyond(cell) - beyond(cell + 1)).collect();
        expected.push(beyond(cells));
        expected.iter_mut().for_each(|part| *part *= f64::from(total));
        chi_squared("distances", &counts, &expected, 1e-4);
    }

    /// By hand from the extension's formula, in f64: 1 - (4.09712 + 4.20863 c - √(9.59217 + 41.6808 c + 17.7126 c²))².
    #[test]
    fn colors_become_albedos_as_the_extension_says() {
        let expected = |color: f64| {
            let s = 4.09712 + 4.20863 * color - (9.59217 + 41.6808 * color + 17.7126 * color * color).sqrt();
            1.0 - s * s
        };
        for color in [0.0f32, 0.1, 0.5, 0.8, 0.99, 1.0] {
            let found = f64::from(albedo_of_color(Vec3::splat(color)).y);
            assert!((found - expected(f64::from(color)).clamp(0.0, 1.0)).abs() < 1e-5, "{color}: {found}");
        }
        // Black scatters nothing, white all.
        assert!(albedo_of_color(Vec3::ZERO).x < 1e-4 && albedo_of_color(Vec3::ONE).x > 0.999_99);
    }
}
