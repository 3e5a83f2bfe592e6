//! Models that are stored in two ways: their pictures must be alike.

use std::path::Path;

use brewster::film::flip;

use crate::scenario::Scenario;
use crate::{Manner, PIXELS_PER_DEGREE, aces, mean_difference, over_gray, render, srgb_encode};

/// A scenario, the same model stored in another way, and how that is.
const PAIRS: &[(&str, &str, &str)] = &[
    ("Box", "models/Box/glTF-Draco/Box.gltf", "Draco"),
    ("Duck", "models/Duck/glTF-Draco/Duck.gltf", "Draco"),
    ("Duck", "models/Duck/glTF-Quantized/Duck.gltf", "quantized"),
    ("Fox", "models/FoxMeshopt/Fox-meshopt-cc.glb", "meshopt, quantized"),
    ("ToyCar", "models/ToyCarWebp/ToyCar-webp.glb", "WebP with losses"),
    ("AnisotropyBarnLamp", "models/AnisotropyBarnLamp/glTF/AnisotropyBarnLamp.gltf", "PNG instead of KTX2"),
];

/// Prints how far the pictures of each pair are apart, and beside that two pictures of one file with different samples.
pub(crate) fn compare(folder: &Path, manner: Manner) -> Result<(), String> {
    println!("| model | stored as | mean difference | FLIP | with other samples |");
    println!("| --- | --- | --- | --- | --- |");
    for &(name, twin, how) in PAIRS {
        let path = folder.join("goldens").join(name).join("scenario.json");
        if !path.is_file() || !folder.join(twin).is_file() {
            println!("| {name} | {how} | not in this folder | | |");
            continue;
        }
        let mut scenario = Scenario::read(&path)?;
        let shown = |scenario: &Scenario, seed: u64| {
            let light = render(folder, scenario, Manner { seed, ..manner })?;
            Ok::<_, String>(over_gray(&light, |color| aces(color).map(srgb_encode)).halved())
        };
        let (plain, other_samples) = (shown(&scenario, 0)?, shown(&scenario, 1)?);
        scenario.model = twin.to_owned();
        let stored_otherwise = shown(&scenario, 0)?;
        let apart = mean_difference(&plain, &stored_otherwise);
        let noise = mean_difference(&plain, &other_samples);
        let flip = flip(&plain.decoded(), &stored_otherwise.decoded(), PIXELS_PER_DEGREE);
        let flip = flip.map_err(|error| error.to_string())?.mean;
        println!("| {name} | {how} | {apart:.4} | {flip:.4} | {noise:.4} |");
    }
    Ok(())
}
