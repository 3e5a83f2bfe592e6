//! Shades hits on dielectrics: every one splits into both queues, with F_r and F_t.

use brewster_buffers::DielectricsView;
use brewster_geometry::offset_origin;
use brewster_optics::phong::highlight as phong_highlight;
use brewster_optics::refraction::{mirror, refract_with_cosine};
use glam::Vec3;

use super::{Continuation, facing_normals, send_shadow_ray};
use crate::context::Context;
use crate::media::{MediaId, MediaStacks, Medium};
use crate::queues::{HitsOf, OnDielectric, PathRay, PathRaysView, SurfaceHit};
use crate::stages::Outlet;
use crate::stats::Counts;

/// What a ray finds at a boundary.
struct Split {
    /// The part that is reflected, F_r; the rest is transmitted.
    reflectance: f32,
    /// Unit mirror direction.
    reflected: Vec3,
    /// Unit refracted direction; none where everything is reflected.
    transmitted: Option<Vec3>,
    /// The media in front of the boundary and behind it.
    media: [MediaId; 2],
    /// Unit normal for shading, on the side that the ray came from.
    normal: Vec3,
    /// Unit geometric normal on the side that the ray came from.
    geometric: Vec3,
}

impl Split {
    /// The media around a ray that leaves the boundary: the geometric normal decides on which side it runs.
    fn media_of(&self, direction: Vec3) -> MediaId {
        self.media[usize::from(direction.dot(self.geometric) < 0.0)]
    }
}

/// For each hit: for each light a shadow ray with the Phong highlight about the mirror direction times F_r, or about the
/// refracted direction times F_t for lights behind the boundary, and, below the maximum depth, a reflection with weight
/// F_r and a transmission with weight F_t.
///
/// Reads: rays, hits, dielectrics, textures, lights. Writes: shadow rays, the next depth's reflection and transmission queues,
/// and the media stacks.
pub fn shade_dielectric(
    context: &Context<'_>,
    rays: PathRaysView<'_>,
    hits: &HitsOf<'_, OnDielectric>,
    stacks: &mut MediaStacks,
    continuation: Continuation,
    outlet: &mut impl Outlet,
    counts: &mut Counts,
) {
    let hits = hits.columns();
    for row in 0..hits.len() {
        let hit = hits.get(row);
        split_at_dielectric(context, (&rays.get(hit.ray as usize), &hit), stacks, continuation, outlet, counts);
    }
}

/// One hit.
#[inline(always)]
pub(crate) fn split_at_dielectric(
    context: &Context<'_>,
    (ray, hit): (&PathRay, &SurfaceHit),
    stacks: &mut MediaStacks,
    continuation: Continuation,
    outlet: &mut impl Outlet,
    counts: &mut Counts,
) {
    let dielectrics = context.scene.materials.dielectric.view();
    let split = split(&dielectrics, stacks, ray, hit);
    highlight(context, ray, hit, &split, outlet);
    let send = |direction: Vec3, factor: f32| {
        let origin = offset_origin(&hit.point, direction);
        let along = ray.along(origin, direction);
        PathRay { weight: ray.weight * factor, instance: hit.instance, media: split.media_of(direction), ..along }
    };
    continuation.reflect(send(split.reflected, split.reflectance), outlet, counts);
    match split.transmitted {
        Some(direction) => continuation.transmit(send(direction, 1.0 - split.reflectance), outlet, counts),
        None => counts.totally_reflected += 1,
    }
}

/// Where light goes at the boundary.
fn split(dielectrics: &DielectricsView<'_>, stacks: &mut MediaStacks, ray: &PathRay, hit: &SurfaceHit) -> Split {
    let direction = ray.direction();
    let inward = direction.dot(hit.point.geometric_normal) < 0.0;
    let boundary = stacks.boundary(ray.media, Medium(hit.material), inward, dielectrics);
    let [eta_i, eta_t] = boundary.indices(direction, &hit.point, dielectrics);
    let (geometric, normal) = facing_normals(hit, direction);

    let cos_i = (-direction.dot(normal)).clamp(0.0, 1.0);
    let fresnel = dielectrics.fresnel[hit.material as usize].dielectric(cos_i, eta_i, eta_t);
    let refracted = || refract_with_cosine(direction, normal, fresnel.cos_t, eta_i / eta_t);
    Split {
        reflectance: fresnel.reflectance,
        reflected: mirror(direction, normal),
        transmitted: (!fresnel.is_total()).then(refracted),
        media: [ray.media, boundary.behind],
        normal,
        geometric,
    }
}

/// The lights' images in the surface: a Phong lobe stands for each.
fn highlight(context: &Context<'_>, ray: &PathRay, hit: &SurfaceHit, split: &Split, outlet: &mut impl Outlet) {
    let scene = context.scene;
    let material = scene.materials.dielectric.get(hit.material as usize);
    let specular = scene.color(material.specular, &context.seen(hit.place()));
    for index in 0..scene.lights.len() {
        let light = scene.light_at(index, hit.time);
        let seen = light.illuminate(hit.point.position);
        let (side, geometric_side) = (seen.direction.dot(split.normal), seen.direction.dot(split.geometric));
        let factor = if side > 0.0 && geometric_side > 0.0 {
            split.reflectance * phong_highlight(seen.direction, split.reflected, material.exponent)
        } else if side < 0.0 && geometric_side < 0.0 {
            split.transmitted.map_or(0.0, |transmitted| {
                (1.0 - split.reflectance) * phong_highlight(seen.direction, transmitted, material.exponent)
            })
        } else {
            0.0
        };
        let media = split.media_of(seen.direction);
        let seen_through = ray.weight * specular * factor * seen.irradiance;
        send_shadow_ray(outlet, hit, ray, media, &light, seen.direction, seen_through);
    }
}
