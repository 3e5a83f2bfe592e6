//! Nested media as a plain list: what fills a place is the medium of highest priority, of equal ones the last entered.
//!
//! A medium is known by its material: solids of one material that overlap are one, and the boundary between them is none.

use brewster_buffers::Dielectric;
use glam::DVec3;

/// A row of the dielectric materials, and what stands in it.
pub(crate) type Medium = (usize, Dielectric);

/// The media that a place lies in, in the order in which they were entered.
#[derive(Clone, Debug, Default)]
pub(crate) struct Media(pub(crate) Vec<Medium>);

/// The media on the two sides of a boundary.
pub(crate) struct Boundary {
    pub(crate) before: Media,
    pub(crate) behind: Media,
}

impl Media {
    /// What a ray in these media crosses at a boundary of `medium`, inward or outward. One that leaves what it has never
    /// entered, through a surface that is not closed, counts as having been inside.
    pub(crate) fn boundary(&self, medium: Medium, inward: bool) -> Boundary {
        let mut other = self.clone();
        let entry = self.0.iter().rposition(|&(row, _)| row == medium.0);
        match entry {
            Some(place) if !inward => drop(other.0.remove(place)),
            _ => other.0.push(medium),
        }
        if inward || entry.is_some() {
            Boundary { before: self.clone(), behind: other }
        } else {
            Boundary { before: other, behind: self.clone() }
        }
    }

    /// The index of refraction.
    pub(crate) fn index(&self) -> f32 {
        self.filling().map_or(1.0, |(_, medium)| medium.ior)
    }

    /// What is left of light after a distance, which may be infinite.
    pub(crate) fn transmittance(&self, distance: f32) -> DVec3 {
        let Some((_, medium)) = self.filling() else { return DVec3::ONE };
        let left = |coefficient: f32| match coefficient {
            0.0 => 1.0,
            _ => (-f64::from(coefficient) * f64::from(distance)).exp(),
        };
        DVec3::from_array(medium.absorption.to_array().map(left))
    }

    fn filling(&self) -> Option<&Medium> {
        // Of equal maxima this is the last.
        self.0.iter().max_by_key(|(_, medium)| medium.priority)
    }
}

impl Boundary {
    /// Whether one medium fills both sides, so that there is nothing to see.
    pub(crate) fn is_none(&self) -> bool {
        self.before.filling().map(|medium| medium.0) == self.behind.filling().map(|medium| medium.0)
    }
}
