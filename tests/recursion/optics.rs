//! What surfaces do to light, in f64 and from the textbook's formulas.
//!
//! Directions are those that the tracer's own functions give, in f32, each checked here against the law it has to obey.

use brewster_buffers::{Dielectric, Metal};
use brewster_geometry::SurfacePoint;
use brewster_optics::fresnel::FresnelModel;
use brewster_optics::refraction;
use glam::{DVec2, DVec3, Vec3};

use super::flipped;
use super::media::Boundary;
use crate::textbook;

/// How far a direction in f32 may be from the law.
const DIRECTION_TOLERANCE: f64 = 2e-6;

/// What a dielectric boundary does to a ray.
pub(crate) struct Split {
    /// F_r.
    pub(crate) reflectance: f64,
    /// The direction behind the boundary, if any light goes there.
    pub(crate) refracted: Option<Vec3>,
}

/// The mirror direction, checked: unit length, the same component along the surface, the opposite one across.
pub(crate) fn checked_mirror(direction: Vec3, normal: Vec3) -> Vec3 {
    let mirrored = refraction::mirror(direction, normal);
    let (d, n) = (direction.as_dvec3(), normal.as_dvec3());
    let law = d - 2.0 * d.dot(n) * n;
    assert!(
        (mirrored.as_dvec3() - law).length() < DIRECTION_TOLERANCE,
        "{direction} about {normal}: {mirrored}, not {law}"
    );
    mirrored
}

/// The refracted direction, checked: unit length, on the other side, and by Snell's law.
fn checked_refraction(direction: Vec3, normal: Vec3, eta_i: f32, eta_t: f32) -> Option<Vec3> {
    let refracted = refraction::refract(direction, normal, eta_i, eta_t);
    let (d, n, ratio) = (direction.as_dvec3(), normal.as_dvec3(), f64::from(eta_i) / f64::from(eta_t));
    let sine = d.cross(n) * ratio;
    let Some(refracted) = refracted else {
        assert!(
            sine.length() > 1.0 - DIRECTION_TOLERANCE,
            "{direction} through {normal}: no total reflection by {ratio}"
        );
        return None;
    };
    let t = refracted.as_dvec3();
    let error = (t.cross(n) - sine).length() + (t.length() - 1.0).abs() + t.dot(n).max(0.0);
    assert!(error < DIRECTION_TOLERANCE, "{direction} through {normal} by {ratio}: {refracted} is off by {error}");
    Some(refracted)
}

/// Splits light at the boundary of two media: `surface` gives the model.
///
/// The media's sides are the geometric normal's. Which of them light comes from in the Fresnel equations, the shading
/// normal says.
pub(crate) fn split(surface: &Dielectric, direction: Vec3, point: &SurfacePoint, boundary: &Boundary) -> Split {
    let (before, behind) = (boundary.before.index(), boundary.behind.index());
    let sides_agree = (direction.dot(point.geometric_normal) < 0.0) == (direction.dot(point.shading_normal) < 0.0);
    let (eta_i, eta_t) = if sides_agree { (before, behind) } else { (behind, before) };
    let normal = flipped(point.shading_normal, direction);
    let Some(refracted) = checked_refraction(direction, normal, eta_i, eta_t) else {
        return Split { reflectance: 1.0, refracted: None };
    };
    // Cosines are geometry: near the critical angle no two ways to compute one agree.
    let cos_i = -normal.dot(direction);
    let cos_t = refraction::cos_t(cos_i, eta_i, eta_t).expect("there is a refracted direction");
    let (eta_i, eta_t) = (f64::from(eta_i), f64::from(eta_t));
    let (cos_i, cos_t) = (f64::from(cos_i), f64::from(cos_t));
    let r0 = ((eta_i - eta_t) / (eta_i + eta_t)).powi(2);
    let reflectance = match surface.fresnel {
        FresnelModel::Exact => textbook::dielectric(cos_i, cos_t, eta_i, eta_t),
        FresnelModel::Schlick => textbook::schlick(cos_i, r0),
        // The larger angle has the smaller cosine.
        FresnelModel::SchlickThetaM => textbook::schlick(cos_i.min(cos_t), r0),
    };
    Split { reflectance, refracted: (reflectance < 1.0).then_some(refracted) }
}

/// A metal's reflectance, per channel; `eta_i` is the index of the medium before it, `r0` the color at normal incidence.
pub(crate) fn metal(surface: &Metal, cos_i: f64, eta_i: f32, r0: DVec3) -> DVec3 {
    let [eta, k, r90, f82] = [surface.eta, surface.k, surface.r90, surface.f82].map(|color| color.as_dvec3());
    let channel = |c: usize| match surface.fresnel {
        FresnelModel::Exact => textbook::conductor(cos_i, DVec2::new(eta[c], k[c]) / f64::from(eta_i)),
        FresnelModel::Schlick | FresnelModel::SchlickThetaM => textbook::tinted_schlick(cos_i, [r0[c], r90[c]], f82[c]),
    };
    DVec3::new(channel(0), channel(1), channel(2))
}

/// Phong's highlight about a direction.
pub(crate) fn highlight(toward: DVec3, about: DVec3, exponent: f32) -> f64 {
    toward.dot(about).clamp(0.0, 1.0).powf(exponent.into())
}
