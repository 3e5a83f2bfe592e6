//! The path integrator in a white furnace: in even light of radiance 1 a ball shows what its surface does not absorb.
//!
//! What rough surfaces lose, because light that meets a second facet is lost in the model, is known from quadratures of it.

use std::f64::consts::TAU;

use brewster_buffers::SceneBuffers;
use brewster_optics::albedo::{at_cosine, rough_mirror};
use brewster_optics::dispersion::Wavelength;
use brewster_optics::rough_diffuse::RoughDiffuse;
use brewster_wavefront::Policy;
use glam::{DVec3, Vec3};

use crate::scene::{parse, picture, render_with};

/// Width of the pictures in pixels; they show the middle 1.4 m of a ball of radius 1 m, all of it surface.
const SIZE: u32 = 16;

fn furnace(material: &str) -> SceneBuffers {
    parse(&format!(
        "Scene(
            settings: (integrator: Path, resolution: ({SIZE}, {SIZE}), samples: 256, max_depth: 200, filter: Box),
            camera: Orthographic(eye: (0, 0, 4), target: (0, 0, 0), height: 1.4),
            background: 1,
            entities: [(shape: Sphere(radius: 1), material: {material})],
        )"
    ))
}

/// The mean of the picture by channel, its standard error over pixels, and the energy that the ledger misses of each camera
/// ray's, by theory.
fn render(material: &str) -> (DVec3, DVec3, DVec3) {
    let scene = furnace(material);
    let (film, stats) = render_with(&scene, Policy { ledger: true, ..Policy::default() }, 1);
    let picture = film.resolve().pixels;
    let values: Vec<DVec3> = (0..picture.len()).map(|row| DVec3::from(picture.get(row).color.map(f64::from))).collect();
    let count = values.len() as f64;
    let mean = values.iter().sum::<DVec3>() / count;
    let variance = values.iter().map(|&value| (value - mean) * (value - mean)).sum::<DVec3>() / (count - 1.0);
    let rays = count * f64::from(scene.settings.samples);
    let absorbed = DVec3::from(stats.ledger().absorbed.value()) / rays;
    (mean, (variance / count).powf(0.5), absorbed)
}

/// The mean over the picture of an albedo, which depends on the cosine of the view.
fn expected(albedo: impl Fn(f64) -> DVec3) -> DVec3 {
    const STEPS: usize = 64;
    let table: Vec<DVec3> = (0..=STEPS).map(|step| albedo((step as f64 / STEPS as f64).max(1e-3))).collect();
    let at = |cosine: f64| {
        let place = cosine * STEPS as f64;
        let step = (place as usize).min(STEPS - 1);
        table[step].lerp(table[step + 1], place - step as f64)
    };
    let side = 100;
    let place = |i: usize| 1.4 * ((i as f64 + 0.5) / side as f64 - 0.5);
    let places = (0..side * side).map(|i| (place(i % side), place(i / side)));
    places.map(|(x, y)| at((1.0 - x * x - y * y).sqrt())).sum::<DVec3>() / (side * side) as f64
}

/// Holds a picture's mean against its expectation, to 4.5 standard errors and the error of the tables.
fn check(material: &str, expected: DVec3) {
    let (mean, error, _) = render(material);
    let allowed = 4.5 * error + DVec3::splat(2e-4);
    assert!((mean - expected).abs().cmple(allowed).all(), "{material}: {mean} ± {error}, by theory {expected}");
}

#[test]
fn nothing_is_lost_where_nothing_absorbs() {
    check("Lambert(albedo: 1)", DVec3::ONE);
    check("Metal(r0: 1)", DVec3::ONE);
    check("Dielectric(ior: 1.5)", DVec3::ONE);
    check("Dielectric(ior: 2.4)", DVec3::ONE);
    check("Dielectric(ior: 1.5, thin: true)", DVec3::ONE);
    check("Dielectric(ior: 1.7, dispersion: Abbe(number: 20))", DVec3::ONE);
    check("Dielectric(ior: 1.5, film: (ior: 1.33, thickness: 400))", DVec3::ONE);
    check("Dielectric(ior: 1, film: (ior: 1.33, thickness: 300))", DVec3::ONE);
    check("Dielectric(ior: 1.5, thin: true, film: (ior: 2, thickness: 150))", DVec3::ONE);
    let clear = "base_color: 1, transmission: 1, roughness: 0";
    check(&format!("Principled({clear}, volume: ())"), DVec3::ONE);
    check(&format!("Principled({clear})"), DVec3::ONE);
    check(&format!("Principled({clear}, ior: 1, volume: ())"), DVec3::ONE);
    check(&format!("Principled({clear}, volume: (abbe: 20), iridescence: ())"), DVec3::ONE);
    check(&format!("Principled({clear}, metallic: 0.5, diffuse_transmission: 1)"), DVec3::ONE);
    check("Principled(base_color: 1, specular: 0, diffuse_transmission: 0.5)", DVec3::ONE);
    for roughness in [0.0, 0.3, 1.0] {
        check(&format!("RoughDiffuse(albedo: 1, roughness: {roughness})"), DVec3::ONE);
    }
}

#[test]
fn diffuse_balls_show_their_albedo() {
    check("Lambert(albedo: (0.2, 0.5, 0.9))", DVec3::new(0.2, 0.5, 0.9));
    for roughness in [0.3, 1.0] {
        let albedo = RoughDiffuse { albedo: Vec3::new(0.2, 0.5, 0.9), roughness };
        let theory = expected(|cosine| albedo.directional_albedo(cosine as f32).as_dvec3());
        check(&format!("RoughDiffuse(albedo: (0.2, 0.5, 0.9), roughness: {roughness})"), theory);
    }
}

/// Schlick's curve in f64, from its definition.
fn schlick(r0: DVec3, cosine: f64) -> DVec3 {
    r0 + (DVec3::ONE - r0) * (1.0 - cosine).powi(5)
}

#[test]
fn rough_metals_lose_what_meets_a_second_facet() {
    let r0 = DVec3::new(1.0, 0.7, 0.3);
    check("Metal(r0: (1, 0.7, 0.3))", expected(|cosine| schlick(r0, cosine)));
    for alpha in [0.01, 0.1, 0.3, 0.6, 1.0] {
        let theory = expected(|view| rough_mirror(at_cosine(view), [alpha; 2], |cosine| schlick(r0, cosine)));
        check(&format!("Metal(r0: (1, 0.7, 0.3), alpha: {alpha})"), theory);
    }
}

/// Between the colors of both ends, and the same color everywhere, which a smooth metal shows to the last digits.
#[test]
fn metals_end_in_the_color_that_is_told() {
    let (r0, r90) = (DVec3::new(0.9, 0.5, 0.2), DVec3::new(0.3, 0.5, 0.8));
    let (mean, ..) = render("Metal(r0: (0.9, 0.5, 0.2), r90: (0.9, 0.5, 0.2))");
    assert!((mean - r0).abs().max_element() < 1e-6, "{mean}");
    for alpha in [0.1, 0.6] {
        let even = expected(|view| rough_mirror(at_cosine(view), [alpha; 2], |_| r0));
        check(&format!("Metal(r0: (0.9, 0.5, 0.2), r90: (0.9, 0.5, 0.2), alpha: {alpha})"), even);
        let curve = |cosine: f64| r0 + (r90 - r0) * (1.0 - cosine).powi(5);
        let between = expected(|view| rough_mirror(at_cosine(view), [alpha; 2], curve));
        check(&format!("Metal(r0: (0.9, 0.5, 0.2), r90: (0.3, 0.5, 0.8), alpha: {alpha})"), between);
    }
}

/// A compensated white metal is white, within the precision of the tables.
#[test]
fn compensated_metals_lose_nothing() {
    for alpha in [0.1, 0.4, 1.0] {
        for metal in [
            format!("Metal(r0: 1, alpha: {alpha}, compensated: true)"),
            format!("Principled(metallic: 1, base_color: 1, roughness: {}, compensated: true)", f64::sqrt(alpha)),
        ] {
            let (mean, error, _) = render(&metal);
            assert!((mean - 1.0).abs().max_element() < 5e-3 + 4.5 * error.x, "{metal}: {mean} ± {error}");
        }
    }
}

/// What a coat does not reflect the base does, sooner or later; within the precision of the tables.
#[test]
fn white_below_a_coat_is_white() {
    for coat in ["", "roughness: 0.5", "roughness: 1, ior: 1.8"] {
        let material = format!("Coated(base: Lambert(albedo: 1), {coat})");
        let (mean, error, _) = render(&material);
        assert!((mean - 1.0).abs().max_element() < 0.01 + 4.5 * error.x, "{material}: {mean} ± {error}");
    }
    check("Coated(base: Metal(r0: 1))", DVec3::ONE);
}

/// In rough glass light meets facets any number of times: the picture misses what the ledger expects to be lost, behind
/// a film, too.
#[test]
fn rough_glass_loses_what_theory_expects() {
    for material in [
        "Dielectric(ior: 1.5, alpha: 0.05)",
        "Dielectric(ior: 1.5, alpha: 0.3)",
        "Dielectric(ior: 1.5, alpha: 0.8)",
        "Dielectric(ior: 1.5, alpha: 0.3, film: (ior: 1.33, thickness: 350))",
        "Metal(of: \"Fe\", alpha: 0.3, film: (ior: 2.2, thickness: 60))",
    ] {
        let (mean, error, absorbed) = render(material);
        let allowed = 4.5 * error + DVec3::splat(5e-4);
        assert!((mean + absorbed - 1.0).abs().cmple(allowed).all(), "{material}: {mean} ± {error}, lost {absorbed}");
        assert!(absorbed.x > 0.0, "{material} loses nothing");
    }
}

/// Airy's formula at normal incidence, by textbook for a film that absorbs nothing: `(a² + b² + 2ab cos δ)/(1 + a²b² + 2ab cos δ)`
/// with the amplitudes a and b of both sides and `δ = 4π n d/λ`; averaged over the wavelengths of each channel.
#[test]
fn a_film_shows_its_colors() {
    for (film, thickness, base) in [(1.33, 400.0, 1.0), (1.33, 120.0, 1.6), (2.0, 250.0, 1.5)] {
        let at = |nanometers: f64| {
            let (a, b) = ((1.0 - film) / (1.0 + film), (film - base) / (film + base));
            let wave = 2.0 * a * b * (2.0 * TAU * film * thickness / nanometers).cos();
            (a * a + b * b + wave) / (1.0 + a * a * b * b + wave)
        };
        let sum: DVec3 = (0..10_000)
            .map(|place| Wavelength::sample((place as f32 + 0.5) / 1e4))
            .map(|wavelength| wavelength.weight.as_dvec3() * at(f64::from(wavelength.nanometers)))
            .sum();
        // An opaque surface, so that nothing but the reflection is seen.
        let scene = parse(&format!(
            "Scene(
                settings: (integrator: Path, resolution: (2, 2), samples: 1, filter: Box, roulette: false),
                camera: Orthographic(eye: (0, 0, 4), height: 0.5),
                background: 1,
                entities: [(
                    shape: Quad(),
                    material: Metal(eta: {base}, k: 0, film: (ior: {film}, thickness: {thickness})),
                )],
            )"
        ));
        for (_, color) in picture(&scene) {
            assert!((color - sum / 1e4).abs().max_element() < 0.005, "{film}: {color} instead of {}", sum / 1e4);
        }
    }
}

/// Inside of a ball that shines everywhere with radiance 1 and reflects ρ, d bounces bring 1 + ρ + … + ρᵈ; places on the ball are half
/// of them outside of it by rounding.
#[test]
fn a_ball_lights_itself_from_within() {
    for (depth, expected) in [(0, 1.0), (1, 1.8), (3, 2.952)] {
        let scene = parse(&format!(
            "Scene(
                settings: (integrator: Path, resolution: (32, 32), samples: 16, max_depth: {depth}, roulette: false),
                camera: Perspective(eye: (0.1, 0.2, 0.3), target: (1, 0, 0)),
                entities: [(
                    shape: Sphere(radius: 1),
                    material: Principled(base_color: 0.8, metallic: 0, roughness: 1, specular: 0, emission: 1),
                )],
            )"
        ));
        let pixels = picture(&scene);
        let mean = pixels.iter().map(|(_, color)| color.x).sum::<f64>() / pixels.len() as f64;
        assert!((mean / expected - 1.0).abs() < 0.004, "depth {depth}: {mean}, not {expected}");
    }
}
