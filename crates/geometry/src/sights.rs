//! How points that were drawn look from where they were drawn for.

use brewster_lanes::{Level, dispatch};
use glam::{Vec2, Vec3};

use crate::block::{LANES, Numbers};
use crate::sampling::{AreaSample, area_scale, seen_from};
use crate::shape::LocalSurface;
use crate::surface::SurfacePoint;
use crate::transform::Affine;

/// A drawn point, as a viewer sees it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sight {
    /// The point in world space, by [`seen_from`].
    pub surface: SurfacePoint,
    /// Unit direction from the viewer; NaN if the viewer is there.
    pub direction: Vec3,
    /// The squared distance from the viewer, in square meters.
    pub squared: f32,
    /// The cosine between the normal and the direction back to the viewer.
    pub cosine: f32,
    /// What a density by area in object space is multiplied by to be one per solid angle.
    pub per_area: f64,
}

/// A drawn point as a viewer sees it.
#[inline(always)]
pub fn sight(viewer: Vec3, object_to_world: &Affine, world_to_object: &Affine, sample: &AreaSample) -> Sight {
    let surface = seen_from(viewer, object_to_world, world_to_object, sample);
    let to = surface.position - viewer;
    let squared = to.length_squared();
    let direction = to / squared.sqrt();
    let cosine = -direction.dot(surface.geometric_normal);
    let per_area = per_solid_angle(object_to_world, surface.geometric_normal, squared, cosine);
    Sight { surface, direction, squared, cosine, per_area }
}

/// What a density by area in object space is multiplied by to be one per solid angle, for a surface of this normal in world space
/// that is seen at this cosine from this squared distance.
#[inline(always)]
pub fn per_solid_angle(object_to_world: &Affine, normal: Vec3, squared: f32, cosine: f32) -> f64 {
    f64::from(squared) / (f64::from(cosine.abs()) * area_scale(object_to_world, normal))
}

/// Where the numbers of a drawn point stand in a block.
const TO_WORLD: usize = 0;
const TO_OBJECT: usize = TO_WORLD + 12;
const VIEWER: usize = TO_OBJECT + 12;
const NUMBERS: usize = VIEWER + 3;
const POINT: usize = 0;
const NORMAL: usize = POINT + 3;
const TILT: usize = NORMAL + 3;
const WIDE_NUMBERS: usize = TILT + 1;

/// Where the numbers of a [`Sight`] stand in a block.
const POSITION: usize = 0;
const OUTWARD: usize = POSITION + 3;
const DIRECTION: usize = OUTWARD + 3;
const ERROR: usize = DIRECTION + 3;
const SQUARED: usize = ERROR + 1;
const COSINE: usize = SQUARED + 1;
const FOUND: usize = COSINE + 1;

/// Drawn points that wait until there are enough of them to be looked at at once: [`sight`] as vector code.
#[derive(Debug, Default)]
pub struct Sights {
    numbers: Numbers<f32, NUMBERS>,
    wide: Numbers<f64, WIDE_NUMBERS>,
    uvs: [Vec2; LANES],
    found: Numbers<f32, FOUND>,
    per_area: [f64; LANES],
    len: usize,
}

impl Sights {
    /// How many can wait.
    pub const CAPACITY: usize = LANES;

    /// How many wait.
    #[inline(always)]
    #[expect(clippy::len_without_is_empty, reason = "what matters is whether they are full")]
    pub fn len(&self) -> usize {
        self.len
    }

    /// Adds a point; panics if [`Sights::CAPACITY`] of them wait.
    #[inline(always)]
    pub fn push(&mut self, viewer: Vec3, object_to_world: &Affine, world_to_object: &Affine, sample: &AreaSample) {
        let lane = self.len;
        self.numbers.put_map(TO_WORLD, lane, object_to_world);
        self.numbers.put_map(TO_OBJECT, lane, world_to_object);
        self.numbers.put(VIEWER, lane, viewer.to_array());
        self.wide.put(POINT, lane, sample.local.point.to_array());
        self.wide.put(NORMAL, lane, sample.local.normal.to_array());
        self.wide.put(TILT, lane, [sample.tilt]);
        self.uvs[lane] = sample.local.uv;
        self.len += 1;
    }

    /// Looks at all that wait, and calls with each in turn; none waits afterwards.
    #[inline]
    pub fn look(&mut self, level: Level, mut seen: impl FnMut(usize, &Sight)) {
        look(level, &self.numbers, &self.wide, &mut self.found, &mut self.per_area);
        for lane in 0..std::mem::take(&mut self.len) {
            let (found, normal) = (&self.found, self.found.vector(OUTWARD, lane));
            let surface = SurfacePoint {
                position: found.vector(POSITION, lane),
                geometric_normal: normal,
                shading_normal: normal,
                uv: self.uvs[lane],
                error: found.0[ERROR][lane],
            };
            let [squared, cosine] = found.take(SQUARED, lane);
            let per_area = self.per_area[lane];
            seen(lane, &Sight { surface, direction: found.vector(DIRECTION, lane), squared, cosine, per_area });
        }
    }
}

dispatch! {
    fn look<'a>(
        numbers: &'a Numbers<f32, NUMBERS>,
        wide: &'a Numbers<f64, WIDE_NUMBERS>,
        found: &'a mut Numbers<f32, FOUND>,
        per_area: &'a mut [f64; LANES],
    ) {
        for (lane, per_area) in per_area.iter_mut().enumerate() {
            let (point, normal) = (wide.vector(POINT, lane), wide.vector(NORMAL, lane));
            let local = LocalSurface { point, normal, uv: Vec2::ZERO };
            let sample = AreaSample { local, primitive: 0, tilt: wide.0[TILT][lane] };
            let (to_world, to_object) = (numbers.map(TO_WORLD, lane), numbers.map(TO_OBJECT, lane));
            let sight = sight(numbers.vector(VIEWER, lane), &to_world, &to_object, &sample);
            found.put(POSITION, lane, sight.surface.position.to_array());
            found.put(OUTWARD, lane, sight.surface.geometric_normal.to_array());
            found.put(DIRECTION, lane, sight.direction.to_array());
            found.put(ERROR, lane, [sight.surface.error, sight.squared, sight.cosine]);
            *per_area = sight.per_area;
        }
    }
}
