//! Adaptive sampling stops where the noise is low, saves samples, depends on nothing but the film, and leaves the mean as it is.

use brewster_buffers::{SamplerKind, SceneBuffers};
use brewster_wavefront::{Control, Policy, Renderer};

use crate::scene::{film, render, render_with, small_reference};

const THRESHOLD: f32 = 0.02;
const SAMPLES: u32 = 128;

fn scene(name: &str) -> SceneBuffers {
    let mut scene = small_reference(name);
    scene.settings.samples = SAMPLES;
    scene.settings.noise_threshold = Some(THRESHOLD);
    scene
}

#[test]
fn the_picture_is_the_same_however_work_is_scheduled() {
    for name in ["diffuse-box", "glass-on-checker"] {
        let scene = scene(name);
        let (whole, _) = render(&scene);
        for (batch, threads) in [(1, 1), (100, 2), (4096, 3)] {
            let policy = Policy { batch, ..Policy::default() };
            assert!(render_with(&scene, policy, threads).0 == whole, "{name} by {policy:?} on {threads} threads");
        }
        let mut passes = film(&scene);
        let mut renderer = Renderer::new(&scene, 0, 1, Policy::default(), false).expect("the scene can be rendered");
        for samples in [0..1, 1..20, 20..32, 32..33, 33..SAMPLES] {
            assert!(renderer.pass(samples, &mut passes, &Control::default()));
        }
        assert!(passes == whole, "{name} in passes");
    }
}

/// Every tile stopped at the first look at which its noise was below the threshold: pictures of so many samples, made without
/// one, say so.
#[test]
fn tiles_stop_at_the_first_look_below_the_threshold() {
    let mut scene = scene("diffuse-box");
    let (adaptive, _) = render(&scene);
    scene.settings.noise_threshold = None;
    let looks = [16, 32, 64, SAMPLES];
    let pictures = looks.map(|samples| {
        let mut picture = film(&scene);
        let mut renderer = Renderer::new(&scene, 0, 1, Policy::default(), false).expect("the scene can be rendered");
        assert!(renderer.pass(0..samples, &mut picture, &Control::default()));
        picture
    });
    let mut stopped = [0; 4];
    for tile in adaptive.order().tiles() {
        let expected = (0..3).find(|&look| pictures[look].noise(tile.clone()) < f64::from(THRESHOLD)).unwrap_or(3);
        for pixel in tile.start as usize..tile.end as usize {
            assert_eq!(adaptive.pixels().samples[pixel], looks[expected], "pixel {pixel}");
            assert_eq!(adaptive.pixels().color[pixel], pictures[expected].pixels().color[pixel], "pixel {pixel}");
        }
        stopped[expected] += 1;
    }
    assert!(stopped.iter().filter(|&&tiles| tiles > 0).count() > 1, "all tiles stop alike: {stopped:?}");
    let taken: u32 = adaptive.pixels().samples.iter().sum();
    assert!(taken < SAMPLES * adaptive.order().len() as u32 * 3 / 4, "{taken} samples");
}

#[test]
fn means_over_seeds_agree_with_equal_sampling() {
    const SEEDS: u64 = 12;
    let mut scene = scene("diffuse-box");
    scene.settings.samples = 64;
    scene.settings.sampler = SamplerKind::Independent;
    let mut means = |threshold: Option<f32>, first_seed: u64| -> [f64; 2] {
        scene.settings.noise_threshold = threshold;
        let values: Vec<f64> = (first_seed..first_seed + SEEDS)
            .map(|seed| {
                scene.settings.seed = seed;
                let pixels = render(&scene).0.resolve().pixels;
                pixels.view().color.as_flattened().iter().map(|&value| f64::from(value)).sum()
            })
            .collect();
        let mean = values.iter().sum::<f64>() / SEEDS as f64;
        let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (SEEDS - 1) as f64;
        [mean, variance / SEEDS as f64]
    };
    let ([adaptive, variance], [equal, equal_variance]) = (means(Some(THRESHOLD), 0), means(None, 1000));
    let error = (variance + equal_variance).sqrt();
    assert!((adaptive - equal).abs() < 4.0 * error, "{adaptive}, not {equal} ± {error}");
    assert!(4.0 * error < 0.03 * equal, "the bound says something: {error} of {equal}");
}
