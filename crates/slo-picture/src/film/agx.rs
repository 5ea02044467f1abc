//! AgX: radiance of any size -> light of a screen, without hard edges where a channel reaches white.
//!
//! Source: Troy Sobotka's AgX as Eary Chow develops it for Blender (the base look for sRGB, made by
//! <https://github.com/EaryChow/AgX_LUT_Gen>, with the parameters that Blender 5.0's table
//! `AgX_Base_sRGB.cube` names in its header). Blender interpolates that table of 57^3 entries; here the
//! formulas behind it are computed. Over colours that Blender 5.0.1 saved with its view transform *AgX*
//! (-7 to +6 stops around middle grey, saturations up to 0.8), encoded values differ by 0.09 of 255 on
//! average, by less than 0.7 for 99 of 100 colours, and by 2 at most. If a channel is almost 0, Blender's
//! table is too coarse for it, and its dark channel is off by up to 22 of 255.

use slo_accel::math::elementary::{log2, power};

/// Rec. 709 -> Rec. 2020 with its primaries turned and moved toward white: where each channel gets its
/// curve.
const INSET: [[f32; 3]; 3] = [
    [0.544_814_7, 0.373_787_4, 0.081_397_86],
    [0.140_416_94, 0.754_137_6, 0.105_445_47],
    [0.088_810_42, 0.178_871_78, 0.732_317_8],
];

/// The way back, which gives colours less saturation than they lost. The curves took the rest.
const OUTSET: [[f32; 3]; 3] = [
    [1.964_894, -0.856_007_9, -0.108_886_12],
    [-0.299_309_1, 1.326_391_9, -0.027_082_81],
    [-0.164_356_44, -0.238_207_4, 1.402_563_8],
];

/// Luminance of Rec. 709 by the CIE's functions of 2015.
const LUMINANCE: [f32; 3] = [0.210_351_14, 0.649_797_8, 0.139_851_1];

/// Middle grey, and the range of the curve around it in stops.
const GREY: f32 = 0.18;
const LOWEST: f32 = -10.0;
const HIGHEST: f32 = 6.5;

/// The curve passes through middle grey with this slope, in the range of the curve and in encoded values.
const SLOPE: f32 = 2.4;
/// Middle grey on the curve: `-LOWEST / (HIGHEST - LOWEST)`, and `GREY^(1 / GAMMA)`.
const PIVOT: [f32; 2] = [0.606_060_6, 0.489_437_1];
/// How far the curve would go, if it did not bend, from the pivot to its ends; below and above.
const SCALES: [f32; 2] = [0.565_675_6, 0.715_198_3];
/// Exponent of the values on the curve.
const GAMMA: f32 = 2.4;
/// Share of the hues that channels have before their curves; the rest are hues as curves bend them.
const HUE_BEFORE: f32 = 0.6;

/// Light of a screen, 0 to 1, for radiance.
#[inline(always)]
pub(super) fn agx(radiance: [f32; 3]) -> [f32; 3] {
    let before = times(&INSET, radiance.map(|c| c.max(0.0)));
    let after = before.map(|c| power(curve(c), GAMMA));
    let light = times(&OUTSET, with_hue(before, after));
    without_negatives(light).map(|c| c.clamp(0.0, 1.0))
}

#[inline(always)]
fn times(matrix: &[[f32; 3]; 3], [r, g, b]: [f32; 3]) -> [f32; 3] {
    [0, 1, 2].map(|i| matrix[i][0] * r + matrix[i][1] * g + matrix[i][2] * b)
}

#[inline(always)]
fn largest([r, g, b]: [f32; 3]) -> f32 {
    r.max(g).max(b)
}

#[inline(always)]
fn smallest([r, g, b]: [f32; 3]) -> f32 {
    r.min(g).min(b)
}

/// A sigmoid over stops: a line through middle grey that bends toward 0 and 1 on both sides.
#[inline(always)]
fn curve(light: f32) -> f32 {
    let stops = log2(light.max(f32::MIN_POSITIVE) / GREY);
    let x = ((stops - LOWEST) / (HIGHEST - LOWEST)).max(0.0);
    let way = SLOPE * (x - PIVOT[0]);
    let scale = if way < 0.0 { SCALES[0] } else { SCALES[1] };
    let t = way.abs() / scale;
    // x / (1 + x^1.5)^(1 / 1.5)
    let bent = t / power(1.0 + t * t.sqrt(), 1.0 / 1.5);
    PIVOT[1] + if way < 0.0 { -scale } else { scale } * bent
}

/// Light behind the curves with a hue between its own and the hue before them. Curves keep the order of
/// channels, so only the middle one changes.
#[inline(always)]
fn with_hue(before: [f32; 3], after: [f32; 3]) -> [f32; 3] {
    let (low, high) = (smallest(before), largest(before));
    let (dark, bright) = (smallest(after), largest(after));
    let stretch = (bright - dark) / (high - low).max(f32::MIN_POSITIVE);
    [0, 1, 2].map(|c| {
        let kept = (before[c] - low) * stretch;
        dark + HUE_BEFORE * kept + (1.0 - HUE_BEFORE) * (after[c] - dark)
    })
}

/// Colours outside of Rec. 709 moved toward white until they are inside, and darkened so that they do not
/// look brighter.
#[inline(always)]
fn without_negatives(light: [f32; 3]) -> [f32; 3] {
    let offset = (-smallest(light)).max(0.0);
    let moved = light.map(|c| c + offset);
    let (wanted, found) = (brightness(light), brightness(moved));
    let ratio = if found > wanted { wanted.max(0.0) / found.max(f32::MIN_POSITIVE) } else { 1.0 };
    moved.map(|c| c * ratio)
}

/// How bright a colour looks: dark, saturated colours look brighter than their luminance.
#[inline(always)]
fn brightness(light: [f32; 3]) -> f32 {
    let [r, g, b] = LUMINANCE;
    let luminance = r * light[0] + g * light[1] + b * light[2];
    let plain = power(luminance.max(0.0), 0.08).min(1.0);
    luminance + (1.0 - plain) * (luminance - smallest(light))
}

#[cfg(test)]
mod tests {
    use super::super::display::srgb;
    use super::*;

    /// Colours, and the values of 255 that Blender 5.0.1 saves for them with the view transform *AgX*.
    const BLENDER: [([f32; 3], [f32; 3]); 10] = [
        ([0.18; 3], [117.64; 3]),
        ([1.0; 3], [196.6; 3]),
        ([0.01; 3], [18.49; 3]),
        ([0.8, 0.4, 0.1], [194.14, 154.56, 106.4]),
        ([0.02, 0.03, 0.05], [31.28, 43.53, 57.44]),
        ([4.0, 4.0, 3.0], [233.07, 232.49, 227.32]),
        ([8.0, 0.5, 0.2], [254.89, 195.11, 184.15]),
        ([0.05, 0.3, 0.9], [94.82, 149.51, 199.4]),
        ([20.0, 18.0, 12.0], [255.0, 254.97, 251.53]),
        ([0.3, 0.9, 0.2], [154.51, 191.32, 136.97]),
    ];

    #[test]
    fn colours_are_those_of_blender() {
        for (radiance, expected) in BLENDER {
            let found = agx(radiance).map(|c| srgb(c) * 255.0);
            for (found, expected) in found.into_iter().zip(expected) {
                assert!((found - expected).abs() < 2.1, "{radiance:?}: {found} {expected}");
            }
        }
    }

    #[test]
    fn greys_stay_grey_and_in_order() {
        let mut before = -1.0;
        for i in -120..=100 {
            let grey = GREY * libm::exp2f(i as f32 / 10.0);
            let [r, g, b] = agx([grey; 3]);
            assert!((r - g).abs() < 1e-5 && (g - b).abs() < 1e-5, "{grey}: {r} {g} {b}");
            assert!(r >= before && r <= 1.0, "{grey}: {r} after {before}");
            before = r;
        }
        assert_eq!(agx([0.0; 3]), [0.0; 3]);
        assert_eq!(agx([1e30; 3]), [1.0; 3]);
    }

    #[test]
    fn any_colour_lands_on_the_screen() {
        for i in 0..4096u32 {
            let channel = |shift: u32| libm::exp2f(((i >> shift) & 15) as f32 * 3.0 - 20.0) - 1e-6;
            let light = agx([channel(0), channel(4), channel(8)]);
            assert!(light.iter().all(|c| (0.0..=1.0).contains(c)), "{i}: {light:?}");
        }
    }
}
