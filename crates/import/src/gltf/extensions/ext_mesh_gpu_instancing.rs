//! `EXT_mesh_gpu_instancing`: a node's mesh in many places.

use std::collections::BTreeMap;

use glam::{Affine3A, Quat, Vec3};
use gltf::json::{Index, Node};
use serde::Deserialize;

use super::super::document::Document;
use super::super::{Found, broken};

const NAME: &str = "EXT_mesh_gpu_instancing";

#[derive(Deserialize)]
struct Instancing {
    #[serde(default)]
    attributes: BTreeMap<String, u32>,
}

/// The places of a node's mesh in the node's space, if there are many.
pub(in crate::gltf) fn places(document: &Document, node: &Node, path: &str) -> Found<Option<Vec<Affine3A>>> {
    let Some(Instancing { attributes }) = super::read(super::others!(node), NAME, path)? else { return Ok(None) };
    let path = format!("{path}.extensions.{NAME}.attributes");
    let mut count = None;
    for (name, &index) in &attributes {
        let Some(accessor) = document.root.accessors.get(index as usize) else {
            return Err(broken(format!("{path}.{name}"), format!("there is no accessors[{index}]")).into());
        };
        if count.is_some_and(|count| count != accessor.count.0) {
            let problem = broken(format!("{path}.{name}"), "the attributes have different numbers of rows");
            return Err(problem.into());
        }
        count = Some(accessor.count.0);
    }
    let translations = rows::<3>(document, &attributes, "TRANSLATION", &path)?;
    let rotations = rows::<4>(document, &attributes, "ROTATION", &path)?;
    let scales = rows::<3>(document, &attributes, "SCALE", &path)?;
    let place = |row: usize| {
        let translation = translations.as_ref().map_or(Vec3::ZERO, |rows| Vec3::from_array(rows[row]));
        let rotation = rotations.as_ref().map_or(Quat::IDENTITY, |rows| Quat::from_array(rows[row]).normalize());
        let scale = scales.as_ref().map_or(Vec3::ONE, |rows| Vec3::from_array(rows[row]));
        Affine3A::from_scale_rotation_translation(scale, rotation, translation)
    };
    let count = [translations.as_ref().map(Vec::len), rotations.as_ref().map(Vec::len), scales.as_ref().map(Vec::len)];
    Ok(Some((0..count.into_iter().flatten().next().unwrap_or(0)).map(place).collect()))
}

fn rows<const N: usize>(
    document: &Document,
    attributes: &BTreeMap<String, u32>,
    name: &str,
    path: &str,
) -> Found<Option<Vec<[f32; N]>>> {
    let Some(&index) = attributes.get(name) else { return Ok(None) };
    let path = format!("{path}.{name}");
    document.gather(Index::new(index), &path)?.floats(&path).map(Some)
}
