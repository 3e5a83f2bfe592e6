//! What is told of a pixel is what happened: the light of all contributions is the pixel's to the last unit, and a boundary's
//! numbers are those by which its rays were weighed.

use std::collections::BTreeMap;

use brewster_buffers::{MaterialKind, SceneBuffers};
use brewster_film::Light;
use brewster_wavefront::explain::{ExplainError, Explainer, Met, SampleTree};
use brewster_wavefront::queues::RaySource;

use crate::scene::{SCENES, load, render, small_reference};

/// Pixels from all over a picture.
fn pixels(scene: &SceneBuffers) -> impl Iterator<Item = [u32; 2]> {
    let [width, height] = scene.settings.resolution.to_array();
    (0..24).map(move |n| [(n * 7 + 3) * width / 24 % width, (n * 5 + 1) * height / 24 % height])
}

/// The light that the rays of a tree brought.
fn gathered(tree: &SampleTree) -> Light {
    let mut sum = Light::NONE;
    for ray in &tree.rays {
        let found = ray.lights.iter().chain(ray.shadows.iter().filter_map(|shadow| shadow.found.as_ref()));
        found.filter_map(|found| found.light).for_each(|light| sum.add(light));
    }
    sum
}

fn check(name: &str, scene: &SceneBuffers) {
    let (film, _) = render(scene);
    let mut explainer = Explainer::new(scene, 0).expect("the scene can be rendered");
    let mut lit = 0;
    for [x, y] in pixels(scene) {
        let index = film.order().index(x, y).expect("a pixel of the picture") as usize;
        let (mut sum, mut rays) = (Light::NONE, 0);
        for number in 0..scene.settings.samples {
            let tree = explainer.sample([x, y], number).expect("the picture has the pixel and the sample");
            assert_eq!(gathered(&tree), tree.light, "{name} at {x},{y}, sample {number}");
            sum.add(tree.light);
            rays += tree.rays.iter().map(|ray| 1 + ray.passed).sum::<u64>();
            lit += u32::from(tree.light != Light::NONE);
        }
        assert_eq!(sum, film.pixels().color[index], "{name} at {x},{y}");
        assert!(rays <= u64::from(film.pixels().rays[index]), "{name} at {x},{y}: {rays} rays");
    }
    assert!(lit > 0, "{name} is black");
}

#[test]
fn contributions_add_up_to_the_lectures_pictures() {
    for name in SCENES.into_iter().chain(["details", "moving", "moving_paths", "caustics"]) {
        let mut scene = load(name);
        scene.settings.samples = scene.settings.samples.min(3);
        check(name, &scene);
    }
}

#[test]
fn contributions_add_up_to_pictures_of_paths() {
    for name in ["absorbing-glass", "diffuse-box", "glass-rough", "many-lights", "metals-rough", "punctual-lights"] {
        let mut scene = small_reference(name);
        check(name, &scene);
        (scene.settings.split_depth, scene.settings.clamp) = (3, 0.5);
        check(name, &scene);
    }
    for name in ["principled", "fog"] {
        let mut scene = load(name);
        scene.settings.samples = 3;
        check(name, &scene);
    }
}

/// In the lecture's algorithm a reflection weighs F_r and a transmission F_t times what arrived, to the bit.
#[test]
fn rays_weigh_what_is_told_of_their_boundary() {
    let mut splits = 0;
    for name in ["lake", "nested", "smooth", "facing_metals"] {
        let scene = load(name);
        let mut explainer = Explainer::new(&scene, 0).expect("the scene can be rendered");
        for pixel in pixels(&scene) {
            let tree = explainer.sample(pixel, 0).expect("the picture has the pixel");
            for ray in &tree.rays {
                let Some(parent) = ray.parent.map(|parent| &tree.rays[parent]) else { continue };
                let Met::Surface(surface) = &parent.met else { continue };
                let fresnel = surface.fresnel.expect("mirrors and glass alone send rays");
                let factor = match ray.source {
                    RaySource::Reflection => fresnel.f_r,
                    _ => fresnel.f_t,
                };
                assert_eq!(ray.ray.weight, parent.ray.weight * parent.transmittance * factor, "{name} at {pixel:?}");
                let sum = fresnel.f_r + fresnel.f_t;
                assert!(surface.kind == MaterialKind::Metal || (sum - 1.0).abs().max_element() < 1e-6, "{fresnel:?}");
                splits += 1;
            }
        }
    }
    assert!(splits > 100, "{splits} rays were sent on");
}

/// Coats and principled glass tell R_s and R_p of their boundaries; the angle form of the Fresnel equations says what these are.
#[test]
fn layers_are_told_with_their_fresnel_values() {
    let scene = load("principled");
    let mut explainer = Explainer::new(&scene, 0).expect("the scene can be rendered");
    let [width, height] = scene.settings.resolution.to_array();
    let mut seen = BTreeMap::new();
    for pixel in (0..width * height).step_by(3).map(|n| [n % width, n / width]) {
        let tree = explainer.sample(pixel, 0).expect("the picture has the pixel");
        for ray in &tree.rays {
            let Met::Surface(surface) = &ray.met else { continue };
            for (name, fresnel) in &surface.layers {
                *seen.entry(*name).or_insert(0) += 1;
                let (Some(s), Some(p), Some(eta_t)) = (fresnel.r_s, fresnel.r_p, fresnel.eta_t) else {
                    panic!("{name}")
                };
                // A clearcoat and a metal below a coat are met at angles of their own.
                if matches!(*name, "clearcoat" | "metal below") || fresnel.is_total || surface.cosine > 0.999 {
                    continue;
                }
                let incidence = f64::from(surface.cosine).acos();
                let refraction = (incidence.sin() * f64::from(fresnel.eta_i / eta_t.x)).asin();
                let [difference, sum] = [incidence - refraction, incidence + refraction];
                let expected = [difference.sin() / sum.sin(), difference.tan() / sum.tan()].map(|root| root * root);
                for (found, expected) in [f64::from(s.x), f64::from(p.x)].into_iter().zip(expected) {
                    assert!((found - expected).abs() < 2e-4, "{name} at {}: {found}, not {expected}", surface.cosine);
                }
            }
        }
    }
    assert!(
        ["clearcoat", "transmission", "coat", "metal below"].iter().all(|name| seen.contains_key(name)),
        "{seen:?}"
    );
}

#[test]
fn what_is_not_in_the_picture_is_refused() {
    let scene = load("lake");
    let [width, height] = scene.settings.resolution.to_array();
    let mut explainer = Explainer::new(&scene, 0).expect("the scene can be rendered");
    for outside in [[width, 0], [0, height], [u32::MAX; 2]] {
        let error = explainer.sample(outside, 0).expect_err("there is no such pixel");
        assert!(matches!(error, ExplainError::Outside(size) if size == [width, height]), "{error}");
        assert!(error.to_string().contains(&format!("{width} x {height}")), "{error}");
    }
    let error = explainer.sample([0, 0], scene.settings.samples).expect_err("there is no such sample");
    assert!(matches!(error, ExplainError::NoSuchSample(_)), "{error}");
    assert!(matches!(Explainer::new(&scene, 9), Err(ExplainError::Unsupported(_))));
}
