//! After any series of edits the picture is that of a scene that was never anything else, bit for bit.

use std::path::Path;

use brewster::film::Film;
use brewster::{RenderOptions, Session};
use brewster_random::Random;
use brewster_wavefront::Control;

/// A multiple of 1/8 from -2 to 2.
fn coordinate(random: &mut Random) -> f64 {
    random.below(33) as f64 / 8.0 - 2.0
}

fn one<'a>(random: &mut Random, choices: &[&'a str]) -> &'a str {
    choices[random.below(choices.len())]
}

const SHAPES: [&str; 8] = [
    "Sphere(radius: 0.6)",
    "Sphere(radius: 0.3)",
    "Box(size: (0.8, 0.5, 1))",
    "Torus(major_radius: 0.6, minor_radius: 0.2)",
    "Cylinder(radius: 0.3, height: 1.2)",
    "Cone(radius: 0.5, height: 1)",
    "Quad(size: (1, 1.5))",
    "Mesh(file: \"ball.obj\")",
];

const MATERIALS: [&str; 9] = [
    "Phong(diffuse: (0.7, 0.3, 0.2), specular: 0.4, exponent: 20)",
    "Lambert(albedo: Checker(a: 0.2, b: 0.8, size: 0.25))",
    "Lambert(albedo: Image(file: \"colors.png\"))",
    "Metal(of: \"Au\", exponent: 50)",
    "Metal(r0: (0.5, 0.7, 0.9))",
    "Dielectric(ior: 1.5, absorption: (0.4, 0.1, 0.2))",
    "Emissive(radiance: (1, 0.7, 0.3))",
    "Mix(a: Lambert(), b: Metal(of: \"Cu\"), by: Map(texture: Image(file: \"colors.png\")))",
    "Detailed(of: Lambert(), opacity: Blend(alpha: 0.5), normal: Image(file: \"colors.png\"))",
];

/// A scene as text, in parts that are edited one by one.
struct Draft {
    settings: String,
    camera: String,
    background: String,
    materials: Vec<&'static str>,
    entities: Vec<String>,
    /// Entities so far, for names.
    named: usize,
}

impl Draft {
    fn new(random: &mut Random) -> Draft {
        let mut draft = Draft {
            settings: "max_depth: 3".into(),
            camera: "(0, 1, 7)".into(),
            background: "0.5".into(),
            materials: vec![MATERIALS[0], MATERIALS[3], MATERIALS[5], MATERIALS[1]],
            entities: vec!["(name: \"floor\", shape: Plane(point: (0, -2, 0)), material: \"m0\")".into()],
            named: 0,
        };
        (0..6).for_each(|_| draft.add(random));
        draft
    }

    fn add(&mut self, random: &mut Random) {
        self.named += 1;
        let entity = self.entity(self.named, random);
        self.entities.insert(random.below(self.entities.len() + 1), entity);
    }

    fn entity(&self, name: usize, random: &mut Random) -> String {
        let at = format!("({}, {}, {})", coordinate(random), coordinate(random), coordinate(random));
        let what = match random.below(6) {
            0 => format!("light: Point(intensity: {})", 10 + random.below(20)),
            1 => format!("light: Spot(intensity: 30, outer_angle: {}), look_at: (0, 0, 0)", 20 + random.below(40)),
            _ => {
                let material = random.below(self.materials.len());
                let placed = one(random, &["", ", rotate: (x: 30, y: 50)", ", scale: (1, 0.5, 2)"]);
                let copies = one(random, &["", "", ", instances: Grid(count: (2, 1, 2), spacing: (1, 0, 1))"]);
                let body = format!("shape: {}, material: \"m{material}\"", one(random, &SHAPES));
                if copies.is_empty() { body + placed } else { format!("children: [({body})]{placed}{copies}") }
            }
        };
        format!("(name: \"e{name}\", {what}, at: {at})")
    }

    fn edit(&mut self, random: &mut Random) {
        let entity = 1 + random.below(self.entities.len() - 1);
        match random.below(9) {
            0 | 1 => self.add(random),
            2 if self.entities.len() > 4 => drop(self.entities.remove(entity)),
            3 => self.materials[random.below(4)] = MATERIALS[random.below(MATERIALS.len())],
            4 => {
                self.settings = format!("max_depth: {}, transparent_shadows: {}", random.below(5), random.below(2) == 1)
            }
            5 => self.camera = format!("({}, 1, 7)", coordinate(random)),
            6 => self.background = format!("Gradient(horizon: 0.8, zenith: (0.2, {}, 0.9))", random.below(3)),
            7 => self.entities.swap(entity, 0),
            _ => {
                self.named += 1;
                self.entities[entity] = self.entity(self.named, random);
            }
        }
    }

    fn text(&self) -> String {
        let materials = self.materials.iter().enumerate().map(|(i, material)| format!("\"m{i}\": {material}"));
        format!(
            "Scene(settings: (resolution: (32, 20), samples: 1, {}), camera: Perspective(eye: {}), background: {},
            materials: {{ {} }}, entities: [{}])",
            self.settings,
            self.camera,
            self.background,
            materials.collect::<Vec<_>>().join(", "),
            self.entities.join(",\n")
        )
    }
}

fn session() -> Session {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/edited.ron"));
    Session::new(path, Default::default())
}

fn picture(session: &mut Session, text: &str) -> Film {
    session.load_text(text).unwrap_or_else(|error| panic!("{text}\n{error}"));
    session.flatten().unwrap_or_else(|error| panic!("{text}\n{error}"));
    let mut render = session.render(RenderOptions::default()).expect("the scene has a camera");
    while render.remaining() > 0 {
        render.pass(&Control::default());
    }
    render.film().clone()
}

#[test]
fn pictures_of_an_edited_scene_are_those_of_a_new_one() {
    for seed in 0..3 {
        let mut random = Random::new(seed);
        let mut draft = Draft::new(&mut random);
        let mut edited = session();
        let mut before = picture(&mut edited, &draft.text());
        let mut changes = 0;
        for step in 0..20 {
            (0..=random.below(3)).for_each(|_| draft.edit(&mut random));
            let text = draft.text();
            let after = picture(&mut edited, &text);
            assert!(after == picture(&mut session(), &text), "seed {seed}, edit {step}: another picture of\n{text}");
            changes += usize::from(after != before);
            before = after;
        }
        assert!(changes > 12, "seed {seed}: only {changes} edits can be seen");
    }
}
