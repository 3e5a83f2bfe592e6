//! What an entity's surface does to light.

use bevy_ecs::component::Component;
use bevy_ecs::entity::Entity;
use brewster_buffers::Texture;
use brewster_optics::dispersion::DispersiveIndex;
use brewster_optics::fresnel::FresnelModel;
use brewster_optics::thin_film::Film;
use glam::Vec3;

use super::SceneKey;

/// A surface. Entities share one by [`UsesMaterial`], or carry their own.
#[derive(Component, Clone, Debug, PartialEq)]
#[require(SceneKey)]
#[component(summary_tick)]
pub enum Material {
    /// The lecture's ordinary material: ambient, diffuse and specular.
    Phong {
        /// Reflectance for ambient light.
        ambient: Color,
        /// Albedo, 0 to 1; reflected as albedo/π.
        diffuse: Color,
        /// Factor of the highlight.
        specular: Color,
        /// Exponent of the highlight, zero or more.
        exponent: f32,
    },
    /// Ideal diffuse reflection, albedo/π.
    Lambert {
        /// Albedo, 0 to 1.
        albedo: Color,
    },
    /// Diffuse reflection of a rough surface: the energy-preserving Oren-Nayar model.
    RoughDiffuse {
        /// Albedo, 0 to 1.
        albedo: Color,
        /// 0 (Lambert's surface) to 1.
        roughness: f32,
    },
    /// An opaque conductor: a mirror image times the Fresnel reflectance, blurred where `alpha` is above zero; `Whitted`
    /// adds a Phong highlight times R_0.
    Metal {
        /// The reflectance at normal incidence, or what it follows from.
        reflectance: Reflectance,
        /// How reflectance grows toward grazing angles: `Exact` needs an index, `SchlickThetaM` is for dielectrics.
        fresnel: FresnelModel,
        /// Factor of the highlight, beside R_0.
        specular: Color,
        /// Exponent of the highlight, zero or more.
        exponent: f32,
        /// GGX width, 0 (a mirror) to 1.
        alpha: f32,
        /// A film on it, for the Fresnel equations only.
        film: Option<Film>,
    },
    /// A transparent solid: reflects F_r and transmits 1 - F_r.
    Dielectric {
        /// Index of refraction, 1 or more; with dispersion that at the d line, which `Whitted` takes for all wavelengths.
        ior: f32,
        /// How the index depends on the wavelength, if it does; not for thin sheets.
        dispersion: Option<DispersiveIndex>,
        /// How F_r is computed.
        fresnel: FresnelModel,
        /// Factor of the highlight, beside F_r or F_t.
        specular: Color,
        /// Exponent of the highlight, zero or more.
        exponent: f32,
        /// Beer-Lambert coefficient of the inside, per meter, zero or more.
        absorption: Vec3,
        /// Where media overlap the highest priority fills the place; at equal priority the one entered last.
        priority: i32,
        /// GGX width, 0 (smooth) to 1.
        alpha: f32,
        /// A film on it, for the Fresnel equations only.
        film: Option<Film>,
        /// Whether it is a sheet too thin to be inside of, as a window's pane: light passes straight on, after any number of
        /// reflections between the two faces.
        thin: bool,
    },
    /// A surface that sends out light of its own and reflects none.
    Emissive {
        /// Radiance in nit (used as linear RGB), zero or more.
        radiance: Color,
        /// Whether its back sends out light, too, and not its front alone.
        two_sided: bool,
    },
}

/// The entity wears the [`Material`] of another entity.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
#[component(summary_tick)]
pub struct UsesMaterial(pub Entity);

/// What a metal reflects.
#[derive(Clone, Debug, PartialEq)]
pub enum Reflectance {
    /// By color.
    Normal {
        /// R_0: reflectance at normal incidence, 0 to 1.
        r0: Color,
        /// The color near grazing incidence, at 82°, as a factor of Schlick's curve, 0 to 1: white is that curve.
        f82: Vec3,
    },
    /// The complex index that has this reflectance and edge (Gulbrandsen 2014).
    EdgeTint {
        /// R_0: reflectance at normal incidence, 0 to 1.
        r0: Vec3,
        /// 0 to 1: how much of the index is absorption.
        edge_tint: Vec3,
    },
    /// The complex index per channel, relative to a vacuum.
    Index {
        /// Real part, above zero.
        eta: Vec3,
        /// Imaginary part, zero or more.
        k: Vec3,
    },
}

/// A color that is the same everywhere or comes from a texture. Linear Rec.709.
#[derive(Clone, Debug, PartialEq)]
pub enum Color {
    /// One color.
    Constant(Vec3),
    /// A color from the surface's texture coordinates.
    Texture(Texture),
}

impl Color {
    /// No color.
    pub const BLACK: Color = Color::Constant(Vec3::ZERO);
    /// Everything.
    pub const WHITE: Color = Color::Constant(Vec3::ONE);

    /// The same value in each channel.
    pub const fn gray(value: f32) -> Color {
        Color::Constant(Vec3::splat(value))
    }
}
