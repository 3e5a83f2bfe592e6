//! How a pixel's light came about, as text, JSON, a drawing and a page.

use std::collections::BTreeSet;

use serde_json::Value;

use super::desk::{Desk, SCENE};

/// The samples' rays.
fn rays(explanation: &Value) -> Vec<&Value> {
    let samples = explanation["samples"].as_array().expect("samples");
    samples.iter().flat_map(|sample| sample["rays"].as_array().expect("rays")).collect()
}

#[test]
fn the_parts_add_up_to_the_pixel() {
    let desk = Desk::with_scene();
    desk.run("explain scene.ron --pixel 34,18 -o a.json").expect(0, "");
    let explanation = desk.json("a.json");
    let unit = |value: &Value, channel: usize| value[channel].as_i64().expect("an integer");
    for channel in 0..3 {
        let lights: i64 = rays(&explanation)
            .iter()
            .flat_map(|ray| ray["lights"].as_array().expect("lights"))
            .map(|light| unit(&light["units"], channel))
            .sum();
        assert_eq!(lights, unit(&explanation["units"], channel));
    }
    let names: BTreeSet<&str> = rays(&explanation).iter().filter_map(|ray| ray["surface"]["entity"].as_str()).collect();
    assert!(names.contains("pane"), "{names:?}");
    let glass = rays(&explanation).into_iter().find(|ray| ray["surface"]["entity"] == "pane").expect("the pane");
    // From vacuum into glass.
    assert_eq!(glass["surface"]["media"][0]["name"], "vacuum");
    assert_eq!(glass["surface"]["media"][1], serde_json::json!({"name": "glass", "ior": 1.5}));
}

#[test]
fn what_has_no_name_is_known_by_its_place() {
    let desk = Desk::new();
    desk.write("scene.ron", &SCENE.replace("name: \"pane\", ", ""));
    desk.run("explain scene.ron --pixel 34,18 -o a.json").expect(0, "");
    let explanation = desk.json("a.json");
    let rays = rays(&explanation);
    assert!(rays.iter().any(|ray| ray["surface"]["entity"] == "entity at scene.ron:14:9"), "{explanation}");
}

#[test]
fn every_field_is_in_the_manual() {
    let manual = include_str!("../../README.md");
    let desk = Desk::with_scene();
    desk.run("explain scene.ron --pixel 34,18 -o a.json").expect(0, "");
    let explanation = desk.json("a.json");
    let mut names = BTreeSet::new();
    collect(&explanation, &mut names);
    assert!(names.contains("r_s"), "{names:?}");
    let missing: Vec<&String> = names.iter().filter(|name| !manual.contains(&format!("`{name}`"))).collect();
    assert!(missing.is_empty(), "README.md does not name {missing:?}");
    assert_eq!(explanation["version"], brewster::explain::EXPLANATION_VERSION);
}

fn collect(value: &Value, names: &mut BTreeSet<String>) {
    match value {
        Value::Object(fields) => fields.iter().for_each(|(name, value)| {
            names.insert(name.clone());
            collect(value, names);
        }),
        Value::Array(items) => items.iter().for_each(|item| collect(item, names)),
        _ => {}
    }
}

#[test]
fn text_stays_narrow_and_files_stand_alone() {
    let desk = Desk::with_scene();
    let text = desk.run("explain scene.ron --pixel 34,18 --max-depth 6").expect(0, "").out;
    for part in ["pixel 34,18 of 48 x 32, Whitted", "camera ray", "├─ reflection", "pane of glass", "F_r 0.0"] {
        assert!(text.contains(part), "{part} is not in\n{text}");
    }
    let widest = text.lines().map(|line| line.chars().count()).max().expect("lines");
    assert!(widest < 120, "a line of {widest} columns");
    desk.run("explain scene.ron --pixel 10,12 --sample 2 --camera top -o a.txt -o a.svg -o a.html").expect(0, "");
    assert_eq!(desk.files(), ["a.html", "a.svg", "a.txt", "scene.ron"]);
    let page = String::from_utf8(desk.read("a.html")).expect("text");
    assert!(page.contains("sample 2") && !page.contains("sample 1:"), "{page}");
    let svg = String::from_utf8(desk.read("a.svg")).expect("text");
    for (name, text) in [("a.html", page), ("a.svg", svg)] {
        let outside: Vec<_> = text.match_indices("http").map(|(at, _)| &text[at..at + 26]).collect();
        assert!(outside.iter().all(|&link| link == "http://www.w3.org/2000/svg"), "{name}: {outside:?}");
        assert!(text.contains("prefers-color-scheme: dark"), "{name}");
    }
}

#[test]
fn what_cannot_be_explained_is_said() {
    let desk = Desk::with_scene();
    desk.run("explain scene.ron --pixel 48,0").expect(1, "the picture is 48 x 32: columns are 0 to 47, rows 0 to 31");
    desk.run("explain scene.ron --pixel 0,0 --sample 4").expect(1, "a pixel has 4 samples, numbered from 0 to 3");
    desk.run("explain scene.ron --pixel 0,0 --camera side").expect(1, "no camera \"side\"");
    desk.run("explain scene.ron --pixel 3").expect(2, "expected a column and a row");
    desk.run("explain scene.ron --pixel 0,0 -o a.png").expect(2, "expected a name that ends in .json");
    desk.run("explain nowhere.ron --pixel 0,0").expect(1, "nowhere.ron");
}
