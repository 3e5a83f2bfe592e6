//! Rays and what they met, with the names of the scene file.

use brewster_buffers::MaterialKind;
use brewster_wavefront::explain::{ExplainedRay, Filled, Found, Fresnel, LightSource, Met, Surface};
use brewster_wavefront::media::Medium;
use brewster_wavefront::queues::End;
use serde::Serialize;

use super::radiance;
use crate::Session;
use crate::origin::{entity_name, key_name, material_name};

/// A ray of a path.
#[derive(Clone, Debug, Serialize)]
pub struct NamedRay {
    /// The number of the ray that sent it.
    pub parent: Option<usize>,
    /// Its depth.
    pub depth: u32,
    /// The queue that it waited in.
    pub queue: &'static str,
    /// Where it starts, in meters.
    pub origin: [f32; 3],
    /// Where it goes.
    pub direction: [f32; 3],
    /// What a unit of radiance along it adds to the sample, as it set out.
    pub weight: [f32; 3],
    /// The same behind the medium on its way.
    pub weight_there: [f32; 3],
    /// The Beer-Lambert factor of that medium.
    pub transmittance: [f32; 3],
    /// The medium.
    pub medium: NamedMedium,
    /// The wavelength in nanometers that it stands for, once a boundary has dispersed it.
    pub wavelength: Option<f32>,
    /// How far it comes, in meters; none if it meets nothing.
    pub distance: Option<f32>,
    /// `nothing`, `no boundary`, `medium` where that scatters it, or `surface`.
    pub met: &'static str,
    /// The surface.
    pub surface: Option<NamedSurface>,
    /// Surfaces that it went through because they were not there.
    pub passed: u64,
    /// What became of rays that were not sent on.
    pub ends: Vec<&'static str>,
    /// Light that it found, and rays toward lights.
    pub lights: Vec<NamedLight>,
}

/// What fills a place.
#[derive(Clone, Debug, Serialize)]
pub struct NamedMedium {
    /// The material's name or kind; `vacuum` for none.
    pub name: String,
    /// Its index of refraction.
    pub ior: f32,
}

/// A hit.
#[derive(Clone, Debug, Serialize)]
pub struct NamedSurface {
    /// The entity, by its name or its key.
    pub entity: String,
    /// The material, by its name or its kind.
    pub material: String,
    /// The kind of material that was met: of a mix the one that chance chose.
    pub kind: Option<&'static str>,
    /// Where, in world space.
    pub position: [f32; 3],
    /// Cosine of the angle of incidence.
    pub cosine: Option<f32>,
    /// What is in front of the surface and behind it, where light may go through.
    pub media: Option<[NamedMedium; 2]>,
    /// How a smooth boundary splits light there.
    pub fresnel: Option<NamedFresnel>,
    /// The same of the boundaries that a principled or coated surface has, the outermost first.
    pub layers: Vec<NamedLayer>,
}

/// One of several boundaries.
#[derive(Clone, Debug, Serialize)]
pub struct NamedLayer {
    /// `clearcoat`, `transmission`, `coat` or `metal below`.
    pub name: &'static str,
    /// How it splits light.
    pub fresnel: NamedFresnel,
}

/// How a boundary splits light, by channel.
#[derive(Clone, Debug, Serialize)]
pub struct NamedFresnel {
    /// `Exact`, `Schlick` or `SchlickThetaM`.
    pub model: String,
    /// GGX width; 0 where smooth. Of rough surfaces the other numbers are those of the mean plane.
    pub alpha: f32,
    /// Index on the side of the ray.
    pub eta_i: f32,
    /// Index on the other side.
    pub eta_t: Option<[f32; 3]>,
    /// Imaginary part of a metal's index.
    pub k: Option<[f32; 3]>,
    /// Reflectance of light polarized perpendicular to the plane of incidence.
    pub r_s: Option<[f32; 3]>,
    /// Reflectance of light polarized parallel to it.
    pub r_p: Option<[f32; 3]>,
    /// What is reflected, by the model.
    pub f_r: [f32; 3],
    /// What is transmitted.
    pub f_t: [f32; 3],
    /// Whether it is total internal reflection.
    pub total: bool,
}

/// Light that was found, or that something stood before.
#[derive(Clone, Debug, Serialize)]
pub struct NamedLight {
    /// `light`, by a ray sent there; `emitter` that the ray met; `background`; or `surface`, lit from everywhere or no number.
    pub by: &'static str,
    /// The light's or emitter's name.
    pub name: Option<String>,
    /// Whether it is seen: false where something stands before a light.
    pub visible: bool,
    /// Radiance times weight; before the clamp and, where not visible, what was stopped.
    pub radiance: [f32; 3],
    /// What the film got, in units of 2^-32; none if it was no light.
    pub units: Option<[i64; 3]>,
}

impl NamedLight {
    /// What the film got.
    pub fn film(&self) -> Option<[f64; 3]> {
        self.units.map(|units| radiance(brewster_film::Light(units)))
    }
}

impl NamedRay {
    pub(super) fn new(session: &Session, explained: &ExplainedRay) -> NamedRay {
        let ExplainedRay { parent, depth, source, ray, medium, distance, transmittance, met, passed, ends, .. } =
            explained;
        let (met, surface) = match met {
            Met::Nothing => ("nothing", None),
            Met::NoBoundary { instance, position } => {
                let surface = NamedSurface {
                    entity: entity_name(session, *instance),
                    material: material_name(session, *instance),
                    kind: None,
                    position: position.to_array(),
                    cosine: None,
                    media: None,
                    fresnel: None,
                    layers: Vec::new(),
                };
                ("no boundary", Some(surface))
            }
            Met::Medium { .. } => ("medium", None),
            Met::Surface(surface) => ("surface", Some(NamedSurface::new(session, surface))),
        };
        let ends = [
            ("totally reflected", ends.totally_reflected),
            ("cut by depth", ends.cut_by_depth),
            ("below threshold", ends.below_threshold),
            ("given up", ends.given_up),
            ("absorbed", ends.absorbed),
        ];
        let own = explained.lights.iter().map(|found| found_light(found, surface.as_ref()));
        let sent = explained.shadows.iter().map(|shadow| {
            let name = match shadow.source {
                LightSource::Light(row) => key_name(session, session.buffers().lights.get(row as usize).key, "light"),
                LightSource::Emitter(instance) => entity_name(session, instance),
                LightSource::Background => "background".to_owned(),
            };
            let radiance = shadow.found.map_or(shadow.sent, |found| found.radiance).to_array();
            let units = match shadow.found {
                Some(found) => found.light.map(|light| light.0),
                None => Some([0; 3]),
            };
            NamedLight { by: "light", name: Some(name), visible: shadow.found.is_some(), radiance, units }
        });
        let lights = own.chain(sent).collect();
        NamedRay {
            parent: *parent,
            depth: *depth,
            queue: source.name(),
            origin: ray.origin().to_array(),
            direction: ray.direction().to_array(),
            weight: ray.weight.to_array(),
            weight_there: (ray.weight * *transmittance).to_array(),
            transmittance: transmittance.to_array(),
            medium: NamedMedium::new(session, medium),
            wavelength: ray.wavelength.get().map(|wavelength| wavelength.nanometers),
            distance: distance.is_finite().then_some(*distance),
            met,
            surface,
            passed: *passed,
            ends: ends.into_iter().filter(|&(_, count)| count > 0).map(|(end, _)| end).collect(),
            lights,
        }
    }
}

fn found_light(found: &Found, surface: Option<&NamedSurface>) -> NamedLight {
    let (by, name) = match found.end {
        Some(End::Background) => ("background", None),
        Some(End::Emitter) => ("emitter", surface.map(|surface| surface.entity.clone())),
        Some(End::Light) => ("light", None),
        Some(End::Surface) | None => ("surface", None),
    };
    let units = found.light.map(|light| light.0);
    NamedLight { by, name, visible: true, radiance: found.radiance.to_array(), units }
}

impl NamedSurface {
    fn new(session: &Session, surface: &Surface) -> NamedSurface {
        let Surface { instance, kind, position, cosine, media, fresnel, layers } = surface;
        NamedSurface {
            entity: entity_name(session, *instance),
            material: material_name(session, *instance),
            kind: Some(kind.name()),
            position: position.to_array(),
            cosine: Some(*cosine),
            media: media.as_ref().map(|media| media.each_ref().map(|filled| NamedMedium::new(session, filled))),
            fresnel: fresnel.as_ref().map(NamedFresnel::new),
            layers: layers
                .iter()
                .map(|(name, fresnel)| NamedLayer { name, fresnel: NamedFresnel::new(fresnel) })
                .collect(),
        }
    }
}

impl NamedMedium {
    fn new(session: &Session, filled: &Filled) -> NamedMedium {
        let materials = &session.buffers().materials;
        let is_filled = |row: &usize| materials.medium(materials.rows.get(*row)) == Some(filled.medium.0);
        let name = match filled.medium {
            Medium::VACUUM => "vacuum".to_owned(),
            _ => (0..materials.rows.len()).find(is_filled).map_or("dielectric".to_owned(), |row| {
                key_name(session, materials.rows.view().key[row], MaterialKind::Dielectric.name())
            }),
        };
        NamedMedium { name, ior: filled.ior }
    }
}

impl NamedFresnel {
    fn new(fresnel: &Fresnel) -> NamedFresnel {
        let Fresnel { model, alpha, eta_i, eta_t, k, r_s, r_p, f_r, f_t, is_total } = *fresnel;
        let [eta_t, k, r_s, r_p] = [eta_t, k, r_s, r_p].map(|color| color.map(|color| color.to_array()));
        let (f_r, f_t) = (f_r.to_array(), f_t.to_array());
        NamedFresnel { model: format!("{model:?}"), alpha, eta_i, eta_t, k, r_s, r_p, f_r, f_t, total: is_total }
    }
}
