//! Directions of reflected and refracted rays, perfect and glossy.

use glam::Vec3;

use crate::sampling::warp::cosine_power_lobe;

/// The mirrored direction of travel `d` at a surface of unit normal `n`. Source: thesis 2.10.
#[inline(always)]
pub fn reflect(d: Vec3, n: Vec3) -> Vec3 {
    d - 2.0 * d.dot(n) * n
}

/// The refracted direction of travel, unit, of the unit direction `d` at unit normal `n` that faces
/// it (`d.n <= 0`); `eta` is the index of refraction before the surface over that behind it.
/// `None`: total internal reflection.
///
/// Source: thesis 2.13 and 2.14.
#[inline(always)]
pub fn refract(d: Vec3, n: Vec3, eta: f32) -> Option<Vec3> {
    let cos = -d.dot(n);
    let sin2_t = eta * eta * (1.0 - cos * cos).max(0.0);
    if sin2_t > 1.0 {
        return None;
    }
    Some((d * eta + n * (eta * cos - (1.0 - sin2_t).sqrt())).normalize())
}

/// A direction of the lobe cos^n about unit `axis`, by a point of the unit square; `inverse` is
/// `1 / (n + 1)`, 0 for `axis` itself. Its density is that of the lobe: no weight remains.
#[inline(always)]
pub fn about(axis: Vec3, inverse: f32, u: [f32; 2]) -> Vec3 {
    if inverse == 0.0 {
        return axis;
    }
    let local = cosine_power_lobe(u, inverse);
    let (x, y) = axis.any_orthonormal_pair();
    x * local.x + y * local.y + axis * local.z
}

/// `w` where it is on the side of unit normal `n`, otherwise its mirror image there, so that no
/// energy is lost at grazing angles.
#[inline(always)]
pub fn to_side(w: Vec3, n: Vec3) -> Vec3 {
    let cos = w.dot(n);
    if cos < 0.0 { w - 2.0 * cos * n } else { w }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refraction_bends_toward_the_normal_in_the_denser_medium() {
        let d = Vec3::new(0.6, 0.0, -0.8);
        let t = refract(d, Vec3::Z, 1.0 / 1.5).unwrap();
        // Snell: sin t = 0.6 / 1.5 = 0.4.
        assert!((t - Vec3::new(0.4, 0.0, -(0.84f32.sqrt()))).length() < 1e-6, "{t}");
    }

    #[test]
    fn beyond_the_critical_angle_everything_is_reflected() {
        // sin critical = 1 / 1.5
        let at = |sin: f32| refract(Vec3::new(sin, 0.0, -(1.0 - sin * sin).sqrt()), Vec3::Z, 1.5);
        assert!(at(0.666).is_some());
        assert!(at(0.667).is_none());
    }

    #[test]
    fn lobes_stay_unit_and_on_their_side() {
        let n = Vec3::Z;
        let axis = Vec3::new(0.99, 0.0, 0.141_067).normalize();
        for i in 0..1000 {
            let u = [i as f32 / 1000.0, (i * 37 % 1000) as f32 / 1000.0];
            let w = to_side(about(axis, 0.3, u), n);
            assert!((w.length() - 1.0).abs() < 1e-5 && w.z >= 0.0, "{w}");
        }
        assert_eq!(about(axis, 0.0, [0.3, 0.7]), axis);
    }
}
