//! In a white furnace nothing can be seen that absorbs nothing: whatever stands in even light of radiance 1 shows 1.

use brewster_buffers::{Integrator, SceneBuffers};

use crate::scene::{parse, render};

/// A picture's mean, and its standard error over pixels.
fn mean(scene: &SceneBuffers) -> (f64, f64) {
    let (film, _) = render(scene);
    let picture = film.resolve();
    let values: Vec<f64> = (0..picture.pixels.len())
        .map(|pixel| picture.pixels.get(pixel).color.iter().map(|&value| f64::from(value)).sum::<f64>() / 3.0)
        .collect();
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0);
    (mean, (variance / count).sqrt())
}

fn furnace(material: &str) -> SceneBuffers {
    let mut scene = parse(&format!(
        "Scene(
            settings: (resolution: (16, 16), samples: 64, max_depth: 64, filter: Box),
            camera: Perspective(eye: (0, 0, 4), target: (0, 0, 0), vfov: 20),
            background: 1,
            entities: [(shape: Sphere(radius: 1), material: {material})],
        )"
    ));
    scene.settings.integrator = Integrator::Path;
    scene
}

#[test]
fn a_lambert_ball_shows_its_albedo() {
    let (mean, error) = mean(&furnace("Lambert(albedo: (0.5, 0.5, 0.5))"));
    assert!((mean - 0.5).abs() < 4.0 * error + 1e-6, "{mean} ± {error}");
}

#[test]
fn glass_vanishes() {
    let (mean, error) = mean(&furnace("Dielectric(ior: 1.5)"));
    assert!((mean - 1.0).abs() < 4.0 * error + 1e-5, "{mean} ± {error}");
}
