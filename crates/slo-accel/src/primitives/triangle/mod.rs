//! The triangle test: one arithmetic for every structure, every instruction set, every answer.
//!
//! The ray is sheared so that it runs along an axis; three signed areas then tell on which side of
//! each edge it passes. Corners are taken relative to the ray's origin, so a scene far from the
//! origin of space loses no digits. Each area is a difference of products that is right to 1.5
//! units in the last place, so its sign is right: two triangles that share an edge leave no gap.
//!
//! Source: Woop, Benthin, Wald, *Watertight Ray/Triangle Intersection*, JCGT 2013. Here the areas
//! are summed by Kahan's fused scheme (Jeannerod, Louvet, Muller, *Further analysis of Kahan's
//! algorithm*, Math. Comp. 2013) instead of being recomputed in f64 if they vanish.
//!
//! Every operation is one correctly rounded operation of IEEE 754, fused multiply-add included. A
//! kernel that does the same operations in the same order gives the same bits.

#[cfg_attr(not(target_arch = "x86_64"), allow(dead_code))]
pub(crate) mod lanes;
pub(crate) mod turned;

use glam::{DVec3, Vec3};

/// Three corners. Its points are `(1 - u - v) p0 + u p1 + v p2`.
pub type Triangle = [Vec3; 3];

/// Least size of the sum of the three areas for a hit: below it, underflow may spoil an area.
///
/// Products lose at most 2^-149 each, which is one rounding of this.
pub const MIN_DETERMINANT: f32 = f32::from_bits((127 - 120) << 23);

/// Bound of the distance on each axis between `origin + t direction` of a hit and the point that
/// its weights give, in units of the largest coordinate of a corner relative to the ray's origin.
///
/// It counts roundings: 5 of the sheared corner, 6 of the weights, 4 of t, 3 of the use of t, and
/// as many again for the traversal that relies on it.
pub const POSITION_ERROR: f32 = 32.0 * crate::math::rounding::UNIT_ROUNDOFF;

/// If t is at least this part of the largest distance of a corner along the sheared axis, its sign
/// is certain: weights are right to 2^-22 of the triangle's size over its height, and a triangle a
/// thousand times as long as high still leaves two bits to spare.
const SURE_OF_SIGN: f32 = 1.0 / 4096.0;

/// A ray prepared for the test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShearedRay {
    /// Origin, in the axes of space.
    pub origin: Vec3,
    /// Which axes of space are x, y and z of the sheared one; z is that of the largest direction
    /// component (the first of equals), x and y follow it in cyclic order.
    pub axes: [usize; 3],
    /// `direction.x / direction.z`, `direction.y / direction.z`, `1 / direction.z`, in sheared
    /// axes.
    pub shear: [f32; 3],
}

impl ShearedRay {
    /// Prepares a ray. The direction has any length but 0.
    #[inline(always)]
    pub fn new(origin: Vec3, direction: Vec3) -> Self {
        let z = largest_axis(direction);
        let axes = [(z + 1) % 3, (z + 2) % 3, z];
        let dz = direction[z];
        Self { origin, axes, shear: [direction[axes[0]] / dz, direction[axes[1]] / dz, 1.0 / dz] }
    }

    /// A corner in sheared coordinates; z is not scaled.
    #[inline(always)]
    fn corner(&self, p: Vec3) -> [f32; 3] {
        let [x, y, z] = [self.axes[0], self.axes[1], self.axes[2]];
        let [x, y, z] = [p[x] - self.origin[x], p[y] - self.origin[y], p[z] - self.origin[z]];
        [fused(-self.shear[0], z, x), fused(-self.shear[1], z, y), z]
    }
}

/// A hit of a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleHit {
    /// Distance in lengths of the direction.
    pub t: f32,
    /// Weight of the second corner.
    pub u: f32,
    /// Weight of the third corner.
    pub v: f32,
}

/// The hit with `0 < t < t_max`, on either side of the triangle; edges and corners belong to it.
///
/// The triangle must not be [degenerate](is_degenerate).
#[inline(always)]
pub fn intersect(ray: &ShearedRay, triangle: &Triangle, t_max: f32) -> Option<TriangleHit> {
    let [a, b, c] = [ray.corner(triangle[0]), ray.corner(triangle[1]), ray.corner(triangle[2])];
    let area_a = difference_of_products(c[0], b[1], c[1], b[0]);
    let area_b = difference_of_products(a[0], c[1], a[1], c[0]);
    if (area_a > 0.0 && area_b < 0.0) || (area_a < 0.0 && area_b > 0.0) {
        return None;
    }
    let area_c = difference_of_products(b[0], a[1], b[1], a[0]);
    let positive = area_a >= 0.0 && area_b >= 0.0 && area_c >= 0.0;
    let negative = area_a <= 0.0 && area_b <= 0.0 && area_c <= 0.0;
    let determinant = (area_a + area_b) + area_c;
    if !(positive || negative) || determinant.abs() < MIN_DETERMINANT {
        return None;
    }
    let z = fused(area_c, c[2], fused(area_b, b[2], area_a * a[2]));
    let t = (z / determinant) * ray.shear[2];
    if !(t > 0.0 && t < t_max) {
        return None;
    }
    let reach = a[2].abs().max(b[2].abs()).max(c[2].abs());
    let doubtful = z.abs() <= determinant.abs() * reach * SURE_OF_SIGN;
    (!doubtful || lies_ahead(ray, triangle, determinant < 0.0)).then(|| TriangleHit {
        t,
        u: area_b / determinant,
        v: area_c / determinant,
    })
}

/// Whether a ray that hits a triangle starts before the triangle's plane: not on it, and not
/// behind.
///
/// The t of a hit is off by roundings of the triangle's coordinates along the ray. These are large
/// for a large triangle that the ray grazes: a ray that leaves a floor of 1000 units from a
/// millionth above it could hit that floor again. The sign of the origin's distance from the plane
/// is right in f64, whose roundings are a billionth of those. It is taken from the edges, so that
/// it is right for small triangles far away too. `negative` is the sign of the determinant.
#[cold]
#[inline(never)]
pub(super) fn lies_ahead(ray: &ShearedRay, triangle: &Triangle, negative: bool) -> bool {
    let wide = |p: Vec3| ray.axes.map(|axis| f64::from(p[axis]));
    let difference = |p: [f64; 3], q: [f64; 3]| [p[0] - q[0], p[1] - q[1], p[2] - q[2]];
    let [a, b, c] = triangle.map(wide);
    let (e, f, p) = (difference(b, a), difference(c, a), difference(a, wide(ray.origin)));
    let x = (e[1] * f[2] - e[2] * f[1]) * p[0];
    let y = (e[2] * f[0] - e[0] * f[2]) * p[1];
    let z = (e[0] * f[1] - e[1] * f[0]) * p[2];
    let volume = (x + y) + z;
    volume != 0.0 && (volume < 0.0) ^ negative ^ (ray.shear[2] < 0.0)
}

/// Whether a triangle has no area (its corners lie on a line) or a coordinate that is not finite.
/// Such triangles are never hit; structures leave them out.
pub fn is_degenerate(triangle: &Triangle) -> bool {
    let [a, b, c] = triangle.map(Vec3::as_dvec3);
    let normal = (b - a).cross(c - a);
    normal == DVec3::ZERO || !normal.is_finite()
}

#[inline(always)]
fn largest_axis(direction: Vec3) -> usize {
    let d = direction.abs();
    if d.x >= d.y && d.x >= d.z {
        0
    } else if d.y >= d.z {
        1
    } else {
        2
    }
}

/// `a b - c d` to 1.5 units in the last place: its sign is right.
#[inline(always)]
fn difference_of_products(a: f32, b: f32, c: f32, d: f32) -> f32 {
    let cd = c * d;
    let error = fused(-c, d, cd);
    fused(a, b, -cd) + error
}

/// `a b + c`, rounded once.
// All paths fuse, the scalar one included: no path gives other bits.
#[allow(clippy::disallowed_methods)]
#[inline(always)]
fn fused(a: f32, b: f32, c: f32) -> f32 {
    a.mul_add(b, c)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng, rngs::StdRng};

    const UNIT: Triangle = [Vec3::ZERO, Vec3::X, Vec3::Y];

    fn hit(triangle: &Triangle, origin: Vec3, direction: Vec3) -> Option<TriangleHit> {
        intersect(&ShearedRay::new(origin, direction), triangle, f32::INFINITY)
    }

    #[test]
    fn weights_are_those_of_second_and_third_corner() {
        let expected = Some(TriangleHit { t: 2.0, u: 0.25, v: 0.5 });
        assert_eq!(hit(&UNIT, Vec3::new(0.25, 0.5, 4.0), Vec3::new(0.0, 0.0, -2.0)), expected);
        assert_eq!(hit(&UNIT, Vec3::new(0.25, 0.5, -4.0), Vec3::new(0.0, 0.0, 2.0)), expected);
    }

    #[test]
    fn ends_of_the_ray_are_not_hit() {
        let ray = ShearedRay::new(Vec3::new(0.25, 0.25, 1.0), Vec3::NEG_Z);
        assert!(intersect(&ray, &UNIT, 1.0).is_none());
        assert!(intersect(&ray, &UNIT, 1.0f32.next_up()).is_some());
        assert!(hit(&UNIT, Vec3::new(0.25, 0.25, 0.0), Vec3::NEG_Z).is_none());
        assert!(hit(&UNIT, Vec3::new(0.25, 0.25, -1.0), Vec3::NEG_Z).is_none());
    }

    #[test]
    fn edges_and_corners_are_hit_and_the_plane_is_not() {
        for (x, y) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.5, 0.5), (0.5, 0.0)] {
            assert!(hit(&UNIT, Vec3::new(x, y, 1.0), Vec3::NEG_Z).is_some(), "{x} {y}");
        }
        assert!(hit(&UNIT, Vec3::new(-1.0, 0.25, 0.0), Vec3::X).is_none());
        assert!(hit(&UNIT, Vec3::new(0.7, 0.7, 1.0), Vec3::NEG_Z).is_none());
    }

    #[test]
    fn a_large_triangle_is_not_hit_from_just_before_it() {
        let mut rng = StdRng::seed_from_u64(5);
        let floor = [[-900.0, -900.0], [900.0, -900.0], [900.0, 900.0]];
        for height in [0.0, 1.0, -3.7] {
            let triangle = floor.map(|[x, y]| Vec3::new(x, y, height));
            for _ in 0..20_000 {
                let mut number = |range: std::ops::Range<f32>| rng.random_range(range);
                let (x, y) = (number(-9.0..9.0), number(-9.0..9.0));
                let side = if number(-1.0..1.0) < 0.0 { -1.0 } else { 1.0 };
                let away = Vec3::new(number(-1.0..1.0), number(-1.0..1.0), side * number(0.0..1.0));
                let beside = if side > 0.0 { height.next_up() } else { height.next_down() };
                let origin = Vec3::new(x, y, beside);
                assert_eq!(hit(&triangle, origin, away), None, "{origin} {away}");
            }
        }
    }

    #[test]
    fn flat_to_a_line_is_degenerate() {
        let third = Vec3::new(2.0, 4.0, 6.0);
        assert!(is_degenerate(&[Vec3::ZERO, Vec3::new(1.0, 2.0, 3.0), third]));
        assert!(is_degenerate(&[third, third, Vec3::X]));
        assert!(is_degenerate(&[Vec3::splat(f32::NAN), Vec3::X, Vec3::Y]));
        assert!(!is_degenerate(&UNIT));
        assert!(!is_degenerate(&UNIT.map(|p| p * 1e-30)));
        assert!(!is_degenerate(&UNIT.map(|p| p * 1e30)));
    }

    /// Rays aimed at the middle vertex, the spokes, and the faces of a closed fan, far from the
    /// world's origin: none may pass between two triangles.
    #[test]
    fn fan_has_no_gaps() {
        let mut rng = StdRng::seed_from_u64(7);
        for center in [Vec3::ZERO, Vec3::new(1e3, -2e4, 3e5)] {
            let spokes: [Vec3; 8] = std::array::from_fn(|i| {
                let angle = i as f32 * std::f32::consts::TAU / 8.0;
                center + 100.0 * Vec3::new(libm::cosf(angle), libm::sinf(angle), rng.random())
            });
            for _ in 0..20_000 {
                let i = rng.random_range(0..8);
                let aim = center + rng.random_range(0.0..0.9) * (spokes[i] - center);
                let offset = Vec3::new(rng.random(), rng.random(), 1.0 + rng.random::<f32>());
                let direction = -offset;
                let origin = aim + 50.0 * offset;
                let hits = (0..8).filter(|&j| {
                    hit(&[center, spokes[j], spokes[(j + 1) % 8]], origin, direction).is_some()
                });
                assert!(hits.count() > 0, "gap at spoke {i}: {origin} {direction}");
            }
        }
    }

    /// The error bound that traversals lean on.
    #[test]
    fn hits_lie_on_the_ray_within_the_bound() {
        let mut rng = StdRng::seed_from_u64(3);
        let mut vector = |scale: f32| {
            Vec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..1.0) * scale))
        };
        let mut found = 0;
        while found < 20_000 {
            let (origin, direction) = (vector(3.0), vector(1.0));
            let p = vector(1.0);
            // Nearly edge-on: the ray runs almost in the plane.
            let triangle = [p, p + direction + vector(1e-5), p - direction + vector(1e-3)];
            let origin = p - origin.x * direction + 1e-5 * origin;
            let Some(hit) = hit(&triangle, origin, direction) else { continue };
            found += 1;
            let point = origin.as_dvec3() + f64::from(hit.t) * direction.as_dvec3();
            let [a, b, c] = triangle.map(Vec3::as_dvec3);
            let (u, v) = (f64::from(hit.u), f64::from(hit.v));
            let told = (1.0 - u - v) * a + u * b + v * c;
            let size =
                triangle.iter().map(|&q| (q - origin).abs().max_element()).fold(0.0, f32::max);
            let error = (point - told).abs().max_element();
            assert!(error <= f64::from(POSITION_ERROR * size), "{error} of {size}");
        }
    }
}
