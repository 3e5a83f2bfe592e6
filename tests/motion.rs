//! What moves while the shutter is open looks as it does on the mean over that time.

use std::f64::consts::{FRAC_1_PI, FRAC_2_PI, PI};

use brewster_buffers::SceneBuffers;
use glam::{DVec2, DVec3};

use crate::scene::{load, parse, picture, render, render_with};

/// A picture, four meters high and wide, of parallel rays straight down; the pixel at (x, y) sees (2x, -2y) of the floor.
fn from_above(settings: &str, camera: &str, background: f64, entities: &str) -> SceneBuffers {
    parse(&format!(
        "Scene(
            settings: (resolution: (20, 20), filter: Box, {settings}),
            camera: Orthographic(eye: (0, 4, 0), target: (0, 0, 0), up: (0, 0, -1), height: 4, {camera}),
            background: {background},
            entities: [{entities}],
        )"
    ))
}

/// The pixels of [`from_above`], at the places of the floor that they see.
fn floor(scene: &SceneBuffers) -> Vec<(DVec2, DVec3)> {
    picture(scene).into_iter().map(|(place, color)| (DVec2::new(2.0, -2.0) * place, color)).collect()
}

/// Holds how dark pixels are before a white sky against the part of the time for which their places, of -1 to 1, are covered by what is black.
/// Where `nearer` is not 0, places may also look as those do that are so much farther from the middle, and less covered.
fn assert_covered(context: &str, scene: &SceneBuffers, nearer: f64, covered: impl Fn(DVec2) -> f64) {
    let samples = f64::from(scene.settings.samples);
    let (mut all, mut expected_of_all, mut variance) = (0.0, [0.0; 2], 0.0f64);
    for (place, color) in picture(scene) {
        const STEPS: usize = 40;
        let step = |i: usize| 0.1 * ((i as f64 + 0.5) / STEPS as f64 - 0.5);
        let spots = || (0..STEPS * STEPS).map(|i| place + DVec2::new(step(i % STEPS), step(i / STEPS)));
        let mean = |factor: f64| spots().map(|spot| covered(factor * spot)).sum::<f64>() / (STEPS * STEPS) as f64;
        let [low, high] = [mean(1.0 + nearer), mean(1.0)];
        // Coin tosses would have this deviation; samples that are evenly spread have less.
        let deviation = (high * (1.0 - high) / samples).sqrt();
        let found = 1.0 - color.x;
        let bound = 4.5 * deviation + 1e-4;
        assert!(found > low - bound && found < high + bound, "{context} at {place}: {found}, not {low} to {high}");
        all += found;
        expected_of_all[0] += low;
        expected_of_all[1] += high;
        variance += deviation * deviation;
    }
    let ([low, high], bound) = (expected_of_all, 4.5 * variance.sqrt());
    assert!(all > low - bound && all < high + bound, "{context}: {all}, not {low} to {high}, within {bound}");
}

/// A dark ball of radius r that goes from x = a to x = b hides a point at (x, z) while |x - a - (b - a) s| < √(r² - z²).
#[test]
fn a_ball_leaves_the_coverage_of_its_way() {
    let (r, from, to) = (0.31, -1.1, 1.3);
    let ball =
        "(shape: Sphere(radius: 0.31), material: Lambert(albedo: 0), at: (-1.1, 0, 0.2), motion: (by: (2.4, 0, 0)))";
    let covered = |place: DVec2| {
        let at = DVec2::new(2.0, -2.0) * place;
        let half = (r * r - (at.y - 0.2) * (at.y - 0.2)).max(0.0f64).sqrt();
        let moment = |x: f64| ((x - from) / (to - from)).clamp(0.0, 1.0);
        if half > 0.0 { moment(at.x + half) - moment(at.x - half) } else { 0.0 }
    };
    for integrator in ["Whitted", "Path"] {
        let settings = format!("samples: 256, integrator: {integrator}");
        assert_covered(integrator, &from_above(&settings, "", 1.0, ball), 0.0, covered);
    }
}

/// A ball that grows from radius a to b hides a point at the distance ρ from then on when it reaches it: for 1 - (ρ - a)/(b - a) of the time.
#[test]
fn a_growing_ball_covers_what_it_has_reached() {
    let ball = "(shape: Sphere(radius: 0.4), material: Lambert(albedo: 0), at: (0.1, 0, -0.2), motion: (scale: 4))";
    let scene = from_above("samples: 256, integrator: Path", "", 1.0, ball);
    assert_covered("a growing ball", &scene, 0.0, |place| {
        let distance = (DVec2::new(2.0, -2.0) * place - DVec2::new(0.1, -0.2)).length();
        1.0 - ((distance - 0.4) / 1.2).clamp(0.0, 1.0)
    });
}

/// A bar of half the length l and half the width w that makes half a turn about its middle hides a point at the distance ρ while the angle
/// between them is below asin(w/ρ) and above acos(l/ρ), on either side: for the difference over π/2 of the time. Chords take a thousandth.
#[test]
fn a_turning_bar_covers_less_the_farther_out() {
    let (length, width) = (1.2f64, 0.25f64);
    let bar = "(shape: Box(size: (2.4, 0.1, 0.5)), material: Lambert(albedo: 0), motion: (rotate: (y: 180)))";
    let scene = from_above("samples: 1024, integrator: Path", "", 1.0, bar);
    assert_covered("a turning bar", &scene, 1e-3, |place| {
        let distance = 2.0 * place.length();
        let [below, above] = [(width / distance).min(1.0).asin(), (length / distance).min(1.0).acos()];
        FRAC_2_PI * (below - above).max(0.0)
    });
}

/// A camera that goes evenly from the height a down to b over a ball of radius r sees it under tan θ = r/√(h² - r²), at an angle of view of
/// 90° that far from the middle of the picture: a place q is covered while h² < r² (1 + 1/q²).
#[test]
fn a_ball_grows_for_a_camera_that_comes_down() {
    let (from, to, r) = (4.0, 1.5, 0.8);
    let scene = parse(
        "Scene(
            settings: (resolution: (20, 20), filter: Box, samples: 256, integrator: Path),
            camera: Perspective(eye: (0, 4, 0), target: (0, 0, 0), up: (0, 0, -1), vfov: 90, motion: (eye: (0, 1.5, 0))),
            background: 1,
            entities: [(shape: Sphere(radius: 0.8), material: Lambert(albedo: 0))],
        )",
    );
    assert_covered("a camera that comes down", &scene, 0.0, |place| {
        let height = r * (1.0 + 1.0 / place.length_squared()).sqrt();
        1.0 - ((from - height) / (from - to)).clamp(0.0, 1.0)
    });
}

/// A wheel that is the same after any turn looks still, but for chords that are a thousandth nearer to its axis: 0.1 % of a disk's
/// radius is 0.2 % of its area, at most, and two thirds of that on the mean.
#[test]
fn a_turning_wheel_that_shows_no_turn_looks_still() {
    let wheel = |motion: &str| {
        let entities = format!(
            "(shape: Cylinder(radius: 1.4, height: 0.2), material: Lambert(albedo: 0.8), at: (0.1, 0, 0), {motion}),
            (light: Point(intensity: 30), at: (0, 3, 0))"
        );
        floor(&from_above("samples: 64", "", 0.0, &entities))
    };
    let still = wheel("");
    let mean = |pixels: &[(DVec2, DVec3)]| pixels.iter().map(|(_, color)| color.x).sum::<f64>() / pixels.len() as f64;
    for motion in
        ["motion: (rotate: (y: 90))", "motion: (rotate: (y: -1000))", "motion: (rotate: (axis: (0, 2, 0), angle: 10))"]
    {
        let turning = wheel(motion);
        let ratio = mean(&turning) / mean(&still);
        assert!(ratio < 1.0 + 1e-6 && ratio > 1.0 - 2.2e-3, "{motion}: {ratio}");
        for ((place, turning), (_, still)) in turning.iter().zip(&still) {
            let is_rim = (DVec2::new(place.x - 0.1, place.y).length() - 1.4).abs() < 0.15;
            assert!(is_rim || (turning - still).abs().max_element() < 2e-3 * still.x + 1e-6, "{motion} at {place}");
        }
    }
}

/// The camera goes one way, or the world the other: the same places at the same moments, but for rounding.
#[test]
fn a_moving_camera_sees_a_still_world_as_a_still_one_sees_it_pass() {
    let world = "(shape: Plane(), material: Lambert(albedo: Checker(a: 0.1, b: 0.9, size: 0.3))),
        (shape: Box(size: (0.5, 0.5, 0.5)), material: Lambert(albedo: (0.9, 0.2, 0.1)), at: (0.3, 0.4, 0.1), rotate: (x: 20, y: 30)),
        (shape: Sphere(radius: 0.5), material: Metal(of: \"Au\"), at: (-0.8, 0.5, -0.6)),
        (light: Point(intensity: 20), at: (1, 3, 1))";
    let settings = "samples: 16, max_depth: 2";
    let pan = from_above(settings, "motion: (eye: (0.5, 4, 0.25), target: (0.5, 0, 0.25))", 0.3, world);
    let pass = format!("(motion: (by: (-0.5, 0, -0.25)), children: [{world}])");
    let pass = from_above(settings, "", 0.3, &pass);
    assert!(pan.motions.is_empty() && !pass.motions.is_empty() && pass.light_motions.len() == 1);
    let (pan, pass) = (picture(&pan), picture(&pass));
    let differing =
        pan.iter().zip(&pass).filter(|((_, pan), (_, pass))| (pan - pass).abs().max_element() > 1e-4).count();
    // A sample at an edge may fall to either side.
    assert!(differing < 12, "{differing} of {} pixels differ", pan.len());
    let mean = |pixels: &[(DVec2, DVec3)]| pixels.iter().map(|(_, color)| *color).sum::<DVec3>() / pixels.len() as f64;
    assert!((mean(&pan) / mean(&pass) - 1.0).abs().max_element() < 1e-3);
}

/// A camera that nears what it looks at, and turns by little: eye and target both go evenly, so that the view is known at every moment.
#[test]
fn a_camera_looks_at_its_target_all_the_time() {
    let (eye, target) =
        ([DVec3::new(0.0, 0.5, 6.0), DVec3::new(0.1, 0.5, 1.0)], [DVec3::ZERO, DVec3::new(0.2, 0.1, 0.0)]);
    let scene = parse(
        "Scene(
            settings: (integrator: Path),
            camera: Perspective(
                eye: (0, 0.5, 6), target: (0, 0, 0), vfov: 36,
                motion: (eye: (0.1, 0.5, 1), target: (0.2, 0.1, 0)),
            ),
            background: 1,
            entities: [(shape: Sphere(radius: 0.1), material: Lambert())],
        )",
    );
    for moment in 0..1000 {
        let s = (f64::from(moment) + 0.5) * 1e-3;
        let [from, to] = [eye, target].map(|way| way[0].lerp(way[1], s));
        let frame = scene.cameras[0].frame(s as f32);
        let forward = (to - from).normalize();
        let right = forward.cross(DVec3::Y).normalize();
        assert!((frame.position.as_dvec3() - from).length() < 1e-5, "at {s}: {frame:?}");
        for (axis, expected) in [(frame.forward, forward), (frame.right, right), (frame.up, right.cross(forward))] {
            assert!((axis.as_dvec3() - expected).length() < 1e-4, "at {s}: {axis}, not {expected}");
        }
    }
}

/// The irradiance of a lamp on its way, by the midpoint rule over the time: E = I cos θ / d² of a point, π L (r/d)² cos θ of a ball
/// above the horizon, L A cos θ cos θ' / d² of a small panel, whose side turns away. Albedo over π of it goes up.
#[test]
fn a_moving_lamp_gives_the_mean_of_its_light() {
    let from = DVec3::new(-1.0, 2.0, 0.3);
    let by = DVec3::new(2.0, 0.5, 0.2);
    let squared = |floor: DVec3, at: DVec3| (at - floor).length_squared();
    let cosine = |floor: DVec3, at: DVec3| (at - floor).normalize().y;
    // What a lamp is, how it turns, the square of a sample's light over that of its mean at one moment, the mean.
    type Light<'a> = (&'a str, &'a str, f64, &'a dyn Fn(DVec3, DVec3, f64) -> f64);
    let lamps: [Light<'_>; 4] = [
        ("light: Point(intensity: 12)", "", 1.0, &|floor, at, _| 12.0 * cosine(floor, at) / squared(floor, at)),
        ("shape: Sphere(radius: 0.25), material: Emissive(radiance: 60)", "", 1.1, &|floor, at, _| {
            60.0 * PI * 0.0625 * cosine(floor, at) / squared(floor, at)
        }),
        ("shape: Sphere(radius: 0.25), material: Emissive(radiance: 60)", "rotate: (z: 200)", 3.0, &|floor, at, _| {
            60.0 * PI * 0.0625 * cosine(floor, at) / squared(floor, at)
        }),
        (
            "shape: Quad(size: (0.1, 0.1)), material: Emissive(radiance: 900, sides: Front), rotate: (x: 90)",
            "rotate: (x: 100)",
            1.0,
            &|floor, at, s| {
                // It faces down, and after the turn by 100° along -z and a little up.
                let angle = (100.0 * s).to_radians();
                let facing = DVec3::new(0.0, -angle.cos(), -angle.sin());
                900.0 * 0.01 * (floor - at).normalize().dot(facing).max(0.0) * cosine(floor, at) / squared(floor, at)
            },
        ),
    ];
    for (lamp, turn, squared_of_sample, irradiance) in lamps {
        let entities = format!(
            "(shape: Plane(), material: Lambert(albedo: 0.5)),
            ({lamp}, at: (-1, 2, 0.3), motion: (by: (2, 0.5, 0.2), {turn}))"
        );
        // The camera is above the lamp, which would hide the floor.
        let scene = from_above("samples: 256, integrator: Path, max_depth: 1", "", 0.0, &entities);
        let pixels = floor(&scene);
        // By columns: what was found, what is expected, and the variance of that if samples had nothing to do with each other.
        let mut sums = [[0.0f64; 3]; 20];
        for (pixel, (place, color)) in pixels.into_iter().enumerate() {
            // The lamp hides what is below its way; a small panel next to nothing.
            if (place.y - 0.4).abs() < 0.45 {
                continue;
            }
            const STEPS: u32 = 100;
            let third = |i: u32| 0.2 / 3.0 * (f64::from(i) - 1.0);
            let (mut mean, mut square) = (0.0, 0.0);
            for i in 0..9 * STEPS {
                let spot = DVec3::new(place.x + third(i % 3), 0.0, place.y + third(i / 3 % 3));
                let s = (f64::from(i / 9) + 0.5) / f64::from(STEPS);
                let light = 0.5 * FRAC_1_PI * irradiance(spot, from + by * s, s) / f64::from(9 * STEPS);
                mean += light;
                square += squared_of_sample * light * light * f64::from(9 * STEPS);
            }
            let column = &mut sums[pixel % 20];
            let found = [color.x, mean, (square - mean * mean) / 256.0];
            column.iter_mut().zip(found).for_each(|(sum, number)| *sum += number);
        }
        let all = (0..3).map(|i| sums.iter().map(|sum| sum[i]).sum()).collect::<Vec<f64>>();
        for (column, sum) in sums.iter().map(|sum| &sum[..]).chain([&all[..]]).enumerate() {
            let bound = 4.5 * sum[2].sqrt() + 0.002 * sum[1];
            assert!((sum[0] - sum[1]).abs() < bound, "{lamp} {turn}, column {column}: {sum:?}, within {bound}");
        }
    }
}

/// Motion by nothing is none.
#[test]
fn motion_by_nothing_changes_no_bit() {
    for (name, integrator) in [("shapes", "Whitted"), ("details", "Path")] {
        let path = format!("{}/scenes/{name}.ron", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(&path).expect("the scene is there");
        let with = text.replace("(shape:", "(motion: (by: (0, 0, 0), rotate: (y: 0)), shape:");
        let still = parse(&text);
        let moving = parse(&with.replace("vfov: 4", "motion: (), vfov: 4"));
        assert!(with != text && moving.motions.is_empty() && moving.cameras[0].motion.is_empty(), "{integrator}");
        assert!(render(&still).0 == render(&moving).0, "{name}");
    }
}

/// With the same seed and another motion the picture is another one, and every layer holds what is seen on the mean.
#[test]
fn moving_scenes_move() {
    for name in ["moving", "moving_paths"] {
        let scene = load(name);
        let mut still = scene.clone();
        still.motions = Default::default();
        assert!(scene.cameras[0].motion.len() > 1 && scene.motions.keys(1).is_some(), "{name}");
        let policy = brewster_wavefront::Policy { ledger: true, ..Default::default() };
        let (film, stats) = render_with(&scene, policy, 1);
        assert_eq!(film.rejected(), 0);
        assert!(stats.total().hits > 1000);
        assert!(film != render(&still).0, "{name}");
    }
}
