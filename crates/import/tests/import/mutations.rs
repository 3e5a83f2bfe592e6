//! No scene, however mangled, brings the importer down: known texts are changed at random, from a fixed seed, for a fixed
//! number of rounds. The fuzz target of `tools/fuzz` goes on where this stops.

use std::fs;
use std::path::Path;

use bevy_ecs::world::World;
use brewster_import::{Importer, Limits, LoadOptions};

use crate::random::Random;

const ROUNDS: u64 = 3_000;

/// What a careless or hostile hand may put anywhere.
const PIECES: &[&str] = &[
    "(",
    ")",
    "[",
    "]",
    "{",
    "}",
    ",",
    ":",
    "\"",
    "'",
    "-",
    "NaN",
    "inf",
    "1e999",
    "-1",
    "0",
    "1e-40",
    "1e38",
    "4294967295",
    "\u{feff}",
    "é",
    "/*",
    "*/",
    "//",
    "\\",
    "r#\"",
    "#",
    "Sphere",
    "Plane()",
    "Emissive()",
    "\"red\"",
    "include: \"a.ron\"",
    "parent: \"lamp\"",
    "instances: Grid(count: (9, 9, 9))",
    "children: []",
    "scale: 0",
    "entities",
    "name",
    "(1, 2, 3)",
    "9223372036854775807",
    "_",
];

fn mutate(text: &str, random: &mut Random) -> String {
    let mut characters: Vec<char> = text.chars().collect();
    for _ in 0..=random.below(4) {
        let at = random.below(characters.len() + 1);
        let end = (at + random.below(12)).min(characters.len());
        match random.below(4) {
            0 => drop(characters.drain(at..end)),
            1 => {
                let copy = characters[at..end].to_vec();
                let to = random.below(characters.len() + 1);
                characters.splice(to..to, copy);
            }
            2 => {
                characters.splice(at..end, PIECES[random.below(PIECES.len())].chars());
            }
            _ => {
                characters.splice(at..at, PIECES[random.below(PIECES.len())].chars());
            }
        }
    }
    characters.into_iter().collect()
}

#[test]
fn no_mutated_scene_panics() {
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/broken");
    let mut seeds: Vec<String> = fs::read_dir(&corpus)
        .expect("the corpus is there")
        .map(|entry| entry.expect("it can be read").path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "ron"))
        .filter_map(|path| fs::read_to_string(path).ok())
        .collect();
    seeds.sort();
    let limits = Limits { entities: 10_000, ..Limits::DEFAULT };
    let mut random = Random::new(20_261_122);
    for round in 0..ROUNDS {
        let text = mutate(&seeds[random.below(seeds.len())], &mut random);
        let mut importer = Importer::new(LoadOptions { limits, ..LoadOptions::default() });
        let loaded = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
            match importer.load_text(&corpus.join("mutated.ron"), &text) {
                Ok(loaded) => {
                    loaded.scene.apply(&mut World::new());
                }
                Err(failure) => {
                    assert!(!failure.diagnostics.is_empty());
                    let _ = failure.to_string();
                }
            }
        }));
        assert!(loaded.is_ok(), "round {round} brings the importer down:\n{text}");
    }
}
