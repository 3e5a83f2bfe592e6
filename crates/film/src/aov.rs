//! What the sums mean: color, alpha, depth, normals, ids and counts of every pixel, in rows from the top left corner; and, if
//! the film keeps what they come from, standard errors, albedo and light by the way it came.

use brewster_lanes::columns;

use crate::noise::standard_error;
use crate::{DEPTH_SCALE, Film, Light, LinearImage, Parts, Pixel, SCALE, Window};

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

columns! {
    /// What the light of one pixel is made of, and what it fell on.
    pub struct LightLayers => LightLayersColumns, LightLayersView, LightLayersViewMut {
        /// Mean over the samples of the part of the light that the first surface sends back or lets through; 0 where nothing
        /// was hit.
        pub albedo: [f32; 3],
        /// Mean radiance seen directly: the color less the other two.
        pub direct: [f32; 3],
        /// Mean radiance by way of rays that the first surface reflected.
        pub reflection: [f32; 3],
        /// Mean radiance by way of rays that the first surface transmitted.
        pub transmission: [f32; 3],
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
    /// The pixels' standard errors of the color by channel, infinite with less than two samples, if the film keeps squares.
    pub errors: Option<Vec<[f32; 3]>>,
    /// What their light is made of, if the film keeps parts. As integers the three parts are the color to the last digit;
    /// here each is rounded once.
    pub light: Option<LightLayersColumns>,
}

impl Film {
    /// Divides the sums: means are computed in f64 and rounded once to f32.
    pub fn resolve(&self) -> Layers {
        let order = self.order();
        let window = order.window();
        let places = (0..window.height).flat_map(|y| (0..window.width).map(move |x| (window.x + x, window.y + y)));
        let indices = places.map(|(x, y)| order.index(x, y).expect("the place is in the window") as usize);
        let pixels = self.pixels();
        let errors = self.squares().map(|squares| {
            let error = |pixel: Pixel, squares: [u128; 3]| {
                [0, 1, 2].map(|c| standard_error(pixel.color.0[c], squares[c], pixel.samples) as f32)
            };
            indices.clone().map(|index| error(pixels.get(index), squares.light[index])).collect()
        });
        let light = self
            .parts()
            .map(|parts| indices.clone().map(|index| LightLayers::new(pixels.get(index), parts.get(index))).collect());
        let pixels = indices.map(|index| LayersRow::from(pixels.get(index))).collect();
        Layers { width: order.width(), height: order.height(), window, pixels, errors, light }
    }
}

/// A mean of fixed-point numbers, rounded once.
fn mean(sum: i64, scale: f64, count: u32) -> f32 {
    (sum as f64 / (scale * f64::from(count.max(1)))) as f32
}

impl LightLayers {
    fn new(pixel: Pixel, parts: Parts) -> LightLayers {
        let mean = |Light(sum)| sum.map(|sum| mean(sum, SCALE, pixel.samples));
        let [color, reflection, transmission] =
            [pixel.color, parts.reflection, parts.transmission].map(|light| light.0);
        // Saturated parts may exceed a saturated color.
        let direct = [0, 1, 2].map(|c| color[c].saturating_sub(reflection[c]).saturating_sub(transmission[c]).max(0));
        LightLayers {
            albedo: mean(parts.albedo),
            direct: mean(Light(direct)),
            reflection: mean(parts.reflection),
            transmission: mean(parts.transmission),
        }
    }
}

impl From<Pixel> for LayersRow {
    fn from(pixel: Pixel) -> LayersRow {
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
    use crate::{FirstHit, Keep, NO_ID, Part, PixelOrder};

    #[test]
    fn means_are_of_samples_and_of_hits() {
        let window = Window { x: 1, y: 1, width: 2, height: 2 };
        let order = PixelOrder::new(4, 3, Some(window)).unwrap();
        let mut film = Film::keeping(order, Keep::ALL);
        let pixel = order.index(2, 1).unwrap();
        let mut tile = film.tile_mut();
        for sample in 0..4 {
            tile.add_sample(pixel, Light::new([1.0, 0.5, sample as f32]).unwrap());
        }
        let hit = FirstHit { depth: 3.0, normal: [0.0, 1.0, 0.0], albedo: [1.0, 0.5, 0.0], material: 5, entity: 6 };
        tile.add_first_hit(pixel, 0, hit);
        tile.add_first_hit(pixel, 2, FirstHit { depth: 4.0, normal: [1.0, 0.0, 0.0], ..hit });
        tile.add_rays(pixel, 11);
        tile.add_part(pixel, Part::Reflection, Light([2 << 32, 0, 0]));
        tile.add_part(pixel, Part::Transmission, Light([0, 0, 3 << 32]));

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
        let light = layers.light.as_ref().unwrap();
        let expected_light = LightLayers {
            albedo: [0.5, 0.25, 0.0],
            direct: [0.5, 0.5, 0.75],
            reflection: [0.5, 0.0, 0.0],
            transmission: [0.0, 0.0, 0.75],
        };
        let nothing = LightLayers { albedo: [0.0; 3], direct: [0.0; 3], reflection: [0.0; 3], transmission: [0.0; 3] };
        let rows: Vec<_> = (0..4).map(|index| light.get(index)).collect();
        assert_eq!(rows, [nothing, expected_light, nothing, nothing]);

        // Of 0, 1, 2 and 3: variance 5/3, of the mean 5/12. One pixel has no second sample.
        let errors = layers.errors.as_ref().unwrap();
        assert_eq!(errors[1], [0.0, 0.0, (5.0f64 / 12.0).sqrt() as f32]);
        assert_eq!(errors[0], [f32::INFINITY; 3]);

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
