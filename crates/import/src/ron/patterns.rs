//! Where the instances of an entity are.

use glam::{Affine3A, Mat3, Vec3};

use crate::diagnostics::Code;
use crate::hash::unit;
use crate::limits::Budget;
use crate::session::Session;

use super::convert::{self, Place};
use super::schema::{self, Pattern};
use super::values::{Either, Spanned};

/// The places, in order. Their number is taken from the scene's entities before the places are worked out.
pub(crate) fn places(
    session: &mut Session,
    budget: &mut Budget,
    instances: &Spanned<Either<Vec<schema::Placement>, Pattern>>,
) -> Option<Vec<Affine3A>> {
    let count = match &instances.value {
        Either::Plain(list) => list.len() as u64,
        Either::Choice(Pattern::Grid { count, .. }) => {
            count.iter().fold(1, |product: u64, &along| product.saturating_mul(u64::from(along)))
        }
        Either::Choice(Pattern::Scatter { count, .. }) => u64::from(*count),
    };
    if let Err(exceeded) = budget.take(count) {
        session.error(Code::Limit, instances.span, format!("{count} instances are too many: {exceeded}"));
        return None;
    }
    match &instances.value {
        Either::Plain(list) => Some(list.iter().map(|placement| placed(session, placement)).collect()),
        Either::Choice(Pattern::Grid { count, spacing }) => Some(grid(*count, *spacing)),
        Either::Choice(Pattern::Scatter { scale: [low, high], .. }) if low > high => {
            session.error(Code::Conflict, instances.span, format!("`scale` goes from {low} down to {high}"));
            None
        }
        Either::Choice(Pattern::Scatter { count, seed, size, turn, scale }) => {
            let at = |index| scattered(u64::from(index), *seed, *size, *turn, *scale);
            Some((0..*count).map(at).collect())
        }
    }
}

fn placed(session: &mut Session, placement: &schema::Placement) -> Affine3A {
    let schema::Placement { at, rotate, scale, transform, .. } = placement;
    let place = Place { at: *at, rotate: rotate.as_ref(), scale: *scale, look_at: None, transform: transform.as_ref() };
    convert::place(session, &place)
}

/// x runs fastest, then y, then z.
fn grid(count: [u32; 3], spacing: Vec3) -> Vec<Affine3A> {
    let middle = Vec3::from(count.map(|along| (along - 1) as f32)) * 0.5;
    let mut places = Vec::with_capacity(count.iter().map(|&along| along as usize).product());
    for z in 0..count[2] {
        for y in 0..count[1] {
            for x in 0..count[0] {
                let step = Vec3::new(x as f32, y as f32, z as f32) - middle;
                places.push(Affine3A::from_translation(step * spacing));
            }
        }
    }
    places
}

/// One place of many, by its number alone: more instances leave the first ones where they are.
fn scattered(index: u64, seed: u64, size: Vec3, turn: f32, [low, high]: [f32; 2]) -> Affine3A {
    let random = |dimension| unit(seed, index, dimension);
    let at = (Vec3::new(random(0), random(1), random(2)) - 0.5) * size;
    let rotation = convert::about(Vec3::Y, turn * random(3));
    let scale = low + (high - low) * random(4);
    Affine3A::from_mat3_translation(rotation * Mat3::from_diagonal(Vec3::splat(scale)), at)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_grid_is_centered() {
        let places: Vec<Vec3> =
            grid([3, 1, 2], Vec3::new(2.0, 9.0, 1.0)).iter().map(|place| place.translation.into()).collect();
        let row = |z| [-2.0, 0.0, 2.0].map(|x| Vec3::new(x, 0.0, z));
        assert_eq!(places, [row(-0.5), row(0.5)].concat());
    }

    #[test]
    fn scattered_places_stay_in_their_box_and_depend_on_the_seed() {
        let size = Vec3::new(4.0, 0.0, 2.0);
        let at = |index, seed| scattered(index, seed, size, 360.0, [0.5, 2.0]);
        for index in 0..1000 {
            let place = at(index, 7);
            let translation = Vec3::from(place.translation);
            assert!((translation.abs() * 2.0).cmple(size).all(), "{translation}");
            let scale = place.matrix3.determinant().powf(1.0 / 3.0);
            assert!((0.4999..2.0001).contains(&scale), "{scale}");
        }
        assert_eq!(at(3, 7), at(3, 7));
        assert_ne!(at(3, 7), at(3, 8));
    }
}
