//! Emissive meshes: what their instances share.

use std::sync::Arc;

use brewster_geometry::{Affine, Face, TriangleMesh};
use brewster_lanes::math;
use brewster_optics::color::luminance;
use glam::{DVec3, Vec3};

use super::cone::Cone;
use crate::{Coordinates, Distribution, Texture};

/// How large a surface is, and where its normals point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Extent {
    pub(super) area: f64,
    pub(super) normals: Cone,
}

/// What all instances of a mesh share that shine by the same texture, or by none.
#[derive(Clone, Debug)]
pub(super) struct MeshEmitter {
    pub(super) mesh: Arc<TriangleMesh>,
    texture: Option<(Texture, Vec3)>,
    pub(super) faces: Vec<Face>,
    /// By area in object space and luminance.
    pub(super) triangles: Distribution,
    /// In object space.
    pub(super) extent: Extent,
    /// The mean luminance over the mesh.
    pub(super) luminance: f64,
}

/// Meshes and images are equal if they are one in memory, and then so is what follows from them.
impl PartialEq for MeshEmitter {
    fn eq(&self, other: &MeshEmitter) -> bool {
        let texture = other.texture.as_ref().map(|(texture, factor)| (texture, *factor));
        self.is_of(&other.mesh, texture) && self.luminance == other.luminance
    }
}

/// Places along each edge of a triangle where its texture is looked up.
const LOOKS: u32 = 3;

/// The part of the whole texture's mean that every triangle has at least, as light may lie between the places.
const EVERYWHERE: f64 = 0.1;

impl MeshEmitter {
    /// A mesh that shines by a texture of some mean luminance, or by one color of that; none if no triangle has an area.
    pub(super) fn new(mesh: &Arc<TriangleMesh>, texture: Option<(&Texture, Vec3)>, mean: f64) -> Option<MeshEmitter> {
        let place = |i: u32| (i as f32 + 0.5) / LOOKS as f32;
        let faces: Vec<Face> = (0..mesh.triangles.len()).map(|triangle| mesh.face(triangle)).collect();
        let brightness = |triangle: usize| {
            let Some((texture, factor)) = texture else { return mean };
            let look = |i: u32| {
                let place = [place(i % LOOKS), place(i / LOOKS)];
                let at = mesh.sample_area(triangle, &faces[triangle], place).local;
                let uvs = [at.uv, mesh.second_uv(triangle, at.point).unwrap_or(at.uv)];
                let coordinates = Coordinates { uvs, color: mesh.color(triangle, at.point) };
                f64::from(luminance(factor * texture.evaluate(&coordinates).truncate()))
            };
            let seen: f64 = (0..LOOKS * LOOKS).map(look).sum::<f64>() / f64::from(LOOKS * LOOKS);
            EVERYWHERE * mean + (1.0 - EVERYWHERE) * seen
        };
        let fluxes: Vec<f64> = faces.iter().zip(0..).map(|(face, triangle)| face.area * brightness(triangle)).collect();
        let extent = extent_of_mesh(mesh, &Affine::IDENTITY);
        Some(MeshEmitter {
            mesh: mesh.clone(),
            texture: texture.map(|(texture, factor)| (texture.clone(), factor)),
            triangles: Distribution::new(&fluxes)?,
            faces,
            extent,
            luminance: fluxes.iter().sum::<f64>() / extent.area,
        })
    }

    /// Whether it is of this mesh and this texture, times the same factor.
    pub(super) fn is_of(&self, mesh: &Arc<TriangleMesh>, texture: Option<(&Texture, Vec3)>) -> bool {
        let own = self.texture.as_ref().map(|(texture, factor)| (texture, *factor));
        own == texture && Arc::ptr_eq(&self.mesh, mesh)
    }
}

/// The extent of a mapped mesh. A map that mirrors turns triangles over, but not their normals.
pub(super) fn extent_of_mesh(mesh: &TriangleMesh, map: &Affine) -> Extent {
    let side = if map.mirrors() { -0.5 } else { 0.5 };
    let area = |triangle: usize| {
        let [a, b, c] = mesh.corners(triangle);
        let (ab, ac) = (map.vector(b - a).as_dvec3(), map.vector(c - a).as_dvec3());
        ab.cross(ac) * side
    };
    let areas = || (0..mesh.triangles.len()).map(area);
    let (sum, total) = areas().fold((DVec3::ZERO, 0.0), |(sum, total), area| (sum + area, total + area.length()));
    let Some(axis) = sum.try_normalize() else { return Extent { area: total, normals: Cone::SPHERE } };
    let cosine = areas().filter_map(DVec3::try_normalize).map(|normal| normal.dot(axis)).fold(1.0, f64::min);
    let angle = math::acos((cosine as f32).clamp(-1.0, 1.0));
    // Rounding turns normals of slivers; nothing wider than this is worth telling from a ball.
    let normals = if angle < 3.0 { Cone { axis: axis.as_vec3(), angle: angle + 1e-3 } } else { Cone::SPHERE };
    Extent { area: total, normals }
}
