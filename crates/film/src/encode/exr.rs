//! OpenEXR: every layer of the film in full precision, as named channels of one part.

use std::path::Path;

use exr::prelude::{
    AnyChannel, AnyChannels, AttributeValue, Compression, Encoding, FlatSamples, Image, ImageAttributes, IntegerBounds,
    Layer, LayerAttributes, LineOrder, Text, Vec2, WritableImage,
};

use super::{Metadata, codec_error};
use crate::{FilmError, Layers, LightLayersColumns, write_atomically};

/// Writes every layer.
///
/// | channels | type | |
/// | --- | --- | --- |
/// | `R` `G` `B` `A` | f32 | linear Rec.709 radiance, associated alpha |
/// | `depth.Z` | f32 | meters; infinite where nothing was hit |
/// | `normal.X` `normal.Y` `normal.Z` | f32 | world space; zero where nothing was hit |
/// | `material.id` `entity.id` | u32 | [`crate::NO_ID`] where sample 0 hit nothing |
/// | `rays.count` `samples.count` | u32 | |
/// | `se.R` `se.G` `se.B` | f32 | standard error of the color; infinite with less than two samples |
/// | `albedo.R` … | f32 | the part of the light that the first surface sends back or lets through; zero where nothing was hit |
/// | `direct.R` … `reflection.R` … `transmission.R` … | f32 | the color by the way in which light left the first surface |
///
/// The last three rows are there if the film [keeps](crate::Keep) what they come from.
///
/// The display window is the picture, the data window the crop window. The attributes `software` (the version),
/// `brewster.settings` and `brewster.sceneHash` hold the metadata in UTF-8. Compression is lossless (ZIP) and uses every
/// core.
///
/// # Errors
///
/// The file can't be written.
pub fn write_exr(path: &Path, layers: &Layers, metadata: &Metadata) -> Result<(), FilmError> {
    let text = |text: &str| Text::from_slice_unchecked(text.as_bytes());
    let window = layers.window;
    let mut attributes = LayerAttributes { software_name: Some(text(&metadata.version)), ..LayerAttributes::default() };
    attributes.layer_position = Vec2(window.x as i32, window.y as i32);
    // The crate writes each of these two maps in an order of its own: one entry in each keeps the bytes the same.
    attributes.other.insert(text("brewster.settings"), AttributeValue::Text(text(&metadata.settings)));
    let picture = IntegerBounds::from_dimensions((layers.width as usize, layers.height as usize));
    let mut shared = ImageAttributes::new(picture);
    shared.other.insert(text("brewster.sceneHash"), AttributeValue::Text(text(&metadata.scene_hash)));

    let size = (window.width as usize, window.height as usize);
    let encoding =
        Encoding { compression: Compression::ZIP16, line_order: LineOrder::Increasing, ..Encoding::default() };
    let layer = Layer::new(size, attributes, encoding, channels(layers));
    let image = Image::empty(shared).with_layer(layer);
    write_atomically(path, |file| image.write().to_buffered(file).map_err(|error| codec_error(path, error)))
}

fn channels(layers: &Layers) -> AnyChannels<FlatSamples> {
    let pixels = layers.pixels.view();
    let component = |of: &[[f32; 3]], axis: usize| FlatSamples::F32(of.iter().map(|value| value[axis]).collect());
    let mut channels = vec![
        ("R", component(pixels.color, 0)),
        ("G", component(pixels.color, 1)),
        ("B", component(pixels.color, 2)),
        ("A", FlatSamples::F32(pixels.alpha.to_vec())),
        ("depth.Z", FlatSamples::F32(pixels.depth.to_vec())),
        ("normal.X", component(pixels.normal, 0)),
        ("normal.Y", component(pixels.normal, 1)),
        ("normal.Z", component(pixels.normal, 2)),
        ("material.id", FlatSamples::U32(pixels.material.to_vec())),
        ("entity.id", FlatSamples::U32(pixels.entity.to_vec())),
        ("rays.count", FlatSamples::U32(pixels.rays.to_vec())),
        ("samples.count", FlatSamples::U32(pixels.samples.to_vec())),
    ];
    let mut colors = |names: [&'static str; 3], of: &[[f32; 3]]| {
        channels.extend(names.into_iter().zip([0, 1, 2].map(|axis| component(of, axis))));
    };
    if let Some(errors) = &layers.errors {
        colors(["se.R", "se.G", "se.B"], errors);
    }
    if let Some(light) = layers.light.as_ref().map(LightLayersColumns::view) {
        colors(["albedo.R", "albedo.G", "albedo.B"], light.albedo);
        colors(["direct.R", "direct.G", "direct.B"], light.direct);
        colors(["reflection.R", "reflection.G", "reflection.B"], light.reflection);
        colors(["transmission.R", "transmission.G", "transmission.B"], light.transmission);
    }
    AnyChannels::sort(channels.into_iter().map(|(name, samples)| AnyChannel::new(name, samples)).collect())
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::{Film, FirstHit, Keep, Light, NO_ID, Part, PixelOrder, Window, read_image};

    fn layers() -> Layers {
        let window = Window { x: 3, y: 1, width: 21, height: 50 };
        let mut film = Film::keeping(PixelOrder::new(30, 60, Some(window)).unwrap(), Keep::ALL);
        let mut tile = film.tile_mut();
        for local in 0..tile.len() as u32 {
            let (x, y) = tile.pixel(local);
            tile.add_sample(local, Light::new([x as f32, y as f32, 1000.0]).unwrap());
            tile.add_part(local, Part::Reflection, Light([0, 0, 300 << 32]));
            tile.add_part(local, Part::Transmission, Light([0, 0, 200 << 32]));
            tile.add_rays(local, 100 * y + x);
            if x.is_multiple_of(2) {
                let (normal, albedo) = ([0.0, 0.6, -0.8], [0.5, 0.25, 1.0]);
                let hit = FirstHit { depth: y as f32 + 0.5, normal, albedo, material: x, entity: 70_000 + y };
                tile.add_first_hit(local, 0, hit);
            }
        }
        film.resolve()
    }

    fn metadata() -> Metadata {
        Metadata {
            scene_hash: "00ff".to_owned(),
            settings: "samples: 1, größe".to_owned(),
            version: "brewster 1".to_owned(),
        }
    }

    #[test]
    fn every_layer_is_a_named_channel() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("layers.exr");
        write_exr(&path, &layers(), &metadata()).unwrap();

        let image = exr::prelude::read_first_flat_layer_from_file(&path).unwrap();
        let layer = &image.layer_data;
        assert_eq!(image.attributes.display_window, IntegerBounds::from_dimensions((30, 60)));
        assert_eq!((layer.attributes.layer_position, layer.size), (Vec2(3, 1), Vec2(21, 50)));
        assert_eq!(layer.attributes.software_name, Some(Text::from("brewster 1")));
        let attribute = |name: &str| match &layer.attributes.other[&Text::from(name)] {
            AttributeValue::Text(text) => text.as_slice(),
            _ => panic!("{name} is not text"),
        };
        assert_eq!(attribute("brewster.sceneHash"), b"00ff");
        assert_eq!(attribute("brewster.settings"), "samples: 1, größe".as_bytes());

        let channel = |name: &str| {
            let channel = layer.channel_data.list.iter().find(|channel| channel.name.eq(name)).expect(name);
            &channel.sample_data
        };
        let float = |name: &str, index: usize| match channel(name) {
            FlatSamples::F32(values) => values[index],
            _ => panic!("{name} is not f32"),
        };
        let count = |name: &str, index: usize| match channel(name) {
            FlatSamples::U32(values) => values[index],
            _ => panic!("{name} is not u32"),
        };
        assert_eq!(layer.channel_data.list.len(), 27);
        for index in 0..21 * 50 {
            let (x, y) = (3 + index as u32 % 21, 1 + index as u32 / 21);
            assert_eq!(["R", "G", "B"].map(|name| float(name, index)), [x as f32, y as f32, 1000.0]);
            let hit = x.is_multiple_of(2);
            assert_eq!(float("A", index), if hit { 1.0 } else { 0.0 });
            assert_eq!(float("depth.Z", index), if hit { y as f32 + 0.5 } else { f32::INFINITY });
            let normal = ["normal.X", "normal.Y", "normal.Z"].map(|name| float(name, index));
            assert_eq!(normal, if hit { [0.0, 0.6, -0.8] } else { [0.0; 3] });
            assert_eq!(count("material.id", index), if hit { x } else { NO_ID });
            assert_eq!(count("entity.id", index), if hit { 70_000 + y } else { NO_ID });
            let blue = ["direct.B", "reflection.B", "transmission.B"].map(|name| float(name, index));
            assert_eq!(blue, [500.0, 300.0, 200.0]);
            assert_eq!((float("direct.R", index), float("reflection.R", index)), (x as f32, 0.0));
            let albedo = ["albedo.R", "albedo.G", "albedo.B"].map(|name| float(name, index));
            assert_eq!(albedo, if hit { [0.5, 0.25, 1.0] } else { [0.0; 3] });
            assert_eq!(float("se.G", index), f32::INFINITY, "one sample tells no error");
            assert_eq!((count("rays.count", index), count("samples.count", index)), (100 * y + x, 1));
        }
    }

    #[test]
    fn color_and_alpha_come_back_in_their_place() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("crop.exr");
        write_exr(&path, &layers(), &metadata()).unwrap();
        assert_eq!(read_image(&path).unwrap(), layers().image());
    }

    #[test]
    fn the_same_picture_gives_the_same_bytes() {
        let folder = tempfile::tempdir().unwrap();
        let files = [1, 2, 3, 4].map(|number| {
            let path = folder.path().join(format!("{number}.exr"));
            write_exr(&path, &layers(), &metadata()).unwrap();
            fs::read(&path).unwrap()
        });
        assert!(files.iter().all(|file| *file == files[0]));
    }
}
