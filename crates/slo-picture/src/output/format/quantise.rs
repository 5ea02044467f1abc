//! Radiance -> encoded values of a file.

use std::sync::LazyLock;

use slo_scene::Encoding;

use crate::film::srgb;

/// A channel as files hold it: finite numbers as they are, 0 for all others.
pub(super) fn finite(radiance: f32) -> f32 {
    if radiance.is_finite() { radiance } else { 0.0 }
}

/// For each value of 8 bits but 0, the least linear light that is rounded to it.
static LEAST_OF_8_BITS: LazyLock<Vec<f32>> = LazyLock::new(|| (1..=255).map(least_of).collect());

/// The least linear light that is rounded to `value` of 8 bits on the sRGB curve.
fn least_of(value: u16) -> f32 {
    // Floats that are not negative have the order of their bits.
    let (mut below, mut from) = (0, 1.0f32.to_bits());
    while below + 1 < from {
        let middle = below + (from - below) / 2;
        if rounded(f32::from_bits(middle), Encoding::Srgb, 255) < value {
            below = middle;
        } else {
            from = middle;
        }
    }
    f32::from_bits(from)
}

/// A channel as an integer from 0 to `max`, rounded to the nearest.
pub(super) fn quantised(radiance: f32, encoding: Encoding, max: u16) -> u16 {
    let clamped = finite(radiance).clamp(0.0, 1.0);
    if encoding == Encoding::Srgb && max == 255 {
        // The same result as below, without a power.
        return LEAST_OF_8_BITS.partition_point(|least| *least <= clamped) as u16;
    }
    rounded(clamped, encoding, max)
}

/// A channel from 0 to 1 as an integer from 0 to `max`, rounded to the nearest.
fn rounded(clamped: f32, encoding: Encoding, max: u16) -> u16 {
    let encoded = match encoding {
        Encoding::Raw => clamped,
        Encoding::Srgb => srgb(clamped),
    };
    (encoded * f32::from(max)).round() as u16
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(radiance: f32, raw: u16, srgb: u16) {
        assert_eq!(quantised(radiance, Encoding::Raw, 255), raw, "RAW of {radiance}");
        assert_eq!(quantised(radiance, Encoding::Srgb, 255), srgb, "SRGB of {radiance}");
    }

    #[test]
    fn known_values() {
        check(0.0, 0, 0);
        check(1.0, 255, 255);
        check(0.5, 128, 188); // 127.5 rounds up
        check(0.212, 54, 127); // the curve gives 0.4981: 127.0
        check(0.002, 1, 7); // on the straight part: 0.002 * 12.92 * 255 = 6.6
        check(-3.0, 0, 0);
        check(7.5, 255, 255);
    }

    #[test]
    fn what_is_no_number_is_black() {
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            check(bad, 0, 0);
        }
    }

    #[test]
    fn eight_bits_are_rounded_as_the_curve_says() {
        for i in 0..=200_000 {
            let x = i as f32 / 200_000.0;
            assert_eq!(quantised(x, Encoding::Srgb, 255), rounded(x, Encoding::Srgb, 255), "{x}");
        }
    }

    #[test]
    fn sixteen_bits_use_the_whole_range() {
        assert_eq!(quantised(1.0, Encoding::Raw, u16::MAX), 65535);
        assert_eq!(quantised(0.25, Encoding::Raw, u16::MAX), 16384);
        assert_eq!(quantised(0.5, Encoding::Srgb, u16::MAX), 48192); // 0.735357 * 65535
    }

    #[test]
    fn the_curve_is_monotonic_and_has_no_step() {
        let steps: Vec<u16> =
            (0..=100_000).map(|i| quantised(i as f32 / 1e5, Encoding::Srgb, u16::MAX)).collect();
        assert!(steps.windows(2).all(|w| w[0] <= w[1] && w[1] - w[0] <= 9));
    }
}
