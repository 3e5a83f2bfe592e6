//! Thin-film interference: a film so thin that the light from both of its sides adds up as waves.
//!
//! With `q = n cosθ` in each medium (complex where light does not pass), the amplitudes of both sides are
//! `r_s = (q1 - q2)/(q1 + q2)` and `r_p = (n2² q1 - n1² q2)/(n2² q1 + n1² q2)`, a pass through the film of thickness d
//! turns the phase by `β = 2π d q2/λ`, and all internal reflections together give Airy's sum (Born and Wolf, *Principles of
//! Optics*, section 7.6.1): `R = |r12 + r23 e^{2iβ}|²/|1 + r12 r23 e^{2iβ}|²`. What a film over a dielectric does not
//! reflect it transmits.
//!
//! [`Film::reflectance_at`] is that for one wavelength. [`Film::reflectance`] is its average over the band of each channel
//! (those of [`dispersion`](crate::dispersion)): a path that draws its wavelength and one that follows three channels
//! agree in the mean. As in L. Belcour and P. Barla, *A Practical Extension to Microfacet Theory for the Modeling of
//! Varying Iridescence*, SIGGRAPH 2017, the sum is taken order by order, each with the bands' response to an optical path
//! difference. Theirs fits the responses by Gaussians, which leave the range 0..1; here they are tabulated and the orders
//! beyond the last are summed in closed form. For films of index 1.2 to 2.5 it is off by 0.005 at most, and by 0.03 over
//! metal beyond 78°, where single wavelengths resonate.
//!
//! Indices are above 0, and a film's thickness lies in 0..10⁵ nm; one of thickness 0 is none, to the bit. The rays that
//! go on leave at the angles of the boundary without a film: it is too thin to shift them.

use core::f32::consts::TAU;
use core::ops::{Add, Div, Mul, Sub};

use brewster_lanes::math;
use glam::Vec3;

use crate::fresnel::{FresnelModel, Reflectance, conductor};
use crate::spectrum::{BAND_ROWS, BAND_STEP, BANDS};

/// The orders that are added one by one; what follows them is a geometric series. (With four, errors reach 0.04.)
const ORDERS: usize = 6;

/// Steps in the table of responses.
const STEPS: usize = 320;

/// The step in nanometers of path difference. Beyond the last, 8 µm, a channel's colors have run into one another.
const STEP: f64 = 25.0;

/// A path difference in nanometers that stands for all longer ones: far beyond the table, and its sine is still precise.
const LONG: f32 = 1e6;

/// A film of transparent matter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Film {
    /// Its index of refraction.
    pub ior: f32,
    /// Its thickness in nanometers.
    pub thickness: f32,
}

/// What the channels see of waves that are out of step: `∫ b(λ) exp(2πi x (1/λ - k)) dλ` over the path difference x, for
/// the channel's band b and its mean wave number k.
struct Response {
    waves: [[Complex; 3]; STEPS + 1],
    /// k of each channel, per nanometer.
    wave_number: [f32; 3],
}

static RESPONSE: Response = Response::new();

#[derive(Clone, Copy, Debug, PartialEq)]
struct Complex {
    re: f32,
    im: f32,
}

/// What the sides of a film do to a polarization.
#[derive(Clone, Copy)]
struct Sides {
    /// The amplitude that the upper side reflects.
    upper: Complex,
    /// The amplitude that the lower side reflects.
    lower: Complex,
}

/// One ray's way through film and base.
struct Passage {
    s: Sides,
    p: Sides,
    /// `n2 cosθ2`: imaginary where the film is entered by a fading wave only.
    across: Complex,
}

impl Film {
    /// What is reflected in each channel of light that comes from a medium of index `eta_i` and finds, below the film, a
    /// base whose indices are `eta + i k`; k is 0 for a dielectric.
    #[inline(always)]
    pub fn reflectance(&self, cos_i: f32, eta_i: f32, eta: Vec3, k: Vec3) -> Vec3 {
        let channel = |channel| self.channel(channel, cos_i, eta_i, eta[channel], k[channel]);
        Vec3::new(channel(0), channel(1), channel(2))
    }

    /// The same of light of one wavelength, in nanometers, for both polarizations.
    #[inline(always)]
    pub fn reflectance_at(&self, nanometers: f32, cos_i: f32, eta_i: f32, eta: f32, k: f32) -> Reflectance {
        let passage = Passage::new(cos_i, eta_i, self.ior, Complex { re: eta, im: k });
        let turns = (2.0 * self.thickness / nanometers).min(LONG);
        let turn = Complex::wave(TAU * turns * passage.across.re) * math::exp(-TAU * turns * passage.across.im);
        Reflectance { s: passage.s.airy(turn), p: passage.p.airy(turn) }
    }

    #[inline(always)]
    fn channel(&self, channel: usize, cos_i: f32, eta_i: f32, eta: f32, k: f32) -> f32 {
        if self.thickness == 0.0 {
            let dielectric = FresnelModel::Exact.dielectric(cos_i, eta_i, eta).reflectance;
            return if k == 0.0 { dielectric } else { conductor(cos_i, eta_i, eta, k).unpolarized() };
        }
        let passage = Passage::new(cos_i, eta_i, self.ior, Complex { re: eta, im: k });
        if passage.across.im > 0.0 {
            // A wave that fades has hardly a color: one wavelength stands for the channel.
            let nanometers = 1.0 / RESPONSE.wave_number[channel];
            return self.reflectance_at(nanometers, cos_i, eta_i, eta, k).unpolarized();
        }
        let path = (2.0 * self.thickness * passage.across.re).min(LONG);
        0.5 * (passage.s.average(channel, path) + passage.p.average(channel, path))
    }
}

impl Response {
    /// By the trapezoidal rule in steps of 5 nm: a wave turns by less than half from one to the next.
    const fn new() -> Response {
        let mut sums = [[[0.0; 2]; 3]; STEPS + 1];
        let mut mean = [0.0; 3];
        let mut channel = 0;
        while channel < 3 {
            let mut node = 0;
            while node < NODES {
                let (weight, wave_number) = band(channel, node);
                mean[channel] += weight * wave_number;
                node += 1;
            }
            node = 0;
            while node < NODES {
                let (weight, wave_number) = band(channel, node);
                let rotor = small_turn(core::f64::consts::TAU * STEP * (wave_number - mean[channel]));
                let mut wave = [weight, 0.0];
                let mut step = 0;
                while step <= STEPS {
                    sums[step][channel][0] += wave[0];
                    sums[step][channel][1] += wave[1];
                    wave = [wave[0] * rotor[0] - wave[1] * rotor[1], wave[0] * rotor[1] + wave[1] * rotor[0]];
                    step += 1;
                }
                node += 1;
            }
            channel += 1;
        }
        let mut waves = [[Complex::ONE; 3]; STEPS + 1];
        let mut place = 0;
        while place < 3 * (STEPS + 1) {
            let [re, im] = sums[place / 3][place % 3];
            waves[place / 3][place % 3] = Complex { re: re as f32, im: im as f32 };
            place += 1;
        }
        Response { waves, wave_number: [mean[0] as f32, mean[1] as f32, mean[2] as f32] }
    }

    /// The response of a channel to a path difference, but for the turn of its mean wave.
    #[inline(always)]
    fn at(&self, channel: usize, path: f32) -> Complex {
        let place = path * (1.0 / STEP as f32);
        if place >= STEPS as f32 {
            return Complex { re: 0.0, im: 0.0 };
        }
        let step = place as usize;
        let (low, high) = (self.waves[step][channel], self.waves[step + 1][channel]);
        low + (high - low) * (place - step as f32)
    }
}

/// Nodes of the quadrature over wavelengths: the bands' rows and the middles between them.
const NODES: usize = 2 * BAND_ROWS - 1;

/// The part of a channel's light at a node, and the wave number there.
const fn band(channel: usize, node: usize) -> (f64, f64) {
    let value = 0.5 * (BANDS[node / 2][channel] + BANDS[node.div_ceil(2)][channel]);
    let part = if node == 0 || node == NODES - 1 { 0.25 } else { 0.5 };
    (value * part * BAND_STEP, 1.0 / (380.0 + 0.5 * BAND_STEP * node as f64))
}

/// Cosine and sine of a small angle by their series, which compile-time evaluation can do; to the last digits below ½.
const fn small_turn(angle: f64) -> [f64; 2] {
    let (mut term, mut sums, mut n) = (1.0, [0.0, 0.0], 0);
    while n < 16 {
        sums[n % 2] += if n % 4 < 2 { term } else { -term };
        n += 1;
        term *= angle / n as f64;
    }
    sums
}

impl Passage {
    #[inline(always)]
    fn new(cos_i: f32, eta_i: f32, film: f32, base: Complex) -> Passage {
        let cos_i = cos_i.clamp(0.0, 1.0);
        // Snell: n sinθ is the same everywhere. q² = n² - (n1 sinθ1)², with n² - n1² as a product.
        let along = eta_i * eta_i * (1.0 - cos_i) * (1.0 + cos_i);
        let incident = Complex { re: eta_i * cos_i, im: 0.0 };
        let film_square = (film - eta_i) * (film + eta_i) + incident.re * incident.re;
        let within = Complex { re: film_square, im: 0.0 }.root();
        let base_square = base * base;
        let beyond = (base_square - Complex { re: along, im: 0.0 }).root();
        let s = Sides { upper: contrast(incident, within), lower: contrast(within, beyond) };
        let film2 = film * film;
        let p = Sides {
            upper: contrast(incident * film2, within * (eta_i * eta_i)),
            lower: contrast(within * base_square, beyond * film2),
        };
        Passage { s, p, across: within }
    }
}

impl Sides {
    /// Airy's sum, where a wave comes back from the lower side with the factor `turn`.
    #[inline(always)]
    fn airy(self, turn: Complex) -> f32 {
        let echo = self.lower * turn;
        let above = self.upper + echo;
        let below = Complex::ONE + self.upper * echo;
        let square = below.square();
        // Both vanish together only where all is reflected.
        if square > 0.0 { (above.square() / square).min(1.0) } else { 1.0 }
    }

    /// Its average over a channel, for a film that light passes: with `z = -r12 r23 e^{2iβ}`,
    /// `R = 1 - (1-R12) (1-R23)/(1-|z|²) (1 + 2 Re Σ zᵐ)`.
    #[inline(always)]
    fn average(self, channel: usize, path: f32) -> f32 {
        let mean_turn = Complex::wave(TAU * path * RESPONSE.wave_number[channel]);
        let z = Complex { re: 0.0, im: 0.0 } - self.upper * self.lower * mean_turn;
        let mut power = z;
        let mut sum = Complex { re: 0.0, im: 0.0 };
        let (mut last, mut next) = (Complex::ONE, RESPONSE.at(channel, path));
        for order in 1..ORDERS {
            sum = sum + power * next;
            power = power * z;
            (last, next) = (next, RESPONSE.at(channel, path * (order + 1) as f32));
        }
        // From here on as if the response went on to fade at its last rate.
        let fading = if next.square() < last.square() { next / last } else { Complex::ONE };
        let rest = power * next / (Complex::ONE - z * fading);
        let (through, kept) = ((1.0 - self.upper.square()) * (1.0 - self.lower.square()), 1.0 - z.square());
        if through <= 0.0 || kept <= 0.0 {
            return 1.0;
        }
        let series = 1.0 + 2.0 * (sum + rest).re;
        (1.0 - through / kept * series).clamp(0.0, 1.0)
    }
}

/// `(a - b)/(a + b)`; 0 where both are 0 and there is no boundary.
#[inline(always)]
fn contrast(a: Complex, b: Complex) -> Complex {
    let sum = a + b;
    if sum.square() > 0.0 { (a - b) / sum } else { Complex { re: 0.0, im: 0.0 } }
}

impl Complex {
    const ONE: Complex = Complex { re: 1.0, im: 0.0 };

    #[inline(always)]
    fn wave(phase: f32) -> Complex {
        let (im, re) = math::sin_cos(phase);
        Complex { re, im }
    }

    #[inline(always)]
    fn square(self) -> f32 {
        self.re * self.re + self.im * self.im
    }

    /// The root in the first quadrant, for numbers with an imaginary part of 0 or more: waves fade on their way.
    #[inline(always)]
    fn root(self) -> Complex {
        let modulus = self.square().sqrt();
        let larger = (0.5 * (modulus + self.re.abs())).sqrt();
        let smaller = if larger > 0.0 { 0.5 * self.im / larger } else { 0.0 };
        if self.re >= 0.0 { Complex { re: larger, im: smaller } } else { Complex { re: smaller, im: larger } }
    }
}

impl Add for Complex {
    type Output = Complex;
    #[inline(always)]
    fn add(self, other: Complex) -> Complex {
        Complex { re: self.re + other.re, im: self.im + other.im }
    }
}

impl Sub for Complex {
    type Output = Complex;
    #[inline(always)]
    fn sub(self, other: Complex) -> Complex {
        Complex { re: self.re - other.re, im: self.im - other.im }
    }
}

impl Mul for Complex {
    type Output = Complex;
    #[inline(always)]
    fn mul(self, other: Complex) -> Complex {
        Complex { re: self.re * other.re - self.im * other.im, im: self.re * other.im + self.im * other.re }
    }
}

impl Mul<f32> for Complex {
    type Output = Complex;
    #[inline(always)]
    fn mul(self, factor: f32) -> Complex {
        Complex { re: self.re * factor, im: self.im * factor }
    }
}

impl Div for Complex {
    type Output = Complex;
    #[inline(always)]
    fn div(self, other: Complex) -> Complex {
        let conjugate = Complex { re: other.re, im: -other.im };
        self * conjugate * (1.0 / other.square())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dispersion::Wavelength;
    use crate::fresnel::conductor_color;
    use crate::refraction;
    use crate::strategies::{cosine, real};
    use core::f64::consts::PI;
    use glam::DVec3;
    use proptest::prelude::*;

    /// Complex numbers in f64, for the second algorithm.
    type C = (f64, f64);
    fn add(a: C, b: C) -> C {
        (a.0 + b.0, a.1 + b.1)
    }
    fn mul(a: C, b: C) -> C {
        (a.0 * b.0 - a.1 * b.1, a.0 * b.1 + a.1 * b.0)
    }
    fn scale(a: C, f: f64) -> C {
        (a.0 * f, a.1 * f)
    }
    fn div(a: C, b: C) -> C {
        scale(mul(a, (b.0, -b.1)), 1.0 / (b.0 * b.0 + b.1 * b.1))
    }
    fn root(a: C) -> C {
        let modulus = a.0.hypot(a.1);
        let re = ((modulus + a.0) / 2.0).max(0.0).sqrt();
        let im = ((modulus - a.0) / 2.0).max(0.0).sqrt();
        (re, im)
    }

    /// The reflectance by the film's characteristic matrix (Born and Wolf, section 1.6): a second algorithm.
    fn by_matrix(film: Film, cos_i: f64, eta_i: f64, base: C, wavelength: f64, polarization: char) -> f64 {
        let along = (eta_i * (1.0 - cos_i * cos_i).sqrt()).powi(2);
        let squares = [(eta_i * eta_i, 0.0), ((film.ior as f64).powi(2), 0.0), mul(base, base)];
        let q = squares.map(|square| root(add(square, (-along, 0.0))));
        // The admittance of each medium.
        let y: Vec<C> = (0..3).map(|i| if polarization == 's' { q[i] } else { div(squares[i], q[i]) }).collect();
        let phase = scale(q[1], 2.0 * PI * film.thickness as f64 / wavelength);
        let (cos, sin) = (
            (phase.0.cos() * phase.1.cosh(), -phase.0.sin() * phase.1.sinh()),
            (phase.0.sin() * phase.1.cosh(), phase.0.cos() * phase.1.sinh()),
        );
        let minus_i = |z: C| mul((0.0, -1.0), z);
        let electric = add(cos, minus_i(div(mul(sin, y[2]), y[1])));
        let magnetic = add(minus_i(mul(y[1], sin)), mul(y[2], cos));
        let incident = mul(y[0], electric);
        let r = div(add(incident, scale(magnetic, -1.0)), add(incident, magnetic));
        r.0 * r.0 + r.1 * r.1
    }

    fn base(index: f32) -> Vec3 {
        Vec3::splat(index)
    }

    /// Magnesium fluoride of 1.38 on glass of 1.52, a quarter wave at 550 nm: the textbook's 1.3 % (E. Hecht, *Optics*,
    /// section 9.7), by hand ((1.52-1.38²)/(1.52+1.38²))² = 1.2604 %. A quarter wave of index √n is black, and a half
    /// wave is not there.
    #[test]
    fn coated_lenses_by_hand() {
        let left = |ior: f32, wave: f32, glass: f32| {
            let film = Film { ior, thickness: wave * 550.0 / ior };
            film.reflectance_at(550.0, 1.0, 1.0, glass, 0.0).unpolarized()
        };
        assert!((left(1.38, 0.25, 1.52) - 0.012_604).abs() < 1e-5, "{}", left(1.38, 0.25, 1.52));
        assert!(left(1.5, 0.25, 2.25) < 1e-10);
        let bare = FresnelModel::Exact.dielectric(1.0, 1.0, 1.52).reflectance;
        assert!((left(1.38, 0.5, 1.52) - bare).abs() < 1e-6);
        // In each channel a little more than at the best wavelength, and purple: green is suppressed most.
        let film = Film { ior: 1.38, thickness: 550.0 / (4.0 * 1.38) };
        let color = film.reflectance(1.0, 1.0, base(1.52), Vec3::ZERO);
        assert!(color.min_element() > 0.0126 && color.max_element() < 0.02, "{color}");
        assert!(color.y < color.x && color.x < color.z, "{color}");
    }

    /// The colors of a soap film in the order of the path difference between its sides, in nanometers: the sequence of
    /// Michel-Levy's chart (1888), whose light between crossed polarizers follows the same `sin²(π Γ/λ)`.
    #[test]
    fn soap_films_show_newtons_colors() {
        let color = |path: f32| {
            let film = Film { ior: 1.33, thickness: 0.5 * path / 1.33 };
            // Over the brightest that a film can be, 4 F/(1 + F)².
            film.reflectance(1.0, 1.0, Vec3::ONE, Vec3::ZERO) / 0.0772
        };
        assert!(color(1e-3).max_element() < 1e-5 && color(10.0).max_element() < 0.01, "black: {}", color(10.0));
        let [white, yellow, red, purple, indigo] = [259.0, 332.0, 505.0, 565.0, 589.0].map(color);
        assert!(white.min_element() > 0.85, "white: {white}");
        assert!(yellow.min_position() == 2 && yellow.y > 0.85 && yellow.z < 0.6, "bright yellow: {yellow}");
        assert!(red.max_position() == 0 && red.x > 1.5 * red.y, "red-orange: {red}");
        assert!(purple.min_position() == 1, "purple: {purple}");
        assert!(indigo.z > 4.0 * indigo.x.max(indigo.y), "indigo: {indigo}");
        let [blue, green, yellow, red] = [664.0, 780.0, 910.0, 998.0].map(color);
        assert!(blue.z > blue.y && blue.y > blue.x, "sky blue: {blue}");
        assert!(green.max_position() == 1 && green.y > 0.7, "green: {green}");
        assert!(yellow.min_position() == 2 && yellow.x > 0.7 && yellow.y > 0.5, "pure yellow: {yellow}");
        assert!(red.max_position() == 0 && red.y < 0.3, "bright orange-red: {red}");
        // Thick ones are gray: of both sides together R = 2 F/(1 + F).
        let f = FresnelModel::Exact.dielectric(1.0, 1.0, 1.33).reflectance;
        let thick = Film { ior: 1.33, thickness: 1e5 }.reflectance(1.0, 1.0, Vec3::ONE, Vec3::ZERO);
        assert!(thick.abs_diff_eq(Vec3::splat(2.0 * f / (1.0 + f)), 1e-5), "{thick}");
    }

    /// Against the matrix in f64 at every nanometer of the bands, over glass, water, a soap film's air and metals.
    #[test]
    fn colors_are_the_average_over_wavelengths() {
        let bases = [(1.5, 0.0), (1.333, 0.0), (1.0, 0.0), (0.143, 3.983), (2.9, 3.1), (0.6, 5.3)];
        for (eta, k) in bases {
            for ior in [1.2f32, 1.38, 2.0, 2.5] {
                for thickness in [1.0f32, 60.0, 140.0, 333.0, 580.0, 1500.0, 4000.0] {
                    for cos_i in [1.0f32, 0.8, 0.4, 0.2, 0.1, 0.05] {
                        let film = Film { ior, thickness };
                        let color = film.reflectance(cos_i, 1.0, base(eta), base(k));
                        let exact = over_bands(|nanometers| {
                            let index = (eta as f64, k as f64);
                            let one =
                                |polarization| by_matrix(film, cos_i as f64, 1.0, index, nanometers, polarization);
                            0.5 * (one('s') + one('p'))
                        });
                        let off = (color.as_dvec3() - exact).abs().max_element();
                        let limit = if k > 0.0 && cos_i < 0.2 { 0.03 } else { 0.005 };
                        assert!(off < limit, "{film:?} {cos_i} {eta} {k}: {color} {exact}");
                    }
                }
            }
        }
    }

    /// From inside glass to air, below the critical angle of 41.8° and past it, where all is reflected.
    #[test]
    fn films_on_the_far_side_are_seen_through_the_glass() {
        for ior in [1.7f32, 2.3] {
            for cos_i in [1.0f32, 0.8, 0.7, 0.3] {
                let film = Film { ior, thickness: 300.0 };
                let color = film.reflectance(cos_i, 1.5, Vec3::ONE, Vec3::ZERO);
                let exact = over_bands(|nanometers| {
                    let one = |polarization| by_matrix(film, cos_i as f64, 1.5, (1.0, 0.0), nanometers, polarization);
                    0.5 * (one('s') + one('p'))
                });
                assert!((color.as_dvec3() - exact).abs().max_element() < 0.005, "{film:?} {cos_i}: {color} {exact}");
                assert_eq!(color.min_element() > 0.9999, cos_i < 0.74, "{film:?} {cos_i}: {color}");
            }
        }
    }

    /// The average over each band, by the trapezoidal rule in steps of half a nanometer.
    fn over_bands(f: impl Fn(f64) -> f64) -> DVec3 {
        let mut sum = DVec3::ZERO;
        for i in 0..=800 {
            let row = (i / 20).min(BAND_ROWS - 2);
            let t = i as f64 / 20.0 - row as f64;
            let band = |channel: usize| BANDS[row][channel] * (1.0 - t) + BANDS[row + 1][channel] * t;
            let part = if i == 0 || i == 800 { 0.25 } else { 0.5 };
            sum += DVec3::new(band(0), band(1), band(2)) * (part * f(380.0 + 0.5 * i as f64));
        }
        sum
    }

    /// A path that draws its wavelength sees the same color in the mean.
    #[test]
    fn one_wavelength_agrees_with_three_channels() {
        let film = Film { ior: 1.33, thickness: 400.0 };
        let value = |i: usize| {
            let Wavelength { nanometers, weight } = Wavelength::sample((i as f32 + 0.5) / 1e4);
            weight * film.reflectance_at(nanometers, 0.8, 1.0, 1.5, 0.0).unpolarized()
        };
        let mean = (0..10_000).map(|i| value(i).as_dvec3()).sum::<DVec3>().as_vec3() / 1e4;
        let color = film.reflectance(0.8, 1.0, base(1.5), Vec3::ZERO);
        assert!(mean.abs_diff_eq(color, 1e-3), "{mean} {color}");
    }

    /// A film of no thickness is none to the bit, and a thin one tends to it.
    #[test]
    fn without_thickness_there_is_no_film() {
        let (eta, k) = (Vec3::new(0.143, 0.375, 1.442), Vec3::new(3.983, 2.386, 1.603));
        for cos_i in [0.0, 0.1, 0.5, 0.9, 1.0] {
            for eta_i in [1.0, 1.5] {
                let film = |thickness| Film { ior: 1.7, thickness };
                let (gold, glass) =
                    (conductor_color(cos_i, eta_i, eta, k), FresnelModel::Exact.dielectric(cos_i, eta_i, 1.2));
                let colors = |film: Film| {
                    [film.reflectance(cos_i, eta_i, eta, k), film.reflectance(cos_i, eta_i, base(1.2), Vec3::ZERO)]
                };
                let bare = [gold, base(glass.reflectance)];
                assert_eq!(colors(film(0.0)), bare);
                for (thin, bare) in colors(film(1e-4)).into_iter().zip(bare) {
                    assert!(thin.abs_diff_eq(bare, 2e-4), "{cos_i} {eta_i}: {thin} {bare}");
                }
            }
        }
    }

    /// A gap of air between prisms lets light through past the critical angle while it is thin, and then no more.
    #[test]
    fn thin_gaps_leak() {
        let gap = |thickness| Film { ior: 1.0, thickness }.reflectance(0.5, 1.5, base(1.5), Vec3::ZERO);
        assert!(gap(1.0).max_element() < 0.01 && gap(3000.0).min_element() > 0.999, "{} {}", gap(1.0), gap(3000.0));
        let (thin, thick) = (gap(50.0), gap(200.0));
        assert!(thin.cmplt(thick).all() && thin.x < thin.z, "red leaks further: {thin} {thick}");
    }

    fn thickness() -> impl Strategy<Value = f32> {
        prop_oneof![1 => Just(0.0), 4 => real(0.0, 2000.0), 1 => real(0.0, 1.0), 1 => real(0.0, 1e5), 1 => Just(1e30)]
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4096))]

        #[test]
        fn airys_sum_is_the_matrix(
            cos_i in real(0.01, 1.0), eta_i in real(1.0, 2.0), film in real(1.0, 3.0), thickness in real(0.0, 1500.0),
            eta in real(0.1, 4.0), k in real(0.0, 5.0), wavelength in real(380.0, 780.0),
        ) {
            let film = Film { ior: film, thickness };
            let ours = film.reflectance_at(wavelength, cos_i, eta_i, eta, k);
            let matrix = |polarization| {
                by_matrix(film, cos_i as f64, eta_i as f64, (eta as f64, k as f64), wavelength as f64, polarization)
            };
            prop_assert!((ours.s as f64 - matrix('s')).abs() < 2e-4, "{ours:?} {}", matrix('s'));
            prop_assert!((ours.p as f64 - matrix('p')).abs() < 2e-4, "{ours:?} {}", matrix('p'));
        }

        /// Between dielectrics the same part comes through from both sides.
        #[test]
        fn both_sides_are_reciprocal(
            cos_i in real(0.05, 1.0), film in real(1.0, 3.0), thickness in real(0.0, 1500.0), eta in real(1.0, 2.5),
        ) {
            let film = Film { ior: film, thickness };
            let cos_t = refraction::cos_t(cos_i, 1.0, eta).expect("into the denser side");
            let there = film.reflectance(cos_i, 1.0, base(eta), Vec3::ZERO);
            let back = film.reflectance(cos_t, eta, Vec3::ONE, Vec3::ZERO);
            prop_assert!((there - back).abs().max_element() < 1e-3, "{there:?} {back:?}");
        }

        #[test]
        fn reflectances_stay_in_range(
            cos_i in cosine(), eta_i in real(1.0, 3.0), film in real(1.0, 3.0), thickness in thickness(), eta in real(0.05, 5.0),
            k in prop_oneof![Just(0.0), real(0.0, 8.0)],
        ) {
            let film = Film { ior: film, thickness };
            let one = film.reflectance_at(500.0, cos_i, eta_i, eta, k);
            prop_assert!((0.0..=1.0).contains(&one.s) && (0.0..=1.0).contains(&one.p), "{one:?}");
            let color = film.reflectance(cos_i, eta_i, base(eta), base(k));
            prop_assert!(color.min_element() >= 0.0 && color.max_element() <= 1.0, "{color}");
        }
    }
}
