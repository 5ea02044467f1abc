//! FLIP: the difference that a viewer sees when two pictures alternate.
//!
//! Source: Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström, Fairchild: FLIP: A Difference
//! Evaluator for Alternating Images, 2020; equations and constants of the version for low dynamic
//! range.

use rayon::prelude::*;

use crate::film::{Image, linear};

/// Pixels per degree of sight: a screen of 0.7 m and 3840 pixels at 0.7 m.
const PIXELS_PER_DEGREE: f32 = 67.020_645;
/// Exponent of colour differences, and of feature differences.
const COLOR_EXPONENT: f32 = 0.7;
const FEATURE_EXPONENT: f32 = 0.5;
/// Where large colour differences begin to be compressed, and to what.
const COMPRESSED_FROM: f32 = 0.4;
const COMPRESSED_TO: f32 = 0.95;
/// Width of the feature detectors in degrees.
const FEATURE_WIDTH: f32 = 0.082;

/// A difference depends on pixels within this distance, see [`seen_radius`] and [`feature_radius`].
pub(super) const REACH: u32 = 10;

/// Three values of each pixel.
type Plane = Vec<[f32; 3]>;

/// The difference of each pixel, 0 to 1, row by row. Both pictures hold sRGB values from 0 to 1 and
/// have the same size.
pub fn flip(reference: &Image, picture: &Image) -> Vec<f32> {
    let (a, b) = (opponent(reference), opponent(picture));
    let size = Size { width: reference.width as usize, height: reference.height as usize };
    let (seen_a, seen_b) = (seen(&a, size), seen(&b, size));
    let (features_a, features_b) = (features(&a, size), features(&b, size));
    let pixel = |i: usize| {
        let color = color_difference(seen_a[i], seen_b[i]);
        let feature = feature_difference(features_a[i], features_b[i]);
        libm::powf(color, 1.0 - feature)
    };
    (0..a.len()).into_par_iter().map(pixel).collect()
}

/// sRGB -> YCxCz.
fn opponent(image: &Image) -> Plane {
    image.rgb.par_iter().map(|rgb| ycxcz_of_xyz(xyz_of_rgb(rgb.map(linear)))).collect()
}

fn xyz_of_rgb([r, g, b]: [f32; 3]) -> [f32; 3] {
    [
        0.412_386_56 * r + 0.357_591_5 * g + 0.180_450_49 * b,
        0.212_636_82 * r + 0.715_183 * g + 0.072_180_2 * b,
        0.019_330_622 * r + 0.119_197_17 * g + 0.950_372_6 * b,
    ]
}

fn rgb_of_xyz([x, y, z]: [f32; 3]) -> [f32; 3] {
    [
        3.241_003_3 * x - 1.537_399 * y - 0.498_615_9 * z,
        -0.969_224_3 * x + 1.875_93 * y + 0.041_554_226 * z,
        0.055_639_42 * x - 0.204_011_21 * y + 1.057_149 * z,
    ]
}

/// XYZ of white.
fn white() -> [f32; 3] {
    xyz_of_rgb([1.0; 3])
}

fn ycxcz_of_xyz(xyz: [f32; 3]) -> [f32; 3] {
    let white = white();
    let [x, y, z] = [xyz[0] / white[0], xyz[1] / white[1], xyz[2] / white[2]];
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

fn xyz_of_ycxcz([luma, cx, cz]: [f32; 3]) -> [f32; 3] {
    let white = white();
    let y = (luma + 16.0) / 116.0;
    [(y + cx / 500.0) * white[0], y * white[1], (y - cz / 200.0) * white[2]]
}

/// CIELAB, its colours weakened where it is dark (Hunt).
fn hunt_lab(xyz: [f32; 3]) -> [f32; 3] {
    const DELTA: f32 = 6.0 / 29.0;
    let white = white();
    let f = |t: f32| {
        if t > DELTA * DELTA * DELTA {
            libm::cbrtf(t)
        } else {
            t / (3.0 * DELTA * DELTA) + 4.0 / 29.0
        }
    };
    let [x, y, z] = [f(xyz[0] / white[0]), f(xyz[1] / white[1]), f(xyz[2] / white[2])];
    let lightness = 116.0 * y - 16.0;
    [lightness, 0.01 * lightness * 500.0 * (x - y), 0.01 * lightness * 200.0 * (y - z)]
}

/// Radius of the widest contrast sensitivity.
fn seen_radius() -> i32 {
    let pi = std::f32::consts::PI;
    (3.0 * (0.04 / (2.0 * pi * pi)).sqrt() * PIXELS_PER_DEGREE).ceil() as i32
}

/// A picture as the eye sees it: each channel blurred by its contrast sensitivity.
fn seen(opponent: &Plane, size: Size) -> Plane {
    // Weights and widths of up to two Gaussians per channel.
    const SENSITIVITY: [[[f32; 2]; 2]; 3] =
        [[[1.0, 0.0047], [0.0, 1e-5]], [[1.0, 0.0053], [0.0, 1e-5]], [[34.1, 0.04], [13.5, 0.025]]];
    let pi = std::f32::consts::PI;
    let radius = seen_radius();
    let mut blurred = vec![[0.0; 3]; opponent.len()];
    for (channel, gaussians) in SENSITIVITY.iter().enumerate() {
        let plane: Vec<f32> = opponent.iter().map(|pixel| pixel[channel]).collect();
        let parts = gaussians.map(|[a, b]| {
            let one = |i: i32| {
                let degrees = i as f32 / PIXELS_PER_DEGREE;
                libm::expf(-pi * pi * degrees * degrees / b)
            };
            let kernel: Vec<f32> = (-radius..=radius).map(one).collect();
            let sum: f32 = kernel.iter().sum();
            (kernel, a * (pi / b).sqrt(), sum * sum)
        });
        let total: f32 = parts.iter().map(|(_, weight, sum)| weight * sum).sum();
        for (kernel, weight, _) in parts.iter().filter(|part| part.1 > 0.0) {
            let result = filter(&plane, size, kernel, kernel);
            for (to, value) in blurred.iter_mut().zip(result) {
                to[channel] += value * weight / total;
            }
        }
    }
    let lab = |&pixel: &[f32; 3]| {
        let rgb = rgb_of_xyz(xyz_of_ycxcz(pixel)).map(|value| value.clamp(0.0, 1.0));
        hunt_lab(xyz_of_rgb(rgb))
    };
    blurred.par_iter().map(lab).collect()
}

/// HyAB distance, large ones compressed to 1.
fn color_difference(a: [f32; 3], b: [f32; 3]) -> f32 {
    let largest =
        hyab(hunt_lab(xyz_of_rgb([0.0, 1.0, 0.0])), hunt_lab(xyz_of_rgb([0.0, 0.0, 1.0])));
    let largest = libm::powf(largest, COLOR_EXPONENT);
    let difference = libm::powf(hyab(a, b), COLOR_EXPONENT);
    let border = COMPRESSED_FROM * largest;
    if difference < border {
        COMPRESSED_TO / border * difference
    } else {
        let rest = (difference - border) / (largest - border);
        (COMPRESSED_TO + rest * (1.0 - COMPRESSED_TO)).min(1.0)
    }
}

fn hyab(a: [f32; 3], b: [f32; 3]) -> f32 {
    let [l, x, y] = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    l.abs() + (x * x + y * y).sqrt()
}

fn feature_deviation() -> f32 {
    0.5 * FEATURE_WIDTH * PIXELS_PER_DEGREE
}

/// Radius of the feature detectors.
fn feature_radius() -> i32 {
    (3.0 * feature_deviation()).ceil() as i32
}

/// Strength of edges and of points in each pixel.
fn features(opponent: &Plane, size: Size) -> Vec<[f32; 2]> {
    let luma: Vec<f32> = opponent.iter().map(|pixel| (pixel[0] + 16.0) / 116.0).collect();
    let deviation = feature_deviation();
    let radius = feature_radius();
    let squared = |i: i32| (i * i) as f32 / (deviation * deviation);
    let gauss = |i: i32| libm::expf(-0.5 * squared(i));
    let smooth = balanced((-radius..=radius).map(gauss).collect());
    let edge = balanced((-radius..=radius).map(|i| -(i as f32) * gauss(i)).collect());
    let point = balanced((-radius..=radius).map(|i| (squared(i) - 1.0) * gauss(i)).collect());
    let strength = |kernel: &[f32]| -> Vec<f32> {
        let across = filter(&luma, size, kernel, &smooth);
        let down = filter(&luma, size, &smooth, kernel);
        across.iter().zip(down).map(|(x, y)| (x * x + y * y).sqrt()).collect()
    };
    let (edges, points) = (strength(&edge), strength(&point));
    edges.into_iter().zip(points).map(|(edge, point)| [edge, point]).collect()
}

/// A kernel whose positive weights add up to 1, and its negative ones to -1.
fn balanced(kernel: Vec<f32>) -> Vec<f32> {
    let positive: f32 = kernel.iter().filter(|&&k| k > 0.0).sum();
    let negative: f32 = -kernel.iter().filter(|&&k| k < 0.0).sum::<f32>();
    let scale = |k: f32| if k > 0.0 { k / positive } else { k / negative.max(f32::MIN_POSITIVE) };
    kernel.into_iter().map(scale).collect()
}

fn feature_difference(a: [f32; 2], b: [f32; 2]) -> f32 {
    let difference = (a[0] - b[0]).abs().max((a[1] - b[1]).abs());
    libm::powf(std::f32::consts::FRAC_1_SQRT_2 * difference, FEATURE_EXPONENT).min(1.0)
}

#[derive(Clone, Copy)]
struct Size {
    width: usize,
    height: usize,
}

/// Filters rows with one kernel and columns with another; border pixels are repeated outside.
fn filter(plane: &[f32], size: Size, across: &[f32], down: &[f32]) -> Vec<f32> {
    let Size { width, height } = size;
    let pick = |kernel: &[f32], at: usize, last: usize, value: &dyn Fn(usize) -> f32| -> f32 {
        let radius = kernel.len() / 2;
        let place = |i: usize| (at + i).saturating_sub(radius).min(last);
        kernel.iter().enumerate().map(|(i, weight)| weight * value(place(i))).sum()
    };
    let row = |(y, row): (usize, &mut [f32])| {
        let values = &plane[y * width..(y + 1) * width];
        for (x, out) in row.iter_mut().enumerate() {
            *out = pick(across, x, width - 1, &|i| values[i]);
        }
    };
    let mut rows = vec![0.0; plane.len()];
    rows.par_chunks_mut(width.max(1)).enumerate().for_each(row);
    let column = |(y, row): (usize, &mut [f32])| {
        for (x, out) in row.iter_mut().enumerate() {
            *out = pick(down, y, height - 1, &|i| rows[i * width + x]);
        }
    };
    let mut result = vec![0.0; plane.len()];
    result.par_chunks_mut(width.max(1)).enumerate().for_each(column);
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flat(rgb: [f32; 3]) -> Image {
        Image { width: 24, height: 16, rgb: vec![rgb; 24 * 16] }
    }

    fn mean(map: &[f32]) -> f32 {
        map.iter().sum::<f32>() / map.len() as f32
    }

    #[test]
    fn nothing_reaches_further_than_what_is_looked_at() {
        assert_eq!(seen_radius().max(feature_radius()), REACH as i32);
    }

    #[test]
    fn black_and_white_are_as_far_apart_as_can_be() {
        let far = flip(&flat([0.0; 3]), &flat([1.0; 3]));
        assert!((mean(&far) - 0.966_9).abs() < 2e-3, "{}", mean(&far));
        let colors = flip(&flat([0.0, 1.0, 0.0]), &flat([0.0, 0.0, 1.0]));
        assert!((mean(&colors) - 1.0).abs() < 1e-3, "{}", mean(&colors));
    }

    #[test]
    fn the_same_is_no_difference_and_more_is_more() {
        let gray = flat([0.5; 3]);
        assert!(flip(&gray, &gray).iter().all(|&value| value == 0.0));
        let differences = [0.51, 0.55, 0.7].map(|v| mean(&flip(&gray, &flat([v; 3]))));
        assert!(differences.windows(2).all(|w| w[0] < w[1]), "{differences:?}");
    }

    #[test]
    fn an_edge_that_moves_is_seen_more_than_its_contrast_alone() {
        let edge = |at: u32| {
            let rgb = (0..24 * 16).map(|i| [if i % 24 < at { 0.4 } else { 0.6 }; 3]).collect();
            Image { width: 24, height: 16, rgb }
        };
        let moved = flip(&edge(12), &edge(13));
        let row = &moved[24 * 8..24 * 9];
        assert!(row[12] > 0.1 && row[0] < 0.02, "{row:?}");
    }
}
