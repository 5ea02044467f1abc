//! Normals of surfaces that receive light, packed into a word.

use glam::Vec3;

/// The receiver whose light may come from all directions.
pub const ANY: u32 = u32::MAX;

/// Packs a unit normal: its octahedral map, 16 bits for each coordinate. The word is never [`ANY`].
///
/// Source: Z. Cigolle et al., "A Survey of Efficient Representations for Independent Unit Vectors"
/// (JCGT 2014).
#[inline(always)]
pub fn pack(n: Vec3) -> u32 {
    let scale = 1.0 / (n.x.abs() + n.y.abs() + n.z.abs());
    let (x, y) = (n.x * scale, n.y * scale);
    let folded = [(1.0 - y.abs()).copysign(x), (1.0 - x.abs()).copysign(y)];
    let [x, y] = if n.z < 0.0 { folded } else { [x, y] };
    let word = |x: f32| ((x.clamp(-1.0, 1.0) + 1.0) * 32767.0) as u32;
    word(x) | word(y) << 16
}

/// Returns the unit normal of a word from [`pack`].
#[inline(always)]
pub fn unpack(word: u32) -> Vec3 {
    let number = |bits: u32| bits as f32 * (1.0 / 32767.0) - 1.0;
    let (x, y) = (number(word & 0xffff), number(word >> 16));
    let z = 1.0 - x.abs() - y.abs();
    let fold = (-z).max(0.0);
    let n = Vec3::new(x - fold.copysign(x), y - fold.copysign(y), z);
    n * (1.0 / n.length())
}
