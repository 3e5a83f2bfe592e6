//! Shades hits on metals: the lecture's Phong highlight times R_0, and the mirror image times the Fresnel reflectance.

use brewster_geometry::offset_origin;
use brewster_optics::conductor::F82Tint;
use brewster_optics::fresnel::FresnelModel;
use brewster_optics::fresnel::conductor_color;
use brewster_optics::phong::highlight as phong_highlight;
use brewster_optics::refraction::mirror;
use glam::Vec3;

use super::{Continuation, facing_normals, send_shadow_ray};
use crate::context::Context;
use crate::media::MediaStacks;
use crate::queues::{HitsOf, OnMetal, PathRay, PathRaysView, SurfaceHit};
use crate::stages::Outlet;
use crate::stats::Counts;

/// For each hit: for each light on the viewer's side a shadow ray with ks · R_0 · max(0, L·R)^exponent · irradiance, and, below
/// the maximum depth, a reflection with weight F_r. What is not reflected is absorbed as heat. A complex index counts relative
/// to the medium in front of the metal; R_0 is what the author says, in any medium.
///
/// Reads: rays, hits, metals, textures, lights, the media stacks. Writes: shadow rays and the next depth's reflection queue.
pub fn shade_metal(
    context: &Context<'_>,
    rays: PathRaysView<'_>,
    hits: &HitsOf<'_, OnMetal>,
    stacks: &MediaStacks,
    continuation: Continuation,
    outlet: &mut impl Outlet,
    counts: &mut Counts,
) {
    let hits = hits.columns();
    for row in 0..hits.len() {
        let hit = hits.get(row);
        mirror_at_metal(context, (&rays.get(hit.ray as usize), &hit), stacks, continuation, outlet, counts);
    }
}

/// One hit.
#[inline(always)]
pub(crate) fn mirror_at_metal(
    context: &Context<'_>,
    (ray, hit): (&PathRay, &SurfaceHit),
    stacks: &MediaStacks,
    continuation: Continuation,
    outlet: &mut impl Outlet,
    counts: &mut Counts,
) {
    let scene = context.scene;
    let dielectrics = scene.materials.dielectric.view();
    let material = scene.materials.metal.get(hit.material as usize);
    let direction = ray.direction();
    let (geometric, normal) = facing_normals(hit, direction);
    let mirror = mirror(direction, normal);
    let color = |source| scene.color(source, &context.seen(hit.place()));
    let (r0, specular) = (color(material.r0), color(material.specular));
    for index in 0..scene.lights.len() {
        let light = scene.light_at(index, hit.time);
        let seen = light.illuminate(hit.point.position);
        if seen.direction.dot(normal) <= 0.0 || seen.direction.dot(geometric) <= 0.0 {
            continue;
        }
        let highlight = specular * r0 * phong_highlight(seen.direction, mirror, material.exponent);
        let reflected: Vec3 = ray.weight * highlight * seen.irradiance;
        send_shadow_ray(outlet, hit, ray, ray.media, &light, seen.direction, reflected);
    }
    let cos_i = (-direction.dot(normal)).clamp(0.0, 1.0);
    let reflectance = match material.fresnel {
        FresnelModel::Exact => {
            let eta_i = stacks.filling(ray.media).ior(&dielectrics);
            conductor_color(cos_i, eta_i, material.eta, material.k)
        }
        FresnelModel::Schlick | FresnelModel::SchlickThetaM => {
            F82Tint::new(r0, material.r90, material.f82).reflectance(cos_i)
        }
    };
    let origin = offset_origin(&hit.point, mirror);
    let reflected = ray.along(origin, mirror);
    let reflected = PathRay { weight: ray.weight * reflectance, instance: hit.instance, ..reflected };
    continuation.reflect(reflected, outlet, counts);
}
