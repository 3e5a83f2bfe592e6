//! Materials: every entity with a [`Material`] owns a row, in the order of keys, and a row of its kind's columns.
//!
//! A material that keeps its kind and its number of textures costs one row. Anything else (one more, one less, another kind) writes
//! the tables over from the first row to the last and takes the instances along. So does an edit of a [`Detail`].

use bevy_ecs::entity::Entity;
use bevy_ecs::lifecycle::RemovedComponents;
use bevy_ecs::query::With;
use bevy_ecs::resource::Resource;
use bevy_ecs::system::{Query, ResMut};
use brewster_buffers as buffers;
use brewster_buffers::{DetailId, MaterialId, MaterialKind, MaterialRow, Materials};
use brewster_optics::conductor::index_from_edge_tint;
use brewster_optics::fresnel::{FresnelModel, f0_conductor};
use glam::Vec3;

use super::details;
use super::directory::{Directory, Owner};
use super::instances::InstanceIndex;
use super::principled;
use super::report::{FlattenReport, Problem};
use super::rows::Rows;
use super::textures::{self, TextureWriter};
use super::{Buffers, Edits};
use crate::components::{Color, Detail, Material, Reflectance, Scattering, SceneKey};
use crate::systems::{Watch, for_each_changed};

/// Which entity has which material.
#[derive(Resource, Default)]
pub(super) struct MaterialIndex {
    pub(super) directory: Directory,
    /// The first texture of each material, and then the end of the last one's.
    textures: Vec<usize>,
    /// Whether the tables have to be written over.
    stale: bool,
}

impl MaterialIndex {
    /// The material of an entity that has one.
    pub(super) fn find(&self, entity: Entity) -> Option<MaterialId> {
        self.directory.row(entity).map(MaterialId)
    }

    /// The row of an entity's material if the material can be written over the one that is there.
    fn keeps_row(&self, entity: Entity, material: &Material, materials: &Materials) -> Option<usize> {
        let row = self.directory.row(entity)? as usize;
        let textures = self.textures[row + 1] - self.textures[row];
        let before = materials.rows.get(row);
        let keeps = !matches!(material, Material::Mix { .. })
            && kind(material) == before.kind
            && count_textures(material) == textures
            && second_kind(material) == materials.second(before).map(|(kind, _)| kind)
            && check(material).is_ok()
            && !(before.detail != DetailId::NONE && matches!(material, Material::Dielectric { bare: true, .. }));
        keeps.then_some(row)
    }
}

/// Writes the row of each material that changed within its kind, unless that is not enough.
pub(super) fn flatten_changed_materials(
    (watch, keys, details): (Watch<Material>, Watch<SceneKey, With<Material>>, Watch<Detail>),
    (mut removed, mut details_gone): (RemovedComponents<Material>, RemovedComponents<Detail>),
    materials: Query<&Material>,
    mut index: ResMut<MaterialIndex>,
    mut buffers: ResMut<Buffers>,
    mut report: ResMut<FlattenReport>,
) {
    let (index, buffers) = (&mut *index, &mut buffers.0);
    let gone = |&entity: &Entity| index.directory.knows(entity) && !materials.contains(entity);
    let mut stale = removed.read().filter(gone).count() > 0;
    stale |= details_gone.read().filter(|&entity| materials.contains(entity)).count() > 0;
    for_each_changed(&details, |entity, _| stale |= materials.contains(entity));
    for_each_changed(&keys, |entity, key| stale |= index.directory.is_out_of_order(entity, key));
    let mut changed: Vec<(usize, Entity)> = Vec::new();
    for_each_changed(&watch, |entity, material| {
        if !stale {
            match index.keeps_row(entity, material, &buffers.materials) {
                Some(row) => changed.push((row, entity)),
                None => stale = true,
            }
        }
    });
    index.stale = stale;
    if stale {
        return;
    }
    for (row, entity) in changed {
        let material = materials.get(entity).expect("it has just changed");
        let before = buffers.materials.rows.get(row);
        let second = buffers.materials.second(before).map(|(_, row)| row as usize);
        let rows = (before.row as usize, second);
        let mut writer = TextureWriter::new(&mut buffers.textures.rows, index.textures[row]);
        let differs = put(&mut buffers.materials, &mut writer, material, rows);
        report.textures.rewritten += writer.edits().rewritten;
        report.materials.rewritten += usize::from(differs || !writer.edits().is_none());
    }
}

/// Where materials came, went or changed their kind: writes the tables over and gives instances the new rows of their materials.
pub(super) fn regroup_materials(
    materials: Query<(Entity, &SceneKey, &Material, Option<&Detail>)>,
    mut index: ResMut<MaterialIndex>,
    mut instances: ResMut<InstanceIndex>,
    mut edits: ResMut<Edits>,
    mut buffers: ResMut<Buffers>,
    mut report: ResMut<FlattenReport>,
) {
    let (index, buffers) = (&mut *index, &mut buffers.0);
    if !index.stale {
        return;
    }
    let mut sorted: Vec<(Owner, &Material, Option<&Detail>)> = materials
        .iter()
        .map(|(entity, key, material, detail)| (Owner { key: key.0, entity }, material, detail))
        .collect();
    sorted.sort_unstable_by_key(|(owner, ..)| owner.rank());

    index.directory.invalid.clear();
    index.textures.clear();
    let mut owners: Vec<Owner> = Vec::with_capacity(sorted.len());
    let mut written = [0; MaterialKind::ALL.len()];
    let before = buffers.materials.rows.len();
    let mut writer = TextureWriter::new(&mut buffers.textures.rows, 0);
    let mut detailed: Vec<(usize, &Detail)> = Vec::new();
    for (owner, material, detail) in sorted {
        let sound = check(material).and_then(|()| detail.map_or(Ok(()), |detail| check_detail(material, detail)));
        let sound = sound.map_err(Problem::Material).and_then(|()| owner.check_after(owners.last()));
        if let Err(problem) = sound {
            index.directory.invalid.insert(owner.entity, problem);
            continue;
        }
        index.textures.push(writer.next());
        let row = owners.len();
        let ((kind, kind_row), mut differs) = add(&mut buffers.materials, &mut writer, material, &mut written);
        let detail_row = detail.map_or(DetailId::NONE, |_| DetailId(detailed.len() as u32));
        detailed.extend(detail.map(|detail| (row, detail)));
        let material_row = MaterialRow { kind, row: kind_row, key: owner.key, detail: detail_row };
        differs |= buffers.materials.rows.put(row, material_row);
        report.materials.count(row, before, differs);
        owners.push(owner);
    }
    index.textures.push(writer.next());
    for (detail_row, &(material, detail)) in detailed.iter().enumerate() {
        let differs = buffers.materials.details.put(detail_row, details::row(&mut writer, detail));
        report.materials.rewritten += usize::from(differs && material < before);
    }
    buffers.materials.details.truncate(detailed.len());
    report.textures = writer.finish();
    report.materials.removed = before.saturating_sub(owners.len());
    truncate(&mut buffers.materials, owners.len(), written);

    let moves = index.directory.reorder(owners);
    for (source, material) in instances.sources.iter_mut().zip(buffers.instances.view_mut().material) {
        match moves.of(material.0) {
            Some(row) => {
                report.instances.rewritten += usize::from(material.0 != row);
                material.0 = row;
            }
            None => edits.rewired.push(source.entity),
        }
    }
    edits.rewired.extend(moves.arrived);
    // One that wore another's material and has got a bad one of its own is no instance any longer.
    edits.rewired.extend(index.directory.invalid.keys());
}

/// Writes a material to the next rows of its kinds, what it mixes before itself. Tells its kind and row, and whether others stood in
/// the rows.
fn add(
    materials: &mut Materials,
    textures: &mut TextureWriter<'_>,
    material: &Material,
    written: &mut [usize; MaterialKind::ALL.len()],
) -> ((MaterialKind, u32), bool) {
    let mut next = |kind: MaterialKind| {
        written[kind as usize] += 1;
        written[kind as usize] - 1
    };
    let kind = kind(material);
    if let Material::Mix { a, b, by } = material {
        let (a, a_differs) = add(materials, textures, a, written);
        let (b, b_differs) = add(materials, textures, b, written);
        let row = written[kind as usize];
        written[kind as usize] += 1;
        let mix = buffers::Mix { a, b, by: textures.scalar(by) };
        return ((kind, row as u32), materials.mix.put(row, mix) || a_differs || b_differs);
    }
    let row = next(kind);
    let second = second_kind(material).map(next);
    ((kind, row as u32), put(materials, textures, material, (row, second)))
}

/// The kind of a material.
fn kind(material: &Material) -> MaterialKind {
    match material {
        Material::Phong { .. } => MaterialKind::Phong,
        Material::Lambert { .. } => MaterialKind::Lambert,
        Material::RoughDiffuse { .. } => MaterialKind::RoughDiffuse,
        Material::Metal { .. } => MaterialKind::Metal,
        Material::Dielectric { .. } => MaterialKind::Dielectric,
        Material::Emissive { .. } => MaterialKind::Emissive,
        Material::Principled(principled) if principled.unlit => MaterialKind::Emissive,
        Material::Principled(_) => MaterialKind::Principled,
        Material::Coated { .. } => MaterialKind::Coated,
        Material::Mix { .. } => MaterialKind::Mix,
    }
}

/// The kind of which a material has a row beside that of its own.
fn second_kind(material: &Material) -> Option<MaterialKind> {
    match material {
        Material::Principled(principled) => {
            (!principled.unlit && principled::has_inside(principled)).then_some(MaterialKind::Dielectric)
        }
        Material::Coated { base, .. } => Some(kind(base)),
        _ => None,
    }
}

/// The colors of a material.
fn colors(material: &Material) -> [Option<&Color>; 5] {
    match material {
        Material::Phong { ambient, diffuse, specular, .. } => {
            [Some(ambient), Some(diffuse), Some(specular), None, None]
        }
        Material::Metal { reflectance: Reflectance::Normal { r0, .. }, specular, .. } => {
            [Some(r0), Some(specular), None, None, None]
        }
        Material::Principled(principled) if principled.unlit => [Some(&principled.base_color), None, None, None, None],
        Material::Principled(principled) => principled::colors(principled).map(Some),
        Material::Coated { base, .. } => colors(base),
        Material::Mix { .. } => [None; 5],
        Material::Metal { specular: color, .. }
        | Material::Lambert { albedo: color }
        | Material::RoughDiffuse { albedo: color, .. }
        | Material::Dielectric { specular: color, .. }
        | Material::Emissive { radiance: color, .. } => [Some(color), None, None, None, None],
    }
}

/// The rows of textures that a material takes.
fn count_textures(material: &Material) -> usize {
    let of_colors = colors(material).into_iter().flatten().filter(|color| color.texture().is_some()).count();
    match material {
        Material::Principled(principled) if !principled.unlit => of_colors + principled::other_textures(principled),
        _ => of_colors,
    }
}

/// Writes a material to a row of its kind, what fills it or lies below it to a row of another, and its textures where the writer stands.
/// Says whether others stood in the rows.
fn put(
    materials: &mut Materials,
    textures: &mut TextureWriter<'_>,
    material: &Material,
    (row, second): (usize, Option<usize>),
) -> bool {
    let mut source = |color: &Color| textures.source(color);
    match material {
        Material::Phong { ambient, diffuse, specular, exponent } => {
            let (ambient, diffuse, specular) = (source(ambient), source(diffuse), source(specular));
            materials.phong.put(row, buffers::Phong { ambient, diffuse, specular, exponent: *exponent })
        }
        Material::Lambert { albedo } => materials.lambert.put(row, buffers::Lambert { albedo: source(albedo) }),
        &Material::RoughDiffuse { ref albedo, roughness } => {
            materials.rough_diffuse.put(row, buffers::RoughDiffuse { albedo: source(albedo), roughness })
        }
        &Material::Metal { ref reflectance, fresnel, ref specular, exponent, alpha, film, compensated } => {
            // Where there is no index, one without effect stands in for it.
            let (r0, [r90, f82], eta, k) = match *reflectance {
                Reflectance::Normal { ref r0, r90, f82 } => (source(r0), [r90, f82], Vec3::ONE, Vec3::ZERO),
                Reflectance::Index { eta, k } => {
                    let r0 = [0, 1, 2].map(|channel| f0_conductor(1.0, eta[channel], k[channel]));
                    (buffers::ColorSource::constant(Vec3::from_array(r0)), [Vec3::ONE; 2], eta, k)
                }
                Reflectance::EdgeTint { r0, edge_tint } => {
                    let index = [0, 1, 2].map(|channel| index_from_edge_tint(r0[channel], edge_tint[channel]));
                    let [eta, k] = [index.map(|(eta, _)| eta), index.map(|(_, k)| k)].map(Vec3::from_array);
                    (buffers::ColorSource::constant(r0), [Vec3::ONE; 2], eta, k)
                }
            };
            let specular = source(specular);
            materials.metal.put(
                row,
                buffers::Metal { r0, eta, k, fresnel, r90, f82, alpha, film, compensated, specular, exponent },
            )
        }
        #[rustfmt::skip]
        &Material::Dielectric {
            ior, dispersion, fresnel, ref specular, exponent, absorption, scattering, bare, priority, alpha, film, thin,
        } => {
            let specular = source(specular);
            let Scattering { coefficient: scattering, anisotropy } = scattering;
            materials.dielectric.put(row, buffers::Dielectric {
                ior, dispersion, fresnel, specular, exponent, absorption, scattering, anisotropy, bare, priority, alpha, film,
                thin,
            })
        }
        &Material::Emissive { ref radiance, two_sided } => {
            materials.emissive.put(row, buffers::Emissive { radiance: source(radiance), two_sided })
        }
        Material::Principled(principled) if principled.unlit => {
            let radiance = source(&principled.base_color);
            materials.emissive.put(row, buffers::Emissive { radiance, two_sided: true })
        }
        Material::Principled(principled) => principled::put(materials, textures, principled, row, second),
        Material::Mix { .. } => unreachable!("mixes are written part by part"),
        &Material::Coated { ref base, ior, alpha, absorption, thickness } => {
            let base_row = second.expect("a coated material has a second row");
            let differs = put(materials, textures, base, (base_row, None));
            let (base, base_row, depth) = (kind(base), base_row as u32, absorption * thickness);
            materials.coated.put(row, buffers::Coated { base, base_row, ior, alpha, depth }) || differs
        }
    }
}

/// Drops what lies beyond the rows that were written, in all tables.
fn truncate(materials: &mut Materials, rows: usize, written: [usize; MaterialKind::ALL.len()]) {
    let Materials {
        rows: all,
        details: _,
        phong,
        lambert,
        rough_diffuse,
        metal,
        dielectric,
        emissive,
        principled,
        coated,
        mix,
    } = materials;
    all.truncate(rows);
    phong.truncate(written[MaterialKind::Phong as usize]);
    lambert.truncate(written[MaterialKind::Lambert as usize]);
    rough_diffuse.truncate(written[MaterialKind::RoughDiffuse as usize]);
    metal.truncate(written[MaterialKind::Metal as usize]);
    dielectric.truncate(written[MaterialKind::Dielectric as usize]);
    emissive.truncate(written[MaterialKind::Emissive as usize]);
    principled.truncate(written[MaterialKind::Principled as usize]);
    coated.truncate(written[MaterialKind::Coated as usize]);
    mix.truncate(written[MaterialKind::Mix as usize]);
}

/// Checks the numbers of a material; the error says what must hold.
fn check(material: &Material) -> Result<(), &'static str> {
    for color in colors(material).into_iter().flatten() {
        if !textures::is_color(color.factor()) {
            return Err("a color must be finite and at least 0");
        }
        color.texture().map_or(Ok(()), textures::check)?;
    }
    let exponent_is_sound = |exponent: f32| exponent >= 0.0 && exponent.is_finite();
    let rules = match *material {
        Material::Phong { exponent, .. } => [(exponent_is_sound(exponent), EXPONENT), SOUND, SOUND, SOUND],
        Material::Principled(ref principled) => return principled::check(principled),
        Material::Mix { .. } => return check_mix(material),
        Material::Coated { ref base, ior, alpha, absorption, thickness } => {
            check(base)?;
            let is_base = matches!(**base, Material::Lambert { .. } | Material::Metal { .. });
            let depth = absorption * thickness;
            let is_depth = absorption.min_element() >= 0.0 && thickness >= 0.0 && depth.is_finite();
            [
                (is_base, "a coat lies over a Lambert material or a metal"),
                (ior >= 1.0 && ior.is_finite(), "an index of refraction must be at least 1"),
                (is_part(alpha), ALPHA),
                (is_depth, "absorption and thickness must be at least 0"),
            ]
        }
        Material::Lambert { .. } | Material::Emissive { .. } => [SOUND; 4],
        Material::RoughDiffuse { roughness, .. } => {
            [(is_part(roughness), "a roughness must be 0 to 1"), SOUND, SOUND, SOUND]
        }
        Material::Metal { ref reflectance, fresnel, exponent, alpha, .. } => {
            metal_rules(reflectance, fresnel, exponent_is_sound(exponent), alpha)
        }
        Material::Dielectric { ior, exponent, absorption, alpha, .. } => [
            (exponent_is_sound(exponent), EXPONENT),
            (ior >= 1.0 && ior.is_finite(), "an index of refraction must be at least 1"),
            (absorption.is_finite() && absorption.min_element() >= 0.0, "absorption must be at least 0"),
            (is_part(alpha), ALPHA),
        ],
    };
    let film_is_sound = match *material {
        Material::Metal { film: Some(film), fresnel, .. } | Material::Dielectric { film: Some(film), fresnel, .. } => {
            let has_index = film.ior >= 1.0 && film.ior.is_finite();
            fresnel == FresnelModel::Exact && has_index && (0.0..=1e5).contains(&film.thickness)
        }
        _ => true,
    };
    let dispersion_is_sound = match *material {
        Material::Dielectric { dispersion: Some(dispersion), thin, .. } => dispersion.is_sound() && !thin,
        _ => true,
    };
    let medium_is_sound = match *material {
        Material::Dielectric { scattering: Scattering { coefficient, anisotropy }, thin, .. } => {
            let scatters = coefficient.is_finite() && coefficient.min_element() >= 0.0;
            scatters && is_between(anisotropy) && !(thin && coefficient != Vec3::ZERO)
        }
        _ => true,
    };
    let is_bare = match *material {
        Material::Dielectric { bare: true, dispersion, film, thin, .. } => {
            dispersion.is_none() && film.is_none() && !thin
        }
        _ => true,
    };
    let media = [(medium_is_sound, SCATTERING), (is_bare, BARE)];
    rules
        .into_iter()
        .chain([(film_is_sound, FILM), (dispersion_is_sound, DISPERSION)])
        .chain(media)
        .try_for_each(|(holds, rule)| if holds { Ok(()) } else { Err(rule) })
}

/// Checks a detail of a material.
fn check_detail(material: &Material, detail: &Detail) -> Result<(), &'static str> {
    if matches!(material, Material::Dielectric { bare: true, .. }) {
        return Err("what has no surface has no details");
    }
    details::check(detail)
}

/// Checks a mix and what it is of.
fn check_mix(material: &Material) -> Result<(), &'static str> {
    let Material::Mix { a, b, by } = material else { return Ok(()) };
    if levels(material) > LEVELS {
        return Err("mixes must be at most 8 deep");
    }
    for part in [a, b] {
        check(part)?;
        let has_inside = match **part {
            Material::Dielectric { thin, .. } => !thin,
            _ => second_kind(part) == Some(MaterialKind::Dielectric),
        };
        if has_inside {
            return Err("a mix must be of what has no inside");
        }
    }
    by.texture.as_ref().map_or(Ok(()), |(texture, _)| textures::check(texture))?;
    if is_part(by.factor) { Ok(()) } else { Err("a mix must be by 0 to 1") }
}

/// How many mixes are in each other.
fn levels(material: &Material) -> usize {
    match material {
        Material::Mix { a, b, .. } => 1 + levels(a).max(levels(b)),
        _ => 0,
    }
}

/// Mixes that may be in each other.
const LEVELS: usize = 8;

/// What must hold for a metal.
fn metal_rules(
    reflectance: &Reflectance,
    fresnel: FresnelModel,
    exponent_is_sound: bool,
    alpha: f32,
) -> [(bool, &'static str); 4] {
    let (reflectance_is_sound, has_index) = match *reflectance {
        Reflectance::Normal { ref r0, r90, f82 } => ([r0.factor(), r90, f82].into_iter().all(are_parts), false),
        Reflectance::EdgeTint { r0, edge_tint } => (are_parts(r0) && are_parts(edge_tint), true),
        Reflectance::Index { eta, k } => {
            let finite = eta.is_finite() && k.is_finite();
            (finite && eta.min_element() > 0.0 && k.min_element() >= 0.0, true)
        }
    };
    let model_is_sound = match fresnel {
        FresnelModel::Exact => has_index,
        FresnelModel::Schlick => true,
        FresnelModel::SchlickThetaM => false,
    };
    [
        (exponent_is_sound, EXPONENT),
        (reflectance_is_sound, "a metal's colors must be 0 to 1, its eta above 0, its k at least 0"),
        (model_is_sound, "a metal's Fresnel model must be Schlick, or with an index Exact"),
        (is_part(alpha), ALPHA),
    ]
}

const SOUND: (bool, &str) = (true, "");
const EXPONENT: &str = "an exponent must be at least 0";
const FILM: &str = "a film must be at most 100000 nm thick, of an index of at least 1, and the Fresnel model Exact";
const DISPERSION: &str =
    "dispersion must be finite, without a resonance in the visible range, and not that of a thin sheet";
const SCATTERING: &str = "scattering must be at least 0, its anisotropy between -1 and 1, and not that of a thin sheet";
const BARE: &str = "what has no surface has no film, no dispersion, and is no thin sheet";
const ALPHA: &str = "a GGX width alpha must be 0 to 1";

/// Whether a mean cosine is one of light that is neither all turned back nor all let on.
pub(super) fn is_between(anisotropy: f32) -> bool {
    -1.0 < anisotropy && anisotropy < 1.0
}

fn is_part(value: f32) -> bool {
    (0.0..=1.0).contains(&value)
}

fn are_parts(color: Vec3) -> bool {
    color.to_array().into_iter().all(is_part)
}
