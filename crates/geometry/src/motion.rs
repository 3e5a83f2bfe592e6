//! Instances that move while the shutter is open.
//!
//! A motion is a row of keys: maps from object to world space at equal steps of the shutter's time. Between two keys the
//! *matrix* is interpolated, so that every point of a shape moves along straight pieces: boxes around the shape at the keys
//! hold it at all times. What turns takes enough keys for that to look round. Rays are mapped by the inverse, which is computed
//! for each ray anew: inverses of neighbors cannot be interpolated.
//!
//! A still scene holds nothing of this, and an instance that stays where it is in one that moves takes the way of still ones.
//!
//! A shape moves as a whole. Vertices have no motion of their own, so skins and morph targets stand as they do when the shutter opens: a
//! mesh with two columns of vertices would need triangles of a second kind in every kernel. A patch of up to eight
//! vertices takes two cache lines, and is sheared once for a ray, or met by all rays of a packet with the same corners; with two moments
//! in it it takes four, and each ray of a packet has corners of its own. Surface points and the bounds on their errors, gradients of
//! textures, and areas of lamps, by which triangles are chosen, would depend on the time as well, and a joint that turns would still go
//! along one chord. Pictures of many moments (`--time`) show the same on average.

use std::sync::Arc;

use glam::DMat3;

use crate::transform::{Affine, TransformError};

/// How an instance moves.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    keys: Arc<[Affine]>,
}

/// Steps that a motion has at most.
const MOST_STEPS: usize = 1024;

impl Motion {
    /// A motion through maps from object to world space at equal steps, two or more. Steps that change a map much are divided:
    /// into pieces by less than half each.
    ///
    /// None if all are the same. An error if one of them has no inverse, or if space is flattened on the way between two.
    pub fn new(keys: &[Affine]) -> Result<Option<Motion>, TransformError> {
        keys.iter().try_for_each(|key| key.inverse().map(drop))?;
        let mut keys = keys.to_vec();
        if keys.windows(2).all(|pair| pair[0] == pair[1]) {
            return Ok(None);
        }
        while !keys.windows(2).all(|pair| is_gentle(&pair[0], &pair[1])) {
            if 2 * (keys.len() - 1) > MOST_STEPS {
                return Err(TransformError::FlatOnTheWay);
            }
            let halves = keys.windows(2).flat_map(|pair| [pair[0], between(&pair[0], &pair[1], 0.5)]);
            keys = halves.chain(keys.last().copied()).collect();
        }
        Ok(Some(Motion { keys: keys.into() }))
    }

    /// The maps from object to world space at equal steps: those it was made of, and those between where steps were divided.
    pub fn keys(&self) -> &[Affine] {
        &self.keys
    }
}

/// A + s (B - A).
#[inline(always)]
fn between(a: &Affine, b: &Affine, s: f32) -> Affine {
    let mut map = *a;
    for (row, to) in map.rows.iter_mut().zip(&b.rows) {
        for (x, to) in row.iter_mut().zip(to) {
            *x += (to - *x) * s;
        }
    }
    map
}

/// The norm of a matrix that goes with the largest coordinate of vectors.
fn norm(matrix: DMat3) -> f64 {
    [matrix.row(0), matrix.row(1), matrix.row(2)].map(|row| row.abs().element_sum()).into_iter().fold(0.0, f64::max)
}

/// Whether a step from A to B changes A by less than half: ‖(B - A) A⁻¹‖ ≤ ½. Then no map on the way flattens space, and the
/// inverses are at most (I + s (B - A) A⁻¹)⁻¹, of norm 2, times A⁻¹.
fn is_gentle(a: &Affine, b: &Affine) -> bool {
    let ((from, _), (to, _)) = (a.to_f64(), b.to_f64());
    norm((to - from) * from.inverse()) <= 0.5
}

/// Where an instance is at one moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// From object to world space.
    pub object_to_world: Affine,
    /// The inverse.
    pub world_to_object: Affine,
}

/// Which instances move, and how: a table beside that of the instances, empty where none does.
///
/// One writer; rows hold until it rewrites them. Takes 4 bytes an instance and 48 a key where anything moves.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Motions {
    /// The row of every instance, or [`STILL`].
    rows: Vec<u32>,
    spans: Vec<Span>,
    keys: Vec<Affine>,
}

/// The keys of one instance.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Span {
    first: u32,
    /// One less than there are keys.
    steps: u32,
}

/// Stands for a row where an instance does not move.
const STILL: u32 = u32::MAX;

impl Motions {
    /// No motion.
    pub const NONE: &Motions = &Motions { rows: Vec::new(), spans: Vec::new(), keys: Vec::new() };

    /// The motions of instances in their order.
    pub fn new<'a>(motions: impl IntoIterator<Item = Option<&'a Motion>>) -> Motions {
        let mut table = Motions::default();
        for motion in motions {
            table.rows.push(motion.map_or(STILL, |_| table.spans.len() as u32));
            if let Some(motion) = motion {
                table.spans.push(Span { first: table.keys.len() as u32, steps: motion.keys.len() as u32 - 1 });
                table.keys.extend_from_slice(&motion.keys);
            }
        }
        if table.spans.is_empty() { Motions::default() } else { table }
    }

    /// Whether nothing moves.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Whether the table is for that many instances.
    pub fn fits(&self, instances: usize) -> bool {
        self.rows.is_empty() || self.rows.len() == instances
    }

    /// Writes the motion of an instance over the one that stood there. False if it needs another number of keys: then the table
    /// has to be made anew.
    #[must_use]
    pub fn set(&mut self, instance: u32, motion: Option<&Motion>) -> bool {
        let old = self.span(instance);
        match (old, motion) {
            (None, None) => true,
            (Some(Span { first, steps }), Some(motion)) if steps as usize + 1 == motion.keys.len() => {
                self.keys[first as usize..][..motion.keys.len()].copy_from_slice(&motion.keys);
                true
            }
            _ => false,
        }
    }

    /// The keys of an instance; none if it does not move.
    pub fn keys(&self, instance: u32) -> Option<&[Affine]> {
        let Span { first, steps } = self.span(instance)?;
        Some(&self.keys[first as usize..][..=steps as usize])
    }

    /// Where an instance is at a moment, 0 ≤ time < 1; none if it does not move.
    #[inline(always)]
    pub fn at(&self, instance: u32, time: f32) -> Option<Place> {
        self.span(instance).map(|span| self.place(span, time))
    }

    /// The maps of an instance at a moment, from object to world space and back: those it has when it is still, or others, that
    /// `moved` keeps.
    #[inline(always)]
    pub fn maps_at<'p>(
        &self,
        instance: u32,
        time: f32,
        still: [&'p [Affine]; 2],
        moved: &'p mut Option<Place>,
    ) -> (&'p Affine, &'p Affine) {
        *moved = self.at(instance, time);
        match moved {
            Some(Place { object_to_world, world_to_object }) => (object_to_world, world_to_object),
            None => (&still[0][instance as usize], &still[1][instance as usize]),
        }
    }

    #[inline(always)]
    fn span(&self, instance: u32) -> Option<Span> {
        let row = *self.rows.get(instance as usize)?;
        (row != STILL).then(|| self.spans[row as usize])
    }

    #[inline(never)]
    fn place(&self, Span { first, steps }: Span, time: f32) -> Place {
        let passed = time * steps as f32;
        let step = (passed as usize).min(steps as usize - 1);
        let keys = &self.keys[first as usize + step..][..2];
        let object_to_world = between(&keys[0], &keys[1], passed - step as f32);
        let (linear, translation) = object_to_world.to_f64();
        let inverse = linear.inverse();
        Place { object_to_world, world_to_object: Affine::from_f64(&inverse, -(inverse * translation)) }
    }

    /// Checks the table; returns the first broken promise.
    pub(crate) fn validate(&self, instances: usize) -> Result<(), String> {
        if !self.fits(instances) {
            return Err(format!("motions of {} instances beside {instances}", self.rows.len()));
        }
        for instance in 0..instances as u32 {
            let Some(keys) = self.keys(instance) else { continue };
            let is_sound = |key: &Affine| key.inverse().is_ok();
            if !(keys.iter().all(is_sound) && keys.windows(2).all(|pair| is_gentle(&pair[0], &pair[1]))) {
                return Err(format!("the motion of instance {instance} cannot be interpolated"));
            }
        }
        Ok(())
    }
}

/// What bounds the maps of the step between two keys: the absolute values of their linear parts, and those of the inverses' at most
/// times a matrix whose rows sum up to no more than 1.
pub(crate) fn reach_of_step(key: &Affine, next: &Affine) -> [DMat3; 2] {
    let [from, to] = [key, next].map(|map| map.to_f64().0);
    let column = |i: usize| from.col(i).abs().max(to.col(i).abs());
    [DMat3::from_cols(column(0), column(1), column(2)), from.inverse().abs() * 2.0]
}
