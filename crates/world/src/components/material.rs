//! What an entity's surface does to light.

use bevy_ecs::component::Component;
use bevy_ecs::entity::Entity;
use brewster_buffers::{Channel, Texture};
use brewster_optics::dispersion::DispersiveIndex;
use brewster_optics::fresnel::FresnelModel;
use brewster_optics::thin_film::Film;
use glam::Vec3;

use super::{NormalMap, SceneKey};

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
        /// Whether a rough one keeps the light that meets more than one facet.
        compensated: bool,
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
        /// What the inside scatters.
        scattering: Scattering,
        /// Whether there is no surface where the index is the same on both sides, but only what fills it: fog, smoke. Without films,
        /// dispersion and [`Detail`](super::Detail).
        bare: bool,
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
    /// One of two materials at every hit, by chance: rust on paint, and whatever lies between two materials. Not of what has an inside.
    Mix {
        /// The one.
        a: Box<Material>,
        /// The other.
        b: Box<Material>,
        /// The part of all hits that is the other, 0 to 1.
        by: Scalar,
    },
    /// A surface that sends out light of its own and reflects none.
    Emissive {
        /// Radiance in nit (used as linear RGB), zero or more.
        radiance: Color,
        /// Whether its back sends out light, too, and not its front alone.
        two_sided: bool,
    },
    /// glTF's metallic-roughness material.
    Principled(Box<Principled>),
    /// A clear coat over another material: varnish, lacquer, the glaze of china.
    Coated {
        /// What lies below: Lambert or metal.
        base: Box<Material>,
        /// The coat's index of refraction, 1 or more.
        ior: f32,
        /// The coat's GGX width, 0 (smooth) to 1.
        alpha: f32,
        /// Beer-Lambert coefficient of the coat, per meter, zero or more.
        absorption: Vec3,
        /// The coat's thickness in meters, zero or more; for absorption alone.
        thickness: f32,
    },
}

/// glTF 2.0's metallic-roughness material with the extensions named `KHR_materials_`: every field as their specification
/// has it, with its defaults. Normal maps and opacity are no part of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Principled {
    /// The color of a dielectric's inside, of what it transmits, and of a metal's reflection, 0 to 1.
    pub base_color: Color,
    /// How much of the surface is metal, 0 to 1.
    pub metallic: Scalar,
    /// Its square is the GGX width, 0 to 1.
    pub roughness: Scalar,
    /// Index of refraction, 1 or more; or 0, which stands for infinity.
    pub ior: f32,
    /// Weight of a dielectric's reflection, 0 to 1.
    pub specular: Scalar,
    /// Tint of a dielectric's reflection along the normal, zero or more.
    pub specular_color: Color,
    /// Weight of the clearcoat, 0 to 1.
    pub clearcoat: Scalar,
    /// Its square is the clearcoat's GGX width, 0 to 1.
    pub clearcoat_roughness: Scalar,
    /// The map of the clearcoat's normals: it follows this one alone and not that of the [`Detail`](super::Detail).
    pub clearcoat_normal: Option<NormalMap>,
    /// Color of the sheen, 0 to 1.
    pub sheen_color: Color,
    /// Its square is the sheen's width, 0 to 1.
    pub sheen_roughness: Scalar,
    /// Facets that are wider in one direction.
    pub anisotropy: Anisotropy,
    /// How much of what enters a dielectric comes out beyond, 0 to 1.
    pub transmission: Scalar,
    /// How much of a dielectric's diffuse light is transmitted, 0 to 1.
    pub diffuse_transmission: Scalar,
    /// Color of that, 0 to 1.
    pub diffuse_transmission_color: Color,
    /// The inside of a closed surface that lets light through; without one it is a sheet.
    pub volume: Option<Volume>,
    /// A film whose interference colors the reflection.
    pub iridescence: Iridescence,
    /// Whether a rough metal keeps the light that meets more than one facet, which glTF loses.
    pub compensated: bool,
    /// How much the index depends on the wavelength: 20 over the Abbe number, zero or more. Of a volume only.
    pub dispersion: f32,
    /// Radiance in nit, zero or more; from both sides.
    pub emission: Color,
    /// Whether it is no surface but a picture: it sends out its base color and reflects nothing.
    pub unlit: bool,
}

/// How a medium scatters light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scattering {
    /// How much, per meter, zero or more.
    pub coefficient: Vec3,
    /// The mean cosine of the angle by which light is turned, between -1 (back) and 1 (forward), by Henyey and Greenstein.
    pub anisotropy: f32,
}

impl Scattering {
    /// Of what is clear.
    pub const NONE: Scattering = Scattering { coefficient: Vec3::ZERO, anisotropy: 0.0 };
}

/// The direction in which facets are wider.
#[derive(Clone, Debug, PartialEq)]
pub struct Anisotropy {
    /// How much wider, 0 to 1.
    pub strength: f32,
    /// The direction's angle from the tangent, counterclockwise, in radians.
    pub rotation: f32,
    /// Red and green: the direction, -1 to 1 stored as 0 to 1; it is rotated by `rotation`. Blue: a factor of `strength`.
    pub texture: Option<Texture>,
}

/// What fills a closed surface, and takes the place of what it overlaps.
#[derive(Clone, Debug, PartialEq)]
pub struct Volume {
    /// What is left of white light after the attenuation distance, 0 to 1.
    pub attenuation_color: Vec3,
    /// In meters, above zero; infinite where nothing is absorbed.
    pub attenuation_distance: f32,
    /// The color that the inside looks of after many scatterings, 0 to 1: the part of the attenuation that is scattered follows
    /// from it. Black scatters nothing.
    pub multiscatter_color: Vec3,
    /// As [`Scattering::anisotropy`].
    pub anisotropy: f32,
    /// Where media overlap the highest priority fills the place; at equal priority the one entered last.
    pub priority: i32,
}

/// A thin film between air and surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Iridescence {
    /// How much of the surface it covers, 0 to 1.
    pub factor: Scalar,
    /// Its index of refraction, 1 or more.
    pub ior: f32,
    /// In nanometers: its thickness where `thickness_texture` is 0 and where it is 1 or absent.
    pub thickness: [f32; 2],
    /// What lies between.
    pub thickness_texture: Option<(Texture, Channel)>,
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
        /// R_90: reflectance at grazing incidence, 0 to 1: that of metals is white.
        r90: Vec3,
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
    /// A color from the surface's texture coordinates, times another.
    Tinted {
        /// The other.
        factor: Vec3,
        /// The texture.
        texture: Texture,
    },
}

impl Material {
    /// Whether it sends out light.
    pub fn shines(&self) -> bool {
        match self {
            Material::Emissive { .. } => true,
            Material::Principled(principled) => principled.unlit || principled.emission != Color::BLACK,
            Material::Mix { a, b, .. } => a.shines() || b.shines(),
            _ => false,
        }
    }
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

    /// The color, or the factor of the texture's.
    pub fn factor(&self) -> Vec3 {
        match self {
            Color::Constant(factor) | Color::Tinted { factor, .. } => *factor,
            Color::Texture(_) => Vec3::ONE,
        }
    }

    /// Where it comes from, if it is not the same everywhere.
    pub fn texture(&self) -> Option<&Texture> {
        match self {
            Color::Constant(_) => None,
            Color::Texture(texture) | Color::Tinted { texture, .. } => Some(texture),
        }
    }
}

/// A number that is the same everywhere or is multiplied by a texture.
#[derive(Clone, Debug, PartialEq)]
pub struct Scalar {
    /// The number.
    pub factor: f32,
    /// What it is multiplied by.
    pub texture: Option<(Texture, Channel)>,
}

impl Scalar {
    /// The same everywhere.
    pub const fn constant(factor: f32) -> Scalar {
        Scalar { factor, texture: None }
    }
}

impl Default for Principled {
    /// glTF's defaults.
    fn default() -> Principled {
        Principled {
            base_color: Color::WHITE,
            metallic: Scalar::constant(1.0),
            roughness: Scalar::constant(1.0),
            ior: 1.5,
            specular: Scalar::constant(1.0),
            specular_color: Color::WHITE,
            clearcoat: Scalar::constant(0.0),
            clearcoat_roughness: Scalar::constant(0.0),
            clearcoat_normal: None,
            sheen_color: Color::BLACK,
            sheen_roughness: Scalar::constant(0.0),
            anisotropy: Anisotropy { strength: 0.0, rotation: 0.0, texture: None },
            transmission: Scalar::constant(0.0),
            diffuse_transmission: Scalar::constant(0.0),
            diffuse_transmission_color: Color::WHITE,
            volume: None,
            iridescence: Iridescence {
                factor: Scalar::constant(0.0),
                ior: 1.3,
                thickness: [100.0, 400.0],
                thickness_texture: None,
            },
            compensated: false,
            dispersion: 0.0,
            emission: Color::BLACK,
            unlit: false,
        }
    }
}

impl Default for Volume {
    /// glTF's defaults: nothing is absorbed.
    fn default() -> Volume {
        Volume {
            attenuation_color: Vec3::ONE,
            attenuation_distance: f32::INFINITY,
            multiscatter_color: Vec3::ZERO,
            anisotropy: 0.0,
            priority: 0,
        }
    }
}
