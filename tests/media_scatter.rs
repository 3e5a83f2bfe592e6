//! Media scatter light as the theory of radiative transfer says: by closed forms, by quadratures written here, and by Chandrasekhar's
//! integral equation.

use brewster_buffers::SceneBuffers;
use brewster_wavefront::Policy;
use glam::{DVec2, DVec3};

use crate::scene::{load, parse, picture, render_with};

/// The mean of numbers and its standard error.
fn mean(values: &[DVec3]) -> (DVec3, DVec3) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<DVec3>() / count;
    let variance = values.iter().map(|&value| (value - mean) * (value - mean)).sum::<DVec3>() / (count - 1.0);
    (mean, (variance / count).powf(0.5))
}

/// Holds the mean of numbers against what it should be, to 4.5 standard errors.
#[track_caller]
fn check(what: &str, values: &[DVec3], expected: DVec3) {
    let (mean, error) = mean(values);
    let allowed = 4.5 * error + DVec3::splat(1e-5);
    assert!((mean - expected).abs().cmple(allowed).all(), "{what}: {mean} ± {error}, by theory {expected}");
}

fn colors(scene: &SceneBuffers) -> Vec<DVec3> {
    picture(scene).into_iter().map(|(_, color)| color).collect()
}

/// In even light a body that absorbs nothing is invisible, however it scatters.
#[test]
fn white_media_are_invisible_in_even_light() {
    let whites = [
        "Medium(scattering: 0.5)",
        "Medium(scattering: (0.5, 2, 4), anisotropy: 0.8)",
        "Medium(scattering: (5, 0, 1), anisotropy: -0.6)",
        "Dielectric(ior: 1.5, scattering: 1)",
        "Dielectric(ior: 1.33, scattering: (0.3, 1, 2), anisotropy: 0.7)",
        "Dielectric(ior: 1, scattering: 2, anisotropy: 0.5)",
        "Principled(base_color: 1, transmission: 1, roughness: 0, \
         volume: (color: (0.2, 0.5, 0.8), distance: 1, multiscatter: 1, anisotropy: 0.4))",
    ];
    for material in whites {
        let scene = parse(&format!(
            "Scene(
                settings: (integrator: Path, resolution: (12, 12), samples: 64, max_depth: 1000, filter: Box),
                camera: Orthographic(eye: (0, 0, 4), target: (0, 0, 0), height: 1.4),
                background: 1,
                entities: [(shape: Sphere(radius: 1), material: {material})],
            )"
        ));
        check(material, &colors(&scene), DVec3::ONE);
    }
}

/// What comes straight through is Beer's and Lambert's part, of what is absorbed and of what is scattered; deeper paths are cut. So
/// it is where the slab has a surface, two interactions, and where boundaries that are none, of a weaker medium, part it.
#[test]
fn a_slab_transmits_what_beer_and_lambert_say() {
    let extinction = DVec3::new(0.3, 0.0, 1.0) + DVec3::new(0.2, 1.5, 0.1);
    let numbers = "absorption: (0.3, 0, 1), scattering: (0.2, 1.5, 0.1), anisotropy: 0.9, priority: 1";
    let within = |material: &str| format!("(shape: Box(size: (30, 30, 0.3)), material: {material}),");
    for (depth, surface, inside) in [
        (0, "Medium", String::new()),
        (2, "Dielectric", String::new()),
        (0, "Medium", within("Medium(scattering: 5)")),
        (0, "Medium", within("Dielectric(ior: 1.5, scattering: 5)")),
        (2, "Dielectric", within("Dielectric(ior: 1.3)") + &within("Medium(absorption: 1, ior: 1.2)")),
    ] {
        let scene = parse(&format!(
            "Scene(
                settings: (integrator: Path, resolution: (32, 32), samples: 64, max_depth: {depth}, filter: Box),
                camera: Orthographic(eye: (0, 0, 4), target: (0, 0, 0), height: 1),
                entities: [
                    (shape: Box(size: (40, 40, 0.5)), material: {surface}(ior: 1, {numbers})),
                    {inside}
                    (shape: Quad(size: (40, 40)), material: Emissive(radiance: (1, 2, 3)), at: (0, 0, -1)),
                ],
            )"
        ));
        let left = (-0.5 * extinction).exp() * DVec3::new(1.0, 2.0, 3.0);
        check(&format!("{surface} around {inside}"), &colors(&scene), left);
    }
}

/// Light that is scattered once, toward pixels of a camera that looks along -z at a box of 2 m: the integral along the view of
/// `σ_s p(θ) I/r² exp(-σ_t (t + inside))`, by Simpson's rule.
fn scattered_once(place: DVec2, lamp: DVec3, [absorption, scattering]: [DVec3; 2], g: f64) -> DVec3 {
    const STEPS: usize = 4000;
    let extinction = absorption + scattering;
    let at = |t: f64| {
        let point = DVec3::new(place.x, place.y, 1.0 - t);
        let to = lamp - point;
        let direction = to.normalize();
        // The way to the lamp ends at the box's top, where the lamp is above it.
        let inside = if lamp.y > 1.0 { (1.0 - point.y) / direction.y } else { to.length() };
        let cosine = DVec3::NEG_Z.dot(direction);
        let phase = (1.0 - g * g) / (1.0 + g * g - 2.0 * g * cosine).powf(1.5) / (4.0 * std::f64::consts::PI);
        scattering * (phase / to.length_squared()) * (-extinction * (t + inside)).exp()
    };
    let width = 2.0 / STEPS as f64;
    let sum: DVec3 = (0..=STEPS)
        .map(|step| {
            at(step as f64 * width) * if step == 0 || step == STEPS { 1.0 } else { 2.0 + 2.0 * (step % 2) as f64 }
        })
        .sum();
    sum * width / 3.0
}

#[test]
fn a_lamp_in_and_above_fog_is_scattered_once_as_the_integral_says() {
    let media = [DVec3::new(0.1, 0.0, 0.4), DVec3::new(0.2, 0.6, 0.1)];
    for (lamp, g) in [(DVec3::new(0.05, -0.6, 0.1), 0.5), (DVec3::new(0.0, 4.0, 0.3), -0.4), (DVec3::Y * 3.0, 0.0)] {
        let scene = parse(&format!(
            "Scene(
                settings: (integrator: Path, resolution: (24, 24), samples: 64, max_depth: 1, filter: Box),
                camera: Orthographic(eye: (0, 0.1, 4), target: (0, 0.1, 0), height: 0.8),
                entities: [
                    (shape: Box(size: (2, 2, 2)), material:
                        Medium(absorption: (0.1, 0, 0.4), scattering: (0.2, 0.6, 0.1), anisotropy: {g})),
                    (light: Point(intensity: 1), at: ({}, {}, {})),
                ],
            )",
            lamp.x, lamp.y, lamp.z
        ));
        let differences: Vec<DVec3> = picture(&scene)
            .into_iter()
            .map(|(place, color)| {
                let expected = scattered_once(0.4 * place + DVec2::Y * 0.1, lamp, media, g);
                color / expected - 1.0
            })
            .collect();
        check(&format!("lamp at {lamp}, g {g}"), &differences, DVec3::ZERO);
    }
}

/// A lamp with a size, found by rays toward it and by chance, lights fog as many small lamps do.
#[test]
fn an_extended_lamp_in_fog_is_the_sum_of_its_points() {
    let scene = |lamps: &str| {
        parse(&format!(
            "Scene(
                settings: (integrator: Path, resolution: (24, 24), samples: 256, max_depth: 2, filter: Box),
                camera: Orthographic(eye: (0, 0, 4), target: (0, 0, 0), height: 1.6),
                entities: [
                    (shape: Box(size: (4, 2, 2)), material: Medium(scattering: 0.5, anisotropy: 0.8)),
                    {lamps}
                ],
            )"
        ))
    };
    // By Lambert's law a quad of area A and radiance L is a lamp of intensity L A cosθ toward each side: seen along its normal's
    // side only, in a plane through its middle, many quads of little area in its place are the same.
    let one =
        scene("(shape: Quad(size: (0.8, 0.8)), material: Emissive(radiance: 5), at: (0, 1.4, 0), rotate: (x: 90)),");
    let parts: String = (0..16)
        .map(|i| {
            let (x, z) = (0.2 * f64::from(i % 4) - 0.3, 0.2 * f64::from(i / 4) - 0.3);
            format!("(shape: Quad(size: (0.2, 0.2)), material: Emissive(radiance: 5), at: ({x}, 1.4, {z}), rotate: (x: 90)),")
        })
        .collect();
    let differences: Vec<DVec3> = colors(&one).into_iter().zip(colors(&scene(&parts))).map(|(a, b)| a - b).collect();
    check("one lamp and its parts", &differences, DVec3::ZERO);
}

/// Chandrasekhar's function for isotropic scattering, as a table over the cosine, by iteration of its integral equation
/// `1/H(μ) = √(1-ω) + ω/2 ∫₀¹ μ' H(μ')/(μ + μ') dμ'` (S. Chandrasekhar, *Radiative Transfer*, 1950, §37).
struct H {
    albedo: f64,
    table: Vec<f64>,
}

impl H {
    const STEPS: usize = 400;

    fn new(albedo: f64) -> H {
        let mut h = H { albedo, table: vec![1.0; H::STEPS] };
        for _ in 0..50 {
            // Halfway between two steps, without which it would swing.
            h.table = (0..H::STEPS).map(|i| 0.5 * (h.table[i] + h.at(H::place(i)))).collect();
        }
        h
    }

    fn place(i: usize) -> f64 {
        (i as f64 + 0.5) / H::STEPS as f64
    }

    fn at(&self, cosine: f64) -> f64 {
        let of = |(i, h): (usize, &f64)| H::place(i) * h / (cosine + H::place(i));
        let sum: f64 = self.table.iter().enumerate().map(of).sum();
        1.0 / ((1.0 - self.albedo).sqrt() + 0.5 * self.albedo * sum / H::STEPS as f64)
    }
}

/// A half space of fog in even light sends back `1 - √(1-ω) H(μ)` of it: its albedo for light from that direction, by reciprocity.
#[test]
fn a_half_space_reflects_as_chandrasekhar_says() {
    for albedo in [0.5f64, 0.9, 0.96] {
        let h = H::new(albedo);
        // His theorem 1, `∫₀¹ H dμ = 2/ω (1 - √(1-ω))`, tells that the equation has been solved.
        let theorem = 2.0 / albedo * (1.0 - (1.0 - albedo).sqrt());
        let sum = h.table.iter().sum::<f64>() / H::STEPS as f64;
        assert!((sum / theorem - 1.0).abs() < 2e-4, "albedo {albedo}: {sum} {theorem}");
        for (cosine, eye) in [(1.0, "(0, 0, 4)"), (0.5, "(0, 3.4641016, 2)")] {
            let expected = 1.0 - (1.0 - albedo).sqrt() * h.at(cosine);
            let scene = parse(&format!(
                "Scene(
                    settings: (integrator: Path, resolution: (12, 12), samples: 64, max_depth: 1000, filter: Box),
                    camera: Orthographic(eye: {eye}, target: (0, 0, 0), height: 0.1),
                    background: 1,
                    entities: [
                        (shape: Box(size: (2000, 2000, 1000)), at: (0, 0, -500), material:
                            Medium(scattering: {}, absorption: {})),
                    ],
                )",
                4.0 * albedo,
                4.0 * (1.0 - albedo)
            ));
            check(&format!("albedo {albedo}, cosine {cosine}"), &colors(&scene), DVec3::splat(expected));
        }
    }
}

/// A volume that scatters is what the extension's formulas make of its colors: `σ_t = -ln(c)/d`, `σ_s = ρ σ_t` with
/// `ρ = 1 - (4.09712 + 4.20863 m - √(9.59217 + 41.6808 m + 17.7126 m²))²`, worked out here in f64.
#[test]
fn a_volume_scatters_what_the_extension_says() {
    let scene = parse(
        "Scene(
            settings: (integrator: Path, resolution: (8, 8)),
            camera: Perspective(eye: (0, 0, 4)),
            background: 1,
            entities: [(shape: Sphere(radius: 1), material: Principled(
                transmission: 1, volume: (color: (0.9, 0.5, 0.2), distance: 0.01, multiscatter: (0.572, 0.227, 0), anisotropy: -0.3),
            ))],
        )",
    );
    let medium = scene.materials.dielectric.get(0);
    for (channel, (color, multiple)) in [(0.9f64, 0.572f64), (0.5, 0.227), (0.2, 0.0)].into_iter().enumerate() {
        let attenuation = -color.ln() / 0.01;
        let s = 4.09712 + 4.20863 * multiple - (9.59217 + 41.6808 * multiple + 17.7126 * multiple * multiple).sqrt();
        let scattered = attenuation * (1.0 - s * s).max(0.0);
        let [absorption, scattering] = [medium.absorption, medium.scattering].map(|color| f64::from(color[channel]));
        assert!((scattering - scattered).abs() < 1e-4 * attenuation, "{scattering} {scattered}");
        assert!((absorption + scattering - attenuation).abs() < 1e-4 * attenuation, "{absorption} {attenuation}");
    }
    assert_eq!(medium.anisotropy, -0.3);
}

/// Every ray comes to one end, and every event to one.
#[test]
fn rays_in_fog_are_counted_without_remainder() {
    let (_, stats) = render_with(&load("fog"), Policy::default(), 1);
    for (depth, at) in stats.depths.iter().enumerate() {
        for counts in &at.counts {
            assert_eq!(
                counts.traced(),
                counts.hits + counts.escaped + counts.crossings + counts.scatterings,
                "{depth}"
            );
        }
    }
    let total = stats.total();
    assert!(total.scatterings > 1000 && total.passed > 1000 && total.crossings > 10, "{total:?}");
}

/// The ledger closes: exactly where it is arithmetic, in mean where flights are drawn; what media absorb follows from coefficients.
#[test]
fn energy_in_fog_is_accounted_for() {
    let mut scene = load("fog");
    scene.settings.samples = 32;
    let (_, stats) = render_with(&scene, Policy { ledger: true, ..Policy::default() }, 2);
    let mut flights = 0;
    for (depth, at) in stats.depths.iter().enumerate() {
        let of = at.ledger();
        for channel in 0..3 {
            let at = |energy: brewster_wavefront::ledger::Energy| energy.0[channel];
            let became =
                at(of.volume) + at(of.strayed) + at(of.escaped) + at(of.crossed) + at(of.emitters) + at(of.cut);
            assert_eq!(at(of.entered), became + at(of.scattered), "depth {depth}, channel {channel}");
            let scattered = at(of.absorbed) + at(of.residual) + at(of.below_surface) + at(of.onward);
            let scattered = scattered + at(of.roulette_removed) - at(of.roulette_added);
            assert_eq!(at(of.scattered) + at(of.recolored), scattered, "depth {depth}, channel {channel}");
            for z in [of.z()[channel], of.stray_z()[channel]] {
                assert!(z.abs() < 4.5, "depth {depth}, channel {channel}: {z:.1} standard errors");
            }
            flights += i32::from(of.stray_z()[channel] != 0.0);
        }
    }
    assert!(flights > 20, "flights are drawn at {flights} places");
}

/// A camera in fog sees as one behind a wall of it: what is in front of it counts from where it stands.
#[test]
fn a_camera_inside_fog_is_in_it() {
    let scene = parse(
        "Scene(
            settings: (integrator: Path, resolution: (16, 16), samples: 64, max_depth: 0, filter: Box),
            camera: Orthographic(eye: (0, 0, 0), target: (0, 0, -1), height: 0.1),
            entities: [
                (shape: Sphere(radius: 2), material: Medium(scattering: 0.5, absorption: 0.2)),
                (shape: Quad(), material: Emissive(radiance: 1), at: (0, 0, -1.5)),
            ],
        )",
    );
    check("1.5 m of fog", &colors(&scene), DVec3::splat((-0.7f64 * 1.5).exp()));
}
