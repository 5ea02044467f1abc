//! Flat pieces of surfaces.

use glam::DVec3;

/// Corners that stand for the rim of a disc.
const DISC_CORNERS: usize = 12;

/// Two unit vectors at right angles to a unit vector and to each other; the three are right-handed.
pub(crate) fn axes_about(normal: DVec3) -> [DVec3; 2] {
    let x = normal.any_orthonormal_vector();
    [x, normal.cross(x)]
}

/// A polygon inside a disc; the normal need not be unit.
pub(super) fn disc(center: DVec3, normal: DVec3, radius: f64) -> [DVec3; DISC_CORNERS] {
    let [x, y] = axes_about(normal.normalize_or_zero());
    std::array::from_fn(|i| {
        let (sin, cos) = libm::sincos(i as f64 * std::f64::consts::TAU / DISC_CORNERS as f64);
        center + (x * cos + y * sin) * radius
    })
}
