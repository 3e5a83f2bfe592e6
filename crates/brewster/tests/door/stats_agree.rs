//! Counts do not depend on threads or batches, and every field is documented.

use std::collections::BTreeSet;

use brewster::wavefront::Stage;
use serde_json::Value;

use super::desk::Desk;

/// What `--stats` says of a render of the scene.
fn stats(desk: &Desk, arguments: &str) -> Value {
    desk.run(&format!("render scene.ron --quiet --stats stats.json {arguments}")).expect(0, "");
    desk.json("stats.json")
}

fn without_times(mut stats: Value) -> Value {
    stats.as_object_mut().expect("an object").remove("times").expect("times");
    stats
}

#[test]
fn threads_and_batches_change_times_alone() {
    let desk = Desk::with_scene();
    let (expected, picture) = (without_times(stats(&desk, "--threads 1 -o a.exr")), desk.read("a.exr"));
    for arguments in ["--threads 2", "--threads 7", "--threads 2 --batch 1", "--threads 3 --batch 100000"] {
        let found = without_times(stats(&desk, &format!("{arguments} -o a.exr")));
        assert_eq!(found, expected, "{arguments}");
        assert!(desk.read("a.exr") == picture, "{arguments}: another picture");
    }
}

#[test]
fn counts_add_up() {
    let desk = Desk::with_scene();
    let stats = stats(&desk, "");
    let number = |value: &Value| value.as_u64().expect("a count");
    let totals = &stats["totals"];
    // 48 x 32 pixels with 4 samples each.
    assert_eq!(number(&totals["primary"]), 48 * 32 * 4);
    let sum: u64 = ["primary", "reflection", "transmission", "shadow"].map(|queue| number(&totals[queue])).iter().sum();
    assert_eq!(number(&totals["rays"]), sum);
    for queue in ["primary", "reflection", "transmission"] {
        let depths = stats["depths"].as_array().expect("a list");
        let traced: u64 = depths.iter().map(|depth| number(&depth["queues"][queue]["traced"])).sum();
        assert_eq!(traced, number(&totals[queue]), "{queue}");
        for depth in depths {
            let row = &depth["queues"][queue];
            let ends: u64 = ["hits", "escaped", "crossings"].map(|end| number(&row[end])).iter().sum();
            assert_eq!(number(&row["traced"]), ends, "{queue} at depth {}", depth["depth"]);
        }
    }
    assert_eq!(stats["samples"], serde_json::json!({"asked": 4, "least": 4, "most": 4, "total": 48 * 32 * 4}));
    assert_eq!(stats["film"], serde_json::json!({"rejected": 0, "saturated": 0, "clamped": [0.0, 0.0, 0.0]}));
}

/// A scene for the path integrator: a lamp and a gold ball in an even sky.
const PATH: &str = r#"Scene(
    settings: (integrator: Path, resolution: (24, 16), samples: 4, max_depth: 4),
    camera: Perspective(eye: (0, 1.5, 6), target: (0, 1, 0), vfov: 36),
    background: (0.2, 0.4, 0.9),
    entities: [
        (shape: Plane(normal: (0, 1, 0)), material: Lambert(albedo: 0.5)),
        (shape: Sphere(radius: 1), material: Metal(of: "gold", roughness: 0.4), at: (0, 1, 0)),
        (shape: Sphere(radius: 0.3), material: Emissive(radiance: 10), at: (2, 3, 1)),
    ],
)
"#;

/// Photons are told where they are asked for and find a mirror: never more than were sent.
#[test]
fn photons_are_told() {
    let desk = Desk::new();
    desk.write("scene.ron", &PATH.replace("roughness: 0.4", "roughness: 0"));
    assert_eq!(stats(&desk, "")["guide"], Value::Null);
    let guide = &stats(&desk, "--guiding true")["guide"];
    let number = |name: &str| guide[name].as_u64().expect("a count");
    let [photons, kept, rays] = ["photons", "kept", "rays"].map(number);
    assert!(photons == 4096 && 0 < kept && kept < photons && photons < rays && number("bytes") > 12 * kept, "{guide}");
    desk.write("scene.ron", PATH);
    assert_eq!(stats(&desk, "--guiding true")["guide"], Value::Null);
}

#[test]
fn energy_adds_up() {
    let desk = Desk::new();
    desk.write("scene.ron", PATH);
    let stats = stats(&desk, "");
    let entry = |energy: &Value, name: &str| energy["entries"][name][0].as_f64().expect("an energy");
    let first = &stats["depths"][0]["energy"];
    assert_eq!(entry(first, "entered"), f64::from(24 * 16 * 4));
    let total = &stats["totals"]["energy"];
    let ends = ["escaped", "emitters", "volume", "cut", "absorbed", "residual", "below_surface", "roulette_removed"];
    let sum: f64 = ends.map(|end| entry(total, end)).iter().sum::<f64>();
    let sum = sum - entry(total, "roulette_added") - entry(total, "recolored");
    assert!((sum - f64::from(24 * 16 * 4)).abs() < 1e-3, "{sum}");
    for name in total["entries"].as_object().expect("a map").keys() {
        assert!(include_str!("../../README.md").contains(&format!("`{name}`")), "README.md does not name {name}");
    }
    let said = desk.run("render scene.ron").expect(0, "energy").err;
    assert!(said.contains("escaped") && said.contains("in surfaces"), "{said}");
}

#[test]
fn every_field_is_in_the_manual() {
    let manual = include_str!("../../README.md");
    let desk = Desk::with_scene();
    let mut names = BTreeSet::new();
    collect_names(&stats(&desk, ""), &mut names);
    let is_stage = |name: &str| Stage::ALL.into_iter().any(|stage| stage.name() == name);
    let named = |name: &str| manual.contains(&format!("`{name}`")) || is_stage(name);
    let missing: Vec<_> = names.into_iter().filter(|name| !named(name)).collect();
    assert!(missing.is_empty(), "README.md does not name {missing:?}");
    assert!(manual.contains(&format!("version is {}", brewster::STATS_VERSION)));
}

/// The names of all fields; those of stages, queues, tables and systems stand for themselves.
fn collect_names(value: &Value, names: &mut BTreeSet<String>) {
    match value {
        Value::Object(fields) => {
            for (name, value) in fields {
                names.insert(name.clone());
                if !["stages", "queues", "rows", "systems"].contains(&name.as_str()) {
                    collect_names(value, names);
                } else if let Some(first) = value.as_object().and_then(|fields| fields.values().next()) {
                    collect_names(first, names);
                }
            }
        }
        Value::Array(items) => items.iter().take(1).for_each(|item| collect_names(item, names)),
        _ => {}
    }
}

#[test]
fn a_trace_shows_every_ray() {
    let desk = Desk::with_scene();
    desk.run("render scene.ron --quiet --threads 2 --trace trace.json").expect(0, "");
    let trace = desk.json("trace.json");
    let events = trace["traceEvents"].as_array().expect("a list");
    let named =
        |name: &str| events.iter().filter(|event| event["name"] == name && event["ph"] == "X").collect::<Vec<_>>();
    for name in ["load", "flatten", "prepare", "encode"] {
        assert_eq!(named(name).len(), 1, "{name}");
    }
    let generated: u64 = named("generate").iter().map(|event| event["args"]["rays"].as_u64().expect("a count")).sum();
    assert_eq!(generated, 48 * 32 * 4);
    let spans = events.iter().filter(|event| event["ph"] == "X");
    for event in spans {
        assert!(event["ts"].as_f64().is_some_and(|time| time >= 0.0), "{event}");
        assert!(event["dur"].as_f64().is_some_and(|time| time >= 0.0), "{event}");
    }
}
