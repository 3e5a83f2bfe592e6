//! Which pixel comes when: the film stores pixels in the order in which camera rays visit them.

use std::ops::Range;

use crate::FilmError;

/// A rectangle of pixels; `x` grows to the right and `y` downwards from the picture's top left corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// The leftmost column.
    pub x: u32,
    /// The topmost row.
    pub y: u32,
    /// Columns; at least 1.
    pub width: u32,
    /// Rows; at least 1.
    pub height: u32,
}

/// The side of the square tiles that pixels are visited in.
pub const TILE: u32 = 8;

/// The longest side of a picture, in pixels.
pub const MAX_SIDE: u32 = 1 << 16;

/// The most pixels that a film holds; they take 10 GiB.
pub const MAX_PIXELS: u64 = 1 << 27;

/// The traversal order: numbers the pixels of a crop window without gaps.
///
/// The window is cut, from its top left corner, into tiles of 8 x 8 pixels. Tiles follow each other row by row; within a
/// tile pixels follow the Morton (Z) curve, so that 4, 16 and 64 pixels from a multiple of that number on are a square.
/// Tiles that the right or lower border cuts are visited row by row. Neighbors in the order are neighbors in the
/// picture: their camera rays are coherent, and any run of them is one contiguous slice of the film.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PixelOrder {
    width: u32,
    height: u32,
    window: Window,
}

impl PixelOrder {
    /// The order of a picture of `width` x `height` pixels, of which those inside `crop` are rendered (`None`: all).
    ///
    /// # Errors
    ///
    /// A side that is zero or above [`MAX_SIDE`], more than [`MAX_PIXELS`] pixels in the picture, a crop window that is
    /// empty or leaves the picture.
    pub fn new(width: u32, height: u32, crop: Option<Window>) -> Result<PixelOrder, FilmError> {
        check_size(width, height)?;
        let window = crop.unwrap_or(Window { x: 0, y: 0, width, height });
        let inside = |start: u32, length: u32, end: u32| length > 0 && start < end && length <= end - start;
        if !inside(window.x, window.width, width) || !inside(window.y, window.height, height) {
            return Err(FilmError::Crop { window, width, height });
        }
        Ok(PixelOrder { width, height, window })
    }

    /// The picture's width in pixels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// The picture's height in pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// The part of the picture that is rendered.
    pub fn window(&self) -> Window {
        self.window
    }

    /// The number of pixels in the window.
    #[expect(clippy::len_without_is_empty, reason = "a window is never empty")]
    pub fn len(&self) -> usize {
        self.window.width as usize * self.window.height as usize
    }

    /// The place (x, y) in the picture of the pixel with that index; an index beyond [`PixelOrder::len`] panics or gives
    /// a place outside the window.
    #[inline]
    pub fn pixel(&self, index: u32) -> (u32, u32) {
        let Window { width, height, .. } = self.window;
        let row = index / (TILE * width);
        let rows = TILE.min(height - row * TILE);
        let in_row = index - row * TILE * width;
        let column = in_row / (TILE * rows);
        let columns = TILE.min(width - column * TILE);
        let in_tile = in_row - column * TILE * rows;
        let (x, y) = if columns * rows == TILE * TILE {
            (even_bits(in_tile), even_bits(in_tile >> 1))
        } else {
            (in_tile % columns, in_tile / columns)
        };
        (self.window.x + column * TILE + x, self.window.y + row * TILE + y)
    }

    /// The tiles of [`TILE`] x [`TILE`] pixels, and those that a border cuts, in order: each a run of indices.
    pub fn tiles(&self) -> impl Iterator<Item = Range<u32>> + use<> {
        let Window { width, height, .. } = self.window;
        let sides = |length: u32| (0..length).step_by(TILE as usize).map(move |start| TILE.min(length - start));
        let mut end = 0;
        sides(height).flat_map(move |rows| sides(width).map(move |columns| rows * columns)).map(move |pixels| {
            end += pixels;
            end - pixels..end
        })
    }

    /// The index of the pixel at (x, y) of the picture; `None` outside the window.
    #[inline]
    pub fn index(&self, x: u32, y: u32) -> Option<u32> {
        let Window { width, height, .. } = self.window;
        let (x, y) = (x.checked_sub(self.window.x)?, y.checked_sub(self.window.y)?);
        if x >= width || y >= height {
            return None;
        }
        let (column, row) = (x / TILE, y / TILE);
        let (columns, rows) = (TILE.min(width - column * TILE), TILE.min(height - row * TILE));
        let in_tile = if columns * rows == TILE * TILE {
            spread_bits(x % TILE) | spread_bits(y % TILE) << 1
        } else {
            (y % TILE) * columns + x % TILE
        };
        Some(row * TILE * width + column * TILE * rows + in_tile)
    }
}

/// Checks the size of a picture before memory is taken for it.
pub(crate) fn check_size(width: u32, height: u32) -> Result<(), FilmError> {
    let in_range = |side: u32| (1..=MAX_SIDE).contains(&side);
    if !in_range(width) || !in_range(height) || u64::from(width) * u64::from(height) > MAX_PIXELS {
        return Err(FilmError::Size { width, height });
    }
    Ok(())
}

/// Bits 0, 2 and 4 as bits 0, 1 and 2.
fn even_bits(bits: u32) -> u32 {
    bits & 1 | bits >> 1 & 2 | bits >> 2 & 4
}

/// Bits 0, 1 and 2 as bits 0, 2 and 4.
fn spread_bits(bits: u32) -> u32 {
    bits & 1 | (bits & 2) << 1 | (bits & 4) << 2
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pixel_of_the_window_has_one_index() {
        let windows = [(0, 0, 1, 1), (0, 0, 8, 8), (0, 0, 40, 30), (3, 5, 17, 9), (39, 29, 1, 1), (7, 0, 5, 30)];
        for (x, y, width, height) in windows {
            let window = Window { x, y, width, height };
            let order = PixelOrder::new(40, 30, Some(window)).unwrap();
            let mut places: Vec<_> = (0..order.len() as u32).map(|index| order.pixel(index)).collect();
            for (index, &(x, y)) in places.iter().enumerate() {
                assert_eq!(order.index(x, y), Some(index as u32), "{window:?} at {x}, {y}");
            }
            places.sort_by_key(|&(x, y)| (y, x));
            let expected: Vec<_> = (y..y + height).flat_map(|y| (x..x + width).map(move |x| (x, y))).collect();
            assert_eq!(places, expected, "{window:?}");
        }
    }

    #[test]
    fn squares_follow_each_other() {
        let order = PixelOrder::new(20, 20, None).unwrap();
        let first: Vec<_> = (0..6).map(|index| order.pixel(index)).collect();
        assert_eq!(first, [(0, 0), (1, 0), (0, 1), (1, 1), (2, 0), (3, 0)]);
        assert_eq!(
            [order.pixel(63), order.pixel(64), order.pixel(128), order.pixel(160)],
            [(7, 7), (8, 0), (16, 0), (0, 8)]
        );
    }

    #[test]
    fn tiles_are_the_squares_that_the_window_is_cut_into() {
        for (width, height) in [(40, 30), (8, 8), (3, 17), (1, 1)] {
            let order = PixelOrder::new(width, height, None).unwrap();
            let mut end = 0;
            for tile in order.tiles() {
                assert_eq!(tile.start, end);
                let square = |index: u32| (order.pixel(index).0 / TILE, order.pixel(index).1 / TILE);
                assert!(tile.clone().all(|index| square(index) == square(tile.start)), "{tile:?}");
                end = tile.end;
            }
            assert_eq!(end as usize, order.len());
            assert_eq!(order.tiles().count() as u32, width.div_ceil(TILE) * height.div_ceil(TILE));
        }
    }

    #[test]
    fn places_outside_the_window_have_no_index() {
        let order = PixelOrder::new(40, 30, Some(Window { x: 3, y: 5, width: 17, height: 9 })).unwrap();
        for (x, y) in [(2, 5), (3, 4), (20, 5), (3, 14), (u32::MAX, u32::MAX)] {
            assert_eq!(order.index(x, y), None, "{x}, {y}");
        }
    }

    #[test]
    fn bad_sizes_and_windows_are_errors() {
        for (width, height) in [(0, 1), (1, 0), (MAX_SIDE + 1, 1), (MAX_SIDE, MAX_SIDE), (u32::MAX, u32::MAX)] {
            assert!(matches!(PixelOrder::new(width, height, None), Err(FilmError::Size { .. })), "{width}x{height}");
        }
        for (x, y, width, height) in [(0, 0, 0, 1), (0, 0, 5, 1), (4, 0, 1, 1), (1, 2, 1, 2), (2, 0, u32::MAX, 1)] {
            let window = Window { x, y, width, height };
            assert!(matches!(PixelOrder::new(4, 3, Some(window)), Err(FilmError::Crop { .. })), "{window:?}");
        }
    }
}
