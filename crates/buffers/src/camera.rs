//! Where pictures are taken from.

use std::f32::consts::TAU;

use brewster_geometry::Ray;
use brewster_lanes::math;
use brewster_optics::warp;
use glam::{Vec2, Vec3};

use crate::motion::{around, turned};

/// A camera as columns of a frame: `right`, `up` and `forward` are unit vectors at right angles.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// The name an author chooses it by; empty where it has none.
    pub name: String,
    /// The eye, in meters.
    pub position: Vec3,
    /// To the right in the picture.
    pub right: Vec3,
    /// Up in the picture.
    pub up: Vec3,
    /// Along the view.
    pub forward: Vec3,
    /// How directions become pixels.
    pub projection: Projection,
    /// Radius of the lens in meters; 0 for a pinhole.
    pub aperture_radius: f32,
    /// Distance along `forward` that is sharp, in meters.
    pub focus_distance: f32,
    /// Blades of the aperture, a regular polygon with a corner at the top, 3 or more; 0 for a round one.
    pub blades: u32,
    /// The entity's scene key; rows are in its order.
    pub key: u64,
    /// Where it is at equal steps of the shutter's time, the first of them as above; empty if it stands still. Between two of
    /// them position and axes are interpolated, and the axes brought to right angles again.
    pub motion: Vec<CameraFrame>,
}

/// Where a camera is and how it is turned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraFrame {
    /// The eye, in meters.
    pub position: Vec3,
    /// To the right in the picture.
    pub right: Vec3,
    /// Up in the picture.
    pub up: Vec3,
    /// Along the view.
    pub forward: Vec3,
}

/// How directions become pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Lines through one point; the tangent of half the vertical angle of view.
    Perspective(f32),
    /// Parallel lines; half the height of the picture in meters.
    Orthographic(f32),
}

impl Camera {
    /// A place of the lens, which has radius 1, for two numbers 0 ≤ u < 1: evenly over the disk, or over the regular polygon
    /// of the blades, of which one corner points up.
    #[inline(always)]
    pub fn aperture(&self, u: Vec2) -> Vec2 {
        if self.blades == 0 {
            return warp::disk(u);
        }
        let blades = self.blades as f32;
        let blade = (u.x * blades).floor().min(blades - 1.0);
        let corner = |number: f32| {
            let (sine, cosine) = math::sin_cos(TAU * number / blades);
            Vec2::new(-sine, cosine)
        };
        let weights = warp::triangle(Vec2::new(u.x * blades - blade, u.y));
        corner(blade) * weights.x + corner(blade + 1.0) * weights.y
    }

    /// Where it is at a moment of the shutter, 0 ≤ time < 1.
    #[inline(always)]
    pub fn frame(&self, time: f32) -> CameraFrame {
        if self.motion.is_empty() {
            let &Camera { position, right, up, forward, .. } = self;
            return CameraFrame { position, right, up, forward };
        }
        // Taken apart, so that only a frame that moves passes through memory.
        let CameraFrame { position, right, up, forward } = self.moved_frame(time);
        CameraFrame { position, right, up, forward }
    }

    #[inline(never)]
    fn moved_frame(&self, time: f32) -> CameraFrame {
        let (from, to, s) = around(&self.motion, time);
        let position = from.position + (to.position - from.position) * s;
        if [from.right, from.up, from.forward] == [to.right, to.up, to.forward] {
            return CameraFrame { position, ..*from };
        }
        let forward = turned(from.forward, to.forward, s);
        let right = forward.cross(turned(from.up, to.up, s)).normalize();
        CameraFrame { position, right, up: right.cross(forward), forward }
    }

    /// The ray through a place of the picture and a place of the lens at a moment: `place` from (0, 0), the top left corner, to
    /// (1, 1); `aspect` is width over height; `lens` lies in the unit disk, in its middle for a pinhole.
    #[inline(always)]
    pub fn ray(&self, place: Vec2, aspect: f32, lens: Vec2, time: f32) -> Ray {
        self.ray_from(self.frame(time), place, aspect, lens, time)
    }

    /// [`Self::ray`] where the camera's frame at the moment is known.
    #[inline(always)]
    pub fn ray_from(&self, frame: CameraFrame, place: Vec2, aspect: f32, lens: Vec2, time: f32) -> Ray {
        let CameraFrame { position, right, up, forward } = frame;
        let x = (2.0 * place.x - 1.0) * aspect;
        let y = 1.0 - 2.0 * place.y;
        // The ray through the middle of the lens; its direction goes one meter forward.
        let (origin, direction) = match self.projection {
            Projection::Perspective(tangent) => (position, forward + right * (x * tangent) + up * (y * tangent)),
            Projection::Orthographic(half_height) => {
                (position + right * (x * half_height) + up * (y * half_height), forward)
            }
        };
        let aside = (right * lens.x + up * lens.y) * self.aperture_radius;
        let direction = direction - aside / self.focus_distance;
        Ray { origin: origin + aside, direction: direction / direction.dot(direction).sqrt(), time }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(projection: Projection) -> Camera {
        Camera {
            name: String::new(),
            position: Vec3::new(0.0, 1.0, 5.0),
            right: Vec3::X,
            up: Vec3::Y,
            forward: Vec3::NEG_Z,
            projection,
            aperture_radius: 0.0,
            focus_distance: 1.0,
            blades: 0,
            key: 0,
            motion: Vec::new(),
        }
    }

    #[test]
    fn corners_of_the_picture_look_where_they_should() {
        // A 90 degree view, twice as wide as high: the corners are at (∓2, ±1) one meter ahead.
        let perspective = camera(Projection::Perspective(1.0));
        for (place, toward) in [
            (Vec2::new(0.5, 0.5), Vec3::new(0.0, 0.0, -1.0)),
            (Vec2::new(0.0, 0.0), Vec3::new(-2.0, 1.0, -1.0)),
            (Vec2::new(1.0, 1.0), Vec3::new(2.0, -1.0, -1.0)),
            (Vec2::new(1.0, 0.5), Vec3::new(2.0, 0.0, -1.0)),
        ] {
            let ray = perspective.ray(place, 2.0, Vec2::ZERO, 0.0);
            assert_eq!(ray.origin, perspective.position);
            assert!((ray.direction - toward.normalize()).length() < 1e-6, "{place}: {}", ray.direction);
        }
        let orthographic = camera(Projection::Orthographic(3.0));
        let ray = orthographic.ray(Vec2::new(0.0, 1.0), 2.0, Vec2::ZERO, 0.0);
        assert_eq!((ray.origin, ray.direction), (Vec3::new(-6.0, -2.0, 5.0), Vec3::NEG_Z));
    }

    #[test]
    fn rays_through_any_place_of_the_lens_meet_in_the_plane_of_focus() {
        let place = Vec2::new(0.8, 0.3);
        for projection in [Projection::Perspective(0.7), Projection::Orthographic(2.0)] {
            let lens = Camera { aperture_radius: 0.25, focus_distance: 4.0, ..camera(projection) };
            let at_focus = |ray: Ray| ray.origin + ray.direction * (4.0 / ray.direction.dot(lens.forward));
            let middle = lens.ray(place, 1.5, Vec2::ZERO, 0.0);
            let focus = middle.origin + middle.direction * (4.0 / middle.direction.dot(lens.forward));
            for aside in [Vec2::X, Vec2::NEG_Y, Vec2::new(-0.6, 0.5)] {
                let ray = lens.ray(place, 1.5, aside, 0.0);
                let start = (ray.origin - middle.origin) / 0.25;
                assert!((start - Vec3::new(aside.x, aside.y, 0.0)).length() < 1e-5, "{start}");
                assert!((at_focus(ray) - focus).length() < 1e-5, "{projection:?} {aside}");
                assert!((ray.direction.length() - 1.0).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn apertures_are_filled_evenly() {
        // Of a regular hexagon of radius 1, area 3√3/2, the inscribed circle of radius √3/2 takes 3π/4.
        let hexagon = Camera { blades: 6, ..camera(Projection::Perspective(1.0)) };
        let steps = 200;
        let places =
            (0..steps * steps).map(|i| (Vec2::new((i % steps) as f32, (i / steps) as f32) + 0.5) / steps as f32);
        let (mut inside, mut sum) = (0, Vec2::ZERO);
        for place in places.map(|u| hexagon.aperture(u)) {
            assert!(place.length() <= 1.0 + 1e-6, "{place}");
            // With a corner at the top, two edges are upright.
            assert!(place.x.abs() <= 0.75f32.sqrt() + 1e-6, "{place}");
            inside += i32::from(place.length_squared() < 0.75);
            sum += place;
        }
        let count = (steps * steps) as f32;
        let share = 0.75 * std::f32::consts::PI / (1.5 * 3f32.sqrt());
        assert!((inside as f32 / count - share).abs() < 2e-3, "{}", inside as f32 / count);
        assert!(sum.length() / count < 2e-3, "{sum}");
    }
}
