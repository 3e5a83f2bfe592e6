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
