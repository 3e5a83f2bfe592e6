//! Every format, option and error of `render`.

use std::fs;

use brewster::film::read_image;
use brewster::wavefront::Control;
use brewster::{RenderOptions, Session, SessionOptions};

use super::desk::{Desk, SCENE};

#[test]
fn without_an_output_the_picture_has_the_scenes_name() {
    let desk = Desk::new();
    fs::create_dir(desk.path("scenes")).unwrap();
    desk.write("scenes/ball.ron", SCENE);
    desk.run("render scenes/ball.ron").expect(0, "wrote    ball.png");
    assert_eq!(desk.files(), ["ball.png", "scenes"]);
    let image = read_image(&desk.path("ball.png")).unwrap();
    assert_eq!((image.width, image.height), (48, 32));
}

#[test]
fn one_render_gives_several_files_of_the_same_picture() {
    let desk = Desk::with_scene();
    desk.run("render scene.ron -o a.png -o b.exr -o c.hdr --quiet").expect(0, "");
    let [exr, hdr] = ["b.exr", "c.hdr"].map(|name| read_image(&desk.path(name)).unwrap());
    for (a, b) in exr.color.iter().zip(&hdr.color) {
        let largest = a.iter().fold(0.0f32, |largest, &value| largest.max(value));
        for (a, b) in a.iter().zip(b) {
            assert!((a - b).abs() <= largest / 128.0, "{a} in the EXR, {b} in the HDR");
        }
    }

    // The same picture through the API.
    let mut session = Session::new("scene.ron", SessionOptions::default());
    session.load_text(SCENE).unwrap();
    session.flatten().unwrap();
    let mut render = session.render(RenderOptions { threads: 3, ..RenderOptions::default() }).unwrap();
    while render.remaining() > 0 {
        render.pass(&Control::default());
    }
    assert_eq!(render.film().resolve().image(), exr);
}

#[test]
fn an_exr_says_where_it_comes_from() {
    let desk = Desk::with_scene();
    desk.run("render scene.ron -o a.exr --stats a.json --seed 7 --camera top").expect(0, "");
    let (bytes, stats) = (desk.read("a.exr"), desk.json("a.json"));
    let header = String::from_utf8_lossy(&bytes[..4096.min(bytes.len())]).into_owned();
    let hash = stats["scene"]["hash"].as_str().unwrap();
    for part in [hash, brewster::PROGRAM, "\"seed\":7", "\"camera\":\"top\""] {
        assert!(header.contains(part), "{part} is not in the header");
    }
}

#[test]
fn options_take_the_place_of_settings() {
    let desk = Desk::with_scene();
    let options = "--resolution 20x10 --samples 3 --max-depth 1 --seed 5 --integrator whitted --crop 4,2,8,6";
    desk.run(&format!("render scene.ron -o a.exr --stats a.json {options}")).expect(0, "");
    let settings = &desk.json("a.json")["settings"];
    let expected = serde_json::json!({
        "resolution": [20, 10], "crop": [4, 2, 8, 6], "camera": "", "integrator": "Whitted", "max_depth": 1,
        "samples": 3, "noise_threshold": null, "seed": 5, "sampler": "Sobol", "split_depth": 1, "roulette": true,
        "guiding": false, "clamp": null,
        "filter": "BlackmanHarris", "transparent_shadows": false,
        "contribution_threshold": 0.0, "exposure": 0.0, "tone_mapping": "Srgb",
    });
    assert_eq!(*settings, expected);
    let image = read_image(&desk.path("a.exr")).unwrap();
    assert_eq!((image.width, image.height), (20, 10));
    let outside = image.color.iter().enumerate().filter(|(index, _)| index % 20 < 4 || index / 20 < 2);
    assert!(outside.into_iter().all(|(_, color)| *color == [0.0; 3]), "outside the crop window");
}

#[test]
fn blocks_below_the_noise_threshold_get_no_more_samples() {
    let desk = Desk::with_scene();
    let options = "--samples 256 --noise-threshold 0.02 --stats a.json";
    desk.run(&format!("render scene.ron -o a.exr {options}")).expect(0, "samples  16 to ");
    let samples = &desk.json("a.json")["samples"];
    assert_eq!((&samples["asked"], &samples["least"]), (&256.into(), &16.into()));
    let total = samples["total"].as_u64().unwrap();
    assert!((48 * 32 * 16..48 * 32 * 256).contains(&total), "{samples}");
}

#[test]
fn the_largest_contributions_are_told_with_where_they_came_from() {
    let desk = Desk::with_scene();
    desk.run("render scene.ron -o a.png --fireflies --stats a.json").expect(0, "largest  ");
    let stats = desk.json("a.json");
    assert_eq!(stats["not_light"], serde_json::json!([]));
    let fireflies = stats["fireflies"].as_array().unwrap();
    assert_eq!(fireflies.len(), 16);
    let largest = |firefly: &serde_json::Value| {
        let channels = firefly["radiance"].as_array().unwrap().iter();
        channels.map(|channel| channel.as_f64().unwrap()).fold(0.0, f64::max)
    };
    assert!(fireflies.is_sorted_by(|a, b| largest(a) >= largest(b)), "{fireflies:#?}");
    for firefly in fireflies {
        let entity = firefly["entity"].as_str().unwrap();
        assert!(["floor", "ball", "pane"].contains(&entity), "{firefly}");
        let path = firefly["path"].as_str().unwrap();
        assert!(path.starts_with("C R ") || path.starts_with("C T "), "{firefly}");
        assert!(firefly["depth"].as_u64().unwrap() > 0, "{firefly}");
    }
}

#[test]
fn options_of_paths_take_the_place_of_settings() {
    let desk = Desk::new();
    desk.write("scene.ron", &SCENE.replace("Phong(diffuse: 0.7, specular: 0.1, exponent: 40)", "Lambert(albedo: 0.7)"));
    let options = "--integrator path --sampler independent --split-depth 3 --clamp 2.5";
    desk.run(&format!("render scene.ron -o a.exr --stats a.json {options}")).expect(0, "");
    let settings = &desk.json("a.json")["settings"];
    let found = ["integrator", "sampler", "split_depth", "clamp"].map(|name| settings[name].to_string());
    assert_eq!(found, ["\"Path\"", "\"Independent\"", "3", "2.5"]);
    for (options, is_same) in [("", false), (options, true)] {
        desk.run(&format!("render scene.ron -o b.exr {options}")).expect(0, "");
        assert_eq!(read_image(&desk.path("a.exr")).unwrap() == read_image(&desk.path("b.exr")).unwrap(), is_same);
    }
}

#[test]
fn overrides_reach_the_scene() {
    let desk = Desk::with_scene();
    let white = r#"--set background=(1,1,1) --set entities.ball.at=(0,50,0) --set entities.pane.at=(0,50,0)"#;
    desk.run(&format!("render scene.ron -o a.hdr {white}")).expect(0, "");
    assert_eq!(read_image(&desk.path("a.hdr")).unwrap().color[0], [1.0; 3]);
    desk.run("render scene.ron --set entities.bal.at=(0,0,0)").expect(1, "ball");
    desk.run("render scene.ron --set nonsense").expect(2, "PATH=VALUE");
}

#[test]
fn depth_and_display_change_a_png() {
    let desk = Desk::with_scene();
    desk.run("render scene.ron -o 8.png").expect(0, "");
    desk.run("render scene.ron -o 16.png --png-depth 16").expect(0, "");
    desk.run("render scene.ron -o dark.png --exposure -20").expect(0, "");
    // Bits per channel stand in byte 24 of a PNG.
    assert_eq!([desk.read("8.png")[24], desk.read("16.png")[24]], [8, 16]);
    assert!(read_image(&desk.path("dark.png")).unwrap().color.iter().flatten().all(|&value| value < 0.001));
}

#[test]
fn what_cannot_be_written_is_told_before_anything_is_done() {
    let desk = Desk::with_scene();
    for (arguments, code, message) in [
        ("-o picture.jpg", 2, "expected a name that ends in .png, .exr or .hdr"),
        ("-o picture", 2, "expected a name that ends in .png, .exr or .hdr"),
        ("-o no/such/folder/a.png", 1, "there is no folder no/such/folder"),
        ("-o a.png --stats no/a.json", 1, "there is no folder no"),
        ("-o a.png -o a.png", 2, "named for two files"),
        ("--resolution 0x10", 2, "expected WxH"),
        ("--samples 0", 2, "1..=1048576"),
        ("--integrator Paths", 2, "Whitted, Path"),
        ("--integrator Path", 1, "Phong"),
        ("--sampler Halton", 2, "Sobol, Independent"),
        ("--clamp 0", 2, "expected a number above 0"),
        ("--split-depth 1001", 2, "0..=1000"),
        ("--time-limit 0", 2, "expected seconds above 0"),
        ("--time-limit 1e-9", 1, "before the first sample"),
        ("--crop 40,0,20,10", 1, "crop window"),
        ("--resolution 70000x1", 2, "65536"),
        ("--eye 0,0,0 --target 0,0,0", 1, "the camera looks nowhere"),
        ("--eye 1e30,0,0", 1, "the camera looks nowhere"),
        ("--up 0,0,0", 1, "along its own up"),
        ("--camera side", 1, "\"top\""),
        ("--allow-path nowhere", 2, "expected a folder"),
        ("--watch --stats a.json", 2, "cannot be used with"),
    ] {
        desk.run(&format!("render scene.ron {arguments}")).expect(code, message);
    }
    desk.run("render missing.ron").expect(1, "missing.ron");
    // No file system here takes names of more than 255 bytes.
    let long = "a".repeat(300);
    desk.run(&format!("render scene.ron -o {long}.png --samples 1048576")).expect(1, "too long");
    assert_eq!(desk.files(), ["scene.ron"]);
}

/// A film has at most 2^27 pixels: 60,000 x 60,000 are more, whoever asks for them.
#[test]
fn too_large_a_picture_is_told_where_it_is_asked_for() {
    let desk = Desk::with_scene();
    desk.run("render scene.ron --resolution 60000x60000").expect(2, "'--resolution <WxH>': a picture of 60000x60000");
    let set = "--set settings.resolution=(60000,60000)";
    desk.run(&format!("render scene.ron {set}")).expect(1, "--> --set:1:21");
    desk.write("large.ron", &SCENE.replace("(48, 32)", "(60000, 60000)"));
    desk.run("render large.ron").expect(1, "--> large.ron:2:28");
    desk.run("render large.ron --resolution 4x4 --quiet").expect(0, "");
}

#[test]
fn what_chooses_from_gltf_files_chooses_nothing_elsewhere() {
    let desk = Desk::with_scene();
    for option in ["--scene 0", "--variant red", "--animation all", "--time 1", "--shutter 1", "--frames 0..3"] {
        desk.run(&format!("render scene.ron {option}")).expect(1, "chooses from a glTF file");
    }
}

#[cfg(unix)]
#[test]
fn an_output_is_replaced_whole_or_not_at_all() {
    let desk = Desk::with_scene();
    desk.write("a.png", "the old picture");
    desk.write("broken.ron", "Scene(");
    desk.run("render broken.ron -o a.png").expect(1, "broken.ron");
    assert_eq!(desk.read("a.png"), b"the old picture");
    desk.run("render scene.ron -o a.png").expect(0, "");
    assert!(read_image(&desk.path("a.png")).is_ok());
    assert_eq!(desk.files(), ["a.png", "broken.ron", "scene.ron"], "nothing else is left behind");
}

#[test]
fn quiet_says_nothing_and_lines_say_every_stage() {
    let desk = Desk::with_scene();
    let quiet = desk.run("render scene.ron --quiet");
    assert_eq!((quiet.code, quiet.out.as_str(), quiet.err.as_str()), (Some(0), "", ""));
    let lines = desk.run("render scene.ron").expect(0, "");
    assert_eq!(lines.out, "");
    let stages = ["load", "flatten", "trees", "trace", "encode", "rays", "memory", "wrote"];
    for stage in stages.into_iter().filter(|&stage| stage != "memory" || cfg!(target_os = "linux")) {
        assert!(lines.err.lines().any(|line| line.starts_with(stage)), "no line for {stage}:\n{}", lines.err);
    }
    let rays = lines.err.lines().skip_while(|line| !line.starts_with("rays"));
    let queues: Vec<_> = rays.skip(1).take(4).filter_map(|line| line.split_whitespace().next()).collect();
    assert_eq!(queues, ["primary", "reflection", "transmission", "shadow"], "{}", lines.err);
    // 48 x 32 pixels, 4 samples each.
    assert!(lines.err.contains("6,144"), "{}", lines.err);
}

#[test]
fn warnings_are_told_and_do_not_stop() {
    let desk = Desk::new();
    desk.write("scene.ron", &SCENE.replace("\"gold\": Metal", "\"unused\": Metal(of: \"silver\"), \"gold\": Metal"));
    let ended = desk.run("render scene.ron").expect(0, "unused");
    assert!(ended.err.contains("warnings 1"), "{}", ended.err);
}

#[test]
fn files_outside_the_folder_need_leave() {
    let desk = Desk::new();
    fs::create_dir(desk.path("scenes")).unwrap();
    fs::create_dir(desk.path("meshes")).unwrap();
    desk.write("meshes/triangle.obj", "v -1 0 0\nv 1 0 0\nv 0 1.5 0\nf 1 2 3\n");
    let mesh = "shape: Mesh(file: \"../meshes/triangle.obj\")";
    desk.write("scenes/scene.ron", &SCENE.replace("shape: Sphere(radius: 1)", mesh));
    desk.run("render scenes/scene.ron").expect(1, "--allow-path");
    desk.run("render scenes/scene.ron --allow-path meshes").expect(0, "wrote");
}

#[test]
fn what_another_model_changes_is_written_in_place_of_the_picture() {
    let desk = Desk::with_scene();
    let said = desk.run("render scene.ron --fresnel-error a.exr --threads 2").expect(0, "Schlick differs by").err;
    assert!(said.contains("wrote    a.exr"), "{said}");
    desk.run("render scene.ron --fresnel-error a.png --approximation SchlickThetaM --quiet").expect(0, "");
    assert_eq!(desk.files(), ["a.exr", "a.png", "scene.ron"]);
    desk.run("render scene.ron --fresnel-error a.hdr").expect(2, "a difference is an .exr or a .png file");
    desk.run("render scene.ron --fresnel-error a.exr -o b.png").expect(2, "cannot be used with");
}

#[test]
fn without_queues_it_is_the_same_picture() {
    let desk = Desk::with_scene();
    desk.run("render scene.ron --quiet -o a.exr").expect(0, "");
    desk.run("render scene.ron --quiet --executor Megakernel -o b.exr").expect(0, "");
    assert!(desk.read("a.exr") == desk.read("b.exr"), "another picture");
}
