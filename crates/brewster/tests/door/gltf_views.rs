//! Arguments that choose a part of a glTF file, a camera, a moment or a sky: each picture is known by hand.
//!
//! The file holds two unlit squares of width 1: a red one at x = 2, which is blue in the variant "night", and a green one at
//! y = 2, which falls by 4 m within the first second of the animation "fall" and rises by 1 m in that of "rise".

use std::fs;

use brewster::film::{LinearImage, read_image, srgb_encode};
use serde_json::json;

use super::desk::Desk;

/// Width and height of the pictures.
const SIZE: usize = 64;

fn desk() -> Desk {
    let floats = |values: &[f32]| values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>();
    let corners = [-0.5, -0.5, 0.0, 0.5, -0.5, 0.0, 0.5, 0.5, 0.0, -0.5, -0.5, 0.0, 0.5, 0.5, 0.0, -0.5, 0.5, 0.0];
    let buffer = [floats(&corners), floats(&[0.0, 1.0]), floats(&[0.0, 2.0, 0.0, 0.0, -2.0, 0.0])];
    let buffer = [buffer.concat(), floats(&[0.0, 2.0, 0.0, 0.0, 3.0, 0.0])].concat();
    let unlit = |color: [f32; 3]| {
        json!({
            "pbrMetallicRoughness": {"baseColorFactor": [color[0], color[1], color[2], 1.0]},
            "extensions": {"KHR_materials_unlit": {}},
        })
    };
    let moved = |name: &str, output: u32| {
        json!({
            "name": name,
            "samplers": [{"input": 1, "output": output}],
            "channels": [{"sampler": 0, "target": {"node": 1, "path": "translation"}}],
        })
    };
    let attributes = json!({"POSITION": 0});
    let mappings = json!({"KHR_materials_variants": {"mappings": [{"material": 2, "variants": [0]}]}});
    let view = |offset: u32, length: u32| json!({"buffer": 0, "byteOffset": offset, "byteLength": length});
    let rows = |view: u32, count: u32, kind: &str| json!({"bufferView": view, "componentType": 5126, "count": count, "type": kind});
    let file = json!({
        "asset": {"version": "2.0"},
        "extensionsUsed": ["KHR_materials_unlit", "KHR_materials_variants"],
        "extensions": {"KHR_materials_variants": {"variants": [{"name": "night"}]}},
        "scene": 0,
        "scenes": [{"name": "both", "nodes": [0, 1, 2, 3]}, {"name": "green", "nodes": [1, 3]}],
        "nodes": [
            {"mesh": 0, "translation": [2, 0, 0]},
            {"mesh": 1, "translation": [0, 2, 0]},
            {"name": "near", "camera": 0, "translation": [0, 0, 10]},
            {"name": "far", "camera": 1, "translation": [0, 0, 10]},
        ],
        "cameras": [
            {"name": "near", "type": "orthographic", "orthographic": {"xmag": 4, "ymag": 4, "znear": 0, "zfar": 100}},
            {"name": "far", "type": "orthographic", "orthographic": {"xmag": 8, "ymag": 8, "znear": 0, "zfar": 100}},
        ],
        "meshes": [
            {"primitives": [{"attributes": attributes, "material": 0, "extensions": mappings}]},
            {"primitives": [{"attributes": attributes, "material": 1}]},
        ],
        "materials": [unlit([1.0, 0.0, 0.0]), unlit([0.0, 1.0, 0.0]), unlit([0.0, 0.0, 1.0])],
        "animations": [moved("fall", 2), moved("rise", 3)],
        "accessors": [rows(0, 6, "VEC3"), rows(1, 2, "SCALAR"), rows(2, 2, "VEC3"), rows(3, 2, "VEC3")],
        "bufferViews": [view(0, 72), view(72, 8), view(80, 24), view(104, 24)],
        "buffers": [{"byteLength": buffer.len(), "uri": "squares.bin"}],
    });
    let desk = Desk::new();
    fs::write(desk.path("squares.bin"), buffer).expect("the folder can be written to");
    desk.write("squares.gltf", &file.to_string());
    desk
}

/// The picture of some arguments, in linear light, before nothing.
fn shown(desk: &Desk, arguments: &str) -> LinearImage {
    let size = format!("--resolution {SIZE}x{SIZE} --samples 64 --background transparent --quiet");
    desk.run(&format!("render squares.gltf {size} {arguments} -o a.exr")).expect(0, "");
    read_image(&desk.path("a.exr")).expect("the picture")
}

/// Which colors there are in the middle of squares at places in meters, if the picture shows so many.
fn at(image: &LinearImage, meters: f32, places: &[[f32; 2]]) -> String {
    let pixel = |place: f32| ((place / meters + 0.5) * SIZE as f32) as usize;
    let names = places.iter().map(|&[x, y]| match image.color[pixel(-y) * SIZE + pixel(x)].map(|value| value > 0.5) {
        [true, false, false] => 'r',
        [false, true, false] => 'g',
        [false, false, true] => 'b',
        _ => '-',
    });
    names.collect()
}

/// Where the two squares stand.
const BOTH: [[f32; 2]; 2] = [[2.0, 0.0], [0.0, 2.0]];

#[test]
fn parts_are_chosen_by_name() {
    let desk = desk();
    for (arguments, meters, expected) in [
        ("", 8.0, "rg"),
        ("--camera far", 16.0, "rg"),
        ("--camera near", 8.0, "rg"),
        ("--scene green --camera far", 16.0, "-g"),
        ("--variant night", 8.0, "bg"),
    ] {
        assert_eq!(at(&shown(&desk, arguments), meters, &BOTH), expected, "{arguments}");
    }
    for argument in ["--scene blue", "--camera blue", "--variant blue", "--animation blue --time 0"] {
        let ended = desk.run(&format!("render squares.gltf {argument} -o b.png"));
        assert_ne!(ended.code, Some(0), "{argument}");
    }
}

#[test]
fn moments_are_those_of_the_animation() {
    let desk = desk();
    // Where it is at first, half-way, at its end; and where it is risen by half a meter, which leaves it over the first place.
    let places = [[0.0, 2.1], [0.0, 0.0], [0.0, -2.0], [0.0, 2.7]];
    for (arguments, expected) in [
        ("--time 0", "g---"),
        ("--time 0.5", "-g--"),
        ("--animation fall --time 1", "--g-"),
        ("--animation 0 --time 9", "--g-"),
        ("--animation rise --time 0.5", "g--g"),
    ] {
        assert_eq!(at(&shown(&desk, arguments), 8.0, &places), expected, "{arguments}");
    }
    // It passes every place on its way in a quarter of the time.
    let image = shown(&desk, "--time 0 --shutter 1");
    let alpha = image.alpha.expect("it is transparent")[SIZE / 2 * SIZE + SIZE / 2];
    assert!((alpha - 0.25).abs() < 0.05, "{alpha}");
}

#[test]
fn cameras_are_where_they_are_put() {
    let desk = desk();
    // From 10 m, 2 tan(v/2) 10 m high: 8 m for v = 43.6028 degrees.
    let view = "--eye 0,0,10 --target 0,0,0 --vfov 43.6028";
    assert_eq!(at(&shown(&desk, view), 8.0, &BOTH), "rg");
    assert_eq!(at(&shown(&desk, "--eye 0,0,10 --target 0,0,0 --vfov 77.3196"), 16.0, &BOTH), "rg");
    // With +X up, -Y is on the right.
    assert_eq!(at(&shown(&desk, &format!("{view} --up 1,0,0")), 8.0, &[[0.0, 2.0], [-2.0, 0.0]]), "rg");
    // From behind, where materials that are not double-sided are not seen; from 60 degrees toward +X, at half of its x.
    assert_eq!(at(&shown(&desk, "--orbit 180,90,10 --target 0,0,0 --vfov 43.6028"), 8.0, &[[-2.0, 0.0]]), "-");
    assert_eq!(at(&shown(&desk, "--orbit 60,90,1000 --target 0,0,0 --vfov 0.458366"), 8.0, &[[1.0, 0.0]]), "r");
    assert_eq!(at(&shown(&desk, "--orbit 0,90,10 --target 2,0,0 --vfov 43.6028"), 8.0, &[[0.0, 0.0]]), "r");
}

/// A sky of eight columns. By the mapping u = atan2(z, x)/2π + 1/2 the columns 1 and 2 meet at -Z, 3 and 4 at +X, 5 and 6 at +Z.
#[test]
fn skies_are_turned_and_scaled() {
    let desk = desk();
    let columns: [[u8; 4]; 8] = [
        [0, 0, 128, 129],
        [0, 128, 0, 129],
        [0, 128, 0, 129],
        [128, 0, 0, 129],
        [128, 0, 0, 129],
        [128, 128, 128, 129],
        [128, 128, 128, 129],
        [0, 0, 128, 129],
    ];
    let mut sky = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n".to_vec();
    (0..4).for_each(|_| sky.extend(columns.as_flattened()));
    fs::write(desk.path("sky.hdr"), sky).expect("the folder can be written to");
    // Looking along -Z past the squares; what is at +X comes there by a quarter turn counterclockwise about +Y.
    for (arguments, expected) in [
        ("", [0.0, 1.0, 0.0]),
        ("--environment-rotation 90", [1.0, 0.0, 0.0]),
        ("--environment-rotation=-90", [0.0, 0.0, 1.0]),
        ("--environment-rotation 180", [1.0; 3]),
        ("--environment-strength 2.5", [0.0, 2.5, 0.0]),
    ] {
        let view = "--eye 0,0,0 --target 0,0,-1 --vfov 1 --resolution 4x4 --quiet --samples 4";
        let sky = "--environment sky.hdr --background environment";
        desk.run(&format!("render squares.gltf {view} {sky} {arguments} -o sky.exr")).expect(0, "");
        let image = read_image(&desk.path("sky.exr")).expect("the picture");
        assert!(image.color.iter().all(|color| *color == expected), "{arguments}: {:?}", image.color[0]);
    }
}

/// The studio that stands around a file without lights anyway is there when it is asked for, in the strength that is asked for.
#[test]
fn a_studio_can_be_asked_for() {
    let desk = desk();
    let seen = |arguments: &str| {
        let view = "--eye 0,0,0 --target=-0.62,0.58,0.53 --vfov 20 --resolution 8x8 --quiet --samples 4";
        desk.run(&format!("render squares.gltf {view} --background environment {arguments} -o studio.exr"))
            .expect(0, "");
        read_image(&desk.path("studio.exr")).expect("the picture").color
    };
    let plain = seen("");
    assert!(plain.iter().all(|color| color[0] > 2.0), "the brightest light: {plain:?}");
    assert_eq!(seen("--environment studio"), plain);
    let twice: Vec<[f32; 3]> = plain.iter().map(|color| color.map(|channel| 2.0 * channel)).collect();
    let found = seen("--environment studio --environment-strength 2");
    let is_near = |(a, b): (&[f32; 3], &[f32; 3])| (a[0] - b[0]).abs() < 1e-5 * b[0];
    assert!(found.iter().zip(&twice).all(is_near), "{found:?} instead of {twice:?}");
}

/// Unlit red of 1, a quarter after two stops: 0.5371 on the curve of sRGB. PBR Neutral leaves what is below 0.8 and has a part of
/// black as it is.
#[test]
fn radiance_is_shown_as_asked() {
    let desk = desk();
    let red = |arguments: &str| {
        let size = "--resolution 8x8 --samples 4 --quiet --eye 2,0,1 --target 2,0,0 --vfov 10 --background #000000";
        desk.run(&format!("render squares.gltf {size} {arguments} -o red.png")).expect(0, "");
        srgb_encode(read_image(&desk.path("red.png")).expect("the picture").color[0][0])
    };
    for (arguments, expected) in [
        ("--tonemap none --exposure=-2", 0.25),
        ("--tonemap srgb --exposure=-2", 0.5371),
        ("--tonemap srgb --exposure 3", 1.0),
        ("--tonemap pbr-neutral --exposure=-2", 0.5371),
    ] {
        let found = red(arguments);
        assert!((found - expected).abs() < 1.0 / 255.0, "{arguments}: {found}");
    }
    let others = ["filmic", "aces", "agx", "pbr-neutral"].map(|name| red(&format!("--tonemap {name} --exposure 1")));
    assert!(others.iter().enumerate().all(|(at, one)| !others[..at].contains(one)), "{others:?}");
}
