//! Any bytes as a glTF file: JSON, or the binary form if they begin so. It stands in a folder without other files.

#![no_main]

use bevy_ecs::world::World;
use brewster_import::{Importer, Limits, LoadOptions};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let limits = Limits {
        entities: 10_000,
        image_pixels: 1 << 16,
        vertices: 10_000,
        triangles: 10_000,
        ..Limits::DEFAULT
    };
    let mut options = LoadOptions { limits, ..LoadOptions::default() };
    // Half of all files at a moment of their animation.
    options.gltf.time = bytes.last().filter(|&&last| last % 2 == 1).map(|&last| f32::from(last) / 64.0);
    match Importer::new(options).load_gltf("/nowhere/model.gltf".as_ref(), bytes) {
        Ok(loaded) => {
            let mut world = World::new();
            loaded.scene.apply(&mut world);
            let again = loaded.scene.apply(&mut world);
            assert_eq!(again.spawned + again.changed + again.despawned, 0);
            assert!(!loaded.scene.export("parts").text.is_empty());
        }
        Err(failure) => assert!(!failure.to_string().is_empty()),
    }
});
