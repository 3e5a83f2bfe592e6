//! The media around a ray: which transparent solids it is inside of, in the order in which it entered them.
//!
//! Where solids overlap, the medium of the highest priority fills the place; at equal priority the one entered last. A
//! boundary of a solid that does not fill the place on either side is none: the ray crosses it unchanged
//! (Schmidt and Budge 2002, "Simple nested dielectrics in ray traced images").

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

use brewster_buffers::{DielectricsView, SceneBuffers};
use brewster_geometry::{Hit, HitColumns, Rays, SurfacePoint, closest_hits, offset_origin, surface};
use brewster_lanes::Level;
use brewster_optics::absorption::transmittance;
use brewster_optics::dispersion::PathWavelength;
use glam::Vec3;

/// A set of media in the order in which they were entered: a row of [`MediaStacks`]. Holds within one batch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct MediaId(pub u32);

impl MediaId {
    /// No medium: vacuum.
    pub const VACUUM: MediaId = MediaId(0);
}

/// Row of the dielectrics whose inside a place is filled with, or [`Medium::VACUUM`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Medium(pub u32);

impl Medium {
    /// No medium.
    pub const VACUUM: Medium = Medium(u32::MAX);

    /// Its index of refraction, at the d line where it depends on the wavelength.
    #[inline(always)]
    pub fn ior(self, dielectrics: &DielectricsView<'_>) -> f32 {
        self.ior_at(PathWavelength::NONE, dielectrics)
    }

    /// Its index of refraction for a path.
    #[inline(always)]
    pub fn ior_at(self, wavelength: PathWavelength, dielectrics: &DielectricsView<'_>) -> f32 {
        if self == Medium::VACUUM {
            return 1.0;
        }
        let row = self.0 as usize;
        match (dielectrics.dispersion[row], wavelength.get()) {
            (Some(index), Some(wavelength)) => index.ior_at(wavelength.nanometers),
            _ => dielectrics.ior[row],
        }
    }

    /// Whether its index depends on the wavelength.
    #[inline(always)]
    pub fn disperses(self, dielectrics: &DielectricsView<'_>) -> bool {
        self != Medium::VACUUM && dielectrics.dispersion[self.0 as usize].is_some()
    }

    /// The part of light that is neither absorbed nor scattered after a distance in it, which may be infinite.
    #[inline(always)]
    pub fn transmittance(self, distance: f32, dielectrics: &DielectricsView<'_>) -> Vec3 {
        if self == Medium::VACUUM {
            return Vec3::ONE;
        }
        let row = self.0 as usize;
        transmittance(dielectrics.absorption[row] + dielectrics.scattering[row], distance)
    }
}

#[derive(Clone, Copy, Debug)]
struct Node {
    /// The media before the last one was entered.
    outside: MediaId,
    /// The medium entered last.
    entered: Medium,
    /// The medium that fills the place.
    filling: Medium,
    /// The filling medium's priority; the lowest for vacuum.
    priority: i32,
}

/// All sets of media that the rays of a batch are in, each stored once, so that a ray carries four bytes however deeply
/// solids are nested.
///
/// Owned by one batch, which resets it before it starts; it grows with the number of distinct sets, not of rays, and keeps
/// its memory. Ids of an earlier batch are stale.
#[derive(Debug)]
pub struct MediaStacks {
    nodes: Vec<Node>,
    children: HashMap<(u32, u32), MediaId, BuildHasherDefault<PairHasher>>,
}

impl Default for MediaStacks {
    fn default() -> Self {
        let vacuum =
            Node { outside: MediaId::VACUUM, entered: Medium::VACUUM, filling: Medium::VACUUM, priority: i32::MIN };
        MediaStacks { nodes: vec![vacuum], children: HashMap::default() }
    }
}

/// What lies on the two sides of a boundary.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Boundary {
    /// The media behind it.
    pub behind: MediaId,
    /// The medium that fills the place in front of it.
    pub filling_before: Medium,
    /// The medium that fills the place behind it.
    pub filling_behind: Medium,
}

impl Boundary {
    /// The indices `[eta_i, eta_t]` for the Fresnel equations. Media lie on the sides of the geometric normal; which of the two
    /// light comes from says the shading normal.
    #[inline(always)]
    pub fn indices(&self, direction: Vec3, point: &SurfacePoint, dielectrics: &DielectricsView<'_>) -> [f32; 2] {
        let [before, behind] = [self.filling_before, self.filling_behind].map(|medium| medium.ior(dielectrics));
        let inward = |normal: Vec3| direction.dot(normal) < 0.0;
        if inward(point.geometric_normal) == inward(point.shading_normal) { [before, behind] } else { [behind, before] }
    }
}

impl MediaStacks {
    /// Forgets all sets.
    pub fn reset(&mut self) {
        self.nodes.truncate(1);
        self.children.clear();
    }

    /// The medium that fills the place.
    #[inline]
    pub fn filling(&self, media: MediaId) -> Medium {
        self.nodes[media.0 as usize].filling
    }

    /// The set after a medium was entered.
    pub fn enter(&mut self, media: MediaId, medium: Medium, dielectrics: &DielectricsView<'_>) -> MediaId {
        if let Some(&child) = self.children.get(&(media.0, medium.0)) {
            return child;
        }
        let outside = self.nodes[media.0 as usize];
        let own = dielectrics.priority[medium.0 as usize];
        let fills = outside.filling == Medium::VACUUM || own >= outside.priority;
        let (filling, priority) = if fills { (medium, own) } else { (outside.filling, outside.priority) };
        let child = MediaId(self.nodes.len() as u32);
        self.nodes.push(Node { outside: media, entered: medium, filling, priority });
        self.children.insert((media.0, medium.0), child);
        child
    }

    /// The set after a medium was left: without its last entry, or unchanged if it was never entered.
    pub fn leave(&mut self, media: MediaId, medium: Medium, dielectrics: &DielectricsView<'_>) -> MediaId {
        let mut at = media;
        let mut above = 0;
        while self.nodes[at.0 as usize].entered != medium {
            if at == MediaId::VACUUM {
                return media;
            }
            at = self.nodes[at.0 as usize].outside;
            above += 1;
        }
        // Enter again what had been entered after it, in the same order.
        let mut left = self.nodes[at.0 as usize].outside;
        for skip in (0..above).rev() {
            let mut node = media;
            for _ in 0..skip {
                node = self.nodes[node.0 as usize].outside;
            }
            left = self.enter(left, self.nodes[node.0 as usize].entered, dielectrics);
        }
        left
    }

    /// What a ray with these media finds at a boundary of `medium`, which it crosses inward or outward.
    ///
    /// A ray that leaves a medium it never entered (through a surface that is not closed) counts as having been inside.
    pub fn boundary(
        &mut self,
        media: MediaId,
        medium: Medium,
        inward: bool,
        dielectrics: &DielectricsView<'_>,
    ) -> Boundary {
        let filling_before = self.filling(media);
        if inward {
            let behind = self.enter(media, medium, dielectrics);
            return Boundary { behind, filling_before, filling_behind: self.filling(behind) };
        }
        let behind = self.leave(media, medium, dielectrics);
        let filling_behind = self.filling(behind);
        let never_entered = behind == media;
        let fills = never_entered
            && (filling_before == Medium::VACUUM
                || dielectrics.priority[medium.0 as usize] >= self.nodes[media.0 as usize].priority);
        Boundary { behind, filling_before: if fills { medium } else { filling_before }, filling_behind }
    }

    /// The media of a set in the order in which they were entered.
    pub fn entered(&self, media: MediaId) -> Vec<Medium> {
        let (mut entered, mut at) = (Vec::new(), media);
        while at != MediaId::VACUUM {
            let node = self.nodes[at.0 as usize];
            entered.push(node.entered);
            at = node.outside;
        }
        entered.reverse();
        entered
    }

    /// Enters media one after the other, from vacuum.
    pub fn enter_all(&mut self, entered: &[Medium], dielectrics: &DielectricsView<'_>) -> MediaId {
        entered.iter().fold(MediaId::VACUUM, |media, &medium| self.enter(media, medium, dielectrics))
    }
}

/// The media that a point is inside of at a moment of the shutter, the outermost first: found by a ray that follows one direction to the end and
/// counts the boundaries of dielectrics that it leaves without having entered them.
pub fn media_around(scene: &SceneBuffers, point: Vec3, time: f32, level: Level) -> Vec<Medium> {
    let geometry = scene.geometry();
    // No axis of symmetry of anything likely: edges and tangents are met by chance only.
    let direction = Vec3::new(0.36, 0.86, 0.361_663_8).normalize();
    let mut origin = point;
    let mut entered: Vec<Medium> = Vec::new();
    let mut around: Vec<Medium> = Vec::new();
    let mut hits = HitColumns::new();
    hits.resize(1, Hit::miss());
    for _ in 0..BOUNDARIES {
        let rays = Rays {
            origin: [&[origin.x], &[origin.y], &[origin.z]],
            direction: [&[direction.x], &[direction.y], &[direction.z]],
            time: &[time],
        };
        closest_hits(&geometry, level, rays, hits.view_mut());
        let hit = hits.get(0);
        if hit.is_miss() {
            break;
        }
        let point = surface(&geometry, &rays.get(0), &hit);
        let material = scene.materials.rows.get(scene.instances.view().material[hit.instance as usize].0 as usize);
        if let Some(medium) = scene.materials.medium(material).map(Medium) {
            if direction.dot(point.geometric_normal) < 0.0 {
                entered.push(medium);
            } else if let Some(last) = entered.iter().rposition(|&m| m == medium) {
                entered.remove(last);
            } else {
                around.push(medium);
            }
        }
        origin = offset_origin(&point, direction);
    }
    around.reverse();
    around
}

/// Boundaries that [`media_around`] follows at most.
const BOUNDARIES: usize = 100_000;

/// Mixes two 32-bit numbers by multiplication: fast, and no key here is chosen by an adversary who gains from a collision.
#[derive(Clone, Copy, Debug, Default)]
struct PairHasher(u64);

impl Hasher for PairHasher {
    fn finish(&self) -> u64 {
        self.0 ^ self.0 >> 29
    }

    fn write(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.write_u32(u32::from(byte));
        }
    }

    fn write_u32(&mut self, value: u32) {
        self.0 = (self.0.rotate_left(32) ^ u64::from(value)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    }
}

#[cfg(test)]
mod tests {
    use brewster_buffers::{ColorSource, Dielectric, DielectricColumns};
    use brewster_optics::fresnel::FresnelModel;

    use super::*;

    fn dielectrics(priorities: &[i32]) -> DielectricColumns {
        let row = |&priority: &i32| Dielectric {
            dispersion: None,
            ior: 1.5,
            fresnel: FresnelModel::Exact,
            specular: ColorSource::constant(Vec3::ONE),
            exponent: 1.0,
            absorption: Vec3::ZERO,
            scattering: Vec3::ZERO,
            anisotropy: 0.0,
            bare: false,
            priority,
            alpha: 0.0,
            film: None,
            thin: false,
        };
        priorities.iter().map(row).collect()
    }

    #[test]
    fn the_highest_priority_fills_and_the_last_one_at_equal_priority() {
        let columns = dielectrics(&[0, 0, 5]);
        let view = columns.view();
        let [a, b, high] = [Medium(0), Medium(1), Medium(2)];
        for (entered, filling) in [
            (&[][..], Medium::VACUUM),
            (&[a], a),
            (&[a, b], b),
            (&[b, a], a),
            (&[a, high, b], high),
            (&[high, a, b], high),
            (&[a, a], a),
        ] {
            let mut stacks = MediaStacks::default();
            let media = stacks.enter_all(entered, &view);
            assert_eq!(stacks.filling(media), filling, "{entered:?}");
        }
    }

    #[test]
    fn leaving_takes_the_last_entry_out_wherever_it_is() {
        let columns = dielectrics(&[0, 0, 5]);
        let view = columns.view();
        let [a, b, high] = [Medium(0), Medium(1), Medium(2)];
        for (entered, left, rest) in [
            (&[a][..], a, &[][..]),
            (&[a, b], a, &[b]),
            (&[a, b, a], a, &[a, b]),
            (&[a, high, b], high, &[a, b]),
            (&[a], b, &[a]),
            (&[], b, &[]),
        ] {
            let mut stacks = MediaStacks::default();
            let media = stacks.enter_all(entered, &view);
            let after = stacks.leave(media, left, &view);
            assert_eq!(after, stacks.enter_all(rest, &view), "{entered:?} without {left:?}");
        }
    }

    #[test]
    fn a_boundary_inside_a_stronger_medium_is_none() {
        let columns = dielectrics(&[0, 5]);
        let view = columns.view();
        let (water, glass) = (Medium(0), Medium(1));
        let mut stacks = MediaStacks::default();
        let in_glass = stacks.enter_all(&[glass], &view);
        let crossing = stacks.boundary(in_glass, water, true, &view);
        assert_eq!((crossing.filling_before, crossing.filling_behind), (glass, glass));
        // Out of the glass the water is there, because its boundary was crossed inside the glass.
        let out = stacks.boundary(crossing.behind, glass, false, &view);
        assert_eq!((out.filling_before, out.filling_behind), (glass, water));
        assert_eq!(out.behind, stacks.enter_all(&[water], &view));
    }

    #[test]
    fn leaving_what_was_never_entered_counts_as_having_been_inside() {
        let columns = dielectrics(&[0]);
        let view = columns.view();
        let mut stacks = MediaStacks::default();
        let boundary = stacks.boundary(MediaId::VACUUM, Medium(0), false, &view);
        assert_eq!(
            boundary,
            Boundary { behind: MediaId::VACUUM, filling_before: Medium(0), filling_behind: Medium::VACUUM }
        );
    }
}
