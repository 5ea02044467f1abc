//! Normals for lobes that reflect: bent so far that mirror directions lie above the surface.

use glam::Vec3;

/// Bends unit normal `n` toward `n_geo` until the mirror direction of `eye` lies above the surface
/// by a little; leaves it as it is if it does already.
///
/// Let the normal be at angle x to `n_geo`, in the plane of both normals, and let (a, b) be the
/// eye's components along the plane's axes: b along `n_geo`. The mirror direction's height is then
/// a sin 2x + b cos 2x, which grows to its maximum and falls to `least` where 2x is the angle of
/// (a, b) plus acos(least / |(a, b)|). Sums of angles need no function but the root.
#[inline(always)]
pub(super) fn bent(eye: Vec3, n: Vec3, n_geo: Vec3) -> Vec3 {
    let b = eye.dot(n_geo);
    let least = (0.9 * b).min(0.01);
    let height = 2.0 * eye.dot(n) * n.dot(n_geo) - b;
    let aside = n - n_geo * n.dot(n_geo);
    let aside = aside * (1.0 / aside.length().max(1e-20));
    let a = eye.dot(aside);
    let inverse = 1.0 / (a * a + b * b).sqrt().max(1e-20);
    let (sin, cos) = (a * inverse, b * inverse);
    let c = (least * inverse).clamp(-1.0, 1.0);
    let s = (1.0 - c * c).sqrt();
    let (sin, cos) = (sin * c + cos * s, cos * c - sin * s);
    let z = (0.5 * (1.0 + cos)).max(1e-12).sqrt();
    let normal = n_geo * z + aside * (0.5 * sin / z);
    let normal = normal * (1.0 / normal.length().max(1e-20));
    if height < least { normal } else { n }
}

/// Whether [`bent`] leaves a shading normal as it is for an eye in unit direction `way`, which may be on
/// either side of the surface.
#[inline(always)]
pub(super) fn is_kept(way: Vec3, n: Vec3, n_geo: Vec3) -> bool {
    let b = way.dot(n_geo);
    let height = (2.0 * way.dot(n) * n.dot(n_geo) - b) * 1f32.copysign(b);
    height >= (0.9 * b.abs()).min(0.01)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shading::lobe::reflect;

    #[test]
    fn mirror_directions_lie_above_the_surface() {
        let n_geo = Vec3::new(0.48, 0.6, 0.64);
        let mut bends = 0;
        for i in 0..2000u32 {
            let number = |k: u32| {
                let x = f64::from(i * 7919 + k * 104_729) * 0.618_033_988_749_894_9;
                (x % 1.0 * 2.0 - 1.0) as f32
            };
            let upper = |k: u32| {
                let w = Vec3::new(number(k), number(k + 1), number(k + 2));
                let w = w / w.length();
                if w.dot(n_geo) < 0.0 { -w } else { w }
            };
            let (eye, n) = (upper(1), upper(5));
            let to = bent(eye, n, n_geo);
            let height = |n: Vec3| reflect(-eye, n).dot(n_geo);
            let least = (0.9 * eye.dot(n_geo)).min(0.01);
            assert!((to.length() - 1.0).abs() < 1e-5, "{eye} {n}: {to}");
            assert!(height(to) > least - 1e-4, "{eye} {n}: {}", height(to));
            assert!(to.dot(eye) > 0.0);
            assert_eq!(is_kept(eye, n, n_geo), to == n, "{eye} {n}");
            assert_eq!(is_kept(eye, n, n_geo), is_kept(eye, -n, -n_geo), "{eye} {n}");
            if height(n) >= least {
                assert_eq!(to, n);
            } else {
                // No farther than needed, and in the plane of both normals.
                bends += 1;
                assert!(height(to) < least + 1e-4, "{eye} {n}: {}", height(to));
                assert!(to.dot(n.cross(n_geo)).abs() < 1e-4);
                assert!(to.dot(n) >= n_geo.dot(n) - 1e-4);
            }
        }
        assert!(bends > 100);
    }
}
