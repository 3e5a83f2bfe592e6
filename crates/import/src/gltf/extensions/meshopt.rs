//! `EXT_meshopt_compression`, and `KHR_meshopt_compression`, which differs by name and in streams that the decoder knows
//! apart: a view of a buffer whose bytes are compressed.

use draco_gltf::meshopt::{MeshoptFilter, MeshoptMode, decode_buffer_view};
use serde::Deserialize;

use super::super::document::Document;
use super::super::{Found, broken};

const NAMES: [&str; 2] = ["KHR_meshopt_compression", "EXT_meshopt_compression"];

/// A decoded view may be so many times larger than its stream: 16 bytes of a column that does not change take 2 bits, a whole
/// block of 256 less.
const EXPANSION: u64 = 1024;

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Compressed {
    buffer: usize,
    #[serde(default)]
    byte_offset: u64,
    byte_length: u64,
    byte_stride: u64,
    count: u64,
    mode: String,
    filter: Option<String>,
}

/// The bytes of a view, if it is compressed.
pub(in crate::gltf) fn decode(document: &Document, index: usize) -> Found<Option<Vec<u8>>> {
    let path = format!("bufferViews[{index}]");
    let view = &document.root.buffer_views[index];
    for name in NAMES {
        let Some(compressed) = super::read::<Compressed>(super::others!(view), name, &path)? else { continue };
        let path = format!("{path}.extensions.{name}");
        let source =
            document.range(compressed.buffer, compressed.byte_offset, compressed.byte_length, || path.clone())?;
        let size = compressed.count.checked_mul(compressed.byte_stride);
        let most = EXPANSION.saturating_mul(compressed.byte_length.saturating_add(64));
        let Some(size) = size.filter(|&size| size <= most) else {
            let message = format!("{} rows cannot come out of {} bytes", compressed.count, compressed.byte_length);
            return Err(broken(format!("{path}.count"), message).into());
        };
        let mode = MeshoptMode::from_name(&compressed.mode);
        let mode = mode.map_err(|error| broken(format!("{path}.mode"), error.to_string()))?;
        let filter = MeshoptFilter::from_name(compressed.filter.as_deref().unwrap_or("NONE"));
        let filter = filter.map_err(|error| broken(format!("{path}.filter"), error.to_string()))?;
        let mut bytes = vec![0; size as usize];
        let (count, stride) = (compressed.count as usize, compressed.byte_stride as usize);
        decode_buffer_view(&mut bytes, source, mode, filter, count, stride)
            .map_err(|error| broken(path, error.to_string()))?;
        return Ok(Some(bytes));
    }
    Ok(None)
}
