//! The JSON of a glTF file, typed and checked, and the bytes it refers to.
//!
//! The JSON is kept twice: as plain values, which animation changes, and as the types of the `gltf` crate that are read from
//! them. Nothing behind an index is looked up before all indices were checked.

use std::path::{Path, PathBuf};

use glam::Affine3A;
use gltf::json::{Index, Root, Value, buffer};

use super::container::{Container, Uri};
use super::extensions::{self, meshopt};
use super::{Found, Reporter, broken, is_gltf, typed, validate};
use crate::diagnostics::{Code, Diagnostic};
use crate::hash::Digest;
use crate::sandbox::Refusal;
use crate::session::{Session, describe};

/// A glTF file with all its buffers.
pub(super) struct Document {
    /// The JSON as it stands, but for the animations.
    pub value: Value,
    /// The animations, which the crate's types know only in part.
    pub animations: Value,
    /// The same, typed.
    pub root: Root,
    /// From the space of each node to its parent's after each step of the shutter's time; no steps if nothing moves.
    pub steps: Vec<Vec<Affine3A>>,
    /// The folder that URIs are relative to, canonical.
    pub folder: PathBuf,
    /// None for a buffer without bytes of its own, which is legal where all its views are compressed.
    buffers: Vec<Option<Vec<u8>>>,
    /// What compressed views hold.
    decoded: Vec<Option<Vec<u8>>>,
    /// Bytes of the file and of its buffers.
    pub size: usize,
    /// Of the same bytes.
    pub digest: Digest,
}

impl Document {
    /// Reads a file's bytes and the buffers it refers to.
    pub(super) fn open(session: &mut Session, reporter: &mut Reporter, bytes: &[u8], folder: &Path) -> Found<Document> {
        let container = Container::open(bytes)?;
        let mut value: Value = serde_json::from_slice(container.json).map_err(|error| {
            let place = format!("line {}, column {}", error.line(), error.column());
            broken("", format!("the JSON cannot be read: {error}")).note(format!("at {place} of the JSON"))
        })?;
        let animations = value.get_mut("animations").map(Value::take).unwrap_or_default();
        if let Some(object) = value.as_object_mut() {
            object.remove("animations");
        }
        let root = typed(&value, "")?;
        check_version(&root)?;
        extensions::check(&root, reporter)?;
        validate::check(&root, &value)?;
        let mut document = Document {
            value,
            animations,
            root,
            steps: Vec::new(),
            folder: folder.to_path_buf(),
            buffers: Vec::new(),
            decoded: Vec::new(),
            size: bytes.len(),
            digest: Digest::default(),
        };
        document.digest.update(bytes);
        for (index, buffer) in document.root.buffers.iter().enumerate() {
            let bytes = read_buffer(session, folder, container.binary, index, buffer)?;
            if let Some(bytes) = &bytes {
                document.size += bytes.len();
                document.digest.update(bytes);
            }
            document.buffers.push(bytes);
        }
        for index in 0..document.root.buffer_views.len() {
            let decoded = meshopt::decode(&document, index)?;
            document.decoded.push(decoded);
        }
        Ok(document)
    }

    /// Reads the types from the values again, after these changed.
    pub(super) fn retype(&mut self) -> Found<()> {
        self.root = typed(&self.value, "")?;
        Ok(())
    }

    /// The bytes of a view; `path` is what asks for them.
    pub(super) fn view(&self, index: Index<buffer::View>, path: &str) -> Found<&[u8]> {
        if let Some(Some(decoded)) = self.decoded.get(index.value()) {
            return Ok(decoded);
        }
        let view = &self.root.buffer_views[index.value()];
        self.range(view.buffer.value(), view.byte_offset.map_or(0, |offset| offset.0), view.byte_length.0, || {
            format!("{path}: bufferViews[{}]", index.value())
        })
    }

    /// Bytes of a buffer.
    pub(super) fn range(&self, buffer: usize, offset: u64, length: u64, path: impl Fn() -> String) -> Found<&[u8]> {
        let Some(Some(bytes)) = self.buffers.get(buffer) else {
            return Err(broken(path(), format!("buffer {buffer} has no bytes: it has no `uri`")).into());
        };
        let end = offset.checked_add(length).filter(|&end| end <= bytes.len() as u64);
        match end {
            Some(end) => Ok(&bytes[offset as usize..end as usize]),
            None => {
                let message = format!("{length} bytes from byte {offset} on go beyond the end of buffer {buffer}");
                Err(broken(path(), message).expected(format!("an end at byte {} or before", bytes.len())).into())
            }
        }
    }

    /// The bytes of a URI: those that it holds, or those of a file beside this one.
    pub(super) fn read(&self, session: &mut Session, uri: &str, path: &str) -> Found<Vec<u8>> {
        read(session, &self.folder, uri, path)
    }
}

fn check_version(root: &Root) -> Found<()> {
    let number = |text: &str| text.split('.').next().and_then(|major| major.parse::<u32>().ok());
    let least = root.asset.min_version.as_deref();
    for (path, version) in [("asset.version", Some(root.asset.version.as_str())), ("asset.minVersion", least)] {
        if let Some(version) = version
            && number(version) != Some(2)
        {
            return Err(broken(path, format!("the file is of version {version:.20?}")).expected("\"2.0\"").into());
        }
    }
    if least.is_some_and(|least| least != "2.0") {
        return Err(broken("asset.minVersion", "the file needs a reader of a later version")
            .expected("\"2.0\"")
            .into());
    }
    Ok(())
}

fn read_buffer(
    session: &mut Session,
    folder: &Path,
    binary: Option<&[u8]>,
    index: usize,
    buffer: &gltf::json::Buffer,
) -> Found<Option<Vec<u8>>> {
    let path = format!("buffers[{index}]");
    let mut bytes = match (&buffer.uri, binary) {
        (Some(uri), _) => read(session, folder, uri, &format!("{path}.uri"))?,
        (None, Some(binary)) if index == 0 => binary.to_vec(),
        (None, _) => return Ok(None),
    };
    let stated = buffer.byte_length.0;
    if stated > bytes.len() as u64 {
        let message = format!("the buffer says it has {stated} bytes, but there are {}", bytes.len());
        return Err(broken(format!("{path}.byteLength"), message).into());
    }
    bytes.truncate(stated as usize);
    Ok(Some(bytes))
}

fn read(session: &mut Session, folder: &Path, uri: &str, path: &str) -> Found<Vec<u8>> {
    let name = match Uri::parse(uri, path)? {
        Uri::Data(bytes) => return Ok(bytes),
        Uri::File(name) => name,
    };
    match session.read_beside(folder, &name) {
        Ok((bytes, _)) => Ok(bytes),
        Err(refusal) => {
            let (code, reason) = describe(&refusal);
            let problem = Diagnostic { code, ..broken(path, format!("cannot read {name:?}: {reason}")) };
            Err(Box::new(match refusal {
                Refusal::Outside => problem
                    .expected("a file in the folder of the glTF file or below it")
                    .help("other folders are allowed by `--allow-path DIR`"),
                _ if code == Code::File => match session.neighbor(folder, &name).filter(|name| !is_gltf(name.as_ref()))
                {
                    Some(neighbor) => problem.help(format!("did you mean {neighbor:?}?")),
                    None => problem,
                },
                _ => problem,
            }))
        }
    }
}
