//! The part of the light that a rough surface is expected to send on: tables from theory, for the [`ledger`](crate::ledger).
//!
//! The tables come from quadratures of the model ([`brewster_optics::albedo`]), which draw no sample. No picture depends
//! on them.

use brewster_buffers::SceneBuffers;
use brewster_optics::albedo::{at_cosine, average, rough_boundary, rough_dielectric, rough_mirror};
use brewster_optics::conductor::F82Tint;
use brewster_optics::fresnel::{FresnelModel, conductor_color};
use brewster_optics::layered::Coat;
use brewster_optics::microfacet::Ggx;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::media::Medium;

/// Intervals of a table of albedo.
const STEPS: usize = 24;

/// Intervals of a table of what facets reflect.
const FINE_STEPS: usize = 1000;

/// A color over a cosine, at equal steps of its square root.
#[derive(Clone, Debug)]
struct Table(Box<[Vec3]>);

impl Table {
    /// Albedo over the cosine of the view.
    fn new(albedo: impl Fn(DVec3) -> DVec3) -> Table {
        // No view is quite at the horizon.
        Table::over_roots(STEPS, |root| albedo(at_cosine(f64::from(root.max(0.02)).powi(2))).as_vec3())
    }

    fn over_roots(steps: usize, color: impl Fn(f32) -> Vec3) -> Table {
        Table((0..=steps).map(|step| color(step as f32 / steps as f32)).collect())
    }

    #[inline(always)]
    fn at(&self, cosine: f32) -> Vec3 {
        let steps = self.0.len() - 1;
        let place = cosine.clamp(0.0, 1.0).sqrt() * steps as f32;
        let step = (place as usize).min(steps - 1);
        self.0[step].lerp(self.0[step + 1], place - step as f32)
    }
}

/// The tables of a scene's rough metals and dielectrics.
#[derive(Clone, Debug, Default)]
pub struct Albedos {
    /// Media that a place can be filled with, vacuum among them.
    media: usize,
    /// For each metal and each medium in front of it.
    metals: Vec<Option<Table>>,
    /// For each metal whose color varies: what it reflects with R_0 = 1 beyond what it reflects with 0.
    metal_slopes: Vec<Option<Table>>,
    /// For each dielectric, each medium on its other side, from there and from inside.
    dielectrics: Vec<Option<Table>>,
    /// For each coat and each medium in front of it: what its facets reflect, and what share of the base's color comes out.
    coats: Vec<Option<Table>>,
}

impl Albedos {
    /// Tables for everything rough; a table takes some 20 ms.
    pub fn new(scene: &SceneBuffers) -> Albedos {
        let (metals, dielectrics) = (scene.materials.metal.view(), scene.materials.dielectric.view());
        let coats = scene.materials.coated.view();
        let media = dielectrics.len() + 1;
        let is_rough = |alpha: f32| !Ggx::isotropic(alpha).is_smooth();
        let ior = |medium: usize| if medium == 0 { 1.0 } else { dielectrics.ior[medium - 1] };
        let mirror = |alpha: f32, color: &dyn Fn(f32) -> Vec3| {
            let alpha = f64::from(alpha);
            Table::new(|view| rough_mirror(view, [alpha; 2], |cosine| color(cosine as f32).as_dvec3()))
        };
        // What costs too much to be asked for every facet.
        let facets = |color: &dyn Fn(f32) -> Vec3| Table::over_roots(FINE_STEPS, |root| color(root * root));
        let metal = |index: usize| {
            let (row, medium) = (index / media, index % media);
            let metal = metals.get(row);
            let exact = metal.fresnel == FresnelModel::Exact;
            is_rough(metal.alpha).then(|| match (metal.film, exact) {
                (Some(film), _) => {
                    let colors = facets(&|cosine| film.reflectance(cosine, ior(medium), metal.eta, metal.k));
                    mirror(metal.alpha, &|cosine| colors.at(cosine))
                }
                (None, true) => mirror(metal.alpha, &|cosine| conductor_color(cosine, ior(medium), metal.eta, metal.k)),
                (None, false) => {
                    mirror(metal.alpha, &|cosine| F82Tint::new(Vec3::ZERO, metal.r90, metal.f82).reflectance(cosine))
                }
            })
        };
        let slope = |row: usize| {
            let metal = metals.get(row);
            let of = |r0| F82Tint::new(r0, metal.r90, metal.f82);
            let (black, white) = (of(Vec3::ZERO), of(Vec3::ONE));
            (is_rough(metal.alpha) && metal.fresnel != FresnelModel::Exact)
                .then(|| mirror(metal.alpha, &|cosine| white.reflectance(cosine) - black.reflectance(cosine)))
        };
        let dielectric = |index: usize| {
            let (row, medium, inside) = (index / (2 * media), index / 2 % media, index % 2 == 1);
            let alpha = f64::from(dielectrics.alpha[row]);
            let (own, other) = (f64::from(dielectrics.ior[row]), f64::from(ior(medium)));
            let [eta_i, eta_t] = if inside { [own, other] } else { [other, own] };
            let albedo = |view| {
                let albedo = rough_dielectric(view, [alpha; 2], eta_i, eta_t);
                DVec3::splat(albedo.reflected + albedo.transmitted)
            };
            is_rough(dielectrics.alpha[row]).then(|| match dielectrics.film[row] {
                Some(film) => {
                    let color = |cosine| film.reflectance(cosine, eta_i as f32, Vec3::splat(eta_t as f32), Vec3::ZERO);
                    let colors = facets(&color);
                    Table::new(|view| {
                        rough_boundary(view, [alpha; 2], eta_i / eta_t, |cosine| colors.at(cosine as f32).as_dvec3())
                    })
                }
                None => Table::new(albedo),
            })
        };
        let coat = |index: usize| {
            let (row, medium) = (index / media, index % media);
            let (alpha, eta) = (coats.alpha[row], coats.ior[row] / ior(medium));
            let coat = Coat::new(Ggx::isotropic(alpha), eta);
            let through = |view: DVec3| f64::from(coat.through(view.as_vec3()));
            is_rough(alpha).then(|| {
                let fresnel = |cosine| FresnelModel::Exact.dielectric(cosine as f32, 1.0, eta).reflectance;
                let out = average(|cosine| through(at_cosine(cosine))) / f64::from(coat.mean_through());
                Table::new(|view| {
                    let highlight =
                        rough_mirror(view, [f64::from(alpha); 2], |cosine| DVec3::splat(fresnel(cosine).into()));
                    DVec3::new(highlight.x, through(view) * out, 0.0)
                })
            })
        };
        Albedos {
            media,
            coats: (0..coats.len() * media).into_par_iter().map(coat).collect(),
            metals: (0..metals.len() * media).into_par_iter().map(metal).collect(),
            metal_slopes: (0..metals.len()).into_par_iter().map(slope).collect(),
            dielectrics: (0..dielectrics.len() * 2 * media).into_par_iter().map(dielectric).collect(),
        }
    }

    /// What a rough metal reflects of the light from a direction; `r0` counts where no index is given.
    #[inline(always)]
    pub fn metal(&self, row: u32, medium: Medium, r0: Vec3, cosine: f32) -> Option<Vec3> {
        let base = self.metals.get(row as usize * self.media + number(medium))?.as_ref()?.at(cosine);
        Some(self.metal_slopes[row as usize].as_ref().map_or(base, |slope| base + r0 * slope.at(cosine)))
    }

    /// What a rough coat reflects of the light from a direction, and what share of the base's color comes out of it.
    #[inline(always)]
    pub fn coat(&self, row: u32, medium: Medium, cosine: f32) -> Option<(f32, f32)> {
        let found = self.coats.get(row as usize * self.media + number(medium))?.as_ref()?.at(cosine);
        Some((found.x, found.y))
    }

    /// What a rough dielectric reflects and transmits of the light from a direction, with these media on the viewer's side and
    /// beyond.
    #[inline(always)]
    pub fn dielectric(&self, row: u32, filling: [Medium; 2], cosine: f32) -> Option<Vec3> {
        let inside = filling[0] == Medium(row);
        let other = number(filling[usize::from(inside)]);
        let index = (row as usize * self.media + other) * 2 + usize::from(inside);
        Some(self.dielectrics.get(index)?.as_ref()?.at(cosine))
    }
}

/// A medium's number among a table's: 0 for vacuum.
#[inline(always)]
fn number(medium: Medium) -> usize {
    medium.0.wrapping_add(1) as usize
}
