//! What an author writes into what components hold: degrees into radians, names of metals into indices, files into pixels
//! and triangles. Errors that need more than one field are found here.

mod detail;
mod material;
mod place;
mod principled;
mod texture;

use std::sync::Arc;

use brewster_lanes::math;
use brewster_world::components as world;
use brewster_world::components::parts;
use brewster_world::components::parts::TriangleMesh;
use glam::{Affine3A, Mat3, UVec2, Vec3, Vec4};

use crate::diagnostics::Code;
use crate::limits::Exceeded;
use crate::session::Session;
use crate::source::Span;
use crate::{environment, mesh};

use super::schema;
use super::values::{Either, Rgb, Spanned};

pub(crate) use material::material;
pub(crate) use place::{Place, about, motion, place};

use place::{frame_around_y, is_off};

/// The height of the picture on full-frame film in meters, for which f-stops are given.
const FILM_HEIGHT: f32 = 0.024;

/// Angles of view below this one, in degrees, were probably meant to be radians.
const NARROW: f32 = 2.0;

/// Reports a picture that is larger than any may be.
pub(crate) fn check_resolution(session: &mut Session, resolution: &Spanned<[u32; 2]>) {
    let [width, height] = resolution.value;
    let bound = session.limits.picture_pixels;
    if u64::from(width) * u64::from(height) > bound {
        let exceeded = Exceeded { name: "picture_pixels", bound };
        let message = format!("a picture of {width} x {height} pixels is too large: {exceeded}");
        session.error(Code::Limit, resolution.span, message);
    }
}

/// The whole of a scene's settings, but for the integrator, which may have been chosen elsewhere.
pub(crate) fn settings(settings: &schema::Settings, integrator: parts::Integrator) -> parts::Settings {
    let [width, height] = settings.resolution.value;
    parts::Settings {
        resolution: UVec2::new(width, height),
        integrator,
        max_depth: settings.max_depth,
        samples: settings.samples,
        noise_threshold: settings.noise_threshold,
        seed: settings.seed,
        sampler: match settings.sampler {
            schema::Sampler::Sobol {} => parts::SamplerKind::Sobol,
            schema::Sampler::Independent {} => parts::SamplerKind::Independent,
        },
        split_depth: settings.split_depth,
        roulette: settings.roulette,
        guiding: settings.guiding,
        clamp: settings.clamp.unwrap_or(f32::INFINITY),
        ray_offset: 0.0,
        filter: match settings.filter {
            schema::PixelFilter::Box {} => parts::PixelFilter::Box,
            schema::PixelFilter::Tent {} => parts::PixelFilter::Tent,
            schema::PixelFilter::Gaussian {} => parts::PixelFilter::Gaussian,
            schema::PixelFilter::BlackmanHarris {} => parts::PixelFilter::BlackmanHarris,
        },
        transparent_shadows: settings.transparent_shadows.value,
        contribution_threshold: settings.contribution_threshold,
        backdrop: parts::Backdrop::Background,
        exposure: settings.exposure,
        tone_mapping: match settings.tone_mapping {
            schema::ToneMapping::None {} => parts::ToneMapping::None,
            schema::ToneMapping::Srgb {} => parts::ToneMapping::Srgb,
            schema::ToneMapping::Filmic {} => parts::ToneMapping::Filmic,
            schema::ToneMapping::Aces {} => parts::ToneMapping::Aces,
            schema::ToneMapping::Agx {} => parts::ToneMapping::Agx,
            schema::ToneMapping::PbrNeutral {} => parts::ToneMapping::PbrNeutral,
        },
    }
}

/// The integrator of that name.
pub(crate) fn integrator(integrator: &schema::Integrator) -> parts::Integrator {
    match integrator {
        schema::Integrator::Whitted {} => parts::Integrator::Whitted,
        schema::Integrator::Path {} => parts::Integrator::Path,
    }
}

/// The background.
pub(crate) fn background(session: &mut Session, background: &Either<Rgb, schema::Sky>) -> Option<parts::Background> {
    Some(match background {
        Either::Plain(color) => parts::Background::Constant(color.0),
        Either::Choice(schema::Sky::Gradient { horizon, zenith, ground }) => {
            parts::Background::Gradient { horizon: horizon.0, zenith: zenith.0, ground: ground.unwrap_or(*horizon).0 }
        }
        Either::Choice(schema::Sky::Environment { file, rotation, rows, intensity }) => {
            let rows = match rows {
                schema::Rows::Centers {} => parts::MapRows::Centers,
                schema::Rows::Poles {} => parts::MapRows::Poles,
            };
            let view = environment::View { rows, rotation: rotation.to_radians(), intensity: *intensity };
            parts::Background::Environment(environment::load(session, &file.value, file.span, view)?)
        }
    })
}

/// A camera, its place and how it moves.
pub(crate) fn camera(
    session: &mut Session,
    camera: &Spanned<schema::Camera>,
) -> Option<(world::Camera, Affine3A, Option<world::Motion>)> {
    let (eye, target, up, lens, motion, projection) = match &camera.value {
        schema::Camera::Perspective { eye, target, up, vfov, lens, motion } => {
            if *vfov < NARROW {
                let message = format!("a camera that sees {vfov} degrees: angles are in degrees");
                let warning = session.sources.warning(Code::Range, camera.span, message);
                session.found.push(warning.help(format!("{vfov} radians are {:.1} degrees", vfov.to_degrees())));
            }
            (eye, target, up, lens, motion, world::Projection::Perspective { vfov: vfov.to_radians() })
        }
        schema::Camera::Orthographic { eye, target, up, height, lens, motion } => {
            (eye, target, up, lens, motion, world::Projection::Orthographic { height: *height })
        }
    };
    let lens = match lens {
        Some(at) => {
            let lens = self::lens(session, at, &projection, eye.distance(*target))?;
            if session.integrator == parts::Integrator::Whitted && lens.aperture_radius > 0.0 {
                session.refused.push((at.span, "a lens"));
            }
            Some(lens)
        }
        None => None,
    };
    let place = view(session, camera.span, [*eye, *target, *up])?;
    let motion = match motion {
        Some(pan) => pan_to(session, camera.span, pan, ([*eye, *target, *up], place))?,
        None => None,
    };
    Some((world::Camera { projection, lens }, place, motion))
}

/// The place of a camera by its eye, the point that it looks at, and what is up.
fn view(session: &mut Session, span: Span, [eye, target, up]: [Vec3; 3]) -> Option<Affine3A> {
    let Some(forward) = (target - eye).try_normalize() else {
        session.error(Code::Conflict, span, "`eye` and `target` are one point: the camera looks nowhere");
        return None;
    };
    let Some(right) = forward.cross(up.normalize_or_zero()).try_normalize().filter(|_| is_off(forward, up)) else {
        session.error(Code::Conflict, span, "`up` is zero or points along the view");
        return None;
    };
    let frame = Mat3::from_cols(right, right.cross(forward), -forward);
    Some(Affine3A::from_mat3_translation(frame, eye))
}

/// How a camera moves from what it sees at a place to what it sees when the shutter closes, if that is something else.
fn pan_to(
    session: &mut Session,
    span: Span,
    pan: &schema::Pan,
    (from, place): ([Vec3; 3], Affine3A),
) -> Option<Option<world::Motion>> {
    const LOOKS: usize = 256;
    let to = [pan.eye.unwrap_or(from[0]), pan.target.unwrap_or(from[1]), pan.up.unwrap_or(from[2])];
    if to == from {
        return Some(None);
    }
    let mut at = |s: f32| view(session, span, std::array::from_fn(|i| from[i] + (to[i] - from[i]) * s));
    let mut places = vec![place];
    for look in 1..=LOOKS {
        places.push(at(look as f32 / LOOKS as f32)?);
    }
    // Between two steps a camera turns evenly. One that looks at a point while it comes nearer does not, however little it turns.
    let turns = places.iter().any(|look| !look.matrix3.abs_diff_eq(place.matrix3, 1e-5));
    let steps = if turns { LOOKS } else { 1 };
    let step = |step: usize| place.inverse() * places[step * LOOKS / steps];
    Some(world::Motion::through((1..=steps).map(step).collect::<Vec<_>>()))
}

/// A lens; without a word about it, what the camera looks at is sharp.
fn lens(
    session: &mut Session,
    lens: &schema::Lens,
    projection: &world::Projection,
    target_distance: f32,
) -> Option<world::Lens> {
    let expected = "one of: `aperture_radius`, `f_stop`";
    let (code, message) = match (lens.aperture_radius, lens.f_stop, projection) {
        (Some(aperture_radius), None, _) => {
            return Some(world::Lens {
                aperture_radius,
                focus_distance: lens.focus_distance.unwrap_or(target_distance),
                blades: lens.blades,
            });
        }
        (None, Some(f_stop), world::Projection::Perspective { vfov }) => {
            let focal_length = 0.5 * FILM_HEIGHT / math::tan(0.5 * vfov);
            return Some(world::Lens {
                aperture_radius: 0.5 * focal_length / f_stop,
                focus_distance: lens.focus_distance.unwrap_or(target_distance),
                blades: lens.blades,
            });
        }
        (None, Some(_), world::Projection::Orthographic { .. }) => {
            (Code::Conflict, "an f-stop needs an angle of view: this camera has none")
        }
        (None, None, _) => (Code::MissingField, "nothing says how wide the lens is open"),
        (Some(_), Some(_), _) => (Code::Conflict, "two fields say how wide the lens is open"),
    };
    session.found.push(session.sources.error(code, lens.span, message).expected(expected));
    None
}

/// A light.
pub(crate) fn light(session: &mut Session, light: &Spanned<schema::Light>) -> Option<world::Light> {
    let falloff = |falloff: &schema::Falloff| match falloff {
        schema::Falloff::InverseSquare { range: None } => world::Falloff::InverseSquare,
        &schema::Falloff::InverseSquare { range: Some(range) } => world::Falloff::Within(range),
        schema::Falloff::None {} => world::Falloff::None,
    };
    Some(match &light.value {
        schema::Light::Point { intensity, falloff: with } => {
            world::Light::Point { intensity: intensity.0, falloff: falloff(with) }
        }
        schema::Light::Directional { irradiance } => world::Light::Directional { irradiance: irradiance.0 },
        schema::Light::Spot { inner_angle, outer_angle, .. } if inner_angle > outer_angle => {
            let message = format!("`inner_angle` {inner_angle} is larger than `outer_angle` {outer_angle}");
            session.error(Code::Conflict, light.span, message);
            return None;
        }
        schema::Light::Spot { intensity, inner_angle, outer_angle, falloff: with } => world::Light::Spot {
            intensity: intensity.0,
            inner_angle: inner_angle.to_radians(),
            outer_angle: outer_angle.to_radians(),
            falloff: falloff(with),
        },
        schema::Light::Ambient { radiance } => {
            if session.integrator == parts::Integrator::Path {
                let message = "the integrator Path makes nothing of ambient light, which is for Phong materials";
                let warning = session.sources.warning(Code::Integrator, light.span, message);
                session.found.push(warning.help("a background lights what is around"));
            }
            world::Light::Ambient { radiance: radiance.0 }
        }
    })
}

/// A shape and its place in its entity's space, which for all but planes is the origin.
pub(crate) fn shape(session: &mut Session, shape: &Spanned<schema::Shape>) -> Option<(world::Shape, Affine3A)> {
    let mut conflict = |message: String| {
        session.error(Code::Conflict, shape.span, message);
        None
    };
    let shape = match &shape.value {
        schema::Shape::Sphere { radius } => world::Shape::Sphere { radius: *radius },
        schema::Shape::Plane { normal, point } => {
            let Some(up) = normal.value.try_normalize() else {
                session.error(Code::Range, normal.span, "a normal of length 0 points nowhere");
                return None;
            };
            if (normal.value.length() - 1.0).abs() > 1e-3 {
                let message = format!("the normal's length is {}, not 1", normal.value.length());
                session.found.push(
                    session.sources.warning(Code::Normal, normal.span, message).help("only its direction counts"),
                );
            }
            let place = Affine3A::from_mat3_translation(frame_around_y(up), *point);
            return Some((world::Shape::Plane, place));
        }
        schema::Shape::Quad { size } => world::Shape::Quad { size: *size },
        schema::Shape::Disk { radius, inner_radius } if inner_radius >= radius => {
            return conflict(format!("`inner_radius` {inner_radius} is not less than `radius` {radius}"));
        }
        schema::Shape::Disk { radius, inner_radius } => {
            world::Shape::Disk { radius: *radius, inner_radius: *inner_radius }
        }
        schema::Shape::Box { size } => world::Shape::Cuboid { size: *size },
        schema::Shape::Cylinder { radius, height } => world::Shape::Cylinder { radius: *radius, height: *height },
        schema::Shape::Cone { radius, height } => world::Shape::Cone { radius: *radius, height: *height },
        schema::Shape::Torus { major_radius, minor_radius } if minor_radius >= major_radius => {
            return conflict(format!("`minor_radius` {minor_radius} is not less than `major_radius` {major_radius}"));
        }
        schema::Shape::Torus { major_radius, minor_radius } => {
            world::Shape::Torus { major_radius: *major_radius, minor_radius: *minor_radius }
        }
        schema::Shape::Mesh { .. } => world::Shape::Mesh(triangles(session, shape)?),
        schema::Shape::Gltf { .. } => {
            let message = "a glTF file is not one shape: it stands in an entity";
            session.error(Code::Composition, shape.span, message);
            return None;
        }
    };
    Some((shape, Affine3A::IDENTITY))
}

fn triangles(session: &mut Session, shape: &Spanned<schema::Shape>) -> Option<Arc<TriangleMesh>> {
    let schema::Shape::Mesh { file, positions, triangles, normals, uvs, second_uvs, colors, tangents } = &shape.value
    else {
        return None;
    };
    let expected = "`file`, or `positions` and `triangles`";
    if let Some(file) = file {
        let is_in_place = positions.is_some() || triangles.is_some() || normals.is_some();
        if is_in_place || uvs.is_some() || second_uvs.is_some() || colors.is_some() || tangents.is_some() {
            let error = session.sources.error(Code::Conflict, shape.span, "a mesh from a file and in place at once");
            session.found.push(error.expected(expected));
            return None;
        }
        return mesh::load(session, &file.value, file.span);
    }
    let (Some(positions), Some(triangles)) = (positions, triangles) else {
        let error = session.sources.error(Code::MissingField, shape.span, "nothing says what the mesh is made of");
        session.found.push(error.expected(expected));
        return None;
    };
    let fours = |column: &Option<Spanned<Vec<[f32; 4]>>>| match column {
        Some(column) => column.value.iter().copied().map(Vec4::from_array).collect(),
        None => Vec::new(),
    };
    let mesh = TriangleMesh {
        positions: positions.value.clone(),
        normals: normals.as_ref().map_or_else(Vec::new, |normals| normals.value.clone()),
        uvs: uvs.as_ref().map_or_else(Vec::new, |uvs| uvs.value.clone()),
        second_uvs: second_uvs.as_ref().map_or_else(Vec::new, |uvs| uvs.value.clone()),
        colors: fours(colors),
        tangents: fours(tangents),
        triangles: triangles.value.clone(),
    };
    mesh::check(session, &mesh, shape.span).then(|| Arc::new(mesh))
}
