//! Whether every index of a document leads somewhere and every name is one that the specification knows.
//!
//! The rules are those of the `gltf` crate's types. Three are not held against a file, since nothing here rests on them:
//! accessors without a view are zeros, or come out of a compressed stream; bounds of positions are computed; and extensions are
//! another module's matter.

use gltf::json::mesh::Semantic;
use gltf::json::validation::{Checked, Error, Validate};
use gltf::json::{Path, Root, Value};

use super::{Found, broken};
use crate::diagnostics::nearest;

/// The first thing that is wrong, if any is.
pub(super) fn check(root: &Root, value: &Value) -> Found<()> {
    check_positions(root)?;
    let mut first = None;
    root.validate(root, Path::new, &mut |path, error| {
        let path = path().0;
        let is_ours = matches!(error, Error::Unsupported | Error::Oversize)
            || path.ends_with(".min")
            || path.ends_with(".max")
            || (error == Error::Missing && path.starts_with("accessors[") && path.ends_with(".bufferView"))
            || (error == Error::Missing && path.ends_with("[\"POSITION\"]"));
        if !is_ours && first.is_none() {
            first = Some((path, error));
        }
    });
    match first {
        None => Ok(()),
        Some((path, error)) => Err(Box::new(explain(root, value, &path, error))),
    }
}

/// Accessors of positions, which the crate's own check looks up unasked.
fn check_positions(root: &Root) -> Found<()> {
    for (m, mesh) in root.meshes.iter().enumerate() {
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            if let Some(index) = primitive.attributes.get(&Checked::Valid(Semantic::Positions))
                && index.value() >= root.accessors.len()
            {
                let path = format!("meshes[{m}].primitives[{p}].attributes.POSITION");
                return Err(Box::new(no_such(&path, "accessors", root.accessors.len(), Some(index.value() as u64))));
            }
        }
    }
    Ok(())
}

fn explain(root: &Root, value: &Value, path: &str, error: Error) -> crate::Diagnostic {
    let found = find(value, path);
    let field =
        path.rsplit(['.', '[']).find(|part| part.starts_with(|c: char| c.is_ascii_alphabetic())).unwrap_or(path);
    match error {
        Error::IndexOutOfBounds => {
            let (array, length) = target(root, path, field);
            no_such(path, array, length, found.and_then(Value::as_u64))
        }
        Error::Missing => broken(path, "a value that must be given is absent"),
        Error::Invalid if path.contains(".attributes") => {
            let problem = broken(path, "an attribute that the specification does not name");
            problem.expected(
                "`POSITION`, `NORMAL`, `TANGENT`, `TEXCOORD_n`, `COLOR_n`, `JOINTS_n`, `WEIGHTS_n` or a name that starts with `_`",
            )
        }
        _ => {
            let found = found.map_or("the value".into(), |found| format!("{found:.60}"));
            let problem = broken(path, format!("{found} is not one of the values that may stand here"));
            match names(field, path) {
                [] => problem,
                valid => {
                    let problem_with = problem.expected(valid.join(", "));
                    match nearest(found.trim_matches('"'), valid) {
                        Some(near) => problem_with.help(format!("did you mean {near:?}?")),
                        None => problem_with,
                    }
                }
            }
        }
    }
}

fn no_such(path: &str, array: &str, length: usize, found: Option<u64>) -> crate::Diagnostic {
    let message = match found {
        Some(index) => format!("there is no {array}[{index}]"),
        None => format!("there is no such row of `{array}`"),
    };
    broken(path, message).expected(match length {
        0 => format!("the file has no `{array}` at all"),
        1 => "0, the only one that there is".into(),
        _ => format!("0 to {}", length - 1),
    })
}

/// The array that a field's index is about, and its length.
fn target(root: &Root, path: &str, field: &str) -> (&'static str, usize) {
    match field {
        "bufferView" => ("bufferViews", root.buffer_views.len()),
        "buffer" => ("buffers", root.buffers.len()),
        "material" => ("materials", root.materials.len()),
        "mesh" => ("meshes", root.meshes.len()),
        "skin" => ("skins", root.skins.len()),
        "camera" => ("cameras", root.cameras.len()),
        "scene" => ("scenes", root.scenes.len()),
        "source" => ("images", root.images.len()),
        "index" => ("textures", root.textures.len()),
        "sampler" if path.starts_with("textures") => ("samplers", root.samplers.len()),
        "sampler" => ("samplers of the animation", 0),
        "children" | "nodes" | "joints" | "skeleton" | "node" => ("nodes", root.nodes.len()),
        _ => ("accessors", root.accessors.len()),
    }
}

/// The names that may stand in a field.
fn names(field: &str, path: &str) -> &'static [&'static str] {
    match field {
        "alphaMode" => &["OPAQUE", "MASK", "BLEND"],
        "interpolation" => &["LINEAR", "STEP", "CUBICSPLINE"],
        "path" => &["translation", "rotation", "scale", "weights", "pointer"],
        "type" if path.starts_with("cameras") => &["perspective", "orthographic"],
        "type" => &["SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"],
        "mode" => &["0", "1", "2", "3", "4", "5", "6"],
        "componentType" => &["5120", "5121", "5122", "5123", "5125", "5126"],
        "magFilter" => &["9728", "9729"],
        "minFilter" => &["9728", "9729", "9984", "9985", "9986", "9987"],
        "wrapS" | "wrapT" => &["33071", "33648", "10497"],
        _ => &[],
    }
}

/// The value at a path such as `meshes[0].primitives[1].attributes["POSITION"]`.
fn find<'v>(value: &'v Value, path: &str) -> Option<&'v Value> {
    let keys = path.split(['.', '[']).map(|key| key.trim_end_matches(']').trim_matches('"'));
    keys.filter(|key| !key.is_empty()).try_fold(value, |value, key| match key.parse::<usize>() {
        Ok(index) if value.is_array() => value.get(index),
        _ => value.get(key),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn first(text: &str) -> Option<crate::Diagnostic> {
        let value: Value = serde_json::from_str(text).expect("it is JSON");
        let root: Root = serde_json::from_str(text).expect("it has glTF's types");
        check(&root, &value).err().map(|error| *error)
    }

    #[test]
    fn indices_that_lead_nowhere_are_named() {
        for (text, path, message, expected) in [
            (
                r#""meshes":[{"primitives":[{"attributes":{"POSITION":7}}]}]"#,
                "meshes[0].primitives[0].attributes.POSITION",
                "there is no accessors[7]",
                "the file has no `accessors` at all",
            ),
            (r#""nodes":[{},{"children":[0,5]}]"#, "nodes[1].children[1]", "there is no nodes[5]", "0 to 1"),
            (r#""nodes":[{"mesh":0}]"#, "nodes[0].mesh", "there is no meshes[0]", "the file has no `meshes` at all"),
            (
                r#""images":[{"uri":"a"}],"textures":[{"source":1}]"#,
                "textures[0].source",
                "there is no images[1]",
                "0, the only one that there is",
            ),
        ] {
            let found = first(&format!(r#"{{"asset":{{"version":"2.0"}},{text}}}"#)).expect(text);
            assert_eq!(found.path.as_deref(), Some(path));
            assert_eq!((found.message.as_str(), found.expected.as_deref()), (message, Some(expected)));
        }
    }

    #[test]
    fn names_that_do_not_exist_have_a_nearest_one() {
        let found =
            first(r#"{"asset":{"version":"2.0"},"materials":[{"alphaMode":"BLENDED"}]}"#).expect("no such mode");
        assert_eq!(found.path.as_deref(), Some("materials[0].alphaMode"));
        assert_eq!(found.message, "\"BLENDED\" is not one of the values that may stand here");
        assert_eq!(found.help.as_deref(), Some("did you mean \"BLEND\"?"));
    }

    #[test]
    fn what_nothing_rests_on_is_let_through() {
        let text = r#"{"asset":{"version":"2.0"},"extensionsRequired":["EXT_of_another_module"],
            "accessors":[{"componentType":5126,"count":3,"type":"VEC3"}],
            "meshes":[{"primitives":[{"attributes":{"POSITION":0}},{"attributes":{"NORMAL":0}}]}]}"#;
        assert_eq!(first(text), None);
    }
}
