//! Materials.

use std::sync::OnceLock;

use super::texture::{Map, Number, Paint, Texture};
use super::{ABOVE_ZERO, ONE_OR_MORE, ZERO_OR_MORE};
use crate::ron::decode::{Context, Decode, Fields, check_name, schema, variant};
use crate::ron::info::{FieldInfo, Form, Kind, Range, TypeInfo, VariantInfo};
use crate::ron::node::Node;
use crate::ron::values::{Rgb, Spanned};
use crate::source::Span;

const ZERO_TO_ONE: Range = Range { text: "0 to 1", admits: |x| (0.0..=1.0).contains(&x) };
const COSINE: Range = Range { text: "above -1 and below 1", admits: |x| -1.0 < x && x < 1.0 };
const BELOW_ONE: Range = Range { text: "0 or more, below 1", admits: |x| (0.0..1.0).contains(&x) };
const FILM: Range = Range { text: "0 to 100000", admits: |x| (0.0..=1e5).contains(&x) };

const INDEX: Range = Range { text: "1 or more, or 0", admits: |x| x >= 1.0 || x == 0.0 };

schema! {
    /// What a surface does to light.
    choice Material {
        /// The lectures' ordinary material: ambient, diffuse and specular.
        Phong {
            /// Factor of ambient light; as `diffuse` where absent.
            ambient: Option<Paint> where ZERO_OR_MORE => "0.1",
            /// Albedo of the diffuse part.
            diffuse: Paint where ZERO_OR_MORE = "0.5" => "Checker(a: 0.2, b: 0.8, size: 0.5)",
            /// Factor of the highlight.
            specular: Paint where ZERO_OR_MORE = "0" => "0.3",
            /// Exponent of the highlight: larger is sharper.
            exponent: f32 where ZERO_OR_MORE = "32" => "80",
        },
        /// Ideal diffuse reflection.
        Lambert {
            /// The part of the light that comes back.
            albedo: Paint where ZERO_OR_MORE = "0.5" => "\"#c04020\"",
        },
        /// A diffuse surface that shadows itself: clay, dust, the moon. The energy-preserving model of Oren and Nayar; for
        /// `Path`.
        RoughDiffuse {
            /// The part of the light that would come back, were it smooth.
            albedo: Paint where ZERO_OR_MORE = "0.5" => "\"#c04020\"",
            /// 0 is `Lambert`.
            roughness: f32 where ZERO_TO_ONE = "0.5" => "1",
        },
        /// An opaque conductor. It takes `r0`, or `eta` and `k`, or `of`; and `alpha` or `roughness`.
        Metal {
            /// Reflectance at normal incidence.
            r0: Option<Paint> where ZERO_TO_ONE => "(0.3, 0.4, 0.9)",
            /// Real part of the complex index, per channel.
            eta: Option<Rgb> where ABOVE_ZERO => "(0.14, 0.38, 1.44)",
            /// Imaginary part of the complex index, per channel.
            k: Option<Rgb> where ZERO_OR_MORE => "(3.98, 2.39, 1.6)",
            /// A measured metal, by its symbol or its name.
            of: Option<Spanned<String>> => "\"Au\"",
            /// Beside `r0`: color of the edge, from which the index follows after Gulbrandsen; a color for all of the surface.
            edge_tint: Option<Rgb> where ZERO_TO_ONE => "(0.9, 0.7, 0.5)",
            /// Beside `r0`: reflectance at grazing incidence; with that of `r0` the same color is reflected at every angle.
            r90: Option<Rgb> where ZERO_TO_ONE => "(0.3, 0.4, 0.9)",
            /// Beside `r0`: color of the edge at 82 degrees, as a factor of Schlick's curve.
            f82: Option<Rgb> where ZERO_TO_ONE => "(1, 0.9, 0.8)",
            /// How reflectance grows toward grazing angles: `Exact` where an index is known and `Schlick` with `r0`, if
            /// absent.
            fresnel: Option<Spanned<Fresnel>> => "Schlick",
            /// Width of the GGX distribution of facets: 0 is a mirror, anything else is for `Path`.
            alpha: Option<f32> where ZERO_TO_ONE => "0.2",
            /// The same as artists turn it: its square is `alpha`.
            roughness: Option<f32> where ZERO_TO_ONE => "0.45",
            /// A film on the surface, so thin that it shows the colors of interference. For `Path`, with the Fresnel equations.
            film: Option<Film> => "(ior: 1.33, thickness: 400)",
            /// Whether a rough metal keeps the light that meets more than one facet, and is as bright as a smooth one.
            compensated: bool = "false" => "true",
            /// `Whitted`: factor of the highlight, beside the reflectance at normal incidence.
            specular: Paint where ZERO_OR_MORE = "1" => "0.5",
            /// `Whitted`: exponent of the highlight.
            exponent: f32 where ZERO_OR_MORE = "100" => "300",
        },
        /// A transparent solid. It takes `ior`, or `reflectance`, or `glass`, or a `dispersion` that gives the index, too; and
        /// `alpha` or `roughness`.
        Dielectric {
            /// Index of refraction.
            ior: Option<f32> where ONE_OR_MORE => "1.5",
            /// Reflectance at normal incidence, from which the index follows.
            reflectance: Option<f32> where BELOW_ONE => "0.04",
            /// A glass or another transparent matter, by its name.
            glass: Option<Spanned<String>> => "\"SF11\"",
            /// How the index depends on the wavelength: what fans white light out into colors. For `Path`.
            dispersion: Option<Spanned<Dispersion>> => "Abbe(number: 30)",
            /// How the reflected part is computed.
            fresnel: Fresnel = "Exact" => "SchlickThetaM",
            /// Width of the GGX distribution of facets: 0 is smooth, anything else is for `Path`.
            alpha: Option<f32> where ZERO_TO_ONE => "0.2",
            /// The same as artists turn it: its square is `alpha`.
            roughness: Option<f32> where ZERO_TO_ONE => "0.45",
            /// Whether the surface is a whole sheet, too thin to be inside of: light goes straight on, after any number of
            /// reflections between both faces. For `Path`.
            thin: bool = "false" => "true",
            /// A film on the surface, so thin that it shows the colors of interference. For `Path`, with the Fresnel equations.
            film: Option<Film> => "(ior: 1.33, thickness: 400)",
            /// `Whitted`: factor of the highlight, beside the reflected or the transmitted part.
            specular: Paint where ZERO_OR_MORE = "1" => "0.5",
            /// `Whitted`: exponent of the highlight.
            exponent: f32 where ZERO_OR_MORE = "100" => "300",
            /// What the inside takes away, after Beer and Lambert.
            absorption: Rgb as "1/m" where ZERO_OR_MORE = "0" => "(0.1, 0.02, 0.05)",
            /// What the inside scatters: milk, wax, cloudy ice. For `Path`.
            scattering: Rgb as "1/m" where ZERO_OR_MORE = "0" => "(20, 22, 25)",
            /// Where it scatters to, as the mean cosine: 0 everywhere alike, toward 1 on, toward -1 back.
            anisotropy: f32 where COSINE = "0" => "0.8",
            /// Where solids overlap the highest counts; at equal priority the one entered last.
            priority: i32 = "0" => "1",
        },
        /// What fills a closed shape that has no surface: fog, smoke, a beam's haze. Light goes straight in and out, toward lights, too.
        /// For `Path`.
        Medium {
            /// What it takes away, after Beer and Lambert.
            absorption: Rgb as "1/m" where ZERO_OR_MORE = "0" => "(0.1, 0.02, 0.05)",
            /// What it scatters.
            scattering: Rgb as "1/m" where ZERO_OR_MORE = "0" => "0.2",
            /// Where it scatters to, as the mean cosine: 0 everywhere alike, toward 1 on, toward -1 back.
            anisotropy: f32 where COSINE = "0" => "0.6",
            /// Index of refraction. Where it is not that of the other side, there is a smooth surface: that of a medium in
            /// water is water's.
            ior: f32 where ONE_OR_MORE = "1" => "1.333",
            /// Where solids overlap the highest counts; at equal priority the one entered last.
            priority: i32 = "0" => "1",
        },
        /// glTF's metallic-roughness material with its extensions, each field as glTF has it; the defaults are those of a
        /// half rough plastic. For `Path`.
        Principled {
            /// Color of a dielectric's inside and of what it transmits, or of a metal's reflection.
            base_color: Paint where ZERO_TO_ONE = "0.8" => "\"#c04020\"",
            /// How much of it is metal.
            metallic: Number where ZERO_TO_ONE = "0" => "1",
            /// How rough it is; the square of it is the GGX width.
            roughness: Number where ZERO_TO_ONE = "0.5" => "Map(texture: Image(file: \"wood.png\"), channel: G)",
            /// A dielectric's index of refraction; 0 stands for one without end, which reflects all.
            ior: f32 where INDEX = "1.5" => "1.33",
            /// Weight of a dielectric's reflection.
            specular: Number where ZERO_TO_ONE = "1" => "0.5",
            /// Tint of a dielectric's reflection along the normal.
            specular_color: Paint where ZERO_OR_MORE = "1" => "(1, 0.9, 0.8)",
            /// Weight of a clear coat of varnish over all.
            clearcoat: Number where ZERO_TO_ONE = "0" => "1",
            /// How rough the coat is.
            clearcoat_roughness: Number where ZERO_TO_ONE = "0" => "0.2",
            /// The map of the coat's normals, as that of a surface. The coat follows this one and no other.
            clearcoat_normal: Option<Texture> => "Image(file: \"dents.png\")",
            /// Factor of its slopes.
            clearcoat_normal_scale: f32 = "1" => "0.5",
            /// Color of the sheen of cloth.
            sheen_color: Paint where ZERO_TO_ONE = "0" => "(0.3, 0.1, 0.4)",
            /// How rough the sheen is: rougher is broader.
            sheen_roughness: Number where ZERO_TO_ONE = "0.5" => "0.3",
            /// Roughness that is greater along one direction, as brushed metal's is across the strokes.
            anisotropy: Option<Anisotropy> => "(strength: 0.7)",
            /// How much of a dielectric is glass.
            transmission: Number where ZERO_TO_ONE = "0" => "1",
            /// How much of a dielectric's diffuse light comes out on the other side.
            diffuse_transmission: Number where ZERO_TO_ONE = "0" => "0.5",
            /// Color of that light.
            diffuse_transmission_color: Paint where ZERO_TO_ONE = "1" => "(0.6, 0.8, 0.2)",
            /// What is inside of a closed shape that lets light through. Without it the surface is a sheet, and light goes straight
            /// on.
            volume: Option<Volume> => "(color: (0.5, 0.9, 0.6), distance: 0.1)",
            /// A film that shows the colors of interference.
            iridescence: Option<Iridescence> => "(thickness: 500)",
            /// Whether a rough metal keeps the light that meets more than one facet, which glTF loses.
            compensated: bool = "false" => "true",
            /// Light of its own, from both sides.
            emission: Paint as "nit" where ZERO_OR_MORE = "0" => "(5, 4, 3)",
        },
        /// A clear coat over another material: varnish, lacquer, the glaze of china. It takes `alpha` or `roughness`. For `Path`.
        Coated {
            /// What lies below: `Lambert` or `Metal`.
            base: Spanned<Box<Material>> => "Lambert(albedo: 0.8)",
            /// The coat's index of refraction.
            ior: f32 where ONE_OR_MORE = "1.5" => "1.33",
            /// Width of the GGX distribution of the coat's facets.
            alpha: Option<f32> where ZERO_TO_ONE => "0.2",
            /// The same as artists turn it: its square is `alpha`.
            roughness: Option<f32> where ZERO_TO_ONE => "0.45",
            /// What the coat takes away, after Beer and Lambert.
            absorption: Rgb as "1/m" where ZERO_OR_MORE = "0" => "(100, 500, 2000)",
            /// How thick it is; for absorption alone.
            thickness: f32 as "m" where ZERO_OR_MORE = "0.001" => "0.0002",
        },
        /// A surface that sends out light and reflects none. With `Whitted` it is seen and lights nothing.
        Emissive {
            /// The light.
            radiance: Paint as "nit" where ZERO_OR_MORE = "1" => "(5, 4, 3)",
            /// Which sides shine.
            sides: Sides = "Both" => "Front",
        },
        /// One of two materials at every hit, by chance. Not of what has an inside: a dielectric but a `thin` one, or a principled
        /// material with a volume.
        Mix {
            /// The one.
            a: Box<Spanned<Material>> => "Lambert(albedo: 0.3)",
            /// The other.
            b: Box<Spanned<Material>> => "Metal(of: \"Au\")",
            /// The part of all hits that is the other.
            by: Number where ZERO_TO_ONE = "0.5" => "Map(texture: Image(file: \"wood.png\"))",
        },
        /// Another material with a finer surface: normals from a map, heights, and places where it is not.
        Detailed {
            /// The material.
            of: Box<Spanned<Material>> => "Lambert(albedo: 0.3)",
            /// A map of normals as glTF has them: red, green and blue from 0 to 1 are components from -1 to 1 along tangent, bitangent
            /// (up in the picture) and normal.
            normal: Option<Texture> => "Image(file: \"wood.png\")",
            /// Factor of the components along tangent and bitangent.
            normal_scale: f32 = "1" => "0.5",
            /// Heights along the normal, for shading alone.
            bump: Option<Map> as "m" => "(texture: Image(file: \"wood.png\"), factor: 0.01)",
            /// Where the surface is.
            opacity: Opacity = "Opaque" => "Mask(alpha: Map(texture: Image(file: \"wood.png\"), channel: A))",
            /// Which sides cameras see; they look through the back of a surface that shows its `Front` alone. Light meets both.
            sides: Sides = "Both" => "Front",
        },
    }

    /// Roughness that depends on the direction.
    record Anisotropy {
        /// How much greater it is along the direction than across it.
        strength: f32 where ZERO_TO_ONE => "0.7",
        /// The direction, counterclockwise from that in which the first texture coordinate grows.
        rotation: f32 as "degrees" = "0" => "90",
        /// Red and green: the direction, from -1 to 1 stored as 0 to 1; blue: a factor of `strength`.
        texture: Option<Texture> => "Image(file: \"brushed.png\")",
    }

    /// What fills a closed shape.
    record Volume {
        /// What is left of white light after `distance`.
        color: Rgb where ZERO_TO_ONE = "1" => "(0.5, 0.9, 0.6)",
        /// The distance.
        distance: f32 as "m" where ABOVE_ZERO = "1" => "0.1",
        /// The color that a large body has whose light is scattered many times: it says which part of what `color` loses is scattered
        /// and not absorbed. Black scatters nothing.
        multiscatter: Rgb where ZERO_TO_ONE = "0" => "(0.8, 0.5, 0.4)",
        /// Where it scatters to, as the mean cosine: 0 everywhere alike, toward 1 on, toward -1 back.
        anisotropy: f32 where COSINE = "0" => "0.3",
        /// Abbe's number, which says how much colors fan out: the smaller, the more.
        abbe: Option<f32> where ABOVE_ZERO => "30",
        /// Where solids overlap the highest counts; at equal priority the one entered last.
        priority: i32 = "0" => "1",
    }

    /// Where a surface is. Rays that do not meet it go straight on.
    choice Opacity {
        /// Everywhere.
        Opaque {},
        /// Where a number reaches a limit: leaves, wire mesh.
        Mask {
            /// The number.
            alpha: Number where ZERO_OR_MORE => "Map(texture: Image(file: \"wood.png\"), channel: A)",
            /// The limit.
            cutoff: f32 = "0.5" => "0.25",
        },
        /// As a veil, of which this part is there.
        Blend {
            /// The part.
            alpha: Number where ZERO_TO_ONE => "0.5",
        },
    }

    /// A film of transparent matter on a principled surface.
    record Iridescence {
        /// How much of the surface it covers.
        factor: Number where ZERO_TO_ONE = "1" => "0.5",
        /// Index of refraction.
        ior: f32 where ONE_OR_MORE = "1.3" => "1.33",
        /// Thickness.
        thickness: Number as "nm" where FILM = "400" => "500",
        /// Where the texture of `thickness` is 0.
        thinnest: f32 as "nm" where FILM = "0" => "100",
    }

    /// A film of transparent matter: soap, oil, the oxide on tempered steel. Light that is reflected at both of its sides adds up as
    /// waves; each channel shows the mean over its part of the spectrum.
    record Film {
        /// Index of refraction.
        ior: f32 where ONE_OR_MORE => "1.33",
        /// Thickness.
        thickness: f32 as "nm" where FILM => "400",
    }

    /// How an index of refraction depends on the wavelength. A path that meets such a boundary goes on with a single wavelength, so
    /// that colors take more samples.
    choice Dispersion {
        /// As measured, of a `glass`.
        Measured {},
        /// By Abbe's number: the smaller, the more colors fan out; 20 to 90 for glass. Beside `ior`, `reflectance` or `glass`.
        Abbe {
            /// `(n_d - 1)/(n_F - n_C)`.
            number: f32 where ABOVE_ZERO => "30",
        },
        /// By Cauchy's equation `a + b/λ² + c/λ⁴`, λ in micrometers; gives the index, too.
        Cauchy {
            /// The index far in the infrared.
            a: f32 where ONE_OR_MORE => "1.5046",
            /// In µm².
            b: f32 where ZERO_OR_MORE => "0.0042",
            /// In µm⁴.
            c: f32 where ZERO_OR_MORE = "0" => "0.0001",
        },
        /// By Sellmeier's equation `n² = 1 + Σ b λ²/(λ² - c)`, λ in micrometers; gives the index, too.
        Sellmeier {
            /// The strengths of three resonances.
            b: Rgb where ZERO_OR_MORE => "(1.0396, 0.2318, 1.0105)",
            /// The squares of their wavelengths, in µm², none of them visible.
            c: Rgb where ZERO_OR_MORE => "(0.0060, 0.0200, 103.56)",
        },
    }

    /// Sides of a surface.
    choice Sides {
        /// The one that the normal points to: the outside of solids.
        Front {},
        /// Both.
        Both {},
    }

    /// How a reflectance is computed.
    choice Fresnel {
        /// By the Fresnel equations.
        Exact {},
        /// Schlick's approximation.
        Schlick {},
        /// Schlick's approximation with the angle in the thinner medium. For dielectrics.
        SchlickThetaM {},
    }
}
