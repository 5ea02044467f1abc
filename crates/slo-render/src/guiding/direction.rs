//! Directions as points of the unit square: height, and angle around the z axis. Areas are in
//! proportion to solid angles.

use glam::Vec3;
use slo_accel::math::elementary::{atan2_turns, sin_cos_turns};

/// Steps of each coordinate in a packed direction.
const STEPS: f32 = 65536.0;

/// Packs a unit direction: the height in the high half, the angle in the low half.
#[inline(always)]
pub fn pack(toward: Vec3) -> u32 {
    let step = |x: f32| (x * STEPS).clamp(0.0, STEPS - 1.0) as u32;
    let height = toward.z * 0.5 + 0.5;
    let angle = atan2_turns(toward.y, toward.x) + 0.5;
    step(height) << 16 | step(angle)
}

/// Returns the unit direction of a point of the square.
#[inline(always)]
pub fn direction([height, angle]: [f32; 2]) -> Vec3 {
    let z = height * 2.0 - 1.0;
    let sin = (1.0 - z * z).max(0.0).sqrt();
    let (s, c) = sin_cos_turns(angle - 0.5);
    Vec3::new(sin * c, sin * s, z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_come_back() {
        for i in 0..64 {
            for j in 0..64 {
                let at = [(i as f32 + 0.5) / 64.0, (j as f32 + 0.5) / 64.0];
                let toward = direction(at);
                assert!((toward.length() - 1.0).abs() < 1e-6);
                let packed = pack(toward);
                assert_eq!((packed >> 26, packed >> 10 & 63), (i, j));
            }
        }
        assert_eq!(pack(Vec3::Z) >> 16, 0xffff);
        assert_eq!(pack(-Vec3::Z) >> 16, 0);
    }
}
