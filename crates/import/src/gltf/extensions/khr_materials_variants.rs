//! `KHR_materials_variants`: other materials for the same primitives, by the name of a variant.

use gltf::json::Root;
use gltf::json::mesh::Primitive;
use serde::Deserialize;

use super::super::{Found, broken, choose};

const NAME: &str = "KHR_materials_variants";

#[derive(Deserialize)]
struct Variant {
    name: String,
}

#[derive(Deserialize)]
struct Mapping {
    material: usize,
    #[serde(default)]
    variants: Vec<usize>,
}

/// The number of the chosen variant.
pub(in crate::gltf) fn chosen(root: &Root, variant: Option<&str>) -> Found<Option<usize>> {
    let Some(variant) = variant else { return Ok(None) };
    let found = super::fields(super::others!(root), NAME, "")?;
    let names: Vec<Variant> = found.map_or(Ok(Vec::new()), |found| found.need("variants"))?;
    choose(variant, names.iter().map(|variant| Some(variant.name.as_str())), "variant").map(Some)
}

/// The material of a primitive in a variant; without a word about it, its own.
pub(in crate::gltf) fn material(
    root: &Root,
    primitive: &Primitive,
    variant: Option<usize>,
    path: &str,
) -> Found<Option<usize>> {
    let own = primitive.material.map(|index| index.value());
    let Some(variant) = variant else { return Ok(own) };
    let Some(found) = super::fields(super::others!(primitive), NAME, path)? else { return Ok(own) };
    let mappings: Vec<Mapping> = found.get("mappings", Vec::new())?;
    match mappings.into_iter().find(|mapping| mapping.variants.contains(&variant)) {
        Some(mapping) if mapping.material >= root.materials.len() => {
            let message = format!("there is no materials[{}]", mapping.material);
            Err(broken(found.path(), message).into())
        }
        Some(mapping) => Ok(Some(mapping.material)),
        None => Ok(own),
    }
}
