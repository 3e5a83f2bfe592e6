//! What a surface does to light: pure functions.
//!
//! Every function here takes numbers and returns numbers: it knows no ray, no scene and no memory, and calls no libm,
//! so a picture gets the same bits everywhere. What a tracer calls for every ray is `#[inline(always)]` and compiles into
//! vector loops; [`wide`] has the loops over columns, tested to the bit against the scalar functions.
//!
//! | where is … | here |
//! | --- | --- |
//! | the Fresnel equations: both dielectric forms, conductor, F₀ and its inverse, both Schlick models | [`fresnel`] |
//! | Snell, mirror and refracted direction, total internal reflection, Brewster's angle | [`refraction`] |
//! | Phong's highlight | [`phong`] |
//! | Lambert's diffuse reflection | [`lambert`] |
//! | rough metal, rough glass: GGX and its visible normals | [`microfacet`] |
//! | dust and clay: EON, the energy-preserving Oren-Nayar | [`rough_diffuse`] |
//! | soap bubbles, oil, tempered steel: thin films | [`thin_film`] |
//! | metals by color: F82-tint, edge tint | [`conductor`] |
//! | plastic and car paint: a coat over diffuse, over metal | [`layered`] |
//! | light of further facets, energy kept | [`multiple`] |
//! | glTF's metallic-roughness material, with its extensions | [`principled`] |
//! | velvet: the sheen of cloth | [`sheen`] |
//! | what a rough surface reflects in all: by theory, by table | [`albedo`], [`albedo_table`] |
//! | the same by one direction, drawn by nobody's sampler | [`audit`] |
//! | the frame of a lobe, weights and densities | [`lobe`], [`basis`] |
//! | from the unit square to disks, hemispheres, cones, triangles | [`warp`] |
//! | Beer–Lambert absorption | [`absorption`] |
//! | fog and milk: how far light comes, and where it is turned | [`free_flight`], [`phase`] |
//! | sRGB, luminance, `#rrggbb` | [`color`] |
//! | spectra to Rec.709 | [`spectrum`] |
//! | gold, silver, copper … by measured η and k | [`metals`] |
//! | BK7, SF11, diamond, water … by measured dispersion | [`glasses`] |
//! | an index for every wavelength, and the wavelength that a path follows | [`dispersion`] |
//!
//! Three types matter: [`FresnelModel`](fresnel::FresnelModel), the author's choice of equation, and what it returns,
//! [`DielectricSplit`](fresnel::DielectricSplit); and [`Metal`](metals::Metal), a complex index for each channel.
//!
//! A ray meets a glass ball from inside. The normal is flipped to its side, Snell and Fresnel say where the light goes:
//!
//! ```
//! use brewster_optics::fresnel::FresnelModel;
//! use brewster_optics::{glasses, refraction};
//! use glam::Vec3;
//!
//! let (outward, direction) = (Vec3::Y, Vec3::new(0.6, 0.8, 0.0));
//! let glass = glasses::glass("BK7").unwrap().ior();
//!
//! let normal = refraction::flip_towards_viewer(outward, direction);
//! let cos_i = -normal.dot(direction);
//! let split = FresnelModel::Exact.dielectric(cos_i, glass, 1.0);
//! assert!((split.reflectance - 0.128).abs() < 1e-3 && !split.is_total());
//!
//! let reflected = refraction::mirror(direction, normal);
//! assert!(reflected.abs_diff_eq(Vec3::new(0.6, -0.8, 0.0), 1e-6));
//! let refracted = refraction::refract(direction, normal, glass, 1.0).unwrap();
//! assert!((refracted.x - glass * 0.6).abs() < 1e-6);
//!
//! // Flatter than the critical angle of 41.2°, all of it is reflected.
//! assert!(FresnelModel::Exact.dielectric(0.7, glass, 1.0).is_total());
//! ```
//!
//! A gold mirror, from straight ahead and at grazing incidence, and an index for the artist who thinks in reflectances:
//!
//! ```
//! use brewster_optics::fresnel::{FresnelModel, ior_from_f0};
//! use brewster_optics::metals::metal;
//!
//! let gold = metal("gold").unwrap();
//! let color = gold.f0();
//! assert!(color.x > 0.95 && color.z < 0.4);
//! let grazing = FresnelModel::Exact.conductor(0.0, 1.0, gold.eta, gold.k);
//! assert!(grazing.min_element() > 0.999);
//!
//! assert!((ior_from_f0(0.04).unwrap() - 1.5).abs() < 1e-6);
//! assert!(ior_from_f0(1.0).is_err());
//! ```

pub mod absorption;
pub mod albedo;
pub mod albedo_table;
pub mod audit;
pub mod basis;
pub mod color;
pub mod conductor;
pub mod dispersion;
pub mod free_flight;
pub mod fresnel;
pub mod glasses;
pub mod lambert;
pub mod layered;
pub mod lobe;
pub mod metals;
pub mod microfacet;
pub mod multiple;
pub mod phase;
pub mod phong;
pub mod principled;
pub mod refraction;
pub mod rough_diffuse;
pub mod shading_normal;
pub mod sheen;
pub mod spectrum;
pub mod thin_film;
pub mod warp;
pub mod wide;

#[cfg(test)]
mod statistics;
#[cfg(test)]
mod strategies;
