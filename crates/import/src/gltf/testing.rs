//! Small glTF files, built by hand for tests.

use std::path::Path;
use std::sync::Arc;

use brewster_world::components::parts::TriangleMesh;
use brewster_world::components::{Detail, Shape};

use super::document::Document;
use super::{Reporter, load_bytes};
use crate::LoadOptions;
use crate::limits::Limits;
use crate::scene::{Part, Scene};
use crate::session::{Assets, Session};

/// A file's parts as JSON texts.
#[derive(Default)]
pub(super) struct Builder {
    pub bytes: Vec<u8>,
    pub views: Vec<String>,
    pub accessors: Vec<String>,
    /// Further members of the root object.
    pub rest: String,
}

impl Builder {
    /// Adds a view of new bytes; its number.
    pub(super) fn view(&mut self, bytes: &[u8], stride: Option<usize>) -> usize {
        let stride = stride.map_or(String::new(), |stride| format!(",\"byteStride\":{stride}"));
        let (offset, length) = (self.bytes.len(), bytes.len());
        self.views.push(format!(r#"{{"buffer":0,"byteOffset":{offset},"byteLength":{length}{stride}}}"#));
        self.bytes.extend(bytes);
        self.views.len() - 1
    }

    /// Adds an accessor; its number.
    pub(super) fn accessor(&mut self, view: usize, offset: usize, component: u32, count: usize, kind: &str) -> usize {
        self.accessors.push(format!(
            r#"{{"bufferView":{view},"byteOffset":{offset},"componentType":{component},"count":{count},"type":"{kind}"}}"#
        ));
        self.accessors.len() - 1
    }

    /// Adds an accessor of f32; its number.
    pub(super) fn floats(&mut self, rows: &[f32], kind: &str) -> usize {
        let width = match kind {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "MAT4" => 16,
            _ => 4,
        };
        let bytes: Vec<u8> = rows.iter().flat_map(|row| row.to_le_bytes()).collect();
        let view = self.view(&bytes, None);
        self.accessor(view, 0, 5126, rows.len() / width, kind)
    }

    /// The file, with its bytes as a data URI.
    pub(super) fn text(&self) -> String {
        use base64::Engine;
        let data = base64::engine::general_purpose::STANDARD.encode(&self.bytes);
        let buffers = match self.bytes.len() {
            0 => String::new(),
            length => {
                let uri = format!("data:application/octet-stream;base64,{data}");
                format!(
                    r#","buffers":[{{"byteLength":{length},"uri":"{uri}"}}],"bufferViews":[{}]"#,
                    self.views.join(",")
                )
            }
        };
        let accessors = match &self.accessors[..] {
            [] => String::new(),
            accessors => format!(r#","accessors":[{}]"#, accessors.join(",")),
        };
        format!(r#"{{"asset":{{"version":"2.0"}}{buffers}{accessors}{}}}"#, self.rest)
    }
}

/// The scene of a file, or all that was said of one that is wrong.
pub(super) fn load(builder: &Builder, limits: Limits) -> Result<Scene, String> {
    let path = Path::new("test.gltf");
    let mut assets = Assets::default();
    let mut session = Session::new(path, &[], limits, &mut assets);
    let scene = load_bytes(&mut session, path, builder.text().as_bytes(), &LoadOptions::default());
    scene.ok_or_else(|| format!("{:?}", session.found.finish()))
}

/// The triangles of the only mesh of a file that is right, and what they wear.
pub(super) fn load_mesh(builder: &Builder) -> (Arc<TriangleMesh>, Detail) {
    let scene = load(builder, Limits::DEFAULT).unwrap_or_else(|said| panic!("{said}"));
    let row = scene.rows.iter().find(|row| !matches!(row.shape, Part::None)).expect("a mesh");
    let Part::Own(shape) = &row.shape else { panic!("{row:?}") };
    let (Shape::Mesh(mesh), Part::Of(material)) = (&**shape, &row.material) else { panic!("{row:?}") };
    (Arc::clone(mesh), scene.rows[*material as usize].detail.as_deref().cloned().unwrap_or_default())
}

/// The document of a file that is right.
pub(super) fn document(builder: &Builder) -> Document {
    let mut assets = Assets::default();
    let mut session = Session::new(Path::new("test.gltf"), &[], Limits::DEFAULT, &mut assets);
    let document =
        Document::open(&mut session, &mut Reporter::new("test.gltf"), builder.text().as_bytes(), Path::new("."));
    document.unwrap_or_else(|error| panic!("{error}"))
}
