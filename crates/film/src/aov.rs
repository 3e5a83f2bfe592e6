//! What the sums mean: color, alpha, depth, normals, ids and counts of every pixel, in rows from the top left corner.

use brewster_lanes::columns;

use crate::{DEPTH_SCALE, Film, LinearImage, Pixel, SCALE, Window};

columns! {
    /// The layers of one pixel.
    pub struct LayersRow => LayersColumns, LayersView, LayersViewMut {
        /// Mean radiance in linear Rec.709, in nit; black without samples.
        pub color: [f32; 3],
        /// The part of the samples whose camera ray hit something, 0 to 1.
        pub alpha: f32,
        /// Mean depth of the hits from the camera in meters; infinite without hits.
        pub depth: f32,
        /// Mean world-space normal of the hits, of length 1 or less; zero without hits.
        pub normal: [f32; 3],
        /// The material that sample 0 hit, or [`crate::NO_ID`].
        pub material: u32,
        /// The entity that sample 0 hit, or [`crate::NO_ID`].
        pub entity: u32,
        /// Rays traced, of every kind.
        pub rays: u32,
        /// Samples taken.
        pub samples: u32,
    }
}

/// A film's layers: the pixels of its crop window, row by row from the top left corner.
#[derive(Clone, Debug, PartialEq)]
pub struct Layers {
    /// The width of the whole picture in pixels.
    pub width: u32,
    /// The height of the whole picture in pixels.
    pub height: u32,
    /// The part of the picture that the pixels cover.
    pub window: Window,
    /// The pixels; `window.width` x `window.height` of them.
    pub pixels: LayersColumns,
}

impl Film {
    /// Divides the sums: means are computed in f64 and rounded once to f32.
    pub fn resolve(&self) -> Layers {
        let order = self.order();
        let window = order.window();
        let places = (0..window.height).flat_map(|y| (0..window.width).map(move |x| (window.x + x, window.y + y)));
        let mut pixels = LayersColumns::with_capacity(order.len());
        for (x, y) in places {
            let index = order.index(x, y).expect("the place is in the window");
            pixels.push(LayersRow::from(self.pixels().get(index as usize)));
        }
        Layers { width: order.width(), height: order.height(), window, pixels }
    }
}

impl From<Pixel> for LayersRow {
    fn from(pixel: Pixel) -> LayersRow {
        let mean = |sum: i64, scale: f64, count: u32| (sum as f64 / (scale * f64::from(count.max(1)))) as f32;
        LayersRow {
            color: pixel.color.0.map(|sum| mean(sum, SCALE, pixel.samples)),
            alpha: (f64::from(pixel.hits) / f64::from(pixel.samples.max(1))).min(1.0) as f32,
            depth: if pixel.hits == 0 { f32::INFINITY } else { mean(pixel.depth, DEPTH_SCALE, pixel.hits) },
            normal: pixel.normal.map(|sum| mean(sum, SCALE, pixel.hits)),
            material: pixel.material,
            entity: pixel.entity,
            rays: pixel.rays,
            samples: pixel.samples,
        }
    }
}

impl Layers {
    /// Color and alpha of the whole picture; black and transparent outside the window.
    pub fn image(&self) -> LinearImage {
        let mut image = LinearImage::black(self.width, self.height);
        let alpha = image.alpha.insert(vec![0.0; image.color.len()]);
        let pixels = self.pixels.view();
        for row in 0..self.window.height as usize {
            let (width, picture_width) = (self.window.width as usize, self.width as usize);
            let from = row * width..(row + 1) * width;
            let start = (self.window.y as usize + row) * picture_width + self.window.x as usize;
            image.color[start..start + width].copy_from_slice(&pixels.color[from.clone()]);
            alpha[start..start + width].copy_from_slice(&pixels.alpha[from]);
        }
        image
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{FirstHit, Light, NO_ID, PixelOrder};

    #[test]
    fn means_are_of_samples_and_of_hits() {
        let window = Window { x: 1, y: 1, width: 2, height: 2 };
        let order = PixelOrder::new(4, 3, Some(window)).unwrap();
        let mut film = Film::new(order);
        let pixel = order.index(2, 1).unwrap();
        let mut tile = film.tile_mut();
        for sample in 0..4 {
            tile.add_sample(pixel, Light::new([1.0, 0.5, sample as f32]).unwrap());
        }
        let hit = FirstHit { depth: 3.0, normal: [0.0, 1.0, 0.0], material: 5, entity: 6 };
        tile.add_first_hit(pixel, 0, hit);
        tile.add_first_hit(pixel, 2, FirstHit { depth: 4.0, normal: [1.0, 0.0, 0.0], ..hit });
        tile.add_rays(pixel, 11);

        let layers = film.resolve();
        let empty = LayersRow {
            color: [0.0; 3],
            alpha: 0.0,
            depth: f32::INFINITY,
            normal: [0.0; 3],
            material: NO_ID,
            entity: NO_ID,
            rays: 0,
            samples: 0,
        };
        let expected = LayersRow {
            color: [1.0, 0.5, 1.5],
            alpha: 0.5,
            depth: 3.5,
            normal: [0.5, 0.5, 0.0],
            material: 5,
            entity: 6,
            rays: 11,
            samples: 4,
        };
        let rows: Vec<_> = (0..4).map(|index| layers.pixels.get(index)).collect();
        assert_eq!(rows, [empty, expected, empty, empty]);

        let image = layers.image();
        assert_eq!((image.width, image.height), (4, 3));
        for (index, (color, alpha)) in image.color.iter().zip(image.alpha.unwrap()).enumerate() {
            let expected = if index == 6 { ([1.0, 0.5, 1.5], 0.5) } else { ([0.0; 3], 0.0) };
            assert_eq!((*color, alpha), expected, "pixel {index}");
        }
    }
}
