//! Textures: pictures, samplers, and how they lie over a surface.
//!
//! glTF counts v from the top row down, pictures here have their top row at v = 1: every texture's transform ends with
//! 1 - v, and meshes keep their coordinates. From afar a texture is a mean of its pixels, between two levels of
//! detail, unless its filter for pictures that look small says that it has no levels.

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use brewster_lanes::math;
use brewster_world::components::parts::{Encoding, Filter, Image, ImageTexture, Texture, UvSet, UvTransform, Wrap};
use gltf::json::texture::{MagFilter, MinFilter, WrappingMode};
use gltf::json::validation::Checked;
use gltf::json::{self, Index, Value};
use rayon::prelude::*;
use serde::Deserialize;
use serde_json::Map;

use super::document::Document;
use super::extensions::{self, others};
use super::{Found, Reporter, broken};
use crate::diagnostics::{Code, Diagnostic, Severity};
use crate::session::Session;
use crate::{hash, image};

/// A reference to a texture, wherever in the file it stands: plain, of a normal map, or in an extension.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Info {
    pub index: usize,
    #[serde(default)]
    pub tex_coord: u32,
    #[serde(default)]
    pub extensions: Option<Map<String, Value>>,
}

/// `KHR_texture_transform`: scaled, then turned counterclockwise as v points down, then moved.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct Transform {
    offset: [f32; 2],
    rotation: f32,
    scale: [f32; 2],
    tex_coord: Option<u32>,
}

impl Default for Transform {
    fn default() -> Self {
        Transform { offset: [0.0; 2], rotation: 0.0, scale: [1.0; 2], tex_coord: None }
    }
}

impl Transform {
    /// The same as a map, 1 - v at its end.
    fn map(&self) -> UvTransform {
        let (sine, cosine) = math::sin_cos(self.rotation);
        let ([du, dv], [u, v]) = (self.offset, self.scale);
        UvTransform { rows: [[cosine * u, sine * v, du], [sine * u, -cosine * v, 1.0 - dv]] }
    }
}

/// The pictures of a file, each read once.
#[derive(Default)]
pub(super) struct Textures {
    /// By the file's images; none for one that cannot be read, which was said.
    images: BTreeMap<usize, Option<Arc<Image>>>,
    /// Pictures that were read ahead, by the file's images: the digests of their files.
    ahead: BTreeMap<usize, u64>,
}

impl Textures {
    /// Decodes the pictures of some materials on all cores. What cannot be read is passed over: that is said where it is asked for.
    pub(super) fn read_ahead(&mut self, session: &mut Session, document: &Document, materials: &BTreeSet<usize>) {
        let mut textures = BTreeSet::new();
        let of_file = document.value.get("materials").and_then(Value::as_array);
        for material in materials.iter().filter_map(|&index| of_file?.get(index)) {
            referred(material, &mut textures);
        }
        let root = &document.root;
        let sources = textures.iter().filter_map(|&index| source(root, root.textures.get(index)?, "").ok().flatten());
        let sources: BTreeSet<usize> = sources.collect();
        // Where a picture is asked for, its pixels are taken from the budget in earnest.
        let mut pixels = session.budgets.pixels;
        let mut files = Vec::new();
        for index in sources {
            let Ok(bytes) = bytes(session, document, index) else { continue };
            let digest = hash::of(&bytes);
            if !session.assets.pictures.contains_key(&digest) && image::reserve(&bytes, &mut pixels).is_ok() {
                files.push((digest, bytes));
            }
            self.ahead.insert(index, digest);
        }
        let decoded =
            files.par_iter().filter_map(|(digest, bytes)| Some((*digest, Arc::new(image::decode(bytes).ok()?))));
        session.assets.pictures.extend(decoded.collect::<Vec<_>>());
    }

    /// The texture that a reference at `path` means; none where it cannot be read.
    pub(super) fn texture(
        &mut self,
        (session, reporter): (&mut Session, &mut Reporter),
        document: &Document,
        info: &Info,
        encoding: Encoding,
        path: &str,
    ) -> Found<Option<Texture>> {
        let root = &document.root;
        let Some(texture) = root.textures.get(info.index) else {
            let problem = broken(format!("{path}.index"), format!("there is no textures[{}]", info.index));
            return Err(problem.expected(format!("a number below {}", root.textures.len())).into());
        };
        let here = format!("textures[{}]", info.index);
        let Some(source) = source(root, texture, &here)? else {
            reporter.warn(Code::Image, here, "a texture without a picture is left out");
            return Ok(None);
        };
        let Some(image) = self.image((session, reporter), document, source)? else { return Ok(None) };
        let sampler = texture.sampler.map(|index| &root.samplers[index.value()]);
        let wrap = |mode: Checked<WrappingMode>| match mode.unwrap() {
            WrappingMode::ClampToEdge => Wrap::Clamp,
            WrappingMode::MirroredRepeat => Wrap::Mirror,
            WrappingMode::Repeat => Wrap::Repeat,
        };
        let is_nearest = sampler.is_some_and(|sampler| sampler.mag_filter == Some(Checked::Valid(MagFilter::Nearest)));
        let transform: Transform =
            extensions::read(info.extensions.as_ref(), "KHR_texture_transform", path)?.unwrap_or_default();
        let uv_set = match transform.tex_coord.unwrap_or(info.tex_coord) {
            0 => UvSet::First,
            1 => UvSet::Second,
            other => {
                let message = format!(
                    "texture coordinates beyond the second set are not read: set {other} is taken for the second"
                );
                reporter.warn(Code::Decision, path, message);
                UvSet::Second
            }
        };
        let is_single =
            |filter: &Checked<MinFilter>| matches!(filter, Checked::Valid(MinFilter::Nearest | MinFilter::Linear));
        let has_levels = !sampler.and_then(|sampler| sampler.min_filter.as_ref()).is_some_and(is_single);
        Ok(Some(Texture::Image(ImageTexture {
            pyramid: has_levels.then(|| session.assets.pyramid(&image, encoding)),
            image,
            encoding,
            wrap: sampler.map_or([Wrap::Repeat; 2], |sampler| [wrap(sampler.wrap_s), wrap(sampler.wrap_t)]),
            filter: if is_nearest { Filter::Nearest } else { Filter::Linear },
            uv_set,
            transform: transform.map(),
            vertex_colors: false,
        })))
    }

    /// A picture of the file; none for one that cannot be read: its texture is left out, as if it were white.
    pub(super) fn image(
        &mut self,
        (session, reporter): (&mut Session, &mut Reporter),
        document: &Document,
        index: usize,
    ) -> Found<Option<Arc<Image>>> {
        if let Some(known) = self.images.get(&index) {
            return Ok(known.clone());
        }
        let read = match self.read(session, document, index) {
            Ok(read) => Some(read),
            // Too much is too much; what is missing or broken can be done without.
            Err(problem) if matches!(problem.code, Code::Limit | Code::Sandbox) => return Err(problem),
            Err(problem) => {
                reporter.say_as(Severity::Warning, problem.note("the texture is left out"));
                None
            }
        };
        self.images.insert(index, read.clone());
        Ok(read)
    }

    fn read(&self, session: &mut Session, document: &Document, index: usize) -> Found<Arc<Image>> {
        let path = format!("images[{index}]");
        let image = &document.root.images[index];
        let name =
            image.name.as_deref().or(image.uri.as_deref().filter(|uri| !uri.starts_with("data:"))).unwrap_or(&path);
        let explain = |error: image::Unreadable| {
            let about = Diagnostic::about_path(Severity::Error, error.code(), path.as_str(), "");
            Box::new(error.explain(about, name))
        };
        let file = if self.ahead.contains_key(&index) { None } else { Some(bytes(session, document, index)?) };
        let digest = file.as_ref().map_or_else(|| self.ahead[&index], |file| hash::of(file));
        // An edit elsewhere in the file, or another time of its animation, leaves the pixels where they are in memory.
        if let Some(known) = session.assets.pictures.get(&digest) {
            image::take(&mut session.budgets.pixels, known.width, known.height).map_err(explain)?;
            return Ok(Arc::clone(known));
        }
        let file = file.map_or_else(|| bytes(session, document, index), Ok)?;
        let read = image::read(&file, &mut session.budgets.pixels).map(Arc::new).map_err(explain)?;
        session.assets.pictures.insert(digest, Arc::clone(&read));
        Ok(read)
    }
}

/// The textures that a material refers to in its JSON, but for occlusion.
fn referred(value: &Value, found: &mut BTreeSet<usize>) {
    for (name, value) in value.as_object().into_iter().flatten().filter(|(name, _)| *name != "occlusionTexture") {
        match value.get("index").and_then(Value::as_u64) {
            Some(index) if name.ends_with("Texture") => drop(found.insert(index as usize)),
            _ => referred(value, found),
        }
    }
}

/// The file of an image.
fn bytes<'d>(session: &mut Session, document: &'d Document, index: usize) -> Found<Cow<'d, [u8]>> {
    let path = format!("images[{index}]");
    let image = &document.root.images[index];
    match (&image.uri, image.buffer_view) {
        (Some(uri), _) => document.read(session, uri, &format!("{path}.uri")).map(Cow::Owned),
        (None, Some(view)) => document.view(view, &path).map(Cow::Borrowed),
        (None, None) => Err(broken(path.as_str(), "neither `uri` nor `bufferView` is given").into()),
    }
}

/// The image of a texture: of its extensions' if there is one, since they are there to be preferred.
fn source(root: &json::Root, texture: &json::Texture, path: &str) -> Found<Option<usize>> {
    let plain = Some(texture.source.value())
        .filter(|&index| texture.source != Index::new(u32::MAX) && index < root.images.len());
    for name in ["KHR_texture_basisu", "EXT_texture_webp"] {
        if let Some(found) = extensions::fields(others!(texture), name, path)? {
            let source: usize = found.need("source")?;
            if source >= root.images.len() {
                return Err(broken(found.path_of("source"), format!("there is no images[{source}]")).into());
            }
            return Ok(Some(source));
        }
    }
    Ok(plain)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Mat3, Vec2, Vec3};

    #[test]
    fn transforms_are_the_specifications_matrices() {
        // KHR_texture_transform's own sample code: translation * rotation * scale, then 1 - v.
        let (offset, rotation, scale) = ([0.25, -0.5], 0.7f32, [2.0, 3.0]);
        let translation = Mat3::from_cols(Vec3::X, Vec3::Y, Vec3::new(offset[0], offset[1], 1.0));
        let turn = Mat3::from_cols(
            Vec3::new(rotation.cos(), -rotation.sin(), 0.0),
            Vec3::new(rotation.sin(), rotation.cos(), 0.0),
            Vec3::Z,
        );
        let stretch = Mat3::from_diagonal(Vec3::new(scale[0], scale[1], 1.0));
        let found = Transform { offset, rotation, scale, tex_coord: None }.map();
        for uv in [Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::new(0.3, -1.7)] {
            let expected = translation * turn * stretch * uv.extend(1.0);
            let expected = Vec2::new(expected.x, 1.0 - expected.y);
            assert!((found.apply(uv) - expected).length() < 1e-6, "{uv}: {} for {expected}", found.apply(uv));
        }
    }
}
