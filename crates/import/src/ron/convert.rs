//! What an author writes into what components hold: degrees into radians, names of metals into indices, files into pixels
//! and triangles. Errors that need more than one field are found here.

use std::sync::Arc;

use brewster_lanes::math;
use brewster_optics::{fresnel, glasses, metals};
use brewster_world::components as world;
use brewster_world::components::parts;
use brewster_world::components::parts::{Affine, FresnelModel, TriangleMesh};
use glam::{Affine3A, Mat3, UVec2, Vec3};

use crate::diagnostics::Code;
use crate::session::Session;
use crate::source::Span;
use crate::{image, mesh};

use super::schema::{self, Paint};
use super::values::{Either, Rgb, Scale, Spanned};

/// The whole of a scene's settings.
pub(crate) fn settings(settings: &schema::Settings) -> parts::Settings {
    let [width, height] = settings.resolution;
    parts::Settings {
        resolution: UVec2::new(width, height),
        integrator: match settings.integrator {
            schema::Integrator::Whitted {} => parts::Integrator::Whitted,
        },
        max_depth: settings.max_depth,
        samples: settings.samples,
        seed: settings.seed,
        filter: match settings.filter {
            schema::PixelFilter::Box {} => parts::PixelFilter::Box,
            schema::PixelFilter::Tent {} => parts::PixelFilter::Tent,
            schema::PixelFilter::Gaussian {} => parts::PixelFilter::Gaussian,
            schema::PixelFilter::BlackmanHarris {} => parts::PixelFilter::BlackmanHarris,
        },
        transparent_shadows: settings.transparent_shadows,
        contribution_threshold: settings.contribution_threshold,
        exposure: settings.exposure,
        tone_mapping: match settings.tone_mapping {
            schema::ToneMapping::Srgb {} => parts::ToneMapping::Srgb,
            schema::ToneMapping::Filmic {} => parts::ToneMapping::Filmic,
        },
        ..parts::Settings::default()
    }
}

/// The background.
pub(crate) fn background(background: &Either<Rgb, schema::Sky>) -> parts::Background {
    match background {
        Either::Plain(color) => parts::Background::Constant(color.0),
        Either::Choice(schema::Sky::Gradient { horizon, zenith, ground }) => {
            parts::Background::Gradient { horizon: horizon.0, zenith: zenith.0, ground: ground.unwrap_or(*horizon).0 }
        }
    }
}

/// A camera and its place.
pub(crate) fn camera(session: &mut Session, camera: &Spanned<schema::Camera>) -> Option<(world::Camera, Affine3A)> {
    let (eye, target, up, lens, projection) = match &camera.value {
        schema::Camera::Perspective { eye, target, up, vfov, lens } => {
            (eye, target, up, lens, world::Projection::Perspective { vfov: vfov.to_radians() })
        }
        schema::Camera::Orthographic { eye, target, up, height, lens } => {
            (eye, target, up, lens, world::Projection::Orthographic { height: *height })
        }
    };
    let lens = lens
        .as_ref()
        .map(|lens| world::Lens { aperture_radius: lens.aperture_radius, focus_distance: lens.focus_distance });
    let Some(forward) = (*target - *eye).try_normalize() else {
        session.error(Code::Conflict, camera.span, "`eye` and `target` are one point: the camera looks nowhere");
        return None;
    };
    let Some(right) = forward.cross(up.normalize_or_zero()).try_normalize().filter(|_| is_off(forward, *up)) else {
        session.error(Code::Conflict, camera.span, "`up` is zero or points along the view");
        return None;
    };
    let frame = Mat3::from_cols(right, right.cross(forward), -forward);
    Some((world::Camera { projection, lens }, Affine3A::from_mat3_translation(frame, *eye)))
}

/// Whether two directions span a plane.
fn is_off(a: Vec3, b: Vec3) -> bool {
    a.cross(b.normalize_or_zero()).length_squared() > 1e-10
}

/// A material.
pub(crate) fn material(session: &mut Session, material: &Spanned<schema::Material>) -> Option<world::Material> {
    let span = material.span;
    Some(match &material.value {
        schema::Material::Phong { ambient, diffuse, specular, exponent } => world::Material::Phong {
            ambient: match ambient {
                Some(ambient) => albedo(session, ambient, "ambient", span)?,
                None => paint(session, diffuse)?,
            },
            diffuse: albedo(session, diffuse, "diffuse", span)?,
            specular: paint(session, specular)?,
            exponent: *exponent,
        },
        schema::Material::Lambert { albedo: color } => {
            world::Material::Lambert { albedo: albedo(session, color, "albedo", span)? }
        }
        schema::Material::Metal { r0, eta, k, of, fresnel, specular, exponent } => {
            let reflectance = reflectance(session, (r0, eta, k, of), span)?;
            world::Material::Metal {
                fresnel: metal_fresnel(session, &reflectance, fresnel.as_ref())?,
                reflectance,
                specular: paint(session, specular)?,
                exponent: *exponent,
                alpha: 0.0,
            }
        }
        schema::Material::Dielectric { ior, reflectance, glass, fresnel, specular, exponent, absorption, priority } => {
            world::Material::Dielectric {
                ior: index(session, (*ior, *reflectance, glass), span)?,
                fresnel: fresnel_model(fresnel),
                specular: paint(session, specular)?,
                exponent: *exponent,
                absorption: absorption.0,
                priority: *priority,
                alpha: 0.0,
                thin: false,
            }
        }
        schema::Material::Emissive { radiance } => world::Material::Emissive { radiance: paint(session, radiance)? },
    })
}

type ReflectanceFields<'m> = (&'m Option<Paint>, &'m Option<Rgb>, &'m Option<Rgb>, &'m Option<Spanned<String>>);

fn reflectance(session: &mut Session, fields: ReflectanceFields, span: Span) -> Option<world::Reflectance> {
    match fields {
        (Some(r0), None, None, None) => Some(world::Reflectance::Normal { r0: paint(session, r0)?, f82: Vec3::ONE }),
        (None, Some(eta), Some(k), None) => Some(world::Reflectance::Index { eta: eta.0, k: k.0 }),
        (None, None, None, Some(name)) => {
            let found = metals::metal(&name.value);
            if found.is_none() {
                let message = format!("there is no measured metal {:?}", name.value);
                let error = session.sources.error(Code::UnknownName, name.span, message);
                session.found.push(error.nearest_name(&name.value, metals::metal_names()));
            }
            found.map(|metal| world::Reflectance::Index { eta: metal.eta, k: metal.k })
        }
        (None, Some(_), None, None) | (None, None, Some(_), None) => {
            let message = "an index needs both `eta` and `k`";
            session.error(Code::MissingField, span, message);
            None
        }
        (None, None, None, None) => {
            let error = session.sources.error(Code::MissingField, span, "nothing says what the metal reflects");
            session.found.push(error.expected("one of: `r0`, `eta` and `k`, `of`"));
            None
        }
        _ => {
            let error = session.sources.error(Code::Conflict, span, "more than one field says what the metal reflects");
            session.found.push(error.expected("one of: `r0`, `eta` and `k`, `of`"));
            None
        }
    }
}

fn metal_fresnel(
    session: &mut Session,
    reflectance: &world::Reflectance,
    fresnel: Option<&Spanned<schema::Fresnel>>,
) -> Option<FresnelModel> {
    let has_index = matches!(reflectance, world::Reflectance::Index { .. });
    let Some(fresnel) = fresnel else {
        return Some(if has_index { FresnelModel::Exact } else { FresnelModel::Schlick });
    };
    let (message, expected) = match fresnel.value {
        schema::Fresnel::Exact {} if !has_index => ("the Fresnel equations need an index", "`eta` and `k`, or `of`"),
        schema::Fresnel::SchlickThetaM {} => ("`SchlickThetaM` is for dielectrics", "`Exact` or `Schlick`"),
        _ => return Some(fresnel_model(&fresnel.value)),
    };
    session.found.push(session.sources.error(Code::Conflict, fresnel.span, message).expected(expected));
    None
}

fn fresnel_model(fresnel: &schema::Fresnel) -> FresnelModel {
    match fresnel {
        schema::Fresnel::Exact {} => FresnelModel::Exact,
        schema::Fresnel::Schlick {} => FresnelModel::Schlick,
        schema::Fresnel::SchlickThetaM {} => FresnelModel::SchlickThetaM,
    }
}

fn index(
    session: &mut Session,
    fields: (Option<f32>, Option<f32>, &Option<Spanned<String>>),
    span: Span,
) -> Option<f32> {
    let (code, message) = match fields {
        (Some(ior), None, None) => return Some(ior),
        (None, Some(reflectance), None) => match fresnel::ior_from_f0(reflectance) {
            Ok(ior) if ior.is_finite() => return Some(ior),
            _ => (Code::Range, "no dielectric has this reflectance"),
        },
        (None, None, Some(name)) => {
            let found = glasses::glass(&name.value);
            if found.is_none() {
                let message = format!("there is no glass {:?}", name.value);
                let error = session.sources.error(Code::UnknownName, name.span, message);
                session.found.push(error.nearest_name(&name.value, glasses::glass_names()));
            }
            return found.map(|glass| glass.ior());
        }
        (None, None, None) => (Code::MissingField, "nothing says how the dielectric refracts"),
        _ => (Code::Conflict, "more than one field says how the dielectric refracts"),
    };
    session.found.push(session.sources.error(code, span, message).expected("one of: `ior`, `reflectance`, `glass`"));
    None
}

/// A color that should not pass 1.
fn albedo(session: &mut Session, color: &Paint, field: &str, span: Span) -> Option<world::Color> {
    let largest = match color {
        Either::Plain(Rgb(color)) => color.max_element(),
        Either::Choice(schema::Texture::Checker { a, b, .. }) => a.0.max(b.0).max_element(),
        Either::Choice(schema::Texture::Gradient { from, to, .. }) => from.0.max(to.0).max_element(),
        Either::Choice(schema::Texture::Image { .. }) => 0.0,
    };
    if largest > 1.0 {
        let message = format!("`{field}` of {largest}: the surface sends back more light than it gets");
        session.warning(Code::Albedo, span, message);
    }
    paint(session, color)
}

fn paint(session: &mut Session, paint: &Paint) -> Option<world::Color> {
    let texture = match paint {
        Either::Plain(color) => return Some(world::Color::Constant(color.0)),
        Either::Choice(schema::Texture::Checker { a, b, size }) => {
            parts::Texture::Checker { a: a.0, b: b.0, size: *size }
        }
        Either::Choice(schema::Texture::Gradient { from, to, axis }) => parts::Texture::Gradient {
            from: from.0,
            to: to.0,
            axis: match axis {
                schema::Axis::U {} => parts::Axis::U,
                schema::Axis::V {} => parts::Axis::V,
            },
        },
        Either::Choice(schema::Texture::Image { file, repeat }) => {
            parts::Texture::Image { image: image::load(session, &file.value, file.span)?, repeat: *repeat }
        }
    };
    Some(world::Color::Texture(texture))
}

/// A light.
pub(crate) fn light(session: &mut Session, light: &Spanned<schema::Light>) -> Option<world::Light> {
    let falloff = |falloff: &schema::Falloff| match falloff {
        schema::Falloff::InverseSquare {} => world::Falloff::InverseSquare,
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
        schema::Light::Ambient { radiance } => world::Light::Ambient { radiance: radiance.0 },
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
    };
    Some((shape, Affine3A::IDENTITY))
}

fn triangles(session: &mut Session, shape: &Spanned<schema::Shape>) -> Option<Arc<TriangleMesh>> {
    let schema::Shape::Mesh { file, positions, triangles, normals, uvs } = &shape.value else { return None };
    let expected = "`file`, or `positions` and `triangles`";
    if let Some(file) = file {
        if positions.is_some() || triangles.is_some() || normals.is_some() || uvs.is_some() {
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
    let mesh = TriangleMesh {
        positions: positions.value.clone(),
        normals: normals.as_ref().map_or_else(Vec::new, |normals| normals.value.clone()),
        uvs: uvs.as_ref().map_or_else(Vec::new, |uvs| uvs.value.clone()),
        triangles: triangles.value.clone(),
    };
    mesh::check(session, &mesh, shape.span).then(|| Arc::new(mesh))
}

/// A right-handed frame whose y axis is `up`: the identity for +Y, and z as near as may be to what it was.
fn frame_around_y(up: Vec3) -> Mat3 {
    let z = if up.z.abs() < 0.99 { Vec3::Z } else { Vec3::NEG_Y * up.z.signum() };
    let x = up.cross(z).normalize();
    Mat3::from_cols(x, up, x.cross(up))
}

/// The fields that place something.
pub(crate) struct Place<'e> {
    pub at: Option<Vec3>,
    pub rotate: Option<&'e schema::Rotation>,
    pub scale: Option<Spanned<Scale>>,
    pub look_at: Option<&'e Spanned<Vec3>>,
    pub transform: Option<&'e Spanned<[[f32; 4]; 3]>>,
}

/// The transform that the fields mean; the identity after an error.
pub(crate) fn place(session: &mut Session, place: &Place) -> Affine3A {
    transform(session, place).unwrap_or(Affine3A::IDENTITY)
}

fn transform(session: &mut Session, place: &Place) -> Option<Affine3A> {
    if let Some(matrix) = place.transform {
        if place.at.is_some() || place.rotate.is_some() || place.scale.is_some() || place.look_at.is_some() {
            let message = "`transform` beside other fields that say where the entity is";
            let error = session.sources.error(Code::Conflict, matrix.span, message);
            session.found.push(error.expected("either `transform`, or `at`, `rotate`, `scale` and `look_at`"));
            return None;
        }
        let [x, y, z] = matrix.value;
        let column = |c: usize| Vec3::new(x[c], y[c], z[c]);
        let linear = Mat3::from_cols(column(0), column(1), column(2));
        return regular(session, Affine3A::from_mat3_translation(linear, column(3)), matrix.span);
    }
    let at = place.at.unwrap_or(Vec3::ZERO);
    let rotation = match (place.rotate, place.look_at) {
        (Some(rotation), Some(_)) => {
            session.error(Code::Conflict, rotation.span, "`rotate` and `look_at` both say how the entity is turned");
            return None;
        }
        (Some(rotation), None) => rotate(session, rotation)?,
        (None, Some(target)) => look_at(session, at, target)?,
        (None, None) => Mat3::IDENTITY,
    };
    let Some(scale) = place.scale else { return Some(Affine3A::from_mat3_translation(rotation, at)) };
    let linear = rotation * Mat3::from_diagonal(scale.value.0);
    regular(session, Affine3A::from_mat3_translation(linear, at), scale.span)
}

/// The transform, if it has an inverse.
fn regular(session: &mut Session, transform: Affine3A, span: Span) -> Option<Affine3A> {
    match Affine::from_affine3a(transform).and_then(|affine| affine.inverse()) {
        Ok(_) => Some(transform),
        Err(error) => {
            session.error(Code::Singular, span, error.to_string());
            None
        }
    }
}

fn rotate(session: &mut Session, rotation: &schema::Rotation) -> Option<Mat3> {
    let angles = [rotation.x, rotation.y, rotation.z];
    match (&rotation.axis, rotation.angle) {
        (None, None) => {
            let [x, y, z] = angles;
            Some(about(Vec3::Z, z) * about(Vec3::Y, y) * about(Vec3::X, x))
        }
        (Some(axis), Some(angle)) if angles == [0.0; 3] => match axis.value.try_normalize() {
            Some(axis) => Some(about(axis, angle)),
            None => {
                session.error(Code::Range, axis.span, "an axis of length 0 points nowhere");
                None
            }
        },
        _ => {
            let message = "this says neither an axis with its angle nor angles about x, y and z";
            let error = session.sources.error(Code::Conflict, rotation.span, message);
            session.found.push(error.expected("(x: …, y: …, z: …) or (axis: …, angle: …)"));
            None
        }
    }
}

/// The rotation about a unit axis by an angle in degrees (Rodrigues). Multiples of 90 degrees are exact.
pub(crate) fn about(axis: Vec3, degrees: f32) -> Mat3 {
    let (sin, cos) = sin_cos_degrees(degrees);
    let scaled = axis * (1.0 - cos);
    let turned = axis * sin;
    Mat3::from_cols(
        scaled.x * axis + Vec3::new(cos, turned.z, -turned.y),
        scaled.y * axis + Vec3::new(-turned.z, cos, turned.x),
        scaled.z * axis + Vec3::new(turned.y, -turned.x, cos),
    )
}

fn sin_cos_degrees(degrees: f32) -> (f32, f32) {
    let quarters = (degrees / 90.0).round();
    let (sin, cos) = math::sin_cos((degrees - 90.0 * quarters).to_radians());
    match quarters.rem_euclid(4.0) as u8 {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

/// The rotation that turns -Z toward a point and keeps +Y as far up as it can.
fn look_at(session: &mut Session, at: Vec3, target: &Spanned<Vec3>) -> Option<Mat3> {
    let Some(forward) = (target.value - at).try_normalize() else {
        session.error(Code::Conflict, target.span, "`look_at` is where the entity is itself");
        return None;
    };
    let up = if is_off(forward, Vec3::Y) { Vec3::Y } else { Vec3::NEG_Z };
    let right = forward.cross(up).normalize();
    Some(Mat3::from_cols(right, right.cross(forward), -forward))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rotations_go_counterclockwise_and_quarters_are_exact() {
        for (axis, degrees, from, to) in [
            (Vec3::Z, 90.0, Vec3::X, Vec3::Y),
            (Vec3::X, 90.0, Vec3::Y, Vec3::Z),
            (Vec3::Y, 90.0, Vec3::Z, Vec3::X),
            (Vec3::Y, -90.0, Vec3::X, Vec3::Z),
            (Vec3::Y, 540.0, Vec3::X, Vec3::NEG_X),
        ] {
            assert_eq!(about(axis, degrees) * from, to, "{axis} by {degrees}");
        }
        // cos 30° = √3/2, sin 30° = 1/2.
        let turned = about(Vec3::Y, 30.0) * Vec3::Z;
        assert!((turned - Vec3::new(0.5, 0.0, 0.75f32.sqrt())).length() < 1e-7, "{turned}");
        let axis = Vec3::new(1.0, 1.0, 1.0).normalize();
        assert!((about(axis, 120.0) * Vec3::X - Vec3::Y).length() < 1e-6);
    }

    #[test]
    fn a_frame_around_y_is_a_rotation() {
        for up in [Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z, Vec3::X, Vec3::new(0.6, 0.0, -0.8)] {
            let frame = frame_around_y(up);
            assert!((frame * Vec3::Y - up).length() < 1e-6, "{up}");
            assert!((frame.determinant() - 1.0).abs() < 1e-6, "{up}");
        }
        assert_eq!(frame_around_y(Vec3::Y), Mat3::IDENTITY);
    }
}
