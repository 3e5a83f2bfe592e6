//! Normals for shading that differ from those of the surface, and how far they may.
//!
//! A normal from a map can lean so far over that the mirror direction of the view lies below the surface, where nothing can be
//! seen: black spots at grazing angles. [`visible`] takes such a normal back toward the surface's own, just so far that the
//! mirror direction rises above the surface. It is the idea by which Blender's Cycles keeps reflections valid; a facet model
//! like that of Schüssler, Heitz, Hanika and Dachsbacher, "Microfacet-based normal mapping for robust Monte Carlo path
//! tracing" (2017), would keep energy and reciprocity as well, at the price of a second facet and its interreflections. Here
//! neither is kept: the normal depends on the view, and light that a rough lobe would send below the surface is lost.

use brewster_lanes::math;
use glam::Vec3;

/// The unit normal nearest to `normal`, in its plane with the surface's, about which a viewer in direction `view` sees a mirror
/// image that is above the surface. `geometric` is the unit normal of the surface on the viewer's side.
///
/// What comes out is on the viewer's side, too. A normal that is below the surface counts as one along it.
pub fn visible(normal: Vec3, geometric: Vec3, view: Vec3) -> Vec3 {
    let height = view.dot(geometric);
    // Mirror directions rise by at least this, or by almost as much as the view if that is less.
    let least = (0.9 * height).min(0.01);
    if mirrored(normal, view).dot(geometric) >= least && normal.dot(geometric) > 0.0 {
        return normal;
    }
    let Some(across) = (normal - geometric * normal.dot(geometric)).try_normalize() else { return geometric };
    // Leaning by an angle a, the mirror direction rises by r·cos(2a - b), with the view at (height, x) = r·(cos b, sin b).
    let x = view.dot(across);
    let (reach, angle) = ((height * height + x * x).sqrt(), math::atan2(x, height));
    let most = 0.5 * (angle + math::acos((least / reach).clamp(-1.0, 1.0)));
    let lean = math::acos(normal.dot(geometric).clamp(0.0, 1.0)).min(most).max(0.0);
    let (sine, cosine) = math::sin_cos(lean);
    (geometric * cosine + across * sine).normalize_or(geometric)
}

fn mirrored(normal: Vec3, view: Vec3) -> Vec3 {
    normal * (2.0 * normal.dot(view)) - view
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Directions over the sphere (Fibonacci's spiral).
    fn directions(count: usize) -> impl Iterator<Item = Vec3> {
        (0..count).map(move |i| {
            let z = 1.0 - (2 * i + 1) as f32 / count as f32;
            let (sine, cosine) = math::sin_cos(2.399_963 * i as f32);
            Vec3::new(cosine, sine, 0.0) * (1.0 - z * z).sqrt() + Vec3::Z * z
        })
    }

    #[test]
    fn mirror_images_are_seen_whatever_the_map_says() {
        for view in directions(400).filter(|view| view.z > 1e-3) {
            for normal in directions(400) {
                let found = visible(normal, Vec3::Z, view);
                assert!((found.length() - 1.0).abs() < 1e-5, "{found}");
                let rises = mirrored(found, view).z;
                assert!(rises > 0.5 * view.z.min(0.01), "{normal} seen from {view}: {found} mirrors to {rises}");
                assert!(found.dot(view) > 0.0 && found.z > 0.0, "{normal} seen from {view}: {found}");
                // It leaves alone what is right, and changes the rest no more than it has to.
                let is_right = normal.z > 0.0 && mirrored(normal, view).z > 0.011;
                assert!(!is_right || found == normal, "{normal} seen from {view}: {found}");
                assert!(is_right || mirrored(found, view).z < 0.02 || normal.z < 1e-3, "{normal} seen from {view}");
            }
        }
    }

    #[test]
    fn a_grazing_view_takes_the_normal_back_to_the_middle() {
        // A view 10° above the surface, away from which a normal leans by 45°. The mirror image of the view is turned from it by
        // twice the angle between: 2·(80° + a) for a normal that leans by a, and at a = 5° it lies along the surface.
        let degrees = |angle: f32| angle.to_radians();
        let view = Vec3::new(-math::cos(degrees(10.0)), 0.0, math::sin(degrees(10.0)));
        let normal = Vec3::new(math::sin(degrees(45.0)), 0.0, math::cos(degrees(45.0)));
        let found = visible(normal, Vec3::Z, view);
        let lean = math::asin(found.x).to_degrees();
        assert!((lean - 5.0).abs() < 0.5, "{found} leans by {lean}");
    }
}
