//! Normal maps, heights, opacity and mixes do what can be said of them by hand.

use std::f64::consts::PI;

use brewster_buffers::SceneBuffers;
use brewster_wavefront::Policy;
use brewster_wavefront::ledger::Energy;
use glam::DVec3;

use crate::scene::{counts, load, parse, picture, render, render_with};

/// The mean color of a scene's picture.
fn mean(scene: &SceneBuffers) -> DVec3 {
    let pixels = picture(scene);
    pixels.iter().map(|(_, color)| *color).sum::<DVec3>() / pixels.len() as f64
}

/// A picture of 32 by 32 pixels, looking down -Z on what fills it.
fn scene(settings: &str, background: &str, materials: &str, entities: &str) -> SceneBuffers {
    parse(&format!(
        "Scene(settings: (resolution: (32, 32), {settings}), background: {background},
        camera: Orthographic(eye: (0, 0, 9), target: (0, 0, 0), height: 2),
        materials: {{{materials}}}, entities: [{entities}])"
    ))
}

const PATH: &str = "integrator: Path, max_depth: 1, samples: 64";

/// Cards of nothing but a veil.
fn cards(count: u32, first: f32) -> String {
    let card = |i: u32| format!("(shape: Quad(size: (9, 9)), material: \"veil\", at: (0, 0, {})),", first + i as f32);
    (0..count).map(card).collect()
}

#[test]
fn stacked_veils_let_through_the_product() {
    for (alpha, count) in [(0.25, 1), (0.25, 3), (0.5, 5)] {
        let veil = format!("\"veil\": Detailed(of: Lambert(albedo: 0), opacity: Blend(alpha: {alpha}))");
        let through = (1.0f64 - alpha).powi(count as i32);
        let seen = mean(&scene(PATH, "1", &veil, &cards(count, 0.0))).x;
        // 65,536 rays pass or do not; evenly spread numbers do better than this.
        let error = (through * (1.0 - through) / 65_536.0).sqrt();
        assert!((seen - through).abs() < 4.0 * error, "{count} of {alpha}: {seen} instead of {through}");
    }
}

/// Between two veils of one half lies a boundary that is none, as it is within a solid that takes precedence: a quarter passes both, for
/// what lets light through the second knows nothing of the first.
#[test]
fn veils_beyond_a_boundary_that_is_none_decide_anew() {
    let materials = "\"veil\": Detailed(of: Lambert(albedo: 0), opacity: Blend(alpha: 0.5)),
        \"air\": Dielectric(ior: 1, priority: 1), \"swallowed\": Dielectric(ior: 1.5)";
    let swallowed = "(shape: Box(size: (9, 9, 2)), material: \"swallowed\", at: (0, 0, 2)),";
    let veils = "(shape: Quad(size: (9, 9)), material: \"veil\", at: (0, 0, 4)),
        (shape: Quad(size: (9, 9)), material: \"veil\", at: (0, 0, 0)),";
    let air = "(shape: Box(size: (40, 40, 40)), material: \"air\"),";
    let scene = scene(PATH, "1", materials, &format!("{veils} {air} {swallowed}"));
    let seen = mean(&scene).x;
    let error = (0.25f64 * 0.75 / 65_536.0).sqrt();
    assert!((seen - 0.25).abs() < 4.0 * error, "{seen} instead of a quarter");
    assert!(render_with(&scene, Policy::default(), 1).1.total().crossings > 0);
}

#[test]
fn veils_weaken_light_from_lamps_of_every_kind_alike() {
    // A floor in front of the camera, with cards between it and the light behind the camera: each lets 0.6 through.
    let veil =
        "\"veil\": Detailed(of: Lambert(albedo: 0), opacity: Blend(alpha: 0.4)), \"floor\": Lambert(albedo: 0.8),
        \"lamp\": Emissive(radiance: 30),";
    let floor = "(shape: Quad(size: (2, 2)), material: \"floor\"),";
    let lamps = [
        ("integrator: Whitted, max_depth: 0, samples: 1", "(light: Point(intensity: 5), at: (1, 1, 20)),", 1e-6),
        (
            "integrator: Whitted, max_depth: 0, samples: 1",
            "(light: Directional(irradiance: 2), look_at: (0, 0, -1)),",
            1e-6,
        ),
        (PATH, "(light: Point(intensity: 5), at: (1, 1, 20)),", 1e-6),
        // Found by rays toward lights and by rays that go anywhere; the bound is four standard errors of 64 samples in 1024 pixels.
        (PATH, "(shape: Sphere(radius: 4), material: \"lamp\", at: (0, 0, 20)),", 4e-3),
        (PATH, "(shape: Quad(size: (6, 6)), material: \"lamp\", at: (0, 0, 20)),", 4e-3),
    ];
    for (settings, lamp, tolerance) in lamps {
        let entities = |cards: &str| format!("{floor} {lamp} {cards}");
        // The camera is below the cards.
        let clear = mean(&scene(settings, "0", veil, &entities(""))).x;
        let veiled = mean(&scene(settings, "0", veil, &entities(&cards(2, 10.0)))).x;
        let ratio = veiled / clear;
        assert!((ratio - 0.36f64).abs() < tolerance, "{lamp}: {ratio}");
    }
}

#[test]
fn a_veiled_lamp_gives_its_part_of_light() {
    let floor = "(shape: Quad(size: (2, 2)), material: \"floor\"),
        (shape: Quad(size: (8, 8)), material: \"lamp\", at: (0, 0, 12), rotate: (y: 180)),";
    let lit =
        |lamp: &str| mean(&scene(PATH, "0", &format!("\"floor\": Lambert(albedo: 0.8), \"lamp\": {lamp}"), floor)).x;
    let expected = lit("Emissive(radiance: 3)");
    let found = lit("Detailed(of: Emissive(radiance: 10), opacity: Blend(alpha: 0.3))");
    assert!((found / expected - 1.0).abs() < 1e-2, "{found} instead of {expected}");
}

#[test]
fn a_mask_is_there_or_not() {
    // Squares of a quarter: half of all, and none of them veiled.
    let mask = "\"veil\": Detailed(of: Emissive(radiance: 5), opacity: Mask(alpha: Map(texture: Checker(a: 0.4, b: 0.6, size: 0.25))))";
    let scene = scene(
        "samples: 4, integrator: Whitted, filter: Box",
        "0",
        mask,
        "(shape: Quad(size: (2, 2)), material: \"veil\"),",
    );
    for (place, color) in picture(&scene) {
        let squares = ((place.x + 1.0) * 2.0).floor() + ((place.y + 1.0) * 2.0).floor();
        let expected = if squares % 2.0 == 0.0 { 0.0 } else { 5.0 };
        assert_eq!(color.x, expected, "at {place}");
    }
}

#[test]
fn a_flat_map_changes_no_bit() {
    let of = |material: &str| {
        let scene = scene(
            "integrator: Path, max_depth: 3, samples: 8",
            "Gradient(horizon: 1, zenith: (0.1, 0.2, 0.9))",
            &format!("\"ball\": {material}"),
            "(shape: Sphere(radius: 0.9), material: \"ball\"),",
        );
        render(&scene).0
    };
    let metal = "Metal(of: \"Au\", alpha: 0.3)";
    let flat = "normal: Gradient(from: (0.5, 0.5, 1), to: (0.5, 0.5, 1))";
    let even = "bump: (texture: Gradient(from: 0.7, to: 0.7))";
    let plain = of(metal);
    assert!(of(&format!("Detailed(of: {metal}, {flat})")) == plain);
    assert!(of(&format!("Detailed(of: {metal}, {even})")) == plain);
}

/// Light straight from the camera's side on a floor whose normals lean by an angle: albedo/π · E · cos.
#[test]
fn normals_lean_as_maps_and_heights_say() {
    let seen = |light: &str, detail: &str| {
        let floor = format!("\"floor\": Detailed(of: Lambert(albedo: 0.8), {detail})");
        let entities =
            format!("(shape: Quad(size: (4, 4)), material: \"floor\"), (light: Directional(irradiance: 2), {light}),");
        mean(&scene("integrator: Whitted, max_depth: 0, samples: 1", "0", &floor, &entities)).x
    };
    let lambert = 0.8 / PI * 2.0;
    let light = |x: f64, y: f64| format!("at: ({x}, {y}, 1), look_at: (0, 0, 0)");
    // Red of 0.8 is 0.6 along u, and blue of 0.9 is 0.8 along the normal; green likewise along v.
    let map = |x: f64, y: f64| {
        let color = format!("({}, {}, 0.9)", 0.5 + 0.5 * x, 0.5 + 0.5 * y);
        format!("normal: Gradient(from: {color}, to: {color})")
    };
    // From the side at 45°, in units of √½.
    let slanted = |along: f64, up: f64| lambert * (along + up) * 0.5f64.sqrt();
    // A rise of 3 m over the quad's 4 m is a slope of 0.75: so much does the normal lean back.
    let ramp = |axis: &str| format!("bump: (texture: Gradient(from: 0, to: 1, axis: {axis}), factor: 3)");
    let length = (1.0f64 + 0.75 * 0.75).sqrt();
    for (name, found, expected) in [
        ("map from above", seen(&light(0.0, 0.0), &map(0.6, 0.0)), lambert * 0.8),
        ("map along u", seen(&light(1.0, 0.0), &map(0.6, 0.0)), slanted(0.6, 0.8)),
        ("map along v", seen(&light(0.0, 1.0), &map(0.0, 0.6)), slanted(0.6, 0.8)),
        ("map against v", seen(&light(0.0, 1.0), &map(0.0, -0.6)), slanted(-0.6, 0.8)),
        ("ramp from above", seen(&light(0.0, 0.0), &ramp("U")), lambert / length),
        ("ramp along u", seen(&light(1.0, 0.0), &ramp("U")), slanted(-0.75, 1.0) / length),
        ("ramp along v", seen(&light(0.0, -1.0), &ramp("V")), slanted(0.75, 1.0) / length),
    ] {
        assert!((found - expected).abs() < 1e-5, "{name}: {found} instead of {expected}");
    }
}

#[test]
fn a_mix_is_in_mean_what_lies_between() {
    // In even light a floor shows its albedo; a mirror image of the light is as bright.
    let seen = |material: &str| {
        mean(&scene(PATH, "1", &format!("\"floor\": {material}"), "(shape: Quad(size: (4, 4)), material: \"floor\"),"))
            .x
    };
    let two = "a: Lambert(albedo: 0.2), b: Lambert(albedo: 0.8)";
    for (material, expected) in [
        (format!("Mix({two}, by: 0.3)"), 0.7 * 0.2 + 0.3 * 0.8),
        (format!("Mix({two}, by: 0)"), 0.2),
        (format!("Mix({two}, by: 1)"), 0.8),
        (format!("Mix({two}, by: Map(texture: Checker(a: 0, b: 0.5, size: 0.125)))"), 0.75 * 0.2 + 0.25 * 0.8),
        (format!("Mix(a: Mix({two}, by: 0.5), b: Emissive(radiance: 3), by: 0.25)"), 0.75 * 0.5 + 0.25 * 3.0),
        ("Mix(a: Metal(r0: 0.9), b: Dielectric(ior: 1.5, thin: true))".to_owned(), 0.5 * 0.9 + 0.5),
    ] {
        let found = seen(&material);
        // Of 65,536 hits, each at most 3 apart from the mean.
        assert!((found - expected).abs() < 4.0 * 1.3 / 256.0, "{material}: {found} instead of {expected}");
    }
}

#[test]
fn a_mix_by_squares_is_one_or_the_other() {
    let mix = "\"floor\": Mix(a: Emissive(radiance: 1), b: Emissive(radiance: 4), by: Map(texture: Checker(a: 0, b: 1, size: 0.25)))";
    let floor = "(shape: Quad(size: (2, 2)), material: \"floor\"),";
    for (place, color) in picture(&scene("samples: 4, filter: Box", "0", mix, floor)) {
        let squares = ((place.x + 1.0) * 2.0).floor() + ((place.y + 1.0) * 2.0).floor();
        assert_eq!(color.x, if squares % 2.0 == 0.0 { 1.0 } else { 4.0 }, "at {place}");
    }
}

#[test]
fn bits_and_counts_do_not_depend_on_the_schedule() {
    let scene = load("details");
    let (film, stats) = render(&scene);
    assert!(stats.total().passed > 1000 && film.rejected() == 0);
    for (batch, capacity, threads) in [(1, 4096, 1), (200, 7, 3), (4096, 100, 2)] {
        let (other, counted) = render_with(&scene, Policy { batch, capacity, ..Policy::default() }, threads);
        assert!(other == film, "batch {batch}, capacity {capacity}, {threads} threads");
        assert_eq!(counts(&counted), counts(&stats), "batch {batch}, capacity {capacity}, {threads} threads");
    }
}

#[test]
fn no_ray_and_no_energy_is_lost_at_a_veil() {
    let scene = load("details");
    let (film, stats) = render_with(&scene, Policy { ledger: true, ..Policy::default() }, 1);
    assert_eq!(film.pixels().rays.iter().map(|&rays| u64::from(rays)).sum::<u64>(), stats.rays());
    let total = stats.total();
    assert_eq!(total.traced(), total.hits + total.crossings + total.escaped);
    let ledger = &total.ledger;
    for channel in 0..3 {
        let sum = |entries: &[Energy]| entries.iter().map(|entry| entry.0[channel]).sum::<i64>();
        let met = [ledger.volume, ledger.escaped, ledger.crossed, ledger.emitters, ledger.cut, ledger.scattered];
        assert_eq!(ledger.entered.0[channel], sum(&met), "channel {channel}");
    }
    assert!(ledger.z().iter().all(|z| z.abs() < 4.0), "{:?}", ledger.z());
}

/// Cameras look through the back of a card that shows its front alone, and light is blocked by either side.
#[test]
fn cameras_look_through_backs_that_light_meets() {
    let materials = |sides: &str| {
        format!(
            "\"card\": Detailed(of: Lambert(albedo: 0.5), sides: {sides}, opacity: Blend(alpha: 0.5)),
            \"floor\": Lambert(albedo: 0.8), \"lamp\": Emissive(radiance: 30),"
        )
    };
    let card = |turn: f32, height: f32| {
        format!("(shape: Quad(size: (90, 90)), material: \"card\", at: (0, 0, {height}), rotate: (y: {turn})),")
    };
    // In even light of 1, half of all rays see a card's albedo of 0.5.
    for (sides, turn, expected) in
        [("Both", 0.0, 0.75), ("Both", 180.0, 0.75), ("Front", 0.0, 0.75), ("Front", 180.0, 1.0)]
    {
        let found = mean(&scene(PATH, "1", &materials(sides), &card(turn, 5.0))).x;
        assert!((found - expected).abs() < 5e-3, "{sides} {turn}: {found}");
    }
    // Above the camera a card halves the light of points and lamps, however it is turned.
    for lamp in [
        "(light: Point(intensity: 5), at: (1, 1, 20)),",
        "(shape: Quad(size: (6, 6)), material: \"lamp\", at: (0, 0, 20)),",
    ] {
        let floor = format!("(shape: Quad(size: (2, 2)), material: \"floor\", at: (0, 0, 1)), {lamp}");
        let lit = |sides: &str, card: &str| mean(&scene(PATH, "0", &materials(sides), &format!("{card} {floor}"))).x;
        let clear = lit("Both", "");
        for turn in [0.0, 180.0] {
            let part = lit("Front", &card(turn, 10.0)) / clear;
            assert!((part - 0.5).abs() < 5e-3, "{lamp} {turn}: {part}");
        }
    }
}

/// A picture of squares as fine as a hundredth of a pixel is its mean, with one sample as with many, by way of a mirror too; from
/// near it is what it is without levels, to the bit.
#[test]
fn fine_pictures_are_their_mean_from_afar() {
    let floor = |mipmaps: bool, repeat: f32| {
        let texture = format!("Image(file: \"colors.png\", repeat: {repeat}, mipmaps: {mipmaps})");
        let materials = format!("\"floor\": Emissive(radiance: {texture}), \"mirror\": Metal(r0: 1, fresnel: Schlick)");
        let text = format!(
            "Scene(settings: (resolution: (16, 16), integrator: Path, max_depth: 3, samples: 1), background: 0,
            camera: Perspective(eye: (0, 0, 9), target: (0, 0, 0), vfov: 12),
            materials: {{{materials}}}, entities: [
                (shape: Quad(size: (9, 9)), material: \"floor\"),
                (shape: Quad(size: (1, 9)), material: \"mirror\", at: (0.3, 0, 3), rotate: (y: -90)),
            ])"
        );
        parse(&text)
    };
    let spread = |scene: &SceneBuffers| {
        let pixels = picture(scene);
        let mean = pixels.iter().map(|(_, color)| *color).sum::<DVec3>() / pixels.len() as f64;
        let squares = pixels.iter().map(|(_, color)| (*color - mean).length_squared()).sum::<f64>();
        (mean, (squares / pixels.len() as f64).sqrt())
    };
    let fine = 2000.0;
    let ((mean, of_levels), (noisy_mean, of_pixels)) = (spread(&floor(true, fine)), spread(&floor(false, fine)));
    assert!(of_levels < 1e-3 && of_pixels > 0.1, "{of_levels} {of_pixels}");
    assert!((mean - noisy_mean).abs().max_element() < 4.0 * of_pixels / 16.0, "{mean} {noisy_mean}");
    let of_picture = floor(true, fine).textures.mean(floor(true, fine).materials.emissive.get(0).radiance).as_dvec3();
    assert!((mean - of_picture).abs().max_element() < 1e-3, "{mean} {of_picture}");
    assert!(picture(&floor(true, 0.01)) == picture(&floor(false, 0.01)));
}
