//! How much arithmetic stages do, by a count of their sources by hand.
//!
//! One operation is an addition, subtraction, multiplication, division, square root, minimum, maximum or comparison of f32 or f64; a fused one
//! counts two. Integers (and so nearly all of a random number), conversions, signs and choices are not counted, nor is work that a
//! kernel does in lanes without a ray. `trace` and `shadow` are counted by what the rays [looked at](crate::survey). Of
//! shading, which branches by material and light, the usual case is counted, as it stands beside each number: a count may be off by
//! half of itself, which a roofline's logarithms forgive, and must not be read as a measurement.

use crate::policy::SortKey;
use crate::stats::{Counts, Stage};
use crate::survey::QueueSurvey;

/// Eight boxes: two products, two differences, a minimum and a maximum along each of three axes, and a comparison.
const NODE: u64 = 8 * (3 * 6 + 1);

/// Origin and direction mapped to object space, 33, and the ray made ready for boxes, 39, and triangles, 6.
const INSTANCE: u64 = 33 + 39 + 6;

/// A triangle: its three edges' products and signs, 15, and its share of the eight corners of a patch, sheared by 7 each, of which a patch
/// has two a triangle or fewer. A shape takes about as much.
const PRIMITIVE: u64 = 15 + 2 * 7;

/// What rays do that visit so much.
fn visiting([nodes, instances, primitives]: [u64; 3]) -> u64 {
    nodes * NODE + instances * INSTANCE + primitives * PRIMITIVE
}

/// Operations that a stage did on behalf of the rays of a depth and queue.
pub fn operations(stage: Stage, counts: &Counts, survey: &QueueSurvey, sort: SortKey) -> u64 {
    let rows = counts.stages[stage as usize];
    match stage {
        Stage::Trace => visiting(survey.visits),
        // Of a ray that arrives, the medium and the contribution take six.
        Stage::Shadow => visiting(survey.shadow_visits) + 6 * rows,
        // Every hit has its point, normals and their errors found in f64: 130 in object space, 60 to 240 on a shape or triangle, 110 on the way back.
        Stage::Sort => 350 * (counts.hits + counts.crossings),
        Stage::Order if sort == SortKey::None => 0,
        _ => rows * of_row(stage),
    }
}

/// Operations of a row.
fn of_row(stage: Stage) -> u64 {
    match stage {
        // Counted by more than rows.
        Stage::Trace | Stage::Shadow | Stage::Sort => 0,
        // The place in the pixel by its filter, 20, on the picture plane, 16, and the unit direction, 24.
        Stage::Generate => 60,
        // Three signs, or three scaled coordinates.
        Stage::Order => 9,
        // Three products with 1; through a medium that absorbs there are three exponentials of 20 more.
        Stage::Absorb => 3,
        // A channel chosen, 15, a logarithm, 20, three exponentials, 60, and the weights of three channels, 30.
        Stage::Fly => 125,
        Stage::Cross => 6,
        // The depth along the view axis.
        Stage::Record => 9,
        // A constant background; a map takes 80 more.
        Stage::Escape => 12,
        // A cosine, the frame of the highlight, and one light: 35 for its irradiance, 30 for the highlight's power, 25 for the rest.
        Stage::ShadePhong => 130,
        // The same without the highlight.
        Stage::ShadeLambert => 75,
        // The same with Fresnel's equations for a conductor, three channels of 35.
        Stage::ShadeMetal => 230,
        // Fresnel's equations, 22, the refracted and the mirror direction, 35, two rays, 30, and one light's highlights.
        Stage::ShadeDielectric => 180,
        // The chance that light sampling would have found the place, 40, and the weight.
        Stage::ShadeEmissive => 50,
        // Black but on surfaces that shine.
        Stage::Glow => 3,
        // A number's scale, nine times.
        Stage::Draw => 9,
        // Frame, 35; a light chosen and its place drawn, 70; the lobe and its weights, 55; a direction drawn, 40; the two rays, 40.
        Stage::ScatterLambert => 240,
        // The lobe's two terms and their table, twice.
        Stage::ScatterRoughDiffuse => 340,
        // Smooth: frame, 35, Fresnel's equations for a conductor, 105, mirror direction and ray, 45; rough: 250 more.
        Stage::ScatterMetal => 185,
        // Smooth: frame, 35, Fresnel's equations, 22, two directions, 30, a ray, 45; rough: 200 more.
        Stage::ScatterDielectric => 130,
        // A diffuse, a rough and a transmissive lobe, each evaluated for a light and for the way on.
        Stage::ScatterPrincipled => 700,
        // A rough lobe above another material, twice.
        Stage::ScatterCoated => 500,
        // The phase function of two lights and of the way on, 15 each, the lights drawn, 100, a direction, 60, and three rays, 30.
        Stage::ScatterMedium => 235,
        // Three channels scaled, bounded and compared.
        Stage::Gather => 12,
        Stage::Fold => 6,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand: two rays, three nodes, one instance, four triangles, and a hit.
    #[test]
    fn operations_are_those_of_visits_and_rows() {
        let mut counts = Counts { hits: 1, ..Counts::default() };
        counts.stages[Stage::Trace as usize] = 2;
        counts.stages[Stage::Sort as usize] = 2;
        counts.stages[Stage::Order as usize] = 2;
        let survey = QueueSurvey { visits: [3, 1, 4], ..QueueSurvey::default() };
        let of = |stage, sort| operations(stage, &counts, &survey, sort);
        assert_eq!(of(Stage::Trace, SortKey::None), 3 * 152 + 78 + 4 * 29);
        assert_eq!(of(Stage::Sort, SortKey::None), 350);
        assert_eq!(of(Stage::Order, SortKey::None), 0);
        assert_eq!(of(Stage::Order, SortKey::Octant), 18);
        assert_eq!(of(Stage::Shadow, SortKey::None), 0);
    }
}
