//! Writes down what camera rays hit first.

use brewster_buffers::{MaterialKind, MaterialRow};
use brewster_film::{FilmTile, FirstHit, NO_ID};
use brewster_optics::free_flight;
use brewster_optics::fresnel::{FresnelModel, conductor_color};
use glam::Vec3;

use crate::context::Context;
use crate::queues::{PathRay, PathRaysView, SamplesView, Scattering, ScatteringsView, SurfaceHit, SurfaceHitsView};

/// Adds depth along the view axis, normal, albedo and ids of first hits to the film.
///
/// Reads: rays of depth 0, their samples and hits; materials and textures if the film keeps albedo. Writes: the film's layers.
pub fn record(
    context: &Context<'_>,
    rays: PathRaysView<'_>,
    hits: SurfaceHitsView<'_>,
    samples: SamplesView<'_>,
    tile: &mut FilmTile<'_>,
) {
    for row in 0..hits.len() {
        let hit = hits.get(row);
        let sample = rays.sample[hit.ray as usize] as usize;
        let first = first_hit(context, &hit, tile.keeps_parts());
        tile.add_first_hit(samples.pixel[sample], samples.number[sample], first);
    }
}

/// The same of camera rays that media scatter: these have no ids, and a normal toward the camera.
///
/// Reads: rays of depth 0, their samples and scatterings. Writes: the film's layers.
pub fn record_scatterings(
    context: &Context<'_>,
    rays: PathRaysView<'_>,
    scatterings: ScatteringsView<'_>,
    samples: SamplesView<'_>,
    tile: &mut FilmTile<'_>,
) {
    for row in 0..scatterings.len() {
        let scattering = scatterings.get(row);
        let ray = rays.get(scattering.ray as usize);
        let sample = ray.sample as usize;
        let first = first_scattering(context, (&ray, &scattering, samples.time(context, ray.sample)));
        tile.add_first_hit(samples.pixel[sample], samples.number[sample], first);
    }
}

/// What is written down of one scattering at a moment.
#[inline(always)]
pub(crate) fn first_scattering(
    context: &Context<'_>,
    (ray, scattering, time): (&PathRay, &Scattering, f32),
) -> FirstHit {
    let eye = context.camera.frame(time);
    let (media, row) = (context.scene.materials.dielectric.view(), scattering.medium.0 as usize);
    FirstHit {
        depth: (scattering.position - eye.position).dot(eye.forward).max(0.0),
        normal: (-ray.direction()).to_array(),
        albedo: free_flight::albedo(media.absorption[row], media.scattering[row]).to_array(),
        material: NO_ID,
        entity: NO_ID,
    }
}

/// What is written down of one hit.
#[inline(always)]
pub(crate) fn first_hit(context: &Context<'_>, hit: &SurfaceHit, keeps_parts: bool) -> FirstHit {
    let material = context.scene.instances.view().material[hit.instance as usize].0;
    let albedo = if keeps_parts { albedo(context, material, hit) } else { Vec3::ZERO };
    let eye = context.camera.frame(hit.time);
    FirstHit {
        depth: (hit.point.position - eye.position).dot(eye.forward).max(0.0),
        normal: hit.point.shading_normal.to_array(),
        albedo: albedo.to_array(),
        material,
        entity: hit.instance,
    }
}

/// The color that a surface gives to the light that it sends back or lets through, for denoisers: diffuse albedo, a metal's
/// reflectance along the normal in vacuum, a principled base color, what lies below a coat, the mean of a mix, white for what lets through all that it does not reflect, black for emitters, which
/// reflect nothing.
fn albedo(context: &Context<'_>, material: u32, hit: &SurfaceHit) -> Vec3 {
    let MaterialRow { kind, row, .. } = context.scene.materials.rows.get(material as usize);
    albedo_of(context, (kind, row), hit)
}

/// The same of one kind's row.
fn albedo_of(context: &Context<'_>, (kind, row): (MaterialKind, u32), hit: &SurfaceHit) -> Vec3 {
    let scene = context.scene;
    let row = row as usize;
    let color = |source| scene.color(source, &context.seen(hit.place()));
    match kind {
        MaterialKind::Phong => color(scene.materials.phong.view().diffuse[row]),
        MaterialKind::Lambert => color(scene.materials.lambert.view().albedo[row]),
        MaterialKind::RoughDiffuse => color(scene.materials.rough_diffuse.view().albedo[row]),
        MaterialKind::Metal => {
            let metal = scene.materials.metal.get(row);
            match metal.fresnel {
                FresnelModel::Exact => conductor_color(1.0, 1.0, metal.eta, metal.k),
                FresnelModel::Schlick | FresnelModel::SchlickThetaM => color(metal.r0),
            }
        }
        MaterialKind::Dielectric => Vec3::ONE,
        MaterialKind::Emissive => Vec3::ZERO,
        MaterialKind::Principled => color(scene.materials.principled.view().base_color[row]),
        MaterialKind::Coated => {
            let coated = scene.materials.coated.get(row);
            albedo_of(context, (coated.base, coated.base_row), hit)
        }
        MaterialKind::Mix => {
            let mix = scene.materials.mix.get(row);
            let by = scene.number(mix.by, &context.seen(hit.place())).clamp(0.0, 1.0);
            albedo_of(context, mix.a, hit).lerp(albedo_of(context, mix.b, hit), by)
        }
    }
}
