//! Materials, split by kind so that a shading stage reads columns of one kind only.

use brewster_lanes::columns;
use brewster_optics::dispersion::DispersiveIndex;
use brewster_optics::fresnel::FresnelModel;
use brewster_optics::thin_film::Film;
use glam::Vec3;

use crate::ColorSource;

/// The kinds of material; hits are sorted by it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u8)]
pub enum MaterialKind {
    /// Ambient, diffuse and specular.
    Phong,
    /// Ideal diffuse.
    Lambert,
    /// Diffuse, with the shadows of its own roughness.
    RoughDiffuse,
    /// Opaque conductor.
    Metal,
    /// Transparent solid.
    Dielectric,
    /// Sends out light, reflects none.
    Emissive,
}

impl MaterialKind {
    /// All kinds, in the order in which a bounce shades them.
    pub const ALL: [MaterialKind; 6] = [
        MaterialKind::Phong,
        MaterialKind::Lambert,
        MaterialKind::RoughDiffuse,
        MaterialKind::Metal,
        MaterialKind::Dielectric,
        MaterialKind::Emissive,
    ];

    /// The name used in counters and reports.
    pub fn name(self) -> &'static str {
        match self {
            MaterialKind::Phong => "phong",
            MaterialKind::Lambert => "lambert",
            MaterialKind::RoughDiffuse => "rough diffuse",
            MaterialKind::Metal => "metal",
            MaterialKind::Dielectric => "dielectric",
            MaterialKind::Emissive => "emissive",
        }
    }
}

columns! {
    /// Where a material's parameters are. Its row index is its `MaterialId`.
    pub struct MaterialRow => MaterialRowColumns, MaterialRowsView, MaterialRowsViewMut {
        /// Which columns.
        pub kind: MaterialKind,
        /// Which row of them.
        pub row: u32,
        /// The entity's scene key; rows are in its order.
        pub key: u64,
    }
}

columns! {
    /// Ambient + diffuse + specular.
    pub struct Phong => PhongColumns, PhongsView, PhongsViewMut {
        /// Reflectance for ambient light.
        pub ambient: ColorSource,
        /// Albedo.
        pub diffuse: ColorSource,
        /// Factor of the highlight.
        pub specular: ColorSource,
        /// Exponent of the highlight.
        pub exponent: f32,
    }
}

columns! {
    /// Ideal diffuse reflection.
    pub struct Lambert => LambertColumns, LambertsView, LambertsViewMut {
        /// Albedo.
        pub albedo: ColorSource,
    }
}

columns! {
    /// Diffuse reflection of a rough surface: `brewster_optics::rough_diffuse`.
    pub struct RoughDiffuse => RoughDiffuseColumns, RoughDiffusesView, RoughDiffusesViewMut {
        /// Albedo.
        pub albedo: ColorSource,
        /// 0 is Lambert's surface, 1 the roughest.
        pub roughness: f32,
    }
}

columns! {
    /// An opaque conductor.
    pub struct Metal => MetalColumns, MetalsView, MetalsViewMut {
        /// Reflectance at normal incidence; where an index is given it follows from it.
        pub r0: ColorSource,
        /// Real part of the index per channel; read by `FresnelModel::Exact` only.
        pub eta: Vec3,
        /// Imaginary part of the index per channel; read by `FresnelModel::Exact` only.
        pub k: Vec3,
        /// `Exact` or `Schlick`.
        pub fresnel: FresnelModel,
        /// The color near grazing incidence, at 82°, as a factor of Schlick's curve: white is that curve. Read by
        /// `FresnelModel::Schlick` only.
        pub f82: Vec3,
        /// GGX width, 0 (a mirror) to 1.
        pub alpha: f32,
        /// A film on it; read by `FresnelModel::Exact` only.
        pub film: Option<Film>,
        /// Factor of the highlight, beside R_0.
        pub specular: ColorSource,
        /// Exponent of the highlight.
        pub exponent: f32,
    }
}

columns! {
    /// A transparent solid, and the medium inside it.
    pub struct Dielectric => DielectricColumns, DielectricsView, DielectricsViewMut {
        /// Index of refraction; with dispersion that at the d line.
        pub ior: f32,
        /// How the index depends on the wavelength, if it does; read by `Path` only, and not where `thin`.
        pub dispersion: Option<DispersiveIndex>,
        /// How F_r is computed.
        pub fresnel: FresnelModel,
        /// Factor of the highlight, beside F_r or F_t.
        pub specular: ColorSource,
        /// Exponent of the highlight.
        pub exponent: f32,
        /// Beer-Lambert coefficient per meter.
        pub absorption: Vec3,
        /// Where media overlap the highest fills the place; at equal priority the one entered last.
        pub priority: i32,
        /// GGX width, 0 (smooth) to 1.
        pub alpha: f32,
        /// A film on it; read by `FresnelModel::Exact` only.
        pub film: Option<Film>,
        /// Whether it is a sheet too thin to be inside of: light passes straight on, and no medium is entered.
        pub thin: bool,
    }
}

columns! {
    /// A surface that sends out light.
    pub struct Emissive => EmissiveColumns, EmissivesView, EmissivesViewMut {
        /// Radiance in nit.
        pub radiance: ColorSource,
        /// Whether it shines from both sides. Otherwise only from where its normal points: out of a closed shape, from the
        /// side of a triangle that its corners run counterclockwise on.
        pub two_sided: bool,
    }
}

/// All materials.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Materials {
    /// One row a material: its kind and where its parameters are.
    pub rows: MaterialRowColumns,
    /// Parameters of [`MaterialKind::Phong`].
    pub phong: PhongColumns,
    /// Parameters of [`MaterialKind::Lambert`].
    pub lambert: LambertColumns,
    /// Parameters of [`MaterialKind::RoughDiffuse`].
    pub rough_diffuse: RoughDiffuseColumns,
    /// Parameters of [`MaterialKind::Metal`].
    pub metal: MetalColumns,
    /// Parameters of [`MaterialKind::Dielectric`].
    pub dielectric: DielectricColumns,
    /// Parameters of [`MaterialKind::Emissive`].
    pub emissive: EmissiveColumns,
}
