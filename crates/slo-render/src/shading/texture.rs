//! Texture lookup.

use slo_scene::Texture;

/// Returns the image's colour at `(u, v)`, interpolated bilinearly between four texels.
///
/// The image fills the unit square and repeats. `v` = 0 is its bottom edge, and `v` grows upwards;
/// texel centres lie at half integers. A coordinate that is not finite counts as 0.
#[inline(always)]
pub fn sample_bilinear(texture: &Texture, u: f32, v: f32) -> [f32; 3] {
    let (left, right, fx) = neighbours(u, texture.width());
    let (below, above, fy) = neighbours(v, texture.height());
    let columns = ([left, right], fx);
    mix(row(texture, below, columns), row(texture, above, columns), fy)
}

/// Interpolates between two texels of the row `from_bottom` rows above the lowest.
#[inline(always)]
fn row(texture: &Texture, from_bottom: u32, ([left, right], fx): ([u32; 2], f32)) -> [f32; 3] {
    let y = texture.height() - 1 - from_bottom;
    mix(texture.texel(left, y), texture.texel(right, y), fx)
}

/// Returns the two texels, in a row of `size` texels, on either side of a coordinate, and the
/// weight of the second.
#[inline(always)]
fn neighbours(coordinate: f32, size: u32) -> (u32, u32, f32) {
    let fraction = coordinate - coordinate.floor();
    let x = if fraction.is_finite() { fraction * size as f32 - 0.5 } else { -0.5 };
    let first = x.floor();
    // Left of the first texel's centre, the neighbour is the last texel of the previous repetition.
    let i = if first < 0.0 { size - 1 } else { (first as u32).min(size - 1) };
    let j = if i + 1 == size { 0 } else { i + 1 };
    (i, j, x - first)
}

/// Interpolates linearly from `a` (`t` = 0) to `b` (`t` = 1).
#[inline(always)]
fn mix(a: [f32; 3], b: [f32; 3], t: f32) -> [f32; 3] {
    [a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t, a[2] + (b[2] - a[2]) * t]
}
