//! No scene, however mangled, brings the importer down: known texts are changed at random, from a fixed seed, for a fixed
//! number of rounds. The fuzz target of `tools/fuzz` goes on where this stops.

use std::fs;
use std::path::Path;

use bevy_ecs::world::World;
use brewster_import::{Importer, Limits, LoadOptions};

use brewster_random::Random;

const ROUNDS: u64 = 3_000;

/// Of glTF files, unless `ROUNDS` says otherwise in the environment: a longer run is as simple as that.
const FILES: u64 = 1_500;

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

/// Words and numbers of glTF in places where they do not belong.
const WORDS: &[&str] = &[
    "-1",
    "0",
    "1",
    "2",
    "3",
    "7",
    "5120",
    "5121",
    "5123",
    "5125",
    "5126",
    "1e38",
    "-1e38",
    "1e-40",
    "1e999",
    "4294967295",
    "18446744073709551615",
    "4000000000",
    "null",
    "true",
    "\"\"",
    "\"VEC3\"",
    "\"SCALAR\"",
    "\"MAT4\"",
    "\"BLEND\"",
    "\"MASK\"",
    "[]",
    "{}",
    "[0]",
    "[0,0,0,0]",
    "\"POSITION\"",
    "\"TEXCOORD_1\"",
    "\"JOINTS_0\"",
    "\"WEIGHTS_0\"",
    "\"mesh\"",
    "\"sparse\"",
    "\"byteStride\"",
    "\"normalized\"",
    "\"mode\"",
    "\"CUBICSPLINE\"",
    "\"STEP\"",
    "\"weights\"",
    ",",
    ":",
    "\"",
    "\"/materials/0\"",
];

/// Bytes with some of them changed, taken out, repeated, or with a value in the place of another.
fn mangle(bytes: &[u8], random: &mut Random) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for _ in 0..=random.below(3) {
        let at = random.below(bytes.len());
        let end = (at + random.below(16)).min(bytes.len());
        match random.below(8) {
            0 => drop(bytes.drain(at..end)),
            1 => {
                let copy = bytes[at..end].to_vec();
                bytes.splice(at..at, copy);
            }
            2 if !bytes.is_empty() => bytes[at] ^= 1 << random.below(8),
            3 if !bytes.is_empty() => bytes[at] = random.below(256) as u8,
            // The next value: from a colon to what ends it.
            _ => {
                let from = (at..bytes.len()).find(|&i| matches!(bytes[i], b':' | b'[' | b',')).unwrap_or(bytes.len());
                let from = (from + 1).min(bytes.len());
                let ends = |i: &usize| matches!(bytes[*i], b',' | b'}' | b']' | b':');
                let to = (from..bytes.len()).find(ends).unwrap_or(bytes.len());
                bytes.splice(from..to, WORDS[random.below(WORDS.len())].bytes());
            }
        }
    }
    bytes
}

#[test]
fn no_mangled_gltf_file_panics() {
    let seeds = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tools/fuzz/seeds/gltf");
    let mut files: Vec<_> =
        fs::read_dir(seeds).expect("the seeds are there").map(|entry| entry.expect("an entry").path()).collect();
    files.sort();
    let seeds: Vec<Vec<u8>> = files.iter().map(|path| fs::read(path).expect("a file")).collect();
    let limits =
        Limits { entities: 10_000, image_pixels: 1 << 16, vertices: 10_000, triangles: 10_000, ..Limits::DEFAULT };
    let rounds = std::env::var("ROUNDS").ok().and_then(|rounds| rounds.parse().ok()).unwrap_or(FILES);
    let mut random = Random::new(20_261_123);
    for round in 0..rounds {
        let bytes = mangle(&seeds[random.below(seeds.len())], &mut random);
        let mut options = LoadOptions { limits, ..LoadOptions::default() };
        options.gltf.time = (round % 2 == 1).then_some(0.7);
        let mut importer = Importer::new(options);
        let loaded = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
            match importer.load_gltf("/nowhere/model.gltf".as_ref(), &bytes) {
                Ok(loaded) => {
                    loaded.scene.apply(&mut World::new());
                    assert!(!loaded.scene.export("parts").text.is_empty());
                }
                Err(failure) => assert!(!failure.to_string().is_empty()),
            }
        }));
        assert!(loaded.is_ok(), "round {round} brings the importer down:\n{}", String::from_utf8_lossy(&bytes));
    }
}
