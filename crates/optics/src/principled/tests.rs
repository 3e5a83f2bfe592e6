//! What is known of principled surfaces, from sources of their own.

use super::*;
use crate::albedo;
use crate::fresnel::schlick_color;
use crate::lambert;
use crate::statistics::{Focus, Random, SphereTest};
use crate::strategies::{real, unit_vector};
use glam::DVec3;
use proptest::prelude::*;

fn plastic(roughness: f32) -> Parameters {
    Parameters { metallic: 0.0, facets: Ggx::from_roughness(roughness), ..Parameters::default() }
}

/// Everything at once.
fn motley(roughness: f32) -> Parameters {
    Parameters {
        base_color: Vec3::new(0.9, 0.5, 0.1),
        metallic: 0.3,
        facets: Ggx::from_roughness(roughness),
        ior: 1.8,
        specular: 0.7,
        specular_color: Vec3::new(1.0, 0.4, 2.0),
        clearcoat: 0.6,
        clearcoat_facets: Ggx::from_roughness(0.3),
        sheen_color: Vec3::new(0.2, 0.6, 0.4),
        sheen_alpha: 0.25,
        ..Parameters::default()
    }
}

/// Glass of 1.5 behind whose boundary is a volume, seen from outside or from inside.
fn glass(roughness: f32, inside: bool) -> Parameters {
    let [eta_i, eta_t] = if inside { [1.5, 1.0] } else { [1.0, 1.5] };
    Parameters { interface: Interface::Boundary { eta_i, eta_t, inside }, ..sheet(roughness) }
}

fn sheet(roughness: f32) -> Parameters {
    Parameters { transmission: 1.0, ..plastic(roughness) }
}

/// Half of it lets light through, in every way that there is, under layers.
fn window(roughness: f32, inside: bool) -> Parameters {
    Parameters {
        transmission: 0.6,
        diffuse_transmission: 0.5,
        diffuse_transmission_color: Vec3::new(0.2, 0.9, 0.4),
        iridescence: 0.4,
        interface: glass(roughness, inside).interface,
        ..motley(roughness)
    }
}

fn at(cosine: f32) -> Vec3 {
    albedo::at_cosine(cosine as f64).as_vec3()
}

/// What comes back of green light, by an integral over all directions.
fn green(parameters: &Parameters, view: Vec3) -> f64 {
    let surface = Principled::new(parameters);
    let focus = Focus::new(Vec3::new(-view.x, -view.y, view.z), surface.facets.mean_alpha());
    focus.total(|light| surface.evaluate(view, light).f_cos.y as f64)
}

/// The material of glTF's Appendix B in f64, as its "full code" has it, with KHR_materials_specular's fresnel_mix:
/// diffuse and specular part, times the cosine.
fn appendix_b(p: &Parameters, alpha: f64, view: DVec3, light: DVec3) -> [DVec3; 2] {
    let half = (view + light).normalize();
    let (vh, nh, nl, nv) = (view.dot(half), half.z, light.z, view.z);
    let a2 = alpha * alpha;
    let d = a2 / (core::f64::consts::PI * (nh * nh * (a2 - 1.0) + 1.0).powi(2));
    let v = |cosine: f64| 1.0 / (cosine + (a2 + (1.0 - a2) * cosine * cosine).sqrt());
    let specular_brdf = d * v(nl) * v(nv);
    let weight = (1.0 - vh.abs()).powi(5);
    let fresnel = |f0: DVec3| f0 + (DVec3::ONE - f0) * weight;
    let ior = p.ior as f64;
    let f0 = (((1.0 - ior) / (1.0 + ior)).powi(2) * p.specular_color.as_dvec3()).min(DVec3::ONE);
    let (fr, base, metallic) = (fresnel(f0), p.base_color.as_dvec3(), p.metallic as f64);
    let diffuse = base / core::f64::consts::PI * (1.0 - p.specular as f64 * fr.max_element()) * (1.0 - metallic);
    let dielectric = fr * p.specular as f64 * specular_brdf * (1.0 - metallic);
    [diffuse * nl, (dielectric + fresnel(base) * specular_brdf * metallic) * nl]
}

/// The specular part is the appendix's; with a diffuse base, which is coupled in another way, all of it is near.
#[test]
fn the_appendix_is_followed() {
    let mut random = Random::new(29);
    for i in 0..400 {
        let [view, light] = [(); 2].map(|()| warp::cosine_hemisphere(random.square()));
        let roughness = 0.2 + 0.8 * random.unit();
        let colored = Parameters { clearcoat: 0.0, sheen_color: Vec3::ZERO, ..motley(roughness) };
        let alpha = (roughness * roughness) as f64;
        let [diffuse, specular] = appendix_b(&colored, alpha, view.as_dvec3(), light.as_dvec3());
        let black = Principled { diffuse: Vec3::ZERO, ..Principled::new(&colored) };
        let ours = black.evaluate(view, light).f_cos.as_dvec3();
        let close = (ours - specular).abs().max_element() <= 1e-4 * specular.max_element() + 1e-6;
        assert!(close, "{i} {roughness} {view} {light}: {ours} {specular}");
        if view.z.min(light.z) > 0.5f32.sqrt() {
            let ours = Principled::new(&plastic(roughness)).evaluate(view, light).f_cos.as_dvec3();
            let [diffuse, specular] = appendix_b(&plastic(roughness), alpha, view.as_dvec3(), light.as_dvec3());
            let off = (ours - diffuse - specular).abs().max_element() * core::f64::consts::PI;
            assert!(off < 0.05, "{i} {roughness} {view} {light}: {ours} {diffuse} {specular}");
        }
        assert!(diffuse.is_finite());
    }
}

/// All metal is the rough mirror of Schlick's color, and without specular all dielectric is Lambert's.
#[test]
fn both_ends_are_known() {
    let (view, light) = (Vec3::new(0.6, 0.0, 0.8), Vec3::new(0.0, 0.28, 0.96));
    let color = Vec3::new(0.9, 0.6, 0.2);
    let metal = Parameters { base_color: color, facets: Ggx::isotropic(0.3), ..Parameters::default() };
    let expected = metal.facets.reflection(view, light, |cosine| schlick_color(cosine, color));
    let value = Principled::new(&metal).evaluate(view, light);
    assert!(value.f_cos.abs_diff_eq(expected.f_cos, 1e-6) && (value.pdf - expected.pdf).abs() < 1e-6, "{value:?}");
    let chalk = Parameters { specular: 0.0, base_color: color, ..plastic(0.3) };
    let value = Principled::new(&chalk).evaluate(view, light);
    assert!(value.f_cos.abs_diff_eq(lambert::reflected(color, Vec3::ONE, light.z), 1e-6), "{value:?}");
    assert!((value.pdf - warp::cosine_hemisphere_pdf(light)).abs() < 1e-6, "{value:?}");
    // An index of 0 reflects all, as KHR_materials_ior has it.
    let sent = green(&Parameters { ior: 0.0, ..plastic(0.1) }, view);
    assert!((sent - 1.0).abs() < 2e-3, "{sent}");
}

/// A white furnace: white plastic sends back all light at every roughness, a white metal what its facets do by theory,
/// and a mixture of colors what theory says of its facets, and of the diffuse base what those leave.
#[test]
fn a_furnace_finds_what_theory_says() {
    for roughness in [0.1, 0.5, 1.0] {
        for cosine in [0.9, 0.2] {
            let view = at(cosine);
            let white = green(&plastic(roughness), view);
            assert!((white - 1.0).abs() < 5e-3, "{roughness} {cosine}: {white}");
            let metal = Parameters { facets: Ggx::from_roughness(roughness), ..Parameters::default() };
            let alpha = (roughness as f64).powi(2);
            let theory = albedo::rough_mirror(view.as_dvec3(), [alpha; 2], |_| DVec3::ONE).x;
            let sent = green(&metal, view);
            assert!((sent - theory).abs() < 1e-3, "{roughness} {cosine}: {sent} {theory}");
        }
        let view = at(0.5);
        let colored = Parameters { clearcoat: 0.0, sheen_color: Vec3::ZERO, ..motley(roughness) };
        let surface = Principled::new(&colored);
        let facets = |[f0, f90]: [f32; 2]| {
            let schlick = |cosine: f64| DVec3::splat(f0 as f64 + (f90 - f0) as f64 * (1.0 - cosine).powi(5));
            albedo::rough_mirror(view.as_dvec3(), [(roughness as f64).powi(2); 2], schlick).x
        };
        let theory = facets([surface.f0.y, surface.f90]) + surface.diffuse.y as f64 * (1.0 - facets(surface.layer));
        let sent = green(&colored, view);
        assert!((sent - theory).abs() < 5e-3, "{roughness}: {sent} {theory}");
    }
}

/// What further facets send back fills up what first ones lose: a white metal is white.
#[test]
fn compensated_metal_keeps_all_light() {
    for roughness in [0.3, 0.7, 1.0] {
        for cosine in [0.9, 0.2] {
            let facets = Ggx::from_roughness(roughness);
            let metal = Parameters { facets, compensated: true, ..Parameters::default() };
            let sent = green(&metal, at(cosine));
            assert!((sent - 1.0).abs() < 5e-3, "{roughness} {cosine}: {sent}");
            // Half as much metal makes up for half of its loss, and white plastic loses nothing.
            let half = Parameters { metallic: 0.5, ..metal };
            assert!((green(&half, at(cosine)) - 1.0).abs() < 5e-3, "{roughness} {cosine}");
        }
    }
}

/// White under every layer: no more than all light comes back, nor more than stated.
#[test]
fn layers_make_no_energy() {
    for (roughness, sheen_alpha, clearcoat) in [(0.2, 0.0, 0.5), (0.5, 0.3, 0.0), (1.0, 0.04, 1.0)] {
        for cosine in [0.8, 0.1] {
            let white = Parameters {
                sheen_color: Vec3::ONE,
                sheen_alpha,
                clearcoat,
                clearcoat_facets: Ggx::isotropic(0.2),
                ..plastic(roughness)
            };
            let sent = green(&white, at(cosine));
            assert!(sent < 1.005 && sent > 0.4, "{roughness} {cosine}: {sent}");
        }
    }
}

#[test]
fn samples_follow_their_density() {
    for (name, parameters) in
        [("plastic", plastic(0.5)), ("motley", Parameters { compensated: true, ..motley(0.6) }), ("cloth", motley(1.0))]
    {
        for cosine in [0.9, 0.3] {
            let (surface, view) = (Principled::new(&parameters), at(cosine));
            let test = SphereTest { focus: Focus::SPHERE, family: 6 };
            let sample = |u, choice| surface.choose(view, u, choice).map(|sample| sample.direction);
            test.check(&format!("{name} {view}"), sample, |light| surface.evaluate(view, light).chosen_pdf());
            let mut random = Random::new(31);
            let draws = (0..20_000).map(|_| {
                let (u, choice) = (random.square(), random.unit());
                surface.choose(view, u, choice).map_or(0.0, |sample| sample.weight.y as f64)
            });
            let (mean, sent) = (draws.sum::<f64>() / 20_000.0, green(&parameters, view));
            // Weights lie below 3 and mostly near the mean: four standard errors.
            assert!((mean - sent).abs() < 0.02, "{name} {view}: {mean} {sent}");
        }
    }
}

/// Of volumes: what a rough dielectric does, and the base color at the crossing.
#[test]
fn glass_is_a_rough_dielectric_with_a_color() {
    let color = Vec3::new(0.9, 0.5, 0.1);
    for inside in [false, true] {
        let parameters = Parameters { base_color: color, ..glass(0.5, inside) };
        let Interface::Boundary { eta_i, eta_t, .. } = parameters.interface else { unreachable!("a volume") };
        let bare = RoughDielectric { facets: parameters.facets, eta_i, eta_t };
        let exact = |cos_i| Vec3::splat(fresnel::FresnelModel::Exact.dielectric(cos_i, eta_i, eta_t).reflectance);
        let (surface, mut random) = (Principled::new(&parameters), Random::new(3));
        for _ in 0..200 {
            let [view, light] = [(); 2].map(|()| warp::cosine_hemisphere(random.square()));
            for light in [light, -light] {
                let (ours, bare) = (surface.evaluate(view, light), bare.evaluate(view, light, exact));
                let tint = if light.z > 0.0 { Vec3::ONE } else { color };
                assert!(ours.f_cos.abs_diff_eq(bare.f_cos * tint, 1e-5 * bare.f_cos.max_element()), "{view} {light}");
                assert!((ours.chosen_pdf() - bare.chosen_pdf()).abs() <= 1e-5 * bare.pdf, "{view} {light}");
            }
        }
    }
}

/// By hand, at 60° onto 1.5: r_s² = 0.1766, r_p² = 0.0018 (0.0892 in the mean), and sin60°/1.5 = 0.57735 beyond.
#[test]
fn smooth_glass_by_hand() {
    let (color, view) = (Vec3::new(0.5, 0.25, 1.0), Vec3::new(0.75f32.sqrt(), 0.0, 0.5));
    for (parameters, beyond) in [
        (glass(0.0, false), Vec3::new(-0.57735, 0.0, -(2.0f32 / 3.0).sqrt())),
        (sheet(0.0), -view),
        // An index like that in front: nothing is reflected, nothing is bent, and nothing divides by 0.
        (Parameters { interface: Interface::Boundary { eta_i: 1.5, eta_t: 1.5, inside: true }, ..sheet(0.5) }, -view),
    ] {
        let matched = matches!(parameters.interface, Interface::Boundary { eta_i: 1.5, .. });
        let surface = Principled::new(&Parameters { base_color: color, ..parameters });
        assert!(surface.is_smooth() && surface.transmits());
        let LobeSplit { reflection, transmission, .. } = surface.split(view, Vec2::splat(0.5), 0.5);
        let reflected = if matched { 0.0 } else { 0.0892 };
        if let Some(sample) = reflection {
            assert!(sample.direction.abs_diff_eq(Vec3::new(-view.x, 0.0, 0.5), 1e-6) && sample.is_delta());
            assert!(sample.weight.abs_diff_eq(Vec3::splat(reflected), 1e-4), "{sample:?}");
        } else {
            assert!(matched);
        }
        let sample = transmission.expect("light comes through");
        assert!(sample.direction.abs_diff_eq(beyond, 1e-4) && sample.is_delta(), "{sample:?}");
        assert!(sample.weight.abs_diff_eq(color * (1.0 - reflected), 1e-4), "{sample:?}");
    }
}

/// A white furnace for each way through: what facets pass on by theory, all of what diffuse bases get.
#[test]
fn what_comes_through_a_furnace_is_stated() {
    let sent = |parameters: &Parameters, view: Vec3| {
        let surface = Principled::new(parameters);
        Focus::SPHERE.total(|light| surface.evaluate(view, light).f_cos.y as f64)
    };
    for cosine in [0.9, 0.3] {
        let view = at(cosine);
        for inside in [false, true] {
            let [eta_i, eta_t] = if inside { [1.5, 1.0] } else { [1.0, 1.5] };
            let theory = albedo::rough_dielectric(view.as_dvec3(), [0.25; 2], eta_i, eta_t);
            let sent = sent(&glass(0.5, inside), view);
            assert!(
                (sent - theory.reflected - theory.transmitted).abs() < 2e-3,
                "{cosine} {inside}: {sent} {theory:?}"
            );
        }
        let facets = albedo::rough_mirror(view.as_dvec3(), [0.25; 2], |_| DVec3::ONE).x;
        assert!((sent(&sheet(0.5), view) - facets).abs() < 2e-3, "{cosine}");
        let leaf = Parameters { diffuse_transmission: 0.3, ..plastic(0.5) };
        assert!((sent(&leaf, view) - 1.0).abs() < 5e-3, "{cosine}: {}", sent(&leaf, view));
        let thin = Parameters { diffuse_transmission: 0.3, specular: 0.0, ..plastic(0.5) };
        let surface = Principled::new(&thin);
        let through = |light: Vec3| if light.z < 0.0 { surface.evaluate(view, light).f_cos.y as f64 } else { 0.0 };
        assert!((Focus::SPHERE.total(through) - 0.3).abs() < 1e-3, "{cosine}");
    }
    let view = at(0.4);
    for (name, parameters) in [
        ("film on plastic", Parameters { iridescence: 1.0, ..plastic(0.5) }),
        ("film on metal", Parameters { iridescence: 1.0, metallic: 1.0, ..plastic(0.5) }),
        ("film on glass", Parameters { iridescence: 1.0, ..glass(0.5, false) }),
        ("window", window(0.5, false)),
        ("window from inside", window(0.5, true)),
    ] {
        let white = Parameters {
            base_color: Vec3::ONE,
            diffuse_transmission_color: Vec3::ONE,
            specular_color: Vec3::ONE,
            ..parameters
        };
        let sent = sent(&white, view);
        assert!(sent < 1.005 && sent > 0.6, "{name}: {sent}");
    }
}

/// A film of no thickness is none: over metal Schlick's curve gives way to the Fresnel equations, which agree along the normal.
#[test]
fn films_without_thickness_change_little() {
    let film = Film { ior: 1.3, thickness: 0.0 };
    for parameters in [plastic(0.4), Parameters { base_color: Vec3::new(0.9, 0.6, 0.2), metallic: 1.0, ..plastic(0.4) }]
    {
        let [bare, filmed] = [0.0, 1.0].map(|iridescence| Parameters { iridescence, film, ..parameters });
        let value = |parameters| Principled::new(&parameters).evaluate(Vec3::Z, at(0.999)).f_cos;
        let (bare, filmed) = (value(bare), value(filmed));
        assert!(bare.abs_diff_eq(filmed, 0.04 * bare.max_element()), "{bare} {filmed}");
    }
}

/// Over a black base the coat alone is seen: as if the surface were tilted as its own normal is, 20° here.
#[test]
fn a_clearcoat_has_its_own_normal() {
    let tilt = glam::Quat::from_rotation_y(20f32.to_radians());
    let facets = Ggx::isotropic(0.3);
    let coat = Parameters {
        base_color: Vec3::ZERO,
        specular: 0.0,
        clearcoat: 1.0,
        clearcoat_facets: facets,
        clearcoat_normal: tilt * Vec3::Z,
        direction: Vec2::from_angle(0.7),
        ..plastic(0.5)
    };
    let (surface, mut random) = (Principled::new(&coat), Random::new(8));
    for _ in 0..100 {
        let [view, light] = [(); 2].map(|()| warp::cosine_hemisphere(random.square()));
        let expected = facets.reflection(tilt.inverse() * view, tilt.inverse() * light, |cosine| {
            Vec3::splat(fresnel::schlick(cosine, 0.04))
        });
        let value = surface.evaluate(view, light);
        assert!(value.f_cos.abs_diff_eq(expected.f_cos, 1e-5 + 1e-4 * expected.f_cos.x), "{view} {light}: {value:?}");
        assert!((value.pdf - expected.pdf).abs() < 1e-5 + 1e-4 * expected.pdf, "{view} {light}: {value:?}");
    }
    let test = SphereTest { focus: Focus::SPHERE, family: 1 };
    let (surface, view) = (Principled::new(&Parameters { specular: 1.0, base_color: Vec3::ONE, ..coat }), at(0.3));
    let sample = |u, choice| surface.choose(view, u, choice).map(|sample| sample.direction);
    test.check("coat", sample, |light| surface.evaluate(view, light).pdf);
}

/// KHR_materials_anisotropy: facets of the widths along and across a direction, here 30° from the tangent.
#[test]
fn anisotropic_facets_are_turned() {
    let facets = Ggx::anisotropic(0.6, 0.1);
    let turned = Parameters { facets, direction: Vec2::from_angle(core::f32::consts::FRAC_PI_6), ..plastic(0.0) };
    let turned = Principled::new(&Parameters { metallic: 1.0, ..turned });
    let turn = |w: Vec3| glam::Quat::from_rotation_z(core::f32::consts::FRAC_PI_6) * w;
    let mut random = Random::new(5);
    for _ in 0..100 {
        let [view, light] = [(); 2].map(|()| warp::cosine_hemisphere(random.square()));
        let expected = facets.reflection(view, light, |_| Vec3::ONE).f_cos;
        let value = turned.evaluate(turn(view), turn(light)).f_cos;
        assert!(value.abs_diff_eq(expected, 1e-4 * expected.x), "{view} {light}: {value} {expected}");
    }
}

#[test]
fn samples_of_both_sides_follow_their_density() {
    let anisotropic =
        |parameters| Parameters { facets: Ggx::anisotropic(0.5, 0.2), direction: Vec2::from_angle(1.0), ..parameters };
    for (name, parameters) in [
        ("sheet", sheet(0.6)),
        ("window", window(0.6, false)),
        ("window from inside", window(0.6, true)),
        ("brushed", anisotropic(window(0.5, false))),
    ] {
        // A film colors light and moves none, but takes its time.
        let parameters = Parameters { iridescence: 0.0, ..parameters };
        let (surface, view) = (Principled::new(&parameters), at(0.4));
        let test = SphereTest { focus: Focus::SPHERE, family: 12 };
        let chosen = |u, choice| surface.choose(view, u, choice).map(|sample| sample.direction);
        test.check(name, chosen, |light| surface.evaluate(view, light).chosen_pdf());
        for through in [false, true] {
            let is_there = |light: &Vec3| (light.z < 0.0) == through;
            let split = |u, choice| {
                let LobeSplit { reflection, transmission, .. } = surface.split(view, u, choice);
                [reflection, transmission].into_iter().flatten().map(|sample| sample.direction).find(is_there)
            };
            let pdf = |light: Vec3| if is_there(&light) { surface.evaluate(view, light).pdf } else { 0.0 };
            test.check(&format!("split, {through}, {name}"), split, pdf);
        }
    }
}

/// Every lobe by itself, narrow and wide.
#[test]
fn every_lobe_follows_its_density_at_every_roughness() {
    let black = |roughness| Parameters { base_color: Vec3::ZERO, specular: 0.0, ..plastic(roughness) };
    for roughness in [0.15, 0.45, 0.9] {
        let coat = Ggx::from_roughness(roughness);
        for (name, parameters) in [
            ("metal", Parameters { metallic: 1.0, ..plastic(roughness) }),
            ("compensated metal", Parameters { metallic: 1.0, compensated: true, ..plastic(roughness) }),
            ("highlight", Parameters { base_color: Vec3::ZERO, ..plastic(roughness) }),
            ("plastic", plastic(roughness)),
            ("clearcoat", Parameters { clearcoat: 1.0, clearcoat_facets: coat, ..black(roughness) }),
            ("sheen", Parameters { sheen_color: Vec3::ONE, sheen_alpha: roughness * roughness, ..black(roughness) }),
            ("leaf", Parameters { diffuse_transmission: 0.5, ..plastic(roughness) }),
            ("sheet", sheet(roughness)),
            ("glass", glass(roughness, false)),
            ("glass from inside", glass(roughness, true)),
        ] {
            let (surface, view) = (Principled::new(&parameters), at(0.6));
            let image = Vec3::new(-view.x, 0.0, view.z);
            let width = if parameters.transmission > 0.0 { 1.0 } else { roughness * roughness };
            let test = SphereTest { focus: Focus::new(image, width), family: 30 };
            let chosen = |u, choice| surface.choose(view, u, choice).map(|sample| sample.direction);
            test.check(&format!("{name} {roughness}"), chosen, |light| surface.evaluate(view, light).chosen_pdf());
        }
    }
}

/// What is estimated by one direction comes to what an integral over all of them finds.
#[test]
fn estimates_are_right_in_mean() {
    let anisotropic =
        |parameters| Parameters { facets: Ggx::anisotropic(0.5, 0.1), direction: Vec2::from_angle(1.0), ..parameters };
    let tilted = Vec3::new(0.3, 0.0, 0.95).normalize();
    for (name, parameters) in [
        ("motley", motley(0.3)),
        ("tilted", Parameters { clearcoat_normal: tilted, clearcoat: 1.0, ..motley(0.6) }),
        ("brushed", anisotropic(motley(0.5))),
        ("sheet", sheet(0.4)),
        ("glass", glass(0.4, false)),
        ("glass from inside", glass(0.4, true)),
        ("window", window(0.6, false)),
    ] {
        for cosine in [0.9, 0.2] {
            let (surface, view, mut random) = (Principled::new(&parameters), at(cosine), Random::new(41));
            let whole = Focus::SPHERE.total(|light| surface.evaluate(view, light).f_cos.y as f64);
            let (count, mut sum, mut squares) = (20_000, 0.0, 0.0);
            for _ in 0..count {
                let estimate = surface.estimate(view, random.unit(), random.square()).y as f64;
                (sum, squares) = (sum + estimate, squares + estimate * estimate);
            }
            let mean = sum / count as f64;
            let deviation = (squares / count as f64 - mean * mean).sqrt();
            let error = deviation / (count as f64).sqrt();
            assert!((mean - whole).abs() < 4.0 * error + 1e-3, "{name} {cosine}: {mean} ± {error}, not {whole}");
            assert!(deviation < 2.5, "{name} {cosine}: {deviation}");
        }
    }
}

fn parameters() -> impl Strategy<Value = Parameters> {
    let unit = || prop_oneof![4 => real(0.0, 1.0), 1 => Just(0.0), 1 => Just(1.0)];
    let color = || (unit(), unit(), unit()).prop_map(|(x, y, z)| Vec3::new(x, y, z));
    let layers = (unit(), unit(), color(), unit());
    let eta = || prop_oneof![1 => Just(1.0), 3 => real(1.0, 2.5)];
    let interface =
        prop_oneof![
            Just(Interface::Sheet),
            (eta(), eta(), prop_oneof![Just(false), Just(true)])
                .prop_map(|(eta_i, eta_t, inside)| Interface::Boundary { eta_i, eta_t, inside }),
        ];
    let beyond = (unit(), unit(), color(), interface, unit(), real(1.0, 2.5), real(0.0, 1000.0));
    let angle = (real(0.0, 6.3), unit(), prop_oneof![Just(false), Just(true)]);
    let ior = prop_oneof![Just(0.0), Just(1.0), real(1.0, 3.0)];
    (color(), unit(), unit(), ior, unit(), color(), layers, beyond, angle).prop_map(
        |(base_color, metallic, roughness, ior, specular, tint, layers, beyond, (angle, strength, compensated))| {
            let (clearcoat, coat, sheen_color, sheen_alpha) = layers;
            let (
                transmission,
                diffuse_transmission,
                diffuse_transmission_color,
                interface,
                iridescence,
                film,
                thickness,
            ) = beyond;
            let alpha = roughness * roughness;
            Parameters {
                base_color,
                metallic,
                facets: Ggx::anisotropic(alpha + (1.0 - alpha) * strength * strength, alpha),
                direction: Vec2::from_angle(angle),
                ior,
                specular,
                specular_color: 2.0 * tint,
                clearcoat,
                clearcoat_facets: Ggx::from_roughness(coat),
                clearcoat_normal: Vec3::Z,
                sheen_color,
                sheen_alpha,
                transmission,
                diffuse_transmission,
                diffuse_transmission_color,
                interface,
                compensated,
                iridescence,
                film: Film { ior: film, thickness },
            }
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4096))]

    #[test]
    fn surfaces_are_reciprocal(mut parameters in parameters(), a in unit_vector(), b in unit_vector()) {
        // Of narrower facets the rounding of the half vector is magnified beyond the bound below.
        let wide = |facets: Ggx| Ggx::isotropic(facets.mean_alpha().max(0.05));
        parameters.facets = wide(parameters.facets);
        parameters.clearcoat_facets = wide(parameters.clearcoat_facets);
        let [a, b] = [a, b].map(|w| Vec3::new(w.x, w.y, w.z.abs().max(1e-2)).normalize());
        let surface = Principled::new(&parameters);
        let (there, back) = (surface.evaluate(a, b).f_cos / b.z, surface.evaluate(b, a).f_cos / a.z);
        prop_assert!((there - back).abs().max_element() <= 3e-4 * there.max_element() + 1e-6, "{there} {back}");
    }

    /// From the other side, with the sides exchanged: glass over the squared index of where the light goes.
    #[test]
    fn crossings_are_reciprocal(mut parameters in parameters(), a in unit_vector(), b in unit_vector()) {
        parameters.facets = Ggx::isotropic(parameters.facets.mean_alpha().max(0.05));
        let [a, b] = [a, b].map(|w| Vec3::new(w.x, w.y, w.z.abs().max(1e-2)).normalize());
        let (squares, other_side) = match parameters.interface {
            Interface::Sheet => (1.0, Interface::Sheet),
            Interface::Boundary { eta_i, eta_t, inside } => {
                parameters.diffuse_transmission = 0.0;
                let square = (eta_i / eta_t) * (eta_i / eta_t);
                (square, Interface::Boundary { eta_i: eta_t, eta_t: eta_i, inside: !inside })
            }
        };
        // Where facets tilt by all they can the half vector has few digits left.
        prop_assume!(!matches!(parameters.interface, Interface::Boundary { eta_i, eta_t, .. } if (eta_i - eta_t).abs() < 0.1));
        let there = Principled::new(&parameters).evaluate(a, -b).f_cos / b.z;
        let back = Principled::new(&Parameters { interface: other_side, ..parameters }).evaluate(b, -a).f_cos / a.z;
        let off = (there * squares - back).abs().max_element();
        prop_assert!(off <= 2e-3 * back.max_element() + 1e-5, "{there} {back}");
    }

    #[test]
    fn samples_are_sound(
        parameters in parameters(), view in unit_vector(), x in real(0.0, 0.999), y in real(0.0, 0.999),
        choice in real(0.0, 0.999),
    ) {
        let surface = Principled::new(&parameters);
        let estimate = surface.singular(view) + surface.estimate(view, choice, Vec2::new(x, y));
        prop_assert!(estimate.is_finite() && estimate.min_element() >= 0.0, "{estimate}");
        if let Some(sample) = surface.choose(view, Vec2::new(x, y), choice) {
            prop_assert!(sample.weight.is_finite() && sample.weight.min_element() >= 0.0, "{sample:?}");
            prop_assert!(sample.weight.max_element() < 20.0 && sample.pdf > 0.0, "{sample:?}");
        }
        let LobeSplit { reflection, transmission, reflectance } = surface.split(view, Vec2::new(x, y), choice);
        prop_assert!((0.0..=1.0).contains(&reflectance), "{reflectance}");
        for sample in [reflection, transmission].into_iter().flatten() {
            prop_assert!(sample.weight.is_finite() && sample.weight.min_element() >= 0.0, "{sample:?}");
        }
        for light in [Vec3::Z, -Vec3::Z, -view] {
            let value = surface.evaluate(view, light);
            prop_assert!(value.f_cos.is_finite() && value.pdf >= 0.0 && value.choice >= 0.0, "{value:?}");
        }
    }
}
