//! `KHR_lights_punctual`: points, directions and cones of light. Its candela and lux are taken for linear RGB intensity and
//! irradiance, without a factor 683.

use brewster_world::components::{Falloff, Light};
use glam::Vec3;
use gltf::json::{Node, Root};
use serde::Deserialize;

use super::super::{Found, broken};

#[derive(Deserialize)]
struct Punctual {
    #[serde(default = "white")]
    color: [f32; 3],
    #[serde(default = "one")]
    intensity: f32,
    range: Option<f32>,
    spot: Option<Spot>,
    #[serde(rename = "type")]
    kind: Kind,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
enum Kind {
    Directional,
    Point,
    Spot,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Spot {
    #[serde(default)]
    inner_cone_angle: f32,
    #[serde(default = "quarter")]
    outer_cone_angle: f32,
}

fn white() -> [f32; 3] {
    [1.0; 3]
}

fn one() -> f32 {
    1.0
}

fn quarter() -> f32 {
    std::f32::consts::FRAC_PI_4
}

/// The light at a node, if there is one.
pub(in crate::gltf) fn of_node(root: &Root, node: &Node, path: &str) -> Found<Option<Light>> {
    let found: Option<(Punctual, String)> = super::light(root, super::others!(node), "KHR_lights_punctual", path)?;
    let Some((found, path)) = found else { return Ok(None) };
    let strength = Vec3::from_array(found.color) * found.intensity;
    if !(strength.is_finite() && strength.min_element() >= 0.0) {
        return Err(broken(path, "the light's color and intensity are not finite and 0 or more").into());
    }
    let falloff = match found.range {
        None => Falloff::InverseSquare,
        Some(range) if range > 0.0 && range.is_finite() => Falloff::Within(range),
        Some(range) => {
            let problem = broken(format!("{path}.range"), format!("the range of the light is {range}"));
            return Err(problem.expected("a number above 0").into());
        }
    };
    Ok(Some(match (&found.kind, &found.spot) {
        (Kind::Directional, _) => Light::Directional { irradiance: strength },
        (Kind::Point, _) => Light::Point { intensity: strength, falloff },
        (Kind::Spot, spot) => {
            let (inner, outer) =
                spot.as_ref().map_or((0.0, quarter()), |spot| (spot.inner_cone_angle, spot.outer_cone_angle));
            let most = std::f32::consts::FRAC_PI_2;
            if !(0.0 <= inner && inner <= outer && outer > 0.0 && outer <= most + 1e-6) {
                let problem = broken(format!("{path}.spot"), format!("the cone goes from {inner} to {outer} radians"));
                return Err(problem.expected("0 <= innerConeAngle < outerConeAngle <= π/2").into());
            }
            Light::Spot { intensity: strength, inner_angle: inner, outer_angle: outer.min(most), falloff }
        }
    }))
}
