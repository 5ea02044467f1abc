//! Normals of the surfaces that receive light, packed into a word each.
//!
//! A packed normal differs from the normal by less than [`ERROR`]; whoever decides by one must
//! allow for it.

use glam::Vec3;

/// Light counts from wherever it comes: there is no normal.
pub const ANY: u32 = u32::MAX;

/// The largest distance between a unit normal and what comes of packing and unpacking it.
pub const ERROR: f32 = 1e-4;

/// Steps of a coordinate between -1 and 1.
const STEPS: f32 = 65534.0;

/// Packs a unit normal.
///
/// Source: Q. Meyer et al., "On Floating-Point Normal Vectors" (2010): the octahedron, unfolded.
#[inline(always)]
pub fn pack(normal: Vec3) -> u32 {
    let size = normal.x.abs() + normal.y.abs() + normal.z.abs();
    let (x, y) = (normal.x / size, normal.y / size);
    let (fold_x, fold_y) = ((1.0 - y.abs()).copysign(x), (1.0 - x.abs()).copysign(y));
    let is_lower = normal.z < 0.0;
    let (x, y) = if is_lower { (fold_x, fold_y) } else { (x, y) };
    let word = |c: f32| ((c * 0.5 + 0.5).clamp(0.0, 1.0) * STEPS + 0.5) as u32;
    word(x) | word(y) << 16
}

/// Returns the unit normal of a packed one; 0 for [`ANY`].
#[inline(always)]
pub fn unpack(packed: u32) -> Vec3 {
    let coordinate = |word: u32| word as f32 * (2.0 / STEPS) - 1.0;
    let (x, y) = (coordinate(packed & 0xffff), coordinate(packed >> 16));
    let z = 1.0 - x.abs() - y.abs();
    let (fold_x, fold_y) = ((1.0 - y.abs()).copysign(x), (1.0 - x.abs()).copysign(y));
    let v = if z < 0.0 { Vec3::new(fold_x, fold_y, z) } else { Vec3::new(x, y, z) };
    let scale = if packed == ANY { 0.0 } else { 1.0 / v.length() };
    v * scale
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng, rngs::StdRng};

    use super::*;

    #[test]
    fn normals_come_back() {
        let mut rng = StdRng::seed_from_u64(3);
        let mut worst = 0.0f32;
        let axes = [Vec3::X, Vec3::Y, Vec3::Z].into_iter().flat_map(|a| [a, -a]);
        let random = (0..100_000).map(|_| {
            let v = Vec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..1.0)));
            v.normalize_or(Vec3::Z)
        });
        for normal in axes.chain(random) {
            let packed = pack(normal);
            assert_ne!(packed, ANY);
            let back = unpack(packed);
            assert!((back.length() - 1.0).abs() < 1e-6);
            worst = worst.max((back - normal).length());
        }
        assert!(worst < ERROR && worst > ERROR / 4.0, "{worst}");
        assert_eq!(unpack(ANY), Vec3::ZERO);
    }
}
