//! Exact sums of samples per pixel, and how they become pixel values.
//!
//! A contribution is rounded once to a fixed-point number and added as an integer. Integer sums do
//! not depend on their order: threads, tiles and batches may add as they come, the bits are the
//! same.

mod fixed;

pub use fixed::Fixed;

/// What a pixel knows: the sum of its samples, and how many there are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Pixel {
    /// Red, green, blue.
    pub sum: [Fixed; 3],
    /// Camera samples in the sum.
    pub samples: u32,
}

impl Pixel {
    /// Mean radiance; black where nothing was sampled.
    pub fn mean(&self) -> [f32; 3] {
        let samples = f64::from(self.samples.max(1));
        self.sum.map(|s| (s.to_f64() / samples) as f32)
    }
}

/// The pixels of a picture, row by row, the top row first.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Film {
    width: u32,
    height: u32,
    pixels: Vec<Pixel>,
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

/// There is not enough memory for a picture of this size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooLarge {
    /// Bytes that it needs.
    pub bytes: u64,
}

/// A rectangle of pixels, `x0..x1` times `y0..y1`; y grows downward.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Area {
    /// First column.
    pub x0: u32,
    /// First row.
    pub y0: u32,
    /// One past the last column.
    pub x1: u32,
    /// One past the last row.
    pub y1: u32,
}

impl Area {
    /// Columns.
    pub fn width(&self) -> u32 {
        self.x1 - self.x0
    }

    /// Rows.
    pub fn height(&self) -> u32 {
        self.y1 - self.y0
    }

    /// Pixels.
    pub fn len(&self) -> usize {
        self.width() as usize * self.height() as usize
    }

    /// Whether there is no pixel in it.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

impl Film {
    /// An unexposed film.
    ///
    /// # Errors
    /// [`TooLarge`] where memory does not suffice.
    pub fn new(width: u32, height: u32) -> Result<Self, TooLarge> {
        let len = u64::from(width) * u64::from(height);
        let bytes = len.saturating_mul(size_of::<Pixel>() as u64);
        let mut pixels = Vec::new();
        let len = usize::try_from(len).map_err(|_| TooLarge { bytes })?;
        pixels.try_reserve_exact(len).map_err(|_| TooLarge { bytes })?;
        pixels.resize(len, Pixel::default());
        Ok(Self { width, height, pixels })
    }

    /// Pixels in a row.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Rows of pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// All pixels, row by row.
    pub fn pixels(&self) -> &[Pixel] {
        &self.pixels
    }

    /// Puts the pixels of one area, row by row, in their places.
    pub fn put(&mut self, area: Area, pixels: &[Pixel]) {
        let width = area.width() as usize;
        for (y, row) in (area.y0..area.y1).zip(pixels.chunks_exact(width.max(1))) {
            let start = y as usize * self.width as usize + area.x0 as usize;
            self.pixels[start..start + width].copy_from_slice(row);
        }
    }

    /// The mean of each pixel's samples.
    pub fn image(&self) -> Image {
        Image {
            width: self.width,
            height: self.height,
            rgb: self.pixels.iter().map(Pixel::mean).collect(),
        }
    }

    /// Camera samples of each pixel, row by row: where adaptive sampling went.
    pub fn sample_counts(&self) -> Vec<u32> {
        self.pixels.iter().map(|p| p.samples).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn areas_land_in_their_places() {
        let mut film = Film::new(4, 3).unwrap();
        let area = Area { x0: 1, y0: 1, x1: 3, y1: 3 };
        let pixels: Vec<_> =
            (1..5).map(|i| Pixel { sum: [Fixed::default(); 3], samples: i }).collect();
        film.put(area, &pixels);
        assert_eq!(film.sample_counts(), [0, 0, 0, 0, 0, 1, 2, 0, 0, 3, 4, 0]);
    }

    #[test]
    fn a_film_that_memory_can_not_hold_is_refused() {
        // 65536 x 65536 pixels fit no address space limit of a test, so ask for more.
        assert!(Film::new(u32::MAX, u32::MAX).is_err());
    }

    #[test]
    fn the_mean_divides_at_the_end() {
        let third = Fixed::new(1.0 / 3.0).unwrap();
        let pixel = Pixel { sum: [third + third + third; 3], samples: 3 };
        assert!((pixel.mean()[0] - 1.0 / 3.0).abs() < 1e-7);
    }
}
