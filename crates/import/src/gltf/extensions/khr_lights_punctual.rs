//! `KHR_lights_punctual`: points, directions and cones of light. Its candela and lux are taken for linear RGB intensity and
//! irradiance, without a factor 683.

use brewster_world::components::{Falloff, Light};
use glam::Vec3;
use gltf::json::{Node, Root};
use serde::Deserialize;

use super::super::{Found, broken};

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
enum Kind {
    Directional,
    Point,
    Spot,
}

/// The light at a node, if there is one.
pub(in crate::gltf) fn of_node(root: &Root, node: &Node, path: &str) -> Found<Option<Light>> {
    let Some(found) = super::light(root, super::others!(node), "KHR_lights_punctual", path)? else { return Ok(None) };
    let path = found.path();
    let color: [f32; 3] = found.get("color", [1.0; 3])?;
    let strength = Vec3::from_array(color) * found.get("intensity", 1.0)?;
    if !(strength.is_finite() && strength.min_element() >= 0.0) {
        return Err(broken(path, "the light's color and intensity are not finite and 0 or more").into());
    }
    let falloff = match found.get::<Option<f32>>("range", None)? {
        None => Falloff::InverseSquare,
        Some(range) if range > 0.0 && range.is_finite() => Falloff::Within(range),
        Some(range) => {
            let problem = broken(found.path_of("range"), format!("the range of the light is {range}"));
            return Err(problem.expected("a number above 0").into());
        }
    };
    Ok(Some(match found.need("type")? {
        Kind::Directional => Light::Directional { irradiance: strength },
        Kind::Point => Light::Point { intensity: strength, falloff },
        Kind::Spot => {
            let spot = found.within("spot");
            let inner = spot.get("innerConeAngle", 0.0)?;
            let outer = spot.get("outerConeAngle", std::f32::consts::FRAC_PI_4)?;
            let most = std::f32::consts::FRAC_PI_2;
            if !(0.0 <= inner && inner <= outer && outer > 0.0 && outer <= most + 1e-6) {
                let problem = broken(spot.path(), format!("the cone goes from {inner} to {outer} radians"));
                return Err(problem.expected("0 <= innerConeAngle < outerConeAngle <= π/2").into());
            }
            Light::Spot { intensity: strength, inner_angle: inner, outer_angle: outer.min(most), falloff }
        }
    }))
}
