//! Rays: one as a row, many as columns.

use glam::Vec3;

/// A half line. In world space the direction has unit length and t is in meters; in object space t keeps its meaning, so the
/// direction has whatever length the transform gives it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it starts; the start itself is never hit.
    pub origin: Vec3,
    /// Where it goes.
    pub direction: Vec3,
    /// When it looks, 0 ≤ time < 1 of the shutter's time: where it meets what moves.
    pub time: f32,
}

impl Ray {
    /// The point at distance t.
    #[inline(always)]
    pub fn at(&self, t: f32) -> Vec3 {
        self.origin + self.direction * t
    }
}

/// Rays as columns of one length, borrowed from whatever queue holds them.
#[derive(Clone, Copy, Debug)]
pub struct Rays<'a> {
    /// x, y and z of the origins.
    pub origin: [&'a [f32]; 3],
    /// x, y and z of the directions.
    pub direction: [&'a [f32]; 3],
    /// When they look. May be empty: then all look when the shutter opens.
    pub time: &'a [f32],
}

impl<'a> Rays<'a> {
    /// The number of rays.
    #[inline(always)]
    pub fn len(&self) -> usize {
        self.origin[0].len()
    }

    /// Whether there are none.
    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Ray `index`; panics beyond the end.
    #[inline(always)]
    pub fn get(&self, index: usize) -> Ray {
        let row = |columns: &[&[f32]; 3]| Vec3::new(columns[0][index], columns[1][index], columns[2][index]);
        Ray { origin: row(&self.origin), direction: row(&self.direction), time: self.time_of(index) }
    }

    /// When ray `index` looks.
    #[inline(always)]
    pub(crate) fn time_of(&self, index: usize) -> f32 {
        self.time.get(index).copied().unwrap_or(0.0)
    }

    /// The rays of a range; panics beyond the end.
    pub fn slice(&self, range: std::ops::Range<usize>) -> Rays<'a> {
        Rays {
            origin: self.origin.map(|column| &column[range.clone()]),
            direction: self.direction.map(|column| &column[range.clone()]),
            time: if self.time.is_empty() { &[] } else { &self.time[range] },
        }
    }
}
