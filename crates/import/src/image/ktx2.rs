//! KTX2 with Basis Universal's codecs, which glTF's `KHR_texture_basisu` uses, through `basisu`.

use basisu::{DecodeFlags, TargetFormat, Transcoder};
use brewster_world::components::parts::{Image, Texels};

/// What such files begin with.
pub(super) const MAGIC: &[u8] = b"\xabKTX 20\xbb\r\n\x1a\n";

/// A file whose header was read.
pub(super) struct File<'f>(Transcoder<'f>);

impl File<'_> {
    pub(super) fn open(bytes: &[u8]) -> Result<File<'_>, String> {
        Transcoder::new(bytes).map(File).map_err(|error| format!("{error:?}"))
    }

    /// Width and height of the largest level.
    pub(super) fn size(&self) -> [u32; 2] {
        let (width, height) = self.0.base_dimensions();
        [width, height]
    }

    /// The largest level.
    pub(super) fn decode(&self) -> Result<Image, String> {
        let [width, height] = self.size();
        let bytes =
            self.0.transcode(0, TargetFormat::Rgba32, DecodeFlags::NONE).map_err(|error| format!("{error:?}"))?;
        let texels = bytes.as_chunks().0.to_vec();
        match texels.len() == width as usize * height as usize {
            true => Ok(Image { width, height, texels: Texels::Bytes(texels) }),
            false => Err("the file holds another number of pixels than it says".into()),
        }
    }
}
