//! `EXT_lights_image_based`: a cube of pictures that lights a scene from all around, resampled to the picture of a sky.
//!
//! Of the pictures the first six are taken, those of mirrors: the blurred ones and the coefficients of irradiance are for
//! renderers that do not follow light. A picture's colors are decoded from sRGB and divided by its alpha, which is how the format's
//! authors unpack RGBD; where there is no alpha, it is 1. Faces lie as seen from inside: the extension mirrors the pictures of
//! OpenGL's cubes, whose right is another's left.

use std::sync::Arc;

use brewster_lanes::math;
use brewster_world::components::parts::{Encoding, EnvironmentMap, Image, MapRows, Texels};
use glam::{Quat, Vec3};

use super::super::document::Document;
use super::super::fields::Fields;
use super::super::textures::Textures;
use super::super::{Found, Reporter, broken, too_much};
use super::others;
use crate::session::Session;

const NAME: &str = "EXT_lights_image_based";

/// Columns of the sky at most: finer faces lose detail.
const MOST_COLUMNS: u32 = 8192;

/// The sky that a scene's light is, if it has one; none, too, where a picture of it cannot be read, which is said.
pub(in crate::gltf) fn of_scene(
    (session, reporter): (&mut Session, &mut Reporter),
    document: &Document,
    scene: usize,
) -> Found<Option<Arc<EnvironmentMap>>> {
    let root = &document.root;
    let found = super::light(root, others!(root.scenes[scene]), NAME, &format!("scenes[{scene}]"))?;
    let Some(found) = found else { return Ok(None) };
    let intensity: f32 = found.get("intensity", 1.0)?;
    if !(intensity >= 0.0 && intensity.is_finite()) {
        let problem = broken(found.path_of("intensity"), format!("the intensity is {intensity}"));
        return Err(problem.expected("a number of 0 or more").into());
    }
    let rotation = Quat::from_array(found.get("rotation", [0.0, 0.0, 0.0, 1.0])?);
    if !(rotation.length_squared() > 1e-6 && rotation.is_finite()) {
        return Err(broken(found.path_of("rotation"), "no rotation").expected("a unit quaternion").into());
    }
    let Some(faces) = faces((session, reporter), document, &found)? else { return Ok(None) };
    let (columns, rows) = size(faces[0].width);
    let taken = session.budgets.pixels.take(u64::from(columns) * u64::from(rows));
    taken.map_err(|over| too_much(found.path(), format!("the light's picture is too large: {over}")))?;
    let picture = resampled(&faces, rotation.normalize(), intensity);
    match EnvironmentMap::new(Arc::new(picture), MapRows::Centers, 0.0) {
        Ok(map) => Ok(Some(Arc::new(map))),
        Err(error) => Err(broken(found.path(), format!("the pictures are no sky: {error}")).into()),
    }
}

/// The six faces; none where one cannot be read.
fn faces(
    (session, reporter): (&mut Session, &mut Reporter),
    document: &Document,
    light: &Fields,
) -> Found<Option<[Arc<Image>; 6]>> {
    let levels: Vec<[usize; 6]> = light.need("specularImages")?;
    let path = format!("{}[0]", light.path_of("specularImages"));
    let Some(indices) = levels.first() else {
        return Err(broken(path, "there are no pictures").expected("six images").into());
    };
    let mut textures = Textures::default();
    let mut faces: Vec<Arc<Image>> = Vec::with_capacity(6);
    for (face, &index) in indices.iter().enumerate() {
        let path = format!("{path}[{face}]");
        if index >= document.root.images.len() {
            let problem = broken(path, format!("there is no images[{index}]"));
            return Err(problem.expected(format!("a number below {}", document.root.images.len())).into());
        }
        let Some(image) = textures.image((session, reporter), document, index)? else { return Ok(None) };
        let side = faces.first().map_or(image.width, |first| first.width);
        if (image.width, image.height) != (side, side) {
            let problem = broken(path, format!("the face has {} x {} pixels", image.width, image.height));
            return Err(problem.expected(format!("a square of {side} pixels a side")).into());
        }
        faces.push(image);
    }
    Ok(faces.try_into().ok())
}

/// Columns and rows of a sky as fine as the middle of faces with so many pixels a side.
fn size(side: u32) -> (u32, u32) {
    let columns = side.saturating_mul(4).min(MOST_COLUMNS);
    (columns, columns / 2)
}

/// The sky that six faces show, turned by a rotation.
fn resampled(faces: &[Arc<Image>; 6], rotation: Quat, intensity: f32) -> Image {
    use std::f32::consts::{PI, TAU};
    let (columns, rows) = size(faces[0].width);
    let back = rotation.inverse();
    let texel = |index: u32| {
        let (u, v) = (index % columns, index / columns);
        let (longitude, angle) = (TAU * ((u as f32 + 0.5) / columns as f32 - 0.5), PI * (v as f32 + 0.5) / rows as f32);
        let ((z, x), (sine, cosine)) = (math::sin_cos(longitude), math::sin_cos(angle));
        (look(faces, back * Vec3::new(sine * x, cosine, sine * z)) * intensity).to_array()
    };
    Image { width: columns, height: rows, texels: Texels::Floats((0..columns * rows).map(texel).collect()) }
}

/// What the faces show in a direction, between pixels.
fn look(faces: &[Arc<Image>; 6], direction: Vec3) -> Vec3 {
    let [x, y, z] = direction.to_array();
    let [along_x, along_y, along_z] = direction.abs().to_array();
    // The face, and the place in it: to the right and down, from -1 to 1.
    let (face, right, down) = if along_x >= along_y && along_x >= along_z {
        if x > 0.0 { (0, z / along_x, -y / along_x) } else { (1, -z / along_x, -y / along_x) }
    } else if along_y >= along_z {
        if y > 0.0 { (2, -x / along_y, z / along_y) } else { (3, -x / along_y, -z / along_y) }
    } else if z > 0.0 {
        (4, -x / along_z, -y / along_z)
    } else {
        (5, x / along_z, -y / along_z)
    };
    let image = &faces[face];
    let most = image.width as f32 - 1.0;
    let place = |at: f32| ((0.5 * at + 0.5) * image.width as f32 - 0.5).clamp(0.0, most);
    let (column, row) = (place(right), place(down));
    let (left, top) = (column.floor(), row.floor());
    let pixel = |column: f32, row: f32| {
        let index = row.min(most) as usize * image.width as usize + column.min(most) as usize;
        let texel = image.texel(index, Encoding::Srgb);
        if texel.w > 0.0 { texel.truncate() / texel.w } else { Vec3::ZERO }
    };
    let across = |row: f32| pixel(left, row).lerp(pixel(left + 1.0, row), column - left);
    across(top).lerp(across(top + 1.0), row - top)
}

#[cfg(test)]
mod tests {
    use brewster_world::components::parts::Background;

    use super::super::super::testing::{Builder, load};
    use super::*;
    use crate::limits::Limits;

    /// What a file comes to whose faces have these sizes, red, and one pixel of their own: its sky, or its first error.
    fn loaded(sizes: [[u32; 2]; 6], light: &str) -> Result<Background, String> {
        let mut builder = Builder::default();
        for [width, height] in sizes {
            let mut bytes = Vec::new();
            let picture = ::image::RgbaImage::from_pixel(width, height, ::image::Rgba([255, 0, 0, 102]));
            picture.write_to(&mut std::io::Cursor::new(&mut bytes), ::image::ImageFormat::Png).expect("a picture");
            builder.view(&bytes, None);
        }
        let images: Vec<_> = (0..6).map(|view| format!(r#"{{"bufferView":{view},"mimeType":"image/png"}}"#)).collect();
        builder.rest = format!(
            r#","images":[{}],"extensionsUsed":["{NAME}"],"extensions":{{"{NAME}":{{"lights":[{light}]}}}},
                "scene":0,"scenes":[{{"nodes":[],"extensions":{{"{NAME}":{{"light":0}}}}}}]"#,
            images.join(",")
        );
        let limits = Limits { image_pixels: 1 << 20, ..Limits::DEFAULT };
        load(&builder, limits).map(|scene| scene.background.0)
    }

    #[test]
    fn a_file_s_light_is_its_sky() {
        let light =
            r#"{"intensity":3,"specularImageSize":4,"specularImages":[[0,1,2,3,4,5]],"irradianceCoefficients":[]}"#;
        let Ok(Background::Environment(sky)) = loaded([[4, 4]; 6], light) else { panic!("there is no sky") };
        // 1 over an alpha of 102/255, times 3.
        assert!(sky.radiance(Vec3::new(0.6, -0.8, 0.0)).abs_diff_eq(Vec3::new(7.5, 0.0, 0.0), 1e-4));
        assert_eq!((sky.image().width, sky.image().height), (16, 8));
    }

    #[test]
    fn what_is_no_light_is_refused_with_its_place() {
        let mut sizes = [[4, 4]; 6];
        sizes[3] = [4, 2];
        let whole = r#""specularImages":[[0,1,2,3,4,5]]"#;
        for (sizes, light, expected) in [
            (sizes, format!("{{{whole}}}"), "specularImages[0][3]"),
            ([[4, 4]; 6], r#"{"specularImages":[[0,1,2,3,4,6]]}"#.to_owned(), "images[6]"),
            ([[4, 4]; 6], r#"{"specularImages":[]}"#.to_owned(), "there are no pictures"),
            ([[4, 4]; 6], r#"{"specularImages":[[0,1,2]]}"#.to_owned(), "specularImages"),
            ([[4, 4]; 6], format!(r#"{{"intensity":-1,{whole}}}"#), "intensity"),
            ([[4, 4]; 6], format!(r#"{{"rotation":[0,0,0,0],{whole}}}"#), "rotation"),
            // The faces are admitted, the sky of 1600 x 800 pixels beside them is not.
            ([[400, 400]; 6], format!("{{{whole}}}"), "image_pixels"),
        ] {
            let Err(error) = loaded(sizes, &light) else { panic!("{light} is taken") };
            assert!(error.contains(expected), "{light}: {error}");
        }
    }

    /// Faces of one color each.
    fn faces(colors: [[u8; 4]; 6]) -> [Arc<Image>; 6] {
        colors.map(|color| Arc::new(Image { width: 2, height: 2, texels: Texels::Bytes(vec![color; 4]) }))
    }

    #[test]
    fn faces_are_where_the_extension_says() {
        let cube = faces([10, 20, 30, 40, 50, 60].map(|gray| [gray, 0, 255, 255]));
        let axes = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];
        for (face, axis) in axes.into_iter().enumerate() {
            let expected = cube[face].texel(0, Encoding::Srgb).truncate();
            assert!(look(&cube, axis).abs_diff_eq(expected, 1e-6), "{axis}");
        }
    }

    /// OpenGL's cube map lookup (its specification, table "selection of cube map images"): which face, and the coordinates s and t in
    /// it; the extension mirrors s.
    #[test]
    fn places_in_faces_are_opengls_mirrored() {
        // A face that is brighter to the right, and greener further down.
        let ramp: Vec<[u8; 4]> = (0..64 * 64).map(|i| [(i % 64 * 4) as u8, (i / 64 * 4) as u8, 0, 255]).collect();
        let cube: [Arc<Image>; 6] =
            std::array::from_fn(|_| Arc::new(Image { width: 64, height: 64, texels: Texels::Bytes(ramp.clone()) }));
        let opengl = |d: Vec3| {
            let [x, y, z] = d.to_array();
            let (s, t, m) = match d.abs() {
                a if a.x > a.y && a.x > a.z => (if x > 0.0 { -z } else { z }, -y, a.x),
                a if a.y > a.z => (x, if y > 0.0 { z } else { -z }, a.y),
                a => (if z > 0.0 { x } else { -x }, -y, a.z),
            };
            (0.5 * (s / m + 1.0), 0.5 * (t / m + 1.0))
        };
        for direction in [
            [1.0, 0.3, -0.6],
            [-1.0, 0.2, 0.5],
            [0.4, 1.0, -0.2],
            [0.3, -1.0, 0.7],
            [-0.5, 0.3, 1.0],
            [0.6, -0.2, -1.0],
        ] {
            let direction = Vec3::from_array(direction).normalize();
            let (s, t) = opengl(direction);
            let place = |at: f32| ((at * 64.0 - 0.5) as usize).min(63) * 4;
            let expected = [place(1.0 - s), place(t)].map(|byte| byte as u8);
            let bracket = |low: u8, channel: usize| {
                let at = |byte: u8| {
                    Image { width: 1, height: 1, texels: Texels::Bytes(vec![[byte, byte, 0, 255]]) }
                        .texel(0, Encoding::Srgb)[channel]
                };
                (at(low) - 1e-5)..=(at(low.saturating_add(4)) + 1e-5)
            };
            let found = look(&cube, direction);
            assert!(bracket(expected[0], 0).contains(&found.x), "{direction}: {found}, {expected:?}");
            assert!(bracket(expected[1], 1).contains(&found.y), "{direction}: {found}, {expected:?}");
        }
    }

    /// A quarter turn about +Y, counterclockwise from above, takes what is at +X to -Z.
    #[test]
    fn the_sky_is_turned_and_packed_colors_are_brighter_than_one() {
        let mut colors = [[0, 0, 0, 255]; 6];
        colors[0] = [255, 255, 255, 51];
        let turned = resampled(&faces(colors), Quat::from_rotation_y(std::f32::consts::FRAC_PI_2), 2.0);
        let map = EnvironmentMap::new(Arc::new(turned), MapRows::Centers, 0.0).expect("a sky");
        // 1 over an alpha of 51/255, twice.
        assert!(map.radiance(Vec3::NEG_Z).abs_diff_eq(Vec3::splat(10.0), 1e-4), "{}", map.radiance(Vec3::NEG_Z));
        assert_eq!(map.radiance(Vec3::X), Vec3::ZERO);
    }
}
