//! Extensions: which there are, and a file for each that is more than a line. What they hold is read from the file's own JSON,
//! one way for all.

pub(super) mod ext_lights_image_based;
pub(super) mod ext_mesh_gpu_instancing;
pub(super) mod khr_draco_mesh_compression;
pub(super) mod khr_lights_punctual;
pub(super) mod khr_materials_anisotropy;
pub(super) mod khr_materials_clearcoat;
pub(super) mod khr_materials_diffuse_transmission;
pub(super) mod khr_materials_dispersion;
pub(super) mod khr_materials_emissive_strength;
pub(super) mod khr_materials_ior;
pub(super) mod khr_materials_iridescence;
pub(super) mod khr_materials_pbr_specular_glossiness;
pub(super) mod khr_materials_sheen;
pub(super) mod khr_materials_specular;
pub(super) mod khr_materials_transmission;
pub(super) mod khr_materials_unlit;
pub(super) mod khr_materials_variants;
pub(super) mod khr_materials_volume;
pub(super) mod khr_materials_volume_scatter;
pub(super) mod khr_node_visibility;
pub(super) mod meshopt;

use gltf::json::{Root, Value};
use serde::de::DeserializeOwned;
use serde_json::Map;

use super::fields::Fields;
use super::{Found, Reporter, broken, typed};
use crate::diagnostics::{Code, Diagnostic, Severity};

/// The extensions of an object of the `gltf` crate as plain values.
macro_rules! others {
    ($object:expr) => {
        $object.extensions.as_ref().map(|extensions| &extensions.others)
    };
}
pub(super) use others;

/// The extensions that are read, and what is done with each.
const READ: &[(&str, &str)] = &[
    (
        "EXT_lights_image_based",
        "the cube of mirrors' pictures is the sky that lights the scene; in a part of another scene nothing",
    ),
    ("EXT_mesh_gpu_instancing", "every instance is an entity that shares its mesh"),
    ("EXT_meshopt_compression", "decoded"),
    ("EXT_texture_webp", "decoded"),
    ("KHR_animation_pointer", "every number of the file can be animated"),
    ("KHR_draco_mesh_compression", "decoded"),
    ("KHR_lights_punctual", "candela and lux are linear RGB intensity and irradiance"),
    ("KHR_materials_anisotropy", "rendered"),
    ("KHR_materials_clearcoat", "rendered"),
    ("KHR_materials_diffuse_transmission", "rendered"),
    ("KHR_materials_dispersion", "rendered"),
    ("KHR_materials_emissive_strength", "rendered"),
    ("KHR_materials_ior", "rendered"),
    ("KHR_materials_iridescence", "rendered"),
    ("KHR_materials_pbrSpecularGlossiness", "converted to metallic-roughness with the specular extension"),
    ("KHR_materials_sheen", "rendered"),
    ("KHR_materials_specular", "rendered"),
    ("KHR_materials_transmission", "rendered"),
    ("KHR_materials_unlit", "a surface that sends out its base color and reflects nothing"),
    ("KHR_materials_variants", "the variant of `--variant`, otherwise the default materials"),
    (
        "KHR_materials_volume",
        "rendered: light is traced through the inside, so that thickness only says that there is one",
    ),
    ("KHR_materials_volume_scatter", "rendered: paths are scattered inside, as often as it takes"),
    ("KHR_mesh_quantization", "decoded"),
    ("KHR_meshopt_compression", "decoded"),
    ("KHR_node_visibility", "hidden nodes are left out, with all below them"),
    ("KHR_texture_basisu", "decoded"),
    ("KHR_texture_transform", "applied to every texture"),
    ("KHR_xmp", "nothing in it shows"),
    ("KHR_xmp_json_ld", "nothing in it shows"),
];

/// Says what is done with every extension that the file says it uses. One that is required and not read is an error.
pub(super) fn check(root: &Root, reporter: &mut Reporter) -> Found<()> {
    let known = |name: &str| READ.iter().find(|(known, _)| *known == name);
    for (index, name) in root.extensions_required.iter().enumerate() {
        if known(name).is_none() {
            let message = format!("the file requires the extension {name:?}, which is not known");
            let problem = Diagnostic::about_path(
                Severity::Error,
                Code::Extension,
                format!("extensionsRequired[{index}]"),
                message,
            );
            let names: Vec<&str> = READ.iter().map(|(name, _)| *name).collect();
            return Err(Box::new(match crate::diagnostics::nearest(name, &names) {
                Some(near) => problem.help(format!("did you mean `{near}`?")),
                None => problem.help("without it the file would show something else than was meant"),
            }));
        }
    }
    for (index, name) in root.extensions_used.iter().enumerate() {
        if root.extensions_used[..index].contains(name) {
            continue;
        }
        let path = format!("extensionsUsed[{index}]");
        match known(name) {
            Some((_, done)) => reporter.note(Code::Extension, path, format!("{name}: {done}")),
            None => reporter.warn(Code::Extension, path, format!("{name}: not known, and left out")),
        }
    }
    Ok(())
}

/// What an extension holds, if it is there, as a type. `path` is that of the object it stands in.
pub(super) fn read<T: DeserializeOwned>(
    others: Option<&Map<String, Value>>,
    name: &str,
    path: &str,
) -> Found<Option<T>> {
    let value = others.and_then(|others| others.get(name));
    value.map(|value| typed(value, &path_of(path, name))).transpose()
}

/// The same field by field.
pub(super) fn fields<'d>(others: Option<&'d Map<String, Value>>, name: &str, path: &str) -> Found<Option<Fields<'d>>> {
    match others.and_then(|others| others.get(name)) {
        None => Ok(None),
        value @ Some(Value::Object(_)) => Ok(Some(Fields::new(value, path_of(path, name)))),
        Some(_) => Err(broken(path_of(path, name), "the extension is no object").into()),
    }
}

/// The light that an extension gives an object, out of the list that it keeps at the root.
pub(super) fn light<'d>(
    root: &'d Root,
    others: Option<&'d Map<String, Value>>,
    name: &str,
    path: &str,
) -> Found<Option<Fields<'d>>> {
    let Some(of_object) = fields(others, name, path)? else { return Ok(None) };
    let light: usize = of_object.need("light")?;
    let lights = others!(root).and_then(|others| others.get(name)?.get("lights")?.as_array());
    match lights.and_then(|lights| lights.get(light)) {
        Some(found) => Ok(Some(Fields::new(Some(found), format!("extensions.{name}.lights[{light}]")))),
        None => {
            let message = format!("there is no light {light}: the file has {}", lights.map_or(0, Vec::len));
            Err(broken(of_object.path_of("light"), message).into())
        }
    }
}

/// Where the extension of an object stands.
fn path_of(object: &str, name: &str) -> String {
    if object.is_empty() { format!("extensions.{name}") } else { format!("{object}.extensions.{name}") }
}
