//! Materials, split by kind so that a shading stage reads columns of one kind only.

use brewster_lanes::columns;
use brewster_optics::dispersion::DispersiveIndex;
use brewster_optics::fresnel::FresnelModel;
use brewster_optics::thin_film::Film;
use glam::{Vec2, Vec3};

use crate::{ColorSource, Detail, DetailId, ScalarSource, TextureId};

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
    /// glTF's material.
    Principled,
    /// A clear coat over a Lambert material or a metal.
    Coated,
    /// One of two others, by chance; no hit is of this kind.
    Mix,
}

impl MaterialKind {
    /// All kinds, in the order in which a bounce shades them.
    pub const ALL: [MaterialKind; 9] = [
        MaterialKind::Phong,
        MaterialKind::Lambert,
        MaterialKind::RoughDiffuse,
        MaterialKind::Metal,
        MaterialKind::Dielectric,
        MaterialKind::Emissive,
        MaterialKind::Principled,
        MaterialKind::Coated,
        MaterialKind::Mix,
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
            MaterialKind::Principled => "principled",
            MaterialKind::Coated => "coated",
            MaterialKind::Mix => "mix",
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
        /// Its normals and its opacity, if there is more to them.
        pub detail: DetailId,
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
        /// Reflectance at grazing incidence, where Schlick's curve ends. Read by `FresnelModel::Schlick` only.
        pub r90: Vec3,
        /// The color near grazing incidence, at 82°, as a factor of Schlick's curve: white is that curve. Read by
        /// `FresnelModel::Schlick` only.
        pub f82: Vec3,
        /// GGX width, 0 (a mirror) to 1.
        pub alpha: f32,
        /// A film on it; read by `FresnelModel::Exact` only.
        pub film: Option<Film>,
        /// Whether the light that meets more than one facet is kept.
        pub compensated: bool,
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
        /// What the inside scatters, per meter; read by `Path` only.
        pub scattering: Vec3,
        /// The mean cosine by which it is turned: `brewster_optics::phase`.
        pub anisotropy: f32,
        /// Whether there is no surface where the index is the same on both sides: light goes straight on, toward lights, too.
        pub bare: bool,
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

columns! {
    /// glTF's metallic-roughness material: `brewster_optics::principled`.
    pub struct Principled => PrincipledColumns, PrincipledsView, PrincipledsViewMut {
        /// The color of what a dielectric scatters and transmits and a metal reflects.
        pub base_color: ColorSource,
        /// How much of the surface is metal.
        pub metallic: ScalarSource,
        /// Its square is the GGX width.
        pub roughness: ScalarSource,
        /// Index of refraction; 0 stands for infinity.
        pub ior: f32,
        /// Weight of a dielectric's reflection.
        pub specular: ScalarSource,
        /// Tint of a dielectric's reflection along the normal.
        pub specular_color: ColorSource,
        /// Weight of the clearcoat.
        pub clearcoat: ScalarSource,
        /// Its square is the clearcoat's GGX width.
        pub clearcoat_roughness: ScalarSource,
        /// The map of the clearcoat's normals, or `TextureId::NONE`.
        pub clearcoat_normal: TextureId,
        /// Factor of that map's components along tangent and bitangent.
        pub clearcoat_normal_scale: f32,
        /// Color of the sheen.
        pub sheen_color: ColorSource,
        /// Its square is the sheen's width.
        pub sheen_roughness: ScalarSource,
        /// How much wider facets are in one direction than across it.
        pub anisotropy: f32,
        /// That direction, from the tangent: cosine and sine.
        pub anisotropy_direction: Vec2,
        /// Red and green: the direction, turned by `anisotropy_direction`; blue: a factor of `anisotropy`.
        pub anisotropy_texture: TextureId,
        /// How much of what enters a dielectric comes out beyond.
        pub transmission: ScalarSource,
        /// How much of a dielectric's diffuse light is transmitted.
        pub diffuse_transmission: ScalarSource,
        /// The color of that.
        pub diffuse_transmission_color: ColorSource,
        /// What fills it: a row of the dielectrics, or [`Principled::NO_MEDIUM`], as in a sheet.
        pub medium: u32,
        /// How much of the surface a thin film covers.
        pub iridescence: ScalarSource,
        /// The film's index of refraction.
        pub iridescence_ior: f32,
        /// The film's thickness in nanometers, where its source is 0 and where it is 1.
        pub iridescence_thickness: [f32; 2],
        /// Which of both, or what lies between.
        pub iridescence_thickness_source: ScalarSource,
        /// Whether the metal keeps the light that meets more than one facet.
        pub compensated: bool,
        /// Radiance in nit, from both sides.
        pub emission: ColorSource,
    }
}

impl Principled {
    /// In place of a row of dielectrics.
    pub const NO_MEDIUM: u32 = u32::MAX;
}

columns! {
    /// A clear coat over another material: `brewster_optics::layered`.
    pub struct Coated => CoatedColumns, CoatedsView, CoatedsViewMut {
        /// The kind of what lies below: Lambert or metal.
        pub base: MaterialKind,
        /// Its row among those of its kind.
        pub base_row: u32,
        /// The coat's index of refraction.
        pub ior: f32,
        /// The coat's GGX width, 0 (smooth) to 1.
        pub alpha: f32,
        /// What the coat absorbs along the normal: coefficient times thickness.
        pub depth: Vec3,
    }
}

columns! {
    /// One of two materials, of which every hit meets one. Their rows are those before its own, and are no other material's.
    pub struct Mix => MixColumns, MixesView, MixesViewMut {
        /// The kind of the first and its row.
        pub a: (MaterialKind, u32),
        /// The kind of the second and its row.
        pub b: (MaterialKind, u32),
        /// How often it is the second; held in 0..1.
        pub by: ScalarSource,
    }
}

/// All materials.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Materials {
    /// One row a material: its kind and where its parameters are.
    pub rows: MaterialRowColumns,
    /// What some materials have beside their kind's parameters, in the materials' order.
    pub details: Vec<Detail>,
    /// Parameters of [`MaterialKind::Phong`].
    pub phong: PhongColumns,
    /// Parameters of [`MaterialKind::Lambert`], and of such below coats.
    pub lambert: LambertColumns,
    /// Parameters of [`MaterialKind::RoughDiffuse`].
    pub rough_diffuse: RoughDiffuseColumns,
    /// Parameters of [`MaterialKind::Metal`], and of such below coats.
    pub metal: MetalColumns,
    /// Parameters of [`MaterialKind::Dielectric`], and the insides of other materials that have one.
    pub dielectric: DielectricColumns,
    /// Parameters of [`MaterialKind::Emissive`].
    pub emissive: EmissiveColumns,
    /// Parameters of [`MaterialKind::Principled`].
    pub principled: PrincipledColumns,
    /// Parameters of [`MaterialKind::Coated`].
    pub coated: CoatedColumns,
    /// Parameters of [`MaterialKind::Mix`].
    pub mix: MixColumns,
}

impl Materials {
    /// The row of the dielectrics that is inside of a surface of a material; none if it is a sheet or opaque.
    #[inline]
    pub fn medium(&self, material: MaterialRow) -> Option<u32> {
        let row = material.row as usize;
        match material.kind {
            MaterialKind::Dielectric => (!self.dielectric.view().thin[row]).then_some(material.row),
            MaterialKind::Principled => {
                Some(self.principled.view().medium[row]).filter(|&medium| medium != Principled::NO_MEDIUM)
            }
            _ => None,
        }
    }

    /// Whether a mix may have it: not what has an inside, of which one would not know whether a path is in it.
    pub fn is_mixable(&self, (kind, row): (MaterialKind, u32)) -> bool {
        self.medium(MaterialRow { kind, row, key: 0, detail: DetailId::NONE }).is_none()
    }

    /// The row that a material has of another kind beside that of its own: what fills it, or what lies below its coat.
    pub fn second(&self, material: MaterialRow) -> Option<(MaterialKind, u32)> {
        match material.kind {
            MaterialKind::Principled => self.medium(material).map(|row| (MaterialKind::Dielectric, row)),
            MaterialKind::Coated => {
                let coated = self.coated.get(material.row as usize);
                Some((coated.base, coated.base_row))
            }
            _ => None,
        }
    }

    /// The light that a material sends out, if it is of a kind that may.
    pub fn emission(&self, material: MaterialRow) -> Option<Emissive> {
        let row = material.row as usize;
        match material.kind {
            MaterialKind::Emissive => Some(self.emissive.get(row)),
            MaterialKind::Principled => {
                Some(Emissive { radiance: self.principled.view().emission[row], two_sided: true })
            }
            _ => None,
        }
    }
}
