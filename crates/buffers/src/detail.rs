//! What a surface has that is finer than its shape: normals from maps, and places where it is not.

use brewster_geometry::{Hit, Ray, SurfacePoint, UvSet, meets_front};
use brewster_optics::basis::Basis;
use brewster_optics::shading_normal::visible;
use glam::{Vec2, Vec3};

use crate::{Coordinates, DetailId, MaterialId, ScalarSource, SceneBuffers, SeenPlace, Texture, TextureId};

/// The detail of a material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detail {
    /// A map of normals, or `TextureId::NONE`: red, green and blue from 0 to 1 are components from -1 to 1 along tangent,
    /// bitangent and normal.
    pub normal: TextureId,
    /// Factor of the components along tangent and bitangent.
    pub normal_scale: f32,
    /// Heights in meters along the normal, for shading alone.
    pub bump: ScalarSource,
    /// Where the surface is.
    pub opacity: Opacity,
    /// Whether cameras see its front alone: camera rays that come to its back go straight on.
    pub front_only: bool,
}

/// Where a surface is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Opacity {
    /// Everywhere.
    Opaque,
    /// Where a number reaches a limit.
    Mask {
        /// The number.
        alpha: ScalarSource,
        /// The limit.
        cutoff: f32,
    },
    /// As a veil of which this part is there.
    Blend {
        /// The part, held in 0..1.
        alpha: ScalarSource,
    },
}

impl Detail {
    /// None.
    pub const NONE: Detail = Detail {
        normal: TextureId::NONE,
        normal_scale: 1.0,
        bump: ScalarSource::constant(0.0),
        opacity: Opacity::Opaque,
        front_only: false,
    };
}

impl SceneBuffers {
    /// The part of a surface that is there: 1 where a material has no detail.
    #[inline(always)]
    pub fn coverage(&self, material: MaterialId, place: &SeenPlace) -> f32 {
        match self.materials.rows.view().detail[material.0 as usize] {
            DetailId::NONE => 1.0,
            detail => self.coverage_of(detail, place),
        }
    }

    fn coverage_of(&self, detail: DetailId, place: &SeenPlace) -> f32 {
        match self.materials.details[detail.0 as usize].opacity {
            Opacity::Opaque => 1.0,
            Opacity::Mask { alpha, cutoff } => f32::from(self.number(alpha, place) >= cutoff),
            Opacity::Blend { alpha } => self.number(alpha, place).clamp(0.0, 1.0),
        }
    }

    /// Whether a material may be absent somewhere.
    #[inline(always)]
    pub fn is_veiled(&self, material: MaterialId) -> bool {
        match self.materials.rows.view().detail[material.0 as usize] {
            DetailId::NONE => false,
            detail => self.materials.details[detail.0 as usize].opacity != Opacity::Opaque,
        }
    }

    /// Whether a camera ray that hit a surface sees through it, since it came to the back of one that shows its front alone.
    #[inline(always)]
    pub fn is_culled(&self, ray: &Ray, hit: &Hit) -> bool {
        let material = self.instances.view().material[hit.instance as usize];
        match self.materials.rows.view().detail[material.0 as usize] {
            DetailId::NONE => false,
            detail => self.materials.details[detail.0 as usize].front_only && !meets_front(&self.geometry(), ray, hit),
        }
    }

    /// The normal that a surface is shaded with where a ray arrives in a direction: the shading normal, bent by height and map, and
    /// held where its mirror image can be seen.
    pub fn bent_normal(&self, detail: DetailId, place: &SeenPlace, point: &SurfacePoint, direction: Vec3) -> Vec3 {
        let detail = &self.materials.details[detail.0 as usize];
        let upright = point.shading_normal;
        let bumped = if detail.bump.is_zero() { upright } else { self.bumped(detail.bump, place, upright) };
        let bent = match detail.normal {
            TextureId::NONE => bumped,
            map => self.mapped(map, detail.normal_scale, place, bumped),
        };
        if bent == upright {
            return upright;
        }
        let side = if direction.dot(point.geometric_normal) < 0.0 { 1.0 } else { -1.0 };
        // Where the mesh's own normal leans to the other side, its map does, too.
        let outward = if upright.dot(point.geometric_normal) < 0.0 { -bent } else { bent };
        visible(outward * side, point.geometric_normal * side, -direction) * side
    }

    /// The unit tangent and bitangent of a surface around a unit normal: along which u and v of a texture grow, or those of the
    /// first texture coordinates without one.
    ///
    /// A mesh's own tangents count, if it has them. Else they follow from how texture coordinates run over the surface; where they
    /// do not, any direction is as good.
    pub fn tangents(&self, texture: TextureId, place: &SeenPlace, normal: Vec3) -> [Vec3; 2] {
        let (tangent, side) = self.geometry().vertex_tangent(place).unwrap_or_else(|| {
            let [of_u, of_v] = self.gradients(texture, place);
            let across = of_v.cross(normal);
            let tangent = across * 1f32.copysign(across.dot(of_u));
            (tangent, 1f32.copysign(normal.cross(tangent).dot(of_v)))
        });
        let basis = Basis::with_tangent(normal, tangent);
        [basis.tangent, basis.bitangent * side]
    }

    /// The gradients along the surface of the coordinates by which a texture is looked up.
    fn gradients(&self, texture: TextureId, place: &SeenPlace) -> [Vec3; 2] {
        let texture = (texture != TextureId::NONE).then(|| &self.textures.rows[texture.0 as usize]);
        match texture {
            Some(Texture::Image(image)) => image.transform.gradients(self.uv_gradients(place, image.uv_set)),
            _ => self.uv_gradients(place, UvSet::First),
        }
    }

    /// A unit normal, bent by a map of normals.
    pub fn mapped(&self, map: TextureId, scale: f32, place: &SeenPlace, normal: Vec3) -> Vec3 {
        let [x, y, z] = (self.texture(map, place).truncate() * 2.0 - 1.0).to_array();
        let (x, y) = (x * scale, y * scale);
        if x == 0.0 && y == 0.0 {
            return normal;
        }
        let [tangent, bitangent] = self.tangents(map, place, normal);
        (tangent * x + bitangent * y + normal * z).normalize_or(normal)
    }

    /// The normal of the surface after each point has moved along the normal by its height: less the gradient of the height (Blinn
    /// 1978, "Simulation of wrinkled surfaces", for small heights; Mikkelsen 2010, "Bump mapping unparametrized surfaces").
    fn bumped(&self, height: ScalarSource, place: &SeenPlace, normal: Vec3) -> Vec3 {
        if height.texture == TextureId::NONE {
            return normal;
        }
        let at = self.coordinates(place);
        let Vec2 { x, y } = self.textures.rows[height.texture.0 as usize].slope(&at, height.channel) * height.factor;
        if x == 0.0 && y == 0.0 {
            return normal;
        }
        let [of_u, of_v] = self.gradients(height.texture, place);
        let gradient = of_u * x + of_v * y;
        (normal - (gradient - normal * normal.dot(gradient))).normalize_or(normal)
    }
}

impl Texture {
    /// How much a channel grows with each of the coordinates by which the texture is looked up: from half a pixel before to half a
    /// pixel behind. Steps between squares have no slope.
    fn slope(&self, at: &Coordinates, channel: crate::Channel) -> Vec2 {
        match self {
            Texture::Image(image) => image.slope(at, channel),
            Texture::Gradient { from, to, axis } => {
                let along = if *axis == crate::Axis::U { Vec2::X } else { Vec2::Y };
                let inside = (0.0..=1.0).contains(&at.uvs[0].dot(along));
                let rise = (*to - *from).extend(0.0)[channel as usize];
                if inside { along * rise } else { Vec2::ZERO }
            }
            Texture::Checker { .. } | Texture::VertexColors => Vec2::ZERO,
        }
    }
}

impl SceneBuffers {
    /// Checks that details name textures and can be computed with, and that materials have those in their order.
    pub(crate) fn validate_details(&self) -> Result<(), String> {
        let names = self.materials.rows.view().detail.iter().filter(|&&detail| detail != DetailId::NONE);
        if !names.copied().eq((0..self.materials.details.len() as u32).map(DetailId)) {
            return Err("materials and their details are not in one order".to_owned());
        }
        let has = |texture: TextureId| texture == TextureId::NONE || (texture.0 as usize) < self.textures.rows.len();
        let is_sound = |number: ScalarSource| number.factor.is_finite() && has(number.texture);
        for (row, detail) in self.materials.details.iter().enumerate() {
            let opacity = match detail.opacity {
                Opacity::Opaque => true,
                Opacity::Mask { alpha, cutoff } => is_sound(alpha) && cutoff.is_finite(),
                Opacity::Blend { alpha } => is_sound(alpha),
            };
            let map = has(detail.normal) && detail.normal_scale.is_finite();
            if !(opacity && map && is_sound(detail.bump)) {
                return Err(format!("detail {row} is none: {detail:?}"));
            }
        }
        Ok(())
    }
}
