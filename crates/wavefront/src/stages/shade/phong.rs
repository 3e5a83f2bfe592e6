//! Shades hits on Phong materials: ambient + diffuse + specular, the lecture's ordinary surface.

use brewster_optics::lambert;
use brewster_optics::phong::highlight as phong_highlight;
use brewster_optics::refraction::mirror;
use glam::Vec3;

use super::{facing_normals, send_shadow_ray};
use crate::context::Context;
use crate::queues::{Contribution, End, HitsOf, OnPhong, PathRay, PathRaysView, SurfaceHit};
use crate::stages::Outlet;

/// For each hit: the ambient term as a contribution, and for each light on the viewer's side a shadow ray with
/// (albedo/π · N·L + ks · max(0, L·R)^exponent) · irradiance.
///
/// Reads: rays, hits, Phong materials, textures, lights. Writes: shadow rays and contributions.
pub fn shade_phong(
    context: &Context<'_>,
    rays: PathRaysView<'_>,
    hits: &HitsOf<'_, OnPhong>,
    outlet: &mut impl Outlet,
) {
    let hits = hits.columns();
    for row in 0..hits.len() {
        let hit = hits.get(row);
        light_phong(context, &rays.get(hit.ray as usize), &hit, outlet);
    }
}

/// One hit.
#[inline(always)]
pub(crate) fn light_phong(context: &Context<'_>, ray: &PathRay, hit: &SurfaceHit, outlet: &mut impl Outlet) {
    let scene = context.scene;
    let material = scene.materials.phong.get(hit.material as usize);
    let direction = ray.direction();
    let (geometric, normal) = facing_normals(hit, direction);
    let mirror = mirror(direction, normal);
    let color = |source| scene.color(source, &context.seen(hit.place()));
    let (diffuse, specular) = (lambert::brdf(color(material.diffuse)), color(material.specular));

    let ambient = ray.weight * color(material.ambient) * scene.ambient;
    outlet.light(Contribution {
        radiance: ambient,
        sample: ray.sample,
        trail: ray.trail.end(End::Surface),
        instance: hit.instance,
    });
    for index in 0..scene.lights.len() {
        let light = scene.light_at(index, hit.time);
        let seen = light.illuminate(hit.point.position);
        let cosine = seen.direction.dot(normal);
        if cosine <= 0.0 || seen.direction.dot(geometric) <= 0.0 {
            continue;
        }
        let highlight = specular * phong_highlight(seen.direction, mirror, material.exponent);
        let reflected: Vec3 = ray.weight * (diffuse * cosine + highlight) * seen.irradiance;
        send_shadow_ray(outlet, hit, ray, ray.media, &light, seen.direction, reflected);
    }
}
