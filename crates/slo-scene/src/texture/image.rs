//! Images as scenes use them.

use std::sync::Arc;

use super::texels::{Layout, Samples, Texels};
use crate::settings::{Curve, Filter, Wrap};

/// An image with the file's values as they are, kept at the file's precision, and how it is looked
/// up.
///
/// All values are finite and not negative; those of PNG and JPEG files go from 0 to 1. A copy
/// shares the texels.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    width: u32,
    height: u32,
    texels: Arc<Texels>,
    alpha: Alpha,
    wrap: Wrap,
    filter: Filter,
    encoding: Option<Curve>,
}

/// What is known of an image's alpha.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Alpha {
    /// The file has none.
    None,
    /// The file has it, but no pixel is transparent.
    Opaque,
    /// Colours are not multiplied by it.
    Straight,
    /// Colours are multiplied by it.
    Premultiplied,
}

impl Texture {
    /// An image of 8-bit channels: red, green, blue in turn, the top row first. `None` unless
    /// there are `3 * width * height` of them and the image has a texel.
    pub fn from_rgb8(width: u32, height: u32, channels: Vec<u8>) -> Option<Self> {
        Self::new(width, height, Layout::Rgb, Samples::Bits8(channels), Alpha::None)
    }

    /// As [`from_rgb8`](Self::from_rgb8), of 16-bit channels.
    pub fn from_rgb16(width: u32, height: u32, channels: Vec<u16>) -> Option<Self> {
        Self::new(width, height, Layout::Rgb, Samples::Bits16(channels), Alpha::None)
    }

    /// As [`from_rgb8`](Self::from_rgb8), with alpha, which colours are not multiplied by: red,
    /// green, blue, alpha in turn.
    pub fn from_rgba8(width: u32, height: u32, channels: Vec<u8>) -> Option<Self> {
        Self::new(width, height, Layout::Rgba, Samples::Bits8(channels), Alpha::Straight)
    }

    /// As [`from_rgb8`](Self::from_rgb8), of floats; also `None` if one of them is negative or not
    /// finite.
    pub fn from_rgb_f32(width: u32, height: u32, channels: Vec<f32>) -> Option<Self> {
        Self::new(width, height, Layout::Rgb, floats(channels)?, Alpha::None)
    }

    /// As [`from_rgb_f32`](Self::from_rgb_f32), with alpha, which colours are multiplied by, as in
    /// EXR files; also `None` if alpha exceeds 1.
    pub fn from_rgba_f32(width: u32, height: u32, channels: Vec<f32>) -> Option<Self> {
        if channels.iter().skip(3).step_by(4).any(|alpha| *alpha > 1.0) {
            return None;
        }
        Self::new(width, height, Layout::Rgba, floats(channels)?, Alpha::Premultiplied)
    }

    /// An image that repeats and is interpolated.
    pub(super) fn new(
        width: u32,
        height: u32,
        layout: Layout,
        samples: Samples,
        alpha: Alpha,
    ) -> Option<Self> {
        let texels = Arc::new(Texels::new(width, height, layout, samples)?);
        let (wrap, filter) = (Wrap::Repeat, Filter::Linear);
        Some(Self { width, height, texels, alpha, wrap, filter, encoding: None })
    }

    /// The same image, continued in another way outside of the unit square.
    #[must_use]
    pub fn with_wrap(self, wrap: Wrap) -> Self {
        Self { wrap, ..self }
    }

    /// The same image, with another way from texels to values between them.
    #[must_use]
    pub fn with_filter(self, filter: Filter) -> Self {
        Self { filter, ..self }
    }

    /// The same image, with a curve for all its uses; with `None` each use has its own.
    #[must_use]
    pub fn with_encoding(self, encoding: Option<Curve>) -> Self {
        Self { encoding, ..self }
    }

    /// Pixels, 1 or more.
    #[inline]
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Pixels, 1 or more.
    #[inline]
    pub fn height(&self) -> u32 {
        self.height
    }

    /// How the image continues outside of the unit square.
    #[inline]
    pub fn wrap(&self) -> Wrap {
        self.wrap
    }

    /// How values between texels come about.
    #[inline]
    pub fn filter(&self) -> Filter {
        self.filter
    }

    /// The curve of all uses, if the scene names one.
    #[inline]
    pub fn encoding(&self) -> Option<Curve> {
        self.encoding
    }

    /// The curve of a use as colour: the one that the scene names; otherwise sRGB for files of 8 or
    /// 16 bits, and none for floats.
    pub fn color_curve(&self) -> Curve {
        let by_file = if self.texels.is_float() { Curve::Raw } else { Curve::Srgb };
        self.encoding.unwrap_or(by_file)
    }

    /// The curve of a use as numbers or normals, and of Phong materials: the one that the scene
    /// names, otherwise none.
    #[inline]
    pub fn data_curve(&self) -> Curve {
        self.encoding.unwrap_or(Curve::Raw)
    }

    /// Whether the file has alpha, even if no pixel is transparent.
    pub fn has_alpha(&self) -> bool {
        self.alpha != Alpha::None
    }

    /// Whether a pixel may be transparent: uses that do not show alpha should say so.
    pub fn is_transparent(&self) -> bool {
        matches!(self.alpha, Alpha::Straight | Alpha::Premultiplied)
    }

    /// Whether colours are multiplied by alpha, as in EXR files.
    #[inline]
    pub fn is_premultiplied(&self) -> bool {
        self.alpha == Alpha::Premultiplied
    }

    /// Whether values may exceed 1.
    pub fn is_float(&self) -> bool {
        self.texels.is_float()
    }

    /// Whether red, green and blue are the same value, which the file has only once.
    pub fn is_grey(&self) -> bool {
        matches!(self.texels.layout(), Layout::Grey | Layout::GreyAlpha)
    }

    /// Bytes that the texels take in memory.
    pub fn bytes(&self) -> usize {
        self.texels.bytes()
    }

    /// Red, green and blue of the texel in column `x` from the left and row `y` from the top, as
    /// the file has them; columns and rows past the edge give the last one.
    #[inline(always)]
    pub fn texel(&self, x: u32, y: u32) -> [f32; 3] {
        self.texels.color(self.index(x, y))
    }

    /// As [`texel`](Self::texel), with alpha in `[0, 1]`: 1 if the image has none.
    #[inline(always)]
    pub fn texel_rgba(&self, x: u32, y: u32) -> [f32; 4] {
        self.decoded_rgba(x, y, Curve::Raw)
    }

    /// As [`texel`](Self::texel), with the curve removed.
    #[inline(always)]
    pub fn decoded(&self, x: u32, y: u32, curve: Curve) -> [f32; 3] {
        self.texels.decoded(self.index(x, y), curve)
    }

    /// As [`decoded`](Self::decoded), of the texels in several places.
    #[inline(always)]
    pub fn decoded_each<const N: usize>(
        &self,
        places: [(u32, u32); N],
        curve: Curve,
    ) -> [[f32; 3]; N] {
        self.texels.decoded_each(places.map(|(x, y)| self.index(x, y)), curve)
    }

    /// As [`texel_rgba`](Self::texel_rgba), with the curve removed from the colour.
    #[inline(always)]
    pub fn decoded_rgba(&self, x: u32, y: u32, curve: Curve) -> [f32; 4] {
        let index = self.index(x, y);
        let [r, g, b] = self.texels.decoded(index, curve);
        [r, g, b, self.texels.alpha(index)]
    }

    /// The number of a texel.
    #[inline(always)]
    fn index(&self, x: u32, y: u32) -> usize {
        let x = x.min(self.width - 1) as usize;
        let y = y.min(self.height - 1) as usize;
        y * self.width as usize + x
    }
}

/// The values, unless one of them is negative or not finite.
fn floats(values: Vec<f32>) -> Option<Samples> {
    let is_usable = values.iter().all(|value| value.is_finite() && *value >= 0.0);
    is_usable.then_some(Samples::Float(values))
}
