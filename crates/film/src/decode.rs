//! Files to pictures: what the encoders write, and what others write in these formats.

use std::{
    fs::{self, File},
    io::{self, BufReader, Read, Seek},
    path::Path,
};

use ::exr::{
    meta::{MetaData, header::Header},
    prelude::{ReadChannels, ReadLayers, Vec2, read},
};
use image::{DynamicImage, ImageDecoder, ImageReader};

use crate::{FilmError, LinearImage, encode::codec_error, order::check_size, srgb_decode};

/// Reads a PNG, EXR or HDR file, told apart by their content, as linear Rec.709.
///
/// - PNG: values are taken for sRGB display values; colors are multiplied by alpha.
/// - EXR: `R`, `G`, `B` and, if it is there, `A` of the first part that has them; pixels of the display window that are
///   outside the data window are black and transparent, others outside the display window are dropped.
/// - HDR: as it is.
///
/// Sizes are checked against [`crate::MAX_SIDE`] and [`crate::MAX_PIXELS`] before memory is taken.
///
/// # Errors
///
/// The file can't be read, is no such picture, is damaged or too large. All name the file.
pub fn read_image(path: &Path) -> Result<LinearImage, FilmError> {
    let io_error = |source| FilmError::Io { path: path.to_path_buf(), source };
    // Looked at before it is opened: a pipe would be waited for.
    if !fs::metadata(path).map_err(io_error)?.is_file() {
        return Err(codec_error(path, "it is a folder, or no ordinary file"));
    }
    let mut reader = BufReader::new(File::open(path).map_err(io_error)?);
    let mut magic = Vec::with_capacity(4);
    reader.by_ref().take(4).read_to_end(&mut magic).map_err(io_error)?;
    reader.rewind().map_err(io_error)?;
    if magic == [0x76, 0x2f, 0x31, 0x01] { read_exr(&mut reader) } else { read_other(&mut reader) }
        .map_err(|message| codec_error(path, message))
}

fn read_other(reader: &mut BufReader<File>) -> Result<LinearImage, String> {
    let text = |error: image::ImageError| error.to_string();
    let reader = ImageReader::new(reader).with_guessed_format().map_err(|error: io::Error| error.to_string())?;
    if reader.format().is_none() {
        return Err("neither PNG nor EXR nor HDR".to_owned());
    }
    let decoder = reader.into_decoder().map_err(text)?;
    let (width, height) = decoder.dimensions();
    check_size(width, height).map_err(|error| error.to_string())?;
    let pixels = DynamicImage::from_decoder(decoder).map_err(text)?;

    let linear = matches!(pixels, DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_));
    let has_alpha = pixels.color().has_alpha();
    let mut image = LinearImage::black(width, height);
    let mut coverage = Vec::with_capacity(if has_alpha { image.color.len() } else { 0 });
    for (color, pixel) in image.color.iter_mut().zip(pixels.into_rgba32f().pixels()) {
        let [r, g, b, alpha] = pixel.0;
        *color = if linear { [r, g, b] } else { [r, g, b].map(srgb_decode) };
        if has_alpha {
            *color = color.map(|value| value * alpha);
            coverage.push(alpha);
        }
    }
    image.alpha = has_alpha.then_some(coverage);
    Ok(image)
}

fn read_exr(reader: &mut BufReader<File>) -> Result<LinearImage, String> {
    let text = |error: ::exr::error::Error| error.to_string();
    let metadata = MetaData::read_from_buffered(&mut *reader, false).map_err(text)?;
    let header = metadata.headers.iter().find(|header| has_colors(header)).ok_or("no channels R, G and B")?;
    let (picture, data) = (header.shared_attributes.display_window, header.data_window());
    let (width, height) = checked_size(picture.size)?;
    checked_size(data.size)?;
    let has_alpha = header.channels.list.iter().any(|channel| channel.name.eq("A"));
    let left = i64::from(data.position.0) - i64::from(picture.position.0);
    let top = i64::from(data.position.1) - i64::from(picture.position.1);

    let empty = move |_, _: &_| {
        let mut image = LinearImage::black(width, height);
        image.alpha = has_alpha.then(|| vec![0.0; image.color.len()]);
        image
    };
    let place = move |image: &mut LinearImage, at: Vec2<usize>, (r, g, b, alpha): (f32, f32, f32, f32)| {
        let (x, y) = (at.0 as i64 + left, at.1 as i64 + top);
        if (0..i64::from(width)).contains(&x) && (0..i64::from(height)).contains(&y) {
            let index = y as usize * width as usize + x as usize;
            image.color[index] = [r, g, b];
            if let Some(coverage) = &mut image.alpha {
                coverage[index] = alpha;
            }
        }
    };
    reader.rewind().map_err(|error| error.to_string())?;
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .rgba_channels(empty, place)
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(reader)
        .map_err(text)?;
    Ok(image.layer_data.channel_data.pixels)
}

/// Whether the part is one that colors can be read from.
fn has_colors(header: &Header) -> bool {
    let has = |name: &str| header.channels.list.iter().any(|channel| channel.name.eq(name));
    !header.deep && has("R") && has("G") && has("B")
}

fn checked_size(size: Vec2<usize>) -> Result<(u32, u32), String> {
    let side = |side: usize| u32::try_from(side).unwrap_or(u32::MAX);
    let (width, height) = (side(size.0), side(size.1));
    check_size(width, height).map_err(|error| error.to_string())?;
    Ok((width, height))
}

#[cfg(test)]
mod tests {
    use std::{fs, path::PathBuf};

    use super::*;
    use crate::{Film, Light, Metadata, PixelOrder, PngAlpha, PngSettings, write_exr, write_hdr, write_png};

    /// A small file of each format.
    fn samples(folder: &Path) -> [PathBuf; 3] {
        let mut film = Film::new(PixelOrder::new(9, 5, None).unwrap());
        let mut tile = film.tile_mut();
        for local in 0..45 {
            tile.add_sample(local, Light::new([local as f32 / 45.0, 0.5, 0.25]).unwrap());
        }
        let layers = film.resolve();
        let paths = ["a.png", "a.exr", "a.hdr"].map(|name| folder.join(name));
        write_png(&paths[0], &layers.image(), &PngSettings::default()).unwrap();
        write_exr(&paths[1], &layers, &Metadata::default()).unwrap();
        write_hdr(&paths[2], &layers.image()).unwrap();
        paths
    }

    #[test]
    fn damaged_files_are_errors_that_name_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let broken = folder.path().join("broken");
        for sample in samples(folder.path()) {
            let bytes = fs::read(&sample).unwrap();
            for length in (0..bytes.len()).step_by(bytes.len() / 60 + 1) {
                fs::write(&broken, &bytes[..length]).unwrap();
                // A cut in the trailer may leave the picture whole.
                if let Err(error) = read_image(&broken) {
                    assert!(error.to_string().starts_with(&broken.display().to_string()), "{error}");
                } else {
                    assert!(length > bytes.len() / 2, "{} cut at {length}", sample.display());
                }
            }
            for position in 0..bytes.len().min(1200) {
                let mut bytes = bytes.clone();
                bytes[position] ^= 0x81;
                fs::write(&broken, &bytes).unwrap();
                let _ = read_image(&broken);
            }
        }
    }

    #[test]
    fn what_is_no_picture_is_said_so() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("notes.png");
        assert!(matches!(read_image(&path), Err(FilmError::Io { .. })));
        let message = read_image(folder.path()).unwrap_err().to_string();
        assert_eq!(message, format!("{}: it is a folder, or no ordinary file", folder.path().display()));
        for content in [&b""[..], b"v/1", b"these are notes"] {
            fs::write(&path, content).unwrap();
            let message = read_image(&path).unwrap_err().to_string();
            assert_eq!(message, format!("{}: neither PNG nor EXR nor HDR", path.display()));
        }
    }

    #[test]
    fn enormous_sizes_are_refused_before_memory_is_taken() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("huge");
        let [png, exr, hdr] = samples(folder.path());

        // Width and height stand at bytes 16 to 24 of a PNG, in a chunk with a checksum.
        let mut bytes = fs::read(png).unwrap();
        bytes[16..24].copy_from_slice(&[0, 0, 0x80, 0, 0, 1, 0, 0]);
        let checksum = crc32(&bytes[12..29]);
        bytes[29..33].copy_from_slice(&checksum.to_be_bytes());
        fs::write(&path, &bytes).unwrap();
        let message = read_image(&path).unwrap_err().to_string();
        assert!(message.contains("32768x65536 pixels: sides range from 1 to 65536"), "{message}");

        let text = fs::read(hdr).unwrap();
        let line = text.windows(2).position(|pair| pair == b"-Y").unwrap();
        let huge = [&text[..line], b"-Y 70000 +X 90000\n", &[2, 2, 0, 0]].concat();
        fs::write(&path, huge).unwrap();
        let message = read_image(&path).unwrap_err().to_string();
        assert!(message.contains("90000x70000 pixels"), "{message}");

        // The display window: four corners of 32 bits after the attribute's name, type and size.
        let mut bytes = fs::read(exr).unwrap();
        let name = b"displayWindow\0box2i\0";
        let start = bytes.windows(name.len()).position(|window| window == name).unwrap() + name.len() + 4;
        bytes[start + 8..start + 16].copy_from_slice(&[0xff, 0xff, 0, 0, 0xff, 0xff, 0xff, 0]);
        fs::write(&path, &bytes).unwrap();
        let message = read_image(&path).unwrap_err().to_string();
        assert!(message.contains("65536x16777216 pixels"), "{message}");
    }

    /// The checksum of a PNG chunk (ISO 3309).
    fn crc32(bytes: &[u8]) -> u32 {
        !bytes.iter().fold(u32::MAX, |crc, &byte| {
            (0..8).fold(crc ^ u32::from(byte), |crc, _| crc >> 1 ^ (0xedb8_8320 & (crc & 1).wrapping_neg()))
        })
    }

    #[test]
    fn alpha_multiplies_what_a_png_holds() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("alpha.png");
        let mut image = LinearImage::black(2, 1);
        image.color = vec![[0.5, 0.25, 0.0], [0.0; 3]];
        image.alpha = Some(vec![128.0 / 255.0, 0.0]);
        write_png(&path, &image, &PngSettings { alpha: PngAlpha::Straight, ..PngSettings::default() }).unwrap();
        let back = read_image(&path).unwrap();
        assert_eq!(back.alpha, image.alpha);
        for (found, expected) in back.color.as_flattened().iter().zip(image.color.as_flattened()) {
            assert!((found - expected).abs() < 0.01, "{found} for {expected}");
        }
    }
}
