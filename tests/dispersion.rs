//! Dispersion against Snell's law and the Fresnel equations, wavelength by wavelength.

use brewster_optics::dispersion::Wavelength;
use glam::DVec3;

use crate::scene::{parse, picture};

/// Rays at 45° into a sea whose index is `1.3 + 0.08/λ²`, over a floor 1 m below that glows the more the farther out: each
/// wavelength meets it elsewhere, and dims by its own squared index.
#[test]
fn every_wavelength_meets_the_floor_where_snell_says() {
    let scene = parse(
        "Scene(
            settings: (integrator: Path, resolution: (2, 2), samples: 4096, max_depth: 4, split_depth: 1, filter: Box),
            camera: Orthographic(eye: (0, 2, 2), target: (0, 0, 0), height: 0.01),
            background: 0.5,
            entities: [
                (shape: Plane(), material: Dielectric(dispersion: Cauchy(a: 1.3, b: 0.08))),
                (
                    shape: Quad(size: (2, 2)), rotate: (x: -90), at: (0, -1, 0),
                    material: Emissive(radiance: Gradient(from: 0, to: 4, axis: V)),
                ),
            ],
        )",
    );
    let pixels = picture(&scene);
    let found = pixels.iter().map(|(_, color)| *color).sum::<DVec3>() / pixels.len() as f64;
    let cos_i = 0.5f64.sqrt();
    let wavelengths = 10_000;
    let expected = (0..wavelengths).map(|i| {
        let Wavelength { nanometers, weight } = Wavelength::sample((i as f32 + 0.5) / wavelengths as f32);
        let n = 1.3 + 0.08 / (1e-3 * f64::from(nanometers)).powi(2);
        let cos_t = (1.0 - 0.5 / (n * n)).sqrt();
        let (s, p) = ((cos_i - n * cos_t) / (cos_i + n * cos_t), (n * cos_i - cos_t) / (n * cos_i + cos_t));
        let reflected = 0.5 * (s * s + p * p);
        let tangent = (1.0 - cos_t * cos_t).sqrt() / cos_t;
        let glow = 4.0 * (0.5 + 0.5 * tangent);
        weight.as_dvec3() * (0.5 * reflected + (1.0 - reflected) * glow / (n * n))
    });
    let expected = expected.sum::<DVec3>() / f64::from(wavelengths);
    // Between red and blue lie 15 %; 16,384 wavelengths a color, one in each of as many equal strips.
    assert!((found / expected - 1.0).abs().max_element() < 1e-3, "{found} instead of {expected}");
    assert!(found.x > 1.1 * found.z, "{found}");
}
