//! A picture in memory.

use slo_scene::Look;

use super::display::srgb;
use super::toning::Toning;

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

impl Image {
    /// A smaller copy of `width` columns and `height` rows: each of its pixels is the mean of the
    /// pixels that it covers.
    #[must_use]
    pub fn shrunk(&self, [width, height]: [usize; 2]) -> Self {
        let (from_width, from_height) = (self.width as usize, self.height as usize);
        let range = |i: usize, to: usize, from: usize| i * from / to..((i + 1) * from / to).max(1);
        let pixel = |i: usize| {
            let (columns, rows) =
                (range(i % width, width, from_width), range(i / width, height, from_height));
            let count = (columns.len() * rows.len()).max(1) as f32;
            let mut sum = [0.0; 3];
            for y in rows {
                for rgb in &self.rgb[y * from_width + columns.start..y * from_width + columns.end] {
                    (0..3).for_each(|c| sum[c] += rgb[c]);
                }
            }
            sum.map(|channel| channel / count)
        };
        let rgb = (0..width * height).map(pixel).collect();
        Self { width: width as u32, height: height as u32, rgb }
    }

    /// The pixels with the exposure and the tone map of a look, clamped and encoded as sRGB: red, green
    /// and blue bytes, row by row from the top.
    pub fn srgb8(&self, look: Look) -> Vec<u8> {
        let toning = Toning::of(look);
        let byte = |value: f32| (srgb(value.clamp(0.0, 1.0)) * 255.0 + 0.5) as u8;
        self.rgb.iter().flat_map(|&rgb| toning.apply(rgb).map(byte)).collect()
    }
}
