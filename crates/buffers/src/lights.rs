//! Lights without extent.

use brewster_lanes::columns;
use glam::Vec3;

/// The kinds of light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u8)]
pub enum LightKind {
    /// From a point, weakened by the squared distance. A spot is one with a cone.
    Point,
    /// From a point, not weakened by distance.
    PointWithoutFalloff,
    /// Parallel.
    Directional,
}

columns! {
    /// A light without extent.
    pub struct Light => LightColumns, LightsView, LightsViewMut {
        /// Which kind.
        pub kind: LightKind,
        /// World position in meters; zero for directional light.
        pub position: Vec3,
        /// Unit direction in which the light travels, or the axis of its cone.
        pub direction: Vec3,
        /// Radiant intensity in candela; for directional light irradiance in lux, without falloff irradiance too.
        pub intensity: Vec3,
        /// 1/(cos inner - cos outer) of the cone; zero where there is none.
        pub cone_scale: f32,
        /// Added to the scaled cosine; the square of the sum, clamped to 0..1, is the cone's factor. One where there is none.
        pub cone_offset: f32,
        /// Where its light has come to nothing, in meters; infinite where that is nowhere. Of points that are weakened by distance.
        pub range: f32,
        /// The entity's scene key; rows are in its order.
        pub key: u64,
    }
}

/// One light as a point sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Illumination {
    /// Unit direction toward the light.
    pub direction: Vec3,
    /// Distance in meters; infinite for directional light.
    pub distance: f32,
    /// Irradiance on a plane that faces the light, nothing in between.
    pub irradiance: Vec3,
}

/// A place of a light that was drawn to be asked for its light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightSample {
    /// Unit direction toward it.
    pub direction: Vec3,
    /// How far a ray from the point may go without meeting the light itself, in meters; infinite for what comes from afar. A
    /// ray that starts off its surface asks [`LightSample::ray_from`].
    pub distance: f32,
    /// The end of such rays: where the light is, or just off its surface. Zero for what comes from afar.
    pub target: Vec3,
    /// Radiance in nit; of a light without extent the irradiance on a plane that faces it, nothing in between.
    pub radiance: Vec3,
    /// Density per solid angle, above 0, with the probability of having chosen this light in it; of a light without extent
    /// that probability alone.
    pub pdf: f32,
    /// Whether the light has no extent: no ray meets it by chance.
    pub is_delta: bool,
}

impl LightSample {
    /// Light with extent that comes from afar.
    #[inline(always)]
    pub(crate) fn distant(direction: Vec3, radiance: Vec3, pdf: f32) -> LightSample {
        LightSample { direction, distance: f32::INFINITY, target: Vec3::ZERO, radiance, pdf, is_delta: false }
    }
}

impl Light {
    /// The light as `point` sees it; black where the point is the light's own.
    #[inline(always)]
    pub fn illuminate(&self, point: Vec3) -> Illumination {
        if self.kind == LightKind::Directional {
            return Illumination { direction: -self.direction, distance: f32::INFINITY, irradiance: self.intensity };
        }
        let to_light = self.position - point;
        let squared = to_light.length_squared();
        if squared == 0.0 {
            return Illumination { direction: -self.direction, distance: 0.0, irradiance: Vec3::ZERO };
        }
        let distance = squared.sqrt();
        let direction = to_light / distance;
        let ramp = (-direction.dot(self.direction) * self.cone_scale + self.cone_offset).clamp(0.0, 1.0);
        // The window that KHR_lights_punctual recommends: 1 - (d/range)⁴.
        let part = squared / (self.range * self.range);
        let window = (1.0 - part * part).max(0.0);
        let falloff = if self.kind == LightKind::Point { squared } else { 1.0 };
        Illumination { direction, distance, irradiance: self.intensity * (ramp * ramp * window / falloff) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAMP: Light = Light {
        kind: LightKind::Point,
        position: Vec3::new(0.0, 3.0, 0.0),
        direction: Vec3::NEG_Y,
        intensity: Vec3::new(8.0, 4.0, 2.0),
        cone_scale: 0.0,
        cone_offset: 1.0,
        range: f32::INFINITY,
        key: 0,
    };

    #[test]
    fn a_point_light_weakens_by_the_squared_distance() {
        let seen = LAMP.illuminate(Vec3::new(0.0, 1.0, 0.0));
        assert_eq!(seen, Illumination { direction: Vec3::Y, distance: 2.0, irradiance: Vec3::new(2.0, 1.0, 0.5) });
        let constant = Light { kind: LightKind::PointWithoutFalloff, ..LAMP };
        assert_eq!(constant.illuminate(Vec3::ZERO).irradiance, LAMP.intensity);
        assert_eq!(LAMP.illuminate(LAMP.position).irradiance, Vec3::ZERO);
    }

    /// At half its range 1/16 of the light is missing, at all of it and beyond all.
    #[test]
    fn a_range_ends_light_softly() {
        let lamp = Light { range: 4.0, ..LAMP };
        for (distance, part) in [(2.0, 0.9375), (4.0, 0.0), (5.0, 0.0)] {
            let seen = lamp.illuminate(LAMP.position - Vec3::Y * distance).irradiance;
            assert_eq!(seen, LAMP.intensity * (part / (distance * distance)), "{distance}");
        }
    }

    #[test]
    fn a_directional_light_is_the_same_everywhere() {
        let sun = Light { kind: LightKind::Directional, ..LAMP };
        let seen = sun.illuminate(Vec3::new(5.0, -7.0, 100.0));
        assert_eq!((seen.direction, seen.irradiance), (Vec3::Y, LAMP.intensity));
        assert_eq!(seen.distance, f32::INFINITY);
    }

    #[test]
    fn a_cone_ramps_from_its_inner_to_its_outer_angle() {
        // cos inner = 1, cos outer = 0.5: at cosine 0.75 the ramp is one half, its square a quarter.
        let spot = Light { cone_scale: 2.0, cone_offset: -1.0, ..LAMP };
        let at = |cosine: f32| {
            let direction = Vec3::new((1.0 - cosine * cosine).sqrt(), -cosine, 0.0);
            spot.illuminate(spot.position + 2.0 * direction).irradiance.x / 2.0
        };
        for (cosine, factor) in [(1.0, 1.0), (0.75, 0.25), (0.5, 0.0), (0.3, 0.0), (-1.0, 0.0)] {
            assert!((at(cosine) - factor).abs() < 1e-5, "cosine {cosine}: {} instead of {factor}", at(cosine));
        }
    }
}
