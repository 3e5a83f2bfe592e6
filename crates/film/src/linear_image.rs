//! A picture in linear light: what is tone-mapped, written, read back and compared.

/// Linear Rec.709 colors, row by row from the top left corner.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearImage {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Colors, `width` x `height` of them; multiplied by alpha where there is one.
    pub color: Vec<[f32; 3]>,
    /// Coverage, 0 to 1, as many as colors; `None`: opaque.
    pub alpha: Option<Vec<f32>>,
}

impl LinearImage {
    /// A black, opaque picture.
    pub fn black(width: u32, height: u32) -> LinearImage {
        LinearImage { width, height, color: vec![[0.0; 3]; width as usize * height as usize], alpha: None }
    }
}
