//! The scene as columns: what a flatten writes and the tracer reads.
//!
//! [`SceneBuffers`] is the whole scene. Rows are named by ids ([`InstanceId`], [`MaterialId`], …) that hold until the next
//! flatten. Nothing here knows entities or files.

mod camera;
mod detail;
mod distribution;
mod emitters;
mod environment;
mod environment_map;
mod ids;
mod instances;
mod lights;
mod materials;
mod motion;
mod settings;
#[cfg(test)]
mod statistics;
mod textures;
mod trees;
mod validate;

pub use camera::{Camera, CameraFrame, Projection};
pub use detail::{Detail, Opacity};
pub use distribution::{Cell, Choice, Distribution, Distribution2d};
pub use emitters::{Emitter, EmitterColumns, Emitters, EmittersView, EmittersViewMut, Placing};
pub use environment::{Backdrop, Background};
pub use environment_map::{EnvironmentMap, MapError, MapRows, SKY_RUN};
pub use ids::{DetailId, InstanceId, MaterialId, TextureId};
pub use instances::{Instance, InstanceColumns, InstancesView, InstancesViewMut};
pub use lights::{Illumination, Light, LightColumns, LightKind, LightSample, LightsView, LightsViewMut};
pub use materials::{
    Coated, CoatedColumns, CoatedsView, CoatedsViewMut, Dielectric, DielectricColumns, DielectricsView,
    DielectricsViewMut, Emissive, EmissiveColumns, EmissivesView, EmissivesViewMut, Lambert, LambertColumns,
    LambertsView, LambertsViewMut, MaterialKind, MaterialRow, MaterialRowColumns, MaterialRowsView,
    MaterialRowsViewMut, Materials, Metal, MetalColumns, MetalsView, MetalsViewMut, Mix, MixColumns, MixesView,
    MixesViewMut, Phong, PhongColumns, PhongsView, PhongsViewMut, Principled, PrincipledColumns, PrincipledsView,
    PrincipledsViewMut, RoughDiffuse, RoughDiffuseColumns, RoughDiffusesView, RoughDiffusesViewMut,
};
pub use motion::LightMotion;
pub use settings::{Integrator, PixelFilter, SamplerKind, Settings, ToneMapping};
pub use textures::{
    Axis, Channel, ColorSource, Coordinates, Encoding, Filter, Image, ImageTexture, Pyramid, ScalarSource, SeenPlace,
    Texels, Texture, Textures, UvTransform, Wrap,
};
pub use trees::Trees;

pub use brewster_geometry::{Motion, Motions, SurfacePlace, UvSet};

use brewster_geometry::{SceneGeometry, ShapeTable};
use glam::Vec3;

/// The whole scene.
///
/// Written by the flatten systems, one writer at a time; read by any number of threads afterwards. A flatten makes every id
/// stale that an earlier one gave out.
#[derive(Clone, Debug, Default)]
pub struct SceneBuffers {
    /// What stands where, ordered by scene key.
    pub instances: InstanceColumns,
    /// Which instances move while the shutter is open.
    pub motions: Motions,
    /// The shapes that instances refer to.
    pub shapes: ShapeTable,
    /// How rays find instances and triangles.
    pub trees: Trees,
    /// The materials that instances refer to, split by kind.
    pub materials: Materials,
    /// The textures that materials refer to.
    pub textures: Textures,
    /// Lights without extent, ordered by scene key.
    pub lights: LightColumns,
    /// Which of the lights move while the shutter is open, in their order.
    pub light_motions: Vec<LightMotion>,
    /// What sends out light and can be sampled: emissive instances and lights, with how they are chosen.
    pub emitters: Emitters,
    /// The sum of all ambient lights, radiance in nit.
    pub ambient: Vec3,
    /// Cameras, ordered by scene key.
    pub cameras: Vec<Camera>,
    /// What rays see that meet nothing.
    pub background: Background,
    /// The scene's settings.
    pub settings: Settings,
}

impl SceneBuffers {
    /// What traversal reads.
    pub fn geometry(&self) -> SceneGeometry<'_> {
        let instances = self.instances.view();
        SceneGeometry {
            object_to_world: instances.object_to_world,
            world_to_object: instances.world_to_object,
            motions: &self.motions,
            shapes: instances.shape,
            table: &self.shapes,
            mesh_trees: &self.trees.meshes,
            top: &self.trees.top,
            planes: &self.trees.planes,
            obvhs: self.trees.obvhs.as_deref(),
        }
    }
}
