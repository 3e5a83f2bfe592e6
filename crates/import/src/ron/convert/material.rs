//! Materials: names of metals and glasses into indices, roughness into width, and which integrator renders what.

use brewster_optics::dispersion::{Cauchy, Sellmeier};
use brewster_optics::{fresnel, glasses, metals};
use brewster_world::components as world;
use brewster_world::components::parts::{DispersiveIndex, Film, FresnelModel, Integrator};
use glam::Vec3;

use crate::diagnostics::Code;
use crate::ron::schema::{self, Paint};
use crate::ron::values::{Rgb, Spanned};
use crate::session::Session;
use crate::source::Span;

use super::detail::detail;
use super::principled::principled;
use super::texture::{albedo, paint};

/// A material, and its detail.
pub(crate) fn material(
    session: &mut Session,
    material: &Spanned<schema::Material>,
) -> Option<(world::Material, Option<world::Detail>)> {
    match &material.value {
        detailed @ schema::Material::Detailed { of, .. } => {
            let detail = detail(session, detailed)?;
            if matches!(of.value, schema::Material::Medium { .. }) {
                session.error(Code::Conflict, of.span, "a medium without a surface has no details");
                return None;
            }
            Some((plain(session, of)?, Some(detail)))
        }
        _ => Some((plain(session, material)?, None)),
    }
}

/// A material without detail.
fn plain(session: &mut Session, material: &Spanned<schema::Material>) -> Option<world::Material> {
    let span = material.span;
    let material = bare(session, &material.value, span)?;
    session.refuse_unless_rendered(&material, span);
    Some(material)
}

impl Session<'_> {
    /// Remembers a material that the integrator does not render.
    pub(crate) fn refuse_unless_rendered(&mut self, material: &world::Material, span: Span) {
        if let Some(what) = not_rendered(self.integrator, material) {
            self.refused.push((span, what));
        }
    }
}

/// A material, whatever renders it.
fn bare(session: &mut Session, material: &schema::Material, span: Span) -> Option<world::Material> {
    Some(match material {
        schema::Material::Phong { ambient, diffuse, specular, exponent } => world::Material::Phong {
            ambient: match ambient {
                Some(ambient) => albedo(session, ambient, "ambient", span)?,
                None => paint(session, diffuse)?,
            },
            diffuse: albedo(session, diffuse, "diffuse", span)?,
            specular: paint(session, specular)?,
            exponent: *exponent,
        },
        schema::Material::Lambert { albedo: color } => {
            world::Material::Lambert { albedo: albedo(session, color, "albedo", span)? }
        }
        schema::Material::RoughDiffuse { albedo: color, roughness } => {
            world::Material::RoughDiffuse { albedo: albedo(session, color, "albedo", span)?, roughness: *roughness }
        }
        schema::Material::Metal {
            r0,
            eta,
            k,
            of,
            edge_tint,
            r90,
            f82,
            fresnel,
            alpha,
            roughness,
            film,
            compensated,
            specular,
            exponent,
        } => {
            let reflectance = reflectance(session, (r0, eta, k, of), span)?;
            let reflectance = tinted(session, reflectance, (*edge_tint, *r90, *f82), span)?;
            let has_index = !matches!(reflectance, world::Reflectance::Normal { .. });
            let fresnel = metal_fresnel(session, &reflectance, fresnel.as_ref())?;
            world::Material::Metal {
                film: self::film(session, film.as_ref(), fresnel, if has_index { EXACT } else { METAL_INDEX })?,
                fresnel,
                reflectance,
                specular: paint(session, specular)?,
                exponent: *exponent,
                alpha: width(session, (*alpha, *roughness), span)?,
                compensated: *compensated,
            }
        }
        dielectric @ schema::Material::Dielectric { .. } => self::dielectric(session, dielectric, span)?,
        medium @ schema::Material::Medium { .. } => self::medium(medium)?,
        principled @ schema::Material::Principled { .. } => {
            world::Material::Principled(Box::new(self::principled(session, principled, span)?))
        }
        coated @ schema::Material::Coated { .. } => self::coated(session, coated, span)?,
        schema::Material::Mix { a, b, by } => {
            let mut part = |material: &Spanned<schema::Material>| {
                let part = plain(session, material)?;
                let has_inside = match &part {
                    world::Material::Dielectric { thin, .. } => !thin,
                    world::Material::Principled(principled) => principled.volume.is_some(),
                    _ => false,
                };
                if has_inside {
                    session.error(Code::Conflict, material.span, "a mix is not of what has an inside");
                }
                Some(Box::new(part))
            };
            let (a, b) = (part(a), part(b));
            world::Material::Mix { a: a?, b: b?, by: super::texture::part(session, by)? }
        }
        schema::Material::Detailed { .. } => {
            session.error(Code::Conflict, span, "detail is for the whole of a material, and once");
            return None;
        }
        schema::Material::Emissive { radiance, sides } => world::Material::Emissive {
            radiance: paint(session, radiance)?,
            two_sided: matches!(sides, schema::Sides::Both {}),
        },
    })
}

fn coated(session: &mut Session, material: &schema::Material, span: Span) -> Option<world::Material> {
    let schema::Material::Coated { base, ior, alpha, roughness, absorption, thickness } = material else {
        return None;
    };
    if !matches!(*base.value, schema::Material::Lambert { .. } | schema::Material::Metal { .. }) {
        let error = session.sources.error(Code::Conflict, base.span, "a coat does not lie over this material");
        session.found.push(error.expected("`Lambert` or `Metal`"));
        return None;
    }
    Some(world::Material::Coated {
        base: Box::new(bare(session, &base.value, base.span)?),
        ior: *ior,
        alpha: width(session, (*alpha, *roughness), span)?,
        absorption: absorption.0,
        thickness: *thickness,
    })
}

/// What the material has that the integrator does not render. The integrators' table says what they do with the rest.
fn not_rendered(integrator: Integrator, material: &world::Material) -> Option<&'static str> {
    match (integrator, material) {
        (Integrator::Whitted, world::Material::Principled(_)) => Some("principled materials"),
        (Integrator::Whitted, world::Material::Coated { .. }) => Some("coated materials"),
        (Integrator::Whitted, world::Material::RoughDiffuse { .. }) => Some("rough diffuse materials"),
        (Integrator::Whitted, world::Material::Metal { alpha, .. }) if *alpha > 0.0 => Some("rough metals"),
        (Integrator::Whitted, world::Material::Dielectric { alpha, .. }) if *alpha > 0.0 => Some("rough dielectrics"),
        (Integrator::Whitted, world::Material::Dielectric { thin: true, .. }) => Some("thin dielectrics"),
        (Integrator::Whitted, world::Material::Dielectric { bare: true, .. }) => Some("media without a surface"),
        (Integrator::Whitted, world::Material::Dielectric { scattering, .. })
            if scattering.coefficient != Vec3::ZERO =>
        {
            Some("media that scatter")
        }
        (
            Integrator::Whitted,
            world::Material::Metal { film: Some(_), .. } | world::Material::Dielectric { film: Some(_), .. },
        ) => Some("thin films"),
        (Integrator::Whitted, world::Material::Dielectric { dispersion: Some(_), .. }) => Some("dispersion"),
        (Integrator::Path, world::Material::Phong { .. }) => Some("Phong materials"),
        _ => None,
    }
}

fn dielectric(session: &mut Session, material: &schema::Material, span: Span) -> Option<world::Material> {
    let schema::Material::Dielectric {
        ior,
        reflectance,
        glass,
        dispersion,
        fresnel,
        alpha,
        roughness,
        film,
        thin,
        specular,
        exponent,
        absorption,
        scattering,
        anisotropy,
        priority,
    } = material
    else {
        return None;
    };
    let alpha = width(session, (*alpha, *roughness), span)?;
    if *thin && alpha > 0.0 {
        session.error(Code::Conflict, span, "a thin sheet is smooth: `alpha` and `roughness` do not go with `thin`");
    }
    if *thin && absorption.0 != Vec3::ZERO {
        session.error(Code::Conflict, span, "a thin sheet has no inside: `absorption` does not go with `thin`");
    }
    if *thin && scattering.0 != Vec3::ZERO {
        session.error(Code::Conflict, span, "a thin sheet has no inside: `scattering` does not go with `thin`");
    }
    if *thin && dispersion.is_some() {
        session.error(
            Code::Conflict,
            span,
            "light goes straight through a thin sheet: `dispersion` does not go with `thin`",
        );
    }
    let fresnel = fresnel_model(fresnel);
    let (ior, dispersion) = index(session, (*ior, *reflectance, glass), dispersion.as_ref(), span)?;
    Some(world::Material::Dielectric {
        dispersion,
        film: self::film(session, film.as_ref(), fresnel, EXACT)?,
        ior,
        fresnel,
        specular: paint(session, specular)?,
        exponent: *exponent,
        absorption: absorption.0,
        scattering: world::Scattering { coefficient: scattering.0, anisotropy: *anisotropy },
        bare: false,
        priority: *priority,
        alpha,
        thin: *thin,
    })
}

/// What fills a shape without a surface: a dielectric whose surface is that of its index alone.
fn medium(material: &schema::Material) -> Option<world::Material> {
    let &schema::Material::Medium { absorption, scattering, anisotropy, ior, priority } = material else { return None };
    Some(world::Material::Dielectric {
        ior,
        dispersion: None,
        fresnel: FresnelModel::Exact,
        specular: world::Color::WHITE,
        exponent: 100.0,
        absorption: absorption.0,
        scattering: world::Scattering { coefficient: scattering.0, anisotropy },
        bare: true,
        priority,
        alpha: 0.0,
        film: None,
        thin: false,
    })
}

/// The film on a surface; `expected` says what it would go with.
fn film(
    session: &mut Session,
    film: Option<&schema::Film>,
    fresnel: FresnelModel,
    expected: &str,
) -> Option<Option<Film>> {
    let Some(film) = film else { return Some(None) };
    if fresnel == FresnelModel::Exact {
        return Some(Some(Film { ior: film.ior, thickness: film.thickness }));
    }
    let error = session.sources.error(Code::Conflict, film.span, "a film needs the Fresnel equations");
    session.found.push(error.expected(expected));
    None
}

/// The GGX width that a surface gets by `alpha`, or as the square of `roughness`.
fn width(session: &mut Session, fields: (Option<f32>, Option<f32>), span: Span) -> Option<f32> {
    match fields {
        (alpha, None) => Some(alpha.unwrap_or(0.0)),
        (None, Some(roughness)) => Some(roughness * roughness),
        (Some(_), Some(_)) => {
            let error = session.sources.error(Code::Conflict, span, "two fields say how rough the surface is");
            session.found.push(error.expected("one of: `alpha`, `roughness`"));
            None
        }
    }
}

const EXACT: &str = "`fresnel: Exact`";

/// What gives a metal an index.
const METAL_INDEX: &str = "`eta` and `k`, or `of`, or `edge_tint` beside `r0`";

const METAL_FIELDS: &str = "one of: `r0`, `eta` and `k`, `of`";

type ReflectanceFields<'m> = (&'m Option<Paint>, &'m Option<Rgb>, &'m Option<Rgb>, &'m Option<Spanned<String>>);

fn reflectance(session: &mut Session, fields: ReflectanceFields, span: Span) -> Option<world::Reflectance> {
    let (code, message) = match fields {
        (Some(r0), None, None, None) => {
            return Some(world::Reflectance::Normal { r0: paint(session, r0)?, r90: Vec3::ONE, f82: Vec3::ONE });
        }
        (None, Some(eta), Some(k), None) => return Some(world::Reflectance::Index { eta: eta.0, k: k.0 }),
        (None, None, None, Some(name)) => {
            let found = metals::metal(&name.value);
            if found.is_none() {
                let message = format!("there is no measured metal {:?}", name.value);
                let error = session.sources.error(Code::UnknownName, name.span, message);
                session.found.push(error.nearest_name(&name.value, metals::metal_names()));
            }
            return found.map(|metal| world::Reflectance::Index { eta: metal.eta, k: metal.k });
        }
        (None, Some(_), None, None) | (None, None, Some(_), None) => {
            session.error(Code::MissingField, span, "an index needs both `eta` and `k`");
            return None;
        }
        (None, None, None, None) => (Code::MissingField, "nothing says what the metal reflects"),
        _ => (Code::Conflict, "more than one field says what the metal reflects"),
    };
    session.found.push(session.sources.error(code, span, message).expected(METAL_FIELDS));
    None
}

/// The reflectance with what `edge_tint`, or `r90` and `f82`, say of its edge.
fn tinted(
    session: &mut Session,
    reflectance: world::Reflectance,
    tints: (Option<Rgb>, Option<Rgb>, Option<Rgb>),
    span: Span,
) -> Option<world::Reflectance> {
    let (message, expected) = match (reflectance, tints) {
        (reflectance, (None, None, None)) => return Some(reflectance),
        (world::Reflectance::Normal { r0, .. }, (None, r90, f82)) => {
            let [r90, f82] = [r90, f82].map(|color| color.map_or(Vec3::ONE, |color| color.0));
            return Some(world::Reflectance::Normal { r0, r90, f82 });
        }
        (world::Reflectance::Normal { r0: world::Color::Constant(r0), .. }, (Some(edge_tint), None, None)) => {
            return Some(world::Reflectance::EdgeTint { r0, edge_tint: edge_tint.0 });
        }
        (world::Reflectance::Normal { .. }, (Some(_), None, None)) => {
            ("an edge tint needs the same `r0` everywhere", "a color for `r0`, or `f82`")
        }
        (world::Reflectance::Normal { .. }, (Some(_), ..)) => {
            ("two fields say what the metal's edge looks like", "`edge_tint`, or `r90` and `f82`")
        }
        _ => ("an index says what the metal's edge looks like", "`r0` beside `edge_tint`, `r90` or `f82`"),
    };
    session.found.push(session.sources.error(Code::Conflict, span, message).expected(expected));
    None
}

fn metal_fresnel(
    session: &mut Session,
    reflectance: &world::Reflectance,
    fresnel: Option<&Spanned<schema::Fresnel>>,
) -> Option<FresnelModel> {
    let has_index = !matches!(reflectance, world::Reflectance::Normal { .. });
    let Some(fresnel) = fresnel else {
        return Some(if has_index { FresnelModel::Exact } else { FresnelModel::Schlick });
    };
    let (message, expected) = match fresnel.value {
        schema::Fresnel::Exact {} if !has_index => ("the Fresnel equations need an index", METAL_INDEX),
        schema::Fresnel::SchlickThetaM {} => ("`SchlickThetaM` is for dielectrics", "`Exact` or `Schlick`"),
        _ => return Some(fresnel_model(&fresnel.value)),
    };
    session.found.push(session.sources.error(Code::Conflict, fresnel.span, message).expected(expected));
    None
}

fn fresnel_model(fresnel: &schema::Fresnel) -> FresnelModel {
    match fresnel {
        schema::Fresnel::Exact {} => FresnelModel::Exact,
        schema::Fresnel::Schlick {} => FresnelModel::Schlick,
        schema::Fresnel::SchlickThetaM {} => FresnelModel::SchlickThetaM,
    }
}

/// The index, at the d line, and what it is at other wavelengths.
fn index(
    session: &mut Session,
    (ior, reflectance, glass): (Option<f32>, Option<f32>, &Option<Spanned<String>>),
    dispersion: Option<&Spanned<schema::Dispersion>>,
    span: Span,
) -> Option<(f32, Option<DispersiveIndex>)> {
    use schema::Dispersion;
    let own = dispersion.and_then(|dispersion| match dispersion.value {
        Dispersion::Cauchy { a, b, c } => Some(DispersiveIndex::Cauchy(Cauchy { a, b, c })),
        Dispersion::Sellmeier { b, c } => Some(DispersiveIndex::Sellmeier(Sellmeier { b: b.0, c: c.0 })),
        Dispersion::Abbe { .. } | Dispersion::Measured {} => None,
    });
    let mut measured = None;
    let ior = match (ior, reflectance, glass, own) {
        (Some(ior), None, None, None) => Ok(ior),
        (None, Some(reflectance), None, None) => {
            let ior = fresnel::ior_from_f0(reflectance).ok().filter(|ior| ior.is_finite());
            ior.ok_or((Code::Range, "no dielectric has this reflectance"))
        }
        (None, None, Some(name), None) => {
            measured = glasses::glass(&name.value);
            if measured.is_none() {
                let message = format!("there is no glass {:?}", name.value);
                let error = session.sources.error(Code::UnknownName, name.span, message);
                session.found.push(error.nearest_name(&name.value, glasses::glass_names()));
            }
            Ok(measured?.ior())
        }
        (None, None, None, Some(own)) if own.is_sound() => Ok(own.ior()),
        (None, None, None, Some(_)) => Err((Code::Range, "the index has a resonance in the visible range")),
        (None, None, None, None) => Err((Code::MissingField, "nothing says how the dielectric refracts")),
        _ => Err((Code::Conflict, "more than one field says how the dielectric refracts")),
    };
    let ior = match ior {
        Ok(ior) => ior,
        Err((code, message)) => {
            let error = session.sources.error(code, span, message);
            session
                .found
                .push(error.expected("one of: `ior`, `reflectance`, `glass`, or a `dispersion` that gives it"));
            return None;
        }
    };
    let dispersion = match dispersion.map(|dispersion| (&dispersion.value, dispersion.span)) {
        Some((Dispersion::Abbe { number }, _)) => Some(DispersiveIndex::Cauchy(Cauchy::from_abbe(ior, *number))),
        Some((Dispersion::Measured {}, span)) if measured.is_none() => {
            let error = session.sources.error(Code::Conflict, span, "only a glass was measured");
            session.found.push(error.expected("a `glass`, or `Abbe(number: 30)`"));
            return None;
        }
        Some((Dispersion::Measured {}, _)) => measured.map(DispersiveIndex::Glass),
        Some(_) | None => own,
    };
    Some((ior, dispersion))
}
