//! Where things are: fields that place something into transforms.

use brewster_lanes::math;
use brewster_world::components as world;
use brewster_world::components::parts::Affine;
use glam::{Affine3A, Mat3, Vec3};

use crate::diagnostics::Code;
use crate::ron::schema;
use crate::ron::values::{Scale, Spanned};
use crate::session::Session;
use crate::source::Span;

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
        (Some(rotation), None) => rotate(session, rotation, 1.0)?,
        (None, Some(target)) => look_at(session, at, target)?,
        (None, None) => Mat3::IDENTITY,
    };
    let Some(scale) = place.scale else { return Some(Affine3A::from_mat3_translation(rotation, at)) };
    let linear = rotation * Mat3::from_diagonal(scale.value.0);
    regular(session, Affine3A::from_mat3_translation(linear, at), scale.span)
}

/// Degrees that a motion turns by at most: it goes in so many steps only that look round to here.
const MOST_TURN: f32 = 5000.0;

/// How an entity at a place moves; none if it does not, or after an error.
///
/// What turns keeps its shape, however it is scaled: it turns after it was scaled, about the axes that its place gives it.
pub(crate) fn motion(session: &mut Session, motion: &schema::Motion, place: Affine3A) -> Option<world::Motion> {
    let (matrix, inverse) = (Mat3::from(place.matrix3), Mat3::from(place.matrix3.inverse()));
    let scale = Vec3::new(matrix.x_axis.length(), matrix.y_axis.length(), matrix.z_axis.length());
    let turning = motion.rotate.as_ref();
    if let Some(rotation) = turning {
        rotate(session, rotation, 1.0)?;
    }
    let angle = turning.map_or(0.0, |turn| turn.angle.unwrap_or(turn.x.abs() + turn.y.abs() + turn.z.abs()));
    if let Some(rotation) = turning.filter(|_| angle.abs() > MOST_TURN) {
        let message = format!("a motion does not turn by {angle} degrees");
        let error = session.sources.error(Code::Range, rotation.span, message);
        session.found.push(error.expected(format!("{MOST_TURN} degrees in all at most")));
        return None;
    }
    let moved = world::Motion::turning(angle.to_radians(), |s| {
        let turned = turning.and_then(|rotation| rotate(session, rotation, s)).unwrap_or(Mat3::IDENTITY);
        let turned = match turned == Mat3::IDENTITY {
            true => turned,
            false => Mat3::from_diagonal(scale.recip()) * turned * Mat3::from_diagonal(scale),
        };
        Affine3A::from_mat3_translation(turned * (1.0 + (motion.scale - 1.0) * s), inverse * (motion.by * s))
    });
    moved.steps().iter().any(|step| *step != Affine3A::IDENTITY).then_some(moved)
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

/// A part of a rotation, or all of it.
fn rotate(session: &mut Session, rotation: &schema::Rotation, part: f32) -> Option<Mat3> {
    let angles = [rotation.x, rotation.y, rotation.z].map(|angle| angle * part);
    match (&rotation.axis, rotation.angle) {
        (None, None) => {
            let [x, y, z] = angles;
            Some(about(Vec3::Z, z) * about(Vec3::Y, y) * about(Vec3::X, x))
        }
        (Some(axis), Some(angle)) if angles == [0.0; 3] => match axis.value.try_normalize() {
            Some(axis) => Some(about(axis, angle * part)),
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

/// A right-handed frame whose y axis is `up`: the identity for +Y, and z as near as may be to what it was.
pub(super) fn frame_around_y(up: Vec3) -> Mat3 {
    let z = if up.z.abs() < 0.99 { Vec3::Z } else { Vec3::NEG_Y * up.z.signum() };
    let x = up.cross(z).normalize();
    Mat3::from_cols(x, up, x.cross(up))
}

/// Whether two directions span a plane.
pub(super) fn is_off(a: Vec3, b: Vec3) -> bool {
    a.cross(b.normalize_or_zero()).length_squared() > 1e-10
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
