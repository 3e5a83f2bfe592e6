//! Numbers, places and lights as text that is read back, but for some angles to the bit.

use std::collections::HashSet;

use brewster_world::components::{Falloff, Light};
use glam::{Affine3A, Vec3};

/// Names for things, each its own: those that they have, numbered where several have the same. What has none is called as told, and
/// numbered; nothing if that is empty.
pub(super) fn names<'n>(found: impl Iterator<Item = Option<&'n str>>, unnamed: &str) -> Vec<String> {
    let mut taken = HashSet::new();
    found
        .map(|name| {
            let wanted = name.filter(|name| !name.is_empty()).unwrap_or(unnamed);
            if wanted.is_empty() {
                return String::new();
            }
            let mut name = wanted.to_owned();
            let mut number = 2;
            while !taken.insert(name.clone()) {
                name = format!("{wanted} {number}");
                number += 1;
            }
            name
        })
        .collect()
}

/// `(x, y, z)`.
pub(super) fn triple(vector: Vec3) -> String {
    format!("({:?}, {:?}, {:?})", vector.x, vector.y, vector.z)
}

/// A color, gray as one number.
pub(super) fn color(color: Vec3) -> String {
    if color == Vec3::splat(color.x) { format!("{:?}", color.x) } else { triple(color) }
}

/// An angle in degrees that is that many radians again; where no f32 is, one that comes next to it.
pub(super) fn degrees(radians: f32) -> String {
    let near = radians.to_degrees();
    let candidates = [near, near.next_up(), near.next_down(), near.next_up().next_up(), near.next_down().next_down()];
    let exact = candidates.into_iter().find(|degrees| degrees.to_radians() == radians);
    format!("{:?}", exact.unwrap_or(near))
}

/// The three upper rows of a matrix.
pub(super) fn matrix(place: Affine3A) -> String {
    let Affine3A { matrix3: m, translation: t } = place;
    let row = |[x, y, z, t]: [f32; 4]| format!("({x:?}, {y:?}, {z:?}, {t:?})");
    let rows = [
        [m.x_axis.x, m.y_axis.x, m.z_axis.x, t.x],
        [m.x_axis.y, m.y_axis.y, m.z_axis.y, t.y],
        [m.x_axis.z, m.y_axis.z, m.z_axis.z, t.z],
    ];
    format!("({})", rows.map(row).join(", "))
}

/// The field that says where an entity is; none at the origin.
pub(super) fn place(place: Affine3A) -> Option<String> {
    if place == Affine3A::IDENTITY {
        None
    } else if place.matrix3 == glam::Mat3A::IDENTITY {
        Some(format!("at: {}", triple(place.translation.into())))
    } else {
        Some(format!("transform: {}", matrix(place)))
    }
}

/// A light.
pub(super) fn light(light: &Light) -> String {
    let falloff = |falloff: &Falloff| match falloff {
        Falloff::InverseSquare => String::new(),
        Falloff::Within(range) => format!(", falloff: InverseSquare(range: {range:?})"),
        Falloff::None => ", falloff: None".to_owned(),
    };
    match light {
        Light::Point { intensity, falloff: with } => {
            format!("Point(intensity: {}{})", color(*intensity), falloff(with))
        }
        Light::Directional { irradiance } => format!("Directional(irradiance: {})", color(*irradiance)),
        Light::Spot { intensity, inner_angle, outer_angle, falloff: with } => format!(
            "Spot(intensity: {}, inner_angle: {}, outer_angle: {}{})",
            color(*intensity),
            degrees(*inner_angle),
            degrees(*outer_angle),
            falloff(with)
        ),
        Light::Ambient { radiance } => format!("Ambient(radiance: {})", color(*radiance)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique() {
        let found = names([Some("a"), None, Some("a"), Some(""), Some("a 2")].into_iter(), "thing");
        assert_eq!(found, ["a", "thing", "a 2", "thing 2", "a 2 2"]);
        assert_eq!(names([None, Some("b")].into_iter(), ""), ["", "b"]);
    }

    /// Degrees are coarser than radians for one angle in ten: those come to a neighbor.
    #[test]
    fn angles_are_the_same_radians_again_or_their_neighbors() {
        for step in 0..1000 {
            let radians = step as f32 * 0.001_57;
            let again = degrees(radians).parse::<f32>().expect("a number").to_radians();
            assert!([radians.next_down(), radians, radians.next_up()].contains(&again), "{radians}");
        }
    }
}
