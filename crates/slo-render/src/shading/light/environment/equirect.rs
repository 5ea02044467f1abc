//! Equirectangular images: directions and places in the image.

use glam::Vec3;

use slo_accel::math::elementary::atan2_turns;
use slo_scene::Texture;

/// Returns the place in the image, in `[0, 1]`, from the left and from the bottom, for a unit
/// direction. The middle of the image is +x, which is turned by `turn` full turns toward +y.
#[inline(always)]
pub(super) fn place(way: Vec3, turn: f32) -> [f32; 2] {
    let u = 0.5 + turn - atan2_turns(way.y, way.x);
    let across = (way.x * way.x + way.y * way.y).sqrt();
    [u - u.floor(), 1.0 - 2.0 * atan2_turns(across, way.z)]
}

/// Returns the image's colour at a [`place`], interpolated bilinearly between four texels. The
/// image continues from its right edge to its left, and ends at its top and its bottom.
#[inline(always)]
pub(super) fn sample_equirect(texture: &Texture, [u, v]: [f32; 2]) -> Vec3 {
    let (width, height) = (texture.width(), texture.height());
    let x = u * width as f32 - 0.5;
    let y = (1.0 - v) * height as f32 - 0.5;
    let (left, above) = (x.floor(), y.floor());
    let (fx, fy) = (x - left, y - above);
    let i = if left < 0.0 { width - 1 } else { (left as u32).min(width - 1) };
    let j = if i + 1 == width { 0 } else { i + 1 };
    let top = above.max(0.0) as u32;
    let below = (above + 1.0).max(0.0) as u32;
    let texel = |x: u32, y: u32| Vec3::from(texture.texel(x, y));
    let row = |y: u32| texel(i, y) * (1.0 - fx) + texel(j, y) * fx;
    row(top) * (1.0 - fy) + row(below) * fy
}
