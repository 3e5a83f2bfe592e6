//! Light that is held back, the largest contributions and those that are no light are told with what they came from.

use brewster_film::SCALE;
use brewster_tests::agreement::REFERENCES;

use crate::scene::{parse, render, small_reference};

/// What the clamp took is what is missing, but for the rounding of a single number to each contribution; and nothing is missing of
/// what is seen directly.
#[test]
fn what_the_clamp_takes_is_what_is_missing() {
    for name in REFERENCES {
        let mut scene = small_reference(name);
        let (whole, stats) = render(&scene);
        assert_eq!(stats.total().clamped.0, [0; 3], "{name}");
        let Some(largest) = stats.attribution.largest().first() else { panic!("{name}: nothing came by a surface") };
        let largest = largest.radiance.max_element();

        scene.settings.clamp = 0.25 * largest;
        let (clamped, stats) = render(&scene);
        let direct =
            |film: &brewster_film::Film| film.resolve().light.expect("the film keeps parts").view().direct.to_vec();
        assert!(direct(&whole) == direct(&clamped), "{name}: direct light is clamped");
        let sum = |film: &brewster_film::Film, c: usize| {
            film.pixels().color.iter().map(|light| light.0[c] as f64).sum::<f64>()
        };
        for c in 0..3 {
            let (missing, taken) = (sum(&whole, c) - sum(&clamped, c), stats.total().clamped.0[c] as f64);
            assert!(taken >= 0.0 && (missing - taken).abs() < 1e-6 * sum(&whole, c), "{name}: {missing}, not {taken}");
        }
        assert!(stats.total().clamped.0.iter().any(|&taken| taken > 0), "{name}: nothing is clamped");
    }
}

/// A clamp at the largest contribution takes nothing, one just below it does.
#[test]
fn no_contribution_is_larger_than_the_largest() {
    for name in ["diffuse-box", "glass-rough", "metals-rough"] {
        let mut scene = small_reference(name);
        let stats = render(&scene).1;
        let largest = stats.attribution.largest();
        assert_eq!(largest.len(), 16, "{name}");
        assert!(largest.iter().all(|origin| origin.trail.to_string().len() > "C L".len()), "{name}: {largest:?}");
        let value = largest[0].radiance.max_element();
        for (clamp, takes) in [(value, false), (value * 0.999, true)] {
            scene.settings.clamp = clamp;
            let clamped = render(&scene).1.total().clamped.0;
            assert_eq!(clamped.iter().any(|&taken| taken > 0), takes, "{name} at {clamp}: {clamped:?}");
        }
    }
}

/// A lamp so bright that its light on a floor is no number: the floor sent it, toward a light.
#[test]
fn what_is_no_light_is_told_with_where_it_came_from() {
    let scene = parse(
        "Scene(
            settings: (resolution: (8, 8), samples: 4, max_depth: 1, integrator: Path),
            camera: Orthographic(eye: (0, 5, 0), target: (0, 0, 0), up: (0, 0, -1), height: 1),
            entities: [
                (shape: Quad(size: (4, 4)), material: Lambert(albedo: 0.5), rotate: (x: -90)),
                (light: Point(intensity: 3e38), at: (0, 0.1, 0)),
            ],
        )",
    );
    let (film, stats) = render(&scene);
    let origins = stats.attribution.not_light();
    assert_eq!(origins.len(), 16);
    assert!(film.rejected() > 16, "{}", film.rejected());
    for origin in origins {
        assert_eq!((origin.depth, origin.instance, origin.trail.to_string().as_str()), (0, 0, "C L"));
        assert!(!origin.radiance.is_finite(), "{origin:?}");
    }
    assert!(origins.is_sorted_by_key(|origin| (origin.pixel, origin.sample)), "{origins:?}");
    assert!(film.pixels().color.iter().all(|light| light.0.iter().all(|&sum| sum as f64 / SCALE < 3e38)));
}
