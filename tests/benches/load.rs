//! From a large glTF file to its picture: `cargo bench -p brewster-tests --bench load [-- RUNS]`.
//!
//! The file is made anew: hills of 1,002,528 triangles with normals and texture coordinates, under a picture of 4096 x 4096 for the
//! color and another for metal and roughness, both PNG, in one GLB of 60 MB. Each run is a session of its own. Prints, for each run, seconds
//! to read the file, to flatten it (with its tree), to the first sample of every pixel of a picture of 960 x 540 and to the end of 16, all counted
//! from the start, and checks that every pixel has seen light.

use std::path::Path;
use std::time::Instant;

use brewster::film::{LinearImage, PngSettings, write_png};
use brewster::import::LoadOptions;
use brewster::wavefront::Control;
use brewster::{RenderOptions, Session, SessionOptions, SettingsChoices};
use glam::{UVec2, Vec3};

/// Squares along each side of the hills.
const SIDE: u32 = 708;
/// Pixels along each side of the pictures.
const PICTURE: u32 = 4096;

fn main() {
    let runs = std::env::args().skip(1).find_map(|argument| argument.parse().ok()).unwrap_or(3);
    let folder = std::env::temp_dir().join(format!("brewster-load-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a temporary folder");
    let file = folder.join("hills.glb");
    let bytes = hills(&folder);
    std::fs::write(&file, &bytes).expect("the file can be written");
    println!("hills.glb: {} triangles, {:.1} MB", 2 * SIDE * SIDE, bytes.len() as f64 * 1e-6);
    drop(bytes);
    println!("| run | load | flatten | first picture | final picture |");
    println!("| --- | --- | --- | --- | --- |");
    for run in 1..=runs {
        let [load, flatten, first, last] = measure(&file);
        println!("| {run} | {load:.2} s | {flatten:.2} s | {first:.2} s | {last:.2} s |");
    }
    std::fs::remove_dir_all(&folder).expect("the folder can be removed");
}

/// Seconds from the start to each milestone.
fn measure(file: &Path) -> [f64; 4] {
    let begin = Instant::now();
    let settings =
        SettingsChoices { resolution: Some(UVec2::new(960, 540)), samples: Some(16), ..SettingsChoices::default() };
    let options = SessionOptions { load: LoadOptions::default(), settings };
    let mut session = Session::new(file, options);
    session.load().expect("the file is right");
    let load = begin.elapsed().as_secs_f64();
    session.flatten().expect("the scene is right");
    let flatten = begin.elapsed().as_secs_f64();
    let mut render = session.render(RenderOptions::default()).expect("it can be rendered");
    let control = Control::default();
    render.pass(&control);
    let first = begin.elapsed().as_secs_f64();
    while render.remaining() > 0 {
        render.pass(&control);
    }
    let last = begin.elapsed().as_secs_f64();
    let image = render.film().resolve().image();
    assert!(image.color.iter().all(|color| color.iter().sum::<f32>() > 0.0), "a pixel is black");
    assert_eq!(session.buffers().instances.len(), 1);
    [load, flatten, first, last]
}

/// The height at a place from 0 to 1.
fn height(x: f32, z: f32) -> f32 {
    let waves = [(3.0, 5.0, 0.1), (11.0, 7.0, 0.03), (31.0, 43.0, 0.008)];
    waves.iter().map(|&(a, b, high)| high * (a * x + 0.3).sin() * (b * z).cos()).sum()
}

/// The file.
fn hills(folder: &Path) -> Vec<u8> {
    let row = SIDE + 1;
    let place = |i: u32| (i % row, i / row);
    let at = |x: u32, z: u32| (x as f32 / SIDE as f32, z as f32 / SIDE as f32);
    let (mut positions, mut normals, mut uvs) = (Vec::new(), Vec::new(), Vec::new());
    for (x, z) in (0..row * row).map(place) {
        let (u, v) = at(x, z);
        let step = 1e-3;
        let slope = |a: f32, b: f32| (height(u + a, v + b) - height(u - a, v - b)) / (2.0 * step);
        positions.extend(Vec3::new(u - 0.5, height(u, v), v - 0.5).to_array());
        normals.extend(Vec3::new(-slope(step, 0.0), 1.0, -slope(0.0, step)).normalize().to_array());
        uvs.extend([8.0 * u, 8.0 * v]);
    }
    let triangles = (0..SIDE * SIDE).flat_map(|i| {
        let first = i / SIDE * row + i % SIDE;
        [first, first + row, first + 1, first + 1, first + row, first + row + 1]
    });
    let indices: Vec<u8> = triangles.flat_map(u32::to_le_bytes).collect();
    let floats = |values: &[f32]| values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>();
    let color = picture(folder, |x, y| [0.2 + 0.6 * noise(x, y), 0.5, 0.1 + 0.3 * noise(y, x)]);
    let data = picture(folder, |x, y| [1.0, 0.4 + 0.5 * noise(x, y), noise(x / 64, y / 64).round()]);
    let views = [floats(&positions), floats(&normals), floats(&uvs), indices, color, data];
    let mut binary = Vec::new();
    let mut listed = Vec::new();
    for view in &views {
        binary.resize(binary.len().next_multiple_of(4), 0u8);
        listed.push(format!(r#"{{"buffer":0,"byteOffset":{},"byteLength":{}}}"#, binary.len(), view.len()));
        binary.extend(view);
    }
    binary.resize(binary.len().next_multiple_of(4), 0);
    let vertices = row * row;
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"NORMAL":1,"TEXCOORD_0":2}},"indices":3,"material":0}}]}}],
        "materials":[{{"doubleSided":true,"pbrMetallicRoughness":{{"baseColorTexture":{{"index":0}},"metallicRoughnessTexture":{{"index":1}}}}}}],
        "textures":[{{"source":0}},{{"source":1}}],
        "images":[{{"bufferView":4,"mimeType":"image/png"}},{{"bufferView":5,"mimeType":"image/png"}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":{vertices},"type":"VEC3"}},
        {{"bufferView":1,"componentType":5126,"count":{vertices},"type":"VEC3"}},
        {{"bufferView":2,"componentType":5126,"count":{vertices},"type":"VEC2"}},
        {{"bufferView":3,"componentType":5125,"count":{},"type":"SCALAR"}}],
        "bufferViews":[{}],"buffers":[{{"byteLength":{}}}]}}"#,
        6 * SIDE * SIDE,
        listed.join(","),
        binary.len()
    );
    let mut text = json.into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let number = |value: usize| (value as u32).to_le_bytes();
    let mut file = [*b"glTF", number(2), number(28 + text.len() + binary.len()), number(text.len()), *b"JSON"].concat();
    file.extend(text);
    file.extend([number(binary.len()), *b"BIN\0"].concat());
    file.extend(binary);
    file
}

/// A number from 0 to 1 for a pixel.
fn noise(x: u32, y: u32) -> f32 {
    let mixed = (x.wrapping_mul(0x9e37_79b9) ^ y.wrapping_mul(0x85eb_ca6b)).wrapping_mul(0xc2b2_ae35);
    (mixed >> 16) as f32 / 65535.0
}

/// A PNG whose pixels are told.
fn picture(folder: &Path, pixel: impl Fn(u32, u32) -> [f32; 3]) -> Vec<u8> {
    let places = (0..PICTURE * PICTURE).map(|i| (i % PICTURE / 8, i / PICTURE / 8));
    let color = places.map(|(x, y)| pixel(x, y)).collect();
    let image = LinearImage { width: PICTURE, height: PICTURE, color, alpha: None };
    let path = folder.join("picture.png");
    write_png(&path, &image, &PngSettings::default()).expect("the picture can be written");
    std::fs::read(&path).expect("the picture is there")
}
