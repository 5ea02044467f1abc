//! Directions for points of the unit square, and the names of the points.

use glam::DVec3;

use slo_render::sampling::Purpose;

/// Returns a direction about unit `axis` with density proportional to cos^n, n = 1 / spread^2.
///
/// The frame about the axis is Duff's (JCGT 2017): which direction a sample point means depends on
/// it.
pub(super) fn lobe(axis: DVec3, spread: f64, u: [f64; 2]) -> DVec3 {
    if spread == 0.0 {
        return axis;
    }
    let n = 1.0 / (spread * spread);
    let cos = libm::pow(1.0 - u[0], 1.0 / (n + 1.0));
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    let (s, c) = libm::sincos(u[1] * std::f64::consts::TAU);
    let (x, y) = axis.any_orthonormal_pair();
    x * (sin * c) + y * (sin * s) + axis * cos
}

/// Returns the name of the path that continues `path` by a ray for a purpose.
pub(super) fn next_path(path: u32, branch: Purpose) -> u32 {
    let word: u32 = match branch {
        Purpose::Reflection => 2,
        Purpose::Refraction => 3,
        Purpose::Continuation => u32::MAX,
        Purpose::Surface => u32::MAX - 2,
        other => panic!("no path continues by {other:?}"),
    };
    mix(path.wrapping_mul(0x9e37_79b1) ^ mix(word.wrapping_add(0x7f4a_7c15)))
}

/// The bijection of words of Wellons and Ettinger.
fn mix(mut x: u32) -> u32 {
    x ^= x >> 16;
    x = x.wrapping_mul(0x21f0_aaad);
    x ^= x >> 15;
    x = x.wrapping_mul(0x735a_2d97);
    x ^ (x >> 15)
}
