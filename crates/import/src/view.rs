//! Where a picture is taken from and what surrounds the scene, if not the scene's file tells but the one who asks.

use std::f32::consts::PI;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use brewster_lanes::math;
use brewster_world::components as world;
use brewster_world::components::parts::{Backdrop, Background, Image, Texels};
use glam::{Affine3A, Mat3, UVec2, Vec3, Vec3A};

use crate::diagnostics::{Code, Diagnostic, Severity};
use crate::environment::{self, View};
use crate::image;
use crate::keys::Keys;
use crate::scene::{Row, Scene, world_transforms};
use crate::session::{Session, describe};
use crate::source::Span;

/// What takes the place of a scene's cameras and surroundings. Angles are in radians.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ViewChoices {
    /// Where the camera is.
    pub eye: Option<Vec3>,
    /// A point in the middle of the picture; without it, the middle of the scene.
    pub target: Option<Vec3>,
    /// A direction that points up in the picture; without it, +Y.
    pub up: Option<Vec3>,
    /// The full vertical angle of view.
    pub vfov: Option<f32>,
    /// Where the camera is about its target: the angle from +Z toward +X, the angle from +Y, and the distance.
    pub orbit: Option<[f32; 3]>,
    /// What is all around.
    pub environment: Option<EnvironmentChoice>,
    /// What is behind the things in the picture.
    pub backdrop: Option<Backdrop>,
}

/// A picture of the whole sky.
#[derive(Clone, Debug, PartialEq)]
pub struct EnvironmentChoice {
    /// Its file; without one, the studio that stands around glTF files without lights.
    pub file: Option<PathBuf>,
    /// By how much it is turned about +Y.
    pub rotation: f32,
    /// A factor of its radiance.
    pub strength: f32,
}

/// The angle of view of a camera that nobody described.
const VFOV: f32 = 0.6;

/// The direction of that camera from the middle of the scene, as in [`ViewChoices::orbit`].
const DIRECTION: [f32; 2] = [0.5, 1.3];

/// The part of the picture that the scene may fill in that camera.
const FILL: f32 = 0.9;

/// About as many vertices of a mesh are looked at.
const LOOKED_AT: usize = 20_000;

/// Gives a scene the cameras and surroundings that are asked for. `None` after an error.
pub(crate) fn apply(session: &mut Session, scene: &mut Scene, view: &ViewChoices, span: Span) -> Option<()> {
    if let Some(choice) = &view.environment {
        let turned = View { rotation: choice.rotation, intensity: choice.strength, ..View::PLAIN };
        // What stood in the place of another sky goes with it.
        (scene.background.0, scene.settings.0.backdrop) = match &choice.file {
            Some(file) => (sky(session, file, turned)?, Backdrop::Background),
            None => (studio(session, turned)?, Backdrop::Other(PAPER)),
        };
    }
    if let Some(backdrop) = &view.backdrop {
        scene.settings.0.backdrop = backdrop.clone();
    }
    let asks = view.eye.is_some() || view.target.is_some() || view.up.is_some() || view.orbit.is_some();
    if asks || !scene.rows.iter().any(|row| row.camera.is_some()) {
        return place(session, scene, view, span);
    }
    if let Some(vfov) = view.vfov {
        for camera in scene.rows.iter_mut().filter_map(|row| row.camera.as_mut()) {
            if let world::Projection::Perspective { .. } = camera.projection {
                *camera = Arc::new(world::Camera { projection: world::Projection::Perspective { vfov }, ..**camera });
            }
        }
    }
    Some(())
}

/// Puts one camera in the place of all cameras.
fn place(session: &mut Session, scene: &mut Scene, view: &ViewChoices, span: Span) -> Option<()> {
    let size = session.resolution.unwrap_or(scene.settings.0.resolution);
    let corners = corners(&scene.rows);
    let (least, most) = corners
        .iter()
        .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(least, most), corner| (least.min(*corner), most.max(*corner)));
    let middle = if corners.is_empty() { Vec3::ZERO } else { 0.5 * least + 0.5 * most };
    let target = view.target.unwrap_or(middle);
    let up = view.up.unwrap_or(Vec3::Y);
    let vfov = view.vfov.unwrap_or(VFOV);
    let (eye, target) = match (view.eye, view.orbit) {
        (Some(eye), _) => (eye, target),
        // A camera that cannot go around its target looks out from it.
        (None, Some([theta, phi, 0.0])) => (target, target - about(theta, phi)),
        (None, Some([theta, phi, radius])) => (target + about(theta, phi) * radius, target),
        (None, None) => {
            let back = about(DIRECTION[0], DIRECTION[1]);
            (target + back * distance(&corners, target, back, up, vfov, size), target)
        }
    };
    // Who looks straight down or up and does not say what is up in the picture tilts a level camera until it does.
    let level = view.orbit.map_or(Vec3::Z, |[theta, ..]| about(theta, 0.5 * PI));
    let tilted = if eye.y > target.y { -level } else { level };
    let frame = frame(eye, target, up).or_else(|| view.up.is_none().then(|| frame(eye, target, tilted))?);
    let Some(frame) = frame else {
        let message = match (target - eye).try_normalize() {
            None => "the camera looks nowhere: it is where it looks at, or too far away",
            Some(_) => "the camera looks along its own up, or up is nowhere",
        };
        let place = format!("it is at {eye}, looks at {target}, and up is {up}");
        let error = Diagnostic::about_path(Severity::Error, Code::Conflict, "", message).in_file("the view");
        let help = "`--eye`, `--target`, `--up` and `--orbit` place it";
        session.found.push(error.help(help).note(place));
        return None;
    };
    scene.rows.iter_mut().for_each(|row| row.camera = None);
    let camera = world::Camera { projection: world::Projection::Perspective { vfov }, lens: None };
    let transform = Some(Affine3A::from_mat3_translation(frame, eye));
    scene.rows.push(Row { transform, camera: Some(Arc::new(camera)), ..Row::at(Keys::VIEW, span) });
    Some(())
}

/// A camera's axes, unless it looks nowhere or along its own up.
fn frame(eye: Vec3, target: Vec3, up: Vec3) -> Option<Mat3> {
    let forward = (target - eye).try_normalize()?;
    let right = forward.cross(up).try_normalize()?;
    (right.cross(forward).dot(up) > 1e-4 * up.length()).then(|| Mat3::from_cols(right, right.cross(forward), -forward))
}

/// The unit vector at angles from +Z toward +X and from +Y.
fn about(theta: f32, phi: f32) -> Vec3 {
    let ((sin_theta, cos_theta), (sin_phi, cos_phi)) = (math::sin_cos(theta), math::sin_cos(phi));
    Vec3::new(sin_phi * sin_theta, cos_phi, sin_phi * cos_theta)
}

/// How far from the target a camera sees all corners.
fn distance(corners: &[Vec3], target: Vec3, back: Vec3, up: Vec3, vfov: f32, size: UVec2) -> f32 {
    let right = up.cross(back).normalize_or_zero();
    let up = back.cross(right);
    let height = FILL * math::tan(0.5 * vfov);
    let width = height * size.x as f32 / size.y as f32;
    let needed = corners.iter().map(|&corner| {
        let away = corner - target;
        away.dot(back) + (away.dot(right).abs() / width).max(away.dot(up).abs() / height)
    });
    let needed = needed.fold(0.0, f32::max);
    if needed > 0.0 { needed } else { 5.0 }
}

/// Vertices of meshes, and corners of boxes around all other shapes but planes without end.
fn corners(rows: &[Row]) -> Vec<Vec3> {
    let (places, _) = world_transforms(rows);
    let shapes = rows.iter().zip(places).filter(|(row, _)| row.transform.is_some());
    let points = shapes.filter_map(|(row, place)| {
        let shape = match &row.shape {
            crate::scene::Part::None => return None,
            crate::scene::Part::Own(shape) => shape,
            crate::scene::Part::Of(other) => match &rows[*other as usize].shape {
                crate::scene::Part::Own(shape) => shape,
                _ => return None,
            },
        };
        let points = match &**shape {
            world::Shape::Mesh(mesh) => {
                mesh.positions.iter().step_by(1 + mesh.positions.len() / LOOKED_AT).copied().collect()
            }
            _ => box_corners(bounds(shape)?),
        };
        Some(points.into_iter().map(move |point: Vec3| place.transform_point3(point)))
    });
    points.flatten().collect()
}

fn box_corners(half: Vec3) -> Vec<Vec3> {
    let sign = |corner: u32, axis: u32| if corner >> axis & 1 == 0 { -1.0 } else { 1.0 };
    (0..8).map(|corner| half * Vec3::new(sign(corner, 0), sign(corner, 1), sign(corner, 2))).collect()
}

/// Half the box around a shape in its own space, for shapes that have a formula and an end.
fn bounds(shape: &world::Shape) -> Option<Vec3> {
    let half = match shape {
        world::Shape::Plane | world::Shape::Mesh(_) => return None,
        world::Shape::Sphere { radius } => Vec3::splat(*radius),
        world::Shape::Quad { size } => (0.5 * *size).extend(0.0),
        world::Shape::Disk { radius, .. } => Vec3::new(*radius, *radius, 0.0),
        world::Shape::Cuboid { size } => 0.5 * *size,
        world::Shape::Cylinder { radius, height } | world::Shape::Cone { radius, height } => {
            Vec3::new(*radius, 0.5 * height, *radius)
        }
        world::Shape::Torus { major_radius, minor_radius } => {
            let radius = major_radius + minor_radius;
            Vec3::new(radius, *minor_radius, radius)
        }
    };
    Some(half)
}

/// The sky in a file that the one who asks named: it may lie anywhere.
fn sky(session: &mut Session, file: &Path, view: View) -> Option<Background> {
    let name = file.to_string_lossy().into_owned();
    let about = |code, message| Diagnostic::about_file(Severity::Error, code, name.as_str(), message);
    let bytes = match session.read_outside(file) {
        Ok(bytes) => bytes,
        Err(refusal) => {
            let (code, reason) = describe(&refusal);
            session.found.push(about(code, format!("cannot read the environment: {reason}")));
            return None;
        }
    };
    let picture = match session.assets.sky_file.take() {
        Some((known, picture)) if known == bytes.1 => Ok(picture),
        _ => image::read(&bytes.0, &mut session.budgets.pixels).map(Arc::new),
    };
    let picture =
        picture.map_err(|error| session.found.push(error.explain(about(error.code(), String::new()), &name))).ok()?;
    session.assets.sky_file = Some((bytes.1, Arc::clone(&picture)));
    let sky = environment::sky(session, picture, view);
    let sky =
        sky.map_err(|error| session.found.push(about(Code::Image, format!("the picture is no sky: {error}")))).ok()?;
    Some(Background::Environment(sky))
}

/// The light of a photographer's studio: gray walls, a large soft light from above on the left of who looks along -Z, a weaker
/// one on the right, a strip behind, and one overhead.
pub(crate) fn studio(session: &mut Session, view: View) -> Option<Background> {
    const HEIGHT: u32 = 128;
    let picture = match &session.assets.studio {
        Some(picture) => Arc::clone(picture),
        None => {
            let pixels = (0..2 * HEIGHT * HEIGHT).map(|pixel| {
                let (x, y) = (pixel % (2 * HEIGHT), pixel / (2 * HEIGHT));
                let (azimuth, polar) =
                    ((x as f32 + 0.5) / HEIGHT as f32 * PI - PI, (y as f32 + 0.5) / HEIGHT as f32 * PI);
                let ((sine, cosine), (sin_polar, cos_polar)) = (math::sin_cos(azimuth), math::sin_cos(polar));
                [studio_radiance(Vec3A::new(sin_polar * cosine, cos_polar, sin_polar * sine)); 3]
            });
            let picture = Image { width: 2 * HEIGHT, height: HEIGHT, texels: Texels::Floats(pixels.collect()) };
            Arc::clone(session.assets.studio.insert(Arc::new(picture)))
        }
    };
    environment::sky(session, picture, view).ok().map(Background::Environment)
}

/// What the studio's camera sees behind things: gray paper, lit from above.
pub(crate) const PAPER: Background =
    Background::Gradient { horizon: Vec3::splat(0.55), zenith: Vec3::splat(0.32), ground: Vec3::splat(0.4) };

fn studio_radiance(direction: Vec3A) -> f32 {
    /// Where a light is, half its width in radians, and its radiance.
    const LIGHTS: [(Vec3A, f32, f32); 4] = [
        (Vec3A::new(-0.62, 0.58, 0.53), 0.42, 3.6),
        (Vec3A::new(0.87, 0.26, 0.42), 0.35, 1.3),
        (Vec3A::new(0.35, 0.35, -0.87), 0.3, 2.2),
        (Vec3A::new(0.0, 1.0, 0.0), 0.5, 0.8),
    ];
    let walls = 0.28 + 0.18 * direction.y;
    let lights = LIGHTS.iter().map(|&(place, width, radiance)| {
        let angle = math::acos(direction.dot(place.normalize()).clamp(-1.0, 1.0));
        let inside = ((width - angle) / (0.25 * width) + 0.5).clamp(0.0, 1.0);
        radiance * inside * inside * (3.0 - 2.0 * inside)
    });
    walls + lights.sum::<f32>()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_camera_that_nobody_described_sees_everything_and_not_much_more() {
        let corners: Vec<Vec3> = (0..8)
            .map(|corner| Vec3::new((corner & 1) as f32 * 4.0, (corner >> 1 & 1) as f32, (corner >> 2) as f32 * 2.0))
            .collect();
        let target = Vec3::new(2.0, 0.5, 1.0);
        for (size, up) in [(UVec2::new(960, 540), Vec3::Y), (UVec2::new(300, 900), Vec3::Y), (UVec2::ONE, Vec3::X)] {
            let back = about(DIRECTION[0], DIRECTION[1]);
            let eye = target + back * distance(&corners, target, back, up, VFOV, size);
            // A pinhole: what is `depth` before it is seen at its place aside over depth and the tangent of half the angle.
            let (right, tangent) = (up.cross(back).normalize(), (0.5 * VFOV).tan());
            let widest = corners.iter().map(|&corner| {
                let (away, upward) = (corner - eye, back.cross(right));
                let depth = -away.dot(back);
                let aspect = size.x as f32 / size.y as f32;
                (away.dot(right) / aspect).abs().max(away.dot(upward).abs()) / (depth * tangent)
            });
            let widest = widest.fold(0.0, f32::max);
            assert!((widest - FILL).abs() < 1e-4, "{size} {up}: {widest}");
        }
    }

    /// By hand: tilted down until it looks straight down, a camera whose up was +Y has the direction that it looked along at the top.
    #[test]
    fn straight_down_the_top_is_what_lay_ahead() {
        for (eye, up) in [(Vec3::Y, Vec3::NEG_Z), (Vec3::NEG_Y, Vec3::Z)] {
            assert_eq!(frame(eye, Vec3::ZERO, Vec3::Y), None);
            let top = frame(eye, Vec3::ZERO, up).expect("it is across").y_axis;
            let nearly = frame(eye + 1e-3 * Vec3::Z, Vec3::ZERO, Vec3::Y).expect("it is not along up").y_axis;
            assert!((top - nearly).length() < 2e-3, "{eye}: {top} and {nearly}");
        }
    }

    #[test]
    fn orbits_begin_at_z_and_turn_toward_x() {
        for (theta, phi, expected) in [(0.0, 0.5 * PI, Vec3::Z), (0.5 * PI, 0.5 * PI, Vec3::X), (1.0, 0.0, Vec3::Y)] {
            assert!((about(theta, phi) - expected).length() < 1e-6, "{theta} {phi}");
        }
    }
}
