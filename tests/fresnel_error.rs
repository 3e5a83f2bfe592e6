//! The difference of two Fresnel models over the same paths is that of the models.

use brewster_buffers::{Integrator, SceneBuffers};
use brewster_film::Film;
use brewster_optics::fresnel::FresnelModel;
use brewster_wavefront::Control;
use brewster_wavefront::models::both_models;

use crate::scene::{film, load, parse, render, small_reference};

fn both(scene: &SceneBuffers, model: FresnelModel) -> [Film; 2] {
    let order = *film(scene).order();
    let films = both_models(scene, 0, model, order, 2, &Control::default()).expect("the scene can be rendered");
    films.expect("nobody stopped it")
}

/// A plane of glass above black, seen at 60 degrees in even light: what is seen is F_r times the light.
fn pane(integrator: &str) -> SceneBuffers {
    parse(&format!(
        r#"Scene(
            settings: (integrator: {integrator}, resolution: (6, 4), samples: 4, max_depth: 3, split_depth: 1, roulette: false),
            camera: Orthographic(eye: (0, 1, 1.7320508), target: (0, 0, 0), height: 0.2),
            background: (4, 2, 1),
            entities: [
                (shape: Plane(normal: (0, 1, 0)), material: Dielectric(ior: 1.5)),
                (shape: Plane(normal: (0, 1, 0)), material: Lambert(albedo: 0), at: (0, -1, 0)),
            ],
        )"#
    ))
}

/// By hand: at cos θ = 1/2 Schlick gives 0.04 + 0.96/32 = 0.07 from vacuum to glass of 1.5. The equations: sin θ2 = sin 60°/1.5 = 0.5773503,
/// cos θ2 = 0.8164966; r_s = (0.5 - 1.2247449)/(0.5 + 1.2247449) = -0.4202041, r_p = (0.75 - 0.8164966)/(0.75 + 0.8164966) =
/// -0.0424492; F_r = (0.1765715 + 0.0018019)/2 = 0.0891867. θ2 is smaller than θ1 here: θm changes nothing.
#[test]
fn a_pane_differs_by_hand() {
    for integrator in ["Whitted", "Path"] {
        for model in [FresnelModel::Schlick, FresnelModel::SchlickThetaM] {
            let [exact, other] = both(&pane(integrator), model).map(|film| film.resolve().pixels);
            for row in 0..exact.len() {
                for (channel, light) in [4.0, 2.0, 1.0].into_iter().enumerate() {
                    let difference = other.get(row).color[channel] - exact.get(row).color[channel];
                    let expected = (0.07 - 0.089_186_7) * light;
                    assert!((difference - expected).abs() < 2e-6 * light, "{integrator}: {difference}, not {expected}");
                }
            }
        }
    }
}

/// The exact picture is the ordinary one; a model does not differ from itself.
#[test]
fn the_exact_picture_is_the_ordinary_one() {
    let scenes = ["lake", "smooth", "colored_shadows"].map(load).into_iter();
    for scene in scenes.chain(["glass-rough", "metals-rough", "absorbing-glass"].map(small_reference)) {
        let mut by_equations = scene.clone();
        by_equations.materials.dielectric.view_mut().fresnel.fill(FresnelModel::Exact);
        let (expected, _) = render(&by_equations);
        let [exact, same] = both(&scene, FresnelModel::Exact);
        assert!(exact.pixels().color == expected.pixels().color && exact.pixels().rays == expected.pixels().rays);
        assert!(same.pixels().color == expected.pixels().color);
    }
}

/// In the lecture's algorithm, in which no chance has a say, the other picture is that of a render by the other model, where no
/// boundary is between equal indices: there the equations reflect nothing, and no path goes where Schlick's curve would.
#[test]
fn the_other_picture_is_one_by_the_other_model() {
    for name in ["lake", "colored_shadows", "facing_metals"] {
        let mut scene = load(name);
        assert_eq!(scene.settings.integrator, Integrator::Whitted);
        (scene.settings.samples, scene.settings.contribution_threshold) = (1, 0.0);
        let [_, other] = both(&scene, FresnelModel::Schlick).map(|film| film.resolve().pixels);
        scene.materials.dielectric.view_mut().fresnel.fill(FresnelModel::Schlick);
        let metals = scene.materials.metal.view_mut();
        let with_index = metals.fresnel.iter_mut().zip(&*metals.k).filter(|(_, k)| k.max_element() > 0.0);
        with_index.for_each(|(fresnel, _)| *fresnel = FresnelModel::Schlick);
        let expected = render(&scene).0.resolve().pixels;
        for row in 0..expected.len() {
            let (found, expected) = (other.get(row).color, expected.get(row).color);
            for channel in 0..3 {
                let tolerance = 1e-5 * expected[channel].abs().max(1.0);
                assert!((found[channel] - expected[channel]).abs() < tolerance, "{name}: {found:?}, not {expected:?}");
            }
        }
    }
}
