//! Cameras.
//!
//! A camera may have been made for a picture of other proportions than the one that is taken. What it was made to show is shown
//! whole: a picture that is narrower than the camera's shows more above and below, a wider one more to the sides. Near and far
//! planes cut nothing: they serve depth buffers.

use brewster_lanes::math;
use brewster_world::components::{Camera, Projection};
use gltf::json::camera::Type;
use gltf::json::{self};

use super::{Found, broken};

/// A camera for pictures whose width is `aspect` times their height.
pub(super) fn camera(camera: &json::Camera, aspect: f32, path: &str) -> Found<Camera> {
    let is_size = |value: f32| value.is_finite() && value != 0.0;
    let projection = match (camera.type_.unwrap(), &camera.perspective, &camera.orthographic) {
        (Type::Perspective, Some(lens), _) => {
            let vfov = lens.yfov;
            if !(vfov > 0.0 && vfov < std::f32::consts::PI) {
                let problem =
                    broken(format!("{path}.perspective.yfov"), format!("the angle of view is {vfov} radians"));
                return Err(problem.expected("an angle between 0 and π").into());
            }
            let wanted = lens.aspect_ratio.filter(|&ratio| ratio > 0.0 && ratio.is_finite()).unwrap_or(0.0);
            match wanted > aspect {
                true => Projection::Perspective { vfov: 2.0 * math::atan2(math::tan(0.5 * vfov) * wanted, aspect) },
                false => Projection::Perspective { vfov },
            }
        }
        (Type::Orthographic, _, Some(lens)) => {
            if !(is_size(lens.xmag) && is_size(lens.ymag)) {
                let problem = broken(format!("{path}.orthographic"), "the camera's view has no size");
                return Err(problem.expected("`xmag` and `ymag` other than 0").into());
            }
            Projection::Orthographic { height: 2.0 * lens.ymag.abs().max(lens.xmag.abs() / aspect) }
        }
        (Type::Perspective, None, _) => return Err(broken(path, "`perspective` is absent").into()),
        (Type::Orthographic, _, None) => return Err(broken(path, "`orthographic` is absent").into()),
    };
    Ok(Camera { projection, lens: None })
}
