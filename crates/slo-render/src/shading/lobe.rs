//! Directions of reflected and refracted rays, perfect and glossy.

use glam::Vec3;

use crate::sampling::warp::cosine_power_lobe;
use slo_accel::math::elementary::power;

/// Mirrors the direction of travel `d` at a surface with unit normal `n`. Source: thesis 2.10.
#[inline(always)]
pub fn reflect(d: Vec3, n: Vec3) -> Vec3 {
    d - 2.0 * d.dot(n) * n
}

/// Refracts the unit direction of travel `d` at a surface. The unit normal `n` faces the ray (`d.n
/// <= 0`), and `eta` is the index of refraction on the incident side divided by the index on the
/// other side. Returns the unit direction, and false in case of total internal reflection.
///
/// Source: thesis 2.13 and 2.14.
#[inline(always)]
pub fn refract(d: Vec3, n: Vec3, eta: f32) -> (Vec3, bool) {
    let cos = -d.dot(n);
    let sin2_t = eta * eta * (1.0 - cos * cos).max(0.0);
    let cos_t = (1.0 - sin2_t).max(0.0).sqrt();
    let t = d * eta + n * (eta * cos - cos_t);
    (t * (1.0 / t.length()), sin2_t <= 1.0)
}

/// Samples a direction of the lobe cos^n about unit `axis` by a point `u` of the unit square.
/// `inverse` is `1 / (n + 1)`; if it is 0, the result is `axis` itself. The density is proportional
/// to the lobe, so the sample has weight 1.
#[inline(always)]
pub fn about(axis: Vec3, inverse: f32, u: [f32; 2]) -> Vec3 {
    let local = cosine_power_lobe(u, inverse);
    let (x, y) = pair(axis);
    let w = x * local.x + y * local.y + axis * local.z;
    if inverse == 0.0 { axis } else { w }
}

/// Returns the `pdf_solid_angle` of unit `w`, on the side of unit normal `side`, for directions
/// sampled with [`about`] and then [`to_side`]; 0 for a perfect lobe.
#[inline(always)]
pub fn density(axis: Vec3, inverse: f32, side: Vec3, w: Vec3) -> f32 {
    let n = 1.0 / inverse - 1.0;
    let mirrored = w - 2.0 * w.dot(side) * side;
    let [here, there] = [axis.dot(w), axis.dot(mirrored)];
    let sum = power(here.max(0.0), n) + power(there.max(0.0), n);
    if inverse > 0.0 { sum * (std::f32::consts::FRAC_1_PI * 0.5) / inverse } else { 0.0 }
}

/// Returns two unit vectors perpendicular to unit `z` and to each other.
///
/// Source: T. Duff et al., "Building an Orthonormal Basis, Revisited" (JCGT 2017).
#[inline(always)]
pub fn pair(z: Vec3) -> (Vec3, Vec3) {
    let sign = if z.z < 0.0 { -1.0 } else { 1.0 };
    let a = -1.0 / (sign + z.z);
    let b = z.x * z.y * a;
    (
        Vec3::new(1.0 + sign * z.x * z.x * a, sign * b, -sign * z.x),
        Vec3::new(b, sign + z.y * z.y * a, -z.y),
    )
}

/// Returns `w` if it is on the side of unit normal `n`, otherwise its mirror image on that side, so
/// that no energy is lost at grazing angles.
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
        let (t, passes) = refract(d, Vec3::Z, 1.0 / 1.5);
        assert!(passes);
        // Snell: sin t = 0.6 / 1.5 = 0.4.
        assert!((t - Vec3::new(0.4, 0.0, -(0.84f32.sqrt()))).length() < 1e-6, "{t}");
    }

    #[test]
    fn beyond_the_critical_angle_everything_is_reflected() {
        // sin critical = 1 / 1.5
        let at = |sin: f32| refract(Vec3::new(sin, 0.0, -(1.0 - sin * sin).sqrt()), Vec3::Z, 1.5);
        assert!(at(0.666).1);
        assert!(!at(0.667).1);
    }

    /// Integrates over the hemisphere: the density integrates to 1, and its mean direction equals
    /// the mean of the sampled directions.
    #[test]
    fn densities_are_those_of_the_directions() {
        let n = 512;
        let points = || (0..n * n).map(|i| [i / n, i % n].map(|k| (k as f32 + 0.5) / n as f32));
        let uniform = |[u, v]: [f32; 2]| {
            let (s, c) = slo_accel::math::elementary::sin_cos_turns(v);
            let r = (1.0 - u * u).sqrt();
            Vec3::new(r * c, r * s, u)
        };
        for (axis, inverse) in [(Vec3::Z, 0.5), (Vec3::new(0.8, 0.0, 0.6), 0.3)] {
            let drawn = points().map(|u| to_side(about(axis, inverse, u), Vec3::Z).as_dvec3());
            let drawn = drawn.sum::<glam::DVec3>() / f64::from(n * n);
            let weigh = |u| {
                let w = uniform(u);
                let p = f64::from(density(axis, inverse, Vec3::Z, w)) * std::f64::consts::TAU;
                (w.as_dvec3() * p).extend(p) / f64::from(n * n)
            };
            let weighed = points().map(weigh).sum::<glam::DVec4>();
            assert!((weighed.w - 1.0).abs() < 1e-3, "{axis} {inverse}: {weighed}");
            assert!((weighed.truncate() - drawn).length() < 1e-3, "{weighed} is not {drawn}");
        }
        assert_eq!(density(Vec3::Z, 0.0, Vec3::Z, Vec3::Z), 0.0);
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
