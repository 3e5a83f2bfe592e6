//! Spheres, drawn by the cone of directions in which they are seen.

use std::f64::consts::{PI, TAU};

use brewster_geometry::Affine;
use brewster_optics::basis::Basis;
use brewster_optics::warp;
use glam::{DVec3, Vec2, Vec3};

/// What rounding makes of the squared distance of a point on a sphere from its middle, relative to the squared radius, at most: so
/// near to it a point counts as inside of a sphere that shines there.
const ON_IT: f64 = 1e-6;

/// A sphere in world space.
pub(super) struct PlacedSphere {
    center: DVec3,
    radius: f64,
}

impl PlacedSphere {
    pub(super) fn new(to_world: &Affine, radius: f64) -> PlacedSphere {
        let [x, y, z] = to_world.rows.map(|row| f64::from(row[3]));
        PlacedSphere { center: DVec3::new(x, y, z), radius }
    }

    /// A direction from a point, the sphere's outward normal where it meets it, and the density per solid angle. Nothing from
    /// inside, unless it shines there too: then any direction, of which those lead nowhere that leave from the sphere itself.
    #[inline]
    pub(super) fn sample(&self, point: Vec3, two_sided: bool, place: [f32; 2]) -> Option<(Vec3, Vec3, f64)> {
        let to_center = self.center - point.as_dvec3();
        let place = Vec2::from_array(place);
        let versine = self.versine(to_center, two_sided);
        let direction = match versine {
            Some(versine) => {
                let axis = to_center.normalize().as_vec3();
                Basis::around(axis).to_world(warp::cone(place, versine as f32))
            }
            None if two_sided => warp::sphere(place),
            None => return None,
        };
        let along = direction.as_dvec3().normalize();
        let middle = to_center.dot(along);
        // The distance from the line by a product that does not cancel where the sphere is far.
        let beside = to_center.cross(along).length_squared();
        let half = (self.radius * self.radius - beside).max(0.0).sqrt();
        let t = if versine.is_some() { middle - half } else { middle + half };
        if t < 1e-4 * self.radius && versine.is_none() {
            return None;
        }
        let normal = (along * t - to_center).normalize().as_vec3();
        Some((direction, normal, self.density(versine)))
    }

    /// The density of [`PlacedSphere::sample`] in directions that meet the sphere.
    #[inline]
    pub(super) fn pdf(&self, origin: Vec3, two_sided: bool) -> f64 {
        let versine = self.versine(self.center - origin.as_dvec3(), two_sided);
        if versine.is_none() && !two_sided { 0.0 } else { self.density(versine) }
    }

    #[inline(always)]
    fn density(&self, versine: Option<f64>) -> f64 {
        versine.map_or(0.25 / PI, |versine| 1.0 / (TAU * versine))
    }

    /// 1 - cosθ of the cone in which the sphere is seen, precise for small ones; none from inside.
    #[inline(always)]
    fn versine(&self, to_center: DVec3, two_sided: bool) -> Option<f64> {
        let squared_sine = self.radius * self.radius / to_center.length_squared();
        let limit = if two_sided { 1.0 - ON_IT } else { 1.0 };
        (squared_sine < limit).then(|| squared_sine / (1.0 + (1.0 - squared_sine).sqrt()))
    }
}
