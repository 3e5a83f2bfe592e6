//! `EXT_mesh_gpu_instancing`: a node's mesh in many places.

use std::collections::BTreeMap;

use glam::{Affine3A, Quat, Vec3};
use gltf::json::{Index, Node};

use super::super::accessors::Gathered;
use super::super::document::Document;
use super::super::{Found, broken};

/// The places of a node's mesh in the node's space, if there are many.
pub(in crate::gltf) fn places(document: &Document, node: &Node, path: &str) -> Found<Option<Vec<Affine3A>>> {
    let Some(found) = super::fields(super::others!(node), "EXT_mesh_gpu_instancing", path)? else { return Ok(None) };
    let attributes: BTreeMap<String, u32> = found.get("attributes", BTreeMap::new())?;
    let path = found.path_of("attributes");
    let mut columns: BTreeMap<&str, Gathered> = BTreeMap::new();
    for (name, &index) in &attributes {
        let path = format!("{path}.{name}");
        if index as usize >= document.root.accessors.len() {
            return Err(broken(path, format!("there is no accessors[{index}]")).into());
        }
        let gathered = document.gather(Index::new(index), &path)?;
        if columns.values().any(|other| other.count != gathered.count) {
            return Err(broken(path, "the attributes have different numbers of rows").into());
        }
        columns.insert(name, gathered);
    }
    let count = columns.values().next().map_or(0, |column| column.count);
    let translations = rows(&columns, "TRANSLATION", Vec3::ZERO.to_array(), &path)?;
    let rotations = rows(&columns, "ROTATION", Quat::IDENTITY.to_array(), &path)?;
    let scales = rows(&columns, "SCALE", Vec3::ONE.to_array(), &path)?;
    let place = |row: usize| {
        let rotation = Quat::from_array(rotations(row)).normalize();
        Affine3A::from_scale_rotation_translation(scales(row).into(), rotation, translations(row).into())
    };
    Ok(Some((0..count).map(place).collect()))
}

/// The rows of an attribute, or of its default.
fn rows<const N: usize>(
    columns: &BTreeMap<&str, Gathered>,
    name: &str,
    default: [f32; N],
    path: &str,
) -> Found<impl Fn(usize) -> [f32; N]> {
    let rows = columns.get(name).map(|column| column.floats(&format!("{path}.{name}"))).transpose()?;
    Ok(move |row: usize| rows.as_ref().map_or(default, |rows| rows[row]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gltf::testing::{Builder, document};

    #[test]
    fn there_are_as_many_places_as_rows_of_whatever_attribute() {
        let mut builder = Builder::default();
        let numbers = builder.floats(&[7.0, 8.0], "SCALAR");
        let moved = builder.floats(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0], "VEC3");
        let place = Affine3A::from_translation;
        for (attributes, expected) in [
            (String::new(), vec![]),
            (format!(r#""_ID":{numbers}"#), vec![Affine3A::IDENTITY; 2]),
            (
                format!(r#""_ID":{numbers},"TRANSLATION":{moved}"#),
                vec![place(Vec3::new(1.0, 2.0, 3.0)), place(Vec3::new(4.0, 5.0, 6.0))],
            ),
        ] {
            builder.rest = format!(
                r#","nodes":[{{"extensions":{{"EXT_mesh_gpu_instancing":{{"attributes":{{{attributes}}}}}}}}}]"#
            );
            let document = document(&builder);
            let found = places(&document, &document.root.nodes[0], "nodes[0]").expect("it is whole");
            assert_eq!(found, Some(expected), "{attributes}");
        }
    }
}
