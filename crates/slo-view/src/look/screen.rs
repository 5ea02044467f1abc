//! Radiance as bytes for a screen.

use std::sync::LazyLock;

use slo_picture::film::{Image, Toning, srgb};
use slo_scene::{Encoding, Look};

/// Steps of the table of the sRGB curve. The error is below a quarter of a byte.
const STEPS: usize = 1 << 14;

static SRGB: LazyLock<Vec<u8>> = LazyLock::new(|| {
    (0..=STEPS).map(|i| (srgb(i as f32 / STEPS as f32) * 255.0 + 0.5) as u8).collect()
});

/// Returns red, green and blue bytes, row by row: what viewers show of a PNG file with this look.
pub(crate) fn bytes(image: &Image, look: Look) -> Vec<u8> {
    let (toning, curve) = (Toning::of(look), &*SRGB);
    let byte = |value: f32| {
        let value = value.clamp(0.0, 1.0);
        match look.encoding {
            Encoding::Srgb => curve[(value * STEPS as f32 + 0.5) as usize],
            Encoding::Raw => (value * 255.0 + 0.5) as u8,
        }
    };
    image.rgb.iter().flat_map(|&rgb| toning.apply(rgb).map(byte)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_screen_shows_what_files_hold() {
        let rgb = (0..=1000).map(|i| [i as f32 / 900.0, i as f32 / 9e4, i as f32]).collect();
        let image = Image { width: 1001, height: 1, rgb };
        let look = Look { exposure: 0.5, encoding: Encoding::Srgb, ..Look::default() };
        let exact = image.srgb8(look);
        let off = |(a, b): (&u8, &u8)| a.abs_diff(*b);
        assert!(bytes(&image, look).iter().zip(&exact).map(off).max() <= Some(1));
        let raw = Look { exposure: 0.0, encoding: Encoding::Raw, ..Look::default() };
        let one = Image { width: 1, height: 1, rgb: vec![[0.5, f32::NAN, 7.0]] };
        assert_eq!(bytes(&one, raw), [128, 0, 255]);
    }
}
