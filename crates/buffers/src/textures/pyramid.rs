//! Pictures for looking from afar: means of ever more pixels.

use glam::{DVec4, Vec4};
use rayon::prelude::*;

use super::image::{Encoding, Image, Texels};

/// The levels of a picture below itself, each half as wide and high as the one before, down to one pixel; linear, in 8 bytes a pixel
/// (12 where the picture has floats), so a third of that for each pixel of the picture. A level's mean is the picture's.
#[derive(Clone, Debug, PartialEq)]
pub struct Pyramid {
    levels: Vec<Image>,
}

impl Pyramid {
    /// The levels of a sound picture whose bytes stand for colors or data.
    pub fn new(image: &Image, encoding: Encoding) -> Pyramid {
        let mut levels = Vec::new();
        let mut size = [image.width, image.height];
        let mut above: Vec<Vec4> = Vec::new();
        while size != [1, 1] {
            let half = size.map(|side| (side / 2).max(1));
            let level = match levels.is_empty() {
                true => shrunk(size, half, |index| image.texel(index, encoding)),
                false => shrunk(size, half, |index| above[index]),
            };
            levels.push(Image { width: half[0], height: half[1], texels: stored(&level, &image.texels) });
            (size, above) = (half, level);
        }
        Pyramid { levels }
    }

    /// Levels from half the picture's size on.
    pub fn levels(&self) -> &[Image] {
        &self.levels
    }
}

/// Each pixel the mean of those that it covers.
fn shrunk(from: [u32; 2], to: [u32; 2], texel: impl Fn(usize) -> Vec4 + Sync) -> Vec<Vec4> {
    if from == to.map(|side| 2 * side) { quartered(from[0] as usize, to, texel) } else { weighed(from, to, texel) }
}

/// The mean of pixels that are covered, by how much of them.
fn weighed(from: [u32; 2], to: [u32; 2], texel: impl Fn(usize) -> Vec4 + Sync) -> Vec<Vec4> {
    let spans = |axis: usize| -> Vec<Vec<(usize, f64)>> {
        let (many, few) = (f64::from(from[axis]), f64::from(to[axis]));
        let span = |at: u32| {
            let (start, end) = (f64::from(at) * many / few, f64::from(at + 1) * many / few);
            let covered = |index: usize| (end.min(index as f64 + 1.0) - start.max(index as f64)) / (end - start);
            (start as usize..(end.ceil() as usize).min(from[axis] as usize)).map(|i| (i, covered(i))).collect()
        };
        (0..to[axis]).map(span).collect()
    };
    let (columns, rows) = (spans(0), spans(1));
    let width = from[0] as usize;
    let mean = |row: &[(usize, f64)], column: &[(usize, f64)]| {
        let mut sum = DVec4::ZERO;
        for &(y, of_row) in row {
            for &(x, of_column) in column {
                sum += texel(y * width + x).as_dvec4() * (of_row * of_column);
            }
        }
        sum.as_vec4()
    };
    let mut means = vec![Vec4::ZERO; columns.len() * rows.len()];
    means.par_chunks_exact_mut(columns.len()).zip(&rows).for_each(|(means, row)| {
        means.iter_mut().zip(&columns).for_each(|(to, column)| *to = mean(row, column));
    });
    means
}

/// The same where each pixel covers two by two whole ones.
fn quartered(width: usize, to: [u32; 2], texel: impl Fn(usize) -> Vec4 + Sync) -> Vec<Vec4> {
    let mut means = vec![Vec4::ZERO; to[0] as usize * to[1] as usize];
    means.par_chunks_exact_mut(to[0] as usize).enumerate().for_each(|(y, means)| {
        for (x, mean) in means.iter_mut().enumerate() {
            let first = 2 * (y * width + x);
            let mut sum = DVec4::ZERO;
            for index in [first, first + 1, first + width, first + width + 1] {
                sum += texel(index).as_dvec4() * 0.25;
            }
            *mean = sum.as_vec4();
        }
    });
    means
}

/// Pixels in a precision that does not fall behind the picture's.
fn stored(level: &[Vec4], like: &Texels) -> Texels {
    match like {
        Texels::Floats(_) => Texels::Floats(level.iter().map(|pixel| pixel.truncate().to_array()).collect()),
        _ => {
            let word = |value: f32| (value.clamp(0.0, 1.0) * 65535.0 + 0.5) as u16;
            Texels::Words(level.iter().map(|pixel| pixel.to_array().map(word)).collect())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_by_two_pixels_are_weighed_alike() {
        let texel = |index: usize| Vec4::splat((index * 7919 % 1000) as f32).map(|x| (x + 0.1).recip());
        assert_eq!(quartered(12, [6, 5], texel), weighed([12, 10], [6, 5], texel));
    }

    /// Pictures of even and odd sides: every level has their mean, and the last is one pixel.
    #[test]
    fn levels_keep_the_mean() {
        for (width, height) in [(8, 8), (7, 3), (1, 5), (6, 1), (13, 9)] {
            let texels = (0..width * height).map(|i| [(i * 37 % 256) as u8, (i * 11 % 256) as u8, 9, 200]).collect();
            let image = Image { width, height, texels: Texels::Bytes(texels) };
            let pyramid = Pyramid::new(&image, Encoding::Srgb);
            let mean = |image: &Image, encoding| {
                let sum = (0..image.texels.len()).map(|index| image.texel(index, encoding).as_dvec4()).sum::<DVec4>();
                sum / image.texels.len() as f64
            };
            let expected = mean(&image, Encoding::Srgb);
            for level in pyramid.levels() {
                // A word is rounded by half of 1/65535.
                let found = mean(level, Encoding::Linear);
                assert!((found - expected).abs().max_element() < 2e-5, "{width}x{height}: {found} {expected}");
            }
            let last = pyramid.levels().last().expect("there is one");
            assert_eq!((last.width, last.height), (1, 1));
        }
        let one = Image { width: 1, height: 1, texels: Texels::Floats(vec![[1.0; 3]]) };
        assert!(Pyramid::new(&one, Encoding::Linear).levels().is_empty());
    }
}
