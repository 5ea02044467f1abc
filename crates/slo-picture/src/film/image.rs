//! A picture in memory.

/// A picture in linear radiance, or three other numbers for each pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Row-major, the top row first; unclamped.
    pub rgb: Vec<[f32; 3]>,
}
