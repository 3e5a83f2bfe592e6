//! The layers of light say what they claim: the parts of the color, the albedo of what is seen, and how far the color may be
//! off.

use brewster_buffers::{Integrator, SamplerKind, SceneBuffers};
use brewster_film::{Layers, LightLayers};
use brewster_tests::agreement::REFERENCES;

use crate::scene::{parse, render, small_reference};

/// Something before the camera that fills the picture, in light of radiance 1 from everywhere.
fn furnace(integrator: Integrator, material: &str) -> SceneBuffers {
    parse(&format!(
        "Scene(
            settings: (resolution: (4, 4), samples: 4, max_depth: 4, integrator: {integrator:?}, roulette: false),
            camera: Orthographic(eye: (0, 0, 4), target: (0, 0, 0), height: 1),
            background: 1,
            entities: [(shape: Quad(size: (4, 4)), material: {material})],
        )"
    ))
}

/// All pixels are alike: reflection, transmission, direct light and albedo of each.
#[track_caller]
fn check(scene: &SceneBuffers, [direct, reflection, transmission, albedo]: [f32; 4]) {
    let (film, _) = render(scene);
    let light = film.resolve().light.expect("the film keeps parts");
    for row in 0..light.len() {
        let LightLayers { albedo: found_albedo, direct: d, reflection: r, transmission: t } = light.get(row);
        let expected = [(d, direct), (r, reflection), (t, transmission), (found_albedo, albedo)];
        let is_near = |(found, expected): ([f32; 3], f32)| found.iter().all(|x| (x - expected).abs() < 1e-6);
        assert!(expected.into_iter().all(is_near), "{expected:?}");
    }
}

/// By hand: glass of index 1.5 reflects 4 % straight on; a thin sheet of it 2·0.04/1.04.
#[test]
fn what_a_surface_reflects_and_transmits_is_told_apart() {
    for integrator in [Integrator::Whitted, Integrator::Path] {
        let emissive = furnace(integrator, "Emissive(radiance: 3)");
        check(&emissive, [3.0, 0.0, 0.0, 0.0]);
        let mirror = furnace(integrator, "Metal(r0: 0.5)");
        check(&mirror, [0.0, 0.5, 0.0, 0.5]);
    }
    let thin = 2.0 * 0.04 / 1.04;
    let sheet = furnace(Integrator::Path, "Dielectric(ior: 1.5, thin: true)");
    check(&sheet, [0.0, thin, 1.0 - thin, 1.0]);
}

/// Light that a lamp brings to the first surface is direct, whatever finds it but a ray that the surface sends on.
#[test]
fn light_sampled_at_the_first_surface_is_direct() {
    let mut scene = parse(
        "Scene(
            settings: (resolution: (4, 4), samples: 4, max_depth: 1, integrator: Path),
            camera: Orthographic(eye: (0, 0, 4), target: (0, 0, 0), height: 1),
            entities: [
                (shape: Quad(size: (4, 4)), material: Lambert(albedo: 0.5)),
                (light: Directional(irradiance: 2)),
            ],
        )",
    );
    // Albedo over pi, times the irradiance.
    check(&scene, [1.0 / std::f32::consts::PI, 0.0, 0.0, 0.5]);
    scene.settings.max_depth = 5;
    check(&scene, [1.0 / std::f32::consts::PI, 0.0, 0.0, 0.5]);
}

#[test]
fn the_parts_are_the_whole() {
    for name in REFERENCES {
        let (film, _) = render(&small_reference(name));
        let (pixels, parts) = (film.pixels(), film.parts().expect("the film keeps parts"));
        let whole = pixels.color.iter().zip(parts.reflection.iter().zip(parts.transmission));
        for (color, (reflection, transmission)) in whole {
            for c in 0..3 {
                assert!(color.0[c] >= reflection.0[c] + transmission.0[c], "{name}: parts beyond the color");
            }
        }
        let Layers { pixels, light, .. } = film.resolve();
        let light = light.expect("the film keeps parts");
        for row in 0..pixels.len() {
            let (color, light) = (pixels.get(row).color, light.get(row));
            for (c, color) in color.into_iter().enumerate() {
                let sum = light.direct[c] + light.reflection[c] + light.transmission[c];
                assert!((sum - color).abs() <= 4.0 * f32::EPSILON * color, "{name}: {sum}, not {color}");
            }
        }
    }
}

/// The mean of the squared errors that pictures state of themselves is the variance from picture to picture.
#[test]
fn standard_errors_are_the_spread_over_seeds() {
    const SEEDS: u64 = 24;
    let mut scene = small_reference("diffuse-box");
    scene.settings.samples = 16;
    scene.settings.sampler = SamplerKind::Independent;
    let mut sums = Vec::new();
    for seed in 0..SEEDS {
        scene.settings.seed = seed;
        let layers = render(&scene).0.resolve();
        let errors = layers.errors.expect("the film keeps squares");
        sums.resize(errors.len(), [0.0; 3]);
        for (pixel, [sum, squares, stated]) in sums.iter_mut().enumerate() {
            let value = f64::from(layers.pixels.get(pixel).color[1]);
            *sum += value;
            *squares += value * value;
            *stated += f64::from(errors[pixel][1]).powi(2);
        }
    }
    // Of each pixel as part of its color's square, so that the brightest do not outweigh all others.
    let n = SEEDS as f64;
    let relative = |value: f64, sum: f64| value * n * n / (sum * sum);
    let pixels = || sums.iter().filter(|[sum, ..]| *sum > 0.0);
    let stated: f64 = pixels().map(|[sum, _, stated]| relative(stated / n, *sum)).sum();
    let (difference, squares) = pixels()
        .map(|[sum, squares, stated]| relative(stated / n - (squares - sum * sum / n) / (n - 1.0), *sum))
        .fold((0.0f64, 0.0), |(sum, squares), difference| (sum + difference, squares + difference * difference));
    let z = difference / squares.sqrt();
    assert!(z.abs() < 4.0, "{z} standard errors");
    // And this says something: a fifth would show.
    assert!(4.0 * squares.sqrt() < 0.2 * stated, "{} of {stated}", squares.sqrt());
}
