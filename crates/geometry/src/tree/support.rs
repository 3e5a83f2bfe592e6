//! How far a mesh reaches along any direction.

use glam::DVec3;

use super::node::{LEAF, Node};

/// A bound on the support function h(d) = max d·p over the points p of a mesh, from its values in 26 directions.
///
/// As h(a + b) ≤ h(a) + h(b), a direction with |x| ≥ |y| ≥ |z| has h ≤ (|x| - |y|) h(±1, 0, 0) + (|y| - |z|) h(±1, ±1, 0) + |z| h(±1, ±1, ±1), with
/// the direction's signs. Of a ball that makes at most 1.13 times the radius, where the box around it reaches 1.73 radii. (The directions are
/// those of the 26-dops of J. Klosowski et al., *Efficient Collision Detection Using Bounding Volume Hierarchies of k-DOPs*, TVCG 1998.)
#[derive(Clone, Debug)]
pub(super) struct Support {
    /// By the sign of each coordinate, (-1, -1, -1) first.
    reaches: [f64; 27],
}

/// The place of a direction among the reaches.
fn place(signs: [i8; 3]) -> usize {
    signs.into_iter().fold(0, |place, sign| 3 * place + (sign + 1) as usize)
}

/// Nodes that are looked at for a direction, most often some twenty. Then boxes are believed.
const MOST_LOOKS: u32 = 64;

impl Support {
    /// That of what is in a tree.
    pub(super) fn new(nodes: &[Node]) -> Support {
        let mut reaches = [0.0; 27];
        for x in -1..=1 {
            for y in -1..=1 {
                for z in -1..=1 {
                    let direction = DVec3::from_array([x, y, z].map(f64::from));
                    let mut looks = MOST_LOOKS;
                    reaches[place([x, y, z])] = farthest(nodes, 0, direction, f64::NEG_INFINITY, &mut looks);
                }
            }
        }
        Support { reaches }
    }

    /// How far the mesh reaches along a direction at most, in multiples of the direction's length. The mesh has triangles.
    pub(super) fn along(&self, direction: DVec3) -> f64 {
        let direction = direction.to_array();
        let mut axes = [0, 1, 2];
        axes.sort_unstable_by(|&a, &b| direction[b].abs().total_cmp(&direction[a].abs()));
        let (mut signs, mut sum) = ([0; 3], 0.0);
        for (order, axis) in axes.into_iter().enumerate() {
            let next = axes.get(order + 1).map_or(0.0, |&next| direction[next].abs());
            signs[axis] = if direction[axis] < 0.0 { -1 } else { 1 };
            sum += (direction[axis].abs() - next) * self.reaches[place(signs)];
        }
        sum
    }
}

/// How far what is in a node reaches along a direction, or `least` if that is more.
fn farthest(nodes: &[Node], node: u32, direction: DVec3, least: f64, looks: &mut u32) -> f64 {
    let node = &nodes[node as usize];
    let planes = [0, 1, 2].map(|axis| &node.planes[2 * axis + usize::from(direction[axis] > 0.0)]);
    let corner = |place: usize| DVec3::from_array(planes.map(|plane| f64::from(plane[place])));
    let mut reaches = [f64::NEG_INFINITY; 8];
    for (place, reach) in reaches[..node.count as usize].iter_mut().enumerate() {
        *reach = direction.dot(corner(place));
    }
    *looks = looks.saturating_sub(1);
    let mut found = least;
    loop {
        let place = (1..8).fold(0, |most, place| if reaches[place] > reaches[most] { place } else { most });
        if reaches[place] <= found {
            return found;
        }
        let child = node.children[place];
        let is_known = child & LEAF != 0 || *looks == 0;
        found = if is_known { reaches[place] } else { farthest(nodes, child, direction, found, looks) };
        reaches[place] = f64::NEG_INFINITY;
    }
}
