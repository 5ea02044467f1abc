//! Images in memory.

/// An RGB image with the file's values as they are (no transfer curve is removed), kept at the
/// file's precision: 3 bytes a texel, or 6 if the file has 16 bits a channel.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    width: u32,
    height: u32,
    channels: Channels,
}

/// Red, green and blue in turn, row-major, the top row of the image first.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Channels {
    Bits8(Vec<u8>),
    Bits16(Vec<u16>),
}

impl Texture {
    /// An image of 8-bit channels: red, green, blue in turn, the top row first. `None` unless
    /// there are `3 * width * height` of them and the image has a texel.
    pub fn from_rgb8(width: u32, height: u32, channels: Vec<u8>) -> Option<Self> {
        fits(width, height, channels.len()).then_some(Self {
            width,
            height,
            channels: Channels::Bits8(channels),
        })
    }

    /// As [`from_rgb8`](Self::from_rgb8), of 16-bit channels.
    pub fn from_rgb16(width: u32, height: u32, channels: Vec<u16>) -> Option<Self> {
        fits(width, height, channels.len()).then_some(Self {
            width,
            height,
            channels: Channels::Bits16(channels),
        })
    }

    /// Pixels, 1 or more.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Pixels, 1 or more.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Red, green and blue in `[0, 1]` of the texel in column `x` from the left and row `y` from
    /// the top; columns and rows past the edge give the last one.
    #[inline(always)]
    pub fn texel(&self, x: u32, y: u32) -> [f32; 3] {
        let x = x.min(self.width - 1) as usize;
        let y = y.min(self.height - 1) as usize;
        let start = 3 * (y * self.width as usize + x);
        match &self.channels {
            Channels::Bits8(c) => color(&c[start..], 255.0),
            Channels::Bits16(c) => color(&c[start..], 65535.0),
        }
    }
}

/// The first three channels over the largest value of one.
#[inline(always)]
fn color<C: Copy + Into<f32>>(channels: &[C], most: f32) -> [f32; 3] {
    [channels[0].into() / most, channels[1].into() / most, channels[2].into() / most]
}

/// Whether so many channels make an image of that size.
fn fits(width: u32, height: u32, channels: usize) -> bool {
    let texels = u64::from(width) * u64::from(height);
    texels > 0 && u128::from(texels) * 3 == channels as u128
}
