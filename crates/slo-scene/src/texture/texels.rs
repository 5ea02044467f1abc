//! Texels in memory, at the precision of their file.

use super::srgb;
use crate::settings::Curve;

/// The values of an image, row-major, the top row first. All are finite and not negative.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Texels {
    layout: Layout,
    samples: Samples,
}

/// Channels of a texel, in this order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Layout {
    Grey,
    GreyAlpha,
    Rgb,
    Rgba,
}

/// The values of all texels.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Samples {
    Bits8(Vec<u8>),
    Bits16(Vec<u16>),
    /// Bits of IEEE half floats.
    Half(Vec<u16>),
    Float(Vec<f32>),
    /// Three channels with one exponent. Counts as three samples a texel.
    Rgbe(Vec<[u8; 4]>),
}

impl Layout {
    /// Values of a texel.
    #[inline(always)]
    pub(super) fn channels(self) -> usize {
        match self {
            Self::Grey => 1,
            Self::GreyAlpha => 2,
            Self::Rgb => 3,
            Self::Rgba => 4,
        }
    }

    /// Whether the last channel is alpha.
    #[inline(always)]
    pub(super) fn has_alpha(self) -> bool {
        matches!(self, Self::GreyAlpha | Self::Rgba)
    }

    /// Distance from red to green, and from green to blue.
    #[inline(always)]
    fn color_step(self) -> usize {
        usize::from(matches!(self, Self::Rgb | Self::Rgba))
    }
}

impl Texels {
    /// `None` unless there are as many samples as so many texels need, and at least one texel.
    pub(super) fn new(width: u32, height: u32, layout: Layout, samples: Samples) -> Option<Self> {
        let (per_texel, len) = match &samples {
            Samples::Bits8(samples) => (layout.channels(), samples.len()),
            Samples::Bits16(samples) | Samples::Half(samples) => (layout.channels(), samples.len()),
            Samples::Float(samples) => (layout.channels(), samples.len()),
            Samples::Rgbe(samples) => (1, samples.len()),
        };
        let texels = u128::from(width) * u128::from(height);
        let fits = texels > 0 && texels * per_texel as u128 == len as u128;
        fits.then_some(Self { layout, samples })
    }

    pub(super) fn layout(&self) -> Layout {
        self.layout
    }

    /// Whether values may exceed 1.
    pub(super) fn is_float(&self) -> bool {
        match self.samples {
            Samples::Bits8(_) | Samples::Bits16(_) => false,
            Samples::Half(_) | Samples::Float(_) | Samples::Rgbe(_) => true,
        }
    }

    /// Bytes of all texels.
    pub(super) fn bytes(&self) -> usize {
        match &self.samples {
            Samples::Bits8(samples) => samples.len(),
            Samples::Bits16(samples) | Samples::Half(samples) => 2 * samples.len(),
            Samples::Float(samples) => 4 * samples.len(),
            Samples::Rgbe(samples) => 4 * samples.len(),
        }
    }

    /// Red, green and blue of a texel by its number.
    #[inline(always)]
    pub(super) fn color(&self, index: usize) -> [f32; 3] {
        let start = self.layout.channels() * index;
        let step = self.layout.color_step();
        let at = [start, start + step, start + 2 * step];
        match &self.samples {
            Samples::Bits8(samples) => at.map(|i| f32::from(samples[i]) / 255.0),
            Samples::Bits16(samples) => at.map(|i| f32::from(samples[i]) / 65535.0),
            Samples::Half(samples) => at.map(|i| half(samples[i])),
            Samples::Float(samples) => at.map(|i| samples[i]),
            Samples::Rgbe(samples) => rgbe(samples[index]),
        }
    }

    /// As [`color`](Self::color), without the curve.
    #[inline(always)]
    pub(super) fn decoded(&self, index: usize, curve: Curve) -> [f32; 3] {
        match curve {
            Curve::Raw => self.color(index),
            Curve::Srgb => self.linear(index),
        }
    }

    /// As [`decoded`](Self::decoded), of several texels.
    #[inline(always)]
    pub(super) fn decoded_each<const N: usize>(
        &self,
        indices: [usize; N],
        curve: Curve,
    ) -> [[f32; 3]; N] {
        // Images of skies, mostly: one decision for all.
        match (&self.samples, curve) {
            (Samples::Float(samples), Curve::Raw) => self.each(
                indices,
                #[inline(always)]
                |i| samples[i],
            ),
            (Samples::Half(samples), Curve::Raw) => self.each(
                indices,
                #[inline(always)]
                |i| half(samples[i]),
            ),
            _ => indices.map(|index| self.decoded(index, curve)),
        }
    }

    /// Red, green and blue of several texels, from the samples of their numbers.
    #[inline(always)]
    fn each<const N: usize>(
        &self,
        indices: [usize; N],
        sample: impl Fn(usize) -> f32,
    ) -> [[f32; 3]; N] {
        let (count, step) = (self.layout.channels(), self.layout.color_step());
        let mut colors = [[0.0; 3]; N];
        // Loops, since closures in `map` would not be inlined.
        for (color, index) in colors.iter_mut().zip(indices) {
            for (to, channel) in color.iter_mut().zip([0, step, 2 * step]) {
                *to = sample(count * index + channel);
            }
        }
        colors
    }

    /// As [`color`](Self::color), of sRGB values.
    #[inline]
    fn linear(&self, index: usize) -> [f32; 3] {
        let start = self.layout.channels() * index;
        let step = self.layout.color_step();
        let at = [start, start + step, start + 2 * step];
        match &self.samples {
            Samples::Bits8(samples) => at.map(|i| srgb::linear8(samples[i])),
            Samples::Bits16(samples) => at.map(|i| srgb::linear16(samples[i])),
            Samples::Half(_) | Samples::Float(_) | Samples::Rgbe(_) => {
                self.color(index).map(srgb::linear)
            }
        }
    }

    /// Alpha of a texel by its number; 1 if the image has none.
    #[inline(always)]
    pub(super) fn alpha(&self, index: usize) -> f32 {
        if !self.layout.has_alpha() {
            return 1.0;
        }
        let at = self.layout.channels() * (index + 1) - 1;
        match &self.samples {
            Samples::Bits8(samples) => f32::from(samples[at]) / 255.0,
            Samples::Bits16(samples) => f32::from(samples[at]) / 65535.0,
            Samples::Half(samples) => half(samples[at]),
            Samples::Float(samples) => samples[at],
            Samples::Rgbe(_) => 1.0,
        }
    }
}

/// A finite half float from its bits, exactly.
#[inline(always)]
pub(super) fn half(bits: u16) -> f32 {
    // Exponent and mantissa stand in the same order in both formats; the biases differ by 112.
    const BIAS: f32 = f32::from_bits((127 + 112) << 23);
    let magnitude = f32::from_bits(u32::from(bits & 0x7fff) << 13) * BIAS;
    if bits & 0x8000 == 0 { magnitude } else { -magnitude }
}

/// The colour of a pixel of a Radiance picture.
#[inline(always)]
pub(super) fn rgbe([r, g, b, exponent]: [u8; 4]) -> [f32; 3] {
    // 2^(exponent - 136); smaller ones than a normal number count as 0.
    let scale = f32::from_bits(u32::from(exponent.saturating_sub(9)) << 23);
    [r, g, b].map(|channel| f32::from(channel) * scale)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_floats_are_exact() {
        for (bits, value) in [
            (0x0000, 0.0),
            (0x0001, 1.0 / 16_777_216.0),
            (0x03ff, 1023.0 / 16_777_216.0),
            (0x0400, 1.0 / 16384.0),
            (0x3555, 0.333_251_95),
            (0x3c00, 1.0),
            (0xc000, -2.0),
            (0x7bff, 65504.0),
        ] {
            assert_eq!(half(bits), value, "{bits:x}");
        }
        for bits in 0..0x7c00 {
            let expected = exr::prelude::f16::from_bits(bits).to_f32();
            assert_eq!(half(bits).to_bits(), expected.to_bits(), "{bits:x}");
        }
    }

    #[test]
    fn radiance_pixels() {
        assert_eq!(rgbe([128, 64, 255, 129]), [1.0, 0.5, 255.0 / 128.0]);
        assert_eq!(rgbe([1, 2, 3, 136]), [1.0, 2.0, 3.0]);
        assert_eq!(rgbe([255, 255, 255, 0]), [0.0; 3]);
        assert!(rgbe([255; 4])[0].is_finite());
    }

    #[test]
    fn every_layout_gives_colour_and_alpha() {
        let of = |layout, samples: &[u8]| {
            let texels = Texels::new(2, 1, layout, Samples::Bits8(samples.to_vec())).unwrap();
            let [r, g, b] = texels.color(1);
            [r, g, b, texels.alpha(1)].map(|value| (value * 255.0) as u8)
        };
        assert_eq!(of(Layout::Grey, &[1, 2]), [2, 2, 2, 255]);
        assert_eq!(of(Layout::GreyAlpha, &[1, 2, 3, 4]), [3, 3, 3, 4]);
        assert_eq!(of(Layout::Rgb, &[1, 2, 3, 4, 5, 6]), [4, 5, 6, 255]);
        assert_eq!(of(Layout::Rgba, &[1, 2, 3, 4, 5, 6, 7, 8]), [5, 6, 7, 8]);
        assert!(Texels::new(2, 1, Layout::Rgb, Samples::Bits8(vec![0; 5])).is_none());
        assert!(Texels::new(0, 1, Layout::Rgb, Samples::Bits8(Vec::new())).is_none());
        assert!(Texels::new(2, 1, Layout::Rgb, Samples::Rgbe(vec![[0; 4]; 2])).is_some());
    }

    #[test]
    fn the_curve_never_applies_to_alpha() {
        let samples = Samples::Bits16(vec![0x8000; 4]);
        let texels = Texels::new(1, 1, Layout::Rgba, samples).unwrap();
        let half = 32768.0 / 65535.0;
        assert_eq!(texels.decoded(0, Curve::Raw), [half; 3]);
        assert_eq!(texels.decoded(0, Curve::Srgb), [srgb::linear16(0x8000); 3]);
        assert_eq!(texels.alpha(0), half);
    }
}
