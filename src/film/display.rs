//! How radiance is seen: the transfer curve of the picture, and errors as the viewer sees them.

use std::sync::LazyLock;

use super::Pixel;
use crate::math::elementary::power;

/// Pieces that the curve is made of where errors are estimated.
const PIECES: usize = 4096;

/// The sRGB curve at the ends of the pieces.
static CURVE: LazyLock<Vec<f32>> =
    LazyLock::new(|| (0..=PIECES).map(|i| srgb(i as f32 / PIECES as f32)).collect());

/// The same beyond 1, where each doubling has as many pieces.
static GLARE: LazyLock<Vec<f32>> =
    LazyLock::new(|| (0..=Glare::PIECES).map(|i| srgb(Glare::begin(i as u32))).collect());

/// What a channel's radiance becomes on the screen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Display {
    /// Linear from 0 to 1, clamped.
    Raw,
    /// sRGB from 0 to 1, clamped.
    Srgb,
    /// The sRGB curve, which goes on beyond 1: for pictures whose exposure is chosen later.
    Unclamped,
}

impl Display {
    /// The value that is shown for a channel of linear radiance, within 2e-5 (of it, beyond 1): what
    /// an error needs.
    fn value(self, radiance: f32) -> f32 {
        match self {
            Self::Raw => radiance.clamp(0.0, 1.0),
            Self::Unclamped if radiance > 1.0 => Glare::value(radiance),
            Self::Srgb | Self::Unclamped => {
                let at = radiance.clamp(0.0, 1.0) * PIECES as f32;
                let piece = (at as usize).min(PIECES - 1);
                let (low, high) = (CURVE[piece], CURVE[piece + 1]);
                low + (high - low) * (at - piece as f32)
            }
        }
    }

    /// Mean square over the channels of a pixel's estimated error as it is shown; infinite for less
    /// than two samples. What is clamped counts for nothing.
    pub fn squared_error(self, pixel: &Pixel) -> f64 {
        let Some(error) = pixel.error() else { return f64::INFINITY };
        let mean = pixel.mean();
        let of = |c: usize| {
            let (low, high) = (self.value(mean[c] - error[c]), self.value(mean[c] + error[c]));
            let half = f64::from(high - low) / 2.0;
            half * half
        };
        (of(0) + of(1) + of(2)) / 3.0
    }
}

/// The curve from 1 to 65 536: the upper bits of a number tell its piece, the others where in it.
struct Glare;

impl Glare {
    const ONE: u32 = 1.0f32.to_bits();
    const DOUBLINGS: usize = 16;
    const PIECE_BITS: u32 = 16;
    const PIECES: usize = Self::DOUBLINGS << (23 - Self::PIECE_BITS);

    fn begin(piece: u32) -> f32 {
        f32::from_bits(Self::ONE + (piece << Self::PIECE_BITS))
    }

    fn value(radiance: f32) -> f32 {
        let above = radiance.to_bits() - Self::ONE;
        let piece = (above >> Self::PIECE_BITS) as usize;
        match GLARE.get(piece..piece + 2) {
            Some(&[low, high]) => {
                let rest = (above & ((1 << Self::PIECE_BITS) - 1)) as f32;
                low + (high - low) * (rest / (1 << Self::PIECE_BITS) as f32)
            }
            _ => srgb(radiance),
        }
    }
}

/// Linear light -> sRGB; `[0, 1]` to `[0, 1]`, and the same curve beyond.
///
/// Source: IEC 61966-2-1:1999, 5.3.
pub fn srgb(linear: f32) -> f32 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * power(linear, 1.0 / 2.4) - 0.055 }
}

/// Luminance of linear light with the primaries of sRGB.
///
/// Source: ITU-R BT.709-6, 3.
pub fn luminance([r, g, b]: [f32; 3]) -> f64 {
    0.2126 * f64::from(r) + 0.7152 * f64::from(g) + 0.0722 * f64::from(b)
}

/// sRGB -> linear light; the inverse of [`srgb`].
pub fn linear(srgb: f32) -> f32 {
    if srgb <= 0.040_45 { srgb / 12.92 } else { libm::powf((srgb + 0.055) / 1.055, 2.4) }
}

#[cfg(test)]
mod tests {
    use super::super::Fixed;
    use super::*;

    fn pixel(first: f32, second: f32) -> Pixel {
        let mut pixel = Pixel::default();
        for value in [first, second] {
            pixel.add([Fixed::new(value).unwrap(); 3], 1);
        }
        pixel
    }

    #[test]
    fn the_curve_in_pieces_is_the_curve() {
        for i in 0..=100_000 {
            let x = i as f32 / 50_000.0;
            let (shown, expected) = (Display::Unclamped.value(x), srgb(x));
            assert!((shown - expected).abs() < 2e-5, "{x}: {shown} {expected}");
        }
        for i in 0..100_000 {
            let x = 1.0 + 1e-4 * (i as f32) * (i as f32);
            let (shown, expected) = (Display::Unclamped.value(x), srgb(x));
            assert!((shown - expected).abs() < 2e-5 * expected, "{x}: {shown} {expected}");
        }
        assert_eq!(Display::Unclamped.value(1e9), srgb(1e9));
    }

    #[test]
    fn errors_count_as_they_are_seen() {
        let error = |display: Display, first, second| {
            display.squared_error(&pixel(first, second)).sqrt() as f32
        };
        // The mean is 0.5, its error 0.25.
        assert!((error(Display::Raw, 0.25, 0.75) - 0.25).abs() < 1e-6);
        assert_eq!(error(Display::Raw, 3.0, 5.0), 0.0, "both are white");
        assert_eq!(error(Display::Srgb, 3.0, 5.0), 0.0);
        assert!(error(Display::Unclamped, 3.0, 5.0) > 0.1);
        assert!(error(Display::Srgb, 0.01, 0.03) > 2.0 * error(Display::Srgb, 0.51, 0.53));
        assert_eq!(error(Display::Srgb, 0.5, 0.5), 0.0);
        assert_eq!(Display::Raw.squared_error(&Pixel::default()), f64::INFINITY);
    }
}
