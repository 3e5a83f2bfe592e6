//! What is wrong with a scene, as text and as JSON.

use serde_json::Value;

use super::desk::{Desk, SCENE};

fn findings(desk: &Desk, code: i32) -> Value {
    let ended = desk.run("check scene.ron --format json").expect(code, "");
    serde_json::from_str(&ended.out).unwrap_or_else(|error| panic!("{error}: {}", ended.out))
}

#[test]
fn a_sound_scene_passes() {
    let desk = Desk::with_scene();
    let ended = desk.run("check scene.ron").expect(0, "");
    assert_eq!((ended.out.as_str(), ended.err.as_str()), ("scene.ron: 0 errors, 0 warnings\n", ""));
    assert_eq!(findings(&desk, 0), serde_json::json!({"version": 1, "errors": 0, "warnings": 0, "diagnostics": []}));
}

#[test]
fn errors_have_a_place_and_the_nearest_name() {
    let desk = Desk::new();
    desk.write("scene.ron", &SCENE.replace("material: \"gold\"", "material: \"golf\"").replace("ior: 1.5", "ior: 0.5"));
    let text = desk.run("check scene.ron").expect(1, "");
    for part in ["golf", "did you mean \"gold\"?", "scene.ron:8:", "2 errors"] {
        assert!(text.out.contains(part), "{part} is not in\n{}", text.out);
    }
    let json = findings(&desk, 1);
    assert_eq!(json["errors"], 2);
    let errors = json["diagnostics"].as_array().unwrap().iter().filter(|found| found["severity"] == "error");
    let lines: Vec<_> =
        errors.map(|found| (found["file"].as_str().unwrap(), found["line"].as_u64().unwrap())).collect();
    assert_eq!(lines, [("scene.ron", 8), ("scene.ron", 13)]);
}

#[test]
fn warnings_leave_the_exit_code_alone() {
    let desk = Desk::new();
    desk.write("scene.ron", &SCENE.replace("\"gold\": Metal", "\"tin\": Metal(of: \"silver\"), \"gold\": Metal"));
    let json = findings(&desk, 0);
    assert_eq!((&json["errors"], &json["warnings"]), (&Value::from(0), &Value::from(1)));
    assert_eq!(json["diagnostics"][0]["code"], "unused");
}

#[test]
fn what_the_integrator_cannot_render_is_an_error() {
    let desk = Desk::new();
    let lens = "vfov: 36, lens: (aperture_radius: 0.1, focus_distance: 5)";
    desk.write("scene.ron", &SCENE.replace("vfov: 36", lens));
    let json = findings(&desk, 1);
    assert_eq!((&json["diagnostics"][0]["code"], &json["diagnostics"][0]["line"]), (&"integrator".into(), &3.into()));
    assert!(json["diagnostics"][0]["message"].as_str().unwrap().contains("lens"), "{json}");
    desk.run("render scene.ron").expect(1, "lens");

    // The camera goes into the glass while the shutter is open.
    let pan = "vfov: 36, motion: (eye: (1.2, 1, 0.4), target: (1.2, 1, -1))";
    let glass = "shape: Sphere(radius: 1), material: \"glass\"";
    let scene = SCENE.replace("vfov: 36", pan).replace("shape: Box(size: (1.6, 2, 0.1)), material: \"glass\"", glass);
    desk.write("scene.ron", &scene);
    let json = findings(&desk, 1);
    assert_eq!((&json["diagnostics"][0]["code"], &json["diagnostics"][0]["line"]), (&"integrator".into(), &3.into()));

    desk.write("scene.ron", &SCENE.replace("(48, 32)", "(65536, 65536)"));
    let json = findings(&desk, 1);
    assert!(json["diagnostics"][0]["message"].as_str().unwrap().contains("65536 x 65536"), "{json}");
}

#[test]
fn entities_that_no_picture_holds_have_a_place() {
    let desk = Desk::new();
    let far = r#"        (at: (9e14, 0, 0), children: [
            (shape: Sphere(), material: "gold", at: (9e14, 0, 0)),
        ]),
        (name: "lamp", "#;
    desk.write("scene.ron", &SCENE.replace("        (name: \"lamp\", ", far));
    let json = findings(&desk, 1);
    let found = &json["diagnostics"][0];
    assert_eq!((&found["code"], &found["file"]), (&"invalid-entity".into(), &"scene.ron".into()));
    assert_eq!((&found["line"], &found["column"]), (&16.into(), &13.into()), "{json}");
    desk.run("render scene.ron").expect(1, "scene.ron:16:13");
}

#[test]
fn a_missing_file_is_an_error_of_the_input() {
    let desk = Desk::new();
    let json = findings(&desk, 1);
    assert_eq!(json["diagnostics"][0]["code"], "file");
    desk.run("check").expect(2, "SCENE");
}
