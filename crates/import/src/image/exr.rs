//! OpenEXR files: the channels `R`, `G` and `B` of the first part that has them.

use std::io::Cursor;

use brewster_world::components::parts::{Image, Texels};
use exr::math::Vec2;
use exr::meta::MetaData;
use exr::meta::attribute::IntegerBounds;
use exr::meta::header::Header;
use exr::prelude::{ReadChannels, ReadLayers, SpecificChannels, WritableImage, read};

/// What every such file begins with.
pub(super) const MAGIC: &[u8] = &[0x76, 0x2f, 0x31, 0x01];

/// A file whose pixels are not read yet.
pub(super) struct File<'b> {
    bytes: &'b [u8],
    /// Where the picture is.
    picture: IntegerBounds,
    /// The part of it, or more than it, that the file holds.
    data: IntegerBounds,
}

/// A picture of linear numbers as a file.
pub(super) fn write(picture: &Image) -> Result<Vec<u8>, String> {
    let width = picture.width as usize;
    let pixel = |Vec2(x, y): Vec2<usize>| picture.floats().get(y * width + x).copied().unwrap_or_default().into();
    let channels = SpecificChannels::rgb(|place: Vec2<usize>| -> (f32, f32, f32) { pixel(place) });
    let mut bytes = Cursor::new(Vec::new());
    let file = exr::prelude::Image::from_channels((width, picture.height as usize), channels);
    // In the order of rows: threads would write blocks as they come.
    file.write().non_parallel().to_buffered(&mut bytes).map_err(|error| error.to_string())?;
    Ok(bytes.into_inner())
}

impl File<'_> {
    pub(super) fn open(bytes: &[u8]) -> Result<File<'_>, String> {
        let metadata = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(|error| error.to_string())?;
        let header =
            metadata.headers.iter().find(|header| has_colors(header)).ok_or("it has no channels R, G and B")?;
        Ok(File { bytes, picture: header.shared_attributes.display_window, data: header.data_window() })
    }

    /// Width and height of the picture, or of what the file holds if that is more.
    pub(super) fn largest(&self) -> [u32; 2] {
        let [picture, data] = [self.picture.size, self.data.size];
        let larger = if data.0.saturating_mul(data.1) > picture.0.saturating_mul(picture.1) { data } else { picture };
        [larger.0, larger.1].map(|side| u32::try_from(side).unwrap_or(u32::MAX))
    }

    /// The picture; where the file holds nothing of it, it is black.
    pub(super) fn decode(&self) -> Result<Image, String> {
        let Vec2(width, height) = self.picture.size;
        let left = i64::from(self.data.position.0) - i64::from(self.picture.position.0);
        let top = i64::from(self.data.position.1) - i64::from(self.picture.position.1);
        let black = move |_, _: &_| vec![[0.0; 3]; width * height];
        let place = move |pixels: &mut Vec<[f32; 3]>, at: Vec2<usize>, (r, g, b): (f32, f32, f32)| {
            let (x, y) = (at.0 as i64 + left, at.1 as i64 + top);
            if (0..width as i64).contains(&x) && (0..height as i64).contains(&y) {
                pixels[y as usize * width + x as usize] = [r, g, b].map(super::tame);
            }
        };
        let image = read()
            .no_deep_data()
            .largest_resolution_level()
            .rgb_channels(black, place)
            .first_valid_layer()
            .all_attributes()
            .non_parallel()
            .from_buffered(Cursor::new(self.bytes))
            .map_err(|error| error.to_string())?;
        let texels = Texels::Floats(image.layer_data.channel_data.pixels);
        Ok(Image { width: width as u32, height: height as u32, texels })
    }
}

/// Whether the part is one that colors can be read from.
fn has_colors(header: &Header) -> bool {
    let has = |name: &str| header.channels.list.iter().any(|channel| channel.name.eq(name));
    !header.deep && has("R") && has("G") && has("B")
}
