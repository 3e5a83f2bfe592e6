//! Formulas of the textbook in f64, for expected values.

use glam::DVec2;

/// Half a unit in f32's last place, relative: what one rounding of the tracer makes.
pub(crate) const ROUNDING: f64 = 1.0 / (1 << 24) as f64;

/// The reflectance of a dielectric for unpolarized light, by the cosine form; `cos_t` is the refracted ray's.
pub(crate) fn dielectric(cos_i: f64, cos_t: f64, eta_i: f64, eta_t: f64) -> f64 {
    if eta_i == eta_t {
        return 0.0;
    }
    let perpendicular = (eta_i * cos_i - eta_t * cos_t) / (eta_i * cos_i + eta_t * cos_t);
    let parallel = (eta_t * cos_i - eta_i * cos_t) / (eta_t * cos_i + eta_i * cos_t);
    0.5 * (perpendicular * perpendicular + parallel * parallel)
}

/// The same from the angle of incidence alone; 1 beyond the critical angle.
pub(crate) fn reflectance(cos_i: f64, eta_i: f64, eta_t: f64) -> f64 {
    let sine_squared = (eta_i / eta_t).powi(2) * (1.0 - cos_i * cos_i);
    if sine_squared >= 1.0 { 1.0 } else { dielectric(cos_i, (1.0 - sine_squared).sqrt(), eta_i, eta_t) }
}

/// Schlick's approximation.
pub(crate) fn schlick(cosine: f64, r0: f64) -> f64 {
    r0 + (1.0 - r0) * (1.0 - cosine).max(0.0).powi(5)
}

/// Schlick's curve from `r0` to `r90`, less a dip that leaves of it, at a cosine of 1/7, the part `f82` (F82-tint: Kutz, Hašan and
/// Edmondson 2021).
pub(crate) fn tinted_schlick(cosine: f64, [r0, r90]: [f64; 2], f82: f64) -> f64 {
    let dip = |cosine: f64| cosine * (1.0 - cosine).powi(6);
    let schlick = |cosine: f64| r0 + (r90 - r0) * (1.0 - cosine).max(0.0).powi(5);
    schlick(cosine) - schlick(1.0 / 7.0) * (1.0 - f82) * dip(cosine) / dip(1.0 / 7.0)
}

/// A conductor's reflectance from complex amplitudes: `index` is η + ik relative to the medium, as (real, imaginary).
pub(crate) fn conductor(cos_i: f64, index: DVec2) -> f64 {
    let sine_squared = 1.0 - cos_i * cos_i;
    // cos θt by Snell's law with a complex index: √(1 - sin²θ/n²).
    let cos_t = root(DVec2::X - divided(DVec2::new(sine_squared, 0.0), times(index, index)));
    let incident = DVec2::new(cos_i, 0.0);
    let perpendicular = divided(incident - times(index, cos_t), incident + times(index, cos_t));
    let parallel = divided(times(index, incident) - cos_t, times(index, incident) + cos_t);
    0.5 * (perpendicular.length_squared() + parallel.length_squared())
}

/// The product of two complex numbers.
fn times(a: DVec2, b: DVec2) -> DVec2 {
    DVec2::new(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x)
}

/// The quotient of two complex numbers.
fn divided(a: DVec2, b: DVec2) -> DVec2 {
    times(a, DVec2::new(b.x, -b.y)) / b.length_squared()
}

/// The root of a complex number that lies right of the imaginary axis.
fn root(a: DVec2) -> DVec2 {
    let (length, angle) = (a.length().sqrt(), a.to_angle() / 2.0);
    DVec2::new(angle.cos(), angle.sin()) * length
}
