//! Colour of an image at a uv.

use slo_scene::Texture;

/// The image's colour at `(u, v)`, bilinear between the four texels around it.
///
/// The image fills the unit square and repeats; `v` = 0 is its bottom edge and grows upwards;
/// texel centres lie at half integers. A coordinate that is not finite counts as 0.
#[inline(always)]
pub fn sample_bilinear(texture: &Texture, u: f32, v: f32) -> [f32; 3] {
    let (left, right, fx) = neighbours(u, texture.width());
    let (below, above, fy) = neighbours(v, texture.height());
    let columns = ([left, right], fx);
    mix(row(texture, below, columns), row(texture, above, columns), fy)
}

/// Between two texels of the row that many above the lowest one.
#[inline(always)]
fn row(texture: &Texture, from_bottom: u32, ([left, right], fx): ([u32; 2], f32)) -> [f32; 3] {
    let y = texture.height() - 1 - from_bottom;
    mix(texture.texel(left, y), texture.texel(right, y), fx)
}

/// The two texels of a row of `size` that a coordinate lies between, and how far it is from the
/// first to the second.
#[inline(always)]
fn neighbours(coordinate: f32, size: u32) -> (u32, u32, f32) {
    let fraction = coordinate - coordinate.floor();
    let x = if fraction.is_finite() { fraction * size as f32 - 0.5 } else { -0.5 };
    let first = x.floor();
    // -1 at the left edge of the image: the last texel of the repetition before it.
    let i = if first < 0.0 { size - 1 } else { (first as u32).min(size - 1) };
    let j = if i + 1 == size { 0 } else { i + 1 };
    (i, j, x - first)
}

/// From `a` (0) to `b` (1).
#[inline(always)]
fn mix(a: [f32; 3], b: [f32; 3], t: f32) -> [f32; 3] {
    [a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t, a[2] + (b[2] - a[2]) * t]
}
