//! What a golden shows: camera, surroundings, size.

use std::path::Path;

use glam::Vec3;
use serde_json::Value;

/// A scenario.
pub(crate) struct Scenario {
    pub(crate) model: String,
    pub(crate) environment: String,
    pub(crate) target: Vec3,
    /// As [`ViewChoices::orbit`](brewster::import::ViewChoices::orbit).
    pub(crate) orbit: [f32; 3],
    /// In radians.
    pub(crate) vfov: f32,
    pub(crate) shows_environment: bool,
    /// Of the goldens.
    pub(crate) size: [u32; 2],
    /// The renderers.
    pub(crate) goldens: Vec<String>,
    /// Pairs of renderers and the mean difference of their pictures.
    spread: Vec<(String, f64)>,
}

impl Scenario {
    /// Reads a scenario's file.
    pub(crate) fn read(path: &Path) -> Result<Scenario, String> {
        let text = std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
        let json: Value = serde_json::from_str(&text).map_err(|error| error.to_string())?;
        let number = |pointer: &str| {
            let value = json.pointer(pointer).and_then(Value::as_f64);
            value.map(|value| value as f32).ok_or_else(|| format!("the scenario has no {pointer}"))
        };
        let text = |key: &str| {
            json.get(key).and_then(Value::as_str).map(str::to_owned).ok_or_else(|| format!("the scenario has no {key}"))
        };
        let goldens = json.get("goldens").and_then(Value::as_array);
        let spread = json.get("spreadMeanAbs").and_then(Value::as_object);
        Ok(Scenario {
            model: text("model")?,
            environment: text("environment")?,
            target: Vec3::new(number("/target/x")?, number("/target/y")?, number("/target/z")?),
            orbit: [number("/orbit/theta")?.to_radians(), number("/orbit/phi")?.to_radians(), number("/orbit/radius")?],
            vfov: number("/verticalFoV")?.to_radians(),
            shows_environment: json.get("renderSkybox").and_then(Value::as_bool).unwrap_or(false),
            size: [number("/goldenSize/width")? as u32, number("/goldenSize/height")? as u32],
            goldens: goldens.into_iter().flatten().filter_map(Value::as_str).map(str::to_owned).collect(),
            spread: spread
                .into_iter()
                .flatten()
                .filter_map(|(pair, mean)| Some((pair.clone(), mean.as_f64()?)))
                .collect(),
        })
    }

    /// How far a picture may be off: as far as two of the trusted ones are off each other, within bounds.
    pub(crate) fn tolerance(&self, trusted: &[&str]) -> f64 {
        let is_trusted = |pair: &str| pair.split(" / ").all(|renderer| trusted.contains(&renderer));
        let largest =
            self.spread.iter().filter(|(pair, _)| is_trusted(pair)).map(|&(_, mean)| mean).fold(0.0, f64::max);
        if trusted.len() < 2 { 0.02 } else { largest.clamp(0.012, 0.03) }
    }
}
