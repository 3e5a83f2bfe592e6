//! A plain recursion of the lecture's algorithm, the second opinion that the queues have to agree with.
//!
//! One ray at a time, depth first, in f64, from the text of the design and not from the tracer's code. Only geometry is shared:
//! hits, surfaces, spawned origins, cosines and directions are the scene's own f32 functions, so that both follow the very
//! same rays and no edge is seen from two sides; [`optics`] checks these directions against the laws in f64.
//!
//! Where the design leaves a choice, it is made as the tracer's documents say: a medium is known by its material, a light is on
//! a side of a surface if both normals say so, and a shadow ray is aimed from where it starts.

mod media;
mod optics;

use brewster_buffers::{Background, ColorSource, Light, LightKind, MaterialKind, SceneBuffers, Texture, TextureId};
use brewster_geometry::{
    Hit, HitColumns, Ray, Rays, SceneGeometry, SurfacePoint, closest_hits, offset_origin, surface,
};
use brewster_lanes::Level;
use glam::{DVec3, Vec2, Vec3};

use media::Media;
use optics::Split;

/// A scene and its first camera, ready to be traced.
pub(crate) struct Recursion<'a> {
    scene: &'a SceneBuffers,
    geometry: SceneGeometry<'a>,
    camera_media: Media,
}

/// A ray that arrived: what all materials need.
struct Arrival<'a> {
    ray: Ray,
    point: SurfacePoint,
    /// The shading normal on the viewer's side.
    normal: Vec3,
    /// The media that the ray came through.
    media: &'a Media,
    depth: u32,
    /// What the ray's radiance is multiplied with on its way to the pixel.
    weight: DVec3,
}

impl<'a> Recursion<'a> {
    /// Looks at a scene through its first camera.
    pub(crate) fn new(scene: &'a SceneBuffers) -> Recursion<'a> {
        let mut recursion = Recursion { scene, geometry: scene.geometry(), camera_media: Media::default() };
        recursion.camera_media = recursion.media_around(scene.cameras[0].position);
        recursion
    }

    /// The radiance that the middle of a pixel sees.
    pub(crate) fn pixel(&self, x: u32, y: u32) -> DVec3 {
        let size = self.scene.settings.resolution.as_vec2();
        let place = (Vec2::new(x as f32, y as f32) + 0.5) / size;
        self.trace(
            self.scene.cameras[0].ray(place, size.x / size.y, Vec2::ZERO, 0.0),
            &self.camera_media,
            0,
            DVec3::ONE,
        )
    }

    /// The radiance that arrives along a ray.
    fn trace(&self, ray: Ray, media: &Media, depth: u32, weight: DVec3) -> DVec3 {
        let hit = self.closest(&ray);
        let through = media.transmittance(hit.t);
        if hit.is_miss() {
            return through * background(&self.scene.background, ray.direction);
        }
        let weight = weight * through;
        let point = surface(&self.geometry, &ray, &hit);
        let normal = flipped(point.shading_normal, ray.direction);
        let arrival = Arrival { ray, point, normal, media, depth, weight };
        let (kind, row) = self.material_of(&hit);
        let radiance = match kind {
            MaterialKind::Phong => self.phong(row, &arrival),
            MaterialKind::Lambert => self.lambert(row, &arrival),
            MaterialKind::RoughDiffuse => unreachable!("the lecture has none"),
            MaterialKind::Principled | MaterialKind::Coated | MaterialKind::Mix => unreachable!("the lecture has none"),
            MaterialKind::Metal => self.metal(row, &arrival),
            MaterialKind::Dielectric => self.dielectric(row, &arrival),
            MaterialKind::Emissive => self.color(self.scene.materials.emissive.get(row).radiance, &arrival),
        };
        through * radiance
    }

    fn lambert(&self, row: usize, at: &Arrival) -> DVec3 {
        let albedo = self.color(self.scene.materials.lambert.get(row).albedo, at);
        let reflected = |toward: DVec3| albedo / std::f64::consts::PI * at.normal.as_dvec3().dot(toward).max(0.0);
        self.lights(at, Side::Viewer, at.media, reflected)
    }

    fn phong(&self, row: usize, at: &Arrival) -> DVec3 {
        let material = self.scene.materials.phong.get(row);
        let (diffuse, specular) = (self.color(material.diffuse, at), self.color(material.specular, at));
        let mirror = optics::checked_mirror(at.ray.direction, at.normal).as_dvec3();
        let reflected = |toward: DVec3| {
            let diffuse = diffuse / std::f64::consts::PI * at.normal.as_dvec3().dot(toward).max(0.0);
            diffuse + specular * optics::highlight(toward, mirror, material.exponent)
        };
        let ambient = self.color(material.ambient, at) * self.scene.ambient.as_dvec3();
        ambient + self.lights(at, Side::Viewer, at.media, reflected)
    }

    fn metal(&self, row: usize, at: &Arrival) -> DVec3 {
        let material = self.scene.materials.metal.get(row);
        let (r0, specular) = (self.color(material.r0, at), self.color(material.specular, at));
        let direction = optics::checked_mirror(at.ray.direction, at.normal);
        let mirror = direction.as_dvec3();
        let highlight = |toward: DVec3| r0 * specular * optics::highlight(toward, mirror, material.exponent);
        let mut radiance = self.lights(at, Side::Viewer, at.media, highlight);
        let cos_i = -at.normal.dot(at.ray.direction);
        let reflectance = optics::metal(&material, cos_i.into(), at.media.index(), r0);
        radiance += self.follow(at, direction, at.media, reflectance);
        radiance
    }

    fn dielectric(&self, row: usize, at: &Arrival) -> DVec3 {
        let material = self.scene.materials.dielectric.get(row);
        let inward = at.ray.direction.dot(at.point.geometric_normal) < 0.0;
        let boundary = at.media.boundary((row, material), inward);
        if boundary.is_none() {
            let ray = Ray { origin: offset_origin(&at.point, at.ray.direction), ..at.ray };
            return self.trace(ray, &boundary.behind, at.depth, at.weight);
        }
        let specular = self.color(material.specular, at);
        let Split { reflectance, refracted } = optics::split(&material, at.ray.direction, &at.point, &boundary);
        let behind = &boundary.behind;

        let direction = optics::checked_mirror(at.ray.direction, at.normal);
        let mirror = direction.as_dvec3();
        let highlight = |toward: DVec3| specular * reflectance * optics::highlight(toward, mirror, material.exponent);
        let mut radiance = self.lights(at, Side::Viewer, behind, highlight);
        radiance += self.follow(at, direction, behind, DVec3::splat(reflectance));
        if let Some(direction) = refracted {
            let transmittance = 1.0 - reflectance;
            let refracted = direction.as_dvec3();
            let highlight =
                |toward: DVec3| specular * transmittance * optics::highlight(toward, refracted, material.exponent);
            radiance += self.lights(at, Side::Behind, behind, highlight);
            radiance += self.follow(at, direction, behind, DVec3::splat(transmittance));
        }
        radiance
    }

    /// What arrives from a direction, times a factor, if the path may scatter on and is worth it.
    fn follow(&self, at: &Arrival, direction: Vec3, behind: &Media, factor: DVec3) -> DVec3 {
        let weight = at.weight * factor;
        let threshold = f64::from(self.scene.settings.contribution_threshold);
        if at.depth >= self.scene.settings.max_depth || weight.max_element() < threshold {
            return DVec3::ZERO;
        }
        let ray = Ray { origin: offset_origin(&at.point, direction), direction, time: 0.0 };
        factor * self.trace(ray, at.media_toward(direction, behind), at.depth + 1, weight)
    }

    /// The light of all lights on a side of the surface, each times what `reflected` says for its direction.
    fn lights(&self, at: &Arrival, side: Side, behind: &Media, reflected: impl Fn(DVec3) -> DVec3) -> DVec3 {
        let mut sum = DVec3::ZERO;
        for row in 0..self.scene.lights.len() {
            let light = self.scene.lights.get(row);
            let seen = light.illuminate(at.point.position);
            let value = irradiance(&light, at.point.position) * reflected(seen.direction.as_dvec3());
            if at.side_of(seen.direction) == Some(side) && value != DVec3::ZERO {
                let media = at.media_toward(seen.direction, behind);
                let origin = offset_origin(&at.point, seen.direction);
                // From there the light is in another direction by a rounding.
                let seen = light.illuminate(origin);
                sum +=
                    value * self.visibility(Ray { origin, direction: seen.direction, time: 0.0 }, seen.distance, media);
            }
        }
        sum
    }

    /// The part of a light that arrives at the start of a ray toward it.
    fn visibility(&self, mut ray: Ray, mut distance: f32, media: &Media) -> DVec3 {
        let mut media = media.clone();
        let mut visible = DVec3::ONE;
        loop {
            let hit = self.closest(&ray);
            if hit.t >= distance {
                return visible * media.transmittance(distance);
            }
            let (kind, row) = self.material_of(&hit);
            if kind != MaterialKind::Dielectric || !self.scene.settings.transparent_shadows {
                return DVec3::ZERO;
            }
            visible *= media.transmittance(hit.t);
            let point = surface(&self.geometry, &ray, &hit);
            let material = self.scene.materials.dielectric.get(row);
            let boundary = media.boundary((row, material), ray.direction.dot(point.geometric_normal) < 0.0);
            if !boundary.is_none() {
                visible *= 1.0 - optics::split(&material, ray.direction, &point, &boundary).reflectance;
            }
            ray.origin = offset_origin(&point, ray.direction);
            distance -= hit.t;
            media = boundary.behind;
        }
    }

    /// The media around a place. A ray from there leaves what it is in; the innermost it leaves first.
    fn media_around(&self, place: Vec3) -> Media {
        let mut ray = Ray { origin: place, direction: Vec3::new(0.36, 0.8, 0.48), time: 0.0 };
        let (mut met, mut around) = (Vec::new(), Vec::new());
        loop {
            let hit = self.closest(&ray);
            if hit.is_miss() {
                around.reverse();
                return Media(around);
            }
            let point = surface(&self.geometry, &ray, &hit);
            if let (MaterialKind::Dielectric, row) = self.material_of(&hit) {
                if ray.direction.dot(point.geometric_normal) < 0.0 {
                    met.push(row);
                } else if let Some(place) = met.iter().rposition(|&other| other == row) {
                    met.remove(place);
                } else {
                    around.push((row, self.scene.materials.dielectric.get(row)));
                }
            }
            ray.origin = offset_origin(&point, ray.direction);
        }
    }

    fn closest(&self, ray: &Ray) -> Hit {
        let (origin, direction) = (ray.origin.to_array(), ray.direction.to_array());
        let rays = Rays {
            origin: origin.each_ref().map(std::slice::from_ref),
            direction: direction.each_ref().map(std::slice::from_ref),
            time: std::slice::from_ref(&ray.time),
        };
        let mut hits = HitColumns::new();
        hits.resize(1, Hit::miss());
        closest_hits(&self.geometry, Level::BASELINE, rays, hits.view_mut());
        hits.get(0)
    }

    /// The kind of a hit's material and its row among them.
    fn material_of(&self, hit: &Hit) -> (MaterialKind, usize) {
        let material = self.scene.instances.get(hit.instance as usize).material;
        let row = self.scene.materials.rows.get(material.0 as usize);
        (row.kind, row.row as usize)
    }

    fn color(&self, source: ColorSource, at: &Arrival) -> DVec3 {
        match source.texture {
            TextureId::NONE => source.factor.as_dvec3(),
            TextureId(row) => source.factor.as_dvec3() * texture(&self.scene.textures.rows[row as usize], at.point.uv),
        }
    }
}

impl Arrival<'_> {
    /// The side of the surface that a direction leads to; none where the two normals disagree.
    fn side_of(&self, direction: Vec3) -> Option<Side> {
        let by = |normal: Vec3| {
            let cosine = flipped(normal, self.ray.direction).dot(direction);
            if cosine > 0.0 { Side::Viewer } else { Side::Behind }
        };
        let side = by(self.point.geometric_normal);
        (side == by(self.point.shading_normal)).then_some(side)
    }

    /// The media on the side of the surface itself that a direction leads to.
    fn media_toward<'b>(&'b self, direction: Vec3, behind: &'b Media) -> &'b Media {
        let goes_on = flipped(self.point.geometric_normal, self.ray.direction).dot(direction) < 0.0;
        if goes_on { behind } else { self.media }
    }
}

/// A side of a surface.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Side {
    /// Where the ray came from.
    Viewer,
    /// The other.
    Behind,
}

/// The normal on the side that a direction comes from.
fn flipped(normal: Vec3, direction: Vec3) -> Vec3 {
    if normal.dot(direction) > 0.0 { -normal } else { normal }
}

/// A light's irradiance on a plane that faces it.
fn irradiance(light: &Light, point: Vec3) -> DVec3 {
    let intensity = light.intensity.as_dvec3();
    if light.kind == LightKind::Directional {
        return intensity;
    }
    let from_light = point.as_dvec3() - light.position.as_dvec3();
    let distance = from_light.length();
    let cosine = from_light.dot(light.direction.as_dvec3()) / distance;
    let ramp = (cosine * f64::from(light.cone_scale) + f64::from(light.cone_offset)).clamp(0.0, 1.0);
    let falloff = if light.kind == LightKind::Point { distance * distance } else { 1.0 };
    intensity * ramp * ramp / falloff
}

/// The background's radiance: linear in the sine of the elevation.
fn background(background: &Background, direction: Vec3) -> DVec3 {
    match *background {
        Background::Constant(color) => color.as_dvec3(),
        Background::Gradient { horizon, zenith, ground } => {
            let sine = f64::from(direction.y);
            let end = if sine > 0.0 { zenith } else { ground };
            horizon.as_dvec3().lerp(end.as_dvec3(), sine.abs())
        }
        Background::Environment(_) => panic!("the lecture has no pictures of surroundings"),
    }
}

/// A texture's color. The checker's squares are geometry: an edge is where f32 puts it.
fn texture(texture: &Texture, uv: Vec2) -> DVec3 {
    match texture {
        Texture::Checker { a, b, size } => {
            let [column, row] = (uv / *size).to_array().map(|x| x.floor() as i64);
            if (column + row) % 2 == 0 { a.as_dvec3() } else { b.as_dvec3() }
        }
        Texture::Gradient { from, to, axis } => {
            let along = if *axis == brewster_buffers::Axis::U { uv.x } else { uv.y };
            from.as_dvec3().lerp(to.as_dvec3(), f64::from(along).clamp(0.0, 1.0))
        }
        Texture::VertexColors => panic!("the lecture has no colors of vertices"),
        Texture::Image(picture) => {
            let image = &picture.image;
            let (width, height) = (f64::from(image.width), f64::from(image.height));
            let place = picture.transform.apply(uv);
            // In pixels from the middle of the top left one.
            let (x, y) = (f64::from(place.x) * width - 0.5, (1.0 - f64::from(place.y)) * height - 0.5);
            let pixel = |x: f64, y: f64| {
                let (column, row) = (x.rem_euclid(width) as usize, y.rem_euclid(height) as usize);
                image.texel(row * image.width as usize + column, picture.encoding).truncate().as_dvec3()
            };
            let (left, top) = (x.floor(), y.floor());
            let row = |y: f64| pixel(left, y).lerp(pixel(left + 1.0, y), x - left);
            row(top).lerp(row(top + 1.0), y - top)
        }
    }
}
