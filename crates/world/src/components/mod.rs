//! The components that importers and user code spawn and edit. They hold what an author says, in the units of the
//! design: meters, radians, linear Rec.709; nothing here is derived.

mod camera;
mod detail;
mod light;
mod material;
mod motion;
mod settings;
mod shape;
mod transform;

pub use camera::{Camera, Lens, Projection};
pub use detail::{Detail, NormalMap, Opacity};
pub use light::{Falloff, Light};
pub use material::{
    Anisotropy, Color, Iridescence, Material, Principled, Reflectance, Scalar, Scattering, UsesMaterial, Volume,
};
pub use motion::Motion;
pub use settings::{Background, Settings};
pub use shape::{Shape, UsesShape};
pub use transform::{SceneKey, Transform, WorldTransform};

/// What components are made of: types of the crates below, under one roof, so that an importer needs no other.
pub mod parts {
    pub use brewster_buffers::{
        Axis, Backdrop, Background, Channel, Encoding, EnvironmentMap, Filter, Image, ImageTexture, Integrator,
        MapError, MapRows, PixelFilter, Pyramid, SamplerKind, Settings, Texels, Texture, ToneMapping, UvSet,
        UvTransform, Wrap,
    };
    pub use brewster_geometry::{Affine, TriangleMesh};
    pub use brewster_optics::dispersion::DispersiveIndex;
    pub use brewster_optics::fresnel::FresnelModel;
    pub use brewster_optics::thin_film::Film;
}
