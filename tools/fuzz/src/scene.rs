//! Any text as a scene: it is read, or there are errors that can be printed.

#![no_main]

use bevy_ecs::world::World;
use brewster_import::{Importer, Limits, LoadOptions};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    // A folder that does not exist: no scene reads a file. Few entities, so that a run is short.
    let limits = Limits { entities: 10_000, ..Limits::DEFAULT };
    let mut importer = Importer::new(LoadOptions { limits, ..LoadOptions::default() });
    match importer.load_text("/nowhere/scene.ron".as_ref(), text) {
        Ok(loaded) => {
            let mut world = World::new();
            loaded.scene.apply(&mut world);
            let again = loaded.scene.apply(&mut world);
            assert_eq!(again.spawned + again.changed + again.despawned, 0);
        }
        Err(failure) => {
            assert!(!failure.diagnostics.is_empty());
            assert!(!failure.to_string().is_empty());
        }
    }
});
