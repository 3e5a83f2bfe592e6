//! Shades hits on Lambert materials: ideal diffuse reflection.

use brewster_optics::lambert;

use super::{facing_normals, send_shadow_ray};
use crate::context::Context;
use crate::queues::{HitsOf, OnLambert, PathRay, PathRaysView, SurfaceHit};
use crate::stages::Outlet;

/// For each hit and each light on the viewer's side a shadow ray with albedo/π · N·L · irradiance.
///
/// Reads: rays, hits, Lambert materials, textures, lights. Writes: shadow rays.
pub fn shade_lambert(
    context: &Context<'_>,
    rays: PathRaysView<'_>,
    hits: &HitsOf<'_, OnLambert>,
    outlet: &mut impl Outlet,
) {
    let hits = hits.columns();
    for row in 0..hits.len() {
        let hit = hits.get(row);
        light_lambert(context, &rays.get(hit.ray as usize), &hit, outlet);
    }
}

/// One hit.
#[inline(always)]
pub(crate) fn light_lambert(context: &Context<'_>, ray: &PathRay, hit: &SurfaceHit, outlet: &mut impl Outlet) {
    let scene = context.scene;
    let material = scene.materials.lambert.get(hit.material as usize);
    let (geometric, normal) = facing_normals(hit, ray.direction());
    let diffuse = lambert::brdf(scene.color(material.albedo, &context.seen(hit.place())));
    for index in 0..scene.lights.len() {
        let light = scene.light_at(index, hit.time);
        let seen = light.illuminate(hit.point.position);
        let cosine = seen.direction.dot(normal);
        if cosine > 0.0 && seen.direction.dot(geometric) > 0.0 {
            let reflected = ray.weight * diffuse * cosine * seen.irradiance;
            send_shadow_ray(outlet, hit, ray, ray.media, &light, seen.direction, reflected);
        }
    }
}
