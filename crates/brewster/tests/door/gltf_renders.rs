//! glTF files on the command line: a picture with no other argument, views, frames, and the report.

use std::path::Path;

use brewster::film::read_image;

use super::desk::Desk;

fn model(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/gltf/models").join(name);
    path.canonicalize().expect("the model is there").to_string_lossy().into_owned()
}

#[test]
fn a_box_renders_with_no_other_argument_than_its_size() {
    let desk = Desk::new();
    desk.run(&format!("render {} --resolution 32x24 --samples 4", model("Box/glTF-Binary/Box.glb")))
        .expect(0, "Box.png");
    let image = read_image(&desk.path("Box.png")).unwrap();
    // The box is red and in the middle, the paper behind it is gray.
    let [r, g, b] = image.color[12 * 32 + 16];
    assert!(r > 2.0 * g.max(b), "{r} {g} {b}");
    let [r, g, b] = image.color[0];
    assert!((r - g).abs().max((g - b).abs()) < 0.01 && r > 0.1, "{r} {g} {b}");
}

/// Samples go where there is noise; who asks for a number of them gets that everywhere.
#[test]
fn samples_are_spread_by_noise_unless_their_number_is_given() {
    let desk = Desk::new();
    let view = "--orbit 0,90,10 --target 0,0,0 --vfov 20 --background transparent --resolution 32x32";
    let command = format!("render {} {view} --quiet -o a.png --stats a.json", model("Box/glTF-Binary/Box.glb"));
    for (arguments, samples, threshold, least) in [
        ("", 256, serde_json::json!(0.015), 16),
        ("--samples 24", 24, serde_json::json!(null), 24),
        ("--samples 32 --noise-threshold 0.5", 32, serde_json::json!(0.5), 16),
    ] {
        desk.run(&format!("{command} {arguments}")).expect(0, "");
        let stats = desk.json("a.json");
        let (settings, of_pixels) = (&stats["settings"], &stats["samples"]);
        assert_eq!((&settings["samples"], &settings["noise_threshold"]), (&samples.into(), &threshold), "{arguments}");
        assert_eq!(of_pixels["least"], least, "{arguments}");
    }
}

#[test]
fn views_and_backdrops_are_as_asked() {
    let desk = Desk::new();
    let size = "--resolution 16x16 --samples 4 --quiet";
    let model = model("Box/glTF-Binary/Box.glb");
    // From far away the box of side 1 is in the middle alone; the corners show what is behind.
    desk.run(&format!(
        "render {model} {size} --orbit 0,90,10 --target 0,0,0 --vfov 20 --background transparent -o a.png"
    ))
    .expect(0, "");
    let image = read_image(&desk.path("a.png")).unwrap();
    let alpha = image.alpha.expect("it is transparent");
    assert_eq!((alpha[0], alpha[8 * 16 + 8]), (0.0, 1.0));
    desk.run(&format!(
        "render {model} {size} --eye 0,0,10 --target 0,0,0 --background #00ff00 --tonemap srgb -o b.png"
    ))
    .expect(0, "");
    assert_eq!(read_image(&desk.path("b.png")).unwrap().color[0], [0.0, 1.0, 0.0]);
    desk.run(&format!("render {model} {size} --eye 0,0,10 --target 0,0,10")).expect(1, "looks nowhere");
}

#[test]
fn frames_are_numbered_and_move() {
    let desk = Desk::new();
    let model = model("SimpleMorph/glTF/SimpleMorph.gltf");
    let view = "--eye 0.5,0.7,5 --target 0.5,0.7,0 --resolution 24x24 --samples 2 --background transparent --quiet";
    desk.run(&format!("render {model} {view} --frames 0..1 --fps 1 -o m.png")).expect(0, "");
    assert_eq!(desk.files(), ["m-0000.png", "m-0001.png"]);
    let [a, b] = ["m-0000.png", "m-0001.png"].map(|name| read_image(&desk.path(name)).unwrap().alpha);
    assert_ne!(a, b);
}

#[test]
fn the_report_names_extensions_and_decisions() {
    let desk = Desk::new();
    let said =
        desk.run(&format!("check {}", model("SimpleInstancing/glTF-Binary/SimpleInstancing.glb"))).expect(0, "").out;
    assert!(said.contains("note[extension]: EXT_mesh_gpu_instancing"), "{said}");
    assert!(said.contains("note[decision]: the file has no lights"), "{said}");
    desk.write("broken.gltf", r#"{"asset":{"version":"2.0"},"extensionsRequired":["KHR_lights_punctuall"]}"#);
    let said = desk.run("check broken.gltf").expect(1, "").out;
    assert!(said.contains("extensionsRequired[0]") && said.contains("did you mean `KHR_lights_punctual`?"), "{said}");
}

#[test]
fn a_file_is_converted_to_a_scene_that_renders() {
    let desk = Desk::new();
    let box_file = model("Box/glTF-Binary/Box.glb");
    desk.run(&format!("convert {box_file} out.ron")).expect(0, "not converted: what is behind things");
    assert_eq!(desk.files(), ["out", "out.ron"]);
    desk.run("render out.ron --resolution 16x16 --samples 2 --quiet -o out.png").expect(0, "");
    desk.run(&format!("convert {box_file} out.json")).expect(2, "ends in .ron");
    desk.run("convert absent.glb out.ron").expect(1, "there is no such file");
    // What an author has changed since is not written over, nor is a scene that is no glTF file.
    desk.write("out.ron", "Scene()");
    desk.run(&format!("convert {box_file} out.ron")).expect(1, "there is such a file already; --force replaces it");
    assert_eq!(desk.read("out.ron"), b"Scene()");
    desk.run(&format!("convert {box_file} out.ron --force")).expect(0, "");
    assert!(desk.read("out.ron").starts_with(b"// Converted from Box.glb"));
    desk.run("convert out.ron out.ron --force").expect(2, "ends in .gltf or .glb");
}

/// Neighbors of flat paper in the picture of few samples differ by noise, and less so once it is denoised; the EXR stays.
#[test]
fn noise_is_taken_out_when_asked() {
    let desk = Desk::new();
    let view = "--resolution 32x32 --samples 2 --quiet --eye 0,0,1.2 --target 0,0,0";
    let command = format!("render {} {view}", model("Box/glTF-Binary/Box.glb"));
    desk.run(&format!("{command} -o plain.hdr -o plain.exr")).expect(0, "");
    desk.run(&format!("{command} --denoise -o soft.hdr -o soft.exr")).expect(0, "");
    let read = |name: &str| read_image(&desk.path(name)).unwrap().color;
    let roughness = |name: &str| {
        let color = read(name);
        let rows = color.chunks(32).skip(8).take(16).flat_map(|row| row[8..24].windows(2));
        rows.map(|pair| (pair[0][0] - pair[1][0]).abs()).sum::<f32>()
    };
    assert!(
        roughness("soft.hdr") < 0.6 * roughness("plain.hdr"),
        "{} {}",
        roughness("soft.hdr"),
        roughness("plain.hdr")
    );
    assert!(read("soft.exr") == read("plain.exr"));
}
