//! How much energy a rough surface sends on, by quadrature: the theory that ledgers and tables are held against.
//!
//! Nothing here draws a sample, and the equations of [`microfacet`](crate::microfacet) are written once more, in f64 and
//! over slopes: a sampler and its own weights always agree with each other, this agrees with the model. The functions are
//! for tables, tests and ledgers. They take about a millisecond and use libm, so no picture may depend on their
//! last bits.
//!
//! Facets are spread by `D(m) m.z dm = sinψ cosψ dψ dφ/π` with the slopes `alpha_x tanψ cosφ` and `alpha_y tanψ sinφ`, in
//! which GGX is even; `view` has z > 0 and unit length.

use core::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::DVec3;

/// Panels in ψ, each with the nodes of [`GAUSS`].
const PANELS: usize = 48;

/// Steps in φ.
const STEPS: usize = 96;

/// Half of the nodes and weights of the Gauss-Legendre rule of eight (Abramowitz and Stegun, table 25.4).
pub(crate) const GAUSS: [(f64, f64); 4] = [
    (0.183_434_642_495_65, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887),
    (0.796_666_477_413_627, 0.222_381_034_453_374),
    (0.960_289_856_497_536, 0.101_228_536_290_376),
];

/// The parts of the energy that a rough boundary reflects and transmits; the rest is lost between the facets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Albedo {
    /// Reflected, single scattering.
    pub reflected: f64,
    /// Transmitted, single scattering, as energy: without the squared index ratio of radiance.
    pub transmitted: f64,
}

/// What a rough mirror reflects of the light from `view`, each channel by `fresnel(cosine)`.
pub fn rough_mirror(view: DVec3, alpha: [f64; 2], fresnel: impl Fn(f64) -> DVec3) -> DVec3 {
    over_facets(view, alpha, |m, weight| {
        let light = mirrored(view, m);
        if light.z > 0.0 { fresnel(view.dot(m)) * (weight * g1(light, alpha)) } else { DVec3::ZERO }
    })
}

/// What a rough dielectric reflects and transmits of the light from `view`, in a medium of index `eta_i`.
pub fn rough_dielectric(view: DVec3, alpha: [f64; 2], eta_i: f64, eta_t: f64) -> Albedo {
    let ratio = eta_i / eta_t;
    let both = over_facets(view, alpha, |m, weight| {
        let (reflectance, cos_t) = dielectric(view.dot(m), ratio);
        let [reflected, transmitted] = seen_both_ways(view, m, alpha, ratio, cos_t);
        DVec3::new(weight * reflected * reflectance, weight * transmitted * (1.0 - reflectance), 0.0)
    });
    Albedo { reflected: both.x, transmitted: both.y }
}

/// What a rough boundary reflects and transmits together, where its facets reflect `color(cosine)` and transmit the rest, and
/// reflect all beyond the critical angle: a filmed one, say. `ratio` is the index on the viewer's side over the other.
pub fn rough_boundary(view: DVec3, alpha: [f64; 2], ratio: f64, color: impl Fn(f64) -> DVec3) -> DVec3 {
    over_facets(view, alpha, |m, weight| {
        let cos_i = view.dot(m);
        let (_, cos_t) = dielectric(cos_i, ratio);
        let color = if cos_t > 0.0 { color(cos_i) } else { DVec3::ONE };
        let [reflected, transmitted] = seen_both_ways(view, m, alpha, ratio, cos_t);
        (color * reflected + (DVec3::ONE - color) * transmitted) * weight
    })
}

/// G1 of the mirrored and of the refracted direction; 0 for one on the wrong side.
fn seen_both_ways(view: DVec3, m: DVec3, alpha: [f64; 2], ratio: f64, cos_t: f64) -> [f64; 2] {
    let (up, down) = (mirrored(view, m), m * (ratio * view.dot(m) - cos_t) - view * ratio);
    [if up.z > 0.0 { g1(up, alpha) } else { 0.0 }, if down.z < 0.0 { g1(down, alpha) } else { 0.0 }]
}

/// What a [`sheen`](crate::sheen) of color 1 reflects of the light at a cosine.
pub fn sheen(cosine: f64, alpha: f64) -> f64 {
    let view = at_cosine(cosine);
    let lambda = |cosine: f64| {
        let part = (1.0 - alpha).powi(2);
        let mixed = |rough: f64, fine: f64| rough + (fine - rough) * part;
        let (a, b, c) = (mixed(21.5473, 25.3245), mixed(3.82987, 3.32435), mixed(0.19823, 0.16801));
        let (d, e) = (mixed(-1.9776, -1.27393), mixed(-4.32054, -4.85967));
        let fit = |x: f64| a / (1.0 + b * x.powf(c)) + d * x + e;
        if cosine < 0.5 { fit(cosine).exp() } else { (2.0 * fit(0.5) - fit(1.0 - cosine)).exp() }
    };
    let fitted = 1.0 + lambda(cosine);
    // Over lights by cosθ = t², as the lobe rises towards the horizon.
    gauss(0.0, 1.0, PANELS / 2)
        .map(|(root, width)| {
            let light_z = root * root;
            let sine = (1.0 - light_z * light_z).sqrt();
            let visible = 1.0 / ((fitted + lambda(light_z)) * 4.0 * cosine);
            let ring = (0..STEPS).map(|step| {
                let (y, x) = ((step as f64 + 0.5) * TAU / STEPS as f64).sin_cos();
                let half = (DVec3::new(sine * x, sine * y, light_z) + view).normalize();
                (2.0 + 1.0 / alpha) * half.truncate().length().powf(1.0 / alpha) / TAU
            });
            ring.sum::<f64>() * TAU / STEPS as f64 * visible * 2.0 * root * width
        })
        .sum()
}

/// The mean of a directional albedo `E(cosθ)` over all directions of even light, `2 ∫ E(μ) μ dμ`.
pub fn average(directional: impl Fn(f64) -> f64) -> f64 {
    gauss(0.0, 1.0, PANELS / 4).map(|(cosine, weight)| 2.0 * cosine * weight * directional(cosine)).sum()
}

/// The direction at an angle of the given cosine from the normal, above the local x axis.
pub fn at_cosine(cosine: f64) -> DVec3 {
    DVec3::new((1.0 - cosine * cosine).max(0.0).sqrt(), 0.0, cosine)
}

/// Adds up a function of the facet and of its share of what `view` sees.
fn over_facets(view: DVec3, [alpha_x, alpha_y]: [f64; 2], f: impl Fn(DVec3, f64) -> DVec3) -> DVec3 {
    let mut sum = DVec3::ZERO;
    let seen = g1(view, [alpha_x, alpha_y]) / (view.z * PI);
    for (angle, width) in gauss(0.0, FRAC_PI_2, PANELS) {
        let (sine, cosine) = angle.sin_cos();
        for step in 0..STEPS {
            let (y, x) = ((step as f64 + 0.5) * TAU / STEPS as f64).sin_cos();
            let facet = DVec3::new(alpha_x * sine * x, alpha_y * sine * y, cosine);
            let length = facet.length();
            let m = facet / length;
            let towards = view.dot(m);
            if towards > 0.0 {
                sum += f(m, seen * towards * sine * length * width * TAU / STEPS as f64);
            }
        }
    }
    sum
}

/// Smith's G1 for GGX by the tangent of the angle in the stretched surface.
fn g1(w: DVec3, [alpha_x, alpha_y]: [f64; 2]) -> f64 {
    let tangent2 = ((alpha_x * w.x).powi(2) + (alpha_y * w.y).powi(2)) / (w.z * w.z);
    2.0 / (1.0 + (1.0 + tangent2).sqrt())
}

fn mirrored(view: DVec3, m: DVec3) -> DVec3 {
    m * (2.0 * view.dot(m)) - view
}

/// The Fresnel reflectance and the cosine of refraction for `ratio = eta_i/eta_t`.
fn dielectric(cos_i: f64, ratio: f64) -> (f64, f64) {
    let sin2_t = ratio * ratio * (1.0 - cos_i * cos_i);
    if sin2_t >= 1.0 {
        return (1.0, 0.0);
    }
    let cos_t = (1.0 - sin2_t).sqrt();
    let s = (ratio * cos_i - cos_t) / (ratio * cos_i + cos_t);
    let p = (cos_i - ratio * cos_t) / (cos_i + ratio * cos_t);
    (0.5 * (s * s + p * p), cos_t)
}

/// Nodes and weights of the composite Gauss-Legendre rule.
fn gauss(from: f64, to: f64, panels: usize) -> impl Iterator<Item = (f64, f64)> {
    let half = 0.5 * (to - from) / panels as f64;
    (0..panels).flat_map(move |panel| {
        let middle = from + half * (2 * panel + 1) as f64;
        GAUSS.into_iter().flat_map(move |(node, weight)| {
            [(middle - half * node, half * weight), (middle + half * node, half * weight)]
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fresnel::FresnelModel;
    use crate::microfacet::{Ggx, RoughDielectric};
    use crate::statistics::Focus;
    use glam::Vec3;

    const ALPHAS: [[f64; 2]; 4] = [[0.1, 0.1], [0.3, 0.3], [1.0, 1.0], [0.2, 0.6]];

    /// With the Fresnel equations for its color a boundary is a dielectric, and one that reflects nothing it could transmit
    /// still reflects all beyond the critical angle.
    #[test]
    fn boundaries_of_any_color() {
        for (cosine, alpha, [eta_i, eta_t]) in
            [(1.0, 0.1, [1.0, 1.5]), (0.6, 0.3, [1.0, 1.5]), (0.5, 0.3, [1.5, 1.0]), (0.1, 0.7, [1.33, 1.5])]
        {
            let (view, alpha) = (at_cosine(cosine), [alpha; 2]);
            let fresnel = |cosine: f64| {
                let split = FresnelModel::Exact.dielectric(cosine as f32, eta_i as f32, eta_t as f32);
                DVec3::splat(split.reflectance as f64)
            };
            let Albedo { reflected, transmitted } = rough_dielectric(view, alpha, eta_i, eta_t);
            let found = rough_boundary(view, alpha, eta_i / eta_t, fresnel).x;
            assert!((found - reflected - transmitted).abs() < 1e-6, "{cosine}: {found}");
        }
        let clear = rough_boundary(at_cosine(0.3), [1e-4; 2], 1.5, |_| DVec3::ZERO).x;
        assert!((clear - 1.0).abs() < 1e-3, "{clear}");
    }

    /// The same integral over directions of light instead of facets, through the shading code.
    #[test]
    fn both_domains_agree() {
        for alpha in ALPHAS {
            let facets = Ggx::anisotropic(alpha[0] as f32, alpha[1] as f32);
            for cosine in [0.95, 0.5, 0.1] {
                let view = at_cosine(cosine);
                let focus = Focus::new(Vec3::Z, 1.0);
                let f = |light: Vec3| facets.reflection(view.as_vec3(), light, |_| Vec3::ONE).f_cos.x as f64;
                let (facets, lights) = (rough_mirror(view, alpha, |_| DVec3::ONE).x, focus.total(f));
                assert!((facets - lights).abs() < 2e-4, "{alpha:?} {cosine}: {facets} {lights}");
            }
        }
    }

    /// Reflection and transmission, from both sides, as above.
    #[test]
    fn both_domains_agree_for_glass() {
        for alpha in ALPHAS {
            for (eta_i, eta_t) in [(1.0, 1.5), (1.5, 1.0)] {
                let facets = Ggx::anisotropic(alpha[0] as f32, alpha[1] as f32);
                let glass = RoughDielectric { facets, eta_i, eta_t };
                let fresnel = |cos_i: f32| Vec3::splat(FresnelModel::Exact.dielectric(cos_i, eta_i, eta_t).reflectance);
                for cosine in [0.9, 0.3] {
                    let view = at_cosine(cosine);
                    let f = |light: Vec3| glass.evaluate(view.as_vec3(), light, fresnel).f_cos.x as f64;
                    let above = Focus::SPHERE.total(|light| if light.z > 0.0 { f(light) } else { 0.0 });
                    let below = Focus::SPHERE.total(|light| if light.z < 0.0 { f(light) } else { 0.0 });
                    let albedo = rough_dielectric(view, alpha, eta_i as f64, eta_t as f64);
                    let off = (albedo.reflected - above).abs().max((albedo.transmitted - below).abs());
                    assert!(off < 1e-3, "{alpha:?} {eta_i} {eta_t} {cosine}: {albedo:?} {above} {below}");
                }
            }
        }
    }

    /// A smooth surface loses nothing, and a rough one only shadowing: E = 1 and R + T = 1 at width 0.
    #[test]
    fn smooth_surfaces_lose_nothing() {
        for cosine in [1.0, 0.5, 0.1] {
            let mirror = rough_mirror(at_cosine(cosine), [1e-4, 1e-4], |_| DVec3::ONE).x;
            assert!((mirror - 1.0).abs() < 1e-4, "{cosine}: {mirror}");
            let glass = rough_dielectric(at_cosine(cosine), [1e-4, 1e-4], 1.0, 1.5);
            let smooth = dielectric(cosine, 1.0 / 1.5).0;
            assert!((glass.reflected - smooth).abs() < 1e-4, "{cosine}: {glass:?} {smooth}");
            assert!((glass.transmitted - (1.0 - smooth)).abs() < 1e-4, "{cosine}: {glass:?} {smooth}");
        }
    }

    /// Even light: ½ is the mean of E(μ) = 3μ/4, by hand.
    #[test]
    fn averages_by_hand() {
        assert!((average(|cosine| 0.75 * cosine) - 0.5).abs() < 1e-12);
    }
}
